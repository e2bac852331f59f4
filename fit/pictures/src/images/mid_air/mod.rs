//! The mid-air image of a picture, exposed, with what is to be known of it.
//!
//! A picture, a fitted sheet and what is wanted enter. The image leaves, with its facts and
//! warnings.

mod facts;
mod image;
mod remarks;

use edges::photographs::photo::picture::Picture;
use estimator::estimate::Forward;
use estimator::predict::{Fitted, remarks as of_places};
use estimator::samples::Sampling;
use tables::Table;

use crate::error::Error;
use crate::images::exposure::automatic;
use crate::images::mid_air::facts::range;
use crate::images::mid_air::image::{Method, from_afar, from_afar_reduced, from_camera};
use crate::images::mid_air::remarks::{beyond_the_rim, of_camera, of_image, of_reduced};
use crate::images::render::camera::Camera;
use crate::images::render::stray::{self, Around};
use crate::images::render::view::CameraView;
use crate::images::{RenderProgress, Scale, Viewpoint};

pub use facts::{Contrast, Facts, Seconds, TileFacts};
pub use remarks::{clipped, spacious};

/// Where the image is looked at from.
#[derive(Debug, Clone)]
pub enum Look {
    /// From so far that one incidence and one distance stand for all pixels.
    Afar {
        /// Place of the image.
        place: Viewpoint,
        /// Size and orientation of its pixels.
        scale: Scale,
        /// True if a picture under a very wide blur gets fewer pixels, of the same width together.
        may_reduce: bool,
    },
    /// By a camera: each pixel has its own incidence, azimuth and distance.
    Camera {
        /// The camera and the sheet.
        view: CameraView,
        /// Largest error between tiles, as a share of the brightest pixel.
        tolerance: f64,
    },
}

/// Factor on the light of the image and on the ambient light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exposure {
    /// This factor.
    Factor(f64),
    /// The factor that makes the brightest pixel as bright as that of the source.
    Automatic,
}

/// What is wanted of a mid-air image.
#[derive(Debug, Clone)]
pub struct MidAir {
    /// Where the image is looked at from.
    pub look: Look,
    /// Camera whose blur an image from afar has.
    pub camera: Option<Camera>,
    /// Transforms or samples.
    pub forward: Forward,
    /// Samples of the blur, for an image by samples.
    pub sampling: Sampling,
    /// Luminance behind the image, where source white is 1. A camera's view has its own.
    pub ambient: f64,
    /// Factor on all light.
    pub exposure: Exposure,
    /// True if the source stands beside the image, on its left.
    pub beside: bool,
}

impl MidAir {
    /// Makes the mid-air image of a picture.
    ///
    /// `colours` are tables of the sheet in red, green and blue light, where it is dispersive.
    ///
    /// # Errors
    /// Fails if the view cannot be used, a table lacks a direction, the blur is too wide, or the
    /// result cannot be used with the table.
    pub fn image(
        &self,
        sheet: &Fitted<'_>,
        colours: Option<[&Table; 3]>,
        source: &Picture,
        progress: RenderProgress<'_>,
    ) -> Result<(Picture, Facts), Error> {
        let method = Method {
            forward: self.forward,
            sampling: self.sampling,
            camera: self.camera.as_ref(),
            colours,
            progress,
        };
        let (mut rendered, reduced, pitch_mm) = match &self.look {
            Look::Camera { view, tolerance } => {
                let rendered = from_camera(source, sheet, view, *tolerance, &method)?;
                (rendered, None, view.pitch_mm())
            }
            Look::Afar {
                place,
                scale,
                may_reduce: true,
            } => from_afar_reduced(source, sheet, *place, scale, &method)?,
            Look::Afar { place, scale, .. } => {
                let rendered = from_afar(source, sheet, *place, scale, &method)?;
                (rendered, None, scale.pitch_mm)
            }
        };
        let spots = &rendered.spots;
        let places: Vec<Viewpoint> = spots.iter().map(|spot| spot.place).collect();
        let mut warnings = of_places(sheet.result, sheet.table, &places)?;
        warnings.extend(of_image(source, &rendered, sheet));
        warnings.extend(self.camera.as_ref().and_then(of_camera));
        let fewer = reduced.as_ref();
        warnings.extend(fewer.map(|fewer| of_reduced(source, fewer, pitch_mm)));
        let source = fewer.unwrap_or(source);
        if let Look::Afar { place, .. } = &self.look {
            warnings.extend(spacious(source.width as f64 * pitch_mm, place.r_mm));
        }
        warnings.extend(beyond_the_rim(source, &rendered));

        if !sheet.result.stray.is_none() {
            let around = self.around(sheet, &places, pitch_mm);
            stray::add(&mut rendered.image, source, &sheet.result.stray, &around);
        }

        let (ambient, seen_in_mirror) = match &self.look {
            Look::Camera { view, .. } => (view.ambient, view.is_in_mirror()),
            Look::Afar { scale, .. } => (self.ambient, scale.seen_in_mirror),
        };
        let mut image = rendered.image;
        let contrast = (ambient > 0.0).then(|| Contrast {
            mean: image.mean_luminance() / ambient,
            peak: image.peak_luminance() / ambient,
        });
        let exposure = match self.exposure {
            Exposure::Automatic => automatic(source, &image, ambient),
            Exposure::Factor(factor) => factor,
        };
        image.expose(ambient, exposure);
        let size_mm = [image.width, image.height].map(|pixels| pixels as f64 * pitch_mm);
        let image = match self.beside {
            true => image.beside(source),
            false => image,
        };
        let facts = Facts {
            width: image.width,
            height: image.height,
            channels: image.planes.len(),
            size_mm,
            exposure,
            pixel_pitch_mm: pitch_mm,
            incidence_deg: range(spots, |spot| spot.place.incidence_deg),
            azimuth_deg: (!sheet.table.axes.is_mean())
                .then(|| range(spots, |spot| spot.place.azimuth_deg.unwrap_or(f64::NAN))),
            distance_mm: range(spots, |spot| spot.place.r_mm),
            seen_in_mirror,
            energy: (spots.iter().all(|spot| spot.energy.is_some()))
                .then(|| range(spots, |spot| spot.energy.unwrap_or(1.0))),
            luminance_cd_m2: None,
            transfer_error: rendered.transfer_error,
            tiles: rendered.tiles,
            sampling_error: rendered.sampling_error,
            contrast,
            seconds: None,
            warnings,
        };
        Ok((image, facts))
    }

    /// Returns where light goes astray: of a view, at the middle of its picture.
    fn around(&self, sheet: &Fitted<'_>, places: &[Viewpoint], pitch_mm: f64) -> Around {
        let middle = places.get(places.len() / 2);
        let axes = match &self.look {
            Look::Afar { scale, .. } => Scale { pitch_mm, ..*scale }.pixels_from_mm(),
            Look::Camera { .. } => [[1.0 / pitch_mm, 0.0], [0.0, 1.0 / pitch_mm]],
        };
        let straight = matches!(&self.look, Look::Afar { place, .. } if place.incidence_deg == 0.0);
        Around {
            r_mm: middle.map_or(0.0, |place| place.r_mm),
            pitch_mm,
            axes,
            front: straight.then_some(sheet.result.half_mirror),
        }
    }
}
