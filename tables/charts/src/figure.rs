//! Figures that stand alone: a title, one legend at most, and panels in rows.

use crate::colour::PALETTE;
use crate::facet::Facet;
use crate::legend::{Bar, Key, bar, keys};
use crate::panel::{Panel, text, turned};
use crate::text::{HEAD, LINE, SMALL, TITLE, escape, width, wrap};

/// Panels under one title.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Title.
    pub title: String,
    /// Text below the title.
    pub note: String,
    /// Panels, row by row.
    pub facets: Vec<Facet>,
    /// Number of panels beside each other.
    pub columns: usize,
    /// Width and height between the axes of a panel, pixels.
    pub frame: [f64; 2],
    /// Legend where the names of the curves do not fit at their ends; if empty, these names.
    pub keys: Vec<Key>,
    /// Scale of the colours of cells.
    pub bar: Option<Bar>,
}

/// Space around the figure, pixels.
const AROUND: f64 = 16.0;

/// Space for the numbers below a panel, and for the name of the axis below them.
const NUMBERS: f64 = 20.0;
const NAME: f64 = 17.0;

/// Space between panels beside each other, and below each other, without texts.
const BETWEEN: [f64; 2] = [24.0, 12.0];

/// Least width of a figure, for its title.
const LEAST: f64 = 360.0;

impl Figure {
    /// Makes a figure; panels are the smaller the more there are.
    pub fn new(title: impl Into<String>, facets: Vec<Facet>, columns: usize) -> Figure {
        Figure {
            title: title.into(),
            note: String::new(),
            columns,
            frame: match facets.len() {
                0 | 1 => [520.0, 320.0],
                2..=4 => [320.0, 220.0],
                _ => [220.0, 160.0],
            },
            facets,
            keys: Vec::new(),
            bar: None,
        }
    }

    /// Draws the figure as a file that needs nothing else.
    #[allow(
        clippy::too_many_lines,
        reason = "each step of the layout needs the places of those before"
    )]
    pub fn svg(&self) -> String {
        let columns = self.columns.clamp(1, self.facets.len().max(1));
        let rows = self.facets.len().div_ceil(columns);
        let [wide, high] = self.frame;
        // Panels with the same axes show the numbers at the sides of the figure only.
        let is_shared = self
            .facets
            .windows(2)
            .all(|pair| pair[0].axes == pair[1].axes && pair[0].names == pair[1].names);
        let is_direct = self
            .facets
            .iter()
            .all(|facet| facet.are_ends_apart(self.frame));
        let labels = self.facets.iter().flat_map(|facet| &facet.curves);
        let labels = labels
            .map(|curve| width(&curve.name, SMALL))
            .fold(0.0, f64::max);
        let labels = if is_direct && labels > 0.0 {
            labels + 6.0
        } else {
            0.0
        };

        // Where the panels are: the numbers and the names of the axes need space on the left.
        let along = match is_shared {
            true => high * rows as f64,
            false => high,
        };
        let names = |facet: &Facet| wrap(&facet.names[1], SMALL, along);
        let named = self
            .facets
            .iter()
            .map(|facet| names(facet).len())
            .max()
            .unwrap_or(0);
        let numbers = self
            .facets
            .iter()
            .map(|facet| facet.numbers(high))
            .fold(0.0, f64::max);
        let beside = LINE * named as f64 + numbers + 9.0;
        let left = AROUND + beside;
        // The last number of a panel does not meet the first one of the next.
        let across = self.facets.iter().flat_map(Facet::across);
        let across = across.fold(BETWEEN[0], f64::max);
        let pitch_x = wide + labels + across + if is_shared { 0.0 } else { beside };
        let right = left + pitch_x * (columns - 1) as f64 + wide;
        let total = (right + labels.max(across) + AROUND).max(LEAST);

        // Above the panels.
        let most = total - 2.0 * AROUND;
        let mut body = String::new();
        let mut y = AROUND;
        for (class, size, content) in [
            ("name title", TITLE, &self.title),
            ("name head", HEAD, &self.note),
        ] {
            for line in wrap(content, size, most)
                .iter()
                .filter(|line| !line.is_empty())
            {
                body.push_str(&text(class, [AROUND, y + size], line));
                y += size + 5.0;
            }
        }
        y += 6.0;
        let found = self.keys_of_curves();
        let legend = match &self.bar {
            Some(scale) if scale.highest > 0.0 => bar(scale, [left, y], most - beside),
            _ if !is_direct => keys(&found, [AROUND, y], most),
            _ => (String::new(), 0.0),
        };
        body.push_str(&legend.0);
        y += legend.1 + if legend.1 > 0.0 { 6.0 } else { 0.0 };

        // The panels.
        let head = |facet: &Facet| -> Vec<String> {
            let lines = facet.head.lines();
            lines
                .flat_map(|line| wrap(line, HEAD, wide + BETWEEN[0] - 4.0))
                .collect()
        };
        let heads = self
            .facets
            .iter()
            .map(|facet| head(facet).len())
            .max()
            .unwrap_or(0);
        let top = y + LINE * heads as f64 + 4.0;
        let lines = |facet: &Facet| match facet.names[0].as_str() {
            "" => -NAME,
            name => LINE * (wrap(name, SMALL, wide).len() - 1) as f64,
        };
        let below = NUMBERS + NAME + self.facets.iter().map(lines).fold(-NAME, f64::max);
        let pitch_y =
            high + 4.0 + LINE * heads as f64 + BETWEEN[1] + if is_shared { 0.0 } else { below };
        for (k, facet) in self.facets.iter().enumerate() {
            let (column, row) = (k % columns, k / columns);
            let corner = [left + pitch_x * column as f64, top + pitch_y * row as f64];
            let panel = Panel {
                x: facet.axes[0],
                y: facet.axes[1],
                frame: [corner[0], corner[1], wide, high],
            };
            let middle = corner[0] + 0.5 * wide;
            for (line, up) in head(facet).iter().rev().zip(0..) {
                let at = [middle, corner[1] - 7.0 - LINE * f64::from(up)];
                body.push_str(&text("x name head", at, line));
            }
            // The last panels of a shorter last row leave others without one below.
            let is_lowest = k + columns >= self.facets.len();
            body.push_str(
                &facet.drawn(&panel, [!is_shared || is_lowest, !is_shared || column == 0]),
            );
            if is_direct {
                body.push_str(&facet.labels(&panel));
            }
            if !is_shared {
                body.push_str(&beneath(&facet.names[0], [middle, corner[1] + high], wide));
                body.push_str(&upward(
                    &names(facet),
                    [corner[0] - beside, corner[1] + 0.5 * high],
                ));
            }
        }
        let bottom = top + pitch_y * rows.saturating_sub(1) as f64 + high;
        if let Some(facet) = self.facets.first().filter(|_| is_shared) {
            let across = right - left;
            body.push_str(&beneath(
                &facet.names[0],
                [left + 0.5 * across, bottom],
                across,
            ));
            body.push_str(&upward(&names(facet), [AROUND, 0.5 * (top + bottom)]));
        }
        let height = bottom + below + AROUND;
        let style = PALETTE
            .iter()
            .fold(crate::STYLE.to_owned(), |style, (name, colour)| {
                style.replace(&format!("var(--{name})"), colour)
            });
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {total:.0} {height:.0}\" \
             width=\"{total:.0}\" height=\"{height:.0}\" role=\"img\" aria-label=\"{}\" \
             font-family=\"system-ui, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif\">\n\
             <style>\n{style}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"{}\"/>\n\
             {body}\n</svg>\n",
            escape(&self.title),
            PALETTE[0].1,
        )
    }

    /// Returns the keys of the legend: those given, else the names of the curves, each once.
    fn keys_of_curves(&self) -> Vec<Key> {
        if !self.keys.is_empty() {
            return self.keys.clone();
        }
        let mut keys: Vec<Key> = Vec::new();
        for curve in self.facets.iter().flat_map(|facet| &facet.curves) {
            let key = Key {
                name: curve.name.clone(),
                stroke: curve.stroke.clone(),
            };
            if !key.name.is_empty() && !keys.contains(&key) {
                keys.push(key);
            }
        }
        keys
    }
}

/// Writes the name of an axis below a panel, wrapped; the place is the middle of its lower side.
fn beneath(name: &str, [middle, bottom]: [f64; 2], most: f64) -> String {
    let lines = wrap(name, SMALL, most);
    let at = |k: usize| [middle, bottom + NUMBERS + 10.0 + LINE * k as f64];
    let lines = lines
        .iter()
        .enumerate()
        .filter(|(_, line)| !line.is_empty());
    lines.map(|(k, line)| text("x name", at(k), line)).collect()
}

/// Writes the lines of the name of an axis, turned; the place is the middle of their left side.
fn upward(lines: &[String], [left, middle]: [f64; 2]) -> String {
    let at = |k: usize| [left + 10.0 + LINE * k as f64, middle];
    let lines = lines
        .iter()
        .enumerate()
        .filter(|(_, line)| !line.is_empty());
    lines.map(|(k, line)| turned(at(k), line)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Axis;
    use crate::check::faults;
    use crate::facet::{Curve, Marks};
    use crate::legend::{Dash, Stroke};
    use crate::ramp;

    fn curve(name: &str, points: &[[f64; 2]]) -> Curve {
        let stroke = Stroke::solid("#123456");
        let intervals = points.iter().map(|p| [p[1] - 0.1, p[1] + 0.1]);
        Curve::new(name, stroke, Marks::Line, points.iter().copied()).within(intervals)
    }

    fn facet(curves: Vec<Curve>) -> Facet {
        let values = |k: usize| {
            curves
                .iter()
                .flat_map(move |c| c.points.iter().map(move |p| p[k]))
        };
        let axes = [Axis::around(values(0)), Axis::decades(values(1))];
        let head = "incidence 20\u{b0}, azimuth 355\u{b0}: nothing returns\neta 0.1";
        let names = [
            "frequency (1/mm)",
            "error against the closed form (%) & more",
        ];
        Facet {
            shades: vec![[0.5, 100.0]],
            ..Facet::new(head, axes, names, curves)
        }
    }

    fn figure(facets: Vec<Facet>, columns: usize) -> Figure {
        let title = "/a/long/path/without/a/space/to/sheet-from-the-left-drawer-of-the-lab.toml";
        Figure {
            frame: [200.0, 120.0],
            ..Figure::new(title, facets, columns)
        }
    }

    #[test]
    fn no_text_is_cut_or_covered() {
        let azimuths = |names: &str| -> Vec<Curve> {
            let line = |k: usize| {
                curve(
                    &format!("{names}{}\u{b0}", 5 * k),
                    &[[0.0, 1.0], [1.0, 0.5]],
                )
            };
            (0..72).map(line).collect()
        };
        let gap = [[0.0, 1.0], [1.0, f64::NAN], [2.0, 0.2]];
        let far = [[0.0, 1e-12], [1e7, 1e12]];
        let one = facet(vec![curve("one", &[[3.0, 0.5]])]);
        let facets = [
            one.clone(),
            facet(azimuths("")),
            Facet {
                axes: [Axis::linear(0.0, 0.25); 2],
                ..one.clone()
            },
            facet(azimuths(
                "a sheet with a name that is longer than the legend is wide, azimuth ",
            )),
            facet(vec![curve("gap", &gap), curve("<&>", &far)]),
            facet(Vec::new()),
        ];
        for columns in [1, 2, 3, 9] {
            for facet in &facets {
                for count in [1, 2, 5] {
                    let svg = figure(vec![facet.clone(); count], columns).svg();
                    assert_eq!(faults(&svg), [""; 0]);
                }
            }
            assert_eq!(faults(&figure(facets.to_vec(), columns).svg()), [""; 0]);
        }
        assert!(
            figure(vec![one], 1).svg().contains("h0"),
            "one point is a dot"
        );
    }

    #[test]
    fn curves_are_named_at_their_ends_or_once_in_a_legend() {
        let apart = facet(vec![
            curve("a", &[[0.0, 1.0], [1.0, 1.0]]),
            curve("b", &[[0.0, 1.0], [1.0, 0.1]]),
        ]);
        let close = facet(vec![
            curve("a", &[[0.0, 1.0], [1.0, 1.0]]),
            curve("b", &[[0.0, 1.0], [1.0, 0.99]]),
        ]);
        let count = |facets: &[&Facet], name: &str| {
            let svg = figure(facets.iter().map(|&f| f.clone()).collect(), 2).svg();
            svg.matches(&format!(">{name}<")).count()
        };
        assert_eq!(count(&[&apart, &apart, &apart], "b"), 3);
        assert_eq!(
            count(&[&apart, &close, &apart], "b"),
            1,
            "one legend for all"
        );
        let mut other = close.clone();
        other.curves[1].stroke = Stroke::grey(Dash::Dotted);
        assert_eq!(count(&[&close, &other], "b"), 2, "two lines of one name");
    }

    #[test]
    fn faults_are_found() {
        let text = |x: &str, y: f64| crate::panel::text(x, [50.0, y], "0.5");
        let picture = |body: String| crate::svg([100.0, 50.0], "", &body);
        assert!(faults(&picture(text("x", 20.0) + &text("x", 33.0))).is_empty());
        for body in [
            text("x", 20.0) + &text("", 25.0),
            text("x", 5.0),
            text("x", 49.0),
            String::new(),
            text("x", 20.0) + "<path d=\"M1 NaN\"/>",
        ] {
            assert_eq!(faults(&picture(body.clone())).len(), 1, "{body}");
        }
        assert_eq!(ramp(0, 1), ramp(0, 9));
    }
}
