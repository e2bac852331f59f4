//! Walls between the prisms of a periodic cell, and the copies of its facets that overlap a prism or
//! a box.

use glam::{DMat2, DVec2, DVec3};

use crate::optics::Triangle;

/// Largest number of facets, copies included, among which a step of a program looks for the next.
const MOST_COPIES: usize = 1 << 12;

/// Largest distance from a wall at which a facet is in both lists, lattice coordinates.
const WALL: f64 = 1e-9;

/// Walls between the prisms of a periodic cell.
pub(super) struct Walls {
    pub lattice: [DVec2; 2],
    /// Linear map from the plane to lattice coordinates.
    pub lattice_from_plane: DMat2,
    /// Corner of the parallelogram with the lattice coordinates (0, 0), edge lengths.
    pub corner: DVec2,
    /// Facets of one cell; empty if they are too many for a program.
    pub own: Vec<Triangle>,
}

impl Walls {
    /// Returns the displacement of `prism` lattice vectors, edge lengths.
    pub(super) fn displacement(&self, prism: [i32; 2]) -> DVec2 {
        self.lattice[0] * f64::from(prism[0]) + self.lattice[1] * f64::from(prism[1])
    }

    /// Returns the copies of the cell's facets whose boxes overlap the box from `low` to `high` of
    /// the plane, or `None` if they are more than [`MOST_COPIES`].
    pub(super) fn copies_above(&self, low: DVec2, high: DVec2) -> Option<Vec<Triangle>> {
        let ends = [
            low,
            DVec2::new(low.x, high.y),
            DVec2::new(high.x, low.y),
            high,
        ];
        let ends = ends.map(|end| self.lattice_from_plane * end);
        let first_of_box = ends.into_iter().fold(DVec2::INFINITY, DVec2::min);
        let last_of_box = ends.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
        let mut copies = Vec::new();
        for facet in &self.own {
            let corners = facet.corners.map(DVec3::truncate);
            let flat = corners.map(|corner| self.lattice_from_plane * corner);
            let first = (first_of_box - flat[0].max(flat[1]).max(flat[2]) - WALL).ceil();
            let last = (last_of_box - flat[0].min(flat[1]).min(flat[2]) + WALL).floor();
            let copies_at_most = (last - first + 1.0).max(DVec2::ZERO).element_product();
            // A way without end has copies without number, or NaN of them.
            if copies_at_most.is_nan() || copies_at_most > MOST_COPIES as f64 {
                return None;
            }
            let from = corners[0].min(corners[1]).min(corners[2]);
            let to = corners[0].max(corners[1]).max(corners[2]);
            for i in first.x as i32..=last.x as i32 {
                for j in first.y as i32..=last.y as i32 {
                    let offset = self.displacement([i, j]);
                    let overlaps = (from + offset).cmple(high + WALL).all()
                        && (to + offset).cmpge(low - WALL).all();
                    if overlaps {
                        copies.push(facet.moved(offset.extend(0.0)));
                    }
                }
            }
        }
        (copies.len() <= MOST_COPIES).then_some(copies)
    }

    /// Returns every copy of `own` that overlaps the prism of the parallelogram, walls included.
    ///
    /// Beside each copy stands the number of the facet that it is a copy of.
    pub(super) fn copies(&self, own: &[Triangle]) -> Vec<(Triangle, usize)> {
        let mut copies = Vec::new();
        for (number, facet) in own.iter().enumerate() {
            let flat = facet
                .corners
                .map(|corner| self.lattice_from_plane * (corner.truncate() - self.corner));
            let low = flat[0].min(flat[1]).min(flat[2]);
            let high = flat[0].max(flat[1]).max(flat[2]);
            // Copies moved by (i, j) reach into [0, 1]^2 when low + i <= 1 and high + i >= 0.
            let first = |high: f64| (-high - WALL).ceil() as i32;
            let last = |low: f64| (1.0 - low + WALL).floor() as i32;
            for i in first(high.x)..=last(low.x) {
                for j in first(high.y)..=last(low.y) {
                    let corners =
                        flat.map(|corner| corner + DVec2::new(f64::from(i), f64::from(j)));
                    if overlaps_unit_square(corners) {
                        let copy = facet.moved(self.displacement([i, j]).extend(0.0));
                        copies.push((copy, number));
                    }
                }
            }
        }
        copies
    }
}

/// Returns whether a triangle in lattice coordinates overlaps [0, 1]^2.
///
/// It does if no edge of it separates the two. The sides of the square need no test, because the
/// caller passes only triangles whose bounding box overlaps the square.
fn overlaps_unit_square(corners: [DVec2; 3]) -> bool {
    let square = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
    (0..3).all(|i| {
        let (from, to, other) = (corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
        let outward = (to - from).perp();
        let outward = if outward.dot(other - from) > 0.0 {
            -outward
        } else {
            outward
        };
        square
            .iter()
            .any(|&point| outward.dot(point - from) <= WALL * outward.length())
    })
}
