//! Distances and directions at which the photographs of an estimate were taken.

use serde::{Deserialize, Serialize};

use crate::estimate::Scene;

/// Least and greatest value of each quantity over the photographs of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Domain {
    /// Distance R: optical path from the sheet to the image, mm.
    pub floating_distance_mm: [f64; 2],
    /// Incidence, degrees.
    pub incidence_deg: [f64; 2],
    /// Azimuth, degrees; null for a mean table.
    ///
    /// It is the shortest arc that holds all azimuths, as the symmetry of the cell repeats them.
    /// It begins at one of them and may end beyond 360.
    pub azimuth_deg: Option<[f64; 2]>,
}

impl Domain {
    /// Returns the domain of the photographs of a scene whose cell repeats itself after the azimuth
    /// `period_deg`.
    pub fn of(scene: &Scene, period_deg: f64) -> Domain {
        let shots = &scene.shots;
        let azimuths: Option<Vec<f64>> = shots.iter().map(|s| s.direction.azimuth_deg).collect();
        Domain {
            floating_distance_mm: range(shots.iter().map(|shot| shot.r_mm)),
            incidence_deg: range(shots.iter().map(|shot| shot.incidence_deg)),
            azimuth_deg: azimuths.map(|all| arc(&all, period_deg)),
        }
    }
}

/// Returns the least and the greatest value.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}

/// Returns the ends of the shortest arc that holds all azimuths, degrees.
fn arc(azimuths_deg: &[f64], period_deg: f64) -> [f64; 2] {
    /// Difference of two azimuths that count as equal, degrees.
    const SAME_DEG: f64 = 1e-9;
    let plain = range(azimuths_deg.iter().copied());
    let reduced = azimuths_deg
        .iter()
        .map(|own| (own.rem_euclid(period_deg), *own));
    let mut around: Vec<(f64, f64)> = reduced.collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Each azimuth, as the first of the arc, with the gap before it.
    let before = |k: usize| match k {
        0 => around[around.len() - 1].0 - period_deg,
        _ => around[k - 1].0,
    };
    let gaps = around
        .iter()
        .enumerate()
        .map(|(k, (own, first))| (own - before(k), *first));
    let widest = gaps.max_by(|a, b| a.0.total_cmp(&b.0));
    match widest.map(|(gap, first)| (period_deg - gap, first)) {
        Some((span, first)) if span < plain[1] - plain[0] - SAME_DEG => {
            [first, first + span.max(0.0)]
        }
        _ => plain,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_go_the_short_way_round() {
        let cases: [(&[f64], f64, [f64; 2]); 9] = [
            (&[20.0], 360.0, [20.0, 20.0]),
            (&[0.0, 30.0, 10.0], 360.0, [0.0, 30.0]),
            (&[350.0, 10.0], 360.0, [350.0, 370.0]),
            (&[-10.0, 10.0], 360.0, [-10.0, 10.0]),
            (&[5.0, 340.0, 355.0], 360.0, [340.0, 365.0]),
            // A pair repeats itself after 60 degrees: 65 is 5, and 50 lies 15 before it.
            (&[65.0, 50.0], 60.0, [50.0, 65.0]),
            (&[5.0, 50.0], 60.0, [50.0, 65.0]),
            (&[20.0, 80.0, 140.0], 60.0, [20.0, 20.0]),
            (&[0.0, 90.0, 180.0, 270.0], 360.0, [0.0, 270.0]),
        ];
        for (azimuths, period, expected) in cases {
            let found = arc(azimuths, period);
            let off = (0..2)
                .map(|k| (found[k] - expected[k]).abs())
                .fold(0.0, f64::max);
            // Sums of numbers below 720.
            assert!(off < 1e-12, "{azimuths:?}: {found:?}");
        }
    }
}
