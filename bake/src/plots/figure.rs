//! Figures with one panel per direction, all with one scale of colours, and their formats.

use crate::error::Error;
use crate::plots::colours::{STEPS, Scale, colour};
use crate::plots::content::{Content, Extent};
use crate::plots::panel::{Axes, grid, name, nice, pen, tiles};
use glam::DVec2;
use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{Primitive, Scene, TextAnchor};
use std::path::Path;
use tables::Table;
use tables::cli::PlotFormat;

/// Draws a scene as the bytes of `file`, whose extension names the format.
///
/// # Errors
/// Returns an [`Error`] if the extension names no format, or if the plotting crate fails.
pub(crate) fn render(scene: &Scene, file: &Path) -> Result<Vec<u8>, Error> {
    match PlotFormat::of(file)? {
        // The text uses a font of the viewer, because an embedded font takes 3 MB.
        PlotFormat::Svg => Ok(SvgBackend::new().render_scene(scene).into_bytes()),
        PlotFormat::Png => PngBackend::new()
            .with_scale(1.5)
            .render_scene(scene)
            .map_err(|reason| {
                let file = file.display();
                let fault = format!("the picture cannot be drawn ({reason})");
                Error::Failed(format!("{file}: {fault}; try .svg instead"))
            }),
    }
}

/// One direction of a figure.
pub(crate) struct Panel {
    /// Two lines above the panel.
    title: [String; 2],
    content: Content,
    is_empty: bool,
}

impl Panel {
    /// Names a direction by its angles and its retroreflected fraction; `word` is added to them.
    pub(crate) fn new(
        table: &Table,
        (i, a): (usize, usize),
        content: Content,
        word: Option<&str>,
    ) -> Panel {
        let azimuth = match table.axes.azimuth_deg[a] {
            mean if mean.is_nan() => "mean over azimuths".into(),
            azimuth => format!("azimuth {}\u{b0}", angle(azimuth)),
        };
        let eta = match table.retroreflected[[i, a]] {
            0.0 => "eta 0".into(),
            eta => format!("eta {eta:.4}"),
        };
        let word = word.map_or(String::new(), |word| format!(", {word}"));
        let incidence = angle(table.axes.incidence_deg[i]);
        Panel {
            title: [
                format!("incidence {incidence}\u{b0}, {azimuth}"),
                eta + &word,
            ],
            is_empty: content.light().is_empty(),
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
pub(crate) struct Figure {
    pub(crate) title: String,
    /// Line below the title.
    pub(crate) note: Option<String>,
    /// Names of the axes: to the right, then upward.
    pub(crate) axes: [&'static str; 2],
    /// Quantity of the scale of colours.
    pub(crate) bar: &'static str,
    pub(crate) panels: Vec<Panel>,
    /// Number of panels beside each other.
    pub(crate) columns: usize,
}

/// Free space around the panels, pixels: left, top, right, bottom.
const AROUND: [f64; 4] = [64.0, 56.0, 24.0, 104.0];

/// Height of the title of a panel, and space between panels across and down, pixels.
const HEAD: f64 = 36.0;
const BETWEEN: [f64; 2] = [20.0, 20.0];

/// Width of the scale of colours, pixels.
const BAR: f64 = 300.0;

/// Draws a figure in the format that the extension of `file` names.
///
/// # Errors
/// Returns an [`Error`] if the extension names no format, or if the plotting crate fails.
pub(crate) fn draw(figure: &Figure, file: &Path) -> Result<Vec<u8>, Error> {
    PlotFormat::of(file)?;
    let panels = &figure.panels;
    let scale = Scale::of(
        panels
            .iter()
            .flat_map(|panel| panel.content.light())
            .collect(),
    );
    let extent = extent(panels);
    let columns = figure.columns.max(1);
    let rows = panels.len().div_ceil(columns);
    let (low, high) = extent;
    let width = match columns {
        1 => 380.0,
        2 => 300.0,
        _ => 230.0,
    };
    let size = DVec2::new(width, width * (high.y - low.y) / (high.x - low.x));
    let [left, top, right, bottom] = AROUND;
    let top = if figure.note.is_some() {
        top
    } else {
        top - 18.0
    };
    let pitch = size + DVec2::new(BETWEEN[0], BETWEEN[1] + HEAD);
    let end = DVec2::new(left, top) + pitch * DVec2::new(columns as f64, rows as f64)
        - DVec2::from(BETWEEN);
    // A letter of the title is about 8 pixels wide; the name of the scale has 480 at most.
    let least = (left + 480.0).max(2.0 * 24.0 + 8.0 * figure.title.len() as f64);
    let mut scene = Scene::new((end.x + right).max(least), end.y + bottom);
    scene.font_family = Some("DejaVu Sans, Liberation Sans, Arial, sans-serif".into());
    scene.add(text([24.0, 24.0], 14, TextAnchor::Start, &figure.title));
    if let Some(note) = &figure.note {
        scene.add(text([24.0, 43.0], 12, TextAnchor::Start, note));
    }
    for (k, panel) in panels.iter().enumerate() {
        let place = DVec2::new((k % columns) as f64, (k / columns) as f64);
        let corner = DVec2::new(left, top + HEAD) + pitch * place;
        let axes = Axes {
            extent,
            corner,
            size,
            is_left: k % columns == 0,
            is_lowest: k + columns >= panels.len(),
        };
        drawn(&mut scene, panel, &axes, &scale);
    }
    let middle = 0.5 * (DVec2::new(left, top + HEAD) + end);
    let below = [middle.x, end.y + 34.0];
    scene.add(text(below, 12, TextAnchor::Middle, figure.axes[0]));
    let beside = text([18.0, middle.y], 12, TextAnchor::Middle, figure.axes[1]);
    scene.add(turned(beside));
    bar(&mut scene, [left, end.y + 52.0], &scale, figure.bar);
    render(&scene, file)
}

/// Draws one panel with its title.
fn drawn(scene: &mut Scene, panel: &Panel, axes: &Axes, scale: &Scale) {
    let middle = axes.corner.x + 0.5 * axes.size.x;
    for (line, up) in panel.title.iter().zip([21.0, 6.0]) {
        let at = [middle, axes.corner.y - up];
        scene.add(text(at, 12, TextAnchor::Middle, line));
    }
    tiles(scene, &panel.content, axes, scale);
    grid(scene, axes);
    if panel.is_empty {
        let at = [middle, axes.corner.y + 0.5 * axes.size.y];
        scene.add(text(at, 12, TextAnchor::Middle, "nothing returns"));
    }
}

/// Returns the rectangle that holds all light of all panels, with a margin of a twentieth.
fn extent(panels: &[Panel]) -> Extent {
    let all = panels.iter().map(|panel| panel.content.extent());
    let nothing = (DVec2::splat(f64::INFINITY), DVec2::splat(f64::NEG_INFINITY));
    let grow = |(low, high): Extent, own: Extent| (low.min(own.0), high.max(own.1));
    let (low, high) = all.fold(nothing, grow);
    if low.x > high.x {
        return (DVec2::NEG_ONE, DVec2::ONE);
    }
    let (middle, half) = (0.5 * (low + high), 0.55 * (high - low));
    // Light on a line still has a panel of some height.
    let half = half.max(DVec2::new(half.y / 1.5, half.x / 2.0));
    (middle - half, middle + half)
}

/// Draws the scale of colours, with numbers and a name below.
fn bar(scene: &mut Scene, [x, y]: [f64; 2], scale: &Scale, label: &str) {
    let highest = scale.highest;
    if highest == 0.0 {
        return;
    }
    let width = BAR / STEPS as f64;
    for step in 1..=STEPS {
        scene.add(Primitive::Rect {
            x: x + width * (step - 1) as f64,
            y,
            // A little more than a step, so that no gap is seen.
            width: if step < STEPS { width + 0.5 } else { width },
            height: 12.0,
            fill: colour(step),
            stroke: None,
            stroke_width: None,
            opacity: None,
        });
    }
    let step = nice(highest / 5.0);
    for tick in (0..).map(|k| f64::from(k) * step) {
        if tick > highest * (1.0 + 1e-9) {
            break;
        }
        let at = x + BAR * tick / highest;
        scene.add(pen([at, y + 12.0], [at, y + 16.0]));
        let name = name(tick, step);
        scene.add(text([at, y + 28.0], 11, TextAnchor::Middle, &name));
    }
    let more = match scale.largest > highest * (1.0 + 1e-9) {
        true => format!("; darkest: {highest:.3} and more"),
        false => String::new(),
    };
    let label = format!("{label}{more}");
    scene.add(text([x, y + 44.0], 12, TextAnchor::Start, &label));
}

/// Returns a line of text.
fn text([x, y]: [f64; 2], size: u32, anchor: TextAnchor, content: &str) -> Primitive {
    Primitive::Text {
        x,
        y,
        content: content.into(),
        size,
        anchor,
        rotate: None,
        bold: false,
        color: Some(Color::from("#1d2226")),
    }
}

/// Turns text so that it reads upward.
fn turned(mut text: Primitive) -> Primitive {
    if let Primitive::Text { rotate, .. } = &mut text {
        *rotate = Some(-90.0);
    }
    text
}
