//! Whether a table of rays says where the light goes, and how finely.
//!
//! Ideal cubes send all light straight back, and nothing is recorded. That is decided by the mesh
//! and the options alone, never by rays, so that shards and ranks agree.

use crate::cell::Prepared;
use crate::optics::reach_rad;
use crate::plan::plan::Plan;
use crate::plan::scene::no_planes;
use glam::DVec3;
use tables::deviation::Grid;
use tables::options::{Element, Record, SceneOptions};

/// Facets nearer than this to a right angle are at one, rad: coordinates of six digits are no
/// better. The light of such a cube is within 2e-5 rad of straight back, 5 um at a distance of 300
/// mm.
const RIGHT: f64 = 5e-6;

/// Planes of one body above which it stands for a curved one; and so it does with that many pairs
/// that are nearly, not quite, at right angles.
const MOST_PLANES: usize = 2048;
const MOST_PAIRS: usize = 1024;

/// Bins along each axis where light goes in a few directions: only those are stored, so that they
/// may be fine. Odd, so that straight back is in the middle of one.
const BINS_OF_SPOTS: usize = 4095;

/// The same where it goes everywhere, and cells of shifts at most.
const BINS_OF_LOBES: usize = 127;
const CELLS_OF_LOBES: usize = 16;

/// Where the light of a cell goes that counts as retroreflected.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ExitPattern {
    /// Straight back.
    Straight,
    /// In some directions, turned by at most this angle inside, rad.
    Spots(f64),
    /// Anywhere, turned by at most this angle, rad.
    Lobe(f64),
}

impl Plan {
    /// How the exit directions of rays through a cell are recorded; `None` where they are not.
    pub(crate) fn deviations(&self, prepared: &Prepared) -> Option<Grid> {
        let exits = self.exits(prepared);
        let turn = match (self.scene.deviations, exits) {
            (Record::Off, _) | (Record::Auto, ExitPattern::Straight) => return None,
            (_, ExitPattern::Straight) => self.angular_tolerance_deg.to_radians(),
            (_, ExitPattern::Spots(turn) | ExitPattern::Lobe(turn)) => turn,
        };
        // Snell's law widens a small angle by the index, and within the plane of incidence by up to
        // twice that to 60 degrees.
        let range = match self.scene.deviations {
            Record::Within(mrad) => 1e-3 * mrad,
            _ => 2.0 * self.index_of(prepared.cell()) * turn,
        };
        let bins = self.axes.bins;
        let (cells, bins) = match exits {
            ExitPattern::Lobe(_) => (pools(bins), BINS_OF_LOBES),
            ExitPattern::Straight | ExitPattern::Spots(_) => (bins, BINS_OF_SPOTS),
        };
        Some(Grid { cells, bins, range })
    }

    /// What sends light elsewhere than straight back, in one place.
    fn exits(&self, prepared: &Prepared) -> ExitPattern {
        let tolerance = self.angular_tolerance_deg.to_radians();
        let smooth = SceneOptions {
            roughness: None,
            ..self.scene
        };
        if no_planes(&smooth).is_some() {
            return ExitPattern::Lobe(tolerance);
        }
        // A plate's mirrors are at right angles to it, too.
        let upright = (self.scene.element == Element::Plate).then_some(DVec3::Z);
        let angle_error = |facets: &[[DVec3; 3]]| angle_error(facets, upright, tolerance);
        let error = match prepared.kinds() {
            Ok(kinds) => {
                let mut errors = kinds.iter().map(|kind| angle_error(&kind.facets));
                errors.try_fold(0.0, |largest: f64, error| {
                    error.map(|error| largest.max(error))
                })
            }
            Err(_) => angle_error(&prepared.cell().facets),
        };
        // Three mirrors that are off by a, b and c turn light by 2 sqrt(a^2 + b^2 + c^2) at most,
        // first order.
        let turn = |error: f64| 2.0 * 3_f64.sqrt() * error;
        match (error, self.scene.roughness) {
            (None, _) => ExitPattern::Lobe(tolerance),
            (Some(error), Some(roughness)) => {
                ExitPattern::Lobe(tolerance.min(turn(error) + reach_rad(&roughness)))
            }
            (Some(error), None) if error <= RIGHT => ExitPattern::Straight,
            (Some(error), None) => ExitPattern::Spots(tolerance.min(turn(error))),
        }
    }
}

/// The largest error of the right angles of a body, rad: how far two planes that could be faces of
/// a corner, within the tolerance, are from one; `upright` is the normal of one plane more. `None`
/// of a body that stands for a curved one.
fn angle_error(facets: &[[DVec3; 3]], upright: Option<DVec3>, tolerance: f64) -> Option<f64> {
    let mut normals = Vec::from_iter(upright);
    for [a, b, c] in facets {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        // Triangles of one plane, in coordinates of six digits.
        let known = |own: &DVec3| (*own - normal).length() <= RIGHT;
        if !normals.iter().any(known) {
            normals.push(normal);
        }
        if normals.len() > MOST_PLANES {
            return None;
        }
    }
    let pairs = (0..normals.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let errors = pairs.map(|(i, j)| normals[i].dot(normals[j]).abs().asin());
    let errors: Vec<f64> = errors.filter(|&error| error <= tolerance).collect();
    let off = errors.iter().filter(|&&error| error > RIGHT).count();
    (off <= MOST_PAIRS).then(|| errors.into_iter().fold(0.0, f64::max))
}

/// The greatest divisor of `bins` that is at most [`CELLS_OF_LOBES`].
fn pools(bins: usize) -> usize {
    let divides = |n: &usize| bins.is_multiple_of(*n);
    (1..=CELLS_OF_LOBES).rev().find(divides).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pools_divide_the_bins() {
        assert_eq!([1, 7, 34, 96, 128].map(pools), [1, 7, 2, 16, 16]);
    }

    /// Two facets at 90 degrees and 0.3 mrad, and a third at right angles to both.
    #[test]
    fn errors_of_right_angles() {
        let error = 3e-4_f64;
        let b = DVec3::new(-error.sin(), error.cos(), 0.0);
        let facets = [
            [DVec3::ZERO, DVec3::X, b],
            [DVec3::ZERO, b, DVec3::Z],
            [DVec3::ZERO, DVec3::Z, DVec3::X],
        ];
        let found = angle_error(&facets, None, 0.01).expect("three planes");
        // The sine's argument is rounded to an ulp of 1.
        assert!((found - error).abs() < 1e-15, "{found}");
        assert_eq!(
            angle_error(&facets, None, 1e-4),
            Some(0.0),
            "no corner's face within that"
        );
    }
}
