//! Spots of a cell with dihedral errors: where the light of each order of facets leaves.

use crate::cell::ExactCell;
use crate::optics::Rules;

/// Dihedral errors whose spots are drawn, mrad: equal at all three edges of every cube.
pub(crate) const ERRORS_MRAD: [f64; 3] = [0.0, 0.5, 1.0];

/// Directions that count as one spot, as a part of the dihedral error. The two cubes of a pair differ
/// by 6 times the square of the error, in rad.
const SAME: f64 = 0.02;

/// Directions that count as one spot without an error, mrad.
const ROUNDING_MRAD: f64 = 1e-6;

/// Light that leaves in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Angle from straight back in the plane of incidence, mrad.
    pub across_mrad: f64,
    /// Angle from straight back along v = n x u, mrad.
    pub along_mrad: f64,
    /// Share of the returned light.
    pub share: f64,
}

/// Spots of one dihedral error in one direction of incidence.
#[derive(Debug, Clone, PartialEq)]
pub struct SpotDiagram {
    /// Error of all dihedral angles, added to those of the mesh, mrad.
    pub error_mrad: f64,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// The spots, the brightest first; empty if nothing returns.
    pub spots: Vec<Spot>,
}

impl SpotDiagram {
    /// Finds the spots of a cell whose dihedral angles have an error already.
    pub(crate) fn new(
        exact: &ExactCell,
        rules: &Rules,
        error_mrad: f64,
        [incidence_deg, azimuth_deg]: [f64; 2],
    ) -> SpotDiagram {
        let found = exact.direction(incidence_deg, azimuth_deg, 1, 2.0, rules);
        let total: f64 = found.paths.iter().map(|p| p.weight * p.area()).sum();
        let mut spots: Vec<Spot> = Vec::new();
        for path in &found.paths {
            let [across_mrad, along_mrad] = path.deviation.map(|tangent| 1e3 * tangent);
            let share = path.weight * path.area() / total;
            let same = |spot: &&mut Spot| {
                let apart = (spot.across_mrad - across_mrad).hypot(spot.along_mrad - along_mrad);
                apart < SAME * error_mrad + ROUNDING_MRAD
            };
            match spots.iter_mut().find(same) {
                Some(spot) => {
                    let part = share / (spot.share + share);
                    spot.across_mrad += part * (across_mrad - spot.across_mrad);
                    spot.along_mrad += part * (along_mrad - spot.along_mrad);
                    spot.share += share;
                }
                None => spots.push(Spot {
                    across_mrad,
                    along_mrad,
                    share,
                }),
            }
        }
        spots.sort_by(|a, b| b.share.total_cmp(&a.share));
        SpotDiagram {
            error_mrad,
            incidence_deg,
            spots,
        }
    }

    /// Returns the largest angle of a spot from straight back, mrad; 0 without light.
    pub fn largest_mrad(&self) -> f64 {
        let radius = |spot: &Spot| spot.across_mrad.hypot(spot.along_mrad);
        self.spots.iter().map(radius).fold(0.0, f64::max)
    }
}
