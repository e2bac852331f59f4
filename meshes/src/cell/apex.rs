//! Apexes of a surface, and the edges that run from them.
//!
//! An apex is an inner vertex around which the facets face in three nearly perpendicular
//! directions. All neighbours lie on the side that the facets face (the light's side). A finely
//! triangulated facet counts as one facet if its normals at the apex agree. The three edges (legs)
//! of an apex are the concave edges between the facets, followed as long as they are straight.

use glam::DVec3;

use crate::cell::surface::Surface;

/// Cosine of the angle (20 deg) within which the normals of two triangles around a vertex are those
/// of one facet.
const SAME_FACET_COS: f64 = 0.94;
/// Greatest cosine between the normals of two facets that count as perpendicular (5.7 deg off a
/// right angle).
const PERPENDICULAR_COS: f64 = 0.1;
/// Least cosine between a leg and the next step of its concave edge, if the edge counts as
/// straight.
const STRAIGHT_COS: f64 = 0.9995;

/// Vertex at which three perpendicular facets meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// Welded vertex of the corner.
    pub vertex: u32,
    /// Axis of the cube: unit vector in the middle of the three facets' normals, towards the side
    /// that they face.
    pub axis: DVec3,
    /// True if the neighbours lie on the side of `axis`: a hollow corner that returns light.
    /// Otherwise the corner is a peak.
    pub hollow: bool,
}

/// Edge from an apex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Leg {
    /// Welded vertex at the end of the edge.
    pub outer: u32,
    /// Vector from the apex to the end of the edge, file units.
    pub along: DVec3,
}

/// Triangles around each vertex.
#[derive(Debug)]
pub(crate) struct Fans<'s, 'm> {
    surface: &'s Surface<'m>,
    start: Vec<u32>,
    triangles: Vec<u32>,
}

impl<'s, 'm> Fans<'s, 'm> {
    /// Gathers the fans of `surface`.
    pub(crate) fn new(surface: &'s Surface<'m>) -> Self {
        let mut start = vec![0_u32; surface.mesh.positions.len() + 1];
        for &vertex in surface.welded.iter().flatten() {
            start[vertex as usize + 1] += 1;
        }
        for vertex in 1..start.len() {
            start[vertex] += start[vertex - 1];
        }
        let mut next = start.clone();
        let mut triangles = vec![0_u32; 3 * surface.welded.len()];
        for (triangle, corners) in surface.welded.iter().enumerate() {
            for &vertex in corners {
                triangles[next[vertex as usize] as usize] = triangle as u32;
                next[vertex as usize] += 1;
            }
        }
        Self {
            surface,
            start,
            triangles,
        }
    }

    /// Returns the triangles around a vertex.
    fn around(&self, vertex: u32) -> &[u32] {
        &self.triangles
            [self.start[vertex as usize] as usize..self.start[vertex as usize + 1] as usize]
    }

    /// Returns the position of a vertex, file units.
    fn position(&self, vertex: u32) -> DVec3 {
        self.surface.mesh.positions[vertex as usize]
    }

    /// Returns all corners, in the order of the file.
    pub(crate) fn corners(&self) -> Vec<Corner> {
        let mut inner = vec![true; self.surface.mesh.positions.len()];
        for (from, to) in self.surface.boundary() {
            inner[from as usize] = false;
            inner[to as usize] = false;
        }
        (0..inner.len() as u32)
            .filter(|&v| inner[v as usize])
            .filter_map(|v| self.corner(v))
            .collect()
    }

    /// Returns the corner at an inner vertex, if there is one.
    fn corner(&self, vertex: u32) -> Option<Corner> {
        let around = self.around(vertex);
        let mut facets: Vec<(DVec3, DVec3)> = Vec::with_capacity(3);
        for &triangle in around {
            let normal = self.surface.normals[triangle as usize];
            match facets
                .iter()
                .position(|(first, _)| first.dot(normal) > SAME_FACET_COS)
            {
                Some(facet) => facets[facet].1 += normal,
                None if facets.len() == 3 => return None,
                None => facets.push((normal, normal)),
            }
        }
        let [a, b, c] = facets[..] else { return None };
        let [a, b, c] = [a, b, c].map(|(_, sum)| sum.normalize_or_zero());
        if [a.dot(b), b.dot(c), c.dot(a)]
            .iter()
            .any(|cos| cos.abs() > PERPENDICULAR_COS)
        {
            return None;
        }
        let axis = (a + b + c).normalize();
        let apex = self.position(vertex);
        let others = around
            .iter()
            .flat_map(|&t| self.surface.welded[t as usize])
            .filter(|&v| v != vertex);
        let mut rising = others.map(|v| axis.dot(self.position(v) - apex) > 0.0);
        let hollow = rising.next()?;
        rising.all(|r| r == hollow).then_some(Corner {
            vertex,
            axis,
            hollow,
        })
    }

    /// Returns the far ends of the concave edges between facets that start at `vertex`.
    fn concave_edges(&self, vertex: u32) -> Vec<u32> {
        let base = self.position(vertex);
        // Each edge at the vertex with each of its triangles and the third vertex of this triangle,
        // sorted by edge.
        let mut spokes: Vec<(u32, u32, u32)> = Vec::new();
        for &triangle in self.around(vertex) {
            let [a, b, c] = self.surface.welded[triangle as usize];
            let [p, q] = match vertex {
                v if v == a => [b, c],
                v if v == b => [c, a],
                _ => [a, b],
            };
            spokes.extend([(p, triangle, q), (q, triangle, p)]);
        }
        spokes.sort_unstable();
        let concave = |pair: &[(u32, u32, u32)]| {
            let [(end, one, _), (other_end, other, far)] = [pair[0], pair[1]];
            let (n, m) = (
                self.surface.normals[one as usize],
                self.surface.normals[other as usize],
            );
            let hollow = n.dot(m) < SAME_FACET_COS && n.dot(self.position(far) - base) > 0.0;
            (end == other_end && hollow).then_some(end)
        };
        spokes.windows(2).filter_map(concave).collect()
    }

    /// Returns the three legs of a hollow corner, sorted by their outer vertex in the file.
    ///
    /// Returns `None` if the facets do not meet in three straight concave edges.
    pub(crate) fn legs(&self, corner: &Corner) -> Option<[Leg; 3]> {
        let apex = self.position(corner.vertex);
        let starts: [u32; 3] = self.concave_edges(corner.vertex).try_into().ok()?;
        let mut legs = starts.map(|start| {
            let mut outer = start;
            let mut length = apex.distance(self.position(outer));
            let direction = (self.position(outer) - apex) / length;
            loop {
                let here = self.position(outer);
                let onward = self.concave_edges(outer).into_iter().find(|&next| {
                    let step = self.position(next) - here;
                    step.dot(direction) > STRAIGHT_COS * step.length()
                });
                // Each step lengthens the leg, so the walk ends. The test guards against rounding.
                match onward.filter(|&next| apex.distance(self.position(next)) > length) {
                    Some(next) => (outer, length) = (next, apex.distance(self.position(next))),
                    None => {
                        break Leg {
                            outer,
                            along: here - apex,
                        };
                    }
                }
            }
        });
        legs.sort_by_key(|leg| leg.outer);
        Some(legs)
    }
}
