//! Pits of a lattice: its valleys, closed by upright walls to their neighbours and by the front.
//!
//! The facets of one period must be a surface that each upright line meets once, and share their
//! edges. Facets that meet in valleys become one pit, if what lies above them is convex. Else each
//! facet is a pit of its own, for what lies above one convex facet is convex. So the pits fill the
//! space between the facets and the front, and light in a pit meets exactly one of its faces next.

use glam::{DVec2, DVec3};

use crate::cell::Body;
use crate::geometry::polygon;
use crate::proof::pits::{Beyond, Face, Pit, SAME};

/// Facet of a lattice: its number, and the lattice vector by which it is moved.
type Place = (usize, DVec2);

/// Edge of a facet of the base period: number of the facet, number of its edge.
type Edge = (usize, usize);

/// Pit under construction, and the edges below its walls. Its faces are the mirrors, then the walls
/// in the order of these edges, then the opening.
struct Valley {
    pit: Pit,
    walls: Vec<(Edge, DVec2)>,
}

/// Takes the period of a lattice apart into pits, or returns `None` if its facets are no such
/// surface as the head of this file asks for.
pub(crate) fn valleys(body: &Body, lattice: [DVec2; 2]) -> Option<Vec<Pit>> {
    let upward = |facet: &crate::cell::Facet| !facet.dark && facet.normal.z > SAME;
    if !body.facets.iter().all(upward) {
        return None;
    }
    let surface = Surface::new(body, lattice)?;
    let mut found: Vec<Valley> = Vec::new();
    // For each facet its pit and its place there.
    let mut home: Vec<Option<Place>> = vec![None; body.facets.len()];
    for first in 0..body.facets.len() {
        if home[first].is_some() {
            continue;
        }
        let valley = surface.valley(first);
        let free = valley.iter().all(|(facet, _)| home[*facet].is_none());
        let whole = surface.close(&valley).filter(|_| free);
        let (own, closed) = match whole {
            Some(closed) => (valley, closed),
            None => {
                let alone = vec![(first, DVec2::ZERO)];
                let closed = surface.close(&alone)?;
                (alone, closed)
            }
        };
        for (facet, step) in own {
            home[facet] = Some((found.len(), step));
        }
        found.push(closed);
    }
    // A closed surface that faces up lies at least once over each point of the period, so with its
    // area it lies there just once.
    let doors: f64 = found.iter().map(|one| polygon::area(&one.pit.door())).sum();
    if (doors - body.entrance_area).abs() > SAME * body.entrance_area {
        return None;
    }
    let places: Vec<Vec<(Edge, DVec2)>> = found.iter().map(|one| one.walls.clone()).collect();
    for valley in &mut found {
        let mirrors = valley.pit.mirrors().count();
        for (number, ((facet, edge), step)) in valley.walls.iter().enumerate() {
            let ((other, across), way) = surface.beyond[*facet][*edge];
            let (number_there, step_there) = home[other]?;
            let own = |wall: &&(Edge, DVec2)| wall.0 == (other, across);
            let wall = places[number_there].iter().position(|wall| own(&wall))?;
            let mirrors_there = surface.mirrors(&home, number_there);
            valley.pit.faces[mirrors + number].beyond = Beyond::Pit {
                number: number_there,
                face: mirrors_there + wall,
                step: *step + way - step_there,
            };
        }
    }
    Some(found.into_iter().map(|valley| valley.pit).collect())
}

/// Facets of one period, and what lies beyond their edges.
struct Surface<'a> {
    body: &'a Body,
    lattice: [DVec2; 2],
    /// For each edge of each facet, the edge that it shares, and the lattice vector to it.
    beyond: Vec<Vec<(Edge, DVec2)>>,
}

impl<'a> Surface<'a> {
    /// Finds the neighbours of all facets, or returns `None` if an edge has none, or several.
    fn new(body: &'a Body, lattice: [DVec2; 2]) -> Option<Self> {
        let beyond = |(a, b): (DVec3, DVec3)| {
            let mut found = body.facets.iter().enumerate().flat_map(|(facet, other)| {
                let shared = edges(&other.corners).enumerate();
                shared.filter_map(move |(edge, (c, d))| {
                    let step = b - c;
                    let vector = on_lattice(step.truncate(), lattice)?;
                    let alike =
                        step.distance(vector.extend(0.0)) < SAME && (d + step).distance(a) < SAME;
                    alike.then_some(((facet, edge), vector))
                })
            });
            let first = found.next();
            first.filter(|_| found.next().is_none())
        };
        let all = body.facets.iter();
        let all = all.map(|facet| edges(&facet.corners).map(beyond).collect());
        let beyond: Option<Vec<_>> = all.collect();
        Some(Surface {
            body,
            lattice,
            beyond: beyond?,
        })
    }

    /// Returns the facets that meet in valleys, from `first` on. A facet that is met twice, in two
    /// periods, is listed twice.
    fn valley(&self, first: usize) -> Vec<Place> {
        let mut own: Vec<Place> = vec![(first, DVec2::ZERO)];
        let mut next = 0;
        while next < own.len() && own.len() <= 2 * self.body.facets.len() {
            let (facet, step) = own[next];
            for ((other, _), way) in &self.beyond[facet] {
                let place = (*other, step + *way);
                let known = own.iter().any(|&known| same(known, place));
                if !known && self.is_valley(facet, *other, *way) {
                    own.push(place);
                }
            }
            next += 1;
        }
        own
    }

    /// Returns whether no corner of the facet `other`, moved by `way`, lies behind `facet`.
    fn is_valley(&self, facet: usize, other: usize, way: DVec2) -> bool {
        let plane = &self.body.facets[facet];
        let mut corners = self.body.facets[other].corners.iter();
        corners.all(|&x| plane.normal.dot(x + way.extend(0.0)) >= plane.offset - SAME)
    }

    /// Returns the number of mirrors of a pit.
    fn mirrors(&self, home: &[Option<Place>], pit: usize) -> usize {
        let own = home.iter().flatten();
        own.filter(|(number, _)| *number == pit).count()
    }

    /// Closes facets by walls and an opening, or returns `None` if what they enclose is not convex.
    fn close(&self, own: &[Place]) -> Option<Valley> {
        let body = self.body;
        let twice = |n: usize| own[..n].iter().any(|known| known.0 == own[n].0);
        if (0..own.len()).any(twice) {
            return None;
        }
        let mut faces: Vec<Face> = Vec::new();
        let mut rim = Vec::new();
        for &(facet, step) in own {
            let mut face = Face::of(&body.facets[facet]);
            let way = step.extend(0.0);
            face.corners.iter_mut().for_each(|x| *x += way);
            face.offset += face.normal.dot(way);
            for (edge, ends) in edges(&face.corners).enumerate() {
                let ((other, _), beyond) = self.beyond[facet][edge];
                let place = (other, step + beyond);
                if !own.iter().any(|&known| same(known, place)) {
                    rim.push((((facet, edge), step), ends));
                }
            }
            faces.push(face);
        }
        let outline = outline(&rim)?;
        let mut walls = Vec::new();
        for (edge, (a, b)) in rim {
            let up = |x: DVec3| x.truncate().extend(body.height);
            let mut corners = vec![a, up(a), up(b), b];
            corners.dedup_by(|x, y| x.distance(*y) < SAME);
            if corners.len() < 3 {
                continue;
            }
            let normal = (b - a).truncate().perp().normalize().extend(0.0);
            faces.push(Face {
                corners,
                normal,
                offset: normal.dot(a),
                // Replaced when all pits are known.
                beyond: Beyond::Front,
            });
            walls.push(edge);
        }
        let above = outline.iter().rev();
        let above = above.map(|x| x.truncate().extend(body.height));
        faces.push(Face::front(above.collect(), body.height));
        let pit = Pit {
            lattice: Some(self.lattice),
            height: body.height,
            weight: body.weight,
            faces,
        };
        let door = pit.door();
        // Edges in the plane of the entrance have no wall.
        let left = |(a, b): (DVec2, DVec2)| {
            let along = (b - a).normalize();
            door.iter().all(|&x| along.perp_dot(x - a) >= -SAME)
        };
        let next = door.iter().cycle().skip(1);
        let round = door.iter().zip(next).all(|(&a, &b)| left((a, b)));
        (round && pit.is_convex()).then_some(Valley { pit, walls })
    }
}

fn edges(corners: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
    let next = corners.iter().cycle().skip(1);
    corners.iter().copied().zip(next.copied())
}

fn same(a: Place, b: Place) -> bool {
    a.0 == b.0 && a.1.distance(b.1) < SAME
}

/// Returns the vector of `lattice` closest to `step`.
pub(crate) fn on_lattice(step: DVec2, [a, b]: [DVec2; 2]) -> Option<DVec2> {
    let area = a.perp_dot(b);
    let (i, j) = (step.perp_dot(b) / area, a.perp_dot(step) / area);
    let vector = i.round() * a + j.round() * b;
    vector.is_finite().then_some(vector)
}

/// Returns the corners of the one loop that edges form, or `None` if they form no loop.
fn outline<T>(rim: &[(T, (DVec3, DVec3))]) -> Option<Vec<DVec3>> {
    let (from, mut at) = rim.first()?.1;
    let mut corners = vec![from];
    while at.distance(from) >= SAME {
        corners.push(at);
        let next = rim.iter().find(|(_, (a, _))| a.distance(at) < SAME)?;
        at = next.1.1;
        if corners.len() > rim.len() {
            return None;
        }
    }
    (corners.len() == rim.len()).then_some(corners)
}
