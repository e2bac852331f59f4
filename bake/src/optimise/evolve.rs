//! The search: differential evolution for one quantity or for the front of two.
//!
//! The algorithm is GDE3 of Kukkonen and Lampinen, "GDE3: The third evolution step of generalized
//! differential evolution", CEC 2005. With one quantity it is the differential evolution of Storn
//! and Price 1997. Cells that lack something are compared by how much they lack (Deb 2000). A cell
//! is a function of (seed, generation, place), so the result does not depend on the threads.

use crate::geometry::{Stream, centred};
use rayon::prelude::*;
use tables::options::Sampler;

/// Cells of a generation.
const SIZE: usize = 40;

/// Share of the parameters that a new cell takes from the mutation.
const CROSSED: f64 = 0.9;

/// Range of the scale of a mutation.
const SCALE: [f64; 2] = [0.4, 0.9];

/// Differences between the cells of a generation at which the search for one quantity has ended, as
/// a share of the range of each parameter. The quantity is flat there to the square of it.
const SAME: f64 = 1e-6;

/// What is compared of two cells.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Merit {
    /// Quantities to be made as large as possible.
    pub values: Vec<f64>,
    /// What is missing of the conditions; 0 if all are met.
    pub lack: f64,
}

impl Merit {
    /// Returns whether this is nowhere worse than `other`.
    fn covers(&self, other: &Merit) -> bool {
        match self.lack > 0.0 || other.lack > 0.0 {
            true => self.lack <= other.lack,
            false => self.values.iter().zip(&other.values).all(|(a, b)| a >= b),
        }
    }

    /// Returns whether this is nowhere worse than `other` and somewhere better.
    pub(crate) fn dominates(&self, other: &Merit) -> bool {
        self.covers(other) && !other.covers(self)
    }
}

/// A cell as the search sees it: shares of the ranges, and its merit.
pub(crate) type Member = (Vec<f64>, Merit);

/// Returns a source of numbers from 0 to 1 that depend on seed, generation and place alone.
fn dice(seed: u64, generation: u64, place: usize) -> impl FnMut() -> f64 {
    let number = generation * SIZE as u64 + place as u64;
    let stream = Stream::new(Sampler::Random, seed, 0.0, 0.0, number);
    let mut thrown = 0;
    move || {
        thrown += 1;
        0.5 + centred(stream.pair(thrown)[0])
    }
}

/// Searches `dimensions` shares from 0 to 1 with at most `budget` calls of `merit`, but at least one
/// generation, and returns the cells that no other one dominates. `done` is told the cells of each
/// generation.
pub(crate) fn evolve(
    dimensions: usize,
    budget: u64,
    seed: u64,
    merit: &(impl Fn(&[f64]) -> Merit + Sync),
    done: &dyn Fn(u64),
) -> Vec<Member> {
    let judged = |all: Vec<Vec<f64>>| -> Vec<Member> {
        done(all.len() as u64);
        let own: Vec<Merit> = all.par_iter().map(|shares| merit(shares)).collect();
        all.into_iter().zip(own).collect()
    };
    if dimensions == 0 {
        return judged(vec![Vec::new()]);
    }
    let begin = |place| std::iter::repeat_with(dice(seed, 0, place)).take(dimensions);
    let mut all = judged((0..SIZE).map(|place| begin(place).collect()).collect());
    for generation in 1..budget / SIZE as u64 {
        let is_same = |k| extent(&all, |own| own.0[k]) < SAME;
        if all[0].1.values.len() == 1 && (0..dimensions).all(is_same) {
            break;
        }
        let trials = (0..SIZE).map(|place| trial(&all, place, dice(seed, generation, place)));
        for (place, new) in judged(trials.collect()).into_iter().enumerate() {
            if new.1.covers(&all[place].1) {
                all[place] = new;
            } else if !all[place].1.covers(&new.1) {
                all.push(new);
            }
        }
        while all.len() > SIZE {
            all.swap_remove(worst(&all));
        }
    }
    undominated(all, |member| &member.1)
}

/// Returns the difference of the largest and the smallest value of the cells.
fn extent(all: &[Member], of: impl Fn(&Member) -> f64) -> f64 {
    let values = || all.iter().map(&of);
    values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
}

/// Makes a new cell from the one at a place and three others.
fn trial(all: &[Member], place: usize, mut dice: impl FnMut() -> f64) -> Vec<f64> {
    let mut below = |count: usize| ((dice() * count as f64) as usize).min(count - 1);
    let mut others = [place; 4];
    for k in 1..4 {
        while others[..k].contains(&others[k]) {
            others[k] = below(all.len());
        }
    }
    let [own, a, b, c] = others.map(|k| &all[k].0);
    let scale = SCALE[0] + (SCALE[1] - SCALE[0]) * dice();
    // Beyond an end it goes half of the way to the end.
    let share = |k: usize| match a[k] + scale * (b[k] - c[k]) {
        _ if dice() > CROSSED => own[k],
        low if low < 0.0 => 0.5 * own[k],
        high if high > 1.0 => 0.5 + 0.5 * own[k],
        inside => inside,
    };
    (0..own.len()).map(share).collect()
}

/// Returns the place of the cell that a front can best do without: one that many dominate, and
/// among equals the one with the closest neighbours on the front.
fn worst(all: &[Member]) -> usize {
    let beaten = |own: &Member| all.iter().filter(|other| other.1.dominates(&own.1)).count();
    let beaten: Vec<usize> = all.iter().map(beaten).collect();
    let most = beaten.iter().max();
    let mut last: Vec<usize> = (0..all.len())
        .filter(|&k| Some(&beaten[k]) == most)
        .collect();
    let value = |k: usize, of: usize| all[k].1.values[of];
    last.sort_by(|&a, &b| value(a, 0).total_cmp(&value(b, 0)));
    // On a front of two quantities, one falls where the other rises.
    let room = |near: &[usize]| -> f64 {
        let width = |of| extent(all, |own| own.1.values[of]).max(f64::MIN_POSITIVE);
        let apart = |of| (value(near[0], of) - value(near[2], of)).abs() / width(of);
        (0..all[0].1.values.len()).map(apart).sum()
    };
    let inner = last.windows(3).min_by(|a, b| room(a).total_cmp(&room(b)));
    inner.map_or(last[0], |near| near[1])
}

/// Returns those that no other one dominates, one of each merit.
pub(crate) fn undominated<T>(all: Vec<T>, merit: impl Fn(&T) -> &Merit) -> Vec<T> {
    let is_front = |k: usize| {
        let own = merit(&all[k]);
        let mut others = all.iter().map(&merit).enumerate();
        !others.any(|(j, other)| other.dominates(own) || j < k && other.covers(own))
    };
    let front: Vec<bool> = (0..all.len()).map(is_front).collect();
    let kept = all.into_iter().zip(front);
    kept.filter_map(|(own, is_front)| is_front.then_some(own))
        .collect()
}
