//! The step from an OTF along an edge normal to the edge profile on a photograph's own bins.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use num_complex::Complex64;
use transforms::{ComplexToReal, Real};

use edges::numerics::sinc;
use edges::photographs::{BIN_PX, Profile};

/// Frequencies at which an OTF is needed, and the transform from there to the bins.
#[derive(Clone)]
pub(crate) struct Grid {
    /// Length of the transform: the bins of one period.
    size: usize,
    bin_mm: f64,
    /// Factors by frequency that, times -i, turn the transform of a blur into that of a step:
    /// sinc(pi f bin) / (2 pi f period).
    step: Arc<[f64]>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl Grid {
    /// Makes a grid whose period is at least three profiles long, so that the periodic images of a
    /// blur do not reach the profile, even for a blur as long as the profile.
    pub(crate) fn new(bins: usize, pitch_mm: f64) -> Grid {
        let size = (3 * bins).next_power_of_two().max(2048);
        // f bin = q / size, and f period = q.
        let step = (0..size / 2 + 1).map(|q| match q {
            0 => 0.0,
            q => sinc(PI * q as f64 / size as f64) / (TAU * q as f64),
        });
        Grid {
            size,
            bin_mm: BIN_PX * pitch_mm,
            step: step.collect(),
            inverse: f64::inverse(size),
        }
    }

    /// Returns the frequencies along the normal, 1/mm, from 0 to 2 per pixel.
    pub(crate) fn frequencies_per_mm(&self) -> impl ExactSizeIterator<Item = f64> + use<> {
        let period = self.size as f64 * self.bin_mm;
        (0..self.size / 2 + 1).map(move |q| q as f64 / period)
    }

    /// Transforms an OTF to the edge profile averaged over evenly filled bins.
    ///
    /// `otf` holds values at the grid's frequencies. Its first value scales the step (1 for a
    /// profile, 0 for a derivative). `kink` is -d OTF/d|f| at 0 (mm). A kinked OTF gives the line
    /// spread tails of 1/s^2, whose periodic images are removed to second order. The profile is the
    /// inverse transform. It is exact, except for the images of a lobe that is wider than a
    /// profile.
    pub(crate) fn even(&self, otf: &[Complex64], kink: f64) -> Even {
        let period = self.size as f64 * self.bin_mm;
        let step = otf[0].re;
        let mut half: Vec<Complex64> = otf
            .iter()
            .zip(self.step.iter())
            .map(|(o, w)| Complex64::new(o.im * w, -o.re * w))
            .collect();
        // The mean of the profile depends on its centre of mass, which the OTF's slope at 0 gives.
        half[0] = Complex64::from(otf[1].im / TAU);
        // The last coefficient is real. Its imaginary part belongs to 2 cycles per pixel, beyond
        // the reach of any camera.
        half[self.size / 2].im = 0.0;
        let mut periodic = vec![0.0; self.size];
        self.inverse
            .process(&mut half, &mut periodic)
            .expect("lengths and reality are set above");
        // C/s^2 is the tail of the line spread. The sum of its images is C pi^2/(3 P^2) + C pi^4
        // s^2/(15 P^4) + ...
        let tail = kink / (2.0 * PI * PI);
        let linear = step / period - tail * PI.powi(2) / (3.0 * period.powi(2));
        let cubic = tail * PI.powi(4) / (45.0 * period.powi(4));
        let middle = self.size / 2;
        periodic.rotate_right(middle);
        for (index, value) in periodic.iter_mut().enumerate() {
            let s = (index as f64 - middle as f64) * self.bin_mm;
            *value += 0.5 * step + (linear - cubic * s * s) * s;
        }
        Even { values: periodic }
    }

    /// Averages the edge profile over the pixels of each bin. [`Grid::even`] explains `otf` and
    /// `kink`.
    ///
    /// The excess moments of a bin are a few hundredths of a pixel. They enter through the
    /// profile's own differences, whose slope is accurate to (pi/4)^4/30 = 1.3 % at half the
    /// sampling frequency and to 1e-5 at a tenth of it.
    pub(crate) fn profile(&self, otf: &[Complex64], kink: f64, profile: &Profile) -> Vec<f64> {
        let even = self.even(otf, kink);
        let reach = profile.reach as i64;
        let mut bins: Vec<f64> = (-reach..=reach)
            .zip(&profile.excess)
            .map(|(offset, &[m1, m2, m3])| {
                let (m1, m2, m3) = (m1 / BIN_PX, m2 / BIN_PX.powi(2), m3 / BIN_PX.powi(3));
                let [here, slope, curvature, third] = even.around(offset);
                here + slope * m1 + 0.5 * curvature * m2 + third * m3 / 6.0
            })
            .collect();
        profile.bridge(&mut bins);
        bins
    }
}

/// Edge profile averaged over evenly filled bins: one period, with the edge in the middle of bin 0.
#[derive(Clone)]
pub(crate) struct Even {
    values: Vec<f64>,
}

impl Even {
    /// Returns this profile less another one.
    pub(crate) fn less(&self, other: &Even) -> Even {
        let pairs = self.values.iter().zip(&other.values);
        Even {
            values: pairs.map(|(own, other)| own - other).collect(),
        }
    }

    /// Returns the first moment of the line spread up to each place, with its sign changed: the
    /// integral of -s E'(s), pixels. It starts at `reach` bins before the edge, and stays constant
    /// beyond `reach` bins behind it.
    ///
    /// The integral is taken by parts and by the trapezoidal rule, which adds a twelfth of the line
    /// spread per bin. For a blur with a standard deviation of b bins this is 1 / (12 b^2) of it.
    pub(crate) fn moment(&self, reach: usize) -> Even {
        let size = self.values.len();
        let middle = size / 2;
        let (first, end) = (middle.saturating_sub(reach), size.min(middle + reach + 1));
        let mut moments = vec![0.0; first + 1];
        let mut sum = 0.0;
        for (pair, place) in self.values[first..end].windows(2).zip(first..) {
            let place = place as f64 - middle as f64;
            sum += 0.5 * (pair[0] + pair[1]) - ((place + 1.0) * pair[1] - place * pair[0]);
            moments.push(sum * BIN_PX);
        }
        moments.resize(size, sum * BIN_PX);
        Even { values: moments }
    }

    /// Returns the value and the first three derivatives per bin at `offset` (within half a
    /// period), by differences of fourth order (second order for the third derivative).
    pub(crate) fn around(&self, offset: i64) -> [f64; 4] {
        let middle = (self.values.len() / 2) as i64;
        let at = (middle + offset).clamp(2, 2 * middle - 3) as usize;
        let [b2, b1, here, a1, a2] = [
            self.values[at - 2],
            self.values[at - 1],
            self.values[at],
            self.values[at + 1],
            self.values[at + 2],
        ];
        [
            here,
            (8.0 * (a1 - b1) - (a2 - b2)) / 12.0,
            (16.0 * (a1 + b1) - (a2 + b2) - 30.0 * here) / 12.0,
            0.5 * (a2 - b2) - (a1 - b1),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the moment of a normal blur with its closed form: variance times density. The
    /// bins add a twelfth of a squared bin to the variance, the rule a twelfth of the density. What
    /// is left is of the order of 1 / b^4, 2e-4 for the narrowest.
    #[test]
    fn the_moment_of_a_normal_blur_is_its_variance_times_its_density() {
        let (bins, pitch_mm) = (401, 0.1);
        let grid = Grid::new(bins, pitch_mm);
        let mut cases = 0;
        for deviation_px in [2.0_f64, 5.0] {
            let deviation_mm = deviation_px * pitch_mm;
            let otf: Vec<Complex64> = grid
                .frequencies_per_mm()
                .map(|f| (-2.0 * (PI * deviation_mm * f).powi(2)).exp().into())
                .collect();
            let moment = grid.even(&otf, 0.0).moment(bins / 2);
            let b2 = (deviation_px / BIN_PX).powi(2) + 1.0 / 12.0;
            let height = (b2 + 1.0 / 12.0) / (2.0 * PI * b2).sqrt() * BIN_PX;
            for offset in -150_i32..=150 {
                let density = (-0.5 * f64::from(offset).powi(2) / b2).exp();
                let found = moment.around(offset.into())[0];
                assert!((found - height * density).abs() < 2e-4 * height, "{offset}");
                cases += 1;
            }
        }
        assert_eq!(cases, 602);
    }

    /// A normal blur may be a third as wide as the profile: the period is three profiles long, and
    /// at the end of the profile the next image is five deviations away. It is a share of 3e-7
    /// there, with which the Fourier sum of a wide blur agrees to rounding.
    #[test]
    fn images_of_a_wide_blur_stay_away_from_a_long_profile() {
        let (bins, pitch_mm) = (1200_i32, 0.1);
        let grid = Grid::new(bins as usize, pitch_mm);
        let deviation = f64::from(bins) / 3.0;
        let deviation_mm = deviation * BIN_PX * pitch_mm;
        let otf: Vec<Complex64> = grid
            .frequencies_per_mm()
            .map(|f| (-2.0 * (PI * deviation_mm * f).powi(2)).exp().into())
            .collect();
        let edge = grid.even(&otf, 0.0);
        let mut cases = 0;
        for offset in (-bins / 2..=bins / 2).step_by(20) {
            let z = f64::from(offset) / deviation;
            let expected = 0.5 * libm::erfc(-z / std::f64::consts::SQRT_2);
            let found = edge.around(offset.into())[0];
            // The bins add a twelfth of a squared bin to a variance of 160,000, 3e-7.
            assert!(
                (found - expected).abs() < 1e-6,
                "{offset}: {found} {expected}"
            );
            cases += 1;
        }
        assert_eq!(cases, 61);
    }

    /// Compares the profile behind a kinked OTF with its closed form: exp(-2 pi g |f|) belongs to
    /// the line spread g / (pi (s^2 + g^2)), whose tails fall as 1/s^2. Its edge 1/2 + atan(s/g)/pi
    /// is averaged over each bin.
    ///
    /// The images of a tail C/s^2 with C = g/pi sum up to C (2 zeta(2) s / P^2 + 2 zeta(4) s^3 /
    /// P^4 + 2 zeta(6) s^5 / P^6 + ...) in the edge, with the period P. The first two terms are
    /// removed. The rest is at most 2.04 C s^5 / P^6 / (1 - (s/P)^2). The next term of the tail,
    /// -C g^2 / s^4, leaves at most 2.6 C g^2 s / P^4 up to P/4 (2 zeta(4) s + 20/3 zeta(6) s^3 /
    /// P^2 + ...). The transform of 2048 numbers rounds by 1e-14.
    #[test]
    fn the_edge_of_a_line_spread_with_tails_equals_its_closed_form() {
        let pitch_mm = 0.05;
        let grid = Grid::new(10, pitch_mm);
        let bin = BIN_PX * pitch_mm;
        let period = grid.size as f64 * bin;
        // At the last frequency, 1/(2 bin), the OTF is exp(-12 pi) = 4e-17.
        let g = 12.0 * bin;
        let otf: Vec<Complex64> = grid
            .frequencies_per_mm()
            .map(|f| Complex64::from((-TAU * g * f).exp()))
            .collect();
        let even = grid.even(&otf, TAU * g);
        let integral =
            |s: f64| 0.5 * s + (s * (s / g).atan() - 0.5 * g * (s * s / (g * g)).ln_1p()) / PI;
        let quarter = grid.size as i64 / 4;
        let mut cases = 0;
        for offset in (-quarter..=quarter).step_by(16) {
            let s = offset as f64 * bin;
            let expected = (integral(s + 0.5 * bin) - integral(s - 0.5 * bin)) / bin;
            let found = even.around(offset)[0];
            let part = s.abs() / period;
            let tail = g / PI / period;
            let allowed = tail * (2.04 * part.powi(5) / (1.0 - part * part))
                + tail * 2.6 * (g / period).powi(2) * part
                + 1e-13;
            assert!(
                (found - expected).abs() < allowed,
                "s {s}: {found} {expected}, {:.1e} of {allowed:.1e}",
                found - expected
            );
            cases += 1;
        }
        assert_eq!(cases, 65);
    }
}
