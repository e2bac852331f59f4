//! The mean over all azimuths of the exact shares.
//!
//! For one incidence, eta x histogram and the shares of the fates are piecewise smooth functions of
//! the azimuth: edges of polygons pass corners of bins, and fates begin and end. So each of
//! [`PARTS`] equal parts of a turn is halved until the trapezoids of its two halves agree with the
//! trapezoid of the whole part. At a kink or a jump the error of the halves is at most this change;
//! where the functions are smooth it is a third of this change. The error of the mean is therefore
//! below [`MEAN_ERROR`]. The one exception is light that appears and disappears between two
//! azimuths half a part from each other.

use rayon::prelude::*;

use crate::beams::share::Share;
use crate::cell::MEAN_ERROR;

/// Number of equal parts of a turn, each of one degree and halved at least once.
const PARTS: usize = 360;

/// Number of parts that are under way at a time. They are added in order, so that the sum does not
/// depend on the number of threads and the memory does not depend on the number of parts.
const TOGETHER: usize = 24;

/// Largest number of halvings of a part. A jump then costs less than 2^-20 of the light of its
/// part.
const HALVINGS: u32 = 20;

/// Returns the mean of `at`, a function of the azimuth in degrees, over a turn. The mean has no
/// paths: a path belongs to one direction.
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

/// Returns the mean between the azimuths `from` and `to`, degrees; `first` and `last` are the
/// shares at these ends.
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

/// Returns the L1 difference of the trapezoids of two halves from the trapezoid of the whole: (2
/// middle - first - last) / 4.
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
        retroreflected: sum(&|share| share.retroreflected),
        histogram,
        dropped: sum(&|share| share.dropped),
    }
}
