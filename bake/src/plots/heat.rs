//! Pictures with one panel per direction, all with one scale of colours for their densities.

use crate::geometry::Polygon;
use charts::{Axis, Bar, Facet, Figure, Ground, Image, STEPS};
use glam::DVec2;
use tables::Table;

/// Convex polygon with the same density everywhere.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct UniformPolygon {
    pub(crate) polygon: Polygon,
    pub(crate) density: f64,
}

/// Densities of the cells of an even grid.
#[derive(Debug)]
pub(crate) struct Cells {
    /// Densities `[row upward][column to the right]`.
    pub(crate) density: Vec<Vec<f64>>,
    /// Lower left corner.
    pub(crate) corner: DVec2,
    /// Width and height of a cell.
    pub(crate) size: DVec2,
}

/// Distribution that a panel shows.
#[derive(Debug)]
pub(crate) enum Content {
    /// Polygons, whose densities add where they overlap.
    Polygons(Vec<UniformPolygon>),
    /// Bins of the table.
    Bins(Cells),
}

/// Rectangle: its lowest and its highest corner.
type Extent = (DVec2, DVec2);

/// Closed lines around polygons.
type Outlines = Vec<Vec<[f64; 2]>>;

/// Rectangle that holds nothing.
const NOTHING: Extent = (DVec2::INFINITY, DVec2::NEG_INFINITY);

/// Part of all light that may be denser than the scale reaches.
///
/// Slivers where polygons barely overlap, and the noise of rays, would else make all colours pale.
const BEYOND: f64 = 0.005;

/// Cells of a panel of polygons along a pixel.
///
/// A cell has the density of its middle: the mean over a cell would draw a fringe of low densities
/// around each polygon. What is narrower than a cell may have gaps.
const FINE: f64 = 3.0;

/// Largest number of polygons whose outlines are drawn; more would hide the colours.
const MOST_OUTLINES: usize = 200;

impl Cells {
    /// Makes cells without light.
    fn dark((low, high): Extent, [columns, rows]: [usize; 2]) -> Cells {
        Cells {
            density: vec![vec![0.0; columns]; rows],
            corner: low,
            size: (high - low) / DVec2::new(columns as f64, rows as f64),
        }
    }

    /// Adds the density of a polygon to the cells whose middle it holds.
    fn add(&mut self, uniform: &UniformPolygon) {
        // A whole number is the middle of a cell.
        let place = |point: &DVec2| (point - self.corner) / self.size - 0.5;
        let corners: Vec<DVec2> = uniform.polygon.iter().map(place).collect();
        let (low, high) = corners.iter().fold(NOTHING, grown);
        let first = low.y.ceil().max(0.0) as usize;
        for (y, row) in self.density.iter_mut().enumerate().skip(first) {
            let y = y as f64;
            if y > high.y {
                break;
            }
            let sides = (0..corners.len()).filter_map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                let crosses = (a.y <= y) != (b.y <= y);
                crosses.then(|| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x))
            });
            let (from, to) = sides.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), x| {
                (from.min(x), to.max(x))
            });
            let cells = row
                .iter_mut()
                .enumerate()
                .skip(from.ceil().max(0.0) as usize);
            for (_, density) in cells.take_while(|(x, _)| (*x as f64) < to) {
                *density += uniform.density;
            }
        }
    }

    /// Returns the densities above 0, each with the share of light that has it.
    fn light(&self) -> impl Iterator<Item = [f64; 2]> {
        let area = self.size.x * self.size.y;
        let all = self.density.iter().flatten();
        let seen = all.filter(|density| **density > 0.0);
        seen.map(move |&density| [density, density * area])
    }

    /// Returns the range of columns and of rows that hold light; none without light.
    fn filled(&self) -> Option<[[usize; 2]; 2]> {
        let seen = |&density: &f64| density > 0.0;
        let rows: Vec<&Vec<f64>> = self.density.iter().collect();
        let bright = |y: &usize| rows[*y].iter().any(seen);
        let down = [
            (0..rows.len()).find(bright)?,
            (0..rows.len()).rfind(bright)? + 1,
        ];
        let from = rows.iter().filter_map(|row| row.iter().position(seen));
        let to = rows.iter().filter_map(|row| row.iter().rposition(seen));
        Some([[from.min()?, to.max()? + 1], down])
    }

    /// Returns the cells that hold light as a picture.
    fn image(&self, scale: &ColourScale) -> Image {
        let [[left, right], [bottom, top]] = self.filled().unwrap_or_default();
        let rows = self.density[bottom..top].iter().rev();
        let steps = rows.map(|row| row[left..right].iter().map(|&d| scale.step(d)).collect());
        let at = |x: usize, y: usize| self.corner + self.size * DVec2::new(x as f64, y as f64);
        let steps: Vec<Vec<u8>> = steps.collect();
        Image::of(&steps, at(left, bottom).into(), at(right, top).into())
    }
}

impl Content {
    /// Returns the smallest rectangle that holds all light.
    fn extent(&self) -> Extent {
        match self {
            Content::Polygons(polygons) => {
                let corners = polygons.iter().flat_map(|uniform| &uniform.polygon);
                corners.fold(NOTHING, grown)
            }
            Content::Bins(bins) => bins.filled().map_or(NOTHING, |[x, y]| {
                let at = |k: usize| bins.corner + bins.size * DVec2::new(x[k] as f64, y[k] as f64);
                (at(0), at(1))
            }),
        }
    }

    /// Returns cells with the densities, and the outlines of polygons where there are few.
    fn cells(self, extent: Extent, count: [usize; 2]) -> (Cells, Outlines) {
        let polygons = match self {
            Content::Bins(bins) => return (bins, Vec::new()),
            Content::Polygons(polygons) => polygons,
        };
        let mut cells = Cells::dark(extent, count);
        polygons.iter().for_each(|uniform| cells.add(uniform));
        let outline = |uniform: &UniformPolygon| {
            let first = uniform.polygon.first();
            let around = uniform.polygon.iter().chain(first);
            around.map(|&point| point.into()).collect()
        };
        let outlines = match polygons.len() <= MOST_OUTLINES {
            true => polygons.iter().map(outline).collect(),
            false => Vec::new(),
        };
        (cells, outlines)
    }
}

/// Returns a rectangle that holds another point.
fn grown((low, high): Extent, point: &DVec2) -> Extent {
    (low.min(*point), high.max(*point))
}

/// Scale of densities from 0.
#[derive(Debug)]
struct ColourScale {
    /// Density at the end of the scale; 0 without light.
    highest: f64,
    /// Largest density of all, which has the colour of the end.
    largest: f64,
}

impl ColourScale {
    /// Makes a scale for densities, each with the light that has it.
    fn of(mut light: Vec<[f64; 2]>) -> ColourScale {
        light.sort_by(|p, q| q[0].total_cmp(&p[0]));
        let all: f64 = light.iter().map(|[_, share]| share).sum();
        let mut beyond = 0.0;
        let reached = light.iter().find(|[_, share]| {
            beyond += share;
            beyond > BEYOND * all
        });
        ColourScale {
            highest: reached.map_or(0.0, |[density, _]| *density),
            largest: light.first().map_or(0.0, |[density, _]| *density),
        }
    }

    /// Returns the step of a density, from 1 to [`STEPS`]; 0 for no light.
    fn step(&self, density: f64) -> u8 {
        let share = density / self.highest;
        match share > 0.0 {
            true => (share * f64::from(STEPS))
                .ceil()
                .clamp(1.0, f64::from(STEPS)) as u8,
            false => 0,
        }
    }
}

/// One direction of a picture.
pub(crate) struct DirectionPanel {
    head: String,
    content: Content,
}

impl DirectionPanel {
    /// Names a direction by its angles and its retroreflected fraction; `word` is added to them.
    pub(crate) fn new(
        table: &Table,
        (i, a): (usize, usize),
        content: Content,
        word: &str,
    ) -> DirectionPanel {
        let azimuth = match table.axes.azimuth_deg[a] {
            mean if mean.is_nan() => "mean over azimuths".into(),
            azimuth => format!("azimuth {}\u{b0}", angle(azimuth)),
        };
        let eta = match table.retroreflected[[i, a]] {
            0.0 => "eta 0".into(),
            eta => format!("eta {eta:.4}"),
        };
        let incidence = angle(table.axes.incidence_deg[i]);
        DirectionPanel {
            head: format!("incidence {incidence}\u{b0}, {azimuth}\n{eta}{word}"),
            content,
        }
    }
}

/// Writes an angle with at most two decimals.
fn angle(degrees: f64) -> String {
    let text = format!("{degrees:.2}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

/// Panels with one scale of colours and one pair of axes.
pub(crate) struct Picture {
    pub(crate) title: String,
    /// Line below the title.
    pub(crate) note: String,
    /// Names of the axes: to the right, then upward.
    pub(crate) axes: [&'static str; 2],
    /// Quantity of the scale of colours.
    pub(crate) bar: &'static str,
    pub(crate) panels: Vec<DirectionPanel>,
    /// Number of panels beside each other.
    pub(crate) columns: usize,
}

impl Picture {
    /// Draws the picture as SVG, with the densities as PNG within.
    pub(crate) fn svg(self) -> String {
        let extents = self.panels.iter().map(|panel| panel.content.extent());
        let extent =
            margined(extents.fold(NOTHING, |all, own| (all.0.min(own.0), all.1.max(own.1))));
        let (low, high) = extent;
        let width = match self.columns {
            0 | 1 => 380.0,
            2 => 300.0,
            _ => 230.0,
        };
        let frame = [width, width * (high.y - low.y) / (high.x - low.x)];
        let count = frame.map(|length| (FINE * length).round() as usize);
        let panels = self.panels.into_iter();
        let panels: Vec<(String, Cells, Outlines)> = panels
            .map(|panel| {
                let (cells, outlines) = panel.content.cells(extent, count);
                (panel.head, cells, outlines)
            })
            .collect();
        let scale = ColourScale::of(panels.iter().flat_map(|panel| panel.1.light()).collect());
        let axes = [Axis::linear(low.x, high.x), Axis::linear(low.y, high.y)];
        let facet = |(head, cells, outlines): (String, Cells, _)| Facet {
            remark: cells.filled().is_none().then_some("nothing returns"),
            ground: Ground::Cells(cells.image(&scale), outlines),
            ..Facet::new(head, axes, self.axes, Vec::new())
        };
        let highest = scale.highest;
        let more = match scale.largest > highest * (1.0 + 1e-9) {
            true => format!("; darkest: {highest:.3} and more"),
            false => String::new(),
        };
        let figure = Figure {
            note: self.note,
            frame,
            bar: Some(Bar {
                highest,
                is_signed: false,
                name: format!("{}{more}", self.bar),
            }),
            ..Figure::new(
                self.title,
                panels.into_iter().map(facet).collect(),
                self.columns,
            )
        };
        figure.svg()
    }
}

/// Returns a rectangle with a margin of a twentieth, and of some size where light falls on a line.
fn margined((low, high): Extent) -> Extent {
    if low.x > high.x {
        return (DVec2::NEG_ONE, DVec2::ONE);
    }
    let (middle, half) = (0.5 * (low + high), 0.55 * (high - low));
    let half = half.max(DVec2::new(half.y / 1.5, half.x / 2.0));
    let half = half.max(DVec2::splat(1e-6));
    (middle - half, middle + half)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64, density: f64) -> UniformPolygon {
        let corners = [(low, low), (high, low), (high, high), (low, high)];
        UniformPolygon {
            polygon: corners.map(|(x, y)| DVec2::new(x, y)).to_vec(),
            density,
        }
    }

    #[test]
    fn densities_add_where_two_squares_overlap() {
        let mut cells = Cells::dark((DVec2::ZERO, DVec2::splat(4.0)), [4, 4]);
        cells.add(&square(0.0, 2.0, 1.0));
        cells.add(&square(1.0, 3.0, 4.0));
        let expected = [
            [1.0, 1.0, 0.0, 0.0],
            [1.0, 5.0, 4.0, 0.0],
            [0.0, 4.0, 4.0, 0.0],
            [0.0; 4],
        ];
        assert_eq!(cells.density, expected);
        assert_eq!(cells.filled(), Some([[0, 3], [0, 3]]));
        assert_eq!(cells.light().count(), 7);
    }

    /// Checks the light of polygons that are cut by cells, and of those that leave them: the sides
    /// of the triangle, together 5 + sqrt 13 long, pass through at most 100 cells a unit and
    /// direction, each of which may be counted wrongly.
    #[test]
    fn cells_hold_the_light_of_what_covers_them() {
        let light = |uniform: &UniformPolygon| -> f64 {
            let mut cells = Cells::dark((DVec2::ZERO, DVec2::new(3.0, 2.0)), [300, 200]);
            cells.add(uniform);
            cells.light().map(|[_, share]| share).sum()
        };
        assert!((light(&square(-1.0, 1.0, 2.0)) - 2.0).abs() < 1e-9);
        let triangle = UniformPolygon {
            polygon: vec![DVec2::ZERO, DVec2::new(3.0, 0.0), DVec2::new(0.0, 2.0)],
            density: 0.5,
        };
        let wrong = 0.5 * 1e-4 * 2.0 * 100.0 * (5.0 + 13_f64.sqrt());
        assert!((light(&triangle) - 1.5).abs() < wrong && wrong < 0.1);
        assert_eq!(light(&square(5.0, 6.0, 1.0)), 0.0);
        assert_eq!(light(&square(-6.0, -5.0, 1.0)), 0.0);
    }

    #[test]
    fn the_scale_leaves_out_the_densest_slivers() {
        // 0.4 % of the light has the density 9.
        let scale = ColourScale::of(vec![[1.0, 99.6], [9.0, 0.4]]);
        assert_eq!((scale.highest, scale.largest), (1.0, 9.0));
        let steps = [0.0, 1e-9, 1.0 / 64.0, 0.5, 1.0, 9.0].map(|density| scale.step(density));
        assert_eq!(steps, [0, 1, 1, 32, 64, 64]);
        let dark = ColourScale::of(Vec::new());
        assert_eq!(dark.step(0.0), 0, "a picture without light");
    }

    /// Checks the texts of pictures of one and of 24 directions, with a long name, dark directions
    /// and light on a line.
    #[test]
    fn no_text_of_a_picture_is_cut_or_covered() {
        let contents = [
            || Content::Polygons(vec![square(-0.3, 0.4, 12_345.0)]),
            || Content::Polygons(Vec::new()),
            || {
                let line = vec![vec![1e-9; 30]];
                Content::Bins(Cells {
                    density: line,
                    corner: DVec2::new(-1e-4, 0.0),
                    size: DVec2::splat(1e-5),
                })
            },
        ];
        for content in contents {
            for (count, columns) in [(1, 1), (2, 2), (24, 6), (5, 3)] {
                let panel = |k: usize| DirectionPanel {
                    head: format!("incidence 12.34\u{b0}, mean over azimuths\neta 0.{k}, bins"),
                    content: content(),
                };
                let picture = Picture {
                    title: "a-mesh-with_a_name_of/many_letters".repeat(4),
                    note: "drawn: 4 of 10 incidences, 6 of 12 azimuths".into(),
                    axes: [
                        "across, in the plane of incidence, mrad",
                        "along v = n x u, mrad",
                    ],
                    bar: "share of launched light per square edge length",
                    panels: (0..count).map(panel).collect(),
                    columns,
                };
                let svg = picture.svg();
                assert_eq!(charts::check::faults(&svg), [""; 0]);
                assert!(svg.len() < 20_000 + 20_000 * count, "{} bytes", svg.len());
            }
        }
    }
}
