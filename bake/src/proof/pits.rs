//! Convex pits, each closed by mirrors, an opening and walls between it and its neighbours.
//!
//! Light of a cell without a lattice stays in the pit that it enters. In a lattice it crosses walls
//! ([`valleys`](crate::proof::valleys())).

use glam::{DVec2, DVec3};

use crate::cell::{Body, Facet};
use crate::geometry::polygon;

/// Greatest distance of two corners that count as one, edge lengths: far above rounding, far below
/// any facet.
pub(crate) const SAME: f64 = 1e-9;

/// Neighbour of a pit behind one of its faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Beyond {
    /// Nothing: the face is a mirror.
    Mirror,
    /// The front face.
    Front,
    /// Another pit. Light enters it through the face.
    Pit {
        /// Number of that pit.
        number: usize,
        /// Number of the face there.
        face: usize,
        /// Lattice vector by which that pit is moved, edge lengths.
        step: DVec2,
    },
}

/// Face of a pit.
#[derive(Debug, Clone)]
pub(crate) struct Face {
    /// Corners, counter-clockwise seen from inside.
    pub corners: Vec<DVec3>,
    /// Unit normal to the inside.
    pub normal: DVec3,
    /// Offset of the plane normal . x = offset.
    pub offset: f64,
    pub beyond: Beyond,
}

impl Face {
    /// Returns a facet as a mirror.
    pub(crate) fn of(facet: &Facet) -> Self {
        Face {
            corners: facet.corners.clone(),
            normal: facet.normal,
            offset: facet.offset,
            beyond: Beyond::Mirror,
        }
    }

    /// Returns an opening at `height`; its corners run clockwise seen from above.
    pub(crate) fn front(corners: Vec<DVec3>, height: f64) -> Self {
        Face {
            corners,
            normal: DVec3::NEG_Z,
            offset: -height,
            beyond: Beyond::Front,
        }
    }
}

/// Greatest difference of two maps that count as one, and greatest cosine of planes at a right
/// angle. Products of three reflections round by some 1e-15; light would be off by 1e-11 rad.
pub(crate) const STRAIGHT: f64 = 1e-11;

/// Convex body of air or glass between mirrors, walls and an opening.
#[derive(Debug, Clone)]
pub(crate) struct Pit {
    /// Mirrors, walls, and the opening as the last face.
    pub faces: Vec<Face>,
    /// Vectors of the lattice in which light goes from pit to pit; `None` if it stays in one.
    pub lattice: Option<[DVec2; 2]>,
    /// Height of the opening, edge lengths.
    pub height: f64,
    /// Frequency of the pit, relative to the most frequent body.
    pub weight: f64,
}

impl Pit {
    /// Returns the corners of the opening, counter-clockwise seen from above.
    pub(crate) fn door(&self) -> Vec<DVec2> {
        let last = &self.faces[self.faces.len() - 1];
        last.corners.iter().rev().map(|x| x.truncate()).collect()
    }

    /// Returns the faces that reflect light.
    pub(crate) fn mirrors(&self) -> impl Iterator<Item = &Face> {
        self.faces
            .iter()
            .filter(|face| face.beyond == Beyond::Mirror)
    }

    /// Returns whether no point of the pit lies behind one of its faces.
    pub(crate) fn is_convex(&self) -> bool {
        let points = || self.faces.iter().flat_map(|face| &face.corners);
        let before = |face: &Face| points().all(|x| face.normal.dot(*x) >= face.offset - SAME);
        self.faces.iter().all(before)
    }

    /// Returns whether all mirrors are at right angles.
    pub(crate) fn is_right(&self) -> bool {
        let mirrors: Vec<&Face> = self.mirrors().collect();
        mirrors.iter().enumerate().all(|(number, one)| {
            let before = &mirrors[..number];
            before
                .iter()
                .all(|other| one.normal.dot(other.normal).abs() < STRAIGHT)
        })
    }
}

/// Takes a body apart into pits, or returns `None` if it does not consist of them.
///
/// Facets belong together if they share an edge that is not in the plane of the entrance. The edges
/// that remain alone must lie in that plane, and be the rim of one convex opening. No point of a
/// pit may lie behind one of its faces. Then the faces are the whole surface of a convex body, and
/// a ray inside meets exactly one of them next.
pub(crate) fn pits(body: &Body) -> Option<Vec<Pit>> {
    if body.lattice.is_some() || body.facets.iter().any(|facet| facet.dark) {
        return None;
    }
    let mut rest: Vec<usize> = (0..body.facets.len()).collect();
    let mut pits = Vec::new();
    while let Some(first) = rest.pop() {
        let mut own = vec![first];
        let mut next = 0;
        while next < own.len() {
            let edges = edges(&body.facets[own[next]].corners);
            let shares = |&other: &usize| {
                edges.iter().any(|edge| {
                    let below = edge.iter().any(|x| x.z < body.height - SAME);
                    below && holds(&body.facets[other].corners, edge)
                })
            };
            let (found, others) = rest
                .iter()
                .partition::<Vec<usize>, _>(|other| shares(other));
            own.extend(found);
            rest = others;
            next += 1;
        }
        pits.push(pit(body, &own)?);
    }
    let area = |corners: &[DVec2]| polygon::area(corners);
    let doors: f64 = pits.iter().map(|pit| area(&pit.door())).sum();
    let known: f64 = body.doors.iter().map(|door| area(door)).sum();
    ((doors - known).abs() < SAME * known).then_some(pits)
}

fn edges(corners: &[DVec3]) -> Vec<[DVec3; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| [a, b]).collect()
}

/// Returns whether a face has `edge`, run the other way.
fn holds(corners: &[DVec3], edge: &[DVec3; 2]) -> bool {
    edges(corners)
        .iter()
        .any(|[a, b]| a.distance(edge[1]) < SAME && b.distance(edge[0]) < SAME)
}

/// Closes the facets `own` of a body by an opening, or returns `None` if no convex pit results.
fn pit(body: &Body, own: &[usize]) -> Option<Pit> {
    let mut faces: Vec<Face> = own
        .iter()
        .map(|&which| Face::of(&body.facets[which]))
        .collect();
    let all: Vec<[DVec3; 2]> = faces.iter().flat_map(|face| edges(&face.corners)).collect();
    let mut rim: Vec<[DVec3; 2]> = all
        .iter()
        .filter(|edge| !faces.iter().any(|face| holds(&face.corners, edge)))
        .copied()
        .collect();
    // The opening runs along the rim the other way.
    let [from, mut at] = rim.pop().map(|[a, b]| [b, a])?;
    let mut corners = vec![from];
    while at.distance(from) >= SAME {
        corners.push(at);
        let next = rim.iter().position(|edge| edge[1].distance(at) < SAME)?;
        at = rim.swap_remove(next)[0];
    }
    let level = corners.iter().all(|x| (x.z - body.height).abs() < SAME);
    if !rim.is_empty() || !level {
        return None;
    }
    faces.push(Face::front(corners, body.height));
    let pit = Pit {
        lattice: None,
        height: body.height,
        weight: body.weight,
        faces,
    };
    (pit.is_convex() && polygon::is_convex(&pit.door())).then_some(pit)
}
