//! Edge profiles across a slanted edge: lobe or waves, ray shift, lens and pixel, convolved in
//! space.

use crate::simulate::cell::CubeShift;
use crate::simulate::lobe_edge::lobe_edge;
use crate::simulate::masses::compact;
use crate::simulate::wave_edge::wave_edge;
use edges::names::LobeShape;

/// Number of grid steps per pixel of a simulated photograph.
pub(crate) const STEPS_PER_PIXEL: f64 = 32.0;

/// The diffraction of one photograph; `a_per_mm` > 0.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Spread {
    /// No diffraction.
    None,
    /// A diffraction lobe.
    Lobe {
        /// Shape of the lobe, one of [`LobeShape::ALL`].
        shape: LobeShape,
        /// Diffraction spread a, 1/mm.
        a_per_mm: f64,
    },
    /// Wave optics of the aperture, which includes the ray shifts.
    Wave {
        /// Product lambda R (mm^2) and share of every line of the spectrum; the shares sum to 1.
        lines: Vec<(f64, f64)>,
    },
}

/// All causes of blur of one edge.
#[derive(Debug, Clone)]
pub(crate) struct EdgeBlur {
    /// Direction of the edge normal relative to the tangential axis, radians from +x towards +y.
    pub normal_rad: f64,
    /// Direction of the edge normal relative to +x of the picture (right), radians.
    pub normal_in_picture_rad: f64,
    /// Diffraction of the photograph.
    pub spread: Spread,
    /// Ray shifts by cube, edge lengths; empty without ray shift.
    pub shifts: Vec<CubeShift>,
    /// Offset in the image per shift along u (with the cosine of the incidence) and along v, mm per
    /// edge length.
    pub scale_mm: [f64; 2],
    /// Side of a pixel, mm.
    pub pixel_pitch_mm: f64,
    /// Blur of the lens.
    pub lens: LensBlur,
}

/// Blur of a lens.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LensBlur {
    /// Standard deviation of a Gaussian along the edge normal, mm, >= 0.1 pixel.
    pub sigma_mm: f64,
    /// End of the OTF of a perfect round pupil, which stands in place of the Gaussian, 1/mm.
    pub pupil_cutoff_per_mm: Option<f64>,
    /// Share of the light that goes into a halo.
    pub halo_share: f64,
    /// Length over which the halo's line spread falls to 1/e, mm.
    pub halo_mm: f64,
}

/// An edge profile on a grid: 0 far on the dark side, 1 far on the bright side.
#[derive(Debug, Clone)]
pub(crate) struct EdgeProfile {
    step_mm: f64,
    half: usize,
    values: Vec<f64>,
}

impl EdgeProfile {
    /// Computes the profile for distances up to `reach_mm` from the edge, with `steps` grid steps
    /// per pixel.
    pub(crate) fn new(blur: &EdgeBlur, reach_mm: f64, steps: f64) -> EdgeProfile {
        let step = blur.pixel_pitch_mm / steps;
        let kernel = compact(blur, step);
        let half = (reach_mm / step).ceil() as usize + 2;
        let wide = half + kernel.half;
        let along = [blur.normal_rad.cos(), blur.normal_rad.sin()];
        let lobe: Vec<f64> = match &blur.spread {
            Spread::None => {
                return EdgeProfile {
                    step_mm: step,
                    half,
                    values: kernel.cumulative(half),
                };
            }
            Spread::Lobe { shape, a_per_mm } => lobe_edge(*shape, *a_per_mm, along, step, wide),
            Spread::Wave { lines } => {
                wave_edge(&blur.shifts, blur.scale_mm, along, lines, step, wide)
            }
        };
        let size = kernel.masses.len();
        let values = (0..=2 * half)
            .map(|i| {
                kernel
                    .masses
                    .iter()
                    .zip(lobe[i..i + size].iter().rev())
                    .map(|(mass, edge)| mass * edge)
                    .sum()
            })
            .collect();
        EdgeProfile {
            step_mm: step,
            half,
            values,
        }
    }

    /// Returns the profile at the signed distance `s_mm` from the edge, positive on the bright
    /// side. Between grid points it is cubic.
    pub(crate) fn at(&self, s_mm: f64) -> f64 {
        let place =
            (s_mm / self.step_mm + self.half as f64).clamp(1.0, 2.0 * self.half as f64 - 2.0);
        let base = place.floor();
        let t = place - base;
        let v = &self.values[base as usize - 1..base as usize + 3];
        // Lagrange's interpolation through four neighbours.
        v[0] * (-t * (t - 1.0) * (t - 2.0) / 6.0)
            + v[1] * ((t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0)
            + v[2] * (-(t + 1.0) * t * (t - 2.0) / 2.0)
            + v[3] * ((t + 1.0) * t * (t - 1.0) / 6.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::cell::shifts;

    fn lobe(shape: LobeShape, a_per_mm: f64) -> Spread {
        Spread::Lobe { shape, a_per_mm }
    }

    fn blur(spread: Spread, incidence_deg: f64, normal_deg: f64, sigma_px: f64) -> EdgeBlur {
        let c_mm = 0.24;
        let incidence = incidence_deg.to_radians();
        EdgeBlur {
            normal_rad: normal_deg.to_radians(),
            normal_in_picture_rad: normal_deg.to_radians(),
            spread,
            shifts: shifts(incidence, 30_f64.to_radians(), 1.49, true),
            scale_mm: [c_mm * incidence.cos(), c_mm],
            pixel_pitch_mm: 0.05,
            lens: LensBlur {
                sigma_mm: sigma_px * 0.05,
                pupil_cutoff_per_mm: None,
                halo_share: 0.0,
                halo_mm: 1.0,
            },
        }
    }

    #[test]
    fn halving_the_step_changes_less_than_a_millionth() {
        let mut largest: f64 = 0.0;
        let spreads = [
            Spread::None,
            lobe(LobeShape::Radial, 4.9),
            lobe(LobeShape::Radial, 8.0),
            lobe(LobeShape::Separable, 4.2),
            lobe(LobeShape::Gaussian, 2.4),
        ];
        for spread in spreads {
            for (incidence, normal, sigma) in [
                (0.0, 5.0, 0.55),
                (20.0, -27.0, 0.55),
                (45.0, 97.0, 0.55),
                (30.0, 0.0, 0.55),
                (0.0, 90.0, 0.3),
            ] {
                let blur = blur(spread.clone(), incidence, normal, sigma);
                let coarse = EdgeProfile::new(&blur, 8.0, STEPS_PER_PIXEL);
                let fine = EdgeProfile::new(&blur, 8.0, 2.0 * STEPS_PER_PIXEL);
                for k in -2000..=2000 {
                    let s = f64::from(k) * 0.00391;
                    largest = largest.max((coarse.at(s) - fine.at(s)).abs());
                }
            }
        }
        println!("largest change {largest:.2e}");
        assert!(largest < 1e-6, "{largest:e}");
    }

    #[test]
    fn profiles_run_from_dark_to_bright() {
        for spread in [
            Spread::None,
            lobe(LobeShape::Radial, 4.9),
            lobe(LobeShape::Gaussian, 2.4),
        ] {
            let profile = EdgeProfile::new(&blur(spread, 20.0, 12.0, 0.55), 8.0, STEPS_PER_PIXEL);
            assert!(profile.at(-8.0).abs() < 1e-12 && (profile.at(8.0) - 1.0).abs() < 1e-12);
            // Every part of the blur is symmetric about 0.
            assert!((profile.at(0.0) - 0.5).abs() < 1e-12);
            let mut last = 0.0;
            for k in -800..=800 {
                let value = profile.at(f64::from(k) * 0.01);
                assert!(value >= last - 1e-9, "falls at {k}");
                last = value;
            }
        }
        // The light of the separable lobe has not all arrived at 8 mm: both axes leave a tail 1/(2
        // pi a s) times their cosines.
        let (a, angle) = (4.2, 12_f64);
        let profile = EdgeProfile::new(
            &blur(lobe(LobeShape::Separable, a), 20.0, angle, 0.55),
            8.0,
            STEPS_PER_PIXEL,
        );
        let tail = (angle.to_radians().cos() + angle.to_radians().sin())
            / (2.0 * std::f64::consts::PI * a * 8.0);
        assert!(
            (1.0 - profile.at(8.0) - tail).abs() < 0.05 * tail,
            "{}",
            1.0 - profile.at(8.0)
        );
    }

    #[test]
    fn sampled_rays_meet_the_profile() {
        // Monte Carlo over shift, lens and pixel, without a lobe. The standard error of n samples
        // is at most 0.5/sqrt(n).
        use crate::simulate::noise::PixelNoise;
        let blur = blur(Spread::None, 35.0, 33.0, 0.55);
        let profile = EdgeProfile::new(&blur, 2.0, STEPS_PER_PIXEL);
        let n = 400_000_u64;
        let along = [blur.normal_rad.cos(), blur.normal_rad.sin()];
        let total: f64 = blur.shifts.iter().map(|cube| cube.retroreflected).sum();
        let mut offsets: Vec<f64> = (0..n)
            .map(|index| {
                let mut draw = PixelNoise::new(5, 0, index);
                let cube = if draw.uniform() * total < blur.shifts[0].retroreflected {
                    &blur.shifts[0]
                } else {
                    &blur.shifts[1]
                };
                // Points are drawn from the bounding square of all shifts and rejected outside the
                // polygon.
                let shift = loop {
                    let point = [4.0 * draw.uniform() - 2.0, 4.0 * draw.uniform() - 2.0];
                    let corners = &cube.polygon;
                    let inside = (0..corners.len()).all(|k| {
                        let (p, q) = (corners[k], corners[(k + 1) % corners.len()]);
                        (q[0] - p[0]) * (point[1] - p[1]) - (q[1] - p[1]) * (point[0] - p[0]) >= 0.0
                    });
                    if inside {
                        break point;
                    }
                };
                let pixel = [draw.uniform() - 0.5, draw.uniform() - 0.5]
                    .map(|part| part * blur.pixel_pitch_mm);
                along[0] * (shift[0] * blur.scale_mm[0] + pixel[0])
                    + along[1] * (shift[1] * blur.scale_mm[1] + pixel[1])
                    + blur.lens.sigma_mm * draw.normal()
            })
            .collect();
        offsets.sort_by(f64::total_cmp);
        let mut cases = 0;
        for k in -20..=20 {
            let s = 0.02 * f64::from(k);
            let share = offsets.partition_point(|&offset| offset < s) as f64 / n as f64;
            assert!(
                (share - profile.at(s)).abs() < 5.0 * 0.5 / (n as f64).sqrt(),
                "s {s}: {share} {}",
                profile.at(s)
            );
            cases += 1;
        }
        assert_eq!(cases, 41);
    }
}
