//! The mid-air image of a picture: blurred and dimmed as a sheet does it.
//!
//! The picture is the source as it appears in the mid-air image, upright, one luminance a pixel;
//! pixels outside of it are black.

pub(crate) mod psf;
pub(crate) mod sampled;
pub(crate) mod tiles;
pub(crate) mod transform;
pub(crate) mod view;

use std::path::PathBuf;

use crate::images::render::psf::{Fault, Psf};
use crate::images::render::tiles::Tiles;
use crate::images::render::transform::Convolver;
use crate::images::render::view::{CameraView, Seen};
use rayon::prelude::*;

use crate::images::spot::{Sheet, Viewpoint};
use crate::photographs::photo::picture::Picture;

/// Why there is no image.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Error {
    /// Neither .exr nor .png.
    #[error("{}: an image is written as .exr or .png; give one of these endings", path.display())]
    Ending {
        /// The file asked for.
        path: PathBuf,
    },
    /// The encoder failed.
    #[error("{}: the image could not be encoded ({message}); try the other of .exr and .png", path.display())]
    Encode {
        /// The file asked for.
        path: PathBuf,
        /// What the library said.
        message: String,
    },
    /// The blur cannot be had.
    #[error(transparent)]
    Blur(#[from] Fault),
    /// A view that cannot be read.
    #[error(transparent)]
    CameraView(#[from] crate::document::Error),
    /// A view that does not show the sheet.
    #[error(transparent)]
    Unseen(#[from] view::Error),
    /// A model that is known by its transform alone.
    #[error(
        "the model of this result has no samples: --forward render does eq1, angular, shift and \
        lobe; use --forward spectral"
    )]
    NoSamples,
    /// A pixel is seen at an angle that the table lacks.
    #[error("at pixel ({column:.0}, {row:.0}) of the view: {fault}")]
    Pixel {
        /// Column.
        column: f64,
        /// Row.
        row: f64,
        /// What is wrong.
        fault: Box<Fault>,
    },
}

/// How a picture lies in the mid-air image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    /// One pixel in the plane of the image, mm.
    pub pitch_mm: f64,
    /// Direction of the tangential axis, from +x (columns, right) towards +y (rows, down), degrees.
    pub tangential_axis_deg: f64,
}

impl Scale {
    /// From (tangential, sagittal) mm to (columns, rows).
    pub(crate) fn pixels_from_mm(&self) -> [[f64; 2]; 2] {
        let (sine, cosine) = self.tangential_axis_deg.to_radians().sin_cos();
        [[cosine, -sine], [sine, cosine]].map(|row| row.map(|v| v / self.pitch_mm))
    }
}

/// Weights for a picture seen from one direction; a place of no known mu gets energy 1.
///
/// # Errors
/// [`Fault`].
pub(crate) fn uniform_psf(
    sheet: &dyn Sheet,
    place: &Viewpoint,
    scale: &Scale,
) -> Result<Psf, Fault> {
    Psf::new(sheet, place, scale.pixels_from_mm())
}

/// A picture under one blur and dimming: the far field, where every pixel is seen at the same
/// incidence and distance.
///
/// Every plane's sum is the energy times that of the source, but for what is blurred past the
/// frame.
pub(crate) fn uniform(source: &Picture, psf: &Psf) -> Picture {
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
        let planes = source.planes.iter();
        planes
            .map(|plane| convolver.blur(plane, &weights))
            .collect()
    };
    Picture {
        planes,
        warnings: Vec::new(),
        ..*source
    }
}

/// The image as a camera sees it: blur and dimming of every pixel its own, to `tolerance` of the
/// greatest energy ([`Tiles`]). With a coating, what the sheet's front face mirrors is added,
/// `half_mirror` times Fresnel's share of it.
///
/// # Errors
/// [`Error::Unseen`], [`Error::Pixel`].
pub(crate) fn viewed(
    source: &Picture,
    sheet: &dyn Sheet,
    view: &CameraView,
    half_mirror: f64,
    tolerance: f64,
) -> Result<(Picture, Tiles), Error> {
    let size = [source.width, source.height];
    let seen = seen_by(view, source);
    let tiles = Tiles::new(size, tolerance, |at| -> Result<Psf, Error> {
        let Seen {
            place,
            pixels_from_mm,
            ..
        } = seen(at)?;
        let psf = Psf::new(sheet, &place, pixels_from_mm);
        psf.map_err(|fault| Error::Pixel {
            column: at[0].max(0.0),
            row: at[1].max(0.0),
            fault: Box::new(fault),
        })
    })?;
    let mut planes = tiles.render(&source.planes, size);
    coat(&mut planes, source, view, half_mirror)?;
    let image = Picture {
        planes,
        warnings: Vec::new(),
        ..*source
    };
    Ok((image, tiles))
}

/// How the view shows the pixels of a picture, given as (column, row).
fn seen_by<'a>(
    view: &'a CameraView,
    source: &Picture,
) -> impl Fn([f64; 2]) -> Result<Seen, view::Error> + Sync + use<'a> {
    let middle = middle(source);
    move |[x, y]| view.at([x - middle[0], y - middle[1]])
}

fn middle(source: &Picture) -> [f64; 2] {
    [source.width, source.height].map(|n| 0.5 * (n as f64 - 1.0))
}

/// Adds what the sheet's front face mirrors, if it is coated.
fn coat(
    planes: &mut [Vec<f32>],
    source: &Picture,
    view: &CameraView,
    half_mirror: f64,
) -> Result<(), view::Error> {
    let Some(index) = view.coating else {
        return Ok(());
    };
    let (size, middle) = ([source.width, source.height], middle(source));
    let seen = seen_by(view, source);
    for (plane, own) in planes.iter_mut().zip(&source.planes) {
        let rows = plane.par_chunks_exact_mut(source.width).enumerate();
        rows.try_for_each(|(y, row)| -> Result<(), view::Error> {
            for (x, value) in row.iter_mut().enumerate() {
                let Seen {
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

/// A plane between its pixels, black outside.
fn bilinear(plane: &[f32], [width, height]: [usize; 2], [x, y]: [f64; 2]) -> f32 {
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
