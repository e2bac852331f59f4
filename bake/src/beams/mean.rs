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

use crate::beams::exact::Share;
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

#[cfg(test)]
mod tests {
    use super::*;
    use tables::Fate;

    /// Makes light of which the part `moved` lies in the second of two bins, and the rest in the
    /// first.
    fn share(moved: f64) -> Share {
        let mut fate = [0.0; Fate::ALL.len()];
        fate[Fate::Retroreflected as usize] = 1.0;
        Share {
            paths: Vec::new(),
            fate,
            retroreflected: 1.0,
            histogram: vec![1.0 - moved, moved],
            dropped: 0.0,
        }
    }

    /// Returns the L1 error of the mean of light that moves between two bins with the azimuth, if
    /// its true mean is `expected`.
    fn error(moved: impl Fn(f64) -> f64 + Sync, expected: f64) -> f64 {
        let found = mean(&|azimuth: f64| share(moved(azimuth)));
        assert!((found.retroreflected - 1.0).abs() < 1e-13);
        let apart = [
            found.histogram[0] - (1.0 - expected),
            found.histogram[1] - expected,
        ];
        apart.iter().map(|x| x.abs()).sum()
    }

    /// Returns the distance of an azimuth from the next even degree, between 0 and 1.
    fn from_even(azimuth: f64) -> f64 {
        (azimuth - 2.0 * (azimuth / 2.0).round()).abs()
    }

    /// The promise of the manual for exact means over azimuths; a number of its own, so that a
    /// change of the constant is noticed.
    const PROMISED: f64 = 1e-4;

    /// Light jumps at a tenth of a degree from every odd degree, by so little that three azimuths
    /// of a part would be 30 times as far off as is promised: they give the mean of `jump` / 4 for
    /// `jump` / 10, in two bins.
    #[test]
    fn mean_over_jumps_keeps_its_error() {
        for jump in [3e-4, 1e-3, 1e-2, 1.0] {
            let at = |azimuth| if from_even(azimuth) > 0.9 { jump } else { 0.0 };
            let error = error(at, 0.1 * jump);
            // A part is halved until the jump, in two bins, is a change below the promise.
            assert!(error < PROMISED, "{jump}: {error:e}");
        }
    }

    /// The square of the distance from the next even degree has the mean 1/3. The trapezoids of the
    /// halves of a parabola are off by exactly a third of the change, so the error of the mean is
    /// below a third of what is promised.
    #[test]
    fn mean_of_smooth_light_keeps_a_third_of_its_error() {
        for most in [3e-4, 1e-3, 3.6e-2, 1.0] {
            let error = error(|azimuth| most * from_even(azimuth).powi(2), most / 3.0);
            // Sums of 360 parts of numbers up to 1 round by less than 1e-13.
            assert!(error < PROMISED / 3.0 + 1e-13, "{most}: {error:e}");
        }
    }
}
