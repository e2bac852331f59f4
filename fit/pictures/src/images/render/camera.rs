//! Camera that photographs a mid-air image: the square of its pixel and its lens blur the image
//! further.
//!
//! Lengths are mm, or pixels of the picture after `Camera::in_pixels`.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};

use edges::numerics::sinc;
use estimator::result::CameraResult;

use crate::images::spot::TAIL;

/// Distance up to which the halo of a lens with a departure is followed, pixels of the camera.
const HALO_PX: f64 = 64.0;

/// Pixel and lens of a camera, in the plane of the mid-air image.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Width of a pixel.
    width: f64,
    /// Blur length in the parametric OTF of the lens, exp(-(f blur)^exponent).
    blur: f64,
    /// Exponent of the parametric OTF.
    exponent: f64,
    /// Departures from the parametric OTF; none if it alone describes the lens.
    departures: Vec<Departure>,
    /// Converts the first, second and third term of a direction to the shares of the departures.
    shares: Matrix3<f64>,
    /// True if no reference photograph showed the lens.
    is_assumed: bool,
}

/// Departure of the OTF from the parametric one, along one direction.
#[derive(Debug, Clone, PartialEq)]
struct Departure {
    /// Direction, radians from +x (right) towards +y (down).
    normal_rad: f64,
    /// Frequencies, cycles per pixel of the camera, ascending from 0.
    frequency: Vec<f64>,
    /// Departures at these frequencies; beyond the last one there is none.
    otf: Vec<f64>,
}

impl Departure {
    /// Interpolates by the polynomial through the four points around a frequency.
    fn at(&self, frequency: f64) -> f64 {
        let count = self.frequency.len();
        let next = self.frequency.partition_point(|&own| own <= frequency);
        if next == count {
            return 0.0;
        }
        let first = next.saturating_sub(2).min(count - 4);
        let near = &self.frequency[first..first + 4];
        let weight = |own: &f64| -> f64 {
            let others = near.iter().filter(|other| *other != own);
            others
                .map(|other| (frequency - other) / (own - other))
                .product()
        };
        let points = near.iter().zip(&self.otf[first..]);
        points.map(|(own, otf)| weight(own) * otf).sum()
    }
}

/// Returns the terms of a quadratic form of a direction.
fn terms(rad: f64) -> Vector3<f64> {
    Vector3::new(1.0, (2.0 * rad).cos(), (2.0 * rad).sin())
}

impl Camera {
    /// Returns the camera of a result, lengths in mm; `None` if the result has no lens, or one
    /// whose table of the OTF or another number ([`CameraResult::check`]) is damaged.
    pub fn of(camera: &CameraResult) -> Option<Camera> {
        camera.check().ok()?;
        let (width, blur) = (camera.pixel_pitch_mm, camera.lens_blur_mm?);
        let mut own = Camera {
            width,
            blur,
            exponent: camera.lens_exponent?,
            departures: Vec::new(),
            shares: Matrix3::zeros(),
            is_assumed: camera.lens_assumed,
        };
        // One lens without terms is the parametric one.
        let only = camera.lens.len() == 1 && camera.lens[0].terms == 0;
        let measured = camera.lens.iter().filter(|_| !only);
        let departures = measured.map(|lens| {
            let frequency = &lens.frequency_per_px;
            let whole = frequency.len() == lens.otf.len() && frequency.len() >= 4;
            let rest = |(f, otf): (&f64, &f64)| otf - own.parametric(f / width);
            (whole && frequency.is_sorted_by(|a, b| a < b)).then(|| Departure {
                normal_rad: lens.edge_angle_deg.unwrap_or(0.0).to_radians(),
                frequency: frequency.clone(),
                otf: frequency.iter().zip(&lens.otf).map(rest).collect(),
            })
        });
        own.departures = departures.collect::<Option<_>>()?;
        // The logarithm of the OTF is a quadratic form of the direction, the roundest one that the
        // departures determine.
        let mut normal = Matrix3::from_diagonal(&Vector3::new(0.0, 1e-9, 1e-9));
        for departure in &own.departures {
            let own = terms(departure.normal_rad);
            normal += own * own.transpose();
        }
        own.shares = normal.try_inverse().unwrap_or_else(Matrix3::zeros);
        Some(own)
    }

    /// Returns whether the lens is assumed, because its result has no reference photograph.
    pub(crate) fn is_assumed(&self) -> bool {
        self.is_assumed
    }

    /// Converts mm to pixels of `pitch_mm`.
    pub(crate) fn in_pixels(&self, pitch_mm: f64) -> Camera {
        Camera {
            width: self.width / pitch_mm,
            blur: self.blur / pitch_mm,
            ..self.clone()
        }
    }

    /// Returns the width of the square over which a pixel of the camera averages.
    pub(crate) fn width(&self) -> f64 {
        self.width
    }

    /// Evaluates the OTF of the square of a pixel along one of its sides.
    pub(crate) fn square(&self, frequency: f64) -> f64 {
        sinc(PI * frequency * self.width)
    }

    fn parametric(&self, frequency: f64) -> f64 {
        (-(frequency.abs() * self.blur).powf(self.exponent)).exp()
    }

    /// Evaluates the OTF of the lens at a frequency (right, down).
    pub(crate) fn lens(&self, x: f64, y: f64) -> f64 {
        let frequency = x.hypot(y);
        let first = self.parametric(frequency);
        let along = |own: &Departure| first + own.at(frequency * self.width);
        match &self.departures[..] {
            [] => first,
            [only] => along(only),
            several => {
                let here = self.shares * terms(y.atan2(x));
                let all = || {
                    let share = |own: &Departure| terms(own.normal_rad).dot(&here);
                    several.iter().map(move |own| (share(own), along(own)))
                };
                if all().all(|(_, otf)| otf > 0.0) {
                    all()
                        .map(|(share, otf)| share * otf.ln())
                        .sum::<f64>()
                        .exp()
                } else {
                    all().map(|(share, otf)| share * otf).sum()
                }
            }
        }
    }

    /// Returns the distance that contains all but [`TAIL`] of the light of a point along each axis.
    ///
    /// The line spread of the lens is a stable distribution of scale s = blur / (2 pi), whose share
    /// beyond x is 2 sin(pi p / 2) Gamma(p) / pi (s / x)^p far from the middle. This is zero for
    /// the Gaussian (p = 2), of which 6e-7 lie beyond 5 s sqrt(2).
    pub(crate) fn reach(&self) -> f64 {
        let p = self.exponent;
        let far = 2.0 / PI * (0.5 * PI * p).sin().abs() * libm::tgamma(p) / TAIL;
        let scale = self.blur / TAU;
        let lens = scale * (5.0 * std::f64::consts::SQRT_2 + far.powf(1.0 / p));
        let halo = if self.departures.is_empty() {
            0.0
        } else {
            HALO_PX * self.width
        };
        0.5 * self.width + lens.max(halo)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the reach of three lenses whose line spreads are known: a Lorentz curve (p = 1),
    /// whose share beyond x is 2/pi atan(s / x), a Gaussian (p = 2) of standard deviation
    /// s sqrt(2), and one by its Fourier integral, 1 - 2/pi int sin(2 pi f x) / f OTF(f) df. The
    /// integral has 200,000 steps up to OTF = exp(-40), each below 1/200 of a turn of the sine: the
    /// midpoint rule errs by (2 pi / 200)^2 / 24 = 4e-5 of the integrand.
    #[test]
    fn all_but_the_tail_lies_within_the_reach() {
        let scale = 0.3 / TAU;
        let camera = |exponent| Camera {
            width: 0.0,
            blur: 0.3,
            exponent,
            departures: Vec::new(),
            shares: Matrix3::zeros(),
            is_assumed: false,
        };
        let lorentz = camera(1.0).reach();
        let beyond = 2.0 / PI * (scale / lorentz).atan();
        assert!(beyond < TAIL && beyond > 0.9 * TAIL, "{beyond}");
        let gauss = camera(2.0).reach();
        assert!(libm::erfc(gauss / (2.0 * scale)) < TAIL && gauss < 8.0 * scale);
        let mut cases = 0;
        for exponent in [1.2, 1.5, 1.8, 3.0] {
            let own = camera(exponent);
            let x = own.reach();
            let end = 40_f64.powf(1.0 / exponent) / 0.3;
            let step = end / 200_000.0;
            assert!(step * x < 1.0 / 200.0, "{exponent}: {}", step * x);
            let terms = (0..200_000).map(|k| (f64::from(k) + 0.5) * step);
            let within: f64 = terms
                .map(|f| (TAU * f * x).sin() / f * own.lens(f, 0.0))
                .sum();
            let beyond = 1.0 - 2.0 / PI * within * step;
            println!("exponent {exponent}: {beyond:.5} beyond {x:.3}");
            assert!(beyond.abs() < TAIL, "{exponent}: {beyond}");
            cases += 1;
        }
        assert_eq!(cases, 4);
    }
}
