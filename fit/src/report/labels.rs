//! Names of curves at their ends, in place of a legend.

use kuva::prelude::{Layout, TextAnnotation};

/// Width and height of the axes of a panel, pixels, about.
const PANEL: [f64; 2] = [290.0, 220.0];

/// Width of a letter and height of a line of a name, pixels.
const LETTER: f64 = 6.5;
const LINE: f64 = 13.0;

/// Part of the width of a panel that names may take at most.
const MOST: f64 = 0.3;

/// End of a curve.
pub(crate) struct End {
    /// Name of the curve.
    pub name: String,
    /// Last point; its height is from 0 to 1.
    pub point: (f64, f64),
}

/// Names right of the ends of all curves of a panel.
pub(crate) struct Labels {
    names: Vec<TextAnnotation>,
    end: f64,
}

impl Labels {
    /// Places the names behind the ends of curves that begin at `first`.
    ///
    /// Returns `None` if names would cover each other or a curve, or are too long: then the panel
    /// needs a legend.
    pub(crate) fn of(ends: &[End], first: f64) -> Option<Labels> {
        let last = ends.first()?.point.0;
        let letters = ends.iter().map(|end| end.name.chars().count()).max()?;
        let width = (LETTER * letters as f64 + 10.0) / PANEL[0];
        // A curve that ends before the others would run into their names.
        let is_level = ends.iter().all(|end| end.point.0 == last);
        if !is_level || last <= first || width > MOST {
            return None;
        }
        // A name does not cover the axis that its curve ends on.
        let apart = LINE / PANEL[1];
        let height = |end: &End| end.point.1.clamp(0.6 * apart, 1.0 - 0.6 * apart);
        let mut heights: Vec<f64> = ends.iter().map(height).collect();
        heights.sort_by(f64::total_cmp);
        if heights.windows(2).any(|pair| pair[1] - pair[0] < apart) {
            return None;
        }
        let span = (last - first) / (1.0 - width);
        let names = ends.iter().map(|end| {
            // The library centres a text, and raises it by 6 pixels.
            let x = last + 0.5 * width * span;
            let y = height(end) - 10.0 / PANEL[1];
            TextAnnotation::new(&end.name, x, y).with_font_size(11)
        });
        Some(Labels {
            names: names.collect(),
            end: first + span,
        })
    }

    /// Adds the names to a panel, and makes its axis long enough for them.
    pub(crate) fn on(self, layout: Layout) -> Layout {
        let layout = layout.with_x_axis_max(self.end);
        self.names.into_iter().fold(layout, Layout::with_annotation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(name: &str, x: f64, y: f64) -> End {
        End {
            name: name.into(),
            point: (x, y),
        }
    }

    /// Checks that names that would cover each other or a curve are left to the legend: two lines
    /// of 13 pixels need 0.0591 of the 220 pixels of a panel.
    #[test]
    fn names_that_collide_are_left_to_the_legend() {
        let cases = [
            (vec![end("0°", 4.0, 0.5), end("20°", 4.0, 0.44)], true),
            (vec![end("0°", 4.0, 0.5), end("20°", 4.0, 0.445)], false),
            (vec![end("0°", 4.0, 0.5), end("20°", 3.0, 0.2)], false),
            (vec![end("a name of twenty and", 4.0, 0.5)], false),
            (vec![end("0°", 0.0, 0.5)], false),
            (vec![end("0°", 4.0, 0.06), end("20°", 4.0, 0.0)], false),
            (vec![end("0°", 4.0, 0.1), end("20°", 4.0, 0.0)], true),
            (Vec::new(), false),
        ];
        for (ends, expected) in &cases {
            assert_eq!(Labels::of(ends, 0.0).is_some(), *expected);
        }
        // Two letters take 23 of 290 pixels at the right, in which no curve runs.
        let labels = Labels::of(&[end("0°", 4.0, 0.5)], 0.0).expect("one name");
        assert!((labels.end * (1.0 - 23.0 / 290.0) - 4.0).abs() < 1e-12);
        assert!(labels.names[0].text_x > 4.0 && labels.names[0].text_x < labels.end);
    }
}
