//! The slanted-edge estimator: edge profile -> line spread function -> tapered Fourier transform
//! (in the style of ISO 12233).
//!
//! Every step before the modulus is linear in the pixels. The correction of bin positions, the
//! differences and the taper are one banded matrix, and the transform is an FFT. The photograph's
//! profile and the model's pass through the **same** chain, and pixel noise is carried through it
//! exactly.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use nalgebra::DMatrix;
use num_complex::Complex64;
use transforms::{Real, RealToComplex};

use crate::numerics::sinc;
use crate::photographs::profile::{BIN_PX, Profile};

/// Share of the window that the taper leaves unchanged. The rest falls to 0 as a raised cosine
/// (Tukey window).
const FLAT: f64 = 0.7;

/// Number of places of the line spread function that a bin contributes to. They reach from two
/// before the bin to one behind it (place m lies between bins m and m + 1).
const BAND: usize = 4;

/// A slanted-edge estimator for the bins of one profile, at evenly spaced frequencies.
#[derive(Clone)]
pub struct Estimator {
    /// Frequencies along the edge normal, 1/mm; the first is 0.
    pub frequencies_per_mm: Vec<f64>,
    /// Reciprocal of the transfer of bin averaging and of the difference, for each frequency.
    correction: Vec<f64>,
    /// Weights of bin j (row j) in places j - 2 to j + 1 of the tapered line spread function.
    band: Vec<[f64; BAND]>,
    /// Fourier transform over one period. A longer line spread function wraps round, which has no
    /// effect at the frequencies used.
    fourier: Arc<dyn RealToComplex<f64>>,
}

/// A modulation transfer function along an edge normal.
#[derive(Debug, Clone)]
pub struct Mtf {
    /// Modulus at the estimator's frequencies, 1 at the first.
    pub modulus: Vec<f64>,
    /// Variance that bin noise adds to the square of the modulus (twice the variance per component
    /// where noise dominates).
    pub power_noise: Vec<f64>,
}

impl Estimator {
    /// Creates an estimator for frequency 0 and the first `count` multiples of 1 / (`period` bins).
    /// At most `period` / 2 multiples are used.
    pub fn new(profile: &Profile, pitch_mm: f64, period: usize, count: usize) -> Estimator {
        let bin_mm = BIN_PX * pitch_mm;
        let frequencies_per_mm: Vec<f64> = (0..=count.min(period / 2))
            .map(|k| k as f64 / (period as f64 * bin_mm))
            .collect();
        let correction = frequencies_per_mm
            .iter()
            .map(|&f| sinc(PI * f * bin_mm).powi(-2))
            .collect();
        Estimator {
            frequencies_per_mm,
            correction,
            band: band(profile),
            fourier: f64::forward(period),
        }
    }

    /// Reduces the estimator to frequency 0 and the first `count` frequencies above it.
    pub fn truncated(mut self, count: usize) -> Estimator {
        self.frequencies_per_mm.truncate(count + 1);
        self.correction.truncate(count + 1);
        self
    }

    /// Returns the transform of a curve over the bins, at every frequency. Its phase refers to the
    /// profile's first difference.
    pub fn transform(&self, bins: &[f64]) -> Vec<Complex64> {
        let period = self.fourier.len();
        let mut spread = self.fourier.make_input_vec();
        for (j, (weights, value)) in self.band.iter().zip(bins).enumerate() {
            // The place is j - 2. A place before 0 is counted from the period's end; the weights
            // there are 0.
            let mut place = (j + 2 * period - 2) % period;
            for weight in weights {
                spread[place] += weight * value;
                place = if place + 1 == period { 0 } else { place + 1 };
            }
        }
        let mut transform = self.fourier.make_output_vec();
        self.fourier
            .process(&mut spread, &mut transform)
            .expect("both lengths are the plan's own");
        transform.truncate(self.frequencies_per_mm.len());
        transform
    }

    /// Returns the MTF of a measured profile.
    pub fn measure(&self, profile: &Profile) -> Mtf {
        let transform = self.transform(&profile.mean);
        let zero = transform[0].re;
        let corrected = transform.iter().zip(&self.correction);
        let modulus = corrected.map(|(s, c)| s.norm() / zero.abs() * c).collect();
        // The weight of a bin at any frequency is a sum of BAND phases. The square of the weight
        // depends only on the differences of the phases.
        let mut lags = [0.0; BAND];
        for (weights, variance) in self.band.iter().zip(&profile.variance) {
            for (lag, sum) in lags.iter_mut().enumerate() {
                let products = weights.iter().zip(&weights[lag..]);
                *sum += variance * products.map(|(a, b)| a * b).sum::<f64>();
            }
        }
        let turn = TAU / self.fourier.len() as f64;
        let power_noise = (0..).zip(&self.correction).map(|(k, c)| {
            let phase = |lag: usize| (turn * f64::from(k) * lag as f64).cos();
            let rest: f64 = (1..BAND).map(|lag| 2.0 * lags[lag] * phase(lag)).sum();
            (lags[0] + rest).max(0.0) * (c / zero).powi(2)
        });
        Mtf {
            modulus,
            power_noise: power_noise.collect(),
        }
    }

    /// Returns the derivatives of a measured profile's modulus by its bins: rows are frequencies,
    /// columns are bins.
    pub fn response(&self, profile: &Profile) -> DMatrix<f64> {
        let transform = self.transform(&profile.mean);
        let zero = transform[0].re;
        let period = self.fourier.len();
        let circle: Vec<Complex64> = (0..period)
            .map(|i| Complex64::from_polar(1.0, -TAU * i as f64 / period as f64))
            .collect();
        let mut response = DMatrix::zeros(transform.len(), self.band.len());
        let mut by_place = vec![0.0; self.band.len() + BAND];
        for (k, (s, correction)) in transform.iter().zip(&self.correction).enumerate() {
            let norm = s.norm();
            let scale = correction / zero.abs();
            let phase = if norm > 0.0 {
                s.conj() / norm
            } else {
                Complex64::ONE
            } * scale;
            let of_zero = norm * scale / zero;
            // `by_place[m + 2]` belongs to place m.
            let mut at = (2 * period - 2 * k) % period;
            for value in &mut by_place {
                *value = (phase * circle[at]).re - of_zero;
                at = (at + k) % period;
            }
            for (j, weights) in self.band.iter().enumerate() {
                let products = weights.iter().zip(&by_place[j..]);
                response[(k, j)] = products.map(|(w, v)| w * v).sum();
            }
        }
        response
    }

    /// Returns the MTF of a modelled profile and its derivatives by the model's parameters.
    ///
    /// `power_noise` is that of the measured curve. In the mean square, the modulus of a noisy
    /// transform is sqrt(S^2 + n^2), larger than the modulus S of the transform without noise. The
    /// model is raised in the same way.
    pub fn predict(
        &self,
        bins: &[f64],
        by_parameter: &[Vec<f64>],
        power_noise: &[f64],
    ) -> (Vec<f64>, Vec<Vec<f64>>) {
        let transform = self.transform(bins);
        let zero = transform[0].re;
        let modulus: Vec<f64> = (0..transform.len())
            .map(|k| {
                ((transform[k].norm() / zero * self.correction[k]).powi(2) + power_noise[k]).sqrt()
            })
            .collect();
        let derivatives = by_parameter
            .iter()
            .map(|bins| {
                let d = self.transform(bins);
                (0..d.len())
                    .map(|k| {
                        let c2 = (self.correction[k] / zero).powi(2);
                        let power = 2.0 * (transform[k].conj() * d[k]).re * c2
                            - 2.0 * transform[k].norm_sqr() * c2 * d[0].re / zero;
                        if modulus[k] > 0.0 {
                            0.5 * power / modulus[k]
                        } else {
                            0.0
                        }
                    })
                    .collect()
            })
            .collect();
        (modulus, derivatives)
    }
}

/// Returns the standard error of the modulus at every frequency, by pixel noise.
pub fn standard_error(response: &DMatrix<f64>, profile: &Profile) -> Vec<f64> {
    if profile.light.is_some() {
        let all = profile.response(response.clone());
        return all.row_iter().map(|row| row.norm()).collect();
    }
    let rows = response.row_iter();
    rows.map(|row| profile.variance_of(row.iter()).sqrt())
        .collect()
}

/// Returns the weights of the bins in the tapered differences of neighbours.
fn band(profile: &Profile) -> Vec<[f64; BAND]> {
    let n = profile.len();
    let middle = 0.5 * (n as f64 - 2.0);
    let taper = |place: usize| tukey((place as f64 - middle).abs() / (middle + 1.0));
    let mut band = vec![[0.0; BAND]; n];
    // `add` adds the contribution of bin j, taken from bin i (at most one away): + to place j - 1,
    // - to place j.
    let mut add = |i: usize, j: usize, share: f64| {
        let first = j + 1 - i;
        if j > 0 {
            band[i][first] += share * taper(j - 1);
        }
        if j < n - 1 {
            band[i][first + 1] -= share * taper(j);
        }
    };
    for j in 0..n {
        add(j, j, 1.0);
    }
    // The pixels of a bin are not spread evenly over it. The effect of their first two excess
    // moments is removed with the curve's own slope and curvature.
    for j in 1..n - 1 {
        let [m1, m2, _] = profile.excess[j];
        let (slope, curvature) = (0.5 * m1 / BIN_PX, 0.5 * m2 / (BIN_PX * BIN_PX));
        add(j + 1, j, -(slope + curvature));
        add(j - 1, j, slope - curvature);
        add(j, j, 2.0 * curvature);
    }
    band
}

fn tukey(x: f64) -> f64 {
    if x <= FLAT {
        1.0
    } else {
        0.5 + 0.5 * (PI * (x - FLAT) / (1.0 - FLAT)).cos()
    }
}

/// Returns the abscissa at which a curve first falls to `level`, on straight lines between its
/// points. Returns `None` if it never does.
pub fn crossing(abscissae: &[f64], curve: &[f64], level: f64) -> Option<f64> {
    let k = (1..curve.len()).find(|&k| curve[k] <= level && curve[k - 1] > level)?;
    let part = (curve[k - 1] - level) / (curve[k - 1] - curve[k]);
    Some(abscissae[k - 1] + part * (abscissae[k] - abscissae[k - 1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes the chain in plain steps: corrections, differences, taper and transform.
    fn plain(profile: &Profile, bins: &[f64], turn: f64) -> Complex64 {
        let n = bins.len();
        let mut straight = bins.to_vec();
        for j in 1..n - 1 {
            let [m1, m2, _] = profile.excess[j];
            straight[j] -= 0.5 * m1 / BIN_PX * (bins[j + 1] - bins[j - 1])
                + 0.5 * m2 / BIN_PX.powi(2) * (bins[j + 1] - 2.0 * bins[j] + bins[j - 1]);
        }
        let middle = 0.5 * (n as f64 - 2.0);
        let place = |m: usize| {
            let taper = tukey((m as f64 - middle).abs() / (middle + 1.0));
            Complex64::from_polar(taper * (straight[m + 1] - straight[m]), -turn * m as f64)
        };
        (0..n - 1).map(place).sum()
    }

    fn profile(reach: usize) -> Profile {
        let n = 2 * reach + 1;
        let wave = |j: usize, by: f64| (by * (j as f64 + 0.3)).sin();
        Profile {
            reach,
            count: vec![20.0; n],
            mean: (0..n)
                .map(|j| (0.1 * (j as f64 - reach as f64)).tanh() + 0.01 * wave(j, 2.1))
                .collect(),
            excess: (0..n)
                .map(|j| [0.02 * wave(j, 1.3), 0.003 * wave(j, 0.7), 0.0])
                .collect(),
            variance: (0..n).map(|j| 1e-4 * (2.0 + wave(j, 0.2))).collect(),
            noise: [0.01; 2],
            light: None,
        }
    }

    /// Change of a bin in the differences of the modulus.
    const STEP: f64 = 1e-4;

    /// Checks transform, noise and response against the plain chain. Sums of 200 terms of order 1
    /// round to 1e-13, and so the differences to 1e-9.
    #[test]
    fn the_band_and_the_fft_are_the_plain_chain() {
        let mut cases = 0;
        // The last period is shorter than the profile, so the line spread function wraps round.
        for (reach, period, count) in [(64, 144, 40), (100, 201, 100), (90, 64, 32)] {
            let profile = profile(reach);
            let unit = |j: usize| {
                let mut unit = vec![0.0; profile.len()];
                unit[j] = 1.0;
                unit
            };
            let estimator = Estimator::new(&profile, 0.1, period, count);
            let transform = estimator.transform(&profile.mean);
            let mtf = estimator.measure(&profile);
            let response = estimator.response(&profile);
            for k in 0..=count {
                let turn = TAU * k as f64 / period as f64;
                let by_bin: Vec<Complex64> = (0..profile.len())
                    .map(|j| plain(&profile, &unit(j), turn))
                    .collect();
                let expected = plain(&profile, &profile.mean, turn);
                assert!((transform[k] - expected).norm() < 1e-12, "{k}");
                let power = by_bin.iter().zip(&profile.variance);
                let power: f64 = power.map(|(w, v)| w.norm_sqr() * v).sum();
                let scale = estimator.correction[k] / transform[0].re;
                assert!((mtf.power_noise[k] / (power * scale * scale) - 1.0).abs() < 1e-10);
                for j in [0, 1, 17, profile.len() - 2, profile.len() - 1] {
                    let modulus = |way: f64| {
                        let mut moved = profile.clone();
                        moved.mean[j] += way * STEP;
                        estimator.measure(&moved).modulus[k]
                    };
                    let slope = (modulus(1.0) - modulus(-1.0)) / (2.0 * STEP);
                    let error = slope - response[(k, j)];
                    // The third derivative of |z + h w| by h is at most 1.16 w^3/z^2; the
                    // difference has STEP^2/6 of it. The light, by which the modulus is divided,
                    // adds a term of the same size. At a zero the modulus has a kink.
                    let [weight, light] = [by_bin[j], plain(&profile, &unit(j), 0.0)]
                        .map(|weight| (weight * scale).norm());
                    let curved = (weight + light).powi(3) / mtf.modulus[k].powi(2);
                    assert!(
                        error.abs() < 0.4 * STEP * STEP * curved + 1e-9 || mtf.modulus[k] < 1e-3,
                        "{k} {j}: {error}"
                    );
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 5 * (41 + 101 + 33));
    }
}
