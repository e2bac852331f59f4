//! Luminance: the step of an edge, and mu from the ratio of two steps.
//!
//! The two plateaus are parameters of a straight-line fit of the measured profile to the modelled
//! unit edge, not means of a corner: a lobe's tails reach beyond any window.

use crate::photographs::Profile;

/// The step between the plateaus of an edge, fitted to a modelled unit profile.
#[derive(Debug, Clone)]
pub(crate) struct Contrast {
    /// Bright minus dark plateau, linear light at the photograph's exposure.
    pub step: f64,
    /// Derivative of `step` by every bin.
    pub by_bin: Vec<f64>,
}

impl Contrast {
    /// Weighted least squares of the bins to dark + step x unit; weights are the pixels in a bin,
    /// which keeps the result independent of the noise estimate.
    pub(crate) fn fit(profile: &Profile, unit: &[f64]) -> Contrast {
        let total: f64 = profile.count.iter().sum();
        let weighted = |curve: &[f64]| {
            profile
                .count
                .iter()
                .zip(curve)
                .map(|(n, v)| n * v)
                .sum::<f64>()
                / total
        };
        let centre = weighted(unit);
        let spread: f64 = profile
            .count
            .iter()
            .zip(unit)
            .map(|(n, e)| n * (e - centre).powi(2))
            .sum();
        let by_bin: Vec<f64> = profile
            .count
            .iter()
            .zip(unit)
            .map(|(n, e)| n * (e - centre) / spread)
            .collect();
        let step = by_bin.iter().zip(&profile.mean).map(|(w, y)| w * y).sum();
        Contrast { step, by_bin }
    }

    /// Variance of `step` by pixel noise.
    pub(crate) fn variance(&self, profile: &Profile) -> f64 {
        self.by_bin
            .iter()
            .zip(&profile.variance)
            .map(|(w, v)| w * w * v)
            .sum()
    }

    /// Relative derivative of `step` when the unit profile changes by `change` per unit of a
    /// parameter.
    pub(crate) fn relative_change(&self, change: &[f64]) -> f64 {
        -self
            .by_bin
            .iter()
            .zip(change)
            .map(|(w, d)| w * d)
            .sum::<f64>()
    }
}
