//! A sheet of many small cells, taken apart into bodies that light cannot pass between.
//!
//! A **body** is a piece of the mesh whose own rim, its aperture, lies in the entrance plane.
//! Suppose that the apertures are convex and side by side, and that each body lies under its own
//! aperture. Then a ray stays in the body that it enters: it can leave only upward, through the
//! aperture. Bodies that are copies of each other form a **kind** and shift a ray alike. So one
//! body of each kind is traced, with the kind's share of the rays.
//!
//! Every condition is checked. If one fails, [`apart`] names the reason and the mesh is traced as a
//! whole:
//!
//! - Every edge of a body has a facet on either side, or lies in the entrance plane with the body
//!   on its left.
//! - The edges in the entrance plane form one convex loop, the aperture. No vertex of the body is
//!   above or beside it.
//! - An edge of an aperture is shared with a neighbour's aperture or lies on the entrance polygon.
//!   Then the number of apertures over a point is the same everywhere in the entrance, and it is 1
//!   because the areas add up.
//!
//! Two vertices are one vertex if their coordinates are equal to the last bit, as they are in a
//! file that gives them the same digits.

use crate::cell::prepared::PROGRAM_FACETS;
use glam::{DVec2, DVec3};
use meshes::{Cell, Entrance};
use std::collections::HashMap;

/// Largest number of kinds. Each costs a program per direction, which takes the time of some
/// hundred rays and about 3 kB.
const KINDS: usize = 4096;

/// Largest number of kinds if a body is too large for a program: every ray then looks at each kind.
const LARGE_KINDS: usize = 16;

/// Largest number of facets of a body. The comparison of two bodies takes a time that grows with
/// its square.
const MOST_OF_BODY: usize = 256;

/// Largest number of comparisons of rim edges with the sides of the entrance.
const COMPARISONS: usize = 1 << 24;

/// Rounding of coordinates, relative to the extent of the mesh. To this accuracy bodies are alike
/// and points lie in the plane.
const COORDINATE_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Largest relative difference of the sum of the apertures' areas from the area of the entrance.
const COVERED: f64 = 1e-9;

/// Bodies that are copies of each other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Kind {
    /// Facets of one of the bodies, moved so that the middle of its aperture's corners is over the
    /// origin.
    pub facets: Vec<[DVec3; 3]>,
    /// Aperture of that body.
    pub entrance: Entrance,
    /// Places of all bodies: displacements that carry `facets` onto those of the mesh, within
    /// rounding.
    pub places: Vec<DVec2>,
}

/// The reason why a cell is traced as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Whole {
    /// The cell has few facets.
    #[error("the cell has few facets")]
    Small,
    /// The facets stand for curved faces.
    #[error("its faces are curved")]
    Curved,
    /// The facets are surfaces of glass, which light passes.
    #[error("light goes through faces of glass")]
    Glass,
    /// The cell is periodic: its neighbours are those of the lattice.
    #[error("the cell is periodic")]
    Periodic,
    /// The cell is no set of separate bodies.
    #[error(
        "its facets do not form separate cubes side by side, with all rims in one plane and with \
        the vertices of neighbours equal to the last digit"
    )]
    Connected,
    /// The cell has too many bodies that differ.
    #[error(
        "more than {KINDS} of its cubes ({LARGE_KINDS}, if one has more than {facets} facets) \
        differ from each other by more than the rounding of their coordinates",
        facets = PROGRAM_FACETS
    )]
    Unlike,
}

/// The number of a vertex. Equal positions have equal numbers.
type Vertex = usize;

/// Takes `cell` apart and returns the kinds of its bodies, however few its facets.
///
/// # Errors
///
/// Returns [`Whole`], the reason, if the cell cannot be taken apart.
pub(crate) fn apart(cell: &Cell) -> Result<Vec<Kind>, Whole> {
    if cell.normals.is_some() {
        return Err(Whole::Curved);
    }
    if !cell.glass.is_empty() {
        return Err(Whole::Glass);
    }
    if cell.entrance.lattice.is_some() {
        return Err(Whole::Periodic);
    }
    // Each body has two facets on its rim at least. If there are too few such facets, one body is
    // too large, and nothing has to be looked up.
    let height = cell.entrance.height;
    let extent = cell.facets.iter().flatten().map(|p| p.length());
    let tolerance = COORDINATE_ROUNDING * extent.fold(1.0, f64::max);
    let in_plane = |p: &&DVec3| (p.z - height).abs() <= tolerance;
    let on_rim = |facet: &&[DVec3; 3]| facet.iter().filter(in_plane).count() >= 2;
    if cell.facets.iter().filter(on_rim).count() * MOST_OF_BODY < 2 * cell.facets.len() {
        return Err(Whole::Connected);
    }
    let surface = NumberedMesh::new(cell);
    let bodies = surface.bodies().ok_or(Whole::Connected)?;
    let large = bodies.iter().any(|body| body.len() > PROGRAM_FACETS);
    let most = if large { LARGE_KINDS } else { KINDS };
    let mut kinds: Vec<Kind> = Vec::new();
    let mut by_sum: HashMap<i64, Vec<usize>> = HashMap::new();
    let mut rims = Vec::new();
    let mut area = 0.0;
    for body in bodies {
        let rim = surface.aperture(&body).ok_or(Whole::Connected)?;
        rims.extend(edges_of_loop(&rim));
        let corners: Vec<DVec2> = rim.iter().map(|&v| surface.flat(v)).collect();
        area += doubled_area(&corners) / 2.0;
        let place = corners.iter().sum::<DVec2>() / corners.len() as f64;
        let local = |p: DVec3| p - place.extend(0.0);
        let facets: Vec<[DVec3; 3]> = body.iter().map(|&f| cell.facets[f].map(local)).collect();
        // The coordinates of copies have nearly the same sum, so only kinds of nearly that sum are
        // compared.
        let sum: DVec3 = facets.iter().flatten().sum();
        let terms = 9.0 * facets.len() as f64;
        let slot = (sum.element_sum() / (2.0 * terms * surface.tolerance)).floor() as i64;
        let alike = |&kind: &usize| same_facets(&kinds[kind].facets, &facets, surface.tolerance);
        let near = (slot - 1..=slot + 1).filter_map(|slot| by_sum.get(&slot));
        match near.flatten().copied().filter(alike).min() {
            Some(known) => kinds[known].places.push(place),
            None if kinds.len() == most => return Err(Whole::Unlike),
            None => {
                by_sum.entry(slot).or_default().push(kinds.len());
                kinds.push(Kind {
                    facets,
                    entrance: Entrance {
                        height: cell.entrance.height,
                        polygon: without_straight_corners(
                            corners.iter().map(|&p| p - place).collect(),
                        ),
                        lattice: None,
                    },
                    places: vec![place],
                });
            }
        }
    }
    let whole = doubled_area(&cell.entrance.polygon) / 2.0;
    let covered = (area - whole).abs() <= COVERED * whole;
    let fits = covered && surface.has_outline(&rims, &cell.entrance.polygon);
    if fits {
        Ok(kinds)
    } else {
        Err(Whole::Connected)
    }
}

/// The facets of a cell with their vertices numbered.
struct NumberedMesh {
    points: Vec<DVec3>,
    triangles: Vec<[Vertex; 3]>,
    height: f64,
    /// Rounding of coordinates, edge lengths.
    tolerance: f64,
}

impl NumberedMesh {
    fn new(cell: &Cell) -> Self {
        let mut numbers: HashMap<[u64; 3], Vertex> = HashMap::new();
        let mut points = Vec::new();
        let mut number = |p: DVec3| {
            // Adding 0 turns -0 into 0, which is the same place.
            let key = p.to_array().map(|x| (x + 0.0).to_bits());
            *numbers.entry(key).or_insert_with(|| {
                points.push(p);
                points.len() - 1
            })
        };
        let triangles = cell
            .facets
            .iter()
            .map(|facet| facet.map(&mut number))
            .collect();
        let extent = points.iter().map(|p| p.length()).fold(1.0, f64::max);
        NumberedMesh {
            points,
            triangles,
            height: cell.entrance.height,
            tolerance: COORDINATE_ROUNDING * extent,
        }
    }

    fn flat(&self, vertex: Vertex) -> DVec2 {
        self.points[vertex].truncate()
    }

    fn is_in_plane(&self, vertex: Vertex) -> bool {
        (self.points[vertex].z - self.height).abs() <= self.tolerance
    }

    /// Returns whether an edge may be part of an aperture. Such an edge joins no facets.
    fn is_rim(&self, (from, to): (Vertex, Vertex)) -> bool {
        self.is_in_plane(from) && self.is_in_plane(to)
    }

    /// Returns the facets of each body, in the order of their first facets.
    ///
    /// Returns `None` if an edge below the entrance plane has no facet on one side, or more than
    /// one, or if a body has too many facets.
    fn bodies(&self) -> Option<Vec<Vec<usize>>> {
        let mut facet_left_of: HashMap<(Vertex, Vertex), usize> = HashMap::new();
        for (facet, triangle) in self.triangles.iter().enumerate() {
            for edge in edges_of_loop(triangle).filter(|&edge| !self.is_rim(edge)) {
                if facet_left_of.insert(edge, facet).is_some() {
                    return None;
                }
            }
        }
        let mut body_of = vec![usize::MAX; self.triangles.len()];
        let mut bodies = Vec::new();
        for first in 0..self.triangles.len() {
            if body_of[first] != usize::MAX {
                continue;
            }
            body_of[first] = bodies.len();
            let mut body = vec![first];
            let mut looked_at = 0;
            while let Some(&facet) = body.get(looked_at) {
                looked_at += 1;
                let inner =
                    edges_of_loop(&self.triangles[facet]).filter(|&edge| !self.is_rim(edge));
                for (from, to) in inner {
                    let neighbour = *facet_left_of.get(&(to, from))?;
                    if body_of[neighbour] == usize::MAX {
                        body_of[neighbour] = bodies.len();
                        body.push(neighbour);
                    }
                }
            }
            if body.len() > MOST_OF_BODY {
                return None;
            }
            bodies.push(body);
        }
        Some(bodies)
    }

    /// Returns the corners of the aperture of `body`, counter-clockwise seen from the light.
    ///
    /// Returns `None` if the aperture is not one convex loop over the whole body.
    fn aperture(&self, body: &[usize]) -> Option<Vec<Vertex>> {
        let mut next: HashMap<Vertex, Vertex> = HashMap::new();
        for &facet in body {
            let triangle = &self.triangles[facet];
            // A facet in the entrance plane itself has no depth, and its rays enter no body.
            if triangle.iter().all(|&v| self.is_in_plane(v)) {
                return None;
            }
            for (from, to) in edges_of_loop(triangle).filter(|&edge| self.is_rim(edge)) {
                if next.insert(from, to).is_some() {
                    return None;
                }
            }
        }
        let first = *next.keys().min()?;
        let mut rim = vec![first];
        let mut here = *next.get(&first)?;
        while here != first {
            rim.push(here);
            if rim.len() > next.len() {
                return None;
            }
            here = *next.get(&here)?;
        }
        let under = |vertex: Vertex| {
            self.points[vertex].z <= self.height + self.tolerance
                && edges_of_loop(&rim).all(|(from, to)| {
                    let (from, to) = (self.flat(from), self.flat(to));
                    let side = to - from;
                    side.perp_dot(self.flat(vertex) - from) >= -self.tolerance * side.length()
                })
        };
        let below = body
            .iter()
            .flat_map(|&facet| self.triangles[facet])
            .all(under);
        (rim.len() == next.len() && rim.len() >= 3 && below).then_some(rim)
    }

    /// Returns whether every edge of `rims` that has no opposite among them lies on a side of
    /// `polygon`.
    fn has_outline(&self, rims: &[(Vertex, Vertex)], polygon: &[DVec2]) -> bool {
        let mut sum: HashMap<(Vertex, Vertex), i32> = HashMap::new();
        for &(from, to) in rims {
            let (key, sign) = if from < to {
                ((from, to), 1)
            } else {
                ((to, from), -1)
            };
            *sum.entry(key).or_default() += sign;
        }
        let outer: Vec<_> = sum.iter().filter(|(_, sign)| **sign != 0).collect();
        outer.len() * polygon.len() <= COMPARISONS
            && outer.into_iter().all(|(&(from, to), _)| {
                (0..polygon.len()).any(|i| {
                    let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                    [from, to]
                        .iter()
                        .all(|&end| distance_to_side(self.flat(end), a, b) <= 4.0 * self.tolerance)
                })
            })
    }
}

fn edges_of_loop(corners: &[Vertex]) -> impl Iterator<Item = (Vertex, Vertex)> {
    let ends = corners.iter().cycle().skip(1);
    corners.iter().copied().zip(ends.copied())
}

fn doubled_area(polygon: &[DVec2]) -> f64 {
    (1..polygon.len().saturating_sub(1))
        .map(|i| (polygon[i] - polygon[0]).perp_dot(polygon[i + 1] - polygon[0]))
        .sum()
}

fn distance_to_side(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let side = b - a;
    let along = ((p - a).dot(side) / side.length_squared()).clamp(0.0, 1.0);
    p.distance(a + side * along)
}

fn without_straight_corners(polygon: Vec<DVec2>) -> Vec<DVec2> {
    let n = polygon.len();
    let is_corner = |&i: &usize| {
        let (before, here, after) = (polygon[(i + n - 1) % n], polygon[i], polygon[(i + 1) % n]);
        let chord = after - before;
        chord.perp_dot(here - before).abs() > 1e-12 * chord.length()
    };
    (0..n).filter(is_corner).map(|i| polygon[i]).collect()
}

/// Returns whether two lists hold the same facets, to `tolerance` in each coordinate.
///
/// The order of the facets and the corner with which a facet begins do not matter.
fn same_facets(one: &[[DVec3; 3]], other: &[[DVec3; 3]], tolerance: f64) -> bool {
    let near = |a: DVec3, b: DVec3| (a - b).abs().max_element() <= tolerance;
    let same = |a: &[DVec3; 3], b: &[DVec3; 3]| {
        (0..3).any(|turn| (0..3).all(|i| near(a[i], b[(i + turn) % 3])))
    };
    let mut free: Vec<&[DVec3; 3]> = other.iter().collect();
    one.len() == other.len()
        && one.iter().all(|facet| {
            let found = free.iter().position(|candidate| same(facet, candidate));
            found.map(|i| free.swap_remove(i)).is_some()
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances by hand, beside a side and beyond both of its ends. They round by an ulp of 5.
    #[test]
    fn beyond_its_ends_a_side_is_as_near_as_its_end() {
        let (a, b) = (DVec2::new(1.0, -1.0), DVec2::new(3.0, -1.0));
        let cases = [
            (DVec2::new(2.0, 2.0), 3.0),
            (DVec2::new(3.08, -1.0), 0.08),
            (DVec2::new(0.95, -1.0), 0.05),
            (DVec2::new(6.0, 3.0), 5.0),
        ];
        for (p, expected) in cases {
            let found = distance_to_side(p, a, b);
            assert!((found - expected).abs() < 2e-15, "{p}: {found}");
        }
    }
}
