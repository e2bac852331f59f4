//! Inside of a panel: axes, polygons and bins.

use crate::plots::colours::{STEPS, Scale, colour};
use crate::plots::content::{Bins, Content, Extent};
use glam::DVec2;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};
use std::fmt::Write;

/// Largest number of polygons whose outlines are drawn; more would hide the colours.
const MOST_OUTLINES: usize = 200;

/// Axes of a panel.
pub(crate) struct Axes {
    /// Range of both axes, which have one scale.
    pub(crate) extent: Extent,
    /// Upper left corner, pixels.
    pub(crate) corner: DVec2,
    /// Width and height, pixels.
    pub(crate) size: DVec2,
    /// True if the numbers of the upward axis stand beside this panel.
    pub(crate) is_left: bool,
    /// True if the numbers of the axis to the right stand below this panel.
    pub(crate) is_lowest: bool,
}

impl Axes {
    /// Returns the place of a point, pixels from the upper left corner of the picture.
    fn at(&self, point: DVec2) -> DVec2 {
        let (low, high) = self.extent;
        let part = (point - low) / (high - low);
        self.corner + self.size * DVec2::new(part.x, 1.0 - part.y)
    }
}

/// Returns the smallest of 1, 2, 5 times a power of ten that is at least `step`.
pub(crate) fn nice(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    let found = steps.into_iter().find(|&s| s >= step * (1.0 - 1e-9));
    found.unwrap_or(10.0 * power)
}

/// Writes a tick with as few decimals as its step needs.
pub(crate) fn name(tick: f64, step: f64) -> String {
    let decimals = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
    format!("{:.decimals$}", tick + 0.0).replace('-', "\u{2212}")
}

/// Returns a line of the frame.
pub(crate) fn pen([x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) -> Primitive {
    Primitive::Line {
        x1,
        y1,
        x2,
        y2,
        stroke: Color::from("#59636e"),
        stroke_width: 1.0,
        stroke_dasharray: None,
    }
}

/// Draws the frame of a panel with its ticks.
pub(crate) fn grid(scene: &mut Scene, axes: &Axes) {
    let (from, to) = (axes.corner, axes.corner + axes.size);
    let (low, high) = axes.extent;
    scene.add(Primitive::Rect {
        x: from.x,
        y: from.y,
        width: axes.size.x,
        height: axes.size.y,
        fill: Color::None,
        stroke: Some(Color::from("#59636e")),
        stroke_width: Some(1.0),
        opacity: None,
    });
    // The same step on both axes shows that they have one scale.
    let step = nice((high.x - low.x) / 5.0);
    let number = |[x, y]: [f64; 2], anchor: TextAnchor, tick: f64| Primitive::Text {
        x,
        y,
        content: name(tick, step),
        size: 11,
        anchor,
        rotate: None,
        bold: false,
        color: Some(Color::from("#1d2226")),
    };
    for tick in ticks(low.x, high.x, step) {
        let x = axes.at(DVec2::new(tick, low.y)).x;
        scene.add(pen([x, to.y - 4.0], [x, to.y]));
        if axes.is_lowest {
            scene.add(number([x, to.y + 14.0], TextAnchor::Middle, tick));
        }
    }
    for tick in ticks(low.y, high.y, step) {
        let y = axes.at(DVec2::new(low.x, tick)).y;
        scene.add(pen([from.x, y], [from.x + 4.0, y]));
        if axes.is_left {
            scene.add(number([from.x - 5.0, y + 4.0], TextAnchor::End, tick));
        }
    }
}

/// Returns the multiples of `step` from `low` to `high`.
fn ticks(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step).ceil() as i64;
    (first..)
        .map(move |k| k as f64 * step)
        .take_while(move |&tick| tick <= high)
}

/// Draws polygons or bins, one path for each step of the scale of colours.
pub(crate) fn tiles(scene: &mut Scene, content: &Content, axes: &Axes, scale: &Scale) {
    let mut paths = vec![String::new(); STEPS + 1];
    match content {
        Content::Polygons(pieces, _) => {
            for piece in pieces {
                if let Some(step) = scale.step(piece.density) {
                    outline(&mut paths[step], &piece.polygon, axes);
                }
            }
        }
        Content::Bins(bins) => runs(&mut paths, bins, axes, scale),
    }
    for (step, d) in paths.into_iter().enumerate().filter(|(_, d)| !d.is_empty()) {
        // The line in the colour of its area hides the gap to the neighbours.
        let line = (colour(step), 0.4);
        scene.add(path(d, Some(colour(step)), line));
    }
    if let Content::Polygons(_, outlines) = content
        && outlines.len() <= MOST_OUTLINES
    {
        let mut d = String::new();
        for polygon in outlines {
            outline(&mut d, polygon, axes);
        }
        scene.add(path(d, None, (Color::from("#3c3c3c"), 0.4)));
    }
}

/// Returns a path with its colour and the colour and width of its line.
fn path(d: String, fill: Option<Color>, (stroke, stroke_width): (Color, f64)) -> Primitive {
    Primitive::Path(Box::new(PathData {
        d,
        fill,
        stroke,
        stroke_width,
        opacity: None,
        stroke_dasharray: None,
    }))
}

/// Appends a closed polygon to the data of a path.
fn outline(d: &mut String, polygon: &[DVec2], axes: &Axes) {
    for (k, &corner) in polygon.iter().enumerate() {
        let at = axes.at(corner);
        // Writing to a String cannot fail.
        let _ = write!(
            d,
            "{}{:.2} {:.2}",
            if k == 0 { 'M' } else { 'L' },
            at.x,
            at.y
        );
    }
    d.push('Z');
}

/// Appends the bins of each row, neighbours of one step as one rectangle.
fn runs(paths: &mut [String], bins: &Bins, axes: &Axes, scale: &Scale) {
    for (y, row) in bins.density.iter().enumerate() {
        let mut from = 0;
        for x in 0..row.len() {
            let own = scale.step(row[x]);
            if row.get(x + 1).map(|&next| scale.step(next)) == Some(own) {
                continue;
            }
            if let Some(own) = own {
                let place =
                    |x: usize, y: usize| bins.corner + bins.width * DVec2::new(x as f64, y as f64);
                let (a, c) = (place(from, y), place(x + 1, y + 1));
                let corners = [a, DVec2::new(c.x, a.y), c, DVec2::new(a.x, c.y)];
                outline(&mut paths[own], &corners, axes);
            }
            from = x + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes() -> Axes {
        Axes {
            extent: (DVec2::ZERO, DVec2::new(4.0, 2.0)),
            corner: DVec2::new(10.0, 20.0),
            size: DVec2::new(40.0, 20.0),
            is_left: true,
            is_lowest: true,
        }
    }

    #[test]
    fn neighbours_of_one_step_are_one_rectangle() {
        let bins = Bins {
            density: vec![vec![0.0, 2.0, 2.0, 1.0], vec![0.0; 4]],
            corner: DVec2::ZERO,
            width: 1.0,
        };
        let mut paths = vec![String::new(); STEPS + 1];
        let scale = Scale::of(vec![[1.0, 1.0], [2.0, 2.0], [2.0, 2.0]]);
        runs(&mut paths, &bins, &axes(), &scale);
        let filled: Vec<(usize, &str)> = paths
            .iter()
            .enumerate()
            .filter(|(_, d)| !d.is_empty())
            .map(|(step, d)| (step, d.as_str()))
            .collect();
        let half = "M40.00 40.00L50.00 40.00L50.00 30.00L40.00 30.00Z";
        let full = "M20.00 40.00L40.00 40.00L40.00 30.00L20.00 30.00Z";
        assert_eq!(filled, [(32, half), (64, full)]);
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let found: Vec<String> = ticks(-1.1, 0.9, nice(0.4)).map(|t| name(t, 0.5)).collect();
        assert_eq!(found, ["\u{2212}1.0", "\u{2212}0.5", "0.0", "0.5"]);
        assert_eq!((nice(0.011), nice(3.0), nice(0.5)), (0.02, 5.0, 0.5));
    }
}
