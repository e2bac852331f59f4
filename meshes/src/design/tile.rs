//! Cube corners side by side: the land around an aperture, and pairs.

use glam::DVec3;

use crate::design::corner::CornerFacets;
use crate::mesh::mesh::Mesh;

/// Part of the edge length within which vertices are one.
const SAME: f64 = 1e-9;

impl CornerFacets {
    /// Returns the corner with a flat land of the width `width` around its triangular aperture, and
    /// the corners of the outer triangle of the land.
    ///
    /// `ends` are the corners of the aperture.
    pub(super) fn with_land(self, ends: [DVec3; 3], width: f64) -> (Self, [DVec3; 3]) {
        if width == 0.0 {
            return (self, ends);
        }
        let [a, b, c] = ends;
        let sides = [b.distance(c), c.distance(a), a.distance(b)];
        let around: f64 = sides.iter().sum();
        let middle = (a * sides[0] + b * sides[1] + c * sides[2]) / around;
        let inradius = (b - a).cross(c - a).length() / around;
        let outer = ends.map(|end| middle + (end - middle) * (1.0 + width / inradius));
        let mut corner = self;
        let first = corner.positions.len() as u32;
        corner.positions.extend(outer);
        for k in 0..3 {
            let (here, next) = (first + k, first + (k + 1) % 3);
            let [arc, next_arc] = [k, (k + 1) % 3].map(|k| &corner.rim[k as usize]);
            let fan = arc.windows(2).map(|pair| [here, pair[1], pair[0]]);
            let side = [
                [here, next, next_arc[0]],
                [here, next_arc[0], arc[arc.len() - 1]],
            ];
            corner.triangles.extend(fan.chain(side));
        }
        corner.rim = [0, 1, 2].map(|k| vec![first + k]);
        (corner, outer)
    }

    /// Returns the corner alone as a mesh.
    pub(super) fn mesh(self) -> Mesh {
        Mesh {
            positions: self.positions,
            triangles: self.triangles,
            ..Mesh::default()
        }
    }

    /// Returns the corner and its copy.
    ///
    /// The copy is turned by 180 degrees about `normal` (any length) through the middle of the side
    /// that the two share, from `a` to `b`.
    pub(super) fn pair(self, [a, b, _]: [DVec3; 3], normal: DVec3) -> Mesh {
        // The normal is not of unit length, because normalising would turn integers into roots.
        let turned = |p: DVec3| normal * (2.0 * normal.dot(p) / normal.length_squared()) - p;
        let (middle, turned_middle) = ((a + b) * 0.5, turned((a + b) * 0.5));
        let same = SAME * a.length();
        let mut mesh = self.mesh();
        let own = mesh.positions.len();
        let copies: Vec<u32> = (0..own)
            .map(|vertex| {
                let copy = middle + (turned(mesh.positions[vertex]) - turned_middle);
                let shared = mesh.positions[..own].iter();
                let known = shared.clone().position(|p| p.distance(copy) <= same);
                known.unwrap_or_else(|| {
                    mesh.positions.push(copy);
                    mesh.positions.len() - 1
                }) as u32
            })
            .collect();
        let copied = mesh.triangles.iter().map(|t| t.map(|v| copies[v as usize]));
        let copied: Vec<[u32; 3]> = copied.collect();
        mesh.triangles.extend(copied);
        while let Some((triangle, parts)) = touched(&mesh, same) {
            mesh.triangles[triangle] = parts[0];
            mesh.triangles.push(parts[1]);
        }
        mesh
    }
}

/// Finds a triangle with an outer edge on which an outer vertex lies, and returns the two triangles
/// that the vertex divides it into.
///
/// Such edges occur if the arcs of two cubes differ: they then share only a part of the side
/// between them.
fn touched(mesh: &Mesh, same: f64) -> Option<(usize, [[u32; 3]; 2])> {
    let edges = |t: &[u32; 3]| [[t[0], t[1], t[2]], [t[1], t[2], t[0]], [t[2], t[0], t[1]]];
    let inner: std::collections::HashSet<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(edges)
        .map(|[from, to, _]| [from, to])
        .collect();
    let at = |vertex: u32| mesh.positions[vertex as usize];
    let outer = mesh.triangles.iter().enumerate().flat_map(|(i, t)| {
        let outer = edges(t).into_iter();
        outer
            .filter(|&[from, to, _]| !inner.contains(&[to, from]))
            .map(move |edge| (i, edge))
    });
    let outer: Vec<(usize, [u32; 3])> = outer.collect();
    outer.iter().find_map(|&(triangle, [from, to, third])| {
        let side = at(to) - at(from);
        let lies_on = |&vertex: &u32| {
            let along = (at(vertex) - at(from)).dot(side) / side.length_squared();
            let off = at(vertex).distance(at(from) + side * along);
            let margin = same / side.length();
            off <= same && along > margin && along < 1.0 - margin
        };
        let vertex = outer.iter().map(|(_, edge)| edge[0]).find(lies_on)?;
        Some((triangle, [[from, vertex, third], [vertex, to, third]]))
    })
}
