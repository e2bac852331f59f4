//! Image of a point of light at one place of the mid-air image: how its light spreads, and how much
//! arrives.
//!
//! All renderers take the blur from this file, so every model of a sheet (the fitted one is
//! [`crate::images::sheet`]) is rendered in the same ways.

use num_complex::Complex64;

use estimator::Error;
pub use estimator::predict::Viewpoint;
use estimator::samples::DIMENSIONS;

/// Image of one point in the plane across the viewing ray.
///
/// Places are (tangential, sagittal) in mm, and frequencies are in 1/mm.
pub trait Spot: Send + Sync {
    /// Returns the luminance of the mid-air image divided by that of the source: mu eta T R.
    ///
    /// T R is the transmittance of the half mirror times its reflectance. The value is 0 if nothing
    /// returns, and `None` if mu is not known and something returns.
    fn energy(&self) -> Option<f64>;

    /// Evaluates the OTF, the transform E[exp(-2 pi i f.r)] of the distribution of the light.
    ///
    /// It is 1 at frequency 0. If nothing returns, it is 0 everywhere.
    fn otf(&self, frequency: [f64; 2]) -> Complex64;

    /// Returns the greatest distance that the light has from the point, mm.
    ///
    /// If the lobe has no end, it is the distance that contains all but [`TAIL`] of the light along
    /// each axis.
    fn reach_mm(&self) -> f64;

    /// Returns a function from a point of the unit cube to a place (tangential, sagittal) of the
    /// light, mm.
    ///
    /// Returns `None` if only the OTF of the model is known, or if nothing returns.
    fn samples(&self) -> Option<Box<Sampler<'_>>> {
        None
    }

    /// Returns true if the place lies between the directions of the table.
    ///
    /// The blur is less accurate there.
    fn interpolated(&self) -> bool {
        false
    }
}

/// Function from a point of the unit cube of [`estimator::samples::Points`] to a point of the spot, mm.
pub(crate) type Sampler<'a> = dyn Fn([f64; DIMENSIONS]) -> [f64; 2] + Sync + 'a;

/// Share of the light that may lie farther away than `Spot::reach_mm`.
pub const TAIL: f64 = 0.002;

/// Model of a sheet that has a spot at every place.
pub trait Sheet: Sync {
    /// Computes the spot at one place.
    ///
    /// `finest_per_mm` is the highest frequency at which its OTF will be needed. The spot may be
    /// tabulated up to this frequency, and its OTF may be 0 beyond it.
    ///
    /// # Errors
    /// Returns an [`Error`] if the table lacks the direction, if the result lacks a parameter of
    /// the blur, or if the `wave` kernel lacks its data.
    fn spot(&self, place: &Viewpoint, finest_per_mm: f64) -> Result<Box<dyn Spot + '_>, Error>;
}
