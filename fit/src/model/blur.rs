//! The numbers of a blur, and the scaling of its spread with the floating distance.

use crate::names::Kernel;

/// Numbers of the blur at one incidence, which a fit varies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blur {
    /// Spread: a in 1/mm (eq1, lobe), A = a R (angular), or the roughness of a baseline. `shift`
    /// and `wave` ignore it.
    pub spread: f64,
    /// Corner size c, mm, or the roughness of the front (saito-surface). `lobe` and the other
    /// baselines ignore it.
    pub c_mm: f64,
}

impl Kernel {
    /// Returns the divisor that turns the spread parameter into a (1/mm) at the floating distance
    /// `r_mm`: R for `angular`, else 1. It has no meaning for baselines.
    pub fn distance_scale(self, r_mm: f64) -> f64 {
        match self {
            Kernel::Angular => r_mm,
            _ => 1.0,
        }
    }
}
