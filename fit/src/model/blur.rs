//! One model of the blur: its numbers, and how its spread scales with the floating distance.

use crate::names::Kernel;

/// One model of the blur at one incidence: what a fit varies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blur {
    /// a in 1/mm (eq1, lobe), A = a R (angular) or the roughness of a baseline; ignored by `shift`
    /// and `wave`.
    pub spread: f64,
    /// Corner size, mm, or the roughness of the front (saito-surface); ignored by `lobe` and the
    /// other baselines.
    pub c_mm: f64,
}

impl Kernel {
    /// The divisor that turns the spread parameter into a (1/mm) at floating distance `r_mm`: 1 or
    /// R. Not for baselines.
    pub fn distance_scale(self, r_mm: f64) -> f64 {
        match self {
            Kernel::Angular => r_mm,
            _ => 1.0,
        }
    }
}
