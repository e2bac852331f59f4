//! The key `fit` of RESULT.json: how well the fit describes its photographs.

use serde::{Deserialize, Serialize};

use crate::estimate::{Chances, Diagnosis, Goodness, Suspect, Verdict, Worst};

/// Quality of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitResult {
    /// Sum of squares of the differences, in units of their noise.
    pub chi2: f64,
    /// Number of independent differences less that of the fitted parameters.
    pub degrees_of_freedom: usize,
    /// Chi-square per degree of freedom: about 1 if only noise is left.
    pub reduced_chi2: f64,
    /// Probability that noise alone gives this chi-square or a larger one.
    pub p_value: f64,
    /// Probabilities of further tests, whose names are those of [`Chances`].
    pub p_values: Chances,
    /// Factor on all standard errors: 1 if the misfit is not significant.
    pub scale: f64,
    /// Factor on the standard errors of mu: at least `scale`, and more if the photographs disagree
    /// on mu.
    pub scale_of_mu: f64,
    /// The quality in one word.
    pub verdict: Verdict,
    /// Photograph with the largest misfit.
    pub worst: Option<Worst>,
    /// Mistakes that would explain the misfit, the best first.
    pub suspects: Vec<Suspect>,
    /// How far the search for suspects went; null in older results.
    #[serde(default)]
    pub diagnosis: Option<Diagnosis>,
}

impl FitResult {
    /// Converts the quality of an estimate.
    pub(crate) fn new(
        goodness: &Goodness,
        suspects: &[Suspect],
        diagnosis: Diagnosis,
    ) -> FitResult {
        FitResult {
            chi2: goodness.chi2,
            degrees_of_freedom: goodness.degrees_of_freedom,
            reduced_chi2: goodness.reduced_chi2(),
            p_value: goodness.chances.chi2,
            p_values: goodness.chances,
            scale: goodness.scale,
            scale_of_mu: goodness.scale_of_mu,
            verdict: goodness.verdict,
            worst: goodness.worst.clone(),
            suspects: suspects.to_vec(),
            diagnosis: Some(diagnosis),
        }
    }
}
