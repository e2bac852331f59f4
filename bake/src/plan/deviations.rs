//! Decides whether a table of rays records the directions in which light leaves, and in which bins.
//!
//! Ideal cubes send all light straight back, so nothing is recorded for them. The mesh and the
//! options alone decide this, never the rays, so that all shards and ranks agree.

use crate::cell::Prepared;
use crate::optics::reach_rad;
use crate::plan::losses::no_planes;
use crate::plan::plan::Plan;
use glam::DVec3;
use tables::deviation::Grid;
use tables::options::{Element, Front, Record, SceneOptions};

/// Largest error of an angle that counts as a right angle, rad.
///
/// Coordinates of six digits are no more accurate. The light of such a cube is within 2e-5 rad of
/// straight back, which is 5 um at a distance of 300 mm.
const RIGHT: f64 = 5e-6;

/// Largest number of planes of a body with plane facets; a body with more stands for a curved one.
const MOST_PLANES: usize = 2048;

/// Largest number of nearly right angles of a body with plane facets.
///
/// The error of such an angle is above [`RIGHT`]. A body with more of them stands for a curved one.
const MOST_PAIRS: usize = 1024;

/// Cosine of the angle (20 deg) within which normals are those of one curved face.
const SAME_FACE_COS: f64 = 0.94;

/// Largest number of curved faces of a cell whose light is bounded by their slopes.
const MOST_FACES: usize = 64;

/// Number of bins along each axis where light leaves in a few directions.
///
/// Only the bins that rays meet are stored, so the bins may be fine. The number is odd, so that
/// straight back is the middle of a bin.
const BINS_OF_SPOTS: usize = 4095;

/// Number of bins along each axis where light leaves in all directions.
const BINS_OF_LOBES: usize = 127;

/// Largest number of cells of shifts along each axis where light leaves in all directions.
const CELLS_OF_LOBES: usize = 16;

/// Directions in which the retroreflected light of a cell leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ExitPattern {
    /// Exactly straight back.
    Straight,
    /// A few directions, turned from straight back by at most this angle inside the cell, rad.
    Spots(f64),
    /// All directions that are turned from straight back by at most this angle, rad.
    Lobe(f64),
}

impl Plan {
    /// Returns the grid that exit directions of rays through the cell are recorded on, or `None` if
    /// they are not recorded.
    pub(crate) fn deviations(&self, prepared: &Prepared) -> Option<Grid> {
        let exits = self.exits(prepared);
        let turn = match (self.scene.deviations, exits) {
            (Record::Off, _) | (Record::Auto, ExitPattern::Straight) => return None,
            (_, ExitPattern::Straight) => self.angular_tolerance_deg.to_radians(),
            (_, ExitPattern::Spots(turn) | ExitPattern::Lobe(turn)) => turn,
        };
        // At the front face, refraction widens a small angle by the refractive index. In the plane
        // of incidence it widens the angle by up to twice the index, for incidences up to 60
        // degrees.
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

    /// Finds the directions in which the retroreflected light of the cell leaves.
    fn exits(&self, prepared: &Prepared) -> ExitPattern {
        let tolerance = self.angular_tolerance_deg.to_radians();
        let smooth = SceneOptions {
            roughness: None,
            ..self.scene
        };
        let rough = self.scene.roughness.as_ref().map_or(0.0, reach_rad);
        // Glass sends light in a cone, and light that a front face traps meets many mirrors.
        let three = self.scene.glass_index.is_none() && self.scene.front == Front::Once;
        let curved = || match curved_turn(prepared.cell(), tolerance).filter(|_| three) {
            Some(turn) => ExitPattern::Lobe(tolerance.min(turn + rough)),
            None => ExitPattern::Lobe(tolerance),
        };
        if no_planes(&smooth).is_some() {
            return curved();
        }
        // The mirrors of a plate stand at right angles to the plate too.
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
        match (error, self.scene.roughness) {
            (None, _) => curved(),
            (Some(error), Some(_)) => ExitPattern::Lobe(tolerance.min(turn(error) + rough)),
            (Some(error), None) if error <= RIGHT => ExitPattern::Straight,
            (Some(error), None) => ExitPattern::Spots(tolerance.min(turn(error))),
        }
    }
}

/// Returns the largest angle by which three mirrors turn light from straight back if their angles
/// are wrong by at most `error`, to first order: 2 sqrt(a^2 + b^2 + c^2) for the errors a, b and c.
fn turn(error: f64) -> f64 {
    2.0 * 3_f64.sqrt() * error
}

/// Returns a bound of the angle by which three curved faces of the cell turn light from straight
/// back, rad, or `None` if its normals are those of too many faces.
///
/// A face is all normals that lie around one direction. Each of three reflections turns light by
/// twice the angle between the normal there and the face's mean, and the means turn it as the
/// normals of planes do.
fn curved_turn(cell: &meshes::Cell, tolerance: f64) -> Option<f64> {
    let normals: Vec<DVec3> = match &cell.normals {
        Some(found) => {
            let numbers = found.corners.iter().flatten();
            numbers
                .map(|&number| found.vectors[number as usize])
                .collect()
        }
        None => cell.facets.iter().map(facet_normal).collect(),
    };
    let own = |known: &[(DVec3, DVec3)], normal: DVec3| {
        known
            .iter()
            .position(|(first, _)| first.dot(normal) > SAME_FACE_COS)
    };
    let mut faces: Vec<(DVec3, DVec3)> = Vec::new();
    for &normal in &normals {
        match own(&faces, normal) {
            Some(face) => faces[face].1 += normal,
            None if faces.len() == MOST_FACES => return None,
            None => faces.push((normal, normal)),
        }
    }
    let means: Vec<DVec3> = faces
        .iter()
        .map(|(_, sum)| sum.normalize_or_zero())
        .collect();
    let slope = |&normal: &DVec3| {
        own(&faces, normal).map_or(0.0, |face| {
            means[face].cross(normal).length().min(1.0).asin()
        })
    };
    let slope = normals.iter().map(slope).fold(0.0, f64::max);
    let error = right_angle_errors(&means, tolerance).fold(0.0, f64::max);
    Some(6.0 * slope + turn(error))
}

/// Returns the errors of the angles between planes with these normals that are right angles within
/// `tolerance`, rad.
fn right_angle_errors(normals: &[DVec3], tolerance: f64) -> impl Iterator<Item = f64> {
    let pairs = (0..normals.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let errors = pairs.map(|(i, j)| normals[i].dot(normals[j]).abs().asin());
    errors.filter(move |&error| error <= tolerance)
}

/// Returns the unit normal of a facet; zero without area.
fn facet_normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Returns the largest error of the right angles of a body, rad, or `None` if the body stands for a
/// curved one.
///
/// The error of two planes is the difference between their angle and 90 degrees. Two planes with an
/// error above `tolerance`, rad, are not faces of one corner and do not count. `upright` is the
/// normal of one further plane.
fn angle_error(facets: &[[DVec3; 3]], upright: Option<DVec3>, tolerance: f64) -> Option<f64> {
    let mut normals = Vec::from_iter(upright);
    for facet in facets {
        let normal = facet_normal(facet);
        // Two triangles of one plane may differ by this much in coordinates of six digits.
        let known = |own: &DVec3| (*own - normal).length() <= RIGHT;
        if !normals.iter().any(known) {
            normals.push(normal);
        }
        if normals.len() > MOST_PLANES {
            return None;
        }
    }
    let errors: Vec<f64> = right_angle_errors(&normals, tolerance).collect();
    let off = errors.iter().filter(|&&error| error > RIGHT).count();
    (off <= MOST_PAIRS).then(|| errors.into_iter().fold(0.0, f64::max))
}

/// Returns the greatest divisor of `bins` that is at most [`CELLS_OF_LOBES`].
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

    /// Checks two facets at 90 degrees and 0.3 mrad, and a third at right angles to both.
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
        // The argument of the sine is rounded to an ulp of 1.
        assert!((found - error).abs() < 1e-15, "{found}");
        assert_eq!(
            angle_error(&facets, None, 1e-4),
            Some(0.0),
            "no corner's face within that"
        );
    }
}
