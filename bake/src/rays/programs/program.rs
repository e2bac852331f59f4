//! Program of one direction of a small planar cell, which every ray runs.
//!
//! All rays of a direction are parallel, also after any given sequence of facets. Unfolded at the
//! facets, the line of a ray is an affine function of its entry point. So the question whether a
//! ray passes an edge on the inner side is the sign of an affine function. A [`Program`] is the
//! tree of all sequences that can happen, flattened. Each node holds the facets ahead, front to
//! back, with the edges that a ray there can still miss. Each end of the tree holds a fate. Every
//! ray is decided by its own tests. Only tests that no entry point of a node can fail are left out.
//! Whatever is the same for a whole direction (normals, lines, maps) is computed once.
//!
//! Some cells do not fit: cells of many facets, cells whose facets pierce each other or hide each
//! other in a circle, and periodic cells in directions in which light runs far along the sheet. For
//! them `Program::new` returns `None`, and they are traced facet by facet.

mod ahead;

use crate::geometry::centres_below;
use crate::optics::{
    BOUNCE_LIMIT, Incidence, PolarisedLight, Rules, Triangle, fate_of_leaving, reflect, reflection,
};
use crate::rays::accumulator::Bins;
use crate::rays::programs::program::ahead::{FacetAhead, Taken};
use crate::rays::programs::region::{Affine, ROUNDING, Region};
use crate::rays::scene::Scene;
use glam::{DMat3, DVec2, DVec3};
use tables::Fate;

/// Largest number of steps of a program; beyond it, tracing facet by facet is about as fast.
const STEPS: usize = 512;

/// Largest depth of the tree, which is the number of masks that a vector of rays keeps.
pub(crate) const DEPTH: usize = 24;

// No program is as deep as the limit of reflections, so no step tests for it.
const _: () = assert!(DEPTH <= BOUNCE_LIMIT as usize);

/// Largest deviation that is rounding. Light with such deviations leaves straight back.
const STRAIGHT: f64 = 1e-12;

/// Largest difference of bin positions between two maps that count as one.
///
/// It is above the rounding errors of both maps, so maps that differ by rounding alone are one.
const SAME_BIN_POSITION: f64 = 1e-10;

/// End of the rays that a step takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum End {
    /// The rays go on, and the steps that follow are about them.
    Onward,
    /// The rays end with a fate other than retroreflected.
    Fate(Fate),
    /// The rays are retroreflected, shifted by the map of this number.
    Shift(usize),
}

/// Step of a program: it takes those of the rays left at depth `from` that pass all its tests.
///
/// If the rays go on, they are then left at the depth `from + 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    /// Depth in the tree.
    pub from: usize,
    /// Range of the step's tests in [`Program::tests`]; an empty range takes all rays that are
    /// left.
    pub tests: (usize, usize),
    /// End of the rays that the step takes.
    pub end: End,
    /// Loss before that end; `None` without losses.
    pub loss: Option<Loss>,
}

/// Loss of photons, at a surface or at the front face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Loss {
    /// Power that is left after it, as a share of the launched power. A photon goes on if its
    /// chance is below.
    pub power: f64,
    /// Fate of the other photons.
    pub fate: Fate,
}

/// Program of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Program {
    /// Steps; each node comes before its children.
    pub steps: Vec<Step>,
    /// Tests of all steps; a ray passes a test if its value is not negative.
    pub tests: Vec<Affine>,
    /// Bin positions (u, v) as functions of the entry point.
    pub maps: Vec<[Affine; 2]>,
    /// Deviation of the light of each map, as [`Incidence::deviation`] gives it.
    pub deviations: Vec<DVec2>,
    /// Loss at the front face on the way in; `None` without losses.
    pub entry: Option<Loss>,
}

impl Program {
    /// Makes the program for rays along `direction`, or returns `None` if the cell does not fit.
    ///
    /// The rays enter in the convex parts `entry`.
    pub(crate) fn new(
        scene: &Scene,
        entry: Vec<Vec<DVec2>>,
        rules: &Rules,
        direction: &Incidence,
        bins: &Bins,
    ) -> Option<Self> {
        let index = rules.refractive_index;
        let light = rules
            .losses
            .map(|_| PolarisedLight::entered(direction.travel, index));
        let root = UnfoldedRay {
            light,
            direction: direction.travel,
            map: DMat3::IDENTITY,
            offset: DVec3::ZERO,
            start: Affine {
                x: 0.0,
                y: 0.0,
                one: 0.0,
            },
        };
        let program = Program {
            steps: Vec::new(),
            tests: Vec::new(),
            maps: Vec::new(),
            deviations: Vec::new(),
            entry: light.map(|light| Loss {
                power: light.power(),
                fate: Fate::ReflectedByFront,
            }),
        };
        let mut builder = Builder {
            scene,
            rules,
            direction,
            bins,
            program,
        };
        builder.node(&root, 0, entry)?;
        Some(builder.program)
    }
}

/// Line of a ray, unfolded at the facets that it has met.
///
/// A point of the line is `map` (p.x, p.y, height) + `offset` + distance x `direction`.
struct UnfoldedRay {
    /// Polarised light of the path; `None` without losses.
    light: Option<PolarisedLight>,
    direction: DVec3,
    /// Linear map of the reflections so far.
    map: DMat3,
    offset: DVec3,
    /// Distance along the line at which the ray is now, edge lengths.
    start: Affine,
}

impl UnfoldedRay {
    /// Returns `vector` . (position at distance 0) as a function of the entry point.
    fn along(&self, vector: DVec3, height: f64) -> Affine {
        let [x, y, z] =
            [self.map.x_axis, self.map.y_axis, self.map.z_axis].map(|column| vector.dot(column));
        Affine {
            x,
            y,
            one: z * height + vector.dot(self.offset),
        }
    }

    /// Returns the distance at which the line passes the edge from `a` to `b`, seen along the ray.
    ///
    /// The distance is in edge lengths. It is positive on the left of the edge, where the inside of
    /// a facet lies whose corners run counter-clockwise as the ray sees them. For the edge from `b`
    /// to `a` it is exactly minus this value. Returns `None` if the ray sees the edge end-on.
    fn beside(&self, a: DVec3, b: DVec3, height: f64) -> Option<Affine> {
        let swapped = a.to_array() > b.to_array();
        let (low, high) = if swapped { (b, a) } else { (a, b) };
        let sideways = (high - low).cross(self.direction);
        let length = sideways.length();
        let position = self.along(sideways, height);
        let side = Affine {
            one: position.one - sideways.dot(low),
            ..position
        };
        let side = side.times(1.0 / length).as_distance();
        (length > ROUNDING).then(|| side.times(if swapped { -1.0 } else { 1.0 }))
    }

    /// Returns the distance along the line to the plane of `facet`.
    fn distance(&self, facet: &Triangle, height: f64) -> Affine {
        let cosine = self.direction.dot(facet.normal);
        let position = self.along(facet.normal, height);
        Affine {
            one: position.one - facet.normal.dot(facet.corners[0]),
            ..position
        }
        .times(-1.0 / cosine)
    }
}

struct Builder<'a> {
    scene: &'a Scene,
    rules: &'a Rules,
    direction: &'a Incidence,
    bins: &'a Bins,
    program: Program,
}

impl Builder<'_> {
    /// Adds the steps of the rays that enter in `region` and are on `line` after `bounces`
    /// reflections.
    ///
    /// Returns `None` if the cell does not fit.
    fn node(&mut self, line: &UnfoldedRay, bounces: usize, region: Region) -> Option<()> {
        let (hits, left) = self.hits(line, region)?;
        for Taken {
            facet,
            tests,
            region,
        } in hits
        {
            self.hit(line, bounces, &facet, tests, region)?;
        }
        if left.is_empty() {
            return Some(());
        }
        let travel = self.direction.travel;
        let fate = fate_of_leaving(line.map, travel, bounces as u32, self.rules);
        let end = if fate == Fate::Retroreflected {
            End::Shift(self.map(line))
        } else {
            End::Fate(fate)
        };
        let loss = line.light.map(|light| Loss {
            power: light.power_outside(line.direction, self.rules.refractive_index),
            fate: Fate::Trapped,
        });
        self.step(bounces, Vec::new(), end, loss)
    }

    /// Adds the step onto a facet, and the steps that follow from it.
    fn hit(
        &mut self,
        line: &UnfoldedRay,
        bounces: usize,
        next: &FacetAhead,
        tests: Vec<Affine>,
        region: Region,
    ) -> Option<()> {
        let facet = next.facet;
        let cosine = line.direction.dot(facet.normal);
        if cosine > 0.0 {
            return self.step(bounces, tests, End::Fate(Fate::Absorbed), None);
        }
        if self.rules.lets_through(cosine) {
            return self.step(bounces, tests, End::Fate(Fate::Transmitted), None);
        }
        let index = self.rules.refractive_index;
        let surface = self.rules.losses.as_ref();
        let reflected = line.light.zip(surface).map(|(light, surface)| {
            let light = light.reflected(line.direction, facet.normal, surface, index);
            (light, surface.takes())
        });
        // Total reflection takes no photon: no chance lies between the powers before and after it,
        // which are equal but for rounding.
        let before = line.light.map_or(0, |light| centres_below(light.power()));
        let loss = reflected
            .map(|(light, fate)| Loss {
                power: light.power(),
                fate,
            })
            .filter(|loss| centres_below(loss.power) < before);
        self.step(bounces, tests, End::Onward, loss)?;
        let mirror = reflection(facet.normal);
        let after = UnfoldedRay {
            light: reflected.map(|(light, _)| light),
            direction: reflect(line.direction, facet.normal),
            map: mirror * line.map,
            // The reflection is x -> x - 2 n (n . (x - corner)).
            offset: mirror * line.offset
                + facet.normal * (2.0 * facet.normal.dot(facet.corners[0])),
            start: next.distance,
        };
        self.node(&after, bounces + 1, region)
    }

    /// Adds one step, or returns `None` if the program has become too long or too deep.
    fn step(
        &mut self,
        from: usize,
        tests: Vec<Affine>,
        end: End,
        loss: Option<Loss>,
    ) -> Option<()> {
        let first = self.program.tests.len();
        self.program.tests.extend(tests);
        self.program.steps.push(Step {
            from,
            tests: (first, self.program.tests.len()),
            end,
            loss,
        });
        (self.program.steps.len() <= STEPS && from + 1 < DEPTH).then_some(())
    }

    /// Returns the number of the map from entry points to bin positions of rays that leave along
    /// `line`.
    fn map(&mut self, line: &UnfoldedRay) -> usize {
        let height = self.scene.height();
        let d = line.direction;
        // At the distance t = (height - z) / d.z the ray is back on the entrance plane, at the
        // point p' = xy + t d.xy.
        let exit = |axis: DVec2| {
            let inward = axis.extend(-axis.dot(d.truncate()) / d.z);
            let position = line.along(inward, height);
            let shift = Affine {
                x: position.x - axis.x,
                y: position.y - axis.y,
                one: position.one - inward.z * height,
            };
            let scaled = shift.times(self.bins.density);
            Affine {
                one: scaled.one + self.bins.count as f64 / 2.0,
                ..scaled
            }
        };
        let map = [exit(self.direction.u), exit(self.direction.v())];
        let near = |known: &[Affine; 2]| {
            known.iter().zip(&map).all(|(a, b)| {
                let Affine { x, y, one } = a.minus(b);
                x.abs().max(y.abs()).max(one.abs()) < SAME_BIN_POSITION
            })
        };
        let deviation = self.direction.deviation(d, self.rules.refractive_index);
        let as_straight =
            |known: DVec2| known == deviation || known.length().max(deviation.length()) < STRAIGHT;
        let Program {
            maps, deviations, ..
        } = &mut self.program;
        let known = maps.iter().zip(deviations.iter());
        let same = |(map, &off): (&[Affine; 2], &DVec2)| near(map) && as_straight(off);
        known.map(same).position(|same| same).unwrap_or_else(|| {
            maps.push(map);
            deviations.push(deviation);
            maps.len() - 1
        })
    }
}
