//! The camera: the pixel's box, and a lens measured from the reference photograph.

use std::f64::consts::PI;

use crate::sfr::sinc;

/// Transfer function of a camera in the plane of the aerial image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// One pixel in the aerial-image plane, mm.
    pub pitch_mm: f64,
    /// What blurs beside the pixel box; `None` where no reference photograph tells.
    pub lens: Option<Lens>,
}

/// Isotropic lens blur, OTF exp(-(f / f0)^p): Gaussian at p = 2, near a diffraction-limited lens at p = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Blur length 1/f0, mm: the OTF is 1/e at the frequency 1/blur.
    pub blur_mm: f64,
    /// Exponent p.
    pub exponent: f64,
}

impl Camera {
    /// OTF at `frequency` (1/mm) along a normal at `normal_rad` in the photograph (from +x, right, towards +y, down):
    /// real, 1 at zero frequency.
    pub fn otf(&self, frequency: f64, normal_rad: f64) -> f64 {
        let (sin, cos) = normal_rad.sin_cos();
        let pixel =
            sinc(PI * frequency * self.pitch_mm * cos) * sinc(PI * frequency * self.pitch_mm * sin);
        pixel
            * self.lens.map_or(1.0, |lens| {
                (-(frequency.abs() * lens.blur_mm).powf(lens.exponent)).exp()
            })
    }
}
