//! Mid-air image by samples: every pixel gathers light from the places of the source that reach it.
//!
//! The mean of a picture of square pixels over the square of one pixel is linear between pixels,
//! along both axes. One sample of the spot is therefore one interpolated value. Only the blur is
//! sampled, and the expected image is the image of [`Psf`].
//!
//! [`Psf`]: crate::images::render::psf::Psf

use rayon::prelude::*;

use crate::error::Error;
use crate::images::progress::{Pieces, RenderProgress};
use crate::images::render::view;
use crate::images::render::view::CameraView;
use crate::images::render::{Scale, bilinear, coat, seen_by};
use crate::images::spot::{Sheet, Spot, Viewpoint};
use edges::photographs::photo::picture::Picture;
use estimator::Error as Unshown;
use estimator::samples::Points;
use estimator::samples::Sampling;

/// Count of independent randomisations among which the samples of a pixel are divided.
///
/// Their scatter gives the standard error of the pixel.
const RANDOMISATIONS: usize = 8;

/// Samples that one randomisation draws for a picture under one blur; every pixel takes a block of
/// them.
const DRAWN: usize = 32_768;

/// Pieces of the work, in words.
const ROWS: &str = "rows of pixels";

/// Image that was rendered by samples.
#[derive(Debug)]
pub struct Sampled {
    /// Rendered image.
    pub image: Picture,
    /// Root mean square of the standard errors of all values of the image; `None` with one sample a
    /// pixel.
    pub standard_error: Option<f64>,
    /// Blur and brightness of the sheet: one entry for the whole picture, or one for every pixel.
    pub seen: Vec<Spotted>,
}

/// Brightness of the sheet at one place.
#[derive(Debug, Clone, Copy)]
pub struct Spotted {
    /// Incidence, azimuth and distance of the place.
    pub place: Viewpoint,
    /// Luminance of the mid-air image divided by that of the source; `None` without mu.
    pub energy: Option<f64>,
    /// True if the place lies between the directions of the table.
    pub interpolated: bool,
}

impl Spotted {
    fn of(place: Viewpoint, spot: &dyn Spot) -> Spotted {
        Spotted {
            place,
            energy: spot.energy(),
            interpolated: spot.interpolated(),
        }
    }

    /// Returns the energy, or 1 if mu is not known.
    fn brightness(&self) -> f64 {
        self.energy.unwrap_or(1.0)
    }
}

/// Samples of a pixel: `each` samples of every randomisation.
struct Plan {
    nets: Vec<Points>,
    each: usize,
}

impl Plan {
    fn new(sampling: Sampling) -> Plan {
        let count = RANDOMISATIONS.min(sampling.samples);
        let net = |stream| Points::new(sampling.sequence, sampling.seed, stream as u64);
        Plan {
            nets: (0..count).map(net).collect(),
            each: sampling.samples.div_ceil(count),
        }
    }
}

/// Value of a pixel in every plane, and the sum of the squares of their standard errors (0 for one
/// randomisation).
type Gathered = (Vec<f32>, f64);

/// Returns the value of a pixel: the mean over all randomisations, each of which gives offsets in
/// pixels.
fn gather<O: Iterator<Item = [f64; 2]>>(
    source: &Picture,
    pixel: usize,
    brightness: f64,
    randomisations: impl Iterator<Item = O>,
) -> Gathered {
    let size = [source.width, source.height];
    let at = [pixel % source.width, pixel / source.width].map(|v| v as f64);
    let planes = source.planes.len();
    let (mut sums, mut squares, mut count) = (vec![0.0; planes], vec![0.0; planes], 0.0);
    let mut own = vec![0.0; planes];
    for offsets in randomisations {
        own.fill(0.0);
        let mut each = 0.0;
        for [x, y] in offsets {
            // The light that is displaced by (x, y) to this pixel comes from here.
            let from = [at[0] - x, at[1] - y];
            for (own, plane) in own.iter_mut().zip(&source.planes) {
                *own += f64::from(bilinear(plane, size, from));
            }
            each += 1.0;
        }
        for (k, own) in own.iter().enumerate() {
            let mean = own / each * brightness;
            sums[k] += mean;
            squares[k] += mean * mean;
        }
        count += 1.0;
    }
    let variance = |(sum, square): (&f64, &f64)| {
        let scatter: f64 = (square - sum * sum / count).max(0.0);
        if count > 1.0 {
            scatter / (count - 1.0) / count
        } else {
            0.0
        }
    };
    let error = sums.iter().zip(&squares).map(variance).sum();
    (sums.iter().map(|sum| (sum / count) as f32).collect(), error)
}

/// Assembles the image from its pixels, and returns it with its standard error.
fn image(source: &Picture, gathered: Vec<Gathered>, plan: &Plan) -> (Picture, Option<f64>) {
    let plane = |k: usize| gathered.iter().map(|(values, _)| values[k]).collect();
    let planes: Vec<Vec<f32>> = (0..source.planes.len()).map(plane).collect();
    let errors: f64 = gathered.iter().map(|(_, error)| error).sum();
    let count = (gathered.len() * planes.len()) as f64;
    let picture = Picture {
        planes,
        warnings: Vec::new(),
        ..*source
    };
    let standard_error = (plan.nets.len() > 1).then(|| (errors / count).sqrt());
    (picture, standard_error)
}

/// Multiplies an offset by a matrix.
fn turned(matrix: &[[f64; 2]; 2], offset: [f64; 2]) -> [f64; 2] {
    matrix.map(|row| row[0] * offset[0] + row[1] * offset[1])
}

/// Counts the row of a pixel if the pixel is the first of it.
fn tell(rows: &Pieces<'_>, source: &Picture, pixel: usize) {
    if pixel.is_multiple_of(source.width) {
        rows.one();
    }
}

/// Renders a picture with one blur and one brightness for all pixels.
///
/// All pixels share the samples, and each pixel uses a block of them.
///
/// # Errors
/// Returns [`Error::Sheet`] if the sheet has no blur at this place, and [`Error::NoSamples`] if the
/// model has no samples.
pub fn uniform(
    source: &Picture,
    sheet: &dyn Sheet,
    place: &Viewpoint,
    scale: &Scale,
    sampling: Sampling,
    progress: RenderProgress<'_>,
) -> Result<Sampled, Error> {
    let plan = Plan::new(sampling);
    let spot = sheet.spot(place, 0.0)?;
    let seen = Spotted::of(*place, &*spot);
    let matrix = scale.pixels_from_mm();
    let blocks = DRAWN.div_ceil(plan.each);
    let nets: Vec<Vec<[f64; 2]>> = if seen.brightness() == 0.0 {
        vec![vec![[0.0; 2]; blocks * plan.each]; plan.nets.len()]
    } else {
        let offset = spot.samples().ok_or(Error::NoSamples)?;
        let draw = |points: &Points| {
            let indices = (0..(blocks * plan.each) as u32).into_par_iter();
            let drawn = indices.map(|index| turned(&matrix, offset(points.at(index))));
            drawn.collect()
        };
        plan.nets.iter().map(draw).collect()
    };
    let pixels = (0..source.width * source.height).into_par_iter();
    let rows = Pieces::new(progress, ROWS, source.height);
    let gathered = pixels.map(|pixel| {
        // Neighbouring pixels use blocks that are far apart. Every randomisation uses other blocks.
        let own = nets.iter().enumerate().map(|(k, net)| {
            let block = (pixel.wrapping_mul(0x9e37_79b1) >> 7).wrapping_add(k * pixel) % blocks;
            net[block * plan.each..][..plan.each].iter().copied()
        });
        let found = gather(source, pixel, seen.brightness(), own);
        tell(&rows, source, pixel);
        found
    });
    let (image, standard_error) = image(source, gathered.collect(), &plan);
    Ok(Sampled {
        image,
        standard_error,
        seen: vec![seen],
    })
}

/// Renders the image that a camera sees: every pixel has its own blur and brightness, without
/// tiles.
///
/// If the view has a coating, the reflection of the source is added as in
/// [`crate::images::render::viewed`].
///
/// # Errors
/// Returns the error of [`CameraView::at`] if the view does not show the sheet, [`Error::Pixel`] if
/// the blur of a pixel cannot be computed, and [`Error::NoSamples`] if the model has no samples.
pub fn viewed(
    source: &Picture,
    sheet: &dyn Sheet,
    view: &CameraView,
    half_mirror: f64,
    sampling: Sampling,
    progress: RenderProgress<'_>,
) -> Result<Sampled, Error> {
    let plan = Plan::new(sampling);
    let seen = seen_by(view, source);
    let pixels = (0..source.width * source.height).into_par_iter();
    let rows = Pieces::new(progress, ROWS, source.height);
    let one = |pixel: usize| -> Result<(Gathered, Spotted), Error> {
        tell(&rows, source, pixel);
        let at = [pixel % source.width, pixel / source.width].map(|v| v as f64);
        let view::PixelView {
            place,
            pixels_from_mm,
            ..
        } = seen(at)?;
        let fault = |fault: Unshown| Error::Pixel(at, Box::new(fault.into()));
        let spot = sheet.spot(&place, 0.0).map_err(fault)?;
        let spotted = Spotted::of(place, &*spot);
        if spotted.brightness() == 0.0 {
            return Ok(((vec![0.0; source.planes.len()], 0.0), spotted));
        }
        let offset = spot.samples().ok_or(Error::NoSamples)?;
        let first = (pixel as u32).wrapping_mul(plan.each as u32);
        let own = plan.nets.iter().map(|points| {
            let indices = (0..plan.each as u32).map(|k| first.wrapping_add(k));
            indices.map(|index| turned(&pixels_from_mm, offset(points.at(index))))
        });
        Ok((gather(source, pixel, spotted.brightness(), own), spotted))
    };
    let (gathered, spotted) = pixels.map(one).collect::<Result<(Vec<_>, Vec<_>), _>>()?;
    let (mut image, standard_error) = image(source, gathered, &plan);
    coat(&mut image.planes, source, view, half_mirror)?;
    Ok(Sampled {
        image,
        standard_error,
        seen: spotted,
    })
}
