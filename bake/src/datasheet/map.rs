//! Eta over incidence and azimuth, and the angles at which it has fallen to half.

use crate::cell::ExactCell;
use crate::optics::Rules;
use ndarray::Array2;
use rayon::prelude::*;
use tables::Symmetry;

/// Halvings of a step of incidence in the search for half eta: 15 degrees become 1.4e-8 degrees.
const HALVINGS: u32 = 30;

/// Largest distance of two azimuths that count as equal, degrees.
const SAME_DEG: f64 = 1e-9;

/// Retroreflected share eta over incidence and azimuth.
#[derive(Debug, Clone, PartialEq)]
pub struct EtaMap {
    /// Incidences in the air, degrees, ascending from 0.
    pub incidence_deg: Vec<f64>,
    /// Azimuths, degrees, evenly spaced from 0 to below 360.
    pub azimuth_deg: Vec<f64>,
    /// Eta `[incidence, azimuth]`.
    pub eta: Array2<f64>,
    /// Smallest incidence at which eta is below half of its value at normal incidence, degrees, for
    /// each azimuth; `None` if it stays above up to the last incidence.
    ///
    /// A fall and rise within one step of incidence is not seen.
    pub half_deg: Vec<Option<f64>>,
}

/// Returns eta in one direction, degrees.
pub(crate) fn eta(exact: &ExactCell, rules: &Rules, incidence_deg: f64, azimuth_deg: f64) -> f64 {
    let share = exact.direction(incidence_deg, azimuth_deg, 1, 2.0, rules);
    share.retroreflected
}

impl EtaMap {
    /// Computes the map in steps of `step_deg` up to `up_to_deg`, degrees.
    ///
    /// Of a symmetric cell only a sector of azimuths is computed, which stands for the rest. `done`
    /// is called after each azimuth, from any thread, with the number of azimuths that it stands
    /// for.
    pub(crate) fn new(
        exact: &ExactCell,
        rules: &Rules,
        symmetry: Symmetry,
        [step_deg, up_to_deg]: [f64; 2],
        done: &(impl Fn(usize) + Sync),
    ) -> EtaMap {
        let (incidence_deg, azimuth_deg) = axes(step_deg, up_to_deg);
        let mut own: Vec<f64> = Vec::new();
        let mut places = Vec::new();
        for &azimuth in &azimuth_deg {
            let azimuth = representative(symmetry, azimuth);
            let known = own.iter().position(|at| (at - azimuth).abs() < SAME_DEG);
            places.push(known.unwrap_or(own.len()));
            if known.is_none() {
                own.push(azimuth);
            }
        }
        let column = |(k, &azimuth): (usize, &f64)| {
            let at = |incidence: f64| eta(exact, rules, incidence, azimuth);
            let column: Vec<f64> = incidence_deg.iter().map(|&deg| at(deg)).collect();
            let half = half(&incidence_deg, &column, at);
            done(places.iter().filter(|&&place| place == k).count());
            (column, half)
        };
        let columns: Vec<(Vec<f64>, Option<f64>)> =
            own.par_iter().enumerate().map(column).collect();
        let shape = (incidence_deg.len(), azimuth_deg.len());
        EtaMap {
            eta: Array2::from_shape_fn(shape, |(i, a)| columns[places[a]].0[i]),
            half_deg: places.iter().map(|&place| columns[place].1).collect(),
            incidence_deg,
            azimuth_deg,
        }
    }

    /// Returns the mean of eta over all azimuths of the map at each incidence.
    pub fn means(&self) -> Vec<f64> {
        let rows = self.eta.rows().into_iter();
        rows.map(|row| row.sum() / row.len() as f64).collect()
    }

    /// Returns the least and the largest angle of half eta over the azimuths, degrees.
    ///
    /// An end is `None` if eta does not fall to half: the largest if it does not at some azimuth,
    /// the least if it does at none.
    pub fn half_range_deg(&self) -> [Option<f64>; 2] {
        let found = || self.half_deg.iter().flatten().copied();
        let all = self.half_deg.iter().all(Option::is_some);
        [
            found().min_by(f64::total_cmp),
            found().max_by(f64::total_cmp).filter(|_| all),
        ]
    }

    /// Returns eta between the directions of the map, bilinear, at an incidence within it, degrees.
    pub(crate) fn at(&self, incidence_deg: f64, azimuth_deg: f64) -> f64 {
        let count = self.azimuth_deg.len();
        let last = self.incidence_deg.len() - 1;
        let row = self
            .incidence_deg
            .partition_point(|&deg| deg <= incidence_deg);
        let row = row.clamp(1, last.max(1)) - 1;
        let next = (row + 1).min(last);
        let width = self.incidence_deg[next] - self.incidence_deg[row];
        let down = match width > 0.0 {
            true => ((incidence_deg - self.incidence_deg[row]) / width).clamp(0.0, 1.0),
            false => 0.0,
        };
        let place = azimuth_deg.rem_euclid(360.0) / 360.0 * count as f64;
        let (left, across) = (place as usize % count, place.fract());
        let along = |row: usize| {
            let ends = [left, (left + 1) % count].map(|a| self.eta[[row, a]]);
            ends[0] + across * (ends[1] - ends[0])
        };
        along(row) + down * (along(next) - along(row))
    }

    /// Returns another quantity of the same directions, without angles of half eta.
    pub(crate) fn with(&self, eta: Array2<f64>) -> EtaMap {
        EtaMap {
            eta,
            half_deg: vec![None; self.azimuth_deg.len()],
            ..self.clone()
        }
    }
}

/// Returns the incidences and azimuths of a map, degrees; the last incidence is `up_to_deg`.
fn axes(step_deg: f64, up_to_deg: f64) -> (Vec<f64>, Vec<f64>) {
    // Half a thousandth of a step allows for the rounding of steps such as 2.3.
    let steps = (up_to_deg / step_deg - 5e-4).ceil().max(1.0) as u32;
    let incidence = (0..=steps).map(|k| (f64::from(k) * step_deg).min(up_to_deg));
    let around = (360.0 / step_deg).round().max(4.0) as u32;
    let azimuth = (0..around).map(|k| 360.0 * f64::from(k) / f64::from(around));
    (incidence.collect(), azimuth.collect())
}

/// Returns the azimuth in the sector of a symmetry that has the eta of `azimuth_deg`.
fn representative(symmetry: Symmetry, azimuth_deg: f64) -> f64 {
    let (first, _) = symmetry.sector_deg();
    // An azimuth that rounding puts just before the sector lies at its beginning.
    let into = |image: f64| {
        let into = (image - first).rem_euclid(360.0);
        if into > 360.0 - SAME_DEG { 0.0 } else { into }
    };
    let images = symmetry.images(azimuth_deg).map(|(image, _)| into(image));
    first + images.fold(f64::INFINITY, f64::min)
}

/// Returns the smallest incidence at which eta is below half of its first value, by bisection.
fn half(incidence_deg: &[f64], column: &[f64], at: impl Fn(f64) -> f64) -> Option<f64> {
    let target = 0.5 * column[0];
    let below = column.iter().position(|&eta| eta < target)?;
    let [mut low, mut high] = [below - 1, below].map(|k| incidence_deg[k]);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match at(middle) < target {
            true => high = middle,
            false => low = middle,
        }
    }
    Some(0.5 * (low + high))
}
