//! The camera: the box of a pixel, and a lens measured from the reference photograph.

use std::f64::consts::PI;

use crate::numerics::sinc::sinc;

/// Transfer function of a camera in the plane of the mid-air image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Size of one pixel in the plane of the mid-air image, mm.
    pub pitch_mm: f64,
    /// Blur beside the pixel's box; `None` without a reference photograph.
    pub lens: Option<Lens>,
}

/// Isotropic blur of a lens with the OTF exp(-(f / f0)^p): Gaussian at p = 2, near a
/// diffraction-limited lens at p = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Blur length 1/f0, mm. The OTF is 1/e at the frequency f0.
    pub blur_mm: f64,
    /// Exponent p.
    pub exponent: f64,
}

impl Camera {
    /// Evaluates the OTF at `frequency` (1/mm) along a normal at `normal_rad` in the photograph,
    /// which is measured from +x (right) towards +y (down). The OTF is real, and 1 at frequency 0.
    pub fn otf(&self, frequency: f64, normal_rad: f64) -> f64 {
        self.pixel(frequency, normal_rad) * self.lens.map_or(1.0, |lens| lens.otf(frequency)[0])
    }

    /// Evaluates the OTF and its derivatives by ln(blur) and by the exponent of the lens. Without a
    /// lens both derivatives are 0.
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
    /// Evaluates the OTF of the lens and its derivatives by ln(blur) and by the exponent.
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
