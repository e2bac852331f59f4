//! The transform of a box, sinc t = sin t / t.

/// Evaluates sin t / t, which is 1 at t = 0.
pub fn sinc(t: f64) -> f64 {
    if t.abs() < 1e-4 {
        1.0 - t * t / 6.0
    } else {
        t.sin() / t
    }
}
