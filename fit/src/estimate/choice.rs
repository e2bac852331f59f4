//! What a candidate lets vary, and a number with its error.

use crate::names::Kernel;
use crate::names::LobeShape;

/// What a candidate lets vary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// Terms of the blur.
    pub kernel: Kernel,
    /// Shape of the lobe.
    pub shape: LobeShape,
    /// One spread per incidence angle, or one for all.
    pub per_angle_a: bool,
    /// One mu per incidence angle, or one for all.
    pub per_angle_mu: bool,
}

/// A number and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// The estimate.
    pub value: f64,
    /// One standard deviation: pixel noise carried through the estimator, the camera and the
    /// plateaus.
    pub standard_error: f64,
}
