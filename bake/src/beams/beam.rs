//! Follows beams: which part of a beam meets which facet.
//!
//! A beam is a convex polygon of entry points whose light has met the same facets in the same
//! order. Each step cuts the beam into the parts that meet each facet first. The part that meets no
//! facet leaves. Areas are areas of entry points. A reflection therefore changes no area, and the
//! areas of the parts of a beam sum to the area of the beam.

mod fates;

use glam::{DMat2, DVec2, DVec3};
use tables::{Cube, Fate, Jones};

use crate::beams::candidate::Candidate;
use crate::beams::exact::{bounds_of_all, total_area, without};
use crate::beams::view::{Depth, Flight, Isometry, Shadow, View};
use crate::geometry::{Polygon, polygon};
use crate::optics::{PolarisedLight, Rules, element};

/// First distance within which a beam looks for lattice copies, edge lengths. If it is too short,
/// the beam looks four times further, again and again.
const FIRST_LOOK: f64 = 4.0;
/// Last distance within which a beam looks for lattice copies, edge lengths. Light that is still
/// under way after it runs along a valley of the lattice, within 0.005 deg of the sheet. Its fate
/// is `bounce_limit`.
const LAST_LOOK: f64 = 16384.0;

/// Greatest product of two normals of a cube, the sine of its dihedral error (5.7 degrees).
const MOST_SKEW: f64 = 0.1;

/// Retroreflected light of one sequence of facets.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LitPiece {
    /// Polygon of entry points, incidence frame, edge lengths.
    pub polygon: Polygon,
    /// Linear part of the ray shift: shift = matrix p + offset for the entry point p.
    pub matrix: DMat2,
    /// Constant part of the ray shift, edge lengths.
    pub offset: DVec2,
    /// Share of the launched power that is retroreflected.
    pub weight: f64,
    /// Amplitudes of polarised light; `None` if all facets are ideal mirrors, which keep it.
    pub jones: Option<Jones>,
    /// Deviation of the light, as in [`tables::Path::deviation`].
    pub deviation: DVec2,
    /// Number of times that the front face has sent the light back.
    pub passes: u32,
    /// Cube that returned the light, as in [`tables::Path::cube`].
    pub cube: Option<Cube>,
}

/// Pieces and fates of the light of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Followed {
    /// Retroreflected light.
    pub pieces: Vec<LitPiece>,
    /// Area times power by fate, square edge lengths, in the order of [`Fate::ALL`]. Retroreflected
    /// light is in `pieces` alone.
    pub area: [f64; Fate::ALL.len()],
    /// Net area of the slivers that were given up as rounding, square edge lengths.
    pub dropped: f64,
}

/// The history that all light of a beam shares: the facets that it has met.
#[derive(Clone, Copy)]
struct BeamCourse {
    isometry: Isometry,
    reflections: u32,
    /// Number of times that the front face has sent the light back.
    passes: u32,
    /// Normals of the first three facets, incidence frame; 0 before they are met.
    normals: [DVec3; 3],
    /// Polarised light of the path; `None` if all facets are ideal mirrors, which keep it.
    light: Option<PolarisedLight>,
    /// Whether the light loses power.
    is_lossy: bool,
}

impl BeamCourse {
    /// Returns the power that is left, as a share of the launched power.
    fn power(&self) -> f64 {
        let light = self.light.filter(|_| self.is_lossy);
        light.map_or(1.0, |light| light.power())
    }

    /// Returns the planes of the cube that has reflected the light, if it has met three at right angles
    /// and nothing else.
    fn cube(&self) -> Option<Cube> {
        let [a, b, c] = self.normals;
        let skew = [a.dot(b), b.dot(c), c.dot(a)].map(f64::abs);
        let is_corner = skew.into_iter().all(|skew| skew < MOST_SKEW);
        let only = self.reflections == 3 && self.passes == 0;
        (only && is_corner).then(|| self.normals.map(|normal| normal.to_array()))
    }

    /// Returns the power that passes the front face along `toward`, a direction inside the sheet,
    /// as a share of the launched power.
    fn power_outside(&self, toward: DVec3, index: f64) -> f64 {
        let light = self.light.filter(|_| self.is_lossy);
        light.map_or(1.0, |light| light.power_outside(toward, index))
    }
}

/// Light that has met the same facets in the same order and travels in one direction.
struct Beam {
    polygon: Polygon,
    course: BeamCourse,
    /// Depth of the facet that the beam leaves.
    depth: Depth,
}

/// The state with which a beam looks for the facets ahead of it.
struct Ahead<'a> {
    beam: &'a Beam,
    /// Corners of the beam at its start, real space.
    from: Vec<DVec3>,
    /// Direction of travel, unit length, real space.
    toward: DVec3,
    /// Distance to the end of the layer of facets, edge lengths.
    leave: f64,
    shadows: Vec<Shadow>,
}

/// Follows all light of one direction to its fate.
pub(crate) fn trace(view: &View, rules: &Rules) -> Followed {
    let mut tracer = Follower {
        view,
        rules,
        outcome: Followed {
            pieces: Vec::new(),
            area: [0.0; Fate::ALL.len()],
            dropped: 0.0,
        },
        pending: Vec::new(),
    };
    tracer.enter();
    while let Some(beam) = tracer.pending.pop() {
        tracer.step(&beam);
    }
    tracer.outcome
}

/// The state of following all light of one direction: what is settled and what is under way.
struct Follower<'a> {
    view: &'a View,
    rules: &'a Rules,
    outcome: Followed,
    pending: Vec<Beam>,
}

impl Follower<'_> {
    /// Lights the first facets.
    ///
    /// A periodic cell is lit facet by facet and not parallelogram by parallelogram. The light of
    /// one facet of the base period is all its entry points, wherever they are. So no beam is cut
    /// at the sides of the parallelogram.
    fn enter(&mut self) {
        let view = self.view;
        let index = self.rules.refractive_index;
        let course = BeamCourse {
            isometry: Isometry::IDENTITY,
            reflections: 0,
            passes: 0,
            normals: [DVec3::ZERO; 3],
            light: match self.rules.losses {
                Some(_) => Some(PolarisedLight::entered(view.direction, index)),
                None if self.rules.mirror_back => None,
                None => Some(PolarisedLight::whole(view.direction)),
            },
            is_lossy: self.rules.losses.is_some(),
        };
        let power = course.power();
        self.settle(view.entrance_area * (1.0 - power), Fate::ReflectedByFront);
        let mut lit = 0.0;
        let base = view.shadows(&course.isometry);
        let periodic = view.lattice.is_some();
        for shadow in &base {
            let openings: &[Polygon] = if periodic {
                std::slice::from_ref(&shadow.outline)
            } else {
                &view.openings
            };
            for opening in openings {
                let Some(candidate) =
                    Candidate::new(shadow.clone(), opening, None, view.least_area)
                else {
                    continue;
                };
                for polygon in self.lit_parts(&candidate, &base) {
                    lit += polygon::area(&polygon);
                    self.hit(&candidate.shadow, polygon, &course);
                }
            }
        }
        let unlit = view.entrance_area - lit;
        match element::unmet(self.rules.element) {
            Fate::Missed => self.settle(unlit * power, Fate::Missed),
            through => {
                let outside = course.power_outside(view.direction, index);
                self.settle(unlit * (power - outside), Fate::Trapped);
                self.settle(unlit * outside, through);
            }
        }
    }

    /// Returns the parts of a facet that light reaches: the facet less what other facets hide.
    fn lit_parts(&self, candidate: &Candidate, base: &[Shadow]) -> Vec<Polygon> {
        let view = self.view;
        let mut parts = vec![candidate.visible.clone()];
        let mut look = FIRST_LOOK;
        loop {
            let points: Vec<DVec3> = parts
                .iter()
                .flatten()
                .map(|&p| view.point(p, candidate.shadow.depth.at(p)))
                .collect();
            let leave = view.travel_to_leave(&points, -view.direction);
            let (low, high) = bounds_of_all(&parts);
            let flight = Flight {
                isometry: &Isometry::IDENTITY,
                from: &points,
                toward: -view.direction,
                travel: leave.min(look),
            };
            for shadow in base {
                view.copies(shadow, &flight, |step| {
                    if shadow.may_touch(step, low, high) {
                        self.hide(&mut parts, candidate, shadow.moved(step));
                    }
                });
            }
            if parts.is_empty() || view.lattice.is_none() || leave <= look || look >= LAST_LOOK {
                return parts;
            }
            look *= 4.0;
        }
    }

    /// Removes from the parts of a lit facet what `shadow` hides.
    fn hide(&self, parts: &mut Vec<Polygon>, candidate: &Candidate, shadow: Shadow) {
        if (shadow.facet, shadow.translation) == (candidate.shadow.facet, DVec3::ZERO) {
            return;
        }
        let least = self.view.least_area;
        // Of two facets that coincide exactly only the first is lit.
        let first =
            (shadow.facet, shadow.translation.to_array()) < (candidate.shadow.facet, [0.0; 3]);
        let tie = if first {
            self.view.least_depth
        } else {
            -self.view.least_depth
        };
        let mut cut = Vec::new();
        for part in std::mem::take(parts) {
            let Some(blocker) = Candidate::new(shadow.clone(), &part, None, least) else {
                cut.push(part);
                continue;
            };
            if blocker.near > candidate.far {
                cut.push(part);
                continue;
            }
            match polygon::subtract(
                &part,
                &blocker.hiding(&candidate.shadow.depth, None, tie),
                least,
            ) {
                None => cut.push(part),
                Some(rest) => cut.extend(rest.into_iter().filter(|p| polygon::area(p) > least)),
            }
        }
        *parts = cut;
    }

    /// Cuts a beam by the facets that it meets next, and sends the parts on.
    fn step(&mut self, beam: &Beam) {
        let view = self.view;
        let isometry = &beam.course.isometry;
        let toward = isometry.linear * view.direction;
        let from: Vec<DVec3> = beam
            .polygon
            .iter()
            .map(|&p| isometry.linear * view.point(p, beam.depth.at(p)) + isometry.shift)
            .collect();
        let ahead = Ahead {
            beam,
            toward,
            leave: view.travel_to_leave(&from, toward),
            from,
            shadows: view.shadows(isometry),
        };
        let mut open = vec![beam.polygon.clone()];
        let mut look = FIRST_LOOK;
        while !open.is_empty() {
            let candidates = self.candidates(&ahead, &open, look);
            open = open
                .iter()
                .zip(&candidates)
                .flat_map(|(part, candidates)| self.cut(&ahead, part, candidates, look))
                .collect();
            look *= 4.0;
        }
    }

    /// Returns the facets within the distance `look` of the start of the beam, for each of its
    /// `parts`.
    fn candidates(&self, ahead: &Ahead, parts: &[Polygon], look: f64) -> Vec<Vec<Candidate>> {
        let Ahead { beam, toward, .. } = *ahead;
        let view = self.view;
        let boxes: Vec<_> = parts.iter().map(|part| polygon::bounds(part)).collect();
        let mut candidates: Vec<Vec<Candidate>> = parts.iter().map(|_| Vec::new()).collect();
        let flight = Flight {
            isometry: &beam.course.isometry,
            from: &ahead.from,
            toward,
            travel: ahead.leave.min(look),
        };
        for shadow in &ahead.shadows {
            view.copies(shadow, &flight, |step| {
                for (i, &(low, high)) in boxes.iter().enumerate() {
                    if shadow.may_touch(step, low, high) {
                        let (copy, start) = (shadow.moved(step), Some(&beam.depth));
                        let candidate = Candidate::new(copy, &parts[i], start, view.least_area);
                        candidates[i].extend(candidate);
                    }
                }
            });
        }
        candidates
    }

    /// Sends the light of one part of a beam to the facets that it meets among its `candidates`.
    ///
    /// A facet that two parts see is a candidate of each part, so that it does not hide itself.
    /// Returns the parts of `part` that have to look further than `look`.
    fn cut(
        &mut self,
        ahead: &Ahead,
        part: &Polygon,
        candidates: &[Candidate],
        look: f64,
    ) -> Vec<Polygon> {
        let Ahead { beam, toward, .. } = *ahead;
        let view = self.view;
        let all_seen = view.lattice.is_none() || ahead.leave <= look || look >= LAST_LOOK;
        let mut visible = self.visible(candidates, &beam.depth);
        if !all_seen {
            // Beyond `look` an unseen copy may stand before these facets.
            visible.retain(|(i, polygon)| {
                let depth = &candidates[*i].shadow.depth;
                polygon
                    .iter()
                    .all(|&p| depth.at(p) - beam.depth.at(p) <= look)
            });
        }
        let seen: f64 = visible.iter().map(|(_, seen)| polygon::area(seen)).sum();
        let rest = polygon::area(part) - seen;
        let power = beam.course.power();
        let mut open = Vec::new();
        if rest.abs() <= view.least_area {
            self.outcome.dropped += rest * power;
        } else if !all_seen {
            open = without(part, &visible, view.least_area);
            self.outcome.dropped += (rest - total_area(&open)) * power;
        } else if ahead.leave > look && view.lattice.is_some() {
            self.settle(rest * power, Rules::given_up(beam.course.passes));
        } else {
            let parts = without(part, &visible, view.least_area);
            self.leave(beam, toward, parts, rest);
        }
        for (i, seen) in visible {
            let shadow = &candidates[i].shadow;
            self.hit(shadow, seen, &beam.course);
        }
        open
    }

    /// Returns the parts of the candidates that light reaches, each as (number of the candidate,
    /// convex part).
    fn visible(&self, candidates: &[Candidate], start: &Depth) -> Vec<(usize, Polygon)> {
        let least = self.view.least_area;
        let mut visible = Vec::new();
        for (i, candidate) in candidates.iter().enumerate() {
            let mut parts = vec![candidate.visible.clone()];
            for (j, blocker) in candidates.iter().enumerate() {
                if i == j || !blocker.may_hide(candidate) {
                    continue;
                }
                let tie = if j < i {
                    self.view.least_depth
                } else {
                    -self.view.least_depth
                };
                let hiding = blocker.hiding(&candidate.shadow.depth, Some(start), tie);
                let mut cut = Vec::new();
                for part in std::mem::take(&mut parts) {
                    match polygon::subtract(&part, &hiding, least) {
                        None => cut.push(part),
                        Some(rest) => {
                            cut.extend(rest.into_iter().filter(|p| polygon::area(p) > least));
                        }
                    }
                }
                parts = cut;
            }
            visible.extend(parts.into_iter().map(|part| (i, part)));
        }
        visible
    }
}
