//! The departure of a lens from the OTF exp(-(f blur)^p): a factor 1 + S(f), with a spline S.
//!
//! S is a cubic spline of v = sqrt(f / end) with equal steps from 0 to 1. In v the steps are narrow
//! at low frequencies, where a halo of a hundredth of the light lies, and wide at high ones. S and
//! its slope by v are 0 at frequency 0: light is neither lost nor won, and the line spread falls as
//! 1/s^2 or faster. The spline ends with slope 0, and keeps its last value beyond. A spline of twice
//! as many terms contains it.

/// Departure of a lens from its parametric OTF.
#[derive(Debug, Clone, PartialEq)]
pub struct Departure {
    /// Frequency at which the spline ends, 1/mm, > 0.
    pub end_per_mm: f64,
    /// Coefficients of the B-splines, at least 2. A spline whose coefficients are all c is c beyond
    /// the first steps.
    pub terms: Vec<f64>,
}

impl Departure {
    /// Evaluates S at `frequency` (1/mm).
    pub fn at(&self, frequency: f64) -> f64 {
        let mut sum = 0.0;
        self.each(frequency, |term, weight| sum += weight * self.terms[term]);
        sum
    }

    /// Passes each term that has a part at `frequency` (1/mm), with the derivative of S by it, to
    /// `take`. A term may come more than once; its derivatives add up.
    pub fn each(&self, frequency: f64, mut take: impl FnMut(usize, f64)) {
        let count = self.terms.len();
        let place = (frequency.abs() / self.end_per_mm).min(1.0).sqrt() * count as f64;
        let cell = (place as usize).min(count - 1);
        let t = place - cell as f64;
        let u = 1.0 - t;
        let weights = [
            u * u * u / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
            t * t * t / 6.0,
        ];
        for (knot, weight) in (cell..).zip(weights) {
            // Knots are counted from -1. The spline is mirrored at both ends, and the coefficient
            // of knot 0 makes it 0 there.
            match knot {
                0 => take(0, weight),
                1 => take(0, -0.5 * weight),
                knot if knot - 1 > count => take(count - 2, weight),
                knot => take(knot - 2, weight),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(count: usize, frequency: f64, term: usize) -> f64 {
        let mut terms = vec![0.0; count];
        terms[term] = 1.0;
        let end_per_mm = 8.0;
        Departure { end_per_mm, terms }.at(frequency)
    }

    /// Checks the conditions of the spline at both ends, each to the rounding of numbers below 1
    /// or to that of a difference of step h, and that equal coefficients give a constant.
    #[test]
    fn a_spline_starts_at_0_and_ends_level() {
        let mut cases = 0;
        for count in [2, 3, 4, 8, 16] {
            for term in 0..count {
                assert!(at(count, 0.0, term).abs() < 1e-15);
                // v = h: S is of the order (count v)^2, and so is the step at the end.
                let h: f64 = 1e-5;
                let bound = (count as f64 * h).powi(2) * 2.0;
                assert!(at(count, 8.0 * h * h, term).abs() < bound);
                let end = at(count, 8.0, term);
                let before = at(count, 8.0 * (1.0 - h) * (1.0 - h), term);
                assert!((end - before).abs() < bound, "{count} {term}");
                assert_eq!(end, at(count, 20.0, term));
                cases += 1;
            }
            let third = 8.0 * (2.0 / count as f64).powi(2);
            let sum: f64 = (0..count).map(|term| at(count, third, term)).sum();
            assert!((sum - 1.0).abs() < 1e-15, "{count}: {sum}");
        }
        assert_eq!(cases, 33);
    }

    /// A spline on a grid that is twice as fine contains each spline of the coarse grid: its
    /// coefficients at old knots are (c_left + 6 c + c_right) / 8, and those between are means.
    #[test]
    fn a_spline_of_twice_as_many_terms_contains_it() {
        let terms = [0.3, -0.7, 0.2, 0.9];
        // Knots from -1 to 5, mirrored, and the one at 0.
        let knots = [0.3, -0.15, 0.3, -0.7, 0.2, 0.9, 0.2];
        let fine: Vec<f64> = (1..=8)
            .map(|k| {
                let i = k / 2 + 1;
                match k % 2 {
                    0 => (knots[i - 1] + 6.0 * knots[i] + knots[i + 1]) / 8.0,
                    _ => 0.5 * (knots[i] + knots[i + 1]),
                }
            })
            .collect();
        let of = |terms: &[f64]| Departure {
            end_per_mm: 3.0,
            terms: terms.to_vec(),
        };
        let (coarse, fine) = (of(&terms), of(&fine));
        let mut cases = 0;
        for k in 0..=200 {
            let f = 3.4 * f64::from(k) / 200.0;
            assert!((coarse.at(f) - fine.at(f)).abs() < 1e-14, "{f}");
            cases += 1;
        }
        assert_eq!(cases, 201);
    }
}
