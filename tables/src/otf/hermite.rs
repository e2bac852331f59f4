//! Cubic Hermite interpolation on a uniform grid that starts at 0.

use std::ops::{Add, Mul, Sub};

/// Values and slopes at 0, step, 2 step, ...
#[derive(Debug, Clone)]
pub struct Samples<T = f64> {
    step: f64,
    /// Each value with its slope per step. Side by side they are read faster.
    points: Vec<[T; 2]>,
}

impl<T> Samples<T>
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
{
    /// Makes a table of at least two values and as many slopes (per unit of the abscissa).
    pub fn new(step: f64, values: Vec<T>, slopes: Vec<T>) -> Self {
        assert!(
            values.len() >= 2 && values.len() == slopes.len(),
            "an interpolation table needs two points"
        );
        let pairs = values.into_iter().zip(slopes);
        Samples {
            step,
            points: pairs.map(|(value, slope)| [value, slope * step]).collect(),
        }
    }

    /// Returns the last abscissa that is tabulated.
    pub fn end(&self) -> f64 {
        self.step * (self.points.len() - 1) as f64
    }

    /// Returns value and slope at `x` >= 0; beyond the end the last interval is extended.
    ///
    /// The error of the value is at most step^4 / 384 x the greatest fourth derivative.
    pub fn at(&self, x: f64) -> (T, T) {
        let at = x / self.step;
        let i = (at as usize).min(self.points.len() - 2);
        let t = at - i as f64;
        let ([p0, m0], [p1, m1]) = (self.points[i], self.points[i + 1]);
        let rise = p1 - p0;
        let c2 = rise * 3.0 - m0 * 2.0 - m1;
        let c3 = m0 + m1 - rise * 2.0;
        (
            p0 + (m0 + (c2 + c3 * t) * t) * t,
            (m0 + (c2 * 2.0 + c3 * (3.0 * t)) * t) * (1.0 / self.step),
        )
    }
}
