//! sin t / t, the transform of a box.

/// sin t / t.
pub(crate) fn sinc(t: f64) -> f64 {
    if t.abs() < 1e-4 {
        1.0 - t * t / 6.0
    } else {
        t.sin() / t
    }
}
