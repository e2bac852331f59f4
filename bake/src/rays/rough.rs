//! Rays that rough facets turn one by one, 64 of them side by side.
//!
//! Every ray has a direction of its own, so a program cannot trace it. Here the lanes hold whole
//! rays. A step takes every ray to its nearest facet and past it. The lane of a ray that ends takes
//! the next ray, so that all lanes have work.
//!
//! The operations are those of [`crate::rays::path::trace`], in the same order, so every ray ends
//! as it does alone, bit for bit.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

use crate::geometry::{Launch, Stream, philox};
use crate::optics::{
    BOUNCE_LIMIT, Incidence, Quick, Ray, Rules, Triangle, mirrored, reflect, roughness, slack_after,
};
use crate::rays::accumulator::Accumulator;
use crate::rays::departures::{Departure, Departures};
use crate::rays::lane::{LANES, Mask, Reals, choose};
use crate::rays::lane::{digits, points};
use crate::rays::programs::lanes;
use crate::rays::scene::Scene;
use crate::rays::simd::Task;
use glam::{DMat3, DVec2, DVec3};
use std::ops::Range;
use std::sync::Arc;
use tables::Fate;
use tables::options::{Roughness, Slopes};

/// Samples to trace, and what they go through.
pub(crate) struct RoughBatch<'a> {
    /// Scenes that `launch` leads into, none of them periodic.
    pub scenes: &'a [Arc<Scene>],
    /// Map from samples to entry points.
    pub launch: &'a Launch,
    /// Rules by which facets change light: with roughness, without losses.
    pub rules: &'a Rules,
    /// Roughness of the facets.
    pub roughness: Roughness,
    /// Direction of launch and its frame.
    pub direction: &'a Incidence,
    /// Stream that the samples come from.
    pub stream: &'a Stream,
    /// Indices of the samples.
    pub samples: Range<u64>,
}

/// Sample of a batch: its index, and the point where its ray enters.
#[derive(Debug, Clone, Copy)]
struct RoughEntry {
    index: u64,
    point: DVec2,
}

/// Tracing of a batch; `departures` counts its rays in `accumulator`.
pub(crate) struct RoughTracing<'a> {
    /// Samples to trace.
    pub batch: &'a RoughBatch<'a>,
    /// Rays that have left the cell.
    pub departures: &'a mut Departures<'a>,
    /// Counts of the rays.
    pub accumulator: &'a mut Accumulator,
}

impl Task for RoughTracing<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        run(self.batch, self.departures, self.accumulator);
    }
}

/// Traces all samples of a batch; `departures` counts them in `accumulator`.
#[inline(always)]
fn run(batch: &RoughBatch, departures: &mut Departures, accumulator: &mut Accumulator) {
    for (scene, entries) in batch.scenes.iter().zip(entries(batch)) {
        departures.enter(scene);
        let faces = Faces::new(scene);
        let first = scene.enter(DVec2::ZERO, batch.direction.travel);
        let (mut rays, mut arriving) = (LaneRays::new(&first), LaneRays::new(&first));
        let mut waiting = entries.chunks(LANES);
        let mut fresh = 0..0;
        let mut free = u64::MAX;
        loop {
            while free != 0 {
                let Some(arrival) = fresh.next() else {
                    let Some(entries) = waiting.next() else { break };
                    arriving.fill(entries);
                    arriving.look(&faces);
                    fresh = 0..entries.len();
                    continue;
                };
                if arriving.distance[arrival] == UNMET {
                    departures.push(&arriving.departure(arrival), accumulator);
                } else {
                    rays.take(free.trailing_zeros() as usize, &arriving, arrival);
                    free &= free - 1;
                }
            }
            if free == u64::MAX {
                break;
            }
            let fates = rays.step(batch, &faces);
            let mut ended = ended(&fates) & !free;
            free |= ended;
            while ended != 0 {
                let lane = ended.trailing_zeros() as usize;
                ended &= ended - 1;
                if fates[lane] == OUT {
                    departures.push(&rays.departure(lane), accumulator);
                } else {
                    accumulator.fates[fates[lane] as usize] += 1;
                }
            }
        }
        departures.count(accumulator);
    }
}

/// Draws the samples of a batch; returns those of each scene.
#[inline(always)]
fn entries(batch: &RoughBatch) -> Vec<Vec<RoughEntry>> {
    let RoughBatch { launch, stream, .. } = *batch;
    let samples = batch.samples.clone();
    let mut entries = vec![Vec::new(); batch.scenes.len()];
    if lanes::sorts(launch) {
        for index in samples {
            let (scene, point) = launch.entry(stream, index);
            entries[scene].push(RoughEntry { index, point });
        }
        return entries;
    }
    for first in samples.clone().step_by(LANES) {
        let (a, b) = digits(stream, first);
        let count = (samples.end - first).min(LANES as u64) as usize;
        for piece in launch.pieces() {
            let (x, y, chosen) = points(piece, &a, &b);
            let of_scene = &mut entries[piece.scene];
            for lane in 0..count {
                if chosen[lane] >> 63 == 1 {
                    of_scene.push(RoughEntry {
                        index: first + lane as u64,
                        point: DVec2::new(x[lane], y[lane]),
                    });
                }
            }
        }
    }
    entries
}

/// Distance that stands for no facet.
const UNMET: f64 = Triangle::UNMET;

/// Number that stands for a ray which goes on; numbers below it are those of fates.
const ON: u64 = 1 << 32;

/// Number that stands for a ray which leaves the cell.
const OUT: u64 = ON - 1;

/// Returns the set of lanes whose rays do not go on, one bit for each.
#[inline(always)]
fn ended(fates: &Mask) -> u64 {
    let mut ended = 0;
    for lane in 0..LANES {
        ended |= u64::from(fates[lane] != ON) << lane;
    }
    ended
}

/// Facets of a scene, as the lanes see them.
struct Faces<'a> {
    facets: &'a [Triangle],
    quick: Vec<Quick>,
    reach: f64,
}

impl<'a> Faces<'a> {
    fn new(scene: &'a Scene) -> Self {
        let (facets, reach) = (scene.facets(), scene.reach());
        let quick = facets.iter().map(|facet| Quick::new(facet, reach));
        Faces {
            facets,
            quick: quick.collect(),
            reach,
        }
    }

    /// Returns the distance of the nearest facet of `ray`, [`UNMET`] without a facet, and the
    /// facet's normal.
    #[cold]
    fn nearest(&self, ray: &Ray) -> (f64, DVec3) {
        let mut nearest = (UNMET, DVec3::Z);
        for facet in self.facets {
            let distance = facet.reach(ray);
            if distance < nearest.0 {
                nearest = (distance, facet.normal);
            }
        }
        nearest
    }
}

/// Rays under way, one for each lane, with the facets ahead of them.
struct LaneRays {
    point: [Reals; 2],
    origin: [Reals; 3],
    travel: [Reals; 3],
    slack: Reals,
    map: [Reals; 9],
    bounces: Mask,
    index: Mask,
    /// Distance of the nearest facet, [`UNMET`] without a facet.
    distance: Reals,
    /// Unit normal of that facet.
    facet: [Reals; 3],
    grain: f64,
}

impl LaneRays {
    /// Makes lanes that all hold the ray `first`.
    #[inline(always)]
    fn new(first: &Ray) -> Self {
        LaneRays {
            point: [[0.0; LANES]; 2],
            origin: first.origin.to_array().map(|value| [value; LANES]),
            travel: first.direction.to_array().map(|value| [value; LANES]),
            slack: [first.slack; LANES],
            map: DMat3::IDENTITY.to_cols_array().map(|value| [value; LANES]),
            bounces: [0; LANES],
            index: [0; LANES],
            distance: [UNMET; LANES],
            facet: [[0.0; LANES], [0.0; LANES], [1.0; LANES]],
            grain: first.grain,
        }
    }

    /// Starts rays in the first lanes, where the rays have met no facet.
    #[inline(always)]
    fn fill(&mut self, entries: &[RoughEntry]) {
        for (lane, RoughEntry { index, point }) in entries.iter().enumerate() {
            (self.point[0][lane], self.point[1][lane]) = (point.x, point.y);
            (self.origin[0][lane], self.origin[1][lane]) = (point.x, point.y);
            self.index[lane] = *index;
        }
    }

    /// Takes ray `other` of `rays` into `lane`.
    #[inline(always)]
    fn take(&mut self, lane: usize, rays: &LaneRays, other: usize) {
        self.point[0][lane] = rays.point[0][other];
        self.point[1][lane] = rays.point[1][other];
        set(&mut self.origin, lane, get(&rays.origin, other));
        set(&mut self.travel, lane, get(&rays.travel, other));
        self.slack[lane] = rays.slack[other];
        for (entries, others) in self.map.iter_mut().zip(&rays.map) {
            entries[lane] = others[other];
        }
        self.bounces[lane] = rays.bounces[other];
        self.index[lane] = rays.index[other];
        self.distance[lane] = rays.distance[other];
        set(&mut self.facet, lane, get(&rays.facet, other));
    }

    /// Returns the ray of `lane`.
    #[inline(always)]
    fn ray(&self, lane: usize) -> Ray {
        Ray {
            origin: get(&self.origin, lane),
            direction: get(&self.travel, lane),
            slack: self.slack[lane],
            grain: self.grain,
        }
    }

    /// Returns the linear map of the ray of `lane`.
    #[inline(always)]
    fn map(&self, lane: usize) -> DMat3 {
        let [a, b, c, d, e, f, g, h, i] = &self.map;
        let [a, b, c] = [[a, b, c], [d, e, f], [g, h, i]]
            .map(|[x, y, z]| DVec3::new(x[lane], y[lane], z[lane]));
        DMat3::from_cols(a, b, c)
    }

    /// Returns the ray of `lane` as one that leaves.
    #[inline(always)]
    fn departure(&self, lane: usize) -> Departure {
        Departure {
            point: DVec2::new(self.point[0][lane], self.point[1][lane]),
            origin: get(&self.origin, lane),
            travel: get(&self.travel, lane),
            map: self.map(lane),
            bounces: self.bounces[lane],
        }
    }

    /// Takes every ray past the facet ahead of it, and finds the next one. Returns the fate of each
    /// ray as a number: [`ON`] if it goes on, [`OUT`] if it meets no further facet.
    ///
    /// The state of a ray that ends otherwise is lost.
    #[inline(always)]
    fn step(&mut self, batch: &RoughBatch, faces: &Faces) -> Mask {
        let drawn = self.drawn(batch);
        let rules = batch.rules;
        let total_only = rules.reflects_only_totally();
        let mut fates = [ON; LANES];
        for lane in 0..LANES {
            let ray = self.ray(lane);
            let (facet, normal) = (get(&self.facet, lane), get(&drawn, lane));
            let onward = reflect(ray.direction, normal);
            // The first reason to end counts, so it is asked last.
            let mut fate = ON;
            let mut ends = |condition: bool, of: u64| fate = if condition { of } else { fate };
            ends(onward.dot(facet) <= 0.0, Fate::Absorbed as u64);
            let through = !rules.reflects_totally(ray.direction.dot(normal));
            ends(total_only & through, Fate::Transmitted as u64);
            let limit = self.bounces[lane] == u64::from(BOUNCE_LIMIT);
            ends(limit, Fate::BounceLimit as u64);
            let along = ray.direction.dot(facet);
            ends(along >= 0.0, Fate::Absorbed as u64);
            fates[lane] = fate;
            let way = self.distance[lane];
            set(&mut self.origin, lane, ray.origin + ray.direction * way);
            self.slack[lane] = slack_after(along, way, faces.reach);
            set(&mut self.travel, lane, onward);
        }
        for lane in 0..LANES {
            let after = mirrored(self.map(lane), get(&drawn, lane)).to_cols_array();
            for entry in 0..9 {
                self.map[entry][lane] = after[entry];
            }
            self.bounces[lane] += 1;
        }
        self.look(faces);
        for lane in 0..LANES {
            let out = (fates[lane] == ON) & (self.distance[lane] == UNMET);
            fates[lane] = if out { OUT } else { fates[lane] };
        }
        fates
    }

    /// Finds the nearest facet ahead of every ray.
    #[inline(always)]
    fn look(&mut self, faces: &Faces) {
        let mut nearest = [UNMET; LANES];
        let mut normal = [[0.0; LANES], [0.0; LANES], [1.0; LANES]];
        let mut unsure: Mask = [0; LANES];
        for facet in &faces.quick {
            // The top bit says that the facet is nearer.
            let mut nearer: Mask = [0; LANES];
            let before = nearest;
            for lane in 0..LANES {
                let glance = facet.look(&self.ray(lane));
                nearer[lane] = (glance.distance - before[lane]).to_bits();
                let least = glance.distance < before[lane];
                nearest[lane] = if least { glance.distance } else { before[lane] };
                unsure[lane] |= glance.doubt;
            }
            for axis in 0..3 {
                choose(&mut normal[axis], &[facet.normal[axis]; LANES], &nearer);
            }
        }
        self.distance = nearest;
        self.facet = normal;
        let mut left = 0;
        for lane in 0..LANES {
            left |= (unsure[lane] >> 63) << lane;
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let (distance, normal) = faces.nearest(&self.ray(lane));
            self.distance[lane] = distance;
            set(&mut self.facet, lane, normal);
        }
    }

    /// Draws the normals that the rays meet on the facets ahead of them.
    #[inline(always)]
    fn drawn(&self, batch: &RoughBatch) -> [Reals; 3] {
        let facet = &self.facet;
        let alpha = batch.roughness.alpha();
        let slopes = batch.roughness.slopes();
        let [a, b, c] = self.random(batch.stream);
        let mut drawn = [[0.0; LANES]; 3];
        if slopes == Slopes::Ggx {
            for lane in 0..LANES {
                let travel = get(&self.travel, lane);
                let at = [a[lane], b[lane], c[lane]].map(|word| word as u32);
                let normal = roughness::ggx(alpha, get(facet, lane), travel, at);
                set(&mut drawn, lane, normal);
            }
            return drawn;
        }
        let mut steep = 0;
        for lane in 0..LANES {
            let (facet, travel) = (get(facet, lane), get(&self.travel, lane));
            let at = [a[lane], b[lane], c[lane]].map(|word| word as u32);
            let normal = roughness::beckmann(alpha, facet, travel, at);
            set(&mut drawn, lane, normal);
            steep |= u64::from(roughness::turns_away(alpha, facet, travel)) << lane;
        }
        while steep != 0 {
            let lane = steep.trailing_zeros() as usize;
            steep &= steep - 1;
            let (facet, travel) = (get(facet, lane), get(&self.travel, lane));
            // Light from behind a facet ends there, whatever its normal.
            if facet.dot(travel) < 0.0 {
                let at = [a[lane], b[lane], c[lane]].map(|word| word as u32);
                let normal = roughness::steep(alpha, facet, travel, at);
                set(&mut drawn, lane, normal);
            }
        }
        drawn
    }

    /// Returns the random numbers of all rays at this reflection, equal to those of
    /// [`Stream::at_bounce`].
    #[inline(always)]
    fn random(&self, stream: &Stream) -> [Mask; 3] {
        let [mut a, mut b, mut c, mut d] = [[0; LANES]; 4];
        for lane in 0..LANES {
            let bounce = self.bounces[lane] as u32;
            let [first, second] = stream.counters_at_bounce(self.index[lane], bounce);
            [a[lane], b[lane]] = first.map(u64::from);
            [c[lane], d[lane]] = second.map(u64::from);
        }
        philox(&mut a, &mut b, stream.keys[0]);
        philox(&mut c, &mut d, stream.keys[0]);
        [a, b, c]
    }
}

/// Returns the vector of `lane`.
#[inline(always)]
fn get(vectors: &[Reals; 3], lane: usize) -> DVec3 {
    let [x, y, z] = vectors;
    DVec3::new(x[lane], y[lane], z[lane])
}

/// Sets the vector of `lane`.
#[inline(always)]
fn set(vectors: &mut [Reals; 3], lane: usize, vector: DVec3) {
    let [x, y, z] = vectors;
    (x[lane], y[lane], z[lane]) = (vector.x, vector.y, vector.z);
}
