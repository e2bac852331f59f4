//! What the beams of a direction leave behind: the pieces of the entrance whose light returns, and the areas of the rest.

use glam::{DMat2, DVec2, DVec3};
use tables::table::Fate;

use super::view::{Isometry, View};
use crate::optics;
use crate::path::Rules;
use crate::polygon::Polygon;

/// Light that leaves within this angle of straight back has no deviation but rounding, rad: some 1e-15 over the cosine of the
/// incidence, and far below any dihedral error that a mesh can mean.
const STRAIGHT: f64 = 1e-12;

/// Retroreflected light of one facet sequence.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    pub polygon: Polygon,
    /// shift = matrix p + offset.
    pub matrix: DMat2,
    pub offset: DVec2,
    /// Part of its power that comes back.
    pub weight: f64,
    /// As in [`tables::table::Path`].
    pub deviation: DVec2,
}

/// What became of the light of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Outcome {
    pub pieces: Vec<Piece>,
    /// Area times power by fate, square edge lengths, in the order of [`Fate::ALL`]; what returns is in `pieces` alone.
    pub area: [f64; Fate::ALL.len()],
    /// Net area of the slivers given up as rounding, square edge lengths.
    pub dropped: f64,
}

impl Piece {
    /// That of light which leaves along `toward` by the path `isometry`, all of its power, still without its polygon.
    pub fn returned(view: &View, rules: &Rules, isometry: &Isometry, toward: DVec3) -> Piece {
        let View {
            height,
            floor,
            direction,
            ..
        } = *view;
        let plane = rules.element.plane(height, floor);
        // Exit point of the light that entered at p: y = linear (p, height) + shift, carried along `toward` to the
        // plane of the shift, as the entry point is along `direction`.
        let carry = |y: DVec3| y.truncate() - y.z / toward.z * toward.truncate();
        let (u, v) = (carry(isometry.linear.x_axis), carry(isometry.linear.y_axis));
        let start = isometry.linear.z_axis * height + isometry.shift - DVec3::Z * plane;
        let lead = (height - plane) / direction.z * direction.truncate();
        let back = rules.element.straight_back(toward);
        let deviation = optics::deviation(direction, back, rules.refractive_index);
        let straight = deviation.length() < STRAIGHT;
        Piece {
            polygon: Polygon::new(),
            matrix: DMat2::from_cols(u - DVec2::X, v - DVec2::Y),
            offset: carry(start) + lead,
            weight: 1.0,
            deviation: if straight { DVec2::ZERO } else { deviation },
        }
    }
}
