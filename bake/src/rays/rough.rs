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

use crate::optics::{
    BOUNCE_LIMIT, Incidence, Ray, Rules, Triangle, reflect, reflection, roughness,
};
use crate::rays::departures::{Departure, Departures};
use crate::rays::drawn::{digits, points};
use crate::rays::lane::{LANES, Mask, Reals, choose};
use crate::rays::lanes;
use crate::rays::scene::Scene;
use crate::rays::simd::Task;
use crate::rays::tally::Tally;
use crate::samples::{Launch, Stream, philox};
use glam::{DMat3, DVec2, DVec3};
use std::ops::Range;
use std::sync::Arc;
use tables::Fate;
use tables::options::{Roughness, Slopes};

/// Samples to trace, and what they go through.
pub(crate) struct Flight<'a> {
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

/// Sample of a flight: its index, and the point where its ray enters.
#[derive(Debug, Clone, Copy)]
struct Entry {
    index: u64,
    point: DVec2,
}

/// Tracing of a flight; `departures` counts its rays in `tally`.
pub(crate) struct Flying<'a> {
    /// Samples to trace.
    pub flight: &'a Flight<'a>,
    /// Rays that have left the cell.
    pub departures: &'a mut Departures<'a>,
    /// Counts of the rays.
    pub tally: &'a mut Tally,
}

impl Task for Flying<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        run(self.flight, self.departures, self.tally);
    }
}

/// Traces all samples of a flight; `departures` counts them in `tally`.
#[inline(always)]
fn run(flight: &Flight, departures: &mut Departures, tally: &mut Tally) {
    for (scene, entries) in flight.scenes.iter().zip(entries(flight)) {
        departures.enter(scene);
        let mut flock = Flock::new(flight, scene);
        let mut waiting = entries.into_iter();
        let mut free = u64::MAX;
        loop {
            while free != 0 {
                let Some(entry) = waiting.next() else { break };
                flock.enter(free.trailing_zeros() as usize, &entry);
                free &= free - 1;
            }
            if free == u64::MAX {
                break;
            }
            let fates = flock.step(flight, scene.facets());
            let mut ended = ended(&fates) & !free;
            free |= ended;
            while ended != 0 {
                let lane = ended.trailing_zeros() as usize;
                ended &= ended - 1;
                if fates[lane] == OUT {
                    departures.push(&flock.departure(lane), tally);
                } else {
                    tally.fates[fates[lane] as usize] += 1;
                }
            }
        }
        departures.count(tally);
    }
}

/// Draws the samples of a flight; returns those of each scene.
#[inline(always)]
fn entries(flight: &Flight) -> Vec<Vec<Entry>> {
    let Flight { launch, stream, .. } = *flight;
    let samples = flight.samples.clone();
    let mut entries = vec![Vec::new(); flight.scenes.len()];
    if lanes::sorts(launch) {
        for index in samples {
            let (scene, point) = launch.entry(stream, index);
            entries[scene].push(Entry { index, point });
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
                    of_scene.push(Entry {
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

/// Rays under way, one for each lane.
struct Flock {
    point: [Reals; 2],
    origin: [Reals; 3],
    travel: [Reals; 3],
    slack: Reals,
    map: [Reals; 9],
    bounces: Mask,
    index: Mask,
    /// Ray that enters at the origin of the entrance plane.
    first: Ray,
    reach: f64,
}

impl Flock {
    /// Makes a flock without rays. Each lane repeats a ray that counts for nothing.
    #[inline(always)]
    fn new(flight: &Flight, scene: &Scene) -> Self {
        let first = scene.enter(DVec2::ZERO, flight.direction.travel);
        let mut flock = Flock {
            point: [[0.0; LANES]; 2],
            origin: [[0.0; LANES]; 3],
            travel: [[0.0; LANES]; 3],
            slack: [0.0; LANES],
            map: [[0.0; LANES]; 9],
            bounces: [0; LANES],
            index: [0; LANES],
            first,
            reach: scene.reach(),
        };
        let entry = Entry {
            index: 0,
            point: DVec2::ZERO,
        };
        for lane in 0..LANES {
            flock.enter(lane, &entry);
        }
        flock
    }

    /// Starts a ray in `lane`.
    #[inline(always)]
    fn enter(&mut self, lane: usize, entry: &Entry) {
        let DVec2 { x, y } = entry.point;
        (self.point[0][lane], self.point[1][lane]) = (x, y);
        set(
            &mut self.origin,
            lane,
            DVec3::new(x, y, self.first.origin.z),
        );
        set(&mut self.travel, lane, self.first.direction);
        self.slack[lane] = self.first.slack;
        let unit = DMat3::IDENTITY.to_cols_array();
        for (entries, value) in self.map.iter_mut().zip(unit) {
            entries[lane] = value;
        }
        self.bounces[lane] = 0;
        self.index[lane] = entry.index;
    }

    /// Returns the ray of `lane`.
    #[inline(always)]
    fn ray(&self, lane: usize) -> Ray {
        Ray {
            origin: get(&self.origin, lane),
            direction: get(&self.travel, lane),
            slack: self.slack[lane],
            grain: self.first.grain,
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

    /// Takes every ray past its nearest facet. Returns the fate of each ray as a number: [`ON`] if
    /// it goes on, [`OUT`] if it meets no facet.
    #[inline(always)]
    fn step(&mut self, flight: &Flight, facets: &[Triangle]) -> Mask {
        let (distance, facet) = self.nearest(facets);
        let drawn = self.drawn(flight, &facet);
        let rules = flight.rules;
        let total_only = rules.reflects_only_totally();
        let mut fates = [ON; LANES];
        for lane in 0..LANES {
            let ray = self.ray(lane);
            let (facet, normal) = (get(&facet, lane), get(&drawn, lane));
            let onward = reflect(ray.direction, normal);
            // The first reason to end counts, so it is asked last.
            let mut fate = ON;
            let mut ends = |condition: bool, of: u64| fate = if condition { of } else { fate };
            ends(onward.dot(facet) <= 0.0, Fate::Absorbed as u64);
            let through = !rules.reflects_totally(ray.direction.dot(normal));
            ends(total_only & through, Fate::Transmitted as u64);
            let limit = self.bounces[lane] == u64::from(BOUNCE_LIMIT);
            ends(limit, Fate::BounceLimit as u64);
            ends(ray.direction.dot(facet) >= 0.0, Fate::Absorbed as u64);
            ends(distance[lane] == UNMET, OUT);
            fates[lane] = fate;
        }
        for lane in 0..LANES {
            let on = fates[lane] == ON;
            let ray = self.ray(lane);
            let normal = get(&drawn, lane);
            let keep = |new: f64, old: f64| if on { new } else { old };
            let way = keep(distance[lane], 0.0);
            let origin = ray.origin + ray.direction * way;
            let along = ray.direction.dot(get(&facet, lane)).abs();
            let slack = 16.0 * f64::EPSILON * (self.reach + way) / along;
            let onward = reflect(ray.direction, normal);
            self.slack[lane] = keep(slack, ray.slack);
            for axis in 0..3 {
                self.origin[axis][lane] = keep(origin[axis], ray.origin[axis]);
                self.travel[axis][lane] = keep(onward[axis], ray.direction[axis]);
            }
        }
        for lane in 0..LANES {
            let on = fates[lane] == ON;
            let before = self.map(lane);
            let after = reflection(get(&drawn, lane)) * before;
            let (before, after) = (before.to_cols_array(), after.to_cols_array());
            for entry in 0..9 {
                self.map[entry][lane] = if on { after[entry] } else { before[entry] };
            }
            self.bounces[lane] += u64::from(on);
        }
        fates
    }

    /// Returns the distance of the nearest facet of every ray, [`UNMET`] without a facet, and the
    /// facet's normal.
    #[inline(always)]
    fn nearest(&self, facets: &[Triangle]) -> (Reals, [Reals; 3]) {
        let mut nearest = [UNMET; LANES];
        let mut normal = [[0.0; LANES], [0.0; LANES], [1.0; LANES]];
        for facet in facets {
            // The top bit says that the facet is nearer.
            let mut nearer: Mask = [0; LANES];
            for lane in 0..LANES {
                let distance = facet.reach(&self.ray(lane));
                nearer[lane] = (distance - nearest[lane]).to_bits();
                let least = distance < nearest[lane];
                nearest[lane] = if least { distance } else { nearest[lane] };
            }
            for axis in 0..3 {
                choose(&mut normal[axis], &[facet.normal[axis]; LANES], &nearer);
            }
        }
        (nearest, normal)
    }

    /// Draws the normals that the rays meet on facets with these unit normals.
    #[inline(always)]
    fn drawn(&self, flight: &Flight, facet: &[Reals; 3]) -> [Reals; 3] {
        let alpha = flight.roughness.alpha();
        let slopes = flight.roughness.slopes();
        let [a, b, c] = self.random(flight.stream);
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
