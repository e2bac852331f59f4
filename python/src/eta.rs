//! The returned share at many directions, without the histograms and paths of each.

use rayon::prelude::*;
use tables::{Error, Family, Table, polygon};

/// Greatest difference of two angles that count as equal, degrees.
const SAME_DEG: f64 = 1e-9;

/// Half width by which the bounds of a polygon are widened for rounding, edge lengths.
const SLACK: f64 = 1e-6;

/// Directions that one thread takes at a time.
const CHUNK: usize = 512;

/// Place on an axis: the interval, whether the place is its lower end, and the share of the upper
/// end.
type Interval = (usize, bool, f64);

/// Returns eta at directions (incidence, azimuth), degrees: that of [`Table::direction`].
///
/// # Errors
/// Returns the error of the first direction that lies outside of the table.
pub(crate) fn at(table: &Table, directions: &[[f64; 2]]) -> Result<Vec<f64>, Error> {
    let mut azimuths: Vec<f64> = table.azimuths().iter().map(|one| one.0).collect();
    azimuths.push(azimuths[0] + 360.0);
    let chunks = directions.par_chunks(CHUNK).map(|chunk| {
        let mut gap = Gap::default();
        chunk
            .iter()
            .map(|&direction| gap.eta(table, &azimuths, direction))
            .collect::<Result<Vec<f64>, Error>>()
    });
    Ok(chunks.collect::<Result<Vec<_>, _>>()?.concat())
}

/// What the interpolation knows of the gap that was asked for last.
#[derive(Default)]
struct Gap {
    key: Option<[(usize, bool); 2]>,
    families: Option<Vec<Family>>,
}

impl Gap {
    fn eta(
        &mut self,
        table: &Table,
        azimuths: &[f64],
        [incidence_deg, azimuth_deg]: [f64; 2],
    ) -> Result<f64, Error> {
        let slowly = || {
            let azimuth = (!table.axes.is_mean()).then_some(azimuth_deg);
            let found = table.direction(incidence_deg, azimuth)?;
            Ok(found.retroreflected)
        };
        let Some(exact) = table.exact.as_ref().filter(|_| !table.axes.is_mean()) else {
            return slowly();
        };
        let along = interval(&table.axes.incidence_deg, incidence_deg);
        let turned = azimuth_deg.rem_euclid(360.0);
        let before = turned < azimuths[0] - SAME_DEG;
        let across = interval(azimuths, if before { turned + 360.0 } else { turned });
        let (Some(along), Some(across)) = (along, across) else {
            return slowly();
        };
        if along.1 && across.1 {
            return slowly();
        }
        let key = [along, across].map(|(place, on, _)| (place, on));
        if self.key != Some(key) {
            // It refuses polygons that are too many.
            slowly()?;
            self.families = table.families(incidence_deg, azimuth_deg);
            self.key = Some(key);
        }
        let Some(families) = &self.families else {
            return slowly();
        };
        let index = table.provenance.refractive_index;
        let sine = incidence_deg.to_radians().sin() / index;
        let tangent = sine / (1.0 - sine * sine).sqrt();
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        let tau = [tangent * cos, tangent * sin];
        let light = families
            .iter()
            .map(|family| light(family, tau, [along, across]));
        Ok((light.sum::<f64>() / exact.entrance_area).min(1.0))
    }
}

/// Returns the light of a path at a direction: area of its polygon times its weight.
fn light(family: &Family, tau: [f64; 2], place: [Interval; 2]) -> f64 {
    let moved = family
        .members
        .iter()
        .map(|([x, y], _)| (x - tau[0]).hypot(y - tau[1]));
    let margin = Family::FASTEST * moved.fold(f64::INFINITY, f64::min) + SLACK;
    let [[left, low], [right, high]] = family.bounds;
    let (left, right) = (left - margin, right + margin);
    let (low, high) = (low - margin, high + margin);
    let (lines, numbers) = family.at(tau);
    let mut outline = vec![[left, low], [right, low], [right, high], [left, high]];
    for [x, y, offset] in lines {
        let beyond = |p: [f64; 2]| x * p[0] + y * p[1] - offset;
        let on = |p: [f64; 2], q: [f64; 2], part: f64| [0, 1].map(|k| p[k] + part * (q[k] - p[k]));
        outline = polygon::clip(&outline, beyond, on);
        if outline.is_empty() {
            return 0.0;
        }
    }
    // A direction lacks the path by a jump: its share of the gap has none of the light.
    let share = |corner: [f64; 2]| -> f64 {
        let parts = [0, 1].map(|axis| {
            let (_, on, part) = place[axis];
            match (on, corner[axis] > 0.5) {
                (true, _) => 1.0,
                (false, true) => part,
                (false, false) => 1.0 - part,
            }
        });
        parts[0] * parts[1]
    };
    let absent: f64 = family.jumps.iter().map(|&corner| share(corner)).sum();
    polygon::area(&outline) * numbers[6].clamp(0.0, 1.0) * (1.0 - absent).max(0.0)
}

/// Returns the interval of an ascending axis that holds `x`, or `None` outside of it.
fn interval(axis: &[f64], x: f64) -> Option<Interval> {
    let above = axis.partition_point(|&one| one <= x + SAME_DEG);
    let low = above.checked_sub(1)?;
    if (x - axis[low]).abs() <= SAME_DEG {
        return Some((low, true, 0.0));
    }
    let high = axis.get(above)?;
    Some((low, false, (x - axis[low]) / (high - axis[low])))
}
