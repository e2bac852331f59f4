//! The camera: the box of a pixel, and a lens measured from the reference photograph.

use std::f64::consts::PI;

use edges::numerics::sinc;

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

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the derivatives of the OTF with central differences of step h. With u = (f
    /// blur)^p the OTF is exp(-u), and its third derivative by ln u is at most (u + 3 u^2 + u^3)
    /// exp(-u) < 3.4. ln u changes by p per ln(blur) and by ln(f blur) per exponent, so the
    /// differences err by h^2/6 x 3.4 times the cube of that, and by rounding over h.
    #[test]
    fn derivatives_of_the_lens_match_differences() {
        let h = 1e-4;
        let mut cases = 0;
        for exponent in [0.7, 1.0, 1.4, 2.0, 3.0] {
            for frequency in [0.0, 0.3, 2.0, 5.0, 9.0, 14.0] {
                let at = |ln_blur: f64, exponent: f64| Camera {
                    pitch_mm: 0.03,
                    lens: Some(Lens {
                        blur_mm: ln_blur.exp(),
                        exponent,
                    }),
                };
                let (ln_blur, normal_rad) = (0.12_f64.ln(), 0.4);
                let [value, by_blur, by_exponent] =
                    at(ln_blur, exponent).otf_and_slopes(frequency, normal_rad);
                let otf = |ln_blur, exponent| at(ln_blur, exponent).otf(frequency, normal_rad);
                assert_eq!(value, otf(ln_blur, exponent));
                let x = f64::max(frequency * ln_blur.exp(), 1e-9);
                let differences = [
                    (
                        otf(ln_blur + h, exponent) - otf(ln_blur - h, exponent),
                        exponent,
                    ),
                    (
                        otf(ln_blur, exponent + h) - otf(ln_blur, exponent - h),
                        x.ln(),
                    ),
                ];
                for (slope, (change, per)) in [by_blur, by_exponent].into_iter().zip(differences) {
                    let difference = change / (2.0 * h);
                    let allowed = h * h / 6.0 * 3.4 * per.abs().powi(3) + f64::EPSILON / h;
                    assert!(
                        (slope - difference).abs() < allowed,
                        "p {exponent}, f {frequency}: {slope} {difference}"
                    );
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 60);
        // By hand: at f blur = e and p = 1 the OTF is exp(-e), and both derivatives are -e exp(-e).
        let lens = Lens {
            blur_mm: std::f64::consts::E,
            exponent: 1.0,
        };
        let expected = -std::f64::consts::E * (-std::f64::consts::E).exp();
        let [_, by_blur, by_exponent] = lens.otf(1.0);
        assert!((by_blur - expected).abs() < 1e-15 && (by_exponent - expected).abs() < 1e-15);
    }
}
