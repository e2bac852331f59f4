//! One direction of a small planar cell as a short program that every ray runs.
//!
//! All rays of a direction share their direction of travel, also after any given sequence of
//! facets. Unfolded at the facets, the line of a ray is then an affine function of its entry point,
//! and "does it pass this edge on the inner side" is the sign of one. A [`Program`] is the tree of
//! all sequences that can happen, flattened: at each node the facets ahead, front to back, each
//! with the edges that a ray there can still miss, and at each end a fate. Every ray is decided by
//! its own tests; only tests that no entry point of a node can fail are left out, and what can be
//! known for a whole direction (normals, lines, maps) is computed once.
//!
//! Which tests can fail is found by cutting the entrance along the tests. A facet that takes all
//! that is left of a node gets no test at all, so a ray through a shared edge or an apex goes to
//! one facet or the other, never between.
//!
//! Cells that do not fit (periodic, many facets, facets that pierce each other or hide each other
//! in a circle) have no program and are traced facet by facet: `Program::new` returns `None`.

use crate::cell::PROGRAM_FACETS;
use crate::optics::{
    BOUNCE_LIMIT, Incidence, Rules, Triangle, fate_of_leaving, reflect, reflection,
};
use crate::rays::bins::Bins;
use crate::rays::scene::Scene;
use glam::{DMat3, DVec2, DVec3};
use tables::Fate;

/// Steps of a program at most: beyond, tracing facet by facet is about as fast.
const STEPS: usize = 512;

/// Depth of the tree at most: masks that a bundle of rays keeps.
pub(crate) const DEPTH: usize = 24;

/// Distances below this count as rounding when tests are left out, edge lengths.
const ROUNDING: f64 = 1e-12;

/// Parts of the entrance smaller than this are empty, square edge lengths.
const SPECK: f64 = 1e-13;

/// Two maps whose bin positions differ by less than this are one: below the rounding of either.
const SAME_BIN_POSITION: f64 = 1e-10;

/// An affine function of the entry point: `x` p.x + `y` p.y + `one`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Affine {
    /// Coefficient of p.x.
    pub x: f64,
    /// Coefficient of p.y.
    pub y: f64,
    /// Constant.
    pub one: f64,
}

impl Affine {
    /// Its value at `p`.
    #[inline(always)]
    pub(crate) fn at(&self, p: DVec2) -> f64 {
        self.x * p.x + self.y * p.y + self.one
    }

    fn minus(&self, other: &Affine) -> Affine {
        Affine {
            x: self.x - other.x,
            y: self.y - other.y,
            one: self.one - other.one,
        }
    }

    /// The same sign everywhere, as a distance from the line where it is 0, edge lengths.
    fn as_distance(&self) -> Affine {
        let slope = self.x.hypot(self.y);
        if slope > ROUNDING {
            self.times(1.0 / slope)
        } else {
            *self
        }
    }

    fn times(&self, factor: f64) -> Affine {
        Affine {
            x: self.x * factor,
            y: self.y * factor,
            one: self.one * factor,
        }
    }
}

/// What becomes of the rays that a step takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum End {
    /// They go on: the steps that follow are about them.
    Onward,
    /// They end with a fate other than retroreflected.
    Fate(Fate),
    /// They are retroreflected, shifted by this map.
    Shift(usize),
}

/// Takes, of the rays left at `from`, those that pass all its tests; they are left at `from + 1`
/// where they go on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    /// Depth in the tree.
    pub from: usize,
    /// Its tests: positions in [`Program::tests`]. None: takes all that are left.
    pub tests: (usize, usize),
    /// What becomes of them.
    pub end: End,
}

/// The program of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Program {
    /// Steps, each node before its children.
    pub steps: Vec<Step>,
    /// Tests of all steps: a ray passes where the value is not negative.
    pub tests: Vec<Affine>,
    /// Bin positions (u, v) as functions of the entry point.
    pub maps: Vec<[Affine; 2]>,
}

impl Program {
    /// The program for rays along `direction` that enter in the convex parts `entry`, or `None`
    /// where the cell does not fit.
    pub(crate) fn new(
        scene: &Scene,
        entry: Vec<Vec<DVec2>>,
        rules: &Rules,
        direction: &Incidence,
        bins: &Bins,
    ) -> Option<Self> {
        if scene.is_periodic() || scene.facets().len() > PROGRAM_FACETS {
            return None;
        }
        let root = UnfoldedRay {
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

/// The part of a program that rays from one small part of the entrance can need.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Excerpt {
    /// Steps that such rays can take.
    pub steps: Vec<Step>,
    /// Their tests, those left out that all such rays pass.
    pub tests: Vec<Affine>,
}

impl Excerpt {
    /// Takes the part of `program` for rays that enter between `corners` (their convex hull).
    pub(crate) fn refill(&mut self, program: &Program, corners: &[DVec2]) {
        self.steps.clear();
        self.tests.clear();
        // Whether an earlier step of the node at that depth takes all its rays.
        let mut closed = [false; DEPTH];
        // Steps deeper than this belong to a step that no ray takes.
        let mut skipped = usize::MAX;
        for step in &program.steps {
            if step.from > skipped {
                continue;
            }
            skipped = usize::MAX;
            let first = self.tests.len();
            let mut taken = !closed[step.from];
            for test in &program.tests[step.tests.0..step.tests.1] {
                let values = corners.iter().map(|&corner| test.at(corner));
                let (least, most) = values
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), value| {
                        (l.min(value), m.max(value))
                    });
                taken &= most > -ROUNDING;
                if least < ROUNDING {
                    self.tests.push(*test);
                }
            }
            if !taken {
                self.tests.truncate(first);
                skipped = step.from;
                continue;
            }
            closed[step.from] = self.tests.len() == first;
            closed[step.from + 1] = false;
            self.steps.push(Step {
                tests: (first, self.tests.len()),
                ..*step
            });
        }
    }
}

/// The line of a ray, unfolded: position = `map` (p.x, p.y, height) + `offset` + distance x
/// `direction`.
struct UnfoldedRay {
    direction: DVec3,
    /// Linear map of the reflections so far.
    map: DMat3,
    offset: DVec3,
    /// Distance along the line at which the ray is now.
    start: Affine,
}

impl UnfoldedRay {
    /// `vector` . (position at distance 0) as a function of the entry point.
    fn along(&self, vector: DVec3, height: f64) -> Affine {
        let [x, y, z] =
            [self.map.x_axis, self.map.y_axis, self.map.z_axis].map(|column| vector.dot(column));
        Affine {
            x,
            y,
            one: z * height + vector.dot(self.offset),
        }
    }

    /// How far the line passes the edge from `a` to `b`, seen along the ray, edge lengths: positive
    /// on the left, where the inside of a facet is whose corners run counter-clockwise as the ray
    /// sees them. Exactly opposite for the edge from `b` to `a`. `None` for an edge seen end-on.
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

    /// Distance along the line to the plane of `facet`.
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

/// Convex parts of the entrance.
type Region = Vec<Vec<DVec2>>;

/// A facet ahead of the rays of a node.
struct FacetAhead {
    facet: Triangle,
    tests: Vec<Affine>,
    distance: Affine,
    region: Region,
}

struct Builder<'a> {
    scene: &'a Scene,
    rules: &'a Rules,
    direction: &'a Incidence,
    bins: &'a Bins,
    program: Program,
}

impl Builder<'_> {
    /// Adds the steps of the rays that enter in `region` and are now on `line` after `bounces`
    /// reflections.
    fn node(&mut self, line: &UnfoldedRay, bounces: usize, region: Region) -> Option<()> {
        let mut ahead = self.ahead(line, &region)?;
        let mut left = region;
        while !ahead.is_empty() && !left.is_empty() {
            let next = ahead.swap_remove(foremost(&ahead)?);
            let (inside, outside) = split(&left, &next.tests);
            if inside.is_empty() {
                continue;
            }
            let tests = if outside.is_empty() {
                Vec::new()
            } else {
                needed(&left, &next.tests)
            };
            // A step without a test takes all rays: what is outside then is a strip no wider than
            // rounding.
            left = if tests.is_empty() {
                Vec::new()
            } else {
                outside
            };
            self.hit(line, bounces, &next, tests, inside)?;
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
        self.step(bounces, Vec::new(), end)
    }

    /// The facets that rays of `region` on `line` can meet.
    fn ahead(&self, line: &UnfoldedRay, region: &Region) -> Option<Vec<FacetAhead>> {
        let height = self.scene.height();
        let mut ahead = Vec::new();
        for facet in self.scene.facets() {
            let cosine = line.direction.dot(facet.normal);
            if cosine.abs() < ROUNDING {
                continue;
            }
            let [a, b, c] = facet.corners;
            let [b, c] = if cosine < 0.0 { [b, c] } else { [c, b] };
            let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| line.beside(from, to, height));
            let [Some(ab), Some(bc), Some(ca)] = edges else {
                return None;
            };
            let mut tests = vec![ab, bc, ca];
            let distance = line.distance(facet, height);
            let lead = distance.minus(&line.start);
            let (inside, _) = split(region, &tests);
            let (least, most) = extent(&inside, &lead);
            // Rounding of a distance grows as 1/cosine.
            let rounding = ROUNDING / cosine.abs();
            if inside.is_empty() || most <= rounding {
                continue;
            }
            if least < -rounding {
                tests.push(lead.as_distance());
            }
            let (region, _) = split(region, &tests);
            ahead.push(FacetAhead {
                facet: *facet,
                tests,
                distance,
                region,
            });
        }
        Some(ahead)
    }

    /// Adds the step onto a facet, and those that follow from it.
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
            return self.step(bounces, tests, End::Fate(Fate::Absorbed));
        }
        if bounces as u32 == BOUNCE_LIMIT {
            return self.step(bounces, tests, End::Fate(Fate::BounceLimit));
        }
        if self.rules.lets_through(cosine) {
            return self.step(bounces, tests, End::Fate(Fate::Transmitted));
        }
        self.step(bounces, tests, End::Onward)?;
        let mirror = reflection(facet.normal);
        let after = UnfoldedRay {
            direction: reflect(line.direction, facet.normal),
            map: mirror * line.map,
            // x -> x - 2 n (n . (x - corner))
            offset: mirror * line.offset
                + facet.normal * (2.0 * facet.normal.dot(facet.corners[0])),
            start: next.distance,
        };
        self.node(&after, bounces + 1, region)
    }

    fn step(&mut self, from: usize, tests: Vec<Affine>, end: End) -> Option<()> {
        let first = self.program.tests.len();
        self.program.tests.extend(tests);
        self.program.steps.push(Step {
            from,
            tests: (first, self.program.tests.len()),
            end,
        });
        (self.program.steps.len() <= STEPS && from + 1 < DEPTH).then_some(())
    }

    /// The bin position of rays that leave along `line`.
    fn map(&mut self, line: &UnfoldedRay) -> usize {
        let height = self.scene.height();
        let d = line.direction;
        // At distance t = (height - z) / d.z the ray is back on the entrance plane: p' = xy + t
        // d.xy.
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
        self.program.maps.iter().position(near).unwrap_or_else(|| {
            self.program.maps.push(map);
            self.program.maps.len() - 1
        })
    }
}

/// The facet that no other one hides anywhere. `None` where two pierce each other or all hide each
/// other in a circle.
fn foremost(ahead: &[FacetAhead]) -> Option<usize> {
    let mut candidate = None;
    for (i, front) in ahead.iter().enumerate() {
        let mut hidden = false;
        for (_, back) in ahead.iter().enumerate().filter(|(j, _)| *j != i) {
            let (both, _) = split(&front.region, &back.tests);
            let (least, most) = extent(&both, &back.distance.minus(&front.distance));
            if least < -1e-9 && most > 1e-9 {
                return None;
            }
            hidden |= least < -1e-9;
        }
        if !hidden && candidate.is_none() {
            candidate = Some(i);
        }
    }
    candidate
}

/// The parts of `region` where all `tests` pass, and where one fails.
fn split(region: &Region, tests: &[Affine]) -> (Region, Region) {
    let mut inside = region.clone();
    let mut outside = Vec::new();
    for test in tests {
        outside.extend(
            inside
                .iter()
                .map(|part| clip(part, &test.times(-1.0)))
                .filter(|part| !is_speck(part)),
        );
        inside = inside
            .iter()
            .map(|part| clip(part, test))
            .filter(|part| !is_speck(part))
            .collect();
    }
    (inside, outside)
}

/// Those of `tests` that a ray of `region` can fail when it passes the others.
fn needed(region: &Region, tests: &[Affine]) -> Vec<Affine> {
    let mut kept = tests.to_vec();
    let mut i = 0;
    while i < kept.len() {
        let test = kept.remove(i);
        let (inside, _) = split(region, &kept);
        if extent(&inside, &test).0 < -ROUNDING {
            kept.insert(i, test);
            i += 1;
        }
    }
    kept
}

/// Least and greatest value of `function` over the corners of `region`; (inf, -inf) for an empty
/// one.
fn extent(region: &Region, function: &Affine) -> (f64, f64) {
    region
        .iter()
        .flatten()
        .map(|&corner| function.at(corner))
        .fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(least, most), value| (least.min(value), most.max(value)),
        )
}

/// The part of a convex polygon where `test` is not negative.
fn clip(polygon: &[DVec2], test: &Affine) -> Vec<DVec2> {
    let on = |p: DVec2, q: DVec2, part: f64| p + (q - p) * part;
    tables::polygon::clip(polygon, |p| -test.at(p), on)
}

fn is_speck(polygon: &[DVec2]) -> bool {
    let doubled: f64 = (1..polygon.len().saturating_sub(1))
        .map(|i| (polygon[i] - polygon[0]).perp_dot(polygon[i + 1] - polygon[0]))
        .sum();
    doubled.abs() < 2.0 * SPECK
}
