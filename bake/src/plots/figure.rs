//! Figures with one panel per direction, and the formats of pictures.

use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::Scene;
use std::path::{Path, PathBuf};
use tables::Table;
use tables::cli::PlotFormat;
use thiserror::Error;

/// Largest number of panels; of a table with more directions every k-th is drawn.
const PANELS: usize = 24;

/// Reason why a picture cannot be made.
#[derive(Debug, Error)]
pub(crate) enum PlotError {
    /// Extension of a file that names no format of plots.
    #[error(transparent)]
    Format(#[from] tables::cli::Error),
    /// Table of which all light goes straight back, so that there is nothing to draw.
    #[error(
        "--plot-deviations: nothing to plot, because the table records no light that leaves in \
        another direction than straight back; either its cells are ideal, or it was baked with \
        --deviations off"
    )]
    Straight,
    /// Failure of the plotting crate.
    #[error("{}: the picture cannot be drawn ({reason}); try .svg instead", file.display())]
    Draw {
        /// Name of the picture.
        file: PathBuf,
        /// Message of the plotting crate.
        reason: String,
    },
}

/// Draws a scene as the bytes of `file`, whose extension names the format.
///
/// # Errors
/// Returns [`PlotError::Format`] if the extension names no format, and [`PlotError::Draw`] if the
/// plotting crate fails.
pub(crate) fn render(scene: &Scene, file: &Path) -> Result<Vec<u8>, PlotError> {
    match PlotFormat::of(file)? {
        // The text uses a font of the viewer, because an embedded font takes 3 MB.
        PlotFormat::Svg => Ok(SvgBackend::new().render_scene(scene).into_bytes()),
        PlotFormat::Png => PngBackend::new()
            .with_scale(1.5)
            .render_scene(scene)
            .map_err(|reason| PlotError::Draw {
                file: file.to_path_buf(),
                reason,
            }),
    }
}

/// Texts that all panels of a figure share.
pub(crate) struct Labels {
    /// Quantity that is drawn, a comma, and its unit.
    pub(crate) title: &'static str,
    /// Names of the two axes: to the right, then upward.
    pub(crate) axes: [&'static str; 2],
}

/// Draws a figure with one panel per direction; `plot` makes the content of a panel.
pub(crate) fn figure(
    table: &Table,
    file: &Path,
    labels: &Labels,
    plot: &dyn Fn((usize, usize)) -> Plot,
) -> Result<Vec<u8>, PlotError> {
    PlotFormat::of(file)?;
    let (incidences, azimuths) = table.axes.shape();
    let stride = (incidences * azimuths).div_ceil(PANELS);
    let chosen: Vec<(usize, usize)> = (0..incidences * azimuths)
        .step_by(stride)
        .map(|at| (at / azimuths, at % azimuths))
        .collect();
    let columns = chosen.len().clamp(1, 5);
    let (plots, layouts): (Vec<_>, Vec<_>) = chosen
        .iter()
        .map(|&at| panel(table, at, labels, plot(at)))
        .unzip();
    let scene = Figure::new(chosen.len().div_ceil(columns), columns)
        .with_title(title(table, labels, columns, stride))
        .with_title_size(16)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_cell_size(370.0, 300.0)
        .render();
    render(&scene, file)
}

/// Returns the title of the figure, short enough for the width of its panels.
fn title(table: &Table, labels: &Labels, columns: usize, stride: usize) -> String {
    let (short, _) = labels.title.split_once(',').unwrap_or((labels.title, ""));
    let whole = if columns > 2 { labels.title } else { short };
    let mut title = format!("{}: {whole}", table.provenance.design);
    if stride > 1 {
        title += &format!(" (one of every {stride} directions)");
    }
    title
}

/// Puts the angles of a direction and its retroreflected fraction above its plot.
fn panel(
    table: &Table,
    (i, a): (usize, usize),
    labels: &Labels,
    plot: Plot,
) -> (Vec<Plot>, Layout) {
    let axes = &table.axes;
    let azimuth = axes.azimuth_deg[a];
    let azimuth = if azimuth.is_nan() {
        "mean over azimuths".into()
    } else {
        format!("azimuth {azimuth}°")
    };
    let eta = table.retroreflected[[i, a]];
    let back = if eta == 0.0 {
        "nothing back".into()
    } else {
        format!("{:.2} % back", 100.0 * eta)
    };
    let title = format!("incidence {}°, {azimuth}: {back}", axes.incidence_deg[i]);
    let plots = vec![plot];
    let [across, upward] = labels.axes;
    let layout = Layout::auto_from_plots(&plots)
        .with_title(title)
        .with_x_label(across)
        .with_y_label(upward)
        .with_title_size(13);
    (plots, layout)
}
