//! The parameters of a candidate, and a number with its error.

use edges::names::Kernel;
use edges::names::LobeShape;

/// Candidate: the terms of its blur, and which parameters have one value per incidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// Kernel: the terms of the blur.
    pub kernel: Kernel,
    /// Shape of the lobe.
    pub shape: LobeShape,
    /// True for one spread per incidence, false for one spread for all.
    pub per_angle_a: bool,
    /// True for one mu per incidence, false for one mu for all.
    pub per_angle_mu: bool,
}

/// A number and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// Estimated value.
    pub value: f64,
    /// Standard deviation that pixel noise causes, carried through the estimator, the camera and
    /// the plateaus.
    pub standard_error: f64,
}
