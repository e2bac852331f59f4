//! Small vector charts.
//!
//! They have classes and no colours: the style sheet of the page makes them light, dark or printed.
//! kuva, which draws the pictures of `--plot`, fixes colours and a size in pixels, and needs 40 kB
//! where this needs 4 kB.

use std::fmt::Write;

use crate::report::page::markup::{escape, minus};

/// Axis of a panel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    log: bool,
}

impl Axis {
    /// Makes a linear axis from `low` to `high`.
    pub(crate) fn linear(low: f64, high: f64) -> Axis {
        // An axis of length 0 would cause a division by 0.
        let high = if high > low { high } else { low + 1.0 };
        Axis {
            low,
            high,
            log: false,
        }
    }

    /// Makes a logarithmic axis from `low`, which is above 0, to `high`.
    pub(crate) fn logarithmic(low: f64, high: f64) -> Axis {
        Axis {
            log: true,
            ..Axis::linear(low, high)
        }
    }

    /// Makes a linear axis that holds all values, with a margin of 6 % of their range.
    pub(crate) fn around(values: impl IntoIterator<Item = f64>) -> Axis {
        let (low, high) = values
            .into_iter()
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
        if low > high {
            return Axis::linear(0.0, 1.0);
        }
        let margin = (0.06 * (high - low)).max(0.01 * high.abs());
        Axis::linear(low - margin, high + margin)
    }

    /// Returns the position of a value on the axis: 0 at the low end, 1 at the high end.
    fn part(&self, value: f64) -> f64 {
        if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Returns round numbers on the axis, about `most` at the most.
    fn ticks(&self, most: usize) -> Vec<f64> {
        if self.log {
            let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
            let steps: &[f64] = if self.high / self.low > 30.0 {
                &[1.0]
            } else {
                &[1.0, 2.0, 5.0]
            };
            return decades
                .flat_map(|d| steps.iter().map(move |s| s * 10_f64.powi(d)))
                .filter(|v| (self.low..=self.high).contains(v))
                .collect();
        }
        let step = nice((self.high - self.low) / most as f64);
        let first = (self.low / step - 1e-9).ceil() as i64;
        (first..)
            .map(|k| k as f64 * step)
            .take_while(|&v| v <= self.high + 1e-9 * step)
            .collect()
    }

    /// Writes a tick with as few digits as distinguish it from its neighbours.
    fn name(&self, tick: f64, most: usize) -> String {
        let step = if self.log {
            tick
        } else {
            nice((self.high - self.low) / most as f64)
        };
        let decimals = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
        minus(format!("{:.decimals$}", tick + 0.0))
    }
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

/// Rectangle of the picture with two axes.
///
/// Lengths are in the units of the picture, whose origin is its upper left corner.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Panel {
    /// Axis across.
    pub x: Axis,
    /// Axis upwards.
    pub y: Axis,
    /// Left, top, width, height.
    pub frame: [f64; 4],
}

impl Panel {
    /// Returns the place of a point in the picture.
    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let [left, top, width, height] = self.frame;
        [
            left + width * self.x.part(x),
            top + height * (1.0 - self.y.part(y)),
        ]
    }

    /// Draws the lines of all ticks, and the numbers of the y ticks.
    ///
    /// The numbers of the x ticks are drawn if `named` is true.
    pub(crate) fn grid(&self, y_ticks: usize, named: bool) -> String {
        const X_TICKS: usize = 5;
        let [left, top, width, height] = self.frame;
        let (right, bottom) = (left + width, top + height);
        let (mut lines, mut names) = (String::new(), String::new());
        for tick in self.y.ticks(y_ticks) {
            let y = self.at(self.x.low, tick)[1];
            let _ = write!(lines, "M{left} {y:.1}H{right}");
            let _ = write!(
                names,
                "<text class=\"y\" x=\"{}\" y=\"{:.1}\">{}</text>",
                left - 5.0,
                y + 3.5,
                self.y.name(tick, y_ticks)
            );
        }
        for tick in self.x.ticks(X_TICKS) {
            let x = self.at(tick, self.y.low)[0];
            let _ = write!(lines, "M{x:.1} {top}V{bottom}");
            if named {
                let _ = write!(
                    names,
                    "<text class=\"x\" x=\"{x:.1}\" y=\"{}\">{}</text>",
                    bottom + 13.0,
                    self.x.name(tick, X_TICKS)
                );
            }
        }
        format!("<path class=\"lines\" d=\"{lines}\"/>{names}")
    }

    /// Draws the names of the axes: below, and turned on the left.
    pub(crate) fn names(&self, x: &str, y: &str) -> String {
        let [left, top, width, height] = self.frame;
        let (centre, middle) = (left + 0.5 * width, top + 0.5 * height);
        let below = if x.is_empty() {
            String::new()
        } else {
            format!(
                "<text class=\"x name\" x=\"{centre}\" y=\"{}\">{}</text>",
                top + height + 28.0,
                escape(x)
            )
        };
        format!(
            "{below}<text class=\"x name\" transform=\"translate(10 {middle}) \
            rotate(-90)\">{}</text>",
            escape(y)
        )
    }

    /// Draws a curve, and cuts it at the upper side of the panel.
    pub(crate) fn line(&self, class: &str, points: &[[f64; 2]]) -> String {
        let mut d = String::new();
        let mut pen = false;
        let mut go = |[x, y]: [f64; 2], pen: bool| {
            let [x, y] = self.at(x, y);
            let _ = write!(d, "{}{x:.1} {y:.1}", if pen { 'L' } else { 'M' });
        };
        let top = self.y.high;
        for pair in points.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let cut = |a: [f64; 2], b: [f64; 2]| {
                let part = (top - a[1]) / (b[1] - a[1]);
                [a[0] + part * (b[0] - a[0]), top]
            };
            match (a[1] <= top, b[1] <= top) {
                (true, inside) => {
                    if !pen {
                        go(a, false);
                    }
                    go(if inside { b } else { cut(a, b) }, true);
                    pen = inside;
                }
                (false, true) => {
                    go(cut(a, b), false);
                    go(b, true);
                    pen = true;
                }
                (false, false) => pen = false,
            }
        }
        format!("<path class=\"{class}\" d=\"{d}\"/>")
    }

    /// Draws round dots, as lines of no length with round ends.
    pub(crate) fn dots(&self, class: &str, points: &[[f64; 2]]) -> String {
        let mut d = String::new();
        for &[x, y] in points {
            let [x, y] = self.at(x, y);
            let _ = write!(d, "M{x:.1} {y:.1}h0");
        }
        format!("<path class=\"{class}\" d=\"{d}\"/>")
    }

    /// Draws upright bars from the first to the second y.
    pub(crate) fn bars(&self, class: &str, bars: &[(f64, [f64; 2])]) -> String {
        let mut d = String::new();
        for &(x, [low, high]) in bars {
            let ([x, low], [_, high]) = (self.at(x, low), self.at(x, high));
            let _ = write!(d, "M{x:.1} {low:.1}V{high:.1}");
        }
        format!("<path class=\"{class}\" d=\"{d}\"/>")
    }

    /// Draws a horizontal line over the whole width.
    pub(crate) fn level(&self, class: &str, y: f64) -> String {
        self.line(class, &[[self.x.low, y], [self.x.high, y]])
    }

    /// Draws a vertical line from bottom to top.
    pub(crate) fn upright(&self, class: &str, x: f64) -> String {
        self.line(class, &[[x, self.y.low], [x, self.y.high]])
    }

    /// Draws a shaded rectangle between two corners, cut at the sides of the panel.
    pub(crate) fn shade(&self, class: &str, from: [f64; 2], to: [f64; 2]) -> String {
        let limit = |axis: &Axis, v: f64| v.clamp(axis.low, axis.high);
        let inside = |[x, y]: [f64; 2]| self.at(limit(&self.x, x), limit(&self.y, y));
        let ([x0, y1], [x1, y0]) = (inside(from), inside(to));
        format!(
            "<rect class=\"{class}\" x=\"{x0:.1}\" y=\"{y0:.1}\" width=\"{:.1}\" \
            height=\"{:.1}\"/>",
            x1 - x0,
            y1 - y0
        )
    }

    /// Draws a shaded rectangle over the whole width.
    pub(crate) fn band(&self, class: &str, low: f64, high: f64) -> String {
        self.shade(class, [self.x.low, low], [self.x.high, high])
    }

    /// Draws an ellipse about 0, the image of the unit circle under the linear map `(a, 0; b, c)`.
    ///
    /// Both axes must be linear. `colour` is that of the line.
    pub(crate) fn ellipse(&self, colour: &str, [a, b, c]: [f64; 3]) -> String {
        let [x, y] = self.at(0.0, 0.0);
        let [_, _, width, height] = self.frame;
        let right = width / (self.x.high - self.x.low);
        let up = height / (self.y.high - self.y.low);
        format!(
            "<circle r=\"1\" class=\"ellipse\" stroke=\"{colour}\" transform=\"matrix({:.3} {:.3} 0 \
            {:.3} {x:.1} {y:.1})\"/>",
            a * right,
            -b * up,
            -c * up
        )
    }
}

/// Writes a picture with a description for people who do not see it.
pub(crate) fn svg([width, height]: [f64; 2], label: &str, body: &str) -> String {
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">{body}</svg>\n",
        escape(label)
    )
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
                Axis::logarithmic(0.15, 2.0),
                4,
                vec!["0.2", "0.5", "1", "2"],
            ),
            (Axis::logarithmic(3.0, 300.0), 4, vec!["10", "100"]),
        ];
        for (axis, most, wanted) in &cases {
            let found: Vec<String> = axis
                .ticks(*most)
                .iter()
                .map(|&t| axis.name(t, *most))
                .collect();
            assert_eq!(&found, wanted, "{axis:?}");
        }
        assert_eq!(cases.len(), 5);
    }

    #[test]
    fn a_curve_is_cut_where_it_leaves() {
        let panel = Panel {
            x: Axis::linear(0.0, 4.0),
            y: Axis::linear(0.0, 1.0),
            frame: [0.0, 0.0, 40.0, 10.0],
        };
        let curve = [[0.0, 2.0], [1.0, 0.0], [2.0, 0.5], [3.0, 1.5], [4.0, 2.0]];
        assert_eq!(
            panel.line("c", &curve),
            "<path class=\"c\" d=\"M5.0 0.0L10.0 10.0L20.0 5.0L25.0 0.0\"/>"
        );
    }

    #[test]
    fn an_ellipse_is_the_image_of_the_circle() {
        let panel = Panel {
            x: Axis::linear(-2.0, 2.0),
            y: Axis::linear(-1.0, 1.0),
            frame: [0.0, 0.0, 40.0, 40.0],
        };
        // (1, 0) goes to (1, 0.5), which is 10 to the right and 10 up. (0, 1) goes to (0, 0.25),
        // which is 5 up.
        assert!(
            panel
                .ellipse("", [1.0, 0.5, 0.25])
                .contains("matrix(10.000 -10.000 0 -5.000 20.0 20.0)")
        );
    }
}
