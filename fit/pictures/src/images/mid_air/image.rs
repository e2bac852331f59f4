//! The image of a picture, from afar or as a camera sees it, before exposure.

use crate::error::Error;
use crate::images::mid_air::facts::TileFacts;
use crate::images::render;
use crate::images::render::camera::Camera;
use crate::images::render::psf::{LARGEST, Psf};
use crate::images::render::sampled;
use crate::images::render::sampled::Spotted;
use crate::images::render::view::CameraView;
use crate::images::{RenderProgress, Scale, Viewpoint};
use edges::photographs::photo::picture::Picture;
use estimator::estimate::Forward;
use estimator::predict::Fitted;
use estimator::result::ResultFile;
use estimator::samples::Sampling;
use tables::Table;

/// How an image is made.
pub(super) struct Method<'a> {
    /// Transforms or samples.
    pub forward: Forward,
    /// Samples of the blur, for a render by samples.
    pub sampling: Sampling,
    /// Camera whose blur an image from afar has.
    pub camera: Option<&'a Camera>,
    /// Tables of the sheet in red, green and blue light; `None` if one stands for all.
    pub colours: Option<[&'a Table; 3]>,
    /// Callback for the progress.
    pub progress: RenderProgress<'a>,
}

/// Image and the facts about it.
pub(super) struct Rendered {
    /// The image.
    pub image: Picture,
    /// Places whose blur was computed.
    pub spots: Vec<Spotted>,
    /// Largest error of the contrast of single pixels, because of a blur finer than they are.
    pub transfer_error: f64,
    /// Tiles of a view.
    pub tiles: Option<TileFacts>,
    /// Standard error of a pixel of a render by samples.
    pub sampling_error: Option<f64>,
}

impl Rendered {
    fn by_transforms(image: Picture, places: Vec<Viewpoint>, psfs: &[Psf]) -> Rendered {
        let spotted = |(place, psf): (Viewpoint, &Psf)| Spotted {
            place,
            energy: psf.energy,
            interpolated: psf.interpolated,
        };
        Rendered {
            image,
            spots: places.into_iter().zip(psfs).map(spotted).collect(),
            transfer_error: psfs.iter().map(|psf| psf.error).fold(0.0, f64::max),
            tiles: None,
            sampling_error: None,
        }
    }

    fn by_samples(sampled: sampled::Sampled) -> Rendered {
        Rendered {
            image: sampled.image,
            spots: sampled.seen,
            transfer_error: 0.0,
            tiles: None,
            sampling_error: sampled.standard_error,
        }
    }
}

/// Renders red, green and blue by what each sees of the lamp, where the result tells this, and by
/// the table of each, where these are given; all planes alike without either, or if the picture has
/// no colours. The facts are those of green, whose light is the largest part of the luminance.
fn in_colours(
    source: &Picture,
    sheet: &Fitted<'_>,
    tables: Option<[&Table; 3]>,
    render: &dyn Fn(&Picture, &Fitted<'_>) -> Result<Rendered, Error>,
) -> Result<Rendered, Error> {
    let lights = sheet.result.colours.as_ref();
    if source.planes.len() != 3 || (lights.is_none() && tables.is_none()) {
        return render(source, sheet);
    }
    let one = |k: usize| {
        let plane = Picture {
            planes: vec![source.planes[k].clone()],
            warnings: Vec::new(),
            ..*source
        };
        let light = lights.map(|lights| lights[k].clone());
        let result = ResultFile {
            wavelength_nm: light.or(sheet.result.wavelength_nm.clone()),
            ..sheet.result.clone()
        };
        let own = tables.map_or(Ok(*sheet), |tables| sheet.in_colour(tables[k]))?;
        let own = Fitted {
            result: &result,
            ..own
        };
        render(&plane, &own)
    };
    let [mut red, mut green, mut blue] = [one(0)?, one(1)?, one(2)?];
    let each = [&mut red, &mut green, &mut blue];
    let planes = each.map(|own| std::mem::take(&mut own.image.planes));
    green.image.planes = planes.into_iter().flatten().collect();
    green.transfer_error = (green.transfer_error.max(red.transfer_error)).max(blue.transfer_error);
    Ok(green)
}

/// Renders the image with one incidence and distance for all pixels.
pub(super) fn from_afar(
    source: &Picture,
    sheet: &Fitted<'_>,
    place: Viewpoint,
    scale: &Scale,
    method: &Method<'_>,
) -> Result<Rendered, Error> {
    Ok(match method.forward {
        Forward::Spectral => in_colours(source, sheet, method.colours, &|source, sheet| {
            let psf = render::uniform_psf(sheet, &place, scale, method.camera, method.progress)?;
            let image = render::uniform(source, &psf, method.progress);
            Ok(Rendered::by_transforms(image, vec![place], &[psf]))
        })?,
        Forward::Render if method.camera.is_some() => return Err(Error::SampledCamera),
        Forward::Render if method.colours.is_some() => return Err(Error::SampledColours),
        Forward::Render => {
            let (sampling, progress) = (method.sampling, method.progress);
            let found = sampled::uniform(source, sheet, &place, scale, sampling, progress)?;
            Rendered::by_samples(found)
        }
    })
}

/// Fewest pixels along the longer side that are a picture: under a blur too wide for these, nothing
/// is left to see.
const FEWEST: usize = 32;

/// Renders the image as [`from_afar`] does, of a picture with fewer pixels if the blur is too wide
/// for those that it has.
///
/// Returns the picture that was rendered, if it is another, and the side of its pixels, mm.
pub(super) fn from_afar_reduced(
    source: &Picture,
    sheet: &Fitted<'_>,
    place: Viewpoint,
    scale: &Scale,
    method: &Method<'_>,
) -> Result<(Rendered, Option<Picture>, f64), Error> {
    let longer = source.width.max(source.height);
    let mut factor = 1;
    loop {
        let reduced = (factor > 1).then(|| source.reduced(factor));
        let scale = Scale {
            pitch_mm: scale.pitch_mm * factor as f64,
            ..*scale
        };
        let picture = reduced.as_ref().unwrap_or(source);
        let rendered = from_afar(picture, sheet, place, &scale, method);
        let Err(Error::Wide { size, .. }) = rendered else {
            return Ok((rendered?, reduced, scale.pitch_mm));
        };
        factor = (factor + 1).max(factor.saturating_mul(size) / LARGEST);
        if factor.saturating_mul(FEWEST) > longer {
            return Ok((rendered?, None, scale.pitch_mm));
        }
    }
}

/// Renders the image as a camera sees it: each pixel at its own incidence, azimuth and distance.
///
/// `tolerance` is the largest error between tiles, as a share of the brightest pixel.
pub(super) fn from_camera(
    source: &Picture,
    sheet: &Fitted<'_>,
    view: &CameraView,
    tolerance: f64,
    method: &Method<'_>,
) -> Result<Rendered, Error> {
    let (half_mirror, progress) = (sheet.result.half_mirror, method.progress);
    Ok(match method.forward {
        Forward::Spectral => in_colours(source, sheet, method.colours, &|source, sheet| {
            let (image, tiles) =
                render::viewed(source, sheet, view, half_mirror, tolerance, progress)?;
            let [width, height] = [source.width, source.height].map(|n| n as f64);
            let places = tiles.corner_places().map(|[x, y]| {
                let seen = view.at([x - 0.5 * (width - 1.0), y - 0.5 * (height - 1.0)]);
                seen.map(|seen| seen.place)
            });
            let places = places.collect::<Result<_, _>>()?;
            Ok(Rendered {
                tiles: Some(TileFacts {
                    counts: tiles.counts(),
                    error: tiles.error,
                }),
                ..Rendered::by_transforms(image, places, tiles.corners())
            })
        })?,
        Forward::Render if method.colours.is_some() => return Err(Error::SampledColours),
        Forward::Render => {
            let sampling = method.sampling;
            let sampled = sampled::viewed(source, sheet, view, half_mirror, sampling, progress)?;
            Rendered::by_samples(sampled)
        }
    })
}
