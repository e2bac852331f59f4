//! Mid-air image of a picture: the picture blurred and dimmed by a fitted sheet.
//!
//! The picture is the source as it appears in the mid-air image: upright, one luminance per pixel.
//! The area outside the picture is black.

pub mod camera;
pub mod psf;
pub mod sampled;
pub(crate) mod stray;
pub(crate) mod tiles;
pub(crate) mod transform;
pub mod view;

use crate::error::Error;
use crate::images::render::camera::Camera;
use crate::images::render::psf::Psf;
use crate::images::render::tiles::Tiles;
use crate::images::render::transform::Convolver;
use crate::images::render::view::{CameraView, PixelView};
use rayon::prelude::*;

use crate::images::progress::{Pieces, RenderProgress};
use crate::images::spot::{Sheet, Viewpoint};
use edges::photographs::photo::picture::Picture;

/// Scale and orientation of a picture in the mid-air image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Width of a pixel in the plane of the image, mm.
    pub pitch_mm: f64,
    /// Direction of the tangential axis, degrees: 0 is right (+x, columns), 90 is down (+y, rows).
    pub tangential_axis_deg: f64,
    /// True if the sheet is seen in the half mirror: the sagittal axis is then 90 degrees clockwise
    /// from the tangential one, else counter-clockwise.
    pub seen_in_mirror: bool,
}

impl Scale {
    /// Returns the matrix that converts (tangential, sagittal) mm to (columns, rows).
    pub(crate) fn pixels_from_mm(&self) -> [[f64; 2]; 2] {
        let (sine, cosine) = self.tangential_axis_deg.to_radians().sin_cos();
        let clockwise = [-sine, cosine].map(|v| if self.seen_in_mirror { v } else { -v });
        [[cosine, clockwise[0]], [sine, clockwise[1]]].map(|row| row.map(|v| v / self.pitch_mm))
    }
}

/// Computes the weights of the blur for a picture whose pixels are all seen from one direction.
///
/// Where mu is not known, [`Psf::energy`] is `None`, and [`uniform`] uses 1. With a camera, a pixel
/// of the image is the mean over the square of the camera's pixel around the same place, behind its
/// lens.
///
/// # Errors
/// Returns an [`Error`] if the sheet has no blur at this place, or if the blur is too wide.
pub fn uniform_psf(
    sheet: &dyn Sheet,
    place: &Viewpoint,
    scale: &Scale,
    camera: Option<&Camera>,
    progress: RenderProgress<'_>,
) -> Result<Psf, Error> {
    let camera = camera.map(|own| own.in_pixels(scale.pitch_mm));
    let pixels_from_mm = scale.pixels_from_mm();
    Psf::seen(sheet, place, pixels_from_mm, camera.as_ref(), progress)
}

/// Renders a picture with one blur and one brightness for all pixels.
///
/// This is the far field: every pixel is seen at the same incidence and distance. The sum of each
/// colour plane is the energy times that of the source, except for the light that is blurred past
/// the frame.
pub fn uniform(source: &Picture, psf: &Psf, progress: RenderProgress<'_>) -> Picture {
    let energy = psf.energy.unwrap_or(1.0) as f32;
    let size = [source.width, source.height];
    let planes = if energy == 0.0 {
        vec![vec![0.0; source.width * source.height]; source.planes.len()]
    } else {
        let convolver = Convolver::new(size, psf.reach);
        let mut scaled = psf.clone();
        scaled
            .weights
            .iter_mut()
            .for_each(|weight| *weight *= energy);
        let weights = convolver.weights(&scaled);
        let pieces = Pieces::new(progress, "colours", source.planes.len());
        let planes = source.planes.iter();
        planes
            .map(|plane| {
                let blurred = convolver.blur(plane, &weights);
                pieces.one();
                blurred
            })
            .collect()
    };
    Picture {
        planes,
        warnings: Vec::new(),
        ..*source
    }
}

/// Renders the image that a camera sees: every pixel has its own blur and brightness.
///
/// The error is at most `tolerance` of the greatest energy (see `Tiles`). If the view has a
/// coating, the reflection of the source in the front face of the sheet is added: `half_mirror`
/// times the share that the face reflects by Fresnel's equations.
///
/// # Errors
/// Returns the error of [`CameraView::at`] if the view does not show the sheet, and
/// [`Error::Pixel`] if the blur of a pixel cannot be computed.
pub fn viewed(
    source: &Picture,
    sheet: &dyn Sheet,
    view: &CameraView,
    half_mirror: f64,
    tolerance: f64,
    progress: RenderProgress<'_>,
) -> Result<(Picture, Tiles), Error> {
    let size = [source.width, source.height];
    let seen = seen_by(view, source);
    let tiles = Tiles::new(size, tolerance, progress, |at| -> Result<Psf, Error> {
        let PixelView {
            place,
            pixels_from_mm,
            ..
        } = seen(at)?;
        let psf = Psf::new(sheet, &place, pixels_from_mm);
        psf.map_err(|error| Error::Pixel(at.map(|side| side.max(0.0)), Box::new(error)))
    })?;
    let mut planes = tiles.render(&source.planes, size, progress);
    coat(&mut planes, source, view, half_mirror)?;
    let image = Picture {
        planes,
        warnings: Vec::new(),
        ..*source
    };
    Ok((image, tiles))
}

/// Returns a function that says how the view shows the pixel at (column, row) of a picture.
fn seen_by<'a>(
    view: &'a CameraView,
    source: &Picture,
) -> impl Fn([f64; 2]) -> Result<PixelView, Error> + Sync + use<'a> {
    let middle = middle(source);
    move |[x, y]| view.at([x - middle[0], y - middle[1]])
}

/// Returns the middle of a picture, in columns and rows from the middle of its first pixel.
fn middle(source: &Picture) -> [f64; 2] {
    [source.width, source.height].map(|n| 0.5 * (n as f64 - 1.0))
}

/// Adds the reflection of the source in the front face of the sheet, if the face is coated.
///
/// # Errors
/// Returns the error of [`CameraView::at`] if the view does not show the sheet at a pixel.
fn coat(
    planes: &mut [Vec<f32>],
    source: &Picture,
    view: &CameraView,
    half_mirror: f64,
) -> Result<(), Error> {
    let Some(index) = view.coating else {
        return Ok(());
    };
    let (size, middle) = ([source.width, source.height], middle(source));
    let seen = seen_by(view, source);
    for (plane, own) in planes.iter_mut().zip(&source.planes) {
        let rows = plane.par_chunks_exact_mut(source.width).enumerate();
        rows.try_for_each(|(y, row)| -> Result<(), Error> {
            for (x, value) in row.iter_mut().enumerate() {
                let PixelView {
                    place, mirrored, ..
                } = seen([x as f64, y as f64])?;
                if let Some([column, row]) = mirrored {
                    let share = half_mirror * view::fresnel(index, place.incidence_deg);
                    let at = [column + middle[0], row + middle[1]];
                    *value += share as f32 * bilinear(own, size, at);
                }
            }
            Ok(())
        })?;
    }
    Ok(())
}

/// Interpolates a plane linearly between the middles of its pixels; outside it is black.
pub(crate) fn bilinear(plane: &[f32], [width, height]: [usize; 2], [x, y]: [f64; 2]) -> f32 {
    let (left, top) = (x.floor(), y.floor());
    let (across, down) = ((x - left) as f32, (y - top) as f32);
    let at = |column: f64, row: f64| {
        let inside = column >= 0.0 && row >= 0.0 && column < width as f64 && row < height as f64;
        if inside {
            plane[row as usize * width + column as usize]
        } else {
            0.0
        }
    };
    let line = |row: f64| at(left, row) * (1.0 - across) + at(left + 1.0, row) * across;
    line(top) * (1.0 - down) + line(top + 1.0) * down
}
