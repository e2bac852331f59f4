//! Uneven light on the pixels of a bin.
//!
//! The light is L = exp(q), where q is a polynomial in the place d across the line of the edge and
//! the place t along it. A bend of the edge does not bend the light.
//!
//! ```text
//! first order:   d, t
//! second order:  d^2, d t, t^2
//! third order:   d^3, d^2 t, d t^2, t^3
//! fourth order:  (d^2 + t^2)^2
//! ```
//!
//! An exponential of second order describes light that falls as a Gaussian exactly. Of the fall by
//! cos^4 it leaves a third of what a polynomial of second order leaves. The higher orders describe
//! the rest, and a hot spot on a floor of light. Their fourth order has one term: vignetting and a
//! hot spot are round, and the other four of fourth order would widen the error of mu by a third.
//! d and t are in units of [`UNIT_PX`].

use crate::compare::pixels::Bin;
use edges::numerics::chance;

/// Number of terms of uneven light.
pub(crate) const LIGHT: usize = 10;

/// Number of terms of first order.
const FIRST_ORDER: usize = 2;

/// Number of terms up to second order.
const SECOND_ORDER: usize = 5;

/// Unit of places, pixels. It keeps the columns of all orders alike in size.
pub(crate) const UNIT_PX: f64 = 100.0;

/// Coefficients of the terms.
pub(crate) type Uneven = [f64; LIGHT];

/// Terms of the light that are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terms {
    /// None.
    None,
    /// Terms of first order.
    First,
    /// Terms up to second order, with the lit part of the dark plateau and the share of the lamp.
    /// They tell whether the light is uneven, see [`are_uneven`].
    Second,
    /// All, with the same.
    All,
}

impl Terms {
    /// Returns the number of terms.
    pub(crate) fn light(self) -> usize {
        match self {
            Terms::None => 0,
            Terms::First => FIRST_ORDER,
            Terms::Second => SECOND_ORDER,
            Terms::All => LIGHT,
        }
    }

    /// Returns whether the light counts as uneven.
    pub(crate) fn are_many(self) -> bool {
        matches!(self, Terms::Second | Terms::All)
    }

    /// Returns whether the orders of the curve are estimated with these terms. With no terms they
    /// are too, so that the fall of chi-square to second order is that of the light alone.
    pub(crate) fn free_the_curve(self) -> bool {
        self != Terms::First
    }
}

/// Returns whether light counts as uneven, from the falls of chi-square of all photographs by their
/// terms up to second order. Noise makes it so in one campaign of 1,000. Where the light is even,
/// the terms of second order would raise the errors of c and a by 6 % and those of mu by 80 %.
///
/// All photographs are judged together, and of uneven light all terms are estimated. Both a weak
/// light and the higher orders can hide in noise and still move the step, to the same side in most
/// photographs.
pub fn are_uneven(falls: &[f64]) -> bool {
    const RARE: f64 = 1e-3;
    chance::of_squares(falls.iter().sum(), SECOND_ORDER * falls.len()) < RARE
}

/// Light in one bin, or its derivative by one term.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lit {
    /// Mean over the bin's pixels.
    pub value: f64,
    /// Slope along the edge, per pixel.
    pub by_t: f64,
    /// Variance of the pixels' places along the edge.
    share: f64,
}

impl Lit {
    /// Returns the mean of a curve in this light, from the curve's mean and its slope along the
    /// edge.
    pub(crate) fn mean(self, [unit, along, ..]: [f64; 4]) -> f64 {
        self.value * unit + self.by_t * along * self.share
    }

    /// Returns the slope of a curve in this light along the edge.
    pub(crate) fn slope(self, [unit, along, ..]: [f64; 4]) -> f64 {
        self.value * along + self.by_t * unit
    }
}

/// Light of one bin with its derivatives by the terms.
pub(crate) struct Lights {
    /// The light, 1 where it is even.
    pub all: Lit,
    /// Derivatives by the terms.
    pub by: [Lit; LIGHT],
}

/// Returns the light of a bin, with its derivatives by the first `count` terms. The other terms are
/// 0. d counts from `from_px`, a distance from the window's middle.
///
/// The exponent is taken as linear along the edge within the bin. For light that varies by 30 %
/// over four bins this leaves 1e-5 of the light.
pub(super) fn of(bin: &Bin, from_px: f64, terms: &Uneven, count: usize) -> Lights {
    let [share, _] = bin.variance;
    let [across, bend] = bin.from_middle;
    let (means, slopes) = powers(
        [(across - from_px) / UNIT_PX, bend],
        bin.along / UNIT_PX,
        share / UNIT_PX.powi(2),
    );
    let sum = |of: &[f64; LIGHT]| {
        let terms = terms.iter().take(count);
        of.iter().zip(terms).map(|(v, c)| v * c).sum::<f64>()
    };
    let (exponent, slope) = (sum(&means), sum(&slopes) / UNIT_PX);
    let middle = exponent.exp();
    // The mean of exp(slope (t - mean t)) to second order.
    let value = middle * (1.0 + 0.5 * slope * slope * share);
    let lit = |value: f64, by_t: f64| Lit { value, by_t, share };
    let by = |i: usize| {
        let own = slopes[i] / UNIT_PX;
        let by_slope = middle * slope * share * own;
        lit(
            value * means[i] + by_slope,
            middle * (own + slope * means[i]),
        )
    };
    Lights {
        all: lit(value, middle * slope),
        by: std::array::from_fn(|i| if i < count { by(i) } else { lit(0.0, 0.0) }),
    }
}

/// Returns the means of all terms over a bin at `d` whose places along the edge have the mean `t`
/// and the variance `v`, and the slopes of the terms along the edge. `bend` is the slope of d.
fn powers([d, bend]: [f64; 2], t: f64, v: f64) -> ([f64; LIGHT], [f64; LIGHT]) {
    let (dd, tt) = (d * d, t * t);
    let square = dd + tt;
    (
        [
            d,
            t,
            dd,
            d * t,
            tt + v,
            d * dd,
            dd * t,
            d * (tt + v),
            t * (tt + 3.0 * v),
            // Without the fourth moment, which is of the order of v^2.
            square * square + v * (2.0 * dd + 6.0 * tt),
        ],
        [
            bend,
            1.0,
            2.0 * d * bend,
            d + t * bend,
            2.0 * t,
            3.0 * dd * bend,
            dd + 2.0 * d * t * bend,
            2.0 * d * t + tt * bend,
            3.0 * tt,
            4.0 * square * (t + d * bend),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the limits with tables of chi-square for a chance of 1/1,000 at 5, 10, 35 and 100
    /// degrees of freedom, whose values have five digits.
    #[test]
    fn noise_makes_light_uneven_once_in_a_thousand_campaigns() {
        for (photographs, limit) in [(1, 20.515), (2, 29.588), (7, 66.619), (20, 149.449)] {
            for (factor, expected) in [(0.9999, false), (1.0001, true)] {
                let falls = vec![factor * limit / photographs as f64; photographs];
                assert_eq!(are_uneven(&falls), expected, "{photographs} photographs");
            }
        }
        // One photograph in strong light is enough.
        assert!(are_uneven(&[400.0, 3.0, 5.0]));
    }

    /// Compares mean and slope of the light, and their derivatives, with sums over single places
    /// and differences. The light varies by 20 % over 200 pixels, and the bin has 50.
    ///
    /// Means are exact but for two parts: what the exponent has of second order within the bin,
    /// 0.07 (25 / 100)^2 = 0.004 at the ends, by 4/45 of half its square, and the fourth moment of
    /// the last term, 0.01 x 3 (14.4 / 100)^4 = 1e-5.
    ///
    /// A term k (t - mean t)^3 adds 3/5 (25 / 100)^2 k = 0.0375 k to the slope, which is left out.
    /// k is 0.01 by the term of third order, 0.01 x 4 x 0.45 by that of fourth order, and 0.16 x
    /// 0.07 by the product of slope and curvature. Together this is 1.5e-3.
    #[test]
    fn the_light_of_a_bin_is_that_of_its_pixels() {
        let places: Vec<f64> = (0..50).map(|k| 20.5 + f64::from(k)).collect();
        let n = places.len() as f64;
        let along = places.iter().sum::<f64>() / n;
        let spread: f64 = places.iter().map(|t| (t - along).powi(2)).sum();
        let distance = -12.0;
        let bin = Bin {
            count: n,
            along,
            from_middle: [distance, 0.0],
            spread,
            variance: [spread / n, 0.0],
            ..Bin::default()
        };
        let terms = [0.1, -0.1, -0.07, 0.05, -0.07, 0.01, 0.01, -0.01, 0.01, 0.01];
        let at = |t: f64| {
            let (d, t) = (distance / 100.0, t / 100.0);
            let square: f64 = d * d + t * t;
            let all = [
                d,
                t,
                d.powi(2),
                d * t,
                t.powi(2),
                d.powi(3),
                d.powi(2) * t,
                d * t.powi(2),
                t.powi(3),
                square.powi(2),
            ];
            let exponent: f64 = all.iter().zip(&terms).map(|(v, c)| v * c).sum();
            exponent.exp()
        };
        let mean = places.iter().map(|&t| at(t)).sum::<f64>() / n;
        let by_t = places.iter().map(|&t| (t - along) * at(t)).sum::<f64>() / spread;
        let found = of(&bin, 0.0, &terms, LIGHT).all;
        let (off, off_slope) = (found.value / mean - 1.0, found.by_t - by_t);
        println!("{off:.1e} {off_slope:.1e}");
        assert!(off.abs() < 1.2e-5, "{off}");
        assert!((off_slope * UNIT_PX).abs() < 1.5e-3, "{off_slope}");
        let mut cases = 0;
        for count in [0, FIRST_ORDER, SECOND_ORDER, LIGHT] {
            let mut few = terms;
            few[count..].fill(0.0);
            let lights = of(&bin, 0.0, &terms, count);
            let same = of(&bin, 0.0, &few, LIGHT).all;
            assert_eq!((lights.all.value, lights.all.by_t), (same.value, same.by_t));
            for (i, lit) in lights.by.iter().enumerate().take(count) {
                // Third derivatives leave h^2 / 6 of numbers of order 1.
                let h = 1e-4;
                let moved = |by: f64| {
                    let mut terms = terms;
                    terms[i] += by;
                    of(&bin, 0.0, &terms, count).all
                };
                let (high, low) = (moved(h), moved(-h));
                let value = (high.value - low.value) / (2.0 * h);
                assert!((lit.value - value).abs() < 1e-8, "{i}");
                // The slope along the edge does not take the part of the variance.
                let slope = (high.by_t - low.by_t) / (2.0 * h);
                assert!((lit.by_t - slope).abs() < 1e-8, "{i}");
                cases += 1;
            }
        }
        assert_eq!(cases, 17);
    }
}
