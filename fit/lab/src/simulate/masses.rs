//! Densities of compact support (shift, pixel, lens) as masses on a fine grid, convolved there.
//!
//! Each mass is the integral of the exact density times a hat function. A hat increases the variance
//! of a density by step^2 / 6; a [-1, 14, -1] / 12 filter removes the increase. The error is then of
//! fourth order in the step. With [`STEPS_PER_PIXEL`](crate::simulate::profile::STEPS_PER_PIXEL) it
//! is below 1e-7 of the contrast (measured by halving the step), for lenses of sigma >= 0.1 pixel.

use std::f64::consts::PI;

use crate::simulate::cell::{Ramp, marginal};
use crate::simulate::profile::{EdgeBlur, LensBlur, Spread};

/// Distance beyond which the light of a pupil or a halo is left out, pixels, and given to the rest:
/// 6e-4 of the light of a pupil that ends at 1 cycle per pixel.
const SCATTER_PX: f64 = 200.0;

/// Masses on the grid points -half..=half.
#[derive(Debug, Clone)]
pub(super) struct Masses {
    pub half: usize,
    pub masses: Vec<f64>,
}

impl Masses {
    /// Computes the masses of a density from the integral of its cumulative distribution. The
    /// density is 0 beyond `reach`.
    fn of(reach: f64, step: f64, twice_integrated: impl Fn(f64) -> f64) -> Masses {
        let half = (reach / step).ceil() as usize + 2;
        let p2: Vec<f64> = (0..=2 * half + 2)
            .map(|i| twice_integrated((i as f64 - half as f64 - 1.0) * step))
            .collect();
        let hats: Vec<f64> = p2
            .windows(3)
            .map(|w| (w[2] - 2.0 * w[1] + w[0]) / step)
            .collect();
        let hat = |i: usize, by: isize| {
            i.checked_add_signed(by)
                .and_then(|i| hats.get(i))
                .copied()
                .unwrap_or(0.0)
        };
        let masses = (0..hats.len())
            .map(|i| (14.0 * hats[i] - hat(i, -1) - hat(i, 1)) / 12.0)
            .collect();
        Masses { half, masses }
    }

    /// Takes an even density at the grid points, up to a factor. The density must be smooth, or of a
    /// width of many steps.
    fn sampled(half: usize, step: f64, density: impl Fn(f64) -> f64) -> Masses {
        let right: Vec<f64> = (0..=half).map(|i| density(i as f64 * step)).collect();
        let left = right.iter().skip(1).rev();
        let values: Vec<f64> = left.chain(&right).copied().collect();
        let total: f64 = values.iter().sum();
        let masses = values.iter().map(|value| value / total).collect();
        Masses { half, masses }
    }

    /// Returns the mass at point `i` of a grid with `half` points on each side, at least as many as
    /// this one has.
    fn at(&self, i: usize, half: usize) -> f64 {
        let own = (i + self.half).checked_sub(half);
        own.and_then(|own| self.masses.get(own))
            .copied()
            .unwrap_or(0.0)
    }

    fn convolved(&self, other: &Masses) -> Masses {
        let half = self.half + other.half;
        let mut masses = vec![0.0; 2 * half + 1];
        for (i, a) in self.masses.iter().enumerate() {
            for (j, b) in other.masses.iter().enumerate() {
                masses[i + j] += a * b;
            }
        }
        Masses { half, masses }
    }

    /// Returns the cumulative distribution on the points -half..=half of a wider grid, to fourth
    /// order in the step.
    pub(super) fn cumulative(&self, half: usize) -> Vec<f64> {
        let mass = |i: isize| {
            let index = i + self.half as isize;
            usize::try_from(index)
                .ok()
                .and_then(|i| self.masses.get(i))
                .copied()
                .unwrap_or(0.0)
        };
        let half = half as isize;
        let start = -half.max(self.half as isize + 2);
        let mut sum = 0.0;
        let mut values = Vec::with_capacity(2 * half as usize + 1);
        for i in start..=half {
            // Trapezoid rule with Euler and Maclaurin's first correction, step^2 / 12 times the
            // slope of the density.
            if i >= -half {
                values.push(sum + 0.5 * mass(i) - (mass(i + 1) - mass(i - 1)) / 24.0);
            }
            sum += mass(i);
        }
        values
    }
}

/// Returns the masses of the lens along the edge normal.
fn lens_masses(lens: &LensBlur, pitch_mm: f64, step: f64) -> Masses {
    let sigma = lens.sigma_mm;
    let far = (SCATTER_PX * pitch_mm / step).ceil() as usize;
    let core = match lens.pupil_cutoff_per_mm {
        None => {
            let half = (8.5 * sigma / step).ceil() as usize;
            Masses::sampled(half, step, |s| (-0.5 * (s / sigma).powi(2)).exp())
        }
        Some(cutoff) => Masses::sampled(far, step, |s| pupil_line_spread(s, cutoff)),
    };
    if lens.halo_share == 0.0 {
        return core;
    }
    // The isotropic spread K0(r / h) / (2 pi h^2) has this line spread along every normal.
    let halo = Masses::sampled(far, step, |s| (-s.abs() / lens.halo_mm).exp());
    let half = far.max(core.half);
    let masses = (0..=2 * half)
        .map(|i| (1.0 - lens.halo_share) * core.at(i, half) + lens.halo_share * halo.at(i, half));
    Masses {
        half,
        masses: masses.collect(),
    }
}

/// Returns the line spread of a perfect lens with a round pupil, at `s` from its middle, up to a
/// factor.
///
/// Light that spreads along the line adds up over the chords of the pupil, by Parseval's theorem
/// along the other axis. A chord of half width w cos(phi), with w half the cutoff, gives the
/// pattern of a slit, (sin(2 pi s w cos(phi)) / (pi s))^2. The midpoint rule over phi errs by the
/// fourth power of its step once each oscillation has some points.
fn pupil_line_spread(s: f64, cutoff: f64) -> f64 {
    let w = 0.5 * cutoff;
    let phase = 2.0 * PI * s * w;
    let count = 64 + (4.0 * phase.abs()) as usize;
    let chord = |k: usize| {
        let cos = ((k as f64 + 0.5) * PI / count as f64 - 0.5 * PI).cos();
        let x = phase * cos;
        let slit = if x.abs() < 1e-9 { 1.0 } else { x.sin() / x };
        // (2 w cos)^2 of the slit at its middle, and cos of the chord's place.
        cos.powi(3) * slit * slit
    };
    (0..count).map(chord).sum::<f64>() / count as f64
}

/// Returns the masses of ray shift, pixel and lens along the edge normal.
pub(super) fn compact(blur: &EdgeBlur, step: f64) -> Masses {
    let mut kernel = lens_masses(&blur.lens, blur.pixel_pitch_mm, step);
    let (sin, cos) = blur.normal_in_picture_rad.sin_cos();
    for width in [
        blur.pixel_pitch_mm * cos.abs(),
        blur.pixel_pitch_mm * sin.abs(),
    ] {
        // A box narrower than this would increase the variance of the profile by less than 1e-18
        // mm^2.
        if width > 1e-9 {
            let box_p2 = |t: f64| {
                let inside = (t + 0.5 * width).clamp(0.0, width);
                inside * inside / (2.0 * width) + (t - 0.5 * width).max(0.0)
            };
            kernel = kernel.convolved(&Masses::of(0.5 * width, step, box_p2));
        }
    }
    match shift_masses(blur, step) {
        Some(shift) => kernel.convolved(&shift),
        None => kernel,
    }
}

/// Returns the masses of the ray shift along the normal, with each cube weighted by the light that
/// it returns. Returns `None` if there is no ray shift, or if the waves include it.
fn shift_masses(blur: &EdgeBlur, step: f64) -> Option<Masses> {
    let along = [blur.normal_rad.cos(), blur.normal_rad.sin()];
    let total: f64 = blur.shifts.iter().map(|cube| cube.retroreflected).sum();
    if total <= 0.0 || matches!(blur.spread, Spread::Wave { .. }) {
        return None;
    }
    let mut parts: Vec<(f64, Vec<Ramp>)> = Vec::new();
    for cube in blur.shifts.iter().filter(|cube| cube.retroreflected > 0.0) {
        let scaled: Vec<[f64; 2]> = cube
            .polygon
            .iter()
            .map(|[u, v]| [u * blur.scale_mm[0], v * blur.scale_mm[1]])
            .collect();
        parts.push((cube.retroreflected / total, marginal(&scaled, along)));
    }
    let ends = parts.iter().flat_map(|(_, ramps)| {
        ramps
            .iter()
            .flat_map(|ramp| [ramp.low.abs(), ramp.high.abs()])
    });
    let reach = ends.fold(0.0, f64::max);
    Some(Masses::of(reach, step, |t| {
        // A marginal without width is a point at 0, by the symmetry of the polygon.
        let second = |ramps: &[Ramp]| {
            if ramps.is_empty() {
                t.max(0.0)
            } else {
                ramps.iter().map(|ramp| ramp.twice_integrated(t)).sum()
            }
        };
        parts
            .iter()
            .map(|(weight, ramps)| weight * second(ramps))
            .sum()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::profile::STEPS_PER_PIXEL;

    /// The cosine transform of the masses of a lens is its OTF in closed form: that of a round pupil
    /// is 2/pi (acos s - s sqrt(1 - s^2)) with s = f / cutoff, and that of the exponential line
    /// spread 1 / (1 + (2 pi f h)^2).
    ///
    /// A pupil's line spread falls as C / x^2 with C = 4 / (pi cutoff) / (2 pi^2), so 2 C / X of its
    /// light is left out beyond X. What is left is scaled up: the OTF errs by at most twice this. Of
    /// a halo e^-10 is left out.
    #[test]
    fn masses_of_a_lens_have_the_otf_of_its_closed_form() {
        let (pitch_mm, mut cases) = (0.05, 0);
        let step = pitch_mm / STEPS_PER_PIXEL;
        let gaussian = LensBlur {
            sigma_mm: 0.5 * pitch_mm,
            pupil_cutoff_per_mm: None,
            halo_share: 0.0,
            halo_mm: 20.0 * pitch_mm,
        };
        for (cutoff_per_px, halo_share) in [
            (None, 0.0),
            (None, 0.1),
            (Some(0.6), 0.0),
            (Some(1.5), 0.0),
            (Some(1.0), 0.1),
        ] {
            let lens = LensBlur {
                pupil_cutoff_per_mm: cutoff_per_px.map(|cutoff: f64| cutoff / pitch_mm),
                halo_share,
                ..gaussian
            };
            let Masses { half, masses } = lens_masses(&lens, pitch_mm, step);
            for k in 0..40 {
                // Cycles per pixel.
                let f = 0.002 * f64::from(k * k);
                let turn = 2.0 * PI * f / STEPS_PER_PIXEL;
                let places = (0..).map(|i: i32| f64::from(i) - half as f64);
                let parts = masses.iter().zip(places);
                let found: f64 = parts.map(|(mass, x)| mass * (turn * x).cos()).sum();
                let s = cutoff_per_px.map(|cutoff| f64::min(f / cutoff, 1.0));
                let core = s.map_or((-2.0 * (PI * 0.5 * f).powi(2)).exp(), |s| {
                    2.0 / PI * (s.acos() - s * (1.0 - s * s).sqrt())
                });
                let halo = 1.0 / (1.0 + (2.0 * PI * f * 20.0).powi(2));
                let expected = (1.0 - halo_share) * core + halo_share * halo;
                let beyond = cutoff_per_px.map_or(0.0, |cutoff| {
                    4.0 / (PI * cutoff) / (2.0 * PI * PI) / SCATTER_PX
                });
                let allowed = 4.0 * beyond + 2.0 * halo_share * 1e-4 + 1e-6;
                assert!(
                    (found - expected).abs() < allowed,
                    "{cutoff_per_px:?} {halo_share} {f}: {found} {expected}"
                );
                cases += 1;
            }
        }
        assert_eq!(cases, 200);
    }
}
