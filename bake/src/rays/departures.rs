//! Rays of directions of their own that leave the cell, 64 side by side: their fates, shifts and
//! exit directions.

#![allow(
    clippy::needless_range_loop,
    reason = "the same lane of several arrays; iterators hide that"
)]

use crate::optics::{Incidence, Leaving, Rules, element};
use crate::rays::accumulator::Accumulator;
use crate::rays::accumulator::Bins;
use crate::rays::lane::{LANES, Mask, Reals, UNITS, floor};
use crate::rays::scene::Scene;
use glam::{DMat3, DVec2, DVec3};
use tables::Fate;
use tables::deviation::Grid;

/// Ray that leaves the cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Departure {
    /// Point where the ray entered, edge lengths.
    pub point: DVec2,
    /// Point of the last facet, or of the entrance if the ray has met none, edge lengths.
    pub origin: DVec3,
    /// Direction of travel, unit length.
    pub travel: DVec3,
    /// Linear map of the reflections.
    pub map: DMat3,
    /// Number of reflections.
    pub bounces: u64,
}

/// Rays that have left and are still to be counted.
pub(crate) struct Departures<'a> {
    direction: &'a Incidence,
    rules: &'a Rules,
    bins: &'a Bins,
    /// Grid that exit directions are recorded on; `None` if they are not recorded.
    exits: Option<&'a Grid>,
    leaving: Leaving,
    /// Height of the plane on which shifts are measured, edge lengths.
    plane: f64,
    /// Way along the plane from the point of entry to the line of entry at `plane`.
    lead: DVec2,
    count: usize,
    point: [Reals; 2],
    origin: [Reals; 3],
    travel: [Reals; 3],
    map: [Reals; 9],
    bounces: Mask,
}

impl<'a> Departures<'a> {
    /// Makes room for rays of one direction.
    pub(crate) fn new(
        direction: &'a Incidence,
        rules: &'a Rules,
        bins: &'a Bins,
        exits: Option<&'a Grid>,
    ) -> Self {
        Departures {
            direction,
            rules,
            bins,
            exits,
            leaving: Leaving::new(rules),
            plane: 0.0,
            lead: DVec2::ZERO,
            count: 0,
            point: [[0.0; LANES]; 2],
            origin: [[0.0; LANES]; 3],
            travel: [[1.0; LANES]; 3],
            map: [[0.0; LANES]; 9],
            bounces: [0; LANES],
        }
    }

    /// Takes `scene` as the one that rays leave from now on. None may be waiting.
    pub(crate) fn enter(&mut self, scene: &Scene) {
        self.plane = element::plane(self.rules.element, scene.height(), scene.bottom());
        let travel = self.direction.travel;
        self.lead = travel.truncate() * ((self.plane - scene.height()) / travel.z);
    }

    /// Takes a ray, and counts all if there is no room for more.
    #[inline(always)]
    pub(crate) fn push(&mut self, ray: &Departure, accumulator: &mut Accumulator) {
        let lane = self.count;
        let point = ray.point.to_array();
        for axis in 0..2 {
            self.point[axis][lane] = point[axis];
        }
        for axis in 0..3 {
            self.origin[axis][lane] = ray.origin[axis];
            self.travel[axis][lane] = ray.travel[axis];
        }
        let map = ray.map.to_cols_array();
        for entry in 0..9 {
            self.map[entry][lane] = map[entry];
        }
        self.bounces[lane] = ray.bounces;
        self.count += 1;
        if self.count == LANES {
            self.count(accumulator);
        }
    }

    /// Counts the rays that are waiting.
    #[inline(always)]
    pub(crate) fn count(&mut self, accumulator: &mut Accumulator) {
        let fates = self.fates();
        let (bin, place) = self.places();
        for lane in 0..self.count {
            if fates[lane] != Fate::Retroreflected as u64 {
                accumulator.fates[fates[lane] as usize] += 1;
            } else if bin[lane] == BESIDE {
                accumulator.fates[Fate::OutOfRange as usize] += 1;
            } else {
                accumulator.fates[Fate::Retroreflected as usize] += 1;
                accumulator.histogram[bin[lane] as usize] += 1;
                if self.exits.is_some() {
                    accumulator.exits.push(place[lane]);
                }
            }
        }
        self.count = 0;
    }

    /// Returns the numbers of the rays' fates.
    #[inline(always)]
    fn fates(&self) -> Mask {
        let mut fates = [0; LANES];
        let unmet = element::unmet(self.rules.element) as u64;
        let travel = self.direction.travel;
        let [a, b, c, d, e, f, g, h, i] = &self.map;
        for lane in 0..LANES {
            let [x, y, z] = [[a, b, c], [d, e, f], [g, h, i]]
                .map(|[x, y, z]| DVec3::new(x[lane], y[lane], z[lane]));
            let map = DMat3::from_cols(x, y, z);
            let bounces = self.bounces[lane];
            let mut fate = Fate::Deviated as u64;
            fate = if bounces == 2 {
                Fate::LeftAfter2 as u64
            } else {
                fate
            };
            fate = if bounces == 1 {
                Fate::LeftAfter1 as u64
            } else {
                fate
            };
            fate = if bounces == 0 { unmet } else { fate };
            // The first rule that holds counts, so it is asked last.
            let opposite = self.leaving.is_straight(map * travel, travel);
            let fate = if opposite & (bounces > 0) {
                Fate::AntiparallelOther as u64
            } else {
                fate
            };
            let near = self.leaving.is_near(map);
            fates[lane] = if near & (bounces > 0) {
                Fate::Retroreflected as u64
            } else {
                fate
            };
        }
        fates
    }

    /// Returns the bin of each ray's shift, [`BESIDE`] outside of the histogram, and the place of
    /// its shift and exit direction on the grid.
    #[inline(always)]
    fn places(&self) -> (Mask, Mask) {
        let (mut u, mut v): (Reals, Reals) = ([0.0; LANES], [0.0; LANES]);
        let [x, y, z] = &self.origin;
        let [p, q, r] = &self.travel;
        for lane in 0..LANES {
            let along = DVec3::new(p[lane], q[lane], r[lane]);
            let origin = DVec3::new(x[lane], y[lane], z[lane]);
            let exit = (origin + along * ((self.plane - origin.z) / along.z)).truncate();
            let point = DVec2::new(self.point[0][lane], self.point[1][lane]);
            let shift = self.direction.to_frame(exit - (point + self.lead));
            let at = self.bins.position(shift);
            (u[lane], v[lane]) = (at.x, at.y);
        }
        let end = self.bins.count as f64;
        let mut bin = [BESIDE; LANES];
        for lane in 0..LANES {
            let within = (u[lane] >= 0.0) & (v[lane] >= 0.0) & (u[lane] < end) & (v[lane] < end);
            (u[lane], v[lane]) = (floor(u[lane]), floor(v[lane]));
            let number = (v[lane] * end + u[lane] + UNITS).to_bits() & 0xffff_ffff;
            bin[lane] = if within { number } else { BESIDE };
        }
        let mut place = [0; LANES];
        let Some(grid) = self.exits else {
            return (bin, place);
        };
        let pool = (self.bins.count / grid.cells) as f64;
        let [cells, count] = [grid.cells, grid.bins].map(|n| n as f64);
        let (range, width) = (grid.range, grid.bin_width());
        for lane in 0..LANES {
            let travel = DVec3::new(p[lane], q[lane], r[lane]);
            let back = element::straight_back(self.rules.element, travel);
            let off = self.direction.deviation(back, self.rules.refractive_index);
            let of = |tangent: f64| {
                let position = (tangent + range) / width;
                let position = if position > 0.0 { position } else { 0.0 };
                floor(if position < count {
                    position
                } else {
                    count - 1.0
                })
            };
            let cell = floor(v[lane] / pool) * cells + floor(u[lane] / pool);
            let number = (cell * count + of(off.y)) * count + of(off.x);
            place[lane] = (number + UNITS).to_bits() & ((1 << 48) - 1);
        }
        (bin, place)
    }
}

/// Number that stands for a shift outside of the histogram.
const BESIDE: u64 = u64::MAX;
