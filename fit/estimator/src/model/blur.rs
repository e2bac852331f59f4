//! The numbers of a blur, and the scaling of its spread with the floating distance.

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
