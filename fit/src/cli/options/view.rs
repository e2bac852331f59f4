//! A small picture through a VIEW.toml, without a command line.

use std::error::Error;
use std::path::Path;

use tables::Table;

use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;
use estimator::predict::Fitted;
use estimator::result::ResultFile;
use pictures::images::SILENT;
use pictures::images::render;
use pictures::images::render::view::CameraView;

/// Number of columns and of rows of the picture.
const SIZE: [usize; 2] = [12, 8];

/// Largest error between tiles, as a share; the default of `fit render`.
const TOLERANCE: f64 = 0.01;

/// Renders a small white picture as the camera of a VIEW.toml sees it, as `fit render --view` does.
///
/// The fuzzer gives files from strangers to this function.
///
/// # Errors
/// Returns the error with which `fit render` refuses the view, the result or the table.
pub fn render_view(
    view: &Path,
    result: &ResultFile,
    table: &Table,
) -> Result<Picture, Box<dyn Error>> {
    let table = result.seen(table)?;
    let sheet = Fitted::new(result, &table)?;
    let view = CameraView::load(view)?;
    let [width, height] = SIZE;
    let white = Picture {
        width,
        height,
        planes: vec![vec![1.0; width * height]],
        transfer: Transfer::Linear,
        warnings: Vec::new(),
    };
    let (mut image, _) =
        render::viewed(&white, &sheet, &view, result.half_mirror, TOLERANCE, SILENT)?;
    image.expose(view.ambient, 1.0);
    Ok(image)
}
