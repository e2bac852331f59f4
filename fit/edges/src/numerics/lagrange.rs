//! Interpolation between evenly spaced points.

/// Returns the weights of the points -2 to 3 of a six-point interpolation at `t` in [0, 1).
pub fn lagrange(t: f64) -> [f64; 6] {
    const PLACES: [f64; 6] = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
    PLACES.map(|own| {
        PLACES
            .iter()
            .filter(|&&other| other != own)
            .map(|other| (t - other) / (own - other))
            .product()
    })
}
