//! What a sheet makes of a point of light at one place of the mid-air image: where its light goes,
//! and how much arrives.
//!
//! Whatever renders takes its blur from here, so that every model of a sheet (the fitted one:
//! [`crate::images::sheet`]) is rendered in the same ways.

use num_complex::Complex64;

use crate::predict::Error;
use crate::samples::DIMENSIONS;

/// Where a point of the mid-air image is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Viewpoint {
    /// Incidence on the sheet, degrees from its normal.
    pub incidence_deg: f64,
    /// Azimuth about the normal, degrees; `None` for a table that is a mean over azimuths.
    pub azimuth_deg: Option<f64>,
    /// Optical path from the sheet to the image, mm.
    pub r_mm: f64,
}

/// The image of one point, in the plane across the viewing ray: (tangential, sagittal) in mm,
/// frequencies in 1/mm.
pub(crate) trait Spot: Send + Sync {
    /// Luminance over that of the source, half mirror included: mu eta T R. 0 where nothing
    /// returns; `None` where mu is not known but something returns.
    fn energy(&self) -> Option<f64>;

    /// Optical transfer function, the transform E[exp(-2 pi i f.r)] of where the light goes: 1 at
    /// zero frequency, 0 everywhere where nothing returns.
    fn otf(&self, frequency: [f64; 2]) -> Complex64;

    /// How far from the point its light goes, mm; where a lobe has no end, what contains all but
    /// [`TAIL`] of the light along each axis.
    fn reach_mm(&self) -> f64;

    /// Where the light goes (tangential, sagittal), mm, as a function of four coordinates of the
    /// unit cube; `None` for a model that is known by its transform alone, and where nothing
    /// returns.
    fn samples(&self) -> Option<Box<Sampler<'_>>> {
        None
    }

    /// Whether the place lies between the directions of the table, which costs accuracy.
    fn interpolated(&self) -> bool {
        false
    }
}

/// A point of the spot, mm, for a point of the unit cube of [`crate::samples::Points`].
pub(crate) type Sampler<'a> = dyn Fn([f64; DIMENSIONS]) -> [f64; 2] + Sync + 'a;

/// Share of the light that may fall outside of [`Spot::reach_mm`].
pub(crate) const TAIL: f64 = 0.002;

/// A model of a sheet that makes spots.
pub(crate) trait Sheet: Sync {
    /// The spot at one place. `finest_per_mm` is the highest frequency at which its OTF will be
    /// asked, which lets it tabulate; beyond it the OTF may be 0.
    ///
    /// # Errors
    /// [`Error`].
    fn spot(&self, place: &Viewpoint, finest_per_mm: f64) -> Result<Box<dyn Spot + '_>, Error>;
}
