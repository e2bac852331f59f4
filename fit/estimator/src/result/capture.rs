//! The photographs of RESULT.json with their curves, and the camera that took them.

use serde::{Deserialize, Serialize};

use crate::error::{Error, all_within};
use crate::estimate::Estimate;
use crate::estimate::{Aerial, Scene};
use crate::model::{Camera, Lens};
use edges::document::Bounds;

/// Origin of an exposure that the camera wrote.
pub(super) const FROM_EXIF: &str = "Exif";

/// MTF of one photograph, measured and modelled with the same estimator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curves {
    /// Frequencies along the edge normal, 1/mm.
    pub frequency_per_mm: Vec<f64>,
    /// MTF of the photograph.
    pub measured: Vec<f64>,
    /// Standard error of `measured`.
    pub standard_error: Vec<f64>,
    /// MTF of the estimate.
    pub modelled: Vec<f64>,
}

/// One photograph.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaptureResult {
    /// Name of the file.
    pub image: String,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Distance R: optical path from the sheet to the image, mm.
    pub floating_distance_mm: f64,
    /// Relation of the file's values to light that was taken, such as `linear` or `sRGB`; empty in
    /// older results.
    #[serde(default)]
    pub transfer: String,
    /// Origin of this relation: the key `transfer`, a part of the file, or the default of the
    /// format; empty in older results.
    #[serde(default)]
    pub transfer_from: String,
    /// Exposure relative to the reference; null in older results.
    #[serde(default)]
    pub exposure: Option<f64>,
    /// Origin of the exposure: `captures.toml` or `Exif`; empty in older results.
    #[serde(default)]
    pub exposure_from: String,
    /// Direction of the edge normal, degrees: 0 is right (+x), 90 is down (+y).
    pub edge_angle_deg: f64,
    /// Frequency at which the measured MTF falls to one half, 1/mm.
    ///
    /// It is null if the MTF stays above one half.
    pub mtf50_per_mm: Option<f64>,
    /// Mean squared difference of the MTFs.
    pub loss: f64,
    /// Warnings: repairs, assumptions and doubts about this photograph.
    pub warnings: Vec<String>,
    /// MTF curves.
    pub curves: Curves,
}

/// Camera that was used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraResult {
    /// Width of a pixel in the plane of the mid-air image, mm.
    pub pixel_pitch_mm: f64,
    /// Blur of the lens, mm, in its OTF exp(-(f blur)^exponent).
    ///
    /// It is null in results of earlier versions that had no reference photograph.
    pub lens_blur_mm: Option<f64>,
    /// Exponent of the lens' OTF; null like the blur.
    pub lens_exponent: Option<f64>,
    /// True if there is no reference photograph, so that the lens was assumed.
    #[serde(default)]
    pub lens_assumed: bool,
    /// OTF of the lens along each direction in which it was measured; empty in older results.
    #[serde(default)]
    pub lens: Vec<LensResult>,
    /// Largest angle between the edge of a photograph and that of the nearest reference, degrees.
    ///
    /// A lens that one direction shows is taken for round. It is null without a reference
    /// photograph, and in older results.
    #[serde(default)]
    pub farthest_from_reference_deg: Option<f64>,
}

/// Width of a blur: a fit may find one that is nearly nothing.
const BLUR: Bounds = Bounds::new("at least 0 and at most 1e9", |x| (0.0..=1e9).contains(&x));

/// Exponent of a lens, far beyond those of fits.
const EXPONENT: Bounds = Bounds::new("from 0.05 to 100", |x| (0.05..=100.0).contains(&x));

/// Value of an OTF, which noise and sharpening lift above 1.
const OTF: Bounds = Bounds::new("from -4 to 4", |x| x.abs() <= 4.0);

impl CameraResult {
    /// Checks that the numbers are those of a camera.
    ///
    /// # Errors
    /// Returns [`Error::Number`] of the first number that is out of range.
    pub fn check(&self) -> Result<(), Error> {
        let of_lenses = |of: fn(&LensResult) -> &[f64]| -> Vec<f64> {
            let lenses = self.lens.iter();
            lenses.flat_map(|lens| of(lens).iter().copied()).collect()
        };
        let one = |number: Option<f64>| -> Vec<f64> { number.into_iter().collect() };
        let angles = self.lens.iter().filter_map(|lens| lens.edge_angle_deg);
        let checked = [
            (
                "camera.pixel_pitch_mm",
                vec![self.pixel_pitch_mm],
                Bounds::POSITIVE,
            ),
            ("camera.lens_blur_mm", one(self.lens_blur_mm), BLUR),
            ("camera.lens_exponent", one(self.lens_exponent), EXPONENT),
            ("camera.lens.edge_angle_deg", angles.collect(), Bounds::TURN),
            (
                "camera.lens.frequency_per_px",
                of_lenses(|lens| &lens.frequency_per_px),
                Bounds::NOT_NEGATIVE,
            ),
            ("camera.lens.otf", of_lenses(|lens| &lens.otf), OTF),
        ];
        all_within(checked)
    }
}

/// Lens along one direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LensResult {
    /// Direction of the edge normal, degrees: 0 is right (+x), 90 is down (+y). It is null for a
    /// lens that is taken for round.
    pub edge_angle_deg: Option<f64>,
    /// Number of terms that the lens has beside exp(-(f blur)^exponent).
    pub terms: usize,
    /// Frequencies along the normal, cycles per pixel.
    pub frequency_per_px: Vec<f64>,
    /// OTF of the lens at these frequencies, without the box of the pixel.
    pub otf: Vec<f64>,
}

/// Returns the OTF of each lens of a camera at frequencies up to 1.5 cycles per pixel. They are as
/// close as a halo of 20 pixels needs at low frequencies, and as a pupil needs at high ones.
pub(super) fn lenses(camera: &Camera) -> Vec<LensResult> {
    const COUNT: i32 = 48;
    const LAST_PER_PX: f64 = 1.5;
    let is_round = camera.lenses.len() == 1;
    let one = |lens: &Lens| {
        let all = (0..=COUNT).map(|k| LAST_PER_PX * (f64::from(k) / f64::from(COUNT)).powi(2));
        let frequency_per_px: Vec<f64> = all.collect();
        let at = |f: &f64| lens.otf(f / camera.pitch_mm);
        LensResult {
            edge_angle_deg: (!is_round).then(|| lens.normal_rad.to_degrees()),
            terms: lens.departure.as_ref().map_or(0, |own| own.terms.len()),
            otf: frequency_per_px.iter().map(at).collect(),
            frequency_per_px,
        }
    };
    camera.lenses.iter().map(one).collect()
}

/// Converts all photographs with their curves.
pub(super) fn captures(scene: &Scene, best: &Estimate) -> Vec<CaptureResult> {
    let shots = scene.shots.iter().zip(&best.modelled).zip(&best.losses);
    shots
        .map(|((shot, modelled), &loss)| capture(shot, modelled, loss))
        .collect()
}

/// Converts one photograph with its curves.
fn capture(shot: &Aerial, modelled: &[f64], loss: f64) -> CaptureResult {
    let view = &shot.view;
    CaptureResult {
        image: shot.image.clone(),
        incidence_deg: shot.incidence_deg,
        floating_distance_mm: shot.r_mm,
        transfer: shot.transfer.name.clone(),
        transfer_from: shot.transfer.from.clone(),
        exposure: Some(shot.exposure),
        exposure_from: match shot.rounding {
            Some(_) => FROM_EXIF.into(),
            None => "captures.toml".into(),
        },
        edge_angle_deg: view.line.normal_rad.to_degrees(),
        mtf50_per_mm: view.mtf50_per_mm(),
        loss,
        warnings: shot.warnings.clone(),
        curves: Curves {
            frequency_per_mm: view.estimator.frequencies_per_mm.clone(),
            measured: view.mtf.modulus.clone(),
            standard_error: view.mtf_standard_error.clone(),
            modelled: modelled.to_vec(),
        },
    }
}
