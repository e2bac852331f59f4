//! A picture through each sheet, all exposed alike.

use rayon::prelude::*;

use crate::compare::comparison::{Conditions, Contender};
use crate::error::Error;
use crate::images::mid_air::{Exposure, Look, MidAir};
use crate::images::progress::Pieces;
use crate::images::shown;
use crate::images::{RenderProgress, SILENT, Scale, Viewpoint};
use edges::photographs::photo::picture::Picture;
use estimator::estimate::Forward;
use estimator::samples::{Sampling, Sequence};

/// Longest side of a picture, pixels.
const SIDE: usize = 400;

/// Samples, which transforms do not draw.
const UNUSED: Sampling = Sampling {
    samples: 1,
    seed: 0,
    sequence: Sequence::Sobol,
};

/// A picture, and its mid-air images.
#[derive(Debug, Clone)]
pub struct Gallery {
    /// Name of the picture.
    pub name: String,
    /// Width in the air, mm.
    pub width_mm: f64,
    /// The picture itself, as PNG.
    pub source: Vec<u8>,
    /// Factor on the light of all images whose luminance is known.
    pub exposure: f64,
    /// Images, `[incidence][sheet]`.
    pub shown: Vec<Vec<Shown>>,
}

/// A mid-air image.
#[derive(Debug, Clone)]
pub struct Shown {
    /// The image as PNG.
    pub png: Vec<u8>,
    /// True if its luminance is not known, so that it is as bright as its source.
    pub is_unknown: bool,
}

/// Renders a picture through each sheet at each incidence.
///
/// One exposure makes the brightest of all images, with the ambient light, as bright as the source.
/// `tangential_axis_deg` is the direction of the plane of incidence in the picture, degrees.
///
/// # Errors
/// Returns the errors of [`MidAir::image`].
pub fn gallery(
    sheets: &[Contender<'_>],
    conditions: &Conditions,
    (name, source): (String, &Picture),
    width_mm: f64,
    tangential_axis_deg: f64,
    progress: RenderProgress<'_>,
) -> Result<Gallery, Error> {
    let source = shown::at_most(source, SIDE);
    let places = conditions.incidence_deg.iter();
    let places = places.flat_map(|&deg| sheets.iter().map(move |sheet| (deg, sheet)));
    let places: Vec<(f64, &Contender<'_>)> = places.collect();
    let pieces = Pieces::new(progress, "pictures", places.len());
    let images: Vec<(Picture, bool)> = places
        .into_par_iter()
        .map(|(incidence_deg, own)| {
            let wanted = MidAir {
                look: Look::Afar {
                    place: Viewpoint {
                        incidence_deg,
                        azimuth_deg: own.azimuth_deg,
                        r_mm: conditions.floating_distance_mm,
                    },
                    scale: Scale {
                        pitch_mm: width_mm / source.width as f64,
                        tangential_axis_deg,
                        seen_in_mirror: false,
                    },
                    may_reduce: true,
                },
                camera: None,
                forward: Forward::Spectral,
                sampling: UNUSED,
                ambient: 0.0,
                exposure: Exposure::Factor(1.0),
                beside: false,
            };
            let (image, facts) = wanted.image(&own.sheet, None, &source, SILENT)?;
            pieces.one();
            Ok((image, facts.energy.is_none()))
        })
        .collect::<Result<_, Error>>()?;
    let ambient = conditions.viewing.ambient;
    let known = images.iter().filter(|(_, is_unknown)| !is_unknown);
    let brightest = known.map(|(image, _)| image.peak()).fold(0.0, f64::max);
    let exposure = match source.peak() / (brightest + ambient) {
        factor if factor.is_finite() && factor > 0.0 => factor,
        _ => 1.0,
    };
    let shown: Vec<Shown> = images
        .into_par_iter()
        .map(|(mut image, is_unknown)| {
            if !is_unknown {
                image.expose(ambient, exposure);
            }
            Shown {
                png: shown::png(&image),
                is_unknown,
            }
        })
        .collect();
    Ok(Gallery {
        name,
        width_mm,
        source: shown::png(&source),
        exposure,
        shown: shown.chunks(sheets.len()).map(<[Shown]>::to_vec).collect(),
    })
}
