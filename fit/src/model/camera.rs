//! The camera: the pixel's box, and a lens measured from the reference photograph.

use std::f64::consts::PI;

use crate::numerics::sinc::sinc;

/// Transfer function of a camera in the plane of the aerial image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// One pixel in the aerial-image plane, mm.
    pub pitch_mm: f64,
    /// What blurs beside the pixel box; `None` where no reference photograph tells.
    pub lens: Option<Lens>,
}

/// Isotropic lens blur, OTF exp(-(f / f0)^p): Gaussian at p = 2, near a diffraction-limited lens at
/// p = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Blur length 1/f0, mm: the OTF is 1/e at the frequency 1/blur.
    pub blur_mm: f64,
    /// Exponent p.
    pub exponent: f64,
}

impl Camera {
    /// OTF at `frequency` (1/mm) along a normal at `normal_rad` in the photograph (from +x, right,
    /// towards +y, down): real, 1 at zero frequency.
    pub fn otf(&self, frequency: f64, normal_rad: f64) -> f64 {
        self.pixel(frequency, normal_rad) * self.lens.map_or(1.0, |lens| lens.otf(frequency)[0])
    }

    /// The same with its derivatives by ln(blur) and by the exponent of the lens; these are 0
    /// without a lens.
    pub fn otf_and_slopes(&self, frequency: f64, normal_rad: f64) -> [f64; 3] {
        let pixel = self.pixel(frequency, normal_rad);
        self.lens
            .map_or([1.0, 0.0, 0.0], |lens| lens.otf(frequency))
            .map(|part| pixel * part)
    }

    fn pixel(&self, frequency: f64, normal_rad: f64) -> f64 {
        let (sin, cos) = normal_rad.sin_cos();
        sinc(PI * frequency * self.pitch_mm * cos) * sinc(PI * frequency * self.pitch_mm * sin)
    }
}

impl Lens {
    /// OTF and its derivatives by ln(blur) and by the exponent.
    fn otf(&self, frequency: f64) -> [f64; 3] {
        let x = frequency.abs() * self.blur_mm;
        if x == 0.0 {
            return [1.0, 0.0, 0.0];
        }
        let power = x.powf(self.exponent);
        let value = (-power).exp();
        [
            value,
            -self.exponent * power * value,
            -power * x.ln() * value,
        ]
    }
}
