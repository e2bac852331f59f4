//! The mid-air image by samples: every pixel gathers the source from where its light comes.
//!
//! The mean over a pixel's square of a picture of square pixels is a straight line between its
//! pixels, both ways, so that a sample of the spot is one interpolated value: the blur alone is
//! sampled, and the expected image is the one of [`Psf`].
//!
//! [`Psf`]: crate::images::render::psf::Psf

use rayon::prelude::*;

use crate::images::render::psf::Fault;
use crate::images::render::view;
use crate::images::render::view::CameraView;
use crate::images::render::{Error, Scale, bilinear, coat, seen_by};
use crate::images::spot::{Sheet, Spot, Viewpoint};
use crate::photographs::photo::picture::Picture;
use crate::predict::Error as Unshown;
use crate::samples::Points;
use crate::samples::Sampling;

/// Independent randomisations among which a pixel's samples are shared out; its standard error
/// comes from their scatter.
const RANDOMISATIONS: usize = 8;

/// Samples of one randomisation that are drawn for a picture under one blur, a block of which every
/// pixel takes.
const DRAWN: usize = 32_768;

/// An image by samples.
#[derive(Debug)]
pub(crate) struct Sampled {
    /// The image.
    pub image: Picture,
    /// Root mean square over all values of the image of their standard errors; `None` for one
    /// sample a pixel.
    pub standard_error: Option<f64>,
    /// How the sheet was seen: once, or for every pixel.
    pub seen: Vec<Spotted>,
}

/// What the sheet makes of one place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spotted {
    /// The place.
    pub place: Viewpoint,
    /// Luminance over the source's; `None` without mu.
    pub energy: Option<f64>,
    /// Whether the place lies between the directions of the table.
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

    fn brightness(&self) -> f64 {
        self.energy.unwrap_or(1.0)
    }
}

/// The samples of a pixel: `each` of every randomisation.
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

/// Value of every plane, and the sum of the squares of their standard errors (0 for one
/// randomisation).
type Gathered = (Vec<f32>, f64);

/// The mean over randomisations, each of which gives its offsets in pixels.
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
            // Light that lands here left the source so far back.
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

fn turned(matrix: &[[f64; 2]; 2], offset: [f64; 2]) -> [f64; 2] {
    matrix.map(|row| row[0] * offset[0] + row[1] * offset[1])
}

/// A picture under one blur and dimming. All pixels share the samples, each a block of them.
///
/// # Errors
/// [`Error::Blur`]; [`Error::NoSamples`].
pub(crate) fn uniform(
    source: &Picture,
    sheet: &dyn Sheet,
    place: &Viewpoint,
    scale: &Scale,
    sampling: Sampling,
) -> Result<Sampled, Error> {
    let plan = Plan::new(sampling);
    let spot = sheet.spot(place, 0.0).map_err(Fault::from)?;
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
    let gathered = pixels.map(|pixel| {
        // Neighbours take blocks far apart; another randomisation, other ones.
        let own = nets.iter().enumerate().map(|(k, net)| {
            let block = (pixel.wrapping_mul(0x9e37_79b1) >> 7).wrapping_add(k * pixel) % blocks;
            net[block * plan.each..][..plan.each].iter().copied()
        });
        gather(source, pixel, seen.brightness(), own)
    });
    let (image, standard_error) = image(source, gathered.collect(), &plan);
    Ok(Sampled {
        image,
        standard_error,
        seen: vec![seen],
    })
}

/// The image as a camera sees it: blur and dimming of every pixel its own, without tiles. What the
/// coating mirrors is added as in [`crate::images::render::viewed`].
///
/// # Errors
/// [`Error::Unseen`], [`Error::Pixel`], [`Error::NoSamples`].
pub(crate) fn viewed(
    source: &Picture,
    sheet: &dyn Sheet,
    view: &CameraView,
    half_mirror: f64,
    sampling: Sampling,
) -> Result<Sampled, Error> {
    let plan = Plan::new(sampling);
    let seen = seen_by(view, source);
    let pixels = (0..source.width * source.height).into_par_iter();
    let one = |pixel: usize| -> Result<(Gathered, Spotted), Error> {
        let at = [pixel % source.width, pixel / source.width].map(|v| v as f64);
        let view::Seen {
            place,
            pixels_from_mm,
            ..
        } = seen(at)?;
        let fault = |fault: Unshown| Error::Pixel {
            column: at[0],
            row: at[1],
            fault: Box::new(fault.into()),
        };
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
