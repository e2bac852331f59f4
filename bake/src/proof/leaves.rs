//! All facet sequences that light of a patch of directions may take in a pit.
//!
//! A facet is unfolded as in `beams`: the corner X becomes x = transpose(L) (X - shift), and its
//! shadow on the plane of the entrance is x - (height - z) tau. The line through two shadows P and
//! Q is where (Q - P) x (p - P) = 0. In it the squares of tau cancel, so it is affine in tau: no
//! approximation is made.

use glam::{DMat3, DVec2, DVec3};

use crate::geometry::{Polygon, polygon};
use crate::optics::{Leaving, Rules};
use crate::proof::moving::{Affine, Moving, Patch, ever};
use crate::proof::pits::{Face, Pit};

/// Number of reflections after which a sequence is left open. Light of pits with nearly right
/// angles takes 3, and slivers of it 5.
const DEEP: usize = 9;

/// Largest area that counts as none, square edge lengths.
pub(crate) const NO_AREA: f64 = 1e-11;

/// Facet sequence, from the entrance to the exit.
#[derive(Debug, Clone)]
pub(crate) struct Leaf {
    /// Half-planes of the entrance whose intersection takes this sequence.
    pub lines: Vec<Moving>,
    /// Holds all entry points that ever take the sequence.
    pub ever: Polygon,
    /// Linear part of the map from unfolded to real space.
    pub linear: DMat3,
    /// Constant part of that map.
    pub shift: DVec3,
    /// Normals of the facets that it meets, unit length, folded back as `linear` is.
    pub normals: Vec<DVec3>,
    /// True if its light counts as retroreflected.
    pub returns: bool,
    /// True if the sequence was not followed to its end.
    pub open: bool,
}

/// Returns the sequences that light of `patch` may take. Sequences that none takes may be among
/// them.
///
/// A ray in a pit meets exactly one face next. So in each direction the sequences share the whole
/// entrance, each point once, and a sequence's points are those whose light meets its faces one
/// after the other.
pub(crate) fn leaves(pit: &Pit, patch: &Patch, rules: &Rules) -> Vec<Leaf> {
    let door = pit.door();
    let edges = door.iter().zip(door.iter().cycle().skip(1));
    let lines = edges.map(|(&a, &b)| {
        let edge = b - a;
        Moving {
            offset: [edge.perp_dot(a), 0.0, 0.0],
            normal: [DVec2::new(edge.y, -edge.x), DVec2::ZERO, DVec2::ZERO],
            error: 0.0,
        }
    });
    let start = Leaf {
        lines: lines.collect(),
        ever: door.clone(),
        linear: DMat3::IDENTITY,
        shift: DVec3::ZERO,
        normals: Vec::new(),
        returns: false,
        open: false,
    };
    let mut found = Vec::new();
    let mut search = Search {
        pit,
        patch,
        rules,
        leaving: Leaving::new(rules),
        found: &mut found,
    };
    search.follow(start, pit.faces.len() - 1, 0);
    found
}

struct Search<'a> {
    pit: &'a Pit,
    patch: &'a Patch,
    rules: &'a Rules,
    leaving: Leaving,
    found: &'a mut Vec<Leaf>,
}

impl Search<'_> {
    /// Follows the light of `beam`, which comes from the face `last` after `reflections`.
    fn follow(&mut self, beam: Leaf, last: usize, reflections: usize) {
        if reflections == DEEP {
            self.found.push(Leaf { open: true, ..beam });
            return;
        }
        let door = self.pit.faces.len() - 1;
        for (which, face) in self.pit.faces.iter().enumerate() {
            if which == last || !self.faces_light(face, &beam) {
                continue;
            }
            let lines = self.lines(face, &beam, reflections % 2 == 1);
            let seen = ever(&beam.ever, &lines);
            if polygon::area(&seen) <= NO_AREA {
                continue;
            }
            let mut onward = Leaf {
                ever: seen,
                ..beam.clone()
            };
            onward.lines.extend(lines);
            if which == door {
                onward.returns = reflections > 0 && self.leaving.is_near(beam.linear);
                self.found.push(onward);
                continue;
            }
            let reflects = self.reflects(face, &beam);
            if reflects != Some(true) {
                onward.open = reflects.is_none();
                self.found.push(onward);
                continue;
            }
            let mirror = |x: DVec3| x - 2.0 * face.normal.dot(x) * face.normal;
            let [x, y, z] =
                [beam.linear.x_axis, beam.linear.y_axis, beam.linear.z_axis].map(mirror);
            onward.normals.push(beam.linear.transpose() * face.normal);
            onward.linear = DMat3::from_cols(x, y, z);
            onward.shift = mirror(beam.shift) + 2.0 * face.offset * face.normal;
            self.follow(onward, which, reflections + 1);
        }
    }

    /// Returns whether light of a direction of the patch may meet the inside of `face`.
    fn faces_light(&self, face: &Face, beam: &Leaf) -> bool {
        let [middle, s, t] = self.along(face, beam);
        middle - s.abs() - t.abs() < 0.0
    }

    /// Returns the part of the light (tau, -1) of `beam` along the normal of `face`.
    fn along(&self, face: &Face, beam: &Leaf) -> Affine {
        let normal = beam.linear.transpose() * face.normal;
        let along = normal.truncate();
        let Patch {
            centre,
            first,
            second,
            ..
        } = *self.patch;
        [
            along.dot(centre) - normal.z,
            along.dot(first),
            along.dot(second),
        ]
    }

    /// Returns whether `face` reflects light of all directions of the patch, or lets all of it
    /// through; `None` if it may differ.
    ///
    /// Light along (tau, -1) is reflected totally if its cosine c from the normal has c^2 < 1 -
    /// 1/n^2. Over the length 1 / cos(incidence) of that vector, c is affine in tau.
    fn reflects(&self, face: &Face, beam: &Leaf) -> Option<bool> {
        if !self.rules.reflects_only_totally() {
            return Some(true);
        }
        let [middle, s, t] = self.along(face, beam);
        let (middle, change) = (middle.abs(), s.abs() + t.abs());
        let limit = 1.0 - self.rules.refractive_index.powi(-2);
        let (far, near) = self.patch.distances(DVec2::ZERO);
        // Rounding decides within 1e-12 of the limit.
        let most = limit * (1.0 + far * far) + 1e-12;
        let least = limit * (1.0 + near * near) - 1e-12;
        match (
            (middle - change).max(0.0).powi(2),
            (middle + change).powi(2),
        ) {
            (_, greatest) if greatest < least => Some(true),
            (smallest, _) if smallest > most => Some(false),
            _ => None,
        }
    }

    /// Returns the half-planes of the entry points whose light goes through `face`.
    ///
    /// They hold where the light meets the inside of the face. Elsewhere no light of the beam goes
    /// through it, so that they claim too much at worst. An odd number of reflections turns the
    /// outline over.
    fn lines(&self, face: &Face, beam: &Leaf, turned: bool) -> Vec<Moving> {
        let fold = beam.linear.transpose();
        let mut corners: Vec<DVec3> = face
            .corners
            .iter()
            .map(|&x| fold * (x - beam.shift))
            .collect();
        if turned {
            corners.reverse();
        }
        let next = corners.iter().cycle().skip(1);
        let line = |(p, q): (&DVec3, &DVec3)| self.through(*p, *q);
        corners.iter().zip(next).filter_map(line).collect()
    }

    /// Returns the half-plane to the left of the shadows of `p` and `q`, or `None` if they are one.
    fn through(&self, p: DVec3, q: DVec3) -> Option<Moving> {
        let (a, edge) = (p.truncate(), (q - p).truncate());
        // Depths below the entrance, and how they differ.
        let (deep, deeper) = (self.pit.height - p.z, p.z - q.z);
        if edge.length() + deeper.abs() < 1e-9 {
            return None;
        }
        let normal = |tau: DVec2| DVec2::new(-deeper * tau.y, deeper * tau.x);
        let offset = |tau: DVec2| -deep * edge.perp_dot(tau) - deeper * tau.perp_dot(a);
        let Patch {
            centre,
            first,
            second,
            ..
        } = *self.patch;
        let still = DVec2::new(edge.y, -edge.x);
        Some(Moving {
            offset: [
                edge.perp_dot(a) + offset(centre),
                offset(first),
                offset(second),
            ],
            normal: [still + normal(centre), normal(first), normal(second)],
            error: 0.0,
        })
    }
}

/// Returns lines seen from a point that moves as `place`, within `error`.
///
/// A product of two changes is not affine. It is at most the product of their magnitudes.
pub(crate) fn seen_from(lines: &[Moving], place: [DVec2; 3], error: f64) -> Vec<Moving> {
    let seen = |line: &Moving| {
        let product = |i: usize, j: usize| line.normal[i].dot(place[j]);
        let offset: Affine = [
            line.offset[0] + product(0, 0),
            line.offset[1] + product(0, 1) + product(1, 0),
            line.offset[2] + product(0, 2) + product(2, 0),
        ];
        let second =
            product(1, 1).abs() + product(2, 2).abs() + (product(1, 2) + product(2, 1)).abs();
        let steep: f64 = line.normal.iter().map(|n| n.length()).sum();
        Moving {
            offset,
            normal: line.normal,
            error: line.error + second + steep * error,
        }
    };
    lines.iter().map(seen).collect()
}
