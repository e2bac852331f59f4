//! The departure of a lens from the OTF exp(-(f blur)^p): a spline D(f) that is added to it.
//!
//! D is a cubic spline of v = (f / end)^(1/3) with equal steps from 0 to 1. In v the steps are narrow
//! at low frequencies, where a halo of a hundredth of the light lies, and wide at high ones. (With
//! square roots the narrowest of 16 steps is as wide as the OTF of a halo of 20 pixels, and c, a and
//! mu of such lenses are biased by one of their errors.) At both ends the spline, its slope and its
//! curvature by v are 0. So light is neither lost nor won, the line spread falls as 1/s^2 or faster,
//! and D stays 0 beyond the end.

/// Departure of a lens from its parametric OTF.
#[derive(Debug, Clone, PartialEq)]
pub struct Departure {
    /// Frequency at which the spline ends, 1/mm, > 0.
    pub end_per_mm: f64,
    /// Coefficients of the B-splines. A spline whose coefficients are all c is c but for the first
    /// and the last three steps.
    pub terms: Vec<f64>,
}

impl Departure {
    /// Number of steps less that of the terms: what the conditions at both ends take.
    pub const ENDS: usize = 3;

    /// Evaluates D at `frequency` (1/mm).
    pub fn at(&self, frequency: f64) -> f64 {
        let mut sum = 0.0;
        self.each(frequency, |term, weight| sum += weight * self.terms[term]);
        sum
    }

    /// Passes each term that has a part at `frequency` (1/mm), with the derivative of D by it, to
    /// `take`.
    pub fn each(&self, frequency: f64, mut take: impl FnMut(usize, f64)) {
        let count = self.terms.len();
        let place = (frequency.abs() / self.end_per_mm).cbrt() * (count + Departure::ENDS) as f64;
        let cell = place as usize;
        if cell >= count + Departure::ENDS {
            return;
        }
        let t = place - cell as f64;
        let u = 1.0 - t;
        let weights = [
            u * u * u / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
            t * t * t / 6.0,
        ];
        // The knots are -1, 0, 1, .... Those before the first term and after the last are 0.
        for (index, weight) in (cell..).zip(weights) {
            if index >= Departure::ENDS && index - Departure::ENDS < count {
                take(index - Departure::ENDS, weight);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const END: f64 = 8.0;

    fn at(count: usize, frequency: f64, term: usize) -> f64 {
        let mut terms = vec![0.0; count];
        terms[term] = 1.0;
        let end_per_mm = END;
        Departure { end_per_mm, terms }.at(frequency)
    }

    /// Checks the conditions at both ends. A step h = 1e-5 of v from an end is s = h (count + 3)
    /// knots, where the first or the last term is s^3 / 6 and the others are 0. Sums of numbers below
    /// 1 round by 1e-15.
    #[test]
    fn a_spline_starts_and_ends_level_at_0() {
        let mut cases = 0;
        for count in [1, 2, 3, 6, 14, 22] {
            let s = 1e-5 * (count + Departure::ENDS) as f64;
            for term in 0..count {
                assert_eq!(at(count, 0.0, term), 0.0);
                let after = at(count, END * 1e-15, term);
                let before = at(count, END * (1.0_f64 - 1e-5).powi(3), term);
                for (own, last) in [(after, 0), (before, count - 1)] {
                    let expected = if term == last { s.powi(3) / 6.0 } else { 0.0 };
                    assert!((own - expected).abs() < 1e-15, "{count} {term}: {own}");
                }
                assert_eq!(at(count, END, term), 0.0);
                assert_eq!(at(count, 3.0 * END, term), 0.0);
                cases += 1;
            }
        }
        assert_eq!(cases, 48);
    }

    /// Compares with the truncated-power form of cardinal B-splines, over all frequencies: knot k
    /// has sum_j (-1)^j C(4, j) max(0, x - k + 2 - j)^3 / 6, with x the place in knots. Powers up
    /// to 10^3 round by 1e-12.
    #[test]
    fn the_spline_is_a_sum_of_truncated_powers() {
        let terms = [0.3, -0.7, 0.2, 0.9];
        let own = Departure {
            end_per_mm: END,
            terms: terms.to_vec(),
        };
        let mut cases = 0;
        for i in 0..=400 {
            let v = f64::from(i) / 400.0;
            let bump = |k: f64| {
                let power = |j: f64| f64::max(0.0, 7.0 * v - k + 2.0 - j).powi(3) / 6.0;
                power(0.0) - 4.0 * power(1.0) + 6.0 * power(2.0) - 4.0 * power(3.0) + power(4.0)
            };
            let numbered = (2..).map(f64::from).zip(terms);
            let expected: f64 = numbered.map(|(k, c)| c * bump(k)).sum();
            assert!((own.at(END * v.powi(3)) - expected).abs() < 1e-11, "{v}");
            cases += 1;
        }
        assert_eq!(cases, 401);
    }
}
