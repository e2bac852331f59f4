//! All facet sequences that light of a patch of directions may take in a pit.
//!
//! A facet is unfolded as in `beams`: the corner X becomes x = transpose(L) (X - shift), and its
//! shadow on the plane of the entrance is x - (height - z) tau. The line through two shadows P and
//! Q is where (Q - P) x (p - P) = 0. In it the squares of tau cancel, so it is affine in tau: no
//! approximation is made.

use std::collections::BTreeMap;

use glam::{DMat3, DVec2, DVec3};

use crate::geometry::{HalfPlane, Polygon, polygon};
use crate::optics::{Leaving, Rules, mirrored, reflect};
use crate::proof::moving::{Affine, CORNERS, Moving, Patch, ever};
use crate::proof::pits::{Beyond, Face, Pit};
use crate::proof::power::{Surface, most_inside, most_reflected};

/// Number of reflections after which a sequence is left open, for each time that it comes from the
/// front. Light of pits with nearly right angles takes 3, and slivers of it 5.
const DEEP: usize = 9;

/// Number of walls after which a sequence is left open, for each time that it comes from the front.
/// Only light that runs along the sheet crosses as many.
const FAR: usize = 12;

/// Number of times that the front sends light back after which a sequence is left open.
const PASSES: usize = 32;

/// Number of passes for which fields are followed for a bound of the power. Later, the greatest
/// reflectances of the surfaces say enough.
const FOLLOWED: usize = 3;

/// Number of faces that are passed in all, the brightest light first. Sequences that are still
/// under way then are left open. Light of a small patch passes some hundreds. Light that runs
/// almost along walls, or close to where several meet, passes thousands, each with hardly any
/// light.
const MOST: usize = 600;

/// Number of faces that are passed in all where the front splits light. With 600, some 0.4 % of the
/// light of a pair with mirrors of 91 % is left open at 31 degrees.
const MOST_SPLIT: usize = 1500;

/// Largest area that counts as none, square edge lengths.
pub(crate) const NO_AREA: f64 = 1e-11;

/// Facet sequence, from the entrance to the exit.
#[derive(Debug, Clone)]
pub(crate) struct Leaf {
    /// Half-planes of the entrance whose intersection takes this sequence.
    pub lines: Vec<Moving>,
    /// Numbers of the faces that it meets.
    pub faces: Vec<usize>,
    /// Directions (s, t) of the patch in which light may take the sequence.
    pub when: Polygon,
    /// Holds all entry points that ever take the sequence.
    pub ever: Polygon,
    /// Linear part of the map from unfolded to real space.
    pub linear: DMat3,
    /// Constant part of that map.
    pub shift: DVec3,
    /// Surfaces that reflect it.
    pub met: Vec<Surface>,
    /// Bound of the share of the power that it has inside after the last one.
    pub power: f64,
    /// True if its light counts as retroreflected.
    pub returns: bool,
    /// Number of times that the front has sent it back before its end.
    pub passes: usize,
    /// True if its light, or a part of it, goes on from its end as another sequence.
    pub goes_on: bool,
    /// True if the sequence was not followed to its end.
    pub open: bool,
}

impl Leaf {
    /// Returns this light as it enters one `step` of the lattice further.
    pub(crate) fn moved(&self, step: DVec2) -> Leaf {
        let way = step.extend(0.0);
        Leaf {
            lines: self.lines.iter().map(|line| line.moved(step)).collect(),
            ever: self.ever.iter().map(|&x| x + step).collect(),
            shift: self.shift + way - self.linear * way,
            ..self.clone()
        }
    }
}

/// Returns the sequences that light of `patch` may take from the opening of the pit `start`.
/// Sequences that none takes may be among them.
///
/// A ray in a pit meets exactly one face next. So in each direction the sequences share the whole
/// entrance, each point once, and a sequence's points are those whose light meets its faces one
/// after the other. Walls are faces too: light of one order of mirrors may take several sequences.
/// Where the front sends light back, that holds for each number of passes: for the sequences that
/// end at the front after as many, and those that end for good before ([`Leaf::goes_on`]).
///
/// The second value bounds the area of the light that was left out because it was hardly any.
pub(crate) fn leaves(pits: &[Pit], start: usize, patch: &Patch, rules: &Rules) -> (Vec<Leaf>, f64) {
    let door = pits[start].door();
    let edges = door.iter().zip(door.iter().cycle().skip(1));
    let lines = edges.map(|(&a, &b)| {
        let edge = b - a;
        Moving {
            offset: [edge.perp_dot(a), 0.0, 0.0],
            normal: [DVec2::new(edge.y, -edge.x), DVec2::ZERO, DVec2::ZERO],
            error: 0.0,
        }
    });
    let beam = Leaf {
        lines: lines.collect(),
        faces: Vec::new(),
        when: CORNERS.map(DVec2::from_array).to_vec(),
        ever: door.clone(),
        linear: DMat3::IDENTITY,
        shift: DVec3::ZERO,
        met: Vec::new(),
        power: 1.0,
        returns: false,
        passes: 0,
        goes_on: false,
        open: false,
    };
    let mut search = Search {
        pits,
        height: pits[start].height,
        patch,
        rules,
        leaving: Leaving::new(rules),
        pending: BTreeMap::new(),
        waited: 0,
        found: Vec::new(),
        dropped: 0.0,
    };
    search.wait(Under {
        beam,
        pit: start,
        step: DVec2::ZERO,
        last: pits[start].faces.len() - 1,
        walls: 0,
        doubtful: false,
    });
    let most = if rules.splits_at_the_front() {
        MOST_SPLIT
    } else {
        MOST
    };
    let mut passed = 0;
    while let Some((_, under)) = search.pending.pop_last() {
        if passed < most && !under.is_deep() {
            passed += search.follow(&under);
        } else {
            let open = true;
            search.found.push(Leaf { open, ..under.beam });
        }
    }
    // Sequences of equal areas keep an order that does not change from patch to patch.
    search.found.sort_by(|a, b| a.faces.cmp(&b.faces));
    (search.found, search.dropped)
}

/// Light under way.
struct Under {
    /// The faces that it met.
    beam: Leaf,
    /// Number of the pit that it is in.
    pit: usize,
    /// Lattice vector by which that pit is moved.
    step: DVec2,
    /// Number of the face that it comes from.
    last: usize,
    /// Number of walls that it crossed.
    walls: usize,
    /// True if the front sends it back in some directions only. If such light returns, it is left
    /// open, also where it leaves at that very meeting.
    doubtful: bool,
}

impl Under {
    /// Returns whether the light is followed no further.
    fn is_deep(&self) -> bool {
        let rounds = self.beam.passes + 1;
        let met = self.beam.met.len();
        met >= DEEP * rounds || self.walls >= FAR * rounds || rounds > PASSES
    }
}

struct Search<'a> {
    pits: &'a [Pit],
    height: f64,
    patch: &'a Patch,
    rules: &'a Rules,
    leaving: Leaving,
    /// Light under way, by its area times power, whose bits have the order of positive numbers, and
    /// by the number of those before it.
    pending: BTreeMap<(u64, usize), Under>,
    waited: usize,
    found: Vec<Leaf>,
    dropped: f64,
}

impl Search<'_> {
    /// Puts light among that which is under way.
    fn wait(&mut self, under: Under) {
        let light = under.beam.power * polygon::area(&under.beam.ever);
        self.waited += 1;
        self.pending.insert((light.to_bits(), self.waited), under);
    }

    /// Follows light to the faces that it meets next. Returns their number.
    fn follow(&mut self, under: &Under) -> usize {
        let Under {
            ref beam,
            pit,
            step,
            last,
            walls,
            doubtful,
        } = *under;
        let pits = self.pits;
        let mut met = 0;
        for (which, face) in pits[pit].faces.iter().enumerate() {
            if which == last {
                continue;
            }
            let when = self.when(face, beam);
            if when.is_empty() {
                continue;
            }
            let lines = self.lines(face, step, beam);
            let seen = ever(&beam.ever, &lines);
            let area = polygon::area(&seen);
            if area <= NO_AREA {
                self.dropped += area.max(0.0);
                continue;
            }
            met += 1;
            let mut beam = Leaf {
                ever: seen,
                when,
                ..beam.clone()
            };
            beam.lines.extend(lines);
            beam.faces.push(which);
            let onward = |beam: Leaf| Under {
                beam,
                pit,
                step,
                last: which,
                walls,
                doubtful,
            };
            match face.beyond {
                Beyond::Pit {
                    number,
                    face,
                    step: way,
                } => self.wait(Under {
                    pit: number,
                    step: step + way,
                    last: face,
                    walls: walls + 1,
                    ..onward(beam)
                }),
                Beyond::Mirror => match self.reflects(face, &beam) {
                    Some(true) => self.wait(onward(self.reflected(beam, face, step))),
                    reflects => {
                        beam.open = reflects.is_none();
                        self.found.push(beam);
                    }
                },
                Beyond::Front => self.leave(face, onward(beam)),
            }
        }
        met
    }

    /// Returns light after a reflection by `face`, moved by `step`.
    fn reflected(&self, mut beam: Leaf, face: &Face, step: DVec2) -> Leaf {
        let offset = face.offset + face.normal.dot(step.extend(0.0));
        let surface = Surface {
            normal: beam.linear.transpose() * face.normal,
            is_front: face.beyond == Beyond::Front,
        };
        if self.rules.splits_at_the_front() {
            beam.power *= most_reflected(&surface, self.patch, self.rules);
        }
        beam.met.push(surface);
        beam.linear = mirrored(beam.linear, face.normal);
        beam.shift = reflect(beam.shift, face.normal) + 2.0 * offset * face.normal;
        beam
    }

    /// Ends light that meets the front `face`, and sends back inside what the front reflects.
    ///
    /// A sequence ends here even if all of its light goes on: so the sequences of one number of
    /// passes, and those that end for good before, share the entrance.
    fn leave(&mut self, face: &Face, under: Under) {
        let total = self.sends_back(face, &under.beam);
        let in_part = self.rules.splits_at_the_front();
        let goes_on = total != Some(false) || in_part;
        let mut beam = under.beam.clone();
        let returns = !beam.met.is_empty() && self.leaving.is_near(beam.linear);
        let leaves = total != Some(true) && returns;
        let doubtful = under.doubtful || total.is_none();
        beam.returns = leaves && !doubtful;
        beam.open = leaves && doubtful;
        // A part goes on in all directions: more of it beyond the limit of total reflection.
        let doubtful = doubtful && !in_part;
        beam.goes_on = goes_on;
        self.found.push(beam);
        if goes_on {
            let mut beam = self.reflected(under.beam, face, under.step);
            beam.passes += 1;
            if in_part && beam.passes <= FOLLOWED {
                let inside = most_inside(&beam.met, self.patch, self.rules);
                beam.power = beam.power.min(inside);
            }
            self.wait(Under {
                beam,
                doubtful,
                ..under
            });
        }
    }

    /// Returns the directions (s, t) whose light may meet the inside of `face`.
    fn when(&self, face: &Face, beam: &Leaf) -> Polygon {
        let [middle, s, t] = self.along(face, beam);
        if middle - s.abs() - t.abs() >= 0.0 {
            return Polygon::new();
        }
        let meets = HalfPlane {
            gradient: DVec2::new(s, t),
            anchor: DVec2::ZERO,
            constant: middle,
        };
        if beam.when.iter().all(|&x| meets.value(x) <= 0.0) {
            return beam.when.clone();
        }
        polygon::clip(&beam.when, [meets])
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
    fn reflects(&self, face: &Face, beam: &Leaf) -> Option<bool> {
        if self.rules.reflects_only_totally() {
            self.is_total(face, beam)
        } else {
            Some(true)
        }
    }

    /// Returns whether the front `face` sends all light of all directions of the patch back inside,
    /// or lets some out in all of them; `None` if it may differ.
    fn sends_back(&self, face: &Face, beam: &Leaf) -> Option<bool> {
        if self.rules.follows_the_front() {
            self.is_total(face, beam)
        } else {
            Some(false)
        }
    }

    /// Returns whether light of all directions of the patch is reflected totally by `face`, or
    /// none; `None` if it may differ.
    ///
    /// Light along (tau, -1) is reflected totally if its cosine c from the normal has c^2 < 1 -
    /// 1/n^2. Over the length 1 / cos(incidence) of that vector, c is affine in tau.
    fn is_total(&self, face: &Face, beam: &Leaf) -> Option<bool> {
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

    /// Returns the half-planes of the entry points whose light goes through `face`, moved by
    /// `step`.
    ///
    /// Where the light meets the inside of the face, its outline runs counter-clockwise. (An odd
    /// number of reflections turns it over.) Elsewhere it runs the other way, and the half-planes
    /// outside of a polygon have no point in common. So the lines claim no light that is not there,
    /// also for directions that [`Leaf::when`] leaves out.
    fn lines(&self, face: &Face, step: DVec2, beam: &Leaf) -> Vec<Moving> {
        let fold = beam.linear.transpose();
        let way = step.extend(0.0) - beam.shift;
        let corners = face.corners.iter().map(|&x| fold * (x + way));
        let mut corners: Vec<DVec3> = corners.collect();
        if beam.met.len() % 2 == 1 {
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
        let (deep, deeper) = (self.height - p.z, p.z - q.z);
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
