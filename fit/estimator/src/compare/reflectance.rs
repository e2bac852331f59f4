//! Luminance of an edge: the step between its plateaus, from which mu follows.
//!
//! mu is the ratio of two steps. The two plateaus are parameters of a straight-line fit of the
//! measured profile to the modelled unit edge. They are not means over a part of the window,
//! because the tails of a lobe reach beyond any window.

use edges::photographs::Profile;

/// Step between the plateaus of an edge, fitted to a modelled unit profile.
#[derive(Debug, Clone)]
pub struct Contrast {
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
    pub fn fit(profile: &Profile, unit: &[f64]) -> Contrast {
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
        profile.variance_of(self.by_bin.iter())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns three bins with 1, 2 and 5 pixels. Their weighted mean of the unit edge is 0.7.
    fn profile() -> Profile {
        Profile {
            reach: 1,
            count: vec![1.0, 2.0, 5.0],
            mean: vec![1.0, 2.0, 4.0],
            excess: vec![[0.0; 3]; 3],
            variance: vec![0.08, 0.04, 0.016],
            noise: [0.2; 2],
            light: None,
        }
    }

    const UNIT: [f64; 3] = [0.0, 0.3, 1.0];

    /// Checks the weighted straight line by hand: the spread is 0.49 + 2 x 0.16 + 5 x 0.09 = 1.26,
    /// and the weights of the bins over it are -0.7, -0.8 and 1.5. Ten roundings of numbers up to 4
    /// stay below 1e-14.
    #[test]
    fn the_step_is_the_slope_of_the_weighted_line() {
        let profile = profile();
        let contrast = Contrast::fit(&profile, &UNIT);
        let expected = (-0.7 - 0.8 * 2.0 + 1.5 * 4.0) / 1.26;
        assert!(
            (contrast.step - expected).abs() < 1e-14,
            "{}",
            contrast.step
        );
        let of_noise = (0.49 * 0.08 + 0.64 * 0.04 + 2.25 * 0.016) / (1.26 * 1.26);
        let variance = contrast.variance(&profile);
        assert!((variance - of_noise).abs() < 1e-15, "{variance} {of_noise}");
        // Another dark plateau changes nothing.
        let mut raised = profile.clone();
        raised.mean.iter_mut().for_each(|mean| *mean += 0.75);
        let other = Contrast::fit(&raised, &UNIT).step;
        assert!((other - expected).abs() < 1e-14, "{other}");
    }

    /// Compares the derivative of ln(step) with differences, where the profile is that of the unit
    /// edge. The second derivative is of order 1, and its part in a central difference cancels; the
    /// third leaves h^2 times a number below 100.
    #[test]
    fn the_step_answers_to_a_changed_edge() {
        let mut profile = profile();
        profile.mean = UNIT.iter().map(|unit| 0.2 + 0.5 * unit).collect();
        let (change, h) = ([0.1, 0.4, -0.2], 1e-5);
        let at = |by: f64| {
            let unit: Vec<f64> = UNIT.iter().zip(change).map(|(u, d)| u + by * d).collect();
            Contrast::fit(&profile, &unit).step.ln()
        };
        let difference = (at(h) - at(-h)) / (2.0 * h);
        let slope = Contrast::fit(&profile, &UNIT).relative_change(&change);
        assert!((slope - difference).abs() < 1e-8, "{slope} {difference}");
    }
}
