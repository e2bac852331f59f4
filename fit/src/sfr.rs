//! The slanted-edge estimator: edge profile -> line spread -> tapered Fourier transform (ISO 12233 style).
//!
//! Everything before the modulus is linear in the pixels, so the whole chain (correction of bin positions, differences,
//! taper, transform) is one complex matrix. The photograph's profile and the model's go through the **same** matrix, and
//! pixel noise is carried through it exactly.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use crate::profile::{BIN_PX, Profile};

/// Share of the window that the taper leaves untouched; the rest falls to 0 as a raised cosine (Tukey window).
const FLAT: f64 = 0.7;

/// A slanted-edge estimator for the bins of one profile and a list of frequencies.
#[derive(Debug, Clone)]
pub struct Estimator {
    /// Frequencies along the edge normal, 1/mm; the first is 0.
    pub frequencies_per_mm: Vec<f64>,
    /// Row k: weights of the bins in the transform at frequency k.
    rows: Vec<Vec<Complex64>>,
    /// 1 / (transfer of bin averaging and of the difference).
    correction: Vec<f64>,
}

/// A modulation transfer function along an edge normal.
#[derive(Debug, Clone)]
pub struct Mtf {
    /// Modulus at the estimator's frequencies, 1 at the first.
    pub modulus: Vec<f64>,
    /// Row k: derivative of the modulus at frequency k by every bin.
    pub by_bin: Vec<Vec<f64>>,
    /// Variance that bin noise adds to the modulus squared (twice the variance per component where noise dominates).
    pub power_noise: Vec<f64>,
}

impl Estimator {
    /// `frequencies_per_mm` are along the normal, positive; zero is put before them.
    pub fn new(profile: &Profile, pitch_mm: f64, frequencies_per_mm: &[f64]) -> Estimator {
        let bin_mm = BIN_PX * pitch_mm;
        let frequencies_per_mm: Vec<f64> = std::iter::once(0.0)
            .chain(frequencies_per_mm.iter().copied())
            .collect();
        let rows = frequencies_per_mm
            .iter()
            .map(|&f| row(profile, TAU * f * bin_mm))
            .collect();
        let correction = frequencies_per_mm
            .iter()
            .map(|&f| sinc(PI * f * bin_mm).powi(-2))
            .collect();
        Estimator {
            frequencies_per_mm,
            rows,
            correction,
        }
    }

    /// The transform of a curve over the bins, at every frequency.
    pub fn transform(&self, bins: &[f64]) -> Vec<Complex64> {
        self.rows
            .iter()
            .map(|row| row.iter().zip(bins).map(|(w, b)| w * b).sum())
            .collect()
    }

    /// The MTF of a measured profile with its derivatives, for carrying noise.
    pub fn measure(&self, profile: &Profile) -> Mtf {
        let transform = self.transform(&profile.mean);
        let zero = transform[0].re;
        let modulus: Vec<f64> = transform
            .iter()
            .zip(&self.correction)
            .map(|(s, c)| s.norm() / zero.abs() * c)
            .collect();
        let by_bin = (0..modulus.len())
            .map(|k| {
                let s = transform[k];
                let phase = if s.norm() > 0.0 {
                    s.conj() / s.norm()
                } else {
                    Complex64::ONE
                };
                let scale = self.correction[k] / zero.abs();
                let row = self.rows[k].iter().zip(&self.rows[0]);
                row.map(|(w, w0)| (phase * w).re * scale - modulus[k] * w0.re / zero)
                    .collect()
            })
            .collect();
        let power_noise = self
            .rows
            .iter()
            .zip(&self.correction)
            .map(|(row, c)| {
                let sum: f64 = row
                    .iter()
                    .zip(&profile.variance)
                    .map(|(w, v)| w.norm_sqr() * v)
                    .sum();
                sum * (c / zero).powi(2)
            })
            .collect();
        Mtf {
            modulus,
            by_bin,
            power_noise,
        }
    }

    /// The MTF of a modelled profile and its derivatives by the model's parameters.
    ///
    /// `power_noise` is the measured curve's: the modulus of a noisy transform is larger than the transform's modulus,
    /// by sqrt(S^2 + n^2) in the mean square, and the model is raised alike.
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

impl Mtf {
    /// Standard error of the modulus at every frequency, by pixel noise.
    pub fn standard_error(&self, profile: &Profile) -> Vec<f64> {
        let sum = |row: &Vec<f64>| {
            row.iter()
                .zip(&profile.variance)
                .map(|(a, v)| a * a * v)
                .sum::<f64>()
        };
        self.by_bin.iter().map(|row| sum(row).sqrt()).collect()
    }
}

/// Weights of the bins in the tapered transform of their differences at `turn` rad per bin.
fn row(profile: &Profile, turn: f64) -> Vec<Complex64> {
    let n = profile.len();
    let middle = 0.5 * (n as f64 - 2.0);
    let spread: Vec<Complex64> = (0..n - 1)
        .map(|m| {
            let at = m as f64 - middle;
            Complex64::from_polar(tukey(at.abs() / (middle + 1.0)), -turn * at)
        })
        .collect();
    // Differences: bin j enters the line spread at j - 1 with + and at j with -.
    let difference = |j: usize| {
        let left = if j > 0 {
            spread[j - 1]
        } else {
            Complex64::ZERO
        };
        let right = if j < n - 1 {
            spread[j]
        } else {
            Complex64::ZERO
        };
        left - right
    };
    let mut weights: Vec<Complex64> = (0..n).map(difference).collect();
    // The pixels of a bin are not spread evenly over it: their first two excess moments are taken out with the curve's
    // own slope and curvature.
    for j in 1..n - 1 {
        let [m1, m2, _] = profile.excess[j];
        let w = difference(j);
        let (slope, curvature) = (0.5 * m1 / BIN_PX, 0.5 * m2 / (BIN_PX * BIN_PX));
        weights[j + 1] -= w * (slope + curvature);
        weights[j - 1] += w * (slope - curvature);
        weights[j] += w * (2.0 * curvature);
    }
    weights
}

fn tukey(x: f64) -> f64 {
    if x <= FLAT {
        1.0
    } else {
        0.5 + 0.5 * (PI * (x - FLAT) / (1.0 - FLAT)).cos()
    }
}

/// sin t / t.
pub fn sinc(t: f64) -> f64 {
    if t.abs() < 1e-4 {
        1.0 - t * t / 6.0
    } else {
        t.sin() / t
    }
}

/// The abscissa at which a curve first falls to `level`, on straight lines between its points.
pub fn crossing(abscissae: &[f64], curve: &[f64], level: f64) -> Option<f64> {
    let k = (1..curve.len()).find(|&k| curve[k] <= level && curve[k - 1] > level)?;
    let part = (curve[k - 1] - level) / (curve[k - 1] - curve[k]);
    Some(abscissae[k - 1] + part * (abscissae[k] - abscissae[k - 1]))
}
