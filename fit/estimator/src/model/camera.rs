//! The camera: the box of a pixel, and a lens measured from reference photographs.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use crate::model::departure::Departure;
use edges::numerics::sinc;

/// Transfer function of a camera in the plane of the mid-air image.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Size of one pixel in the plane of the mid-air image, mm.
    pub pitch_mm: f64,
    /// Blur beside the pixel's box, along each direction of the edge in which it was measured: one
    /// for a lens that is taken for round, none for a lens that does not blur.
    pub lenses: Vec<Lens>,
}

/// Blur of a lens along one direction, with the OTF exp(-(f / f0)^p) + D(f). The first part is
/// Gaussian at p = 2, and near a diffraction-limited lens at p = 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Lens {
    /// Direction of the edge normal, radians from +x (right) towards +y (down).
    pub normal_rad: f64,
    /// Blur length 1/f0, mm. The first part is 1/e at the frequency f0.
    pub blur_mm: f64,
    /// Exponent p.
    pub exponent: f64,
    /// Departure D from the first part; `None` if that alone describes the lens.
    pub departure: Option<Departure>,
}

/// Camera as it sees edges of one normal.
#[derive(Debug, Clone)]
pub struct Along<'a> {
    camera: &'a Camera,
    /// Cosine and sine of the normal.
    axes: [f64; 2],
    /// Share of each lens.
    shares: Vec<f64>,
}

impl Camera {
    /// Returns the camera as it sees edges with a normal at `normal_rad` in the photograph, which
    /// is measured from +x (right) towards +y (down).
    ///
    /// The squared width of an asymmetric blur is a quadratic form of the normal al: A + B cos(2 al)
    /// plus C sin(2 al). So is the logarithm of the OTF if the lenses differ little. Of the forms
    /// that the lenses allow, that of the least B^2 + C^2 is taken: between two perpendicular ones
    /// the shares are cos^2 and sin^2 of the angle from the first.
    pub fn along(&self, normal_rad: f64) -> Along<'_> {
        let (sin, cos) = normal_rad.sin_cos();
        Along {
            camera: self,
            axes: [cos, sin],
            shares: self.shares(normal_rad),
        }
    }

    /// Evaluates the OTF at `frequency` (1/mm) along a normal. The OTF is real, and 1 at frequency
    /// 0.
    pub fn otf(&self, frequency: f64, normal_rad: f64) -> f64 {
        self.along(normal_rad).otf(frequency)
    }

    fn shares(&self, normal_rad: f64) -> Vec<f64> {
        if self.lenses.len() < 2 {
            return vec![1.0; self.lenses.len()];
        }
        let terms = |rad: f64| Vector3::new(1.0, (2.0 * rad).cos(), (2.0 * rad).sin());
        // The weight of B^2 + C^2 is far below what lenses determine, and far above rounding.
        let mut normal = Matrix3::from_diagonal(&Vector3::new(0.0, 1e-9, 1e-9));
        for lens in &self.lenses {
            let own = terms(lens.normal_rad);
            normal += own * own.transpose();
        }
        let inverse = normal.try_inverse().unwrap_or_else(Matrix3::zeros);
        let here = inverse * terms(normal_rad);
        let all = self.lenses.iter();
        all.map(|lens| terms(lens.normal_rad).dot(&here)).collect()
    }

    /// Returns the number of the numbers of all lenses: ln(blur) and the exponent of each, or the
    /// terms of its departure if it has one.
    pub fn numbers(&self) -> usize {
        self.lenses.iter().map(Lens::numbers).sum()
    }

    /// Returns the lens that has number `index`, and its first number.
    pub(crate) fn lens_of(&mut self, index: usize) -> Option<(&mut Lens, usize)> {
        let mut first = 0;
        for lens in &mut self.lenses {
            let end = first + lens.numbers();
            if index < end {
                return Some((lens, first));
            }
            first = end;
        }
        None
    }
}

impl Along<'_> {
    /// Evaluates the OTF at `frequency` (1/mm).
    pub fn otf(&self, frequency: f64) -> f64 {
        self.pixel(frequency) * self.lens(frequency)
    }

    /// Evaluates the OTF of the lens alone, without the square of the pixel.
    pub(crate) fn lens(&self, frequency: f64) -> f64 {
        let [first, second] = self.parts(frequency);
        first + second
    }

    /// Evaluates the OTF and writes its derivatives by the numbers of the lenses to `slopes`, in
    /// their order: ln(blur) and the exponent of each lens, or its terms.
    ///
    /// # Panics
    /// Panics if `slopes` has fewer entries than [`Camera::numbers`].
    pub fn otf_and_slopes(&self, frequency: f64, slopes: &mut [f64]) -> f64 {
        let pixel = self.pixel(frequency);
        let [first, second] = self.parts(frequency);
        let mut rest = slopes;
        for (lens, share) in self.camera.lenses.iter().zip(&self.shares) {
            let (own, others) = rest.split_at_mut(lens.numbers());
            if let Some(departure) = &lens.departure {
                own.fill(0.0);
                departure.each(frequency, |term, weight| {
                    own[term] += pixel * (share * weight);
                });
            } else {
                let [power, logarithm] = lens.power(frequency);
                own[0] = pixel * (share * (-lens.exponent * power * first));
                own[1] = pixel * (share * (-power * logarithm * first));
            }
            rest = others;
        }
        pixel * (first + second)
    }

    /// Returns both parts of the OTF of the lens.
    fn parts(&self, frequency: f64) -> [f64; 2] {
        let (mut power, mut departure) = (0.0, 0.0);
        for (lens, share) in self.camera.lenses.iter().zip(&self.shares) {
            power += share * lens.power(frequency)[0];
            departure += lens
                .departure
                .as_ref()
                .map_or(0.0, |own| share * own.at(frequency));
        }
        // A quadratic form may become negative beyond the measured directions.
        [(-power.max(0.0)).exp(), departure]
    }

    fn pixel(&self, frequency: f64) -> f64 {
        let [cos, sin] = self.axes;
        let pitch_mm = self.camera.pitch_mm;
        sinc(PI * frequency * pitch_mm * cos) * sinc(PI * frequency * pitch_mm * sin)
    }
}

impl Lens {
    /// Makes a lens with the OTF exp(-(f blur)^p) that is measured along one direction, or taken
    /// for round.
    pub const fn new(blur_mm: f64, exponent: f64) -> Lens {
        Lens {
            normal_rad: 0.0,
            blur_mm,
            exponent,
            departure: None,
        }
    }

    /// Returns the number of its numbers: ln(blur) and the exponent, or the terms of its departure.
    pub fn numbers(&self) -> usize {
        self.departure.as_ref().map_or(2, |own| own.terms.len())
    }

    /// Evaluates the OTF at `frequency` (1/mm).
    pub fn otf(&self, frequency: f64) -> f64 {
        let departure = self.departure.as_ref();
        let departure = departure.map_or(0.0, |own| own.at(frequency));
        (-self.power(frequency)[0]).exp() + departure
    }

    /// Returns (f blur)^p and ln(f blur), which is 0 at frequency 0.
    fn power(&self, frequency: f64) -> [f64; 2] {
        let x = frequency.abs() * self.blur_mm;
        if x == 0.0 {
            return [0.0; 2];
        }
        [x.powf(self.exponent), x.ln()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(ln_blur: f64, exponent: f64) -> Camera {
        Camera {
            pitch_mm: 0.03,
            lenses: vec![Lens::new(ln_blur.exp(), exponent)],
        }
    }

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
                let (ln_blur, normal_rad) = (0.12_f64.ln(), 0.4);
                let mut slopes = [0.0; 2];
                let own = camera(ln_blur, exponent);
                let value = own.along(normal_rad).otf_and_slopes(frequency, &mut slopes);
                let otf = |ln_blur, exponent| camera(ln_blur, exponent).otf(frequency, normal_rad);
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
                for (slope, (change, per)) in slopes.into_iter().zip(differences) {
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
        let unit = Camera {
            pitch_mm: 1e-9,
            lenses: vec![Lens::new(std::f64::consts::E, 1.0)],
        };
        let expected = -std::f64::consts::E * (-std::f64::consts::E).exp();
        let mut slopes = [0.0; 2];
        unit.along(0.0).otf_and_slopes(1.0, &mut slopes);
        for slope in slopes {
            assert!((slope - expected).abs() < 1e-15);
        }
    }

    /// A lens with a departure along x, and one without along y.
    fn mixed() -> Camera {
        let departure = Departure {
            end_per_mm: 20.0,
            terms: vec![-0.2, 0.3, 0.1, -0.4],
        };
        Camera {
            pitch_mm: 0.03,
            lenses: vec![
                Lens {
                    departure: Some(departure),
                    ..Lens::new(0.12, 1.4)
                },
                Lens {
                    normal_rad: 0.5 * PI,
                    ..Lens::new(0.17, 1.8)
                },
            ],
        }
    }

    /// Compares derivatives by the numbers of two lenses with differences of step h = 1e-5. Terms
    /// enter linearly, which leaves rounding / h; the others leave h^2 / 6 x 3.4 x ln^3, 4e-9.
    #[test]
    fn derivatives_by_the_numbers_of_two_lenses_match_differences() {
        let (h, mut cases) = (1e-5, 0);
        let numbers = mixed().numbers();
        assert_eq!(numbers, 6);
        for normal_rad in [0.0, 0.4, 1.2, 0.5 * PI] {
            for frequency in [0.0, 0.1, 1.0, 4.0, 9.0, 30.0] {
                let mut slopes = [7.0; 6];
                let own = mixed();
                let value = own.along(normal_rad).otf_and_slopes(frequency, &mut slopes);
                assert_eq!(value, own.otf(frequency, normal_rad));
                for (index, slope) in slopes.into_iter().enumerate() {
                    let moved = |by: f64| {
                        let mut other = mixed();
                        match index {
                            4 => other.lenses[1].blur_mm *= by.exp(),
                            5 => other.lenses[1].exponent += by,
                            term => {
                                let departure = other.lenses[0].departure.as_mut();
                                departure.expect("it has one").terms[term] += by;
                            }
                        }
                        other.otf(frequency, normal_rad)
                    };
                    let difference = (moved(h) - moved(-h)) / (2.0 * h);
                    assert!((slope - difference).abs() < 4e-9 + 1e-10, "{index}");
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 144);
    }

    /// An elliptic Gaussian, measured along two or three directions, is known along every other:
    /// its squared width is a quadratic form. Along the two directions themselves each is met
    /// whatever their angle. The small weight of B^2 + C^2 leaves 1e-9 over the least eigenvalue.
    #[test]
    fn an_elliptic_lens_is_known_along_every_direction() {
        let width2 = |rad: f64| {
            let (sin, cos) = rad.sin_cos();
            0.04 * cos * cos + 0.09 * sin * sin + 0.02 * sin * cos
        };
        let mut cases = 0;
        for (directions_deg, everywhere) in [
            (vec![-10.0_f64, 80.0], false),
            (vec![5.0, 50.0], false),
            (vec![0.0, 45.0, 90.0], true),
            (vec![10.0, 60.0, 100.0, 170.0], true),
        ] {
            let lens = |deg: &f64| Lens {
                normal_rad: deg.to_radians(),
                ..Lens::new(width2(deg.to_radians()).sqrt(), 2.0)
            };
            let camera = Camera {
                pitch_mm: 1e-9,
                lenses: directions_deg.iter().map(lens).collect(),
            };
            let asked: Vec<f64> = if everywhere {
                (0..36).map(|k| 5.0 * f64::from(k)).collect()
            } else {
                directions_deg
            };
            for deg in asked {
                let found = camera.otf(4.0, deg.to_radians());
                let expected = (-16.0 * width2(deg.to_radians())).exp();
                assert!((found - expected).abs() < 1e-7, "{deg}: {found} {expected}");
                cases += 1;
            }
        }
        // Without a cross term two perpendicular lenses are enough.
        let camera = Camera {
            pitch_mm: 1e-9,
            lenses: [0.0, 0.5 * PI]
                .map(|normal_rad| Lens {
                    normal_rad,
                    ..Lens::new(0.1 + 0.1 * normal_rad, 2.0)
                })
                .to_vec(),
        };
        let wide = 0.1 + 0.05 * PI;
        for deg in 0..36 {
            let (sin, cos) = (5.0 * f64::from(deg)).to_radians().sin_cos();
            let expected = (-16.0 * (0.01 * cos * cos + wide * wide * sin * sin)).exp();
            let found = camera.otf(4.0, (5.0 * f64::from(deg)).to_radians());
            assert!((found - expected).abs() < 1e-7, "{deg}: {found} {expected}");
            cases += 1;
        }
        assert_eq!(cases, 112);
    }
}
