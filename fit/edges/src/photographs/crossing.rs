//! The MTF of one photograph: the curve with its covariance, and the frequencies at which it falls
//! to a level, such as MTF50 and MTF10.
//!
//! The noise of neighbouring frequencies is nearly independent once they lie farther apart than the
//! reciprocal of the profile's length. A real MTF changes slowly over such steps. So its logarithm
//! is fitted by a polynomial about the crossing, weighted by the exact covariance of the curve. The
//! widest range counts in which the fit explains the curve within its noise. The crossing of the
//! fit scatters less than that of the curve itself.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::photographs::profile::{BIN_PX, Profile, smoothed};
use crate::photographs::sfr::{Estimator, crossing};

/// Order of the polynomial.
const ORDER: usize = 3;

/// Least number of frequencies on either side of the crossing.
const LEAST: usize = 3;

/// Largest number of frequencies on either side. It limits the time for photographs of many
/// megapixels.
const MOST: usize = 80;

/// Farthest frequency of the fit from the crossing, as a share of the crossing.
const REACH: f64 = 0.8;

/// Standard deviations of chi-square above its expectation from which a range is too wide.
const STRICT: f64 = 3.0;

/// Ratio of a level to the noise of one component below which the level is lost in noise.
const LOST: f64 = 2.0;

/// Largest number of times that the range is put about a better crossing.
const ROUNDS: usize = 5;

/// Standard errors of the highest term from which it counts in the slope.
const CLEAR: f64 = 2.0;

/// Steps of Gauss and Newton; the third changes nothing that can be seen.
const STEPS: usize = 8;

/// A quantity and its standard error by pixel noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Best value.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}

/// A measured MTF and how its noise is correlated.
pub struct Curve {
    /// Frequencies along the edge normal, evenly spaced from 0 to the sampling frequency.
    pub frequency: Vec<f64>,
    /// Modulus at these frequencies.
    pub modulus: Vec<f64>,
    /// Standard errors of the modulus.
    pub standard_error: Vec<f64>,
    /// Variance that noise adds to the square of the modulus.
    power_noise: Vec<f64>,
    /// Change of the modulus (rows) by one standard deviation of each bin (columns).
    by_noise: DMatrix<f64>,
    /// The same with the correction of uneven light, which has more columns; `None` in even light.
    ///
    /// The light changes the scale of the whole curve. Weights that know such a common error would
    /// bias a fit towards low values, because the covariance follows the measured modulus (Peelle's
    /// puzzle). So weights follow `by_noise`, and standard errors all noise.
    with_light: Option<DMatrix<f64>>,
    /// Number of frequencies over which noise is correlated.
    correlated: usize,
}

/// A polynomial fitted to the logarithm of the curve. Its variable is the distance from the middle
/// frequency over half the range.
struct Fit {
    terms: [f64; ORDER + 1],
    covariance: DMatrix<f64>,
    /// Covariance with the correction of uneven light, if there is one.
    with_light: Option<DMatrix<f64>>,
    /// Sum of the squares of the weighted residuals, above its expectation, in its own standard
    /// deviations.
    excess: f64,
}

impl Curve {
    /// Measures the MTF of a profile at `count` frequencies and at 0. Frequencies are in cycles per
    /// `pitch`; with a pitch of 1 they are in cycles per pixel.
    pub fn new(profile: &Profile, pitch: f64, count: usize) -> Curve {
        // The curve ends at the sampling frequency, a quarter of the period of the spectrum.
        let estimator = Estimator::new(profile, pitch, 4 * count, count);
        let mtf = estimator.measure(profile);
        let response = estimator.response(profile);
        let with_light = profile
            .light
            .is_some()
            .then(|| profile.response(response.clone()));
        let mut by_noise = response;
        for (mut column, variance) in by_noise.column_iter_mut().zip(&profile.variance) {
            column *= variance.sqrt();
        }
        let all = with_light.as_ref().unwrap_or(&by_noise);
        let length_px = profile.len() as f64 * BIN_PX;
        Curve {
            frequency: estimator.frequencies_per_mm,
            modulus: mtf.modulus,
            standard_error: all.row_iter().map(|row| row.norm()).collect(),
            power_noise: mtf.power_noise,
            by_noise,
            with_light,
            correlated: ((count as f64 / length_px).round() as usize).max(1),
        }
    }

    /// Returns the modulus at a frequency, by the cubic through the four nearest points. Returns
    /// `None` beyond the last.
    ///
    /// The points are 1/512 cycles per pixel apart. A blur with a standard deviation of 6 pixels
    /// then has an error of 3e-6.
    pub fn at(&self, frequency: f64) -> Option<Measured> {
        let place = frequency / self.frequency[1];
        let last = self.modulus.len() - 1;
        if !(0.0..=last as f64).contains(&place) {
            return None;
        }
        let first = (place as usize).saturating_sub(1).min(last - 3);
        let weight = |j: usize| -> f64 {
            let others = (0..4).filter(|k| *k != j);
            others
                .map(|k| (place - (first + k) as f64) / (j as f64 - k as f64))
                .product()
        };
        let weights: Vec<(usize, f64)> = (0..4).map(|j| (first + j, weight(j))).collect();
        Some(Measured {
            value: weights.iter().map(|(k, w)| w * self.modulus[*k]).sum(),
            standard_error: self.error_of(&weights),
        })
    }

    /// Returns the frequency at which the MTF first falls to a level, or `None` if it never does or
    /// if the level is lost in noise.
    pub fn falls_to(&self, level: f64) -> Option<Measured> {
        let rough = crossing(
            &self.frequency,
            &smoothed(&self.modulus, self.correlated),
            level,
        )?;
        let cell = self.frequency[1];
        let mut middle = (rough / cell).round() as usize;
        if level < LOST * self.noise(middle) {
            return None;
        }
        for _ in 0..ROUNDS {
            let Some(found) = self.fitted(middle, level) else {
                break;
            };
            let place = (found.value / cell).round() as usize;
            // Noise can make the first crossing too early. The range is then put about the better
            // one.
            if place.abs_diff(middle) <= self.correlated.max(middle / 8) {
                return Some(found);
            }
            middle = place;
        }
        self.read_off(level)
    }

    /// Returns the crossing of the curve that is fitted about a frequency, over the widest range
    /// that the noise allows. Returns `None` if no range will do.
    fn fitted(&self, middle: usize, level: f64) -> Option<Measured> {
        let room = (REACH * middle as f64).min((self.modulus.len() - 1 - middle) as f64);
        let most = (room as usize / self.correlated).min(MOST);
        let first = middle - most * self.correlated;
        let rows: Vec<usize> = (0..=2 * most)
            .map(|i| first + i * self.correlated)
            .collect();
        let changes = self.by_noise.select_rows(&rows);
        let noise = &changes * changes.transpose();
        let mut reach = most;
        while reach >= LEAST {
            let (from, size) = (most - reach, 2 * reach + 1);
            let noise = noise.view((from, from), (size, size)).into_owned();
            let fit = self.fit(&rows[from..from + size], noise, level);
            if let Some(fit) = fit.filter(|fit| fit.excess < STRICT)
                && let Some(found) = fit.falls_to(level)
            {
                let half = (reach * self.correlated) as f64 * self.frequency[1];
                return Some(Measured {
                    value: self.frequency[middle] + half * found.value,
                    standard_error: half * found.standard_error,
                });
            }
            reach -= (reach / 8).max(1);
        }
        None
    }

    /// Returns the standard deviation of the noise of one component of the transform, over the
    /// light.
    fn noise(&self, index: usize) -> f64 {
        (0.5 * self.power_noise[index]).sqrt()
    }

    /// Returns the first crossing of the curve itself.
    fn read_off(&self, level: f64) -> Option<Measured> {
        let value = crossing(&self.frequency, &self.modulus, level)?;
        let after = self.frequency.iter().position(|&f| f >= value)?.max(1);
        let part = (value - self.frequency[after - 1]) / self.frequency[1];
        let error = self.error_of(&[(after - 1, 1.0 - part), (after, part)]);
        // The slope over the range in which noise is correlated; one step has too much noise.
        let half = self.correlated.div_ceil(2);
        let (low, high) = (
            after.saturating_sub(half + 1),
            (after + half).min(self.modulus.len() - 1),
        );
        let fall = self.modulus[low] - self.modulus[high];
        let slope = fall / (self.frequency[high] - self.frequency[low]);
        Some(Measured {
            value,
            standard_error: error / slope.abs(),
        })
    }

    /// Returns the standard error of a weighted sum of moduli.
    fn error_of(&self, weights: &[(usize, f64)]) -> f64 {
        let columns = self
            .with_light
            .as_ref()
            .unwrap_or(&self.by_noise)
            .column_iter();
        let changes = columns.map(|column| weights.iter().map(|(k, w)| w * column[*k]).sum());
        changes
            .map(|change: f64| change * change)
            .sum::<f64>()
            .sqrt()
    }

    /// Fits the frequencies of an odd number of indices, evenly spaced, whose noise has a known
    /// covariance. Returns `None` if that is singular.
    fn fit(&self, indices: &[usize], noise: DMatrix<f64>, level: f64) -> Option<Fit> {
        let points = indices.len();
        let half = 0.5 * (points - 1) as f64;
        let powers = DMatrix::from_fn(points, ORDER + 1, |i, j| {
            ((i as f64 - half) / half).powi(j as i32)
        });
        let noise = noise.cholesky()?;
        let mut terms = DVector::zeros(ORDER + 1);
        terms[0] = level.ln();
        let ends = [indices[0], indices[points - 1]].map(|k| self.modulus[k].max(0.1 * level).ln());
        terms[1] = 0.5 * (ends[1] - ends[0]);
        let mut excess = f64::INFINITY;
        let mut normal: Option<(Cholesky<f64, Dyn>, DMatrix<f64>)> = None;
        for _ in 0..STEPS {
            // No MTF of light lies far above 1; a step that leads there is cut off.
            let model = (&powers * &terms).map(|log| log.min(1.0).exp());
            let seen: Vec<[f64; 2]> = (0..points)
                .map(|i| raised(model[i], self.noise(indices[i])))
                .collect();
            let by_term = DMatrix::from_fn(points, ORDER + 1, |i, j| {
                seen[i][1] * model[i] * powers[(i, j)]
            });
            let off = DVector::from_fn(points, |i, _| self.modulus[indices[i]] - seen[i][0]);
            let weighted = noise.solve(&by_term);
            let factor = (by_term.transpose() * &weighted).cholesky()?;
            let step = factor.solve(&(weighted.transpose() * &off));
            let rest = &off - &by_term * &step;
            let freedom = (points - ORDER - 1) as f64;
            excess = (rest.dot(&noise.solve(&rest)) - freedom) / (2.0 * freedom).sqrt();
            terms += step;
            normal = Some((factor, weighted));
        }
        let (factor, weighted) = normal?;
        let with_light = self.with_light.as_ref().map(|all| {
            let terms = factor.solve(&(weighted.transpose() * all.select_rows(indices)));
            &terms * terms.transpose()
        });
        Some(Fit {
            terms: std::array::from_fn(|j| terms[j]),
            covariance: factor.inverse(),
            with_light,
            excess,
        })
    }
}

/// Returns the mean modulus of an MTF to which complex noise is added, and its derivative by the
/// MTF. `noise` is the standard deviation of one component.
///
/// The mean is that of Rice's distribution, here by a root of powers that is right to 0.015 `noise`
/// for every MTF. Without an MTF it is sqrt(pi / 2) `noise`.
fn raised(mtf: f64, noise: f64) -> [f64; 2] {
    const POWER: f64 = 2.3;
    let floor = FRAC_PI_2.sqrt() * noise;
    let mean = (mtf.powf(POWER) + floor.powf(POWER)).powf(1.0 / POWER);
    [mean, (mtf / mean).powf(POWER - 1.0)]
}

impl Fit {
    /// Returns where the polynomial falls to a level, in its own variable. Returns `None` if it
    /// does not fall there within its range.
    fn falls_to(&self, level: f64) -> Option<Measured> {
        let power = |u: f64, j: usize| u.powi(j as i32);
        let mut u = 0.0_f64;
        let mut slope = 0.0;
        for _ in 0..20 {
            let value: f64 = (0..=ORDER).map(|j| self.terms[j] * power(u, j)).sum();
            slope = (1..=ORDER)
                .map(|j| self.terms[j] * j as f64 * power(u, j - 1))
                .sum();
            u -= ((value - level.ln()) / slope).clamp(-0.3, 0.3);
        }
        let by_term = DVector::from_fn(ORDER + 1, |j, _| power(u, j));
        let covariance = self.with_light.as_ref().unwrap_or(&self.covariance);
        let variance = by_term.dot(&(covariance * &by_term));
        let terms = self.settled();
        let settled: f64 = (1..=ORDER)
            .map(|j| terms[j] * j as f64 * power(u, j - 1))
            .sum();
        let falls = if settled < 0.0 { settled } else { slope };
        let measured = Measured {
            value: u,
            standard_error: variance.sqrt() / falls.abs(),
        };
        (slope < 0.0 && u.abs() <= 1.0 && variance >= 0.0).then_some(measured)
    }

    /// Returns the terms without the part of the highest one that noise explains.
    ///
    /// Noise that makes the crossing too early makes the polynomial steep there. A standard error
    /// by the slope of the polynomial itself is then too small just where the error is large.
    fn settled(&self) -> [f64; ORDER + 1] {
        let last = self.terms[ORDER];
        let variance = self.covariance[(ORDER, ORDER)];
        // A term of 0 gives a share of minus infinity.
        let kept = (1.0 - CLEAR * CLEAR * variance / (last * last)).max(0.0);
        let taken = (1.0 - kept) * last / variance;
        std::array::from_fn(|j| self.terms[j] - taken * self.covariance[(j, ORDER)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Stream;

    /// The standard error of a crossing holds for a curve in noise.
    ///
    /// The logarithm of a Gaussian MTF has noise in the inverse ratio of the MTF. Fits of a cubic
    /// are drawn from their exact distribution, about a crossing at 0. The mean square pull of
    /// 4,000 draws scatters by sqrt(2 / 4000) = 0.022. The crossing is not linear in the terms; the
    /// second order in the slope, whose noise is a seventh here, adds up to 0.02. So 0.1 is above
    /// three standard deviations. With the slope of the cubic itself it was 1.23 to 1.46.
    #[test]
    fn the_error_of_a_crossing_holds_in_noise() {
        const DRAWS: usize = 4000;
        let mut stream = Stream(5);
        let mut cases = 0;
        for (points, ratio) in [(17, 2.2), (17, 3.0), (25, 3.0), (25, 20.0)] {
            let level: f64 = 0.5;
            // The range is 0.75 of the crossing, as it is on average for edges with noise.
            let truth = [1.0, 1.5, 0.5625, 0.0].map(|term| term * level.ln());
            let mut normal_matrix = DMatrix::zeros(ORDER + 1, ORDER + 1);
            for i in 0..points {
                let u = 2.0 * f64::from(i) / f64::from(points - 1) - 1.0;
                let powers = DVector::from_fn(ORDER + 1, |j, _| u.powi(j as i32));
                let log: f64 = powers.iter().zip(truth).map(|(p, t)| p * t).sum();
                let weight = (log.exp() * ratio / level).powi(2);
                normal_matrix += weight * &powers * powers.transpose();
            }
            let covariance = normal_matrix.cholesky().expect("it is regular").inverse();
            let spread = covariance.clone().cholesky().expect("it is regular").l();
            let (mut found, mut sum) = (0, 0.0);
            for _ in 0..DRAWS {
                let noise = &spread * DVector::from_fn(ORDER + 1, |_, _| stream.normal());
                let fit = Fit {
                    terms: std::array::from_fn(|j| truth[j] + noise[j]),
                    covariance: covariance.clone(),
                    with_light: None,
                    excess: 0.0,
                };
                if let Some(crossing) = fit.falls_to(level) {
                    found += 1;
                    sum += (crossing.value / crossing.standard_error).powi(2);
                }
            }
            let pull = sum / f64::from(found);
            assert!(found > 3900, "{points} {ratio}: {found}");
            assert!((pull - 1.0).abs() < 0.1, "{points} {ratio}: {pull}");
            cases += 1;
        }
        assert_eq!(cases, 4);
    }

    /// The mean modulus meets Rice's distribution, integrated over the plane: a sum over steps of
    /// 0.02 standard deviations up to 8, which is exact to 1e-4. The derivative
    /// meets differences, whose error is h^2/6 of a third derivative below 10.
    #[test]
    fn the_mean_of_a_noisy_modulus_is_that_of_rice() {
        const PARTS: i32 = 400;
        let mut cases = 0;
        for mtf in [0.0, 0.3, 1.0, 2.0, 3.0, 5.0, 20.0] {
            let mut mean = 0.0;
            let mut weights = 0.0;
            for i in -PARTS..=PARTS {
                for j in -PARTS..=PARTS {
                    let [x, y] = [i, j].map(|k| 8.0 * f64::from(k) / f64::from(PARTS));
                    let weight = (-0.5 * (x * x + y * y)).exp();
                    weights += weight;
                    mean += weight * (mtf + x).hypot(y);
                }
            }
            let found = raised(mtf, 1.0);
            assert!(
                (found[0] - mean / weights).abs() < 0.015,
                "{mtf}: {found:?}"
            );
            let h = 1e-4;
            let slope =
                (raised(mtf + h, 1.0)[0] - raised((mtf - h).max(0.0), 1.0)[0]) / (h + h.min(mtf));
            assert!((slope - found[1]).abs() < 1e-4, "{mtf}: {slope} {found:?}");
            cases += 1;
        }
        assert_eq!(cases, 7);
    }
    /// Beyond an MTF the curve is the modulus of complex noise: the mean of its square is twice the
    /// square of the noise of one component. The frequencies are those that are told apart, and
    /// each square scatters by itself, so the mean of n of them scatters by 1/sqrt(n); the limit is
    /// 4 of these.
    #[test]
    fn the_noise_of_a_component_is_half_of_the_power_beyond_the_mtf() {
        const DRAWS: u64 = 40;
        const REACH: usize = 60;
        let (mut sum, mut count) = (0.0, 0.0);
        for seed in 0..DRAWS {
            let mut stream = Stream(seed);
            let bins = 2 * REACH + 1;
            let profile = Profile {
                reach: REACH,
                count: vec![20.0; bins],
                // A blur of 2 pixels leaves 4e-9 of the contrast at half the sampling frequency.
                mean: (0..bins)
                    .map(|j| {
                        let s = (j as f64 - REACH as f64) * BIN_PX;
                        0.5 * libm::erfc(-s / (2.0 * std::f64::consts::SQRT_2))
                            + 0.01 * stream.normal()
                    })
                    .collect(),
                excess: vec![[0.0; 3]; bins],
                variance: vec![1e-4; bins],
                noise: [0.01; 2],
                light: None,
            };
            let curve = Curve::new(&profile, 1.0, 128);
            for k in (64..128).step_by(curve.correlated) {
                sum += (curve.modulus[k] / curve.noise(k)).powi(2);
                count += 1.0;
            }
        }
        let mean = sum / count;
        println!("{mean:.3} over {count} squares");
        assert!(
            count > 400.0 && (mean / 2.0 - 1.0).abs() < 4.0 / f64::sqrt(count),
            "{mean}"
        );
    }
}
