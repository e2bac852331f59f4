//! Luminance of an edge: the step between its plateaus, from which mu follows.
//!
//! mu is the ratio of two steps. The two plateaus are parameters of a straight-line fit of the
//! measured profile to the modelled unit edge. They are not means over a part of the window,
//! because the tails of a lobe reach beyond any window.

use crate::photographs::Profile;

/// Step between the plateaus of an edge, fitted to a modelled unit profile.
#[derive(Debug, Clone)]
pub(crate) struct Contrast {
    /// Bright minus dark plateau, in linear light at the photograph's exposure.
    pub step: f64,
    /// Derivatives of `step` by the mean of each bin.
    pub by_bin: Vec<f64>,
}

impl Contrast {
    /// Fits dark + step x unit to the bins by weighted least squares.
    ///
    /// The weight of a bin is its number of pixels. So the result does not depend on the estimate
    /// of the noise.
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

    /// Returns the variance of `step` that pixel noise causes.
    pub(crate) fn variance(&self, profile: &Profile) -> f64 {
        self.by_bin
            .iter()
            .zip(&profile.variance)
            .map(|(w, v)| w * w * v)
            .sum()
    }

    /// Returns the derivative of ln(step) by a parameter for which `change` is the derivative of
    /// the unit profile.
    pub(crate) fn relative_change(&self, change: &[f64]) -> f64 {
        -self
            .by_bin
            .iter()
            .zip(change)
            .map(|(w, d)| w * d)
            .sum::<f64>()
    }
}
