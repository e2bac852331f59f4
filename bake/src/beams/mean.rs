//! The mean over azimuths of what the exact method finds.
//!
//! Of a direction, eta x histogram and the shares of the fates are piecewise smooth in the azimuth:
//! the edges of polygons pass corners of bins, and fates begin and end. So each of [`PARTS`] equal
//! parts of a turn is halved until the trapezoids of two halves agree with that of the whole. At a
//! kink or a jump the halves are off by no more than this change, where the light is smooth by a
//! third of it: the error of the mean is below [`MEAN_ERROR`], unless light comes and goes between
//! two azimuths half a part from each other.

use rayon::prelude::*;

use crate::beams::share::Share;
use crate::cell::MEAN_ERROR;

/// Parts of a turn that are halved at least once: of one degree.
const PARTS: usize = 360;

/// Parts under way at a time, added in order: the sum does not depend on the threads, and memory
/// not on the parts.
const TOGETHER: usize = 24;

/// Most halvings of a part: a jump then costs less than 2^-20 of the light of its part.
const HALVINGS: u32 = 20;

/// The mean of `at` (azimuth in degrees) over a turn. It has no paths, which belong to a direction.
pub(crate) fn mean(at: &(impl Fn(f64) -> Share + Sync)) -> Share {
    let width = 360.0 / PARTS as f64;
    let part = |part: usize| {
        let [from, to] = [part, part + 1].map(|end| end as f64 * width);
        over(at, (from, to), &at(from), &at(to), HALVINGS)
    };
    let parts: Vec<usize> = (0..PARTS).collect();
    let mut sum: Option<Share> = None;
    for some in parts.chunks(TOGETHER) {
        let means: Vec<Share> = some.par_iter().map(|&which| part(which)).collect();
        for mean in means {
            let weight = 1.0 / PARTS as f64;
            sum = Some(match sum {
                None => mixture(&[(weight, &mean)]),
                Some(sum) => mixture(&[(1.0, &sum), (weight, &mean)]),
            });
        }
    }
    sum.unwrap_or_else(|| at(0.0))
}

/// The mean between two azimuths, of which `first` and `last` are the ends.
fn over(
    at: &impl Fn(f64) -> Share,
    (from, to): (f64, f64),
    first: &Share,
    last: &Share,
    halvings: u32,
) -> Share {
    let between = 0.5 * (from + to);
    let middle = at(between);
    if halvings == 0 || change(first, &middle, last) <= MEAN_ERROR {
        return mixture(&[(0.25, first), (0.5, &middle), (0.25, last)]);
    }
    let left = over(at, (from, between), first, &middle, halvings - 1);
    let right = over(at, (between, to), &middle, last, halvings - 1);
    mixture(&[(0.5, &left), (0.5, &right)])
}

/// What the trapezoids of two halves differ by from that of the whole, L1: (2 middle - first -
/// last) / 4.
fn change(first: &Share, middle: &Share, last: &Share) -> f64 {
    let bins = first
        .histogram
        .iter()
        .zip(&middle.histogram)
        .zip(&last.histogram);
    let fates = first.fate.iter().zip(&middle.fate).zip(&last.fate);
    let all = bins.chain(fates);
    all.map(|((a, m), b)| (2.0 * m - a - b).abs()).sum::<f64>() / 4.0
}

fn mixture(parts: &[(f64, &Share)]) -> Share {
    let sum = |of: &dyn Fn(&Share) -> f64| parts.iter().map(|(w, share)| w * of(share)).sum();
    let bins = parts.first().map_or(0, |(_, share)| share.histogram.len());
    let mut histogram = vec![0.0; bins];
    for (weight, share) in parts {
        for (sum, mass) in histogram.iter_mut().zip(&share.histogram) {
            *sum += weight * mass;
        }
    }
    Share {
        paths: Vec::new(),
        fate: std::array::from_fn(|fate| sum(&|share| share.fate[fate])),
        eta: sum(&|share| share.eta),
        histogram,
        dropped: sum(&|share| share.dropped),
    }
}
