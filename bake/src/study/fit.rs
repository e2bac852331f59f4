//! Slopes of measured error curves, and their crossings with a target, on logarithmic axes.

use crate::rays::Sums;
use tables::Table;

/// Power law fitted to points (x, y).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Exponent: d log y / d log x.
    pub exponent: f64,
    /// Standard error of the exponent, from the scatter about the line; `None` for two points.
    pub standard_error: Option<f64>,
    /// Natural logarithm of y at x = 1.
    pub intercept: f64,
    /// Smallest and largest x of the points.
    pub range: [f64; 2],
}

impl Slope {
    /// Returns the fitted y at `x`.
    pub fn at(&self, x: f64) -> f64 {
        (self.intercept + self.exponent * x.ln()).exp()
    }
}

/// Fits log y as a linear function of log x by least squares.
///
/// Returns `None` for fewer than two different x. All numbers must be positive.
pub(crate) fn slope(points: &[[f64; 2]]) -> Option<Slope> {
    let n = points.len() as f64;
    let logs = || points.iter().map(|point| point.map(f64::ln));
    let [x_mean, y_mean] = [0, 1].map(|axis| logs().map(|p| p[axis]).sum::<f64>() / n);
    let xx: f64 = logs().map(|[x, _]| (x - x_mean).powi(2)).sum();
    // Without points xx is 0, and the means are not used.
    if xx <= 0.0 {
        return None;
    }
    let xy: f64 = logs().map(|[x, y]| (x - x_mean) * (y - y_mean)).sum();
    let exponent = xy / xx;
    let intercept = y_mean - exponent * x_mean;
    let squares: f64 = logs()
        .map(|[x, y]| (y - intercept - exponent * x).powi(2))
        .sum();
    let ends = |from: f64, pick: fn(f64, f64) -> f64| points.iter().map(|p| p[0]).fold(from, pick);
    Some(Slope {
        exponent,
        standard_error: (points.len() > 2).then(|| (squares / (n - 2.0) / xx).sqrt()),
        intercept,
        range: [ends(f64::INFINITY, f64::min), ends(0.0, f64::max)],
    })
}

/// Time at which a falling error meets a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reached {
    /// Time in seconds, interpolated between two measurements.
    At(f64),
    /// Upper bound in seconds: the first measurement has already reached the target.
    Within(f64),
    /// No time: no measurement has reached the target.
    Never,
}

impl Reached {
    /// Returns the time in seconds, or its upper bound; `None` if the target was never reached.
    pub fn seconds(self) -> Option<f64> {
        match self {
            Reached::At(seconds) | Reached::Within(seconds) => Some(seconds),
            Reached::Never => None,
        }
    }
}

/// Finds the time at which the points (seconds, error) first fall to `target`.
///
/// Interpolates linearly between neighbours on logarithmic axes.
pub(crate) fn reached(points: &[[f64; 2]], target: f64) -> Reached {
    let Some(below) = points.iter().position(|&[_, error]| error <= target) else {
        return Reached::Never;
    };
    let [seconds, error] = points[below];
    if below == 0 {
        return Reached::Within(seconds);
    }
    // An error of 0 has no logarithm, so the time of the measurement itself is taken.
    if error <= 0.0 {
        return Reached::At(seconds);
    }
    let [before, error_before] = points[below - 1];
    let part = (error_before / target).ln() / (error_before / error).ln();
    Reached::At(before * (seconds / before).powf(part))
}

/// Returns the median; for an even number of values the mean of the two in the middle.
///
/// Sorts the values. Returns NaN if there are none.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 {
        return f64::NAN;
    }
    f64::midpoint(values[(n - 1) / 2], values[n / 2])
}

/// Returns the estimated L1 error of every direction of a table of rays.
///
/// `bake trace --tolerance` makes the same estimate.
pub(crate) fn estimates(table: &Table) -> Vec<f64> {
    Sums::of_table(table).iter().map(Sums::l1_error).collect()
}

/// Returns the mean number of retroreflected rays per bin that any ray met, in one randomisation.
///
/// It is the least over all directions. A direction in which nothing returns counts as infinite.
pub(crate) fn density(table: &Table) -> f64 {
    let of = |sums: &Sums| {
        let randomisations = sums.launched.len().max(1);
        let size = sums.counts.len() / randomisations;
        let met = (0..size)
            .filter(|bin| (0..randomisations).any(|r| sums.counts[r * size + bin] > 0))
            .count();
        let returned: u64 = sums.counts.iter().sum();
        if met == 0 {
            f64::INFINITY
        } else {
            returned as f64 / (met * randomisations) as f64
        }
    };
    Sums::of_table(table)
        .iter()
        .map(of)
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planted_power_law_comes_back() {
        let law = |x: f64| 3.0 * x.powf(-0.75);
        let points: Vec<[f64; 2]> = (5..12)
            .map(|k| 4_f64.powi(k))
            .map(|x| [x, law(x)])
            .collect();
        let found = slope(&points).expect("seven points");
        assert!((found.exponent + 0.75).abs() < 1e-13, "{found:?}");
        assert!(found.standard_error.expect("seven points") < 1e-13);
        assert!((found.at(1e5) / law(1e5) - 1.0).abs() < 1e-12);
        assert_eq!(found.range, [1024.0, 4_f64.powi(11)]);
        assert_eq!(slope(&points[..2]).expect("two").standard_error, None);
        assert_eq!(slope(&points[..1]), None);
        assert_eq!(slope(&[]), None);
    }

    /// Checks the standard error s / sqrt(sum (x - mean)^2), where s is the scatter about the line.
    ///
    /// The residuals are +-0.1 in a pattern orthogonal to 1 and x, so the exponent stays the same.
    #[test]
    fn scatter_makes_the_standard_error() {
        let points = [(0.0, 0.1), (1.0, -0.1), (2.0, -0.1), (3.0, 0.1)];
        let points = points.map(|(x, off): (f64, f64)| [x.exp(), (-0.5 * x + off).exp()]);
        let found = slope(&points).expect("four points");
        // sum of squares 0.04 over 2 degrees of freedom; sum (x - 1.5)^2 = 5.
        let expected = (0.04_f64 / 2.0 / 5.0).sqrt();
        assert!((found.exponent + 0.5).abs() < 1e-14);
        assert!((found.standard_error.expect("four points") - expected).abs() < 1e-14);
    }

    #[test]
    fn crossings() {
        let points = [[1.0, 1e-1], [4.0, 1e-2], [16.0, 1e-3]];
        let Reached::At(seconds) = reached(&points, 10_f64.powf(-1.5)) else {
            panic!("between the first two");
        };
        assert!((seconds - 2.0).abs() < 1e-12);
        assert_eq!(reached(&points, 1e-2), Reached::At(4.0));
        assert_eq!(reached(&points, 0.5), Reached::Within(1.0));
        assert_eq!(reached(&points, 1e-4), Reached::Never);
        assert_eq!(reached(&[[1.0, 0.5], [2.0, 0.0]], 0.1), Reached::At(2.0));
        assert_eq!(reached(&[], 0.1), Reached::Never);
    }

    #[test]
    fn medians() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0]), 2.5);
        assert!(median(&mut []).is_nan());
    }
}
