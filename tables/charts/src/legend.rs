//! Legends: keys of curves or a scale of colours, one of them a figure.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::axis::Axis;
use crate::colour::{PALETTE, STEPS};
use crate::image::png;
use crate::panel::text;
use crate::text::{HEAD, SMALL, width, wrap};

/// Style of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// Without gaps.
    #[default]
    Solid,
    /// Strokes.
    Dashed,
    /// Dots.
    Dotted,
    /// Strokes and dots.
    Dashdot,
}

impl Dash {
    /// All styles.
    pub const ALL: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::Dotted, Dash::Dashdot];

    /// Returns the class of the style sheet.
    pub(crate) const fn class(self) -> &'static str {
        match self {
            Dash::Solid => "solid",
            Dash::Dashed => "dashed",
            Dash::Dotted => "dotted",
            Dash::Dashdot => "dashdot",
        }
    }
}

/// Colour and style of a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stroke {
    /// Colour, as `#rrggbb`.
    pub colour: String,
    /// Style.
    pub dash: Dash,
}

impl Stroke {
    /// Makes a line without gaps.
    pub fn solid(colour: impl Into<String>) -> Stroke {
        Stroke {
            colour: colour.into(),
            dash: Dash::Solid,
        }
    }

    /// Makes a grey line, for limits and for keys of which only the style counts.
    pub fn grey(dash: Dash) -> Stroke {
        let [_, _, (_, soft), _] = PALETTE;
        Stroke {
            colour: soft.into(),
            dash,
        }
    }
}

/// Key of a legend: a piece of line, and what it means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key {
    /// What the line means.
    pub name: String,
    /// Line.
    pub stroke: Stroke,
}

/// Scale of colours from 0 to `highest`, or of differences from -`highest` to `highest`.
#[derive(Debug, Clone)]
pub struct Bar {
    /// Value of the darkest colour.
    pub highest: f64,
    /// True for the scale of differences.
    pub is_signed: bool,
    /// Quantity that the colours show.
    pub name: String,
}

/// Length of the line of a key, pixels, and space behind it and between two keys.
const LINE: f64 = 22.0;
const BEHIND: f64 = 6.0;
const BETWEEN: f64 = 18.0;

/// Height of a line of a legend.
const ROW: f64 = 16.0;

/// Draws keys in rows of at most `most` pixels below `top`; returns them and the height of all.
pub(crate) fn keys(keys: &[Key], [left, top]: [f64; 2], most: f64) -> (String, f64) {
    let mut out = String::new();
    let (mut x, mut y, mut row) = (0.0, 0.0, 0.0_f64);
    for key in keys {
        let lines = wrap(&key.name, SMALL, most - LINE - BEHIND);
        let widest = lines
            .iter()
            .map(|line| width(line, SMALL))
            .fold(0.0, f64::max);
        let wide = LINE + BEHIND + widest;
        if x > 0.0 && x + wide > most {
            (x, y, row) = (0.0, y + row, 0.0);
        }
        let (at, middle) = (left + x, top + y + 0.5 * ROW);
        out.push_str(&format!(
            "<path class=\"{}\" stroke=\"{}\" d=\"M{at:.1} {middle:.1}h{LINE}\"/>",
            key.stroke.dash.class(),
            key.stroke.colour
        ));
        for (k, line) in lines.iter().enumerate() {
            let base = middle + 4.0 + ROW * k as f64;
            out.push_str(&text("name", [at + LINE + BEHIND, base], line));
        }
        row = row.max(ROW * lines.len() as f64);
        x += wide + BETWEEN;
    }
    (out, y + row)
}

/// Draws a scale of colours below `top`; returns it and its height.
pub(crate) fn bar(bar: &Bar, [left, top]: [f64; 2], most: f64) -> (String, f64) {
    const THICK: f64 = 12.0;
    let long = most.min(300.0);
    let steps: Vec<u8> = (1..=STEPS).collect();
    let mut out = format!(
        "<image x=\"{left}\" y=\"{top}\" width=\"{long}\" height=\"{THICK}\" \
         preserveAspectRatio=\"none\" href=\"data:image/png;base64,{}\"/>",
        STANDARD.encode(png(steps.len(), &steps, bar.is_signed))
    );
    let lowest = if bar.is_signed { -bar.highest } else { 0.0 };
    let axis = Axis::linear(lowest, bar.highest);
    for (tick, name) in axis.ticks(4) {
        let x = left + long * axis.part(tick);
        out.push_str(&format!(
            "<path class=\"lines\" d=\"M{x:.1} {}v4\"/>{}",
            top + THICK,
            text("x", [x, top + THICK + 15.0], &name)
        ));
    }
    let mut base = top + THICK + 31.0;
    for line in wrap(&bar.name, HEAD, most) {
        out.push_str(&text("name", [left, base], &line));
        base += ROW;
    }
    (out, base - top - ROW + 6.0)
}
