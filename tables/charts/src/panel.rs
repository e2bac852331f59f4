//! Panels: what is drawn between two axes, as markup with classes and no colours.

use std::fmt::Write;

use crate::axis::Axis;
use crate::text::{SMALL, escape, width};

/// Number of ticks across, about.
pub(crate) const ACROSS: usize = 5;

/// Rectangle of the picture with two axes.
///
/// Lengths are in the units of the picture, whose origin is its upper left corner.
#[derive(Debug, Clone, Copy)]
pub struct Panel {
    /// Axis across.
    pub x: Axis,
    /// Axis upwards.
    pub y: Axis,
    /// Left, top, width, height.
    pub frame: [f64; 4],
}

impl Panel {
    /// Returns the place of a point in the picture.
    pub(crate) fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let [left, top, width, height] = self.frame;
        [
            left + width * self.x.part(x),
            top + height * (1.0 - self.y.part(y)),
        ]
    }

    /// Draws the lines of all ticks, and the numbers of the y ticks.
    ///
    /// The numbers of the x ticks are drawn if `named` is true.
    pub fn grid(&self, y_ticks: usize, named: bool) -> String {
        self.ruled(y_ticks, [named, true])
    }

    /// Draws the lines of all ticks, and the numbers along the axes for which `named` is true.
    pub(crate) fn ruled(&self, y_ticks: usize, named: [bool; 2]) -> String {
        let [left, top, width_of, height] = self.frame;
        let (right, bottom) = (left + width_of, top + height);
        let (mut lines, mut names) = (String::new(), String::new());
        for (tick, name) in self.y.ticks(y_ticks) {
            let y = self.at(self.x.ends()[0], tick)[1];
            let _ = write!(lines, "M{left} {y:.1}H{right}");
            if named[1] {
                names.push_str(&text("y", [left - 5.0, y + 3.5], &name));
            }
        }
        let mut free = f64::NEG_INFINITY;
        for (tick, name) in self.x.ticks(ACROSS) {
            let x = self.at(tick, self.y.ends()[0])[0];
            let _ = write!(lines, "M{x:.1} {top}V{bottom}");
            let half = 0.5 * width(&name, SMALL);
            // A number that would cover the one before is left out.
            if named[0] && x - half > free {
                names.push_str(&text("x", [x, bottom + 15.0], &name));
                free = x + half + 2.0;
            }
        }
        format!("<path class=\"lines\" d=\"{lines}\"/>{names}")
    }

    /// Draws the names of the axes: below, and turned on the left.
    pub fn names(&self, x: &str, y: &str) -> String {
        let [left, top, width, height] = self.frame;
        let below = match x {
            "" => String::new(),
            x => text("x name", [left + 0.5 * width, top + height + 29.0], x),
        };
        below + &turned([10.0, top + 0.5 * height], y)
    }

    /// Draws a curve, cut at the lower and upper sides of the panel and where a value is none.
    pub fn line(&self, class: &str, points: &[[f64; 2]]) -> String {
        format!("<path class=\"{class}\" d=\"{}\"/>", self.path(points))
    }

    /// Returns a curve as the data of a path.
    pub(crate) fn path(&self, points: &[[f64; 2]]) -> String {
        let [_, top, _, height] = self.frame;
        let mut d = String::new();
        let mut pen = None;
        for pair in points.windows(2) {
            let [a, b] = [0, 1].map(|k| self.at(pair[k][0], pair[k][1]));
            let Some([from, to]) = cut(a, b, [top, top + height]) else {
                pen = None;
                continue;
            };
            if pen != Some(from) {
                let _ = write!(d, "M{:.1} {:.1}", from[0], from[1]);
            }
            let _ = write!(d, "L{:.1} {:.1}", to[0], to[1]);
            pen = Some(to);
        }
        d
    }

    /// Draws the area within a line, without its places that are none.
    pub(crate) fn area(&self, class: &str, colour: &str, around: &[[f64; 2]]) -> String {
        let [_, top, _, height] = self.frame;
        let places = around.iter().map(|&[x, y]| self.at(x, y));
        let places = places.filter(|at| at.iter().all(|v| v.is_finite()));
        let d: String = places
            .map(|[x, y]| format!("{x:.1} {:.1} ", y.clamp(top, top + height)))
            .collect();
        format!(
            "<polygon class=\"{class}\" fill=\"{colour}\" points=\"{}\"/>",
            d.trim_end()
        )
    }

    /// Draws round dots, as lines of no length with round ends.
    pub fn dots(&self, class: &str, points: &[[f64; 2]]) -> String {
        format!("<path class=\"{class}\" d=\"{}\"/>", self.spots(points))
    }

    /// Returns the dots that lie in the panel as the data of a path.
    pub(crate) fn spots(&self, points: &[[f64; 2]]) -> String {
        let [left, top, width, height] = self.frame;
        let mut d = String::new();
        for &[x, y] in points {
            let [x, y] = self.at(x, y);
            let inside = (left - 0.5..=left + width + 0.5).contains(&x)
                && (top - 0.5..=top + height + 0.5).contains(&y);
            if inside {
                let _ = write!(d, "M{x:.1} {y:.1}h0");
            }
        }
        d
    }

    /// Draws upright bars from the first to the second y.
    pub fn bars(&self, class: &str, bars: &[(f64, [f64; 2])]) -> String {
        let lines = bars
            .iter()
            .map(|&(x, [low, high])| self.path(&[[x, low], [x, high]]));
        format!(
            "<path class=\"{class}\" d=\"{}\"/>",
            lines.collect::<String>()
        )
    }

    /// Draws a horizontal line over the whole width.
    pub fn level(&self, class: &str, y: f64) -> String {
        let [low, high] = self.x.ends();
        self.line(class, &[[low, y], [high, y]])
    }

    /// Draws a vertical line from bottom to top.
    pub fn upright(&self, class: &str, x: f64) -> String {
        let [low, high] = self.y.ends();
        self.line(class, &[[x, low], [x, high]])
    }

    /// Draws a shaded rectangle between two corners, cut at the sides of the panel.
    pub fn shade(&self, class: &str, from: [f64; 2], to: [f64; 2]) -> String {
        let limit = |axis: &Axis, v: f64| v.clamp(axis.ends()[0], axis.ends()[1]);
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
    pub fn band(&self, class: &str, low: f64, high: f64) -> String {
        let [left, right] = self.x.ends();
        self.shade(class, [left, low], [right, high])
    }

    /// Draws an ellipse about 0, the image of the unit circle under the linear map `(a, 0; b, c)`.
    ///
    /// Both axes must be linear. `colour` is that of the line.
    pub fn ellipse(&self, colour: &str, [a, b, c]: [f64; 3]) -> String {
        let [x, y] = self.at(0.0, 0.0);
        let [_, _, width, height] = self.frame;
        let right = width * (self.x.part(1.0) - self.x.part(0.0));
        let up = height * (self.y.part(1.0) - self.y.part(0.0));
        format!(
            "<circle r=\"1\" class=\"ellipse\" stroke=\"{colour}\" transform=\"matrix({:.3} {:.3} 0 \
            {:.3} {x:.1} {y:.1})\"/>",
            a * right,
            -b * up,
            -c * up
        )
    }
}

/// Returns the part of a line between two heights; `None` if there is none, or a place is none.
fn cut(a: [f64; 2], b: [f64; 2], [top, bottom]: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    if !a.iter().chain(&b).all(|v| v.is_finite()) {
        return None;
    }
    let limited = |from: [f64; 2], to: [f64; 2]| {
        let y = from[1].clamp(top, bottom);
        let part = if y == from[1] {
            0.0
        } else {
            (y - from[1]) / (to[1] - from[1])
        };
        (0.0..=1.0)
            .contains(&part)
            .then(|| [from[0] + part * (to[0] - from[0]), y])
    };
    Some([limited(a, b)?, limited(b, a)?])
}

/// Writes a text at a place; its class says what is at that place: `x` its middle, `y` its end, and
/// else its beginning.
pub(crate) fn text(class: &str, [x, y]: [f64; 2], content: &str) -> String {
    let content = escape(content);
    format!("<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{content}</text>")
}

/// Writes the name of an axis, turned to read upward; the place is that of its middle.
pub(crate) fn turned([x, y]: [f64; 2], content: &str) -> String {
    let content = escape(content);
    format!(
        "<text class=\"x name\" transform=\"translate({x:.1} {y:.1}) rotate(-90)\">{content}</text>"
    )
}

/// Writes a picture with a description for people who do not see it.
pub fn svg([width, height]: [f64; 2], label: &str, body: &str) -> String {
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">{body}</svg>\n",
        escape(label)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_cut_where_it_leaves() {
        let panel = Panel {
            x: Axis::linear(0.0, 4.0),
            y: Axis::linear(0.0, 1.0),
            frame: [0.0, 0.0, 40.0, 10.0],
        };
        let curve = [[0.0, 2.0], [1.0, 0.0], [2.0, 0.5], [3.0, 1.5], [4.0, 2.0]];
        assert_eq!(panel.path(&curve), "M5.0 0.0L10.0 10.0L20.0 5.0L25.0 0.0");
        let below = [[0.0, -1.0], [2.0, 1.0], [4.0, -1.0]];
        assert_eq!(panel.path(&below), "M10.0 10.0L20.0 0.0L30.0 10.0");
        let gap = [
            [0.0, 0.5],
            [1.0, 0.5],
            [2.0, f64::NAN],
            [3.0, 0.5],
            [4.0, 0.5],
        ];
        assert_eq!(panel.path(&gap), "M0.0 5.0L10.0 5.0M30.0 5.0L40.0 5.0");
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
