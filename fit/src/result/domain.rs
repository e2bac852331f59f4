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
    pub azimuth_deg: Option<[f64; 2]>,
}

impl Domain {
    /// Returns the domain of the photographs of a scene.
    pub(crate) fn of(scene: &Scene) -> Domain {
        let shots = &scene.shots;
        let azimuths: Option<Vec<f64>> = shots.iter().map(|s| s.facing.azimuth_deg).collect();
        Domain {
            floating_distance_mm: range(shots.iter().map(|shot| shot.r_mm)),
            incidence_deg: range(shots.iter().map(|shot| shot.incidence_deg)),
            azimuth_deg: azimuths.map(|all| range(all.into_iter())),
        }
    }
}

/// Returns the least and the greatest value.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}
