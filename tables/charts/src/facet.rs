//! One panel of a figure: axes, what lies beneath the curves, the curves and their names.

use crate::axis::Axis;
use crate::image::Image;
use crate::legend::{Dash, Stroke};
use crate::panel::{ACROSS, Panel, text};
use crate::text::{LINE, SMALL, width};

/// How the points of a curve are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marks {
    /// A line; a band shows its intervals.
    Line,
    /// Dots; bars show their intervals.
    Dots,
    /// Dots that a line joins.
    Both,
}

/// Points that belong together.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Name; empty for a curve that is explained elsewhere.
    pub name: String,
    /// Line, or colour of the dots.
    pub stroke: Stroke,
    /// How the points are drawn.
    pub marks: Marks,
    /// Points; one that is not finite is a gap.
    pub points: Vec<[f64; 2]>,
    /// Ends of the interval of each point; empty without intervals.
    pub intervals: Vec<[f64; 2]>,
}

impl Curve {
    /// Makes a curve without intervals.
    pub fn new(
        name: impl Into<String>,
        stroke: Stroke,
        marks: Marks,
        points: impl IntoIterator<Item = [f64; 2]>,
    ) -> Curve {
        Curve {
            name: name.into(),
            stroke,
            marks,
            points: points.into_iter().collect(),
            intervals: Vec::new(),
        }
    }

    /// Makes a grey line between two points: a limit that the other curves are compared with.
    pub fn limit(name: impl Into<String>, dash: Dash, ends: [[f64; 2]; 2]) -> Curve {
        Curve::new(name, Stroke::grey(dash), Marks::Line, ends)
    }

    /// Adds the ends of the interval of each point.
    pub fn within(mut self, intervals: impl IntoIterator<Item = [f64; 2]>) -> Curve {
        self.intervals = intervals.into_iter().collect();
        self
    }
}

/// What lies beneath the curves of a panel.
#[derive(Debug, Clone)]
pub enum Ground {
    /// Lines at the ticks, with numbers.
    Grid,
    /// Circles of radius 1/2 and 1 about 0, for axes from -1.25 to 1.25.
    Circles,
    /// Cells, and outlines over them, on lines at the ticks.
    Cells(Image, Vec<Vec<[f64; 2]>>),
    /// Cells of a polar map about 0 up to a radius, under circles at round radii, with directions
    /// around it. The axes reach from -1.2 to 1.2 times the radius; numbers of radii stand below.
    Polar(Image, f64),
}

/// One panel of a figure.
#[derive(Debug, Clone)]
pub struct Facet {
    /// Text above the panel; each line is wrapped.
    pub head: String,
    /// Axes: to the right, then upward.
    pub axes: [Axis; 2],
    /// Names of the axes.
    pub names: [String; 2],
    /// What lies beneath the curves.
    pub ground: Ground,
    /// Curves; the first is lowest.
    pub curves: Vec<Curve>,
    /// Ranges of the horizontal axis that are shaded.
    pub shades: Vec<[f64; 2]>,
    /// Text in the middle of a panel that is empty.
    pub remark: Option<&'static str>,
}

impl Facet {
    /// Makes a panel of curves on a grid.
    pub fn new(
        head: impl Into<String>,
        axes: [Axis; 2],
        names: [&str; 2],
        curves: Vec<Curve>,
    ) -> Facet {
        Facet {
            head: head.into(),
            axes,
            names: names.map(String::from),
            ground: Ground::Grid,
            curves,
            shades: Vec::new(),
            remark: None,
        }
    }
}

impl Facet {
    /// Returns the number of ticks upward of a panel of this height, about.
    fn ticks(high: f64) -> usize {
        ((high / 30.0) as usize).clamp(1, 5)
    }

    /// Returns the width of the longest number beside a panel of this height.
    pub(crate) fn numbers(&self, high: f64) -> f64 {
        if matches!(self.ground, Ground::Circles | Ground::Polar(..)) {
            return 0.0;
        }
        let ticks = self.axes[1].ticks(Facet::ticks(high));
        ticks
            .iter()
            .map(|(_, name)| width(name, SMALL))
            .fold(0.0, f64::max)
    }

    /// Returns the widths of the numbers below a panel, with a space.
    pub(crate) fn across(&self) -> impl Iterator<Item = f64> {
        let ticks = self.axes[0].ticks(ACROSS).into_iter();
        ticks.map(|(_, name)| width(&name, SMALL) + 4.0)
    }

    /// Returns the names of the curves and where they end, from above.
    fn ends(&self, panel: &Panel) -> Vec<(&str, [f64; 2])> {
        let [_, top, _, high] = panel.frame;
        let named = self.curves.iter().filter(|curve| !curve.name.is_empty());
        let mut ends: Vec<(&str, [f64; 2])> = named
            .filter_map(|curve| {
                let mut places = curve.points.iter().map(|&[x, y]| panel.at(x, y));
                let [x, y] = places.rfind(|at| at.iter().all(|v| v.is_finite()))?;
                // A name does not leave the sides of the panel.
                Some((
                    curve.name.as_str(),
                    [x, y.clamp(top + 5.0, top + high - 5.0)],
                ))
            })
            .collect();
        ends.sort_by(|p, q| p.1[1].total_cmp(&q.1[1]));
        ends
    }

    /// Returns true if the curves of a panel end at its right side, with room for their names.
    pub(crate) fn are_ends_apart(&self, [wide, high]: [f64; 2]) -> bool {
        let panel = Panel {
            x: self.axes[0],
            y: self.axes[1],
            frame: [0.0, 0.0, wide, high],
        };
        let ends = self.ends(&panel);
        ends.windows(2)
            .all(|pair| pair[1].1[1] - pair[0].1[1] >= LINE)
            && ends.iter().all(|(name, [x, _])| {
                (x - wide).abs() < 0.08 * wide && width(name, SMALL) < 0.4 * wide
            })
    }

    /// Writes the names of the curves at their ends.
    pub(crate) fn labels(&self, panel: &Panel) -> String {
        let [left, _, wide, _] = panel.frame;
        let ends = self.ends(panel);
        let written = ends
            .iter()
            .map(|(name, [_, y])| text("name", [left + wide + 5.0, y + 4.0], name));
        written.collect()
    }

    /// Draws a panel, with the numbers along the axes for which `named` is true.
    pub(crate) fn drawn(&self, panel: &Panel, named: [bool; 2]) -> String {
        let [left, top, wide, high] = panel.frame;
        let mut out = match &self.ground {
            Ground::Circles => circles(panel),
            Ground::Polar(image, radius) => polar(panel, image, *radius, named[0]),
            _ => panel.ruled(Facet::ticks(high), named),
        };
        if let Ground::Cells(image, outlines) = &self.ground {
            out.push_str(&cells(panel, image));
            let lines = outlines.iter().map(|outline| panel.path(outline));
            let lines: String = lines.collect();
            out.push_str(&format!("<path class=\"outlines\" d=\"{lines}\"/>"));
        }
        for &[from, to] in &self.shades {
            let [low, high] = self.axes[1].ends();
            out.push_str(&panel.shade("shade", [from, low], [to, high]));
        }
        out.extend(self.curves.iter().map(|curve| curve.drawn(panel)));
        if let Some(remark) = self.remark {
            let middle = [left + 0.5 * wide, top + 0.5 * high];
            out.push_str(&text("x name head", middle, remark));
        }
        out
    }
}

impl Curve {
    fn drawn(&self, panel: &Panel) -> String {
        let stroke = &self.stroke;
        let path = |class: &str, d: String| {
            format!(
                "<path class=\"{class}\" stroke=\"{}\" d=\"{d}\"/>",
                stroke.colour
            )
        };
        let intervals = self.points.iter().zip(&self.intervals);
        let mut out = match self.marks {
            Marks::Line => {
                let sides = intervals.clone().map(|(p, ends)| [p[0], ends[0]]);
                let back = intervals.rev().map(|(p, ends)| [p[0], ends[1]]);
                let around: Vec<[f64; 2]> = sides.chain(back).collect();
                match around.is_empty() {
                    true => String::new(),
                    false => panel.area("between", &stroke.colour, &around),
                }
            }
            Marks::Dots | Marks::Both => {
                let bars =
                    intervals.map(|(&[x, _], &[low, high])| panel.path(&[[x, low], [x, high]]));
                path("bars", bars.collect())
            }
        };
        if self.marks != Marks::Dots {
            out.push_str(&path(stroke.dash.class(), panel.path(&self.points)));
        }
        let dots = match self.marks {
            Marks::Line => self.alone(),
            _ => self.points.clone(),
        };
        if !dots.is_empty() {
            out.push_str(&path("dots", panel.spots(&dots)));
        }
        out
    }

    /// Returns the points without a neighbour, of which no line is drawn.
    fn alone(&self) -> Vec<[f64; 2]> {
        let is_there = |k: Option<usize>| {
            let point = k.and_then(|k| self.points.get(k));
            point.is_some_and(|point| point.iter().all(|v| v.is_finite()))
        };
        let alone = (0..self.points.len()).filter(|&k| {
            is_there(Some(k)) && !is_there(k.checked_sub(1)) && !is_there(Some(k + 1))
        });
        alone.map(|k| self.points[k]).collect()
    }
}

/// Draws the cells of an image.
fn cells(panel: &Panel, image: &Image) -> String {
    if image.png.is_empty() {
        return String::new();
    }
    let [[x0, y1], [x1, y0]] = [image.from, image.to].map(|[x, y]| panel.at(x, y));
    format!(
        "<image x=\"{x0:.2}\" y=\"{y0:.2}\" width=\"{:.2}\" height=\"{:.2}\" \
         preserveAspectRatio=\"none\" image-rendering=\"pixelated\" \
         href=\"data:image/png;base64,{}\"/>",
        x1 - x0,
        y1 - y0,
        image.png
    )
}

/// Draws a polar map with circles at round radii; their numbers stand below it if they are `named`.
fn polar(panel: &Panel, image: &Image, radius: f64, named: bool) -> String {
    let [x, y] = panel.at(0.0, 0.0);
    let [_, top, _, high] = panel.frame;
    let scale = (panel.at(radius, 0.0)[0] - x) / radius;
    let r = radius * scale;
    let mut out = cells(panel, image);
    let ticks = Axis::linear(0.0, radius).ticks(4);
    let inner = ticks.iter().filter(|(tick, _)| *tick < radius);
    for tick in inner.map(|(tick, _)| *tick).chain([radius]) {
        out.push_str(&format!(
            "<circle class=\"lines\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\"/>",
            tick * scale
        ));
    }
    out.push_str(&format!(
        "<path class=\"lines\" d=\"M{:.1} {y:.1}h{:.1}M{x:.1} {:.1}v{:.1}\"/>",
        x - r,
        2.0 * r,
        y - r,
        2.0 * r
    ));
    let around = [
        ("", [x + r + 4.0, y + 4.0], "0°"),
        ("x", [x, y - r - 4.0], "90°"),
        ("y", [x - r - 4.0, y + 4.0], "180°"),
        ("x", [x, y + r + 13.0], "270°"),
    ];
    out.extend(around.map(|(class, at, name)| text(class, at, name)));
    if named {
        let below =
            |(tick, name): &(f64, String)| text("x", [x + tick * scale, top + high + 12.0], name);
        out.extend(ticks.iter().map(below));
    }
    out
}

/// Draws the grid of a polar panel, with directions around it.
fn circles(panel: &Panel) -> String {
    let [x, y] = panel.at(0.0, 0.0);
    let r = panel.at(1.0, 0.0)[0] - x;
    let mut out = format!(
        "<circle class=\"lines\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\"/>\
         <circle class=\"lines\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\"/>\
         <path class=\"lines\" d=\"M{:.1} {y:.1}h{:.1}M{x:.1} {:.1}v{:.1}\"/>",
        0.5 * r,
        x - r,
        2.0 * r,
        y - r,
        2.0 * r
    );
    out.push_str(&text("", [x + r + 4.0, y + 4.0], "0°"));
    out.push_str(&text("x", [x, y - r - 4.0], "90°"));
    let slanted = std::f64::consts::FRAC_1_SQRT_2 * r;
    for (part, name) in [(0.5, "0.5"), (1.0, "1")] {
        out.push_str(&text(
            "",
            [x + part * slanted + 3.0, y + part * slanted + 9.0],
            name,
        ));
    }
    out
}
