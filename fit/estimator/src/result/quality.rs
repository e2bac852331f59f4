//! The keys `fit` and `candidates` of RESULT.json: how well the fit describes its photographs, and how
//! well other models do.

use serde::{Deserialize, Serialize};

use crate::estimate::{Chances, Diagnosis, Goodness, Ranked, Suspect, Verdict, Worst};
use crate::model::OwnBlur;
use edges::names::{Kernel, LobeShape};

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

/// Model that was compared with the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Kernel: the terms of the blur.
    pub kernel: Kernel,
    /// Shape of the lobe; null without a lobe.
    pub lobe: Option<LobeShape>,
    /// Sharing of a (for a baseline, of the roughness): shared by all angles, or one per angle.
    pub sharing: String,
    /// Bayes' information criterion; smaller is better.
    pub criterion: f64,
    /// True if the model has a blur of the mid-air photographs that the reference does not have.
    #[serde(default, skip_serializing_if = "is_false")]
    pub own_blur: bool,
    /// True if it has one such blur for each floating distance.
    #[serde(default, skip_serializing_if = "is_false")]
    pub own_blur_per_distance: bool,
    /// True if the model has an angular spread.
    #[serde(default, skip_serializing_if = "is_false")]
    pub angular_spread: bool,
    /// True if the model has dihedral errors that all cubes share.
    #[serde(default, skip_serializing_if = "is_false")]
    pub dihedral_errors: bool,
    /// Sum of squares of the residuals in units of their noise, with correlations removed.
    pub loss: f64,
    /// Count of parameters of the blur.
    pub parameters: usize,
}

/// Returns whether a flag is not set.
fn is_false(flag: &bool) -> bool {
    !flag
}

/// Converts a row of the comparison.
pub(super) fn candidate(row: &Ranked) -> Candidate {
    let kernel = row.choice.kernel;
    Candidate {
        kernel,
        lobe: kernel.has_lobe().then_some(row.choice.shape),
        sharing: sharing(kernel, row.choice.per_angle_a),
        criterion: row.criterion,
        own_blur: row.choice.further.has_own_blur(),
        own_blur_per_distance: row.choice.further.own_blur == OwnBlur::PerDistance,
        angular_spread: row.choice.further.angular_spread,
        dihedral_errors: row.choice.further.common_errors,
        loss: row.chi2,
        parameters: row.parameters,
    }
}

/// Describes how the spread is shared by the incidence angles, for example "a per angle".
pub fn sharing(kernel: Kernel, per_angle: bool) -> String {
    let name = if kernel.is_baseline() {
        "roughness"
    } else {
        "a"
    };
    match (kernel.has_lobe(), per_angle) {
        (false, _) => "none".into(),
        (true, false) => format!("{name} shared"),
        (true, true) => format!("{name} per angle"),
    }
}
