//! Axes and the round numbers on them.

use crate::text::minus;

/// Axis of a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    low: f64,
    high: f64,
    log: bool,
    /// Names of the places 1, 2, 3 and so on, in place of numbers.
    names: &'static [&'static str],
}

impl Axis {
    /// Makes a linear axis from `low` to `high`.
    pub fn linear(low: f64, high: f64) -> Axis {
        let low = if low.is_finite() { low } else { 0.0 };
        // An axis of length 0 would cause a division by 0.
        let high = match high > low && high.is_finite() {
            true => high,
            false => low + low.abs().max(1.0),
        };
        Axis {
            low,
            high,
            log: false,
            names: &[],
        }
    }

    /// Makes a logarithmic axis from `low` to `high`; from 1 to 10 if `low` is not above 0.
    pub fn logarithmic(low: f64, high: f64) -> Axis {
        let axis = match low > 0.0 && low.is_finite() {
            true => Axis::linear(low, high),
            false => Axis::linear(1.0, 10.0),
        };
        Axis { log: true, ..axis }
    }

    /// Makes an axis with names at the places 1, 2, 3 and so on.
    pub fn named(names: &'static [&'static str]) -> Axis {
        let axis = Axis::linear(0.5, names.len() as f64 + 0.5);
        Axis { names, ..axis }
    }

    /// Makes a linear axis that holds all values, with a margin of 6 % of their range.
    pub fn around(values: impl IntoIterator<Item = f64>) -> Axis {
        let (low, high) = range(values.into_iter().filter(|v| v.is_finite()));
        if low > high {
            return Axis::linear(0.0, 1.0);
        }
        let margin = (0.06 * (high - low)).max(0.01 * high.abs());
        Axis::linear(low - margin, high + margin)
    }

    /// Makes a logarithmic axis that holds all values above 0, with a margin of 6 % of their range.
    pub fn decades(values: impl IntoIterator<Item = f64>) -> Axis {
        let (low, high) = range(values.into_iter().filter(|v| *v > 0.0 && v.is_finite()));
        let margin = (high / low).powf(0.06).max(1.05);
        Axis::logarithmic(low / margin, high * margin)
    }

    /// Returns the ends of the axis.
    pub fn ends(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Returns the position of a value on the axis: 0 at the low end, 1 at the high end.
    pub(crate) fn part(&self, value: f64) -> f64 {
        if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Returns round numbers on the axis, about `most` at the most, and how they are written: with
    /// as few digits as distinguish them.
    pub(crate) fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        if !self.names.is_empty() {
            let places = (1..).map(f64::from);
            return places
                .zip(self.names.iter().map(|n| n.to_string()))
                .collect();
        }
        let ratio = self.high / self.low;
        if self.log && ratio >= 5.0 {
            let ends = [self.low.log10().floor(), self.high.log10().ceil()];
            let decades = ends[0] as i32..=ends[1] as i32;
            let steps: &[f64] = if ratio > 120.0 {
                &[1.0]
            } else {
                &[1.0, 2.0, 5.0]
            };
            // Every second decade, every third and so on if there are many.
            let stride = ((ends[1] - ends[0]) as usize / (most + 1)) as i32 + 1;
            return decades
                .filter(|d| d.rem_euclid(stride) == 0)
                .flat_map(|d| steps.iter().map(move |s| s * 10_f64.powi(d)))
                .filter(|v| (self.low..=self.high).contains(v))
                .map(|v| (v, written(v, v)))
                .collect();
        }
        let step = nice((self.high - self.low) / most as f64);
        let first = (self.low / step - 1e-9).ceil();
        (0..=2 * most)
            .map(|k| (first + k as f64) * step)
            .take_while(|&v| v <= self.high + 1e-9 * step)
            .map(|v| (v, written(v, step)))
            .collect()
    }
}

/// Returns the smallest and the largest of some values.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    })
}

/// Writes a multiple of `step`, as a power of ten if it would be long.
fn written(tick: f64, step: f64) -> String {
    let power = (step.log10() + 1e-9).floor();
    if tick != 0.0 && (tick.abs() >= 1e6 || power < -5.0) {
        let digits = (tick.abs().log10().floor() - power).max(0.0) as usize;
        return minus(format!("{tick:.digits$e}"));
    }
    let decimals = (-power).clamp(0.0, 5.0) as usize;
    minus(format!("{:.decimals$}", tick + 0.0))
}

/// Returns the smallest of 1, 2, 5 times a power of ten that is at least `step`.
fn nice(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * power)
        .into_iter()
        .find(|&s| s >= step * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let cases = [
            (Axis::linear(0.0, 3.3), 5, vec!["0", "1", "2", "3"]),
            (
                Axis::linear(-0.5, 0.5),
                4,
                vec!["\u{2212}0.5", "0.0", "0.5"],
            ),
            (
                Axis::linear(0.238, 0.2421),
                4,
                vec!["0.238", "0.240", "0.242"],
            ),
            (
                Axis::linear(0.0, 2.5e6),
                5,
                vec!["0", "500000", "1.0e6", "1.5e6", "2.0e6", "2.5e6"],
            ),
            (
                Axis::logarithmic(0.15, 2.0),
                4,
                vec!["0.2", "0.5", "1", "2"],
            ),
            (
                Axis::logarithmic(3.0, 300.0),
                4,
                vec!["5", "10", "20", "50", "100", "200"],
            ),
            (Axis::logarithmic(2.0, 300.0), 4, vec!["10", "100"]),
            (
                Axis::logarithmic(2.1, 4.0),
                4,
                vec!["2.5", "3.0", "3.5", "4.0"],
            ),
            (
                Axis::logarithmic(1e-9, 1.0),
                4,
                vec!["1e\u{2212}8", "1e\u{2212}6", "0.0001", "0.01", "1"],
            ),
            (Axis::named(&["c", "mu"]), 4, vec!["c", "mu"]),
            (Axis::around([f64::NAN]), 2, vec!["0.0", "0.5", "1.0"]),
            (Axis::decades([0.0, -1.0]), 5, vec!["1", "2", "5", "10"]),
        ];
        for (axis, most, wanted) in &cases {
            let found: Vec<String> = axis.ticks(*most).into_iter().map(|t| t.1).collect();
            assert_eq!(&found, wanted, "{axis:?}");
        }
    }

    /// Checks that axes of one value, of no value and of values without end have a length.
    #[test]
    fn every_axis_has_a_length() {
        let odd = [0.0, 1.0, -1e300, 1e17, f64::NAN, f64::INFINITY];
        for a in odd {
            for b in odd {
                let axes = [
                    Axis::linear(a, b),
                    Axis::logarithmic(a, b),
                    Axis::around([a, b]),
                    Axis::decades([a, b]),
                ];
                for axis in axes {
                    let [low, high] = axis.ends();
                    assert!(
                        low < high && axis.part(low) == 0.0,
                        "{axis:?} of {a} and {b}"
                    );
                    assert!(axis.ticks(5).len() <= 11);
                }
            }
        }
    }
}
