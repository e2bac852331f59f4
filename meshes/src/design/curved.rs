//! Curved faces: each is cut into many facets, with the normals of the curved face at their
//! corners.
//!
//! A face bulges towards the light by 27 sag b0 b1 b2, where b are its barycentric coordinates.
//! This is the sag in its middle and 0 along its edges, so that faces still meet, rims stay planar
//! and cells still tile. Its slope is 0 at the corners and greatest on the edges: on an ideal cube
//! 6.75 sag / edge length beside a leg, 9.5 at the rim.

use std::collections::HashMap;
use std::num::NonZeroU32;

use glam::DVec3;

use crate::mesh::mesh::Mesh;

/// Cuts each triangle of `mesh`, which is one face, into `segments` x `segments` facets that bulge
/// by `sag` (file units).
///
/// Facets have normals unless `sag` is 0. Corners keep their numbers; neighbours share the points
/// of an edge.
pub(super) fn faces(mesh: &Mesh, sag: f64, segments: u32) -> Mesh {
    let mut fine = Mesh {
        triangles: Vec::new(),
        ..mesh.clone()
    };
    let mut edges = HashMap::new();
    for (face, &corners) in mesh.triangles.iter().enumerate() {
        let face = CoarseTriangle {
            vertices: corners,
            corners: mesh.corners(face),
            sag,
            segments,
        };
        face.cut(&mut edges, &mut fine);
    }
    fine
}

/// Triangle to be cut.
struct CoarseTriangle {
    vertices: [u32; 3],
    corners: [DVec3; 3],
    sag: f64,
    segments: u32,
}

impl CoarseTriangle {
    /// Appends the facets, and the points and normals that they need, to `fine`.
    ///
    /// `edges` holds the first of the points between two corners, in the order of their numbers.
    fn cut(&self, edges: &mut HashMap<[u32; 2], u32>, fine: &mut Mesh) {
        let n = self.segments;
        // Rows of steps (i, j) along the sides from corner 0 to corners 1 and 2: j from 0, and i
        // from 0 to n - j.
        let place = |i: u32, j: u32| (j * (2 * n + 3 - j) / 2 + i) as usize;
        let mut points = Vec::with_capacity(place(0, n) + 1);
        let first_normal = fine.normals.len() as u32 + 1;
        for (i, j) in (0..=n).flat_map(|j| (0..=n - j).map(move |i| (i, j))) {
            points.push(self.point([n - i - j, i, j], edges, fine));
            if self.sag != 0.0 {
                fine.normals.push(self.normal([n - i - j, i, j]));
            }
        }
        let mut add = |corners: [usize; 3]| {
            fine.triangles.push(corners.map(|corner| points[corner]));
            if self.sag != 0.0 {
                let number = |corner: usize| NonZeroU32::new(first_normal + corner as u32);
                fine.corner_normals.push(corners.map(number));
            }
        };
        for (i, j) in (0..n).flat_map(|j| (0..n - j).map(move |i| (i, j))) {
            add([place(i, j), place(i + 1, j), place(i, j + 1)]);
            if i + j + 1 < n {
                add([place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)]);
            }
        }
    }

    /// Returns the number of the vertex at barycentric coordinates `steps` / segments, and adds it
    /// if needed.
    fn point(&self, steps: [u32; 3], edges: &mut HashMap<[u32; 2], u32>, fine: &mut Mesh) -> u32 {
        let n = self.segments;
        if let Some(corner) = steps.iter().position(|&step| step == n) {
            return self.vertices[corner];
        }
        let Some(opposite) = steps.iter().position(|&step| step == 0) else {
            fine.positions.push(self.position(steps));
            return fine.positions.len() as u32 - 1;
        };
        let ends = [(opposite + 1) % 3, (opposite + 2) % 3];
        let [low, high] = if self.vertices[ends[0]] < self.vertices[ends[1]] {
            ends
        } else {
            [ends[1], ends[0]]
        };
        let first = *edges
            .entry([self.vertices[low], self.vertices[high]])
            .or_insert_with(|| {
                let first = fine.positions.len() as u32;
                let along = |step: u32| {
                    let part = f64::from(step) / f64::from(n);
                    self.corners[low] * (1.0 - part) + self.corners[high] * part
                };
                fine.positions.extend((1..n).map(along));
                first
            });
        first + steps[high] - 1
    }

    /// Returns the position on the curved face, file units.
    fn position(&self, steps: [u32; 3]) -> DVec3 {
        let [a, b, c] = self.corners;
        let [u, v, w] = steps.map(|step| f64::from(step) / f64::from(self.segments));
        let normal = (b - a).cross(c - a).normalize();
        a * u + b * v + c * w + normal * (27.0 * self.sag * u * v * w)
    }

    /// Returns the unit normal of the curved face.
    fn normal(&self, steps: [u32; 3]) -> DVec3 {
        let [a, b, c] = self.corners;
        let [u, v, w] = steps.map(|step| f64::from(step) / f64::from(self.segments));
        let normal = (b - a).cross(c - a).normalize();
        // Along the sides, u falls as v or w grows.
        let along = b - a + normal * (27.0 * self.sag * w * (u - v));
        let beside = c - a + normal * (27.0 * self.sag * v * (u - w));
        along.cross(beside).normalize()
    }
}
