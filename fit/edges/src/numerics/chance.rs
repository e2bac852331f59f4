//! Probabilities that noise alone explains a sum of squares.

use statrs::function::gamma::checked_gamma_ur;

/// Returns the probability that the sum of squares of `freedom` independent standard normal numbers
/// reaches `squares`. It is 1 without degrees of freedom, and NaN if `squares` is.
pub fn of_squares(squares: f64, freedom: usize) -> f64 {
    if freedom == 0 || squares <= 0.0 {
        return 1.0;
    }
    if squares == f64::INFINITY {
        return 0.0;
    }
    checked_gamma_ur(0.5 * freedom as f64, 0.5 * squares).unwrap_or(f64::NAN)
}

/// Returns the probability that the least of `count` independent probabilities is at most `least`.
pub fn of_least(least: f64, count: usize) -> f64 {
    // Written so that tiny probabilities keep their digits.
    -(count as f64 * (-least).ln_1p()).exp_m1()
}

/// Returns the probability that a standard normal number is at most `value`.
pub fn of_normal(value: f64) -> f64 {
    let beyond = 0.5 * of_squares(value * value, 1);
    if value > 0.0 { 1.0 - beyond } else { beyond }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with closed forms and with the tables of Abramowitz and Stegun (Handbook of
    /// Mathematical Functions, 1964, table 26.8), whose values have six digits.
    #[test]
    fn chances_agree_with_closed_forms_and_tables() {
        let mut cases = 0;
        for squares in [0.1_f64, 1.0, 5.0, 40.0, 300.0] {
            // With two degrees of freedom the sum of squares is exponential.
            let two = (-0.5 * squares).exp();
            assert!((of_squares(squares, 2) / two - 1.0).abs() < 1e-12);
            // With one it is the square of one normal number.
            let one = libm::erfc((0.5 * squares).sqrt());
            assert!(
                (of_squares(squares, 1) / one - 1.0).abs() < 1e-9,
                "{squares}"
            );
            for (value, sign) in [(squares.sqrt(), 1.0), (-squares.sqrt(), -1.0)] {
                let below = 0.5 * (1.0 + sign * libm::erf((0.5 * squares).sqrt()));
                assert!((of_normal(value) - below).abs() < 1e-12, "{value}");
            }
            cases += 4;
        }
        for (squares, freedom, chance) in [
            (3.841_46, 1, 0.05),
            (10.827_6, 1, 0.001),
            (18.307_0, 10, 0.05),
            (29.588_3, 10, 0.001),
            (124.342, 100, 0.05),
            (149.449, 100, 0.001),
        ] {
            let off = of_squares(squares, freedom) / chance - 1.0;
            assert!(off.abs() < 1e-4, "{squares} of {freedom}: {off}");
            cases += 1;
        }
        assert_eq!((cases, of_normal(0.0)), (26, 0.5));
    }

    /// Compares tens of thousands of degrees of freedom, as a campaign has, with the cube root of
    /// Wilson and Hilferty (1931), which is almost normal. Its error is far below 1 % there.
    #[test]
    fn chances_of_a_whole_campaign_agree_with_wilson_and_hilferty() {
        let n = 57_000_usize;
        for reduced in [0.98, 0.999, 1.0, 1.01, 1.02, 1.03] {
            let freedom = n as f64;
            let part = 2.0 / (9.0 * freedom);
            let normal = (f64::cbrt(reduced) - 1.0 + part) / part.sqrt();
            let expected = 0.5 * libm::erfc(normal / std::f64::consts::SQRT_2);
            let found = of_squares(reduced * freedom, n);
            println!("{reduced}: {found:e} {expected:e}");
            assert!((found / expected - 1.0).abs() < 0.01, "{reduced}");
        }
        assert_eq!(of_squares(2.0 * n as f64, n), 0.0);
    }

    #[test]
    fn limits_are_defined() {
        assert_eq!(of_squares(3.0, 0), 1.0);
        assert_eq!(of_squares(0.0, 3), 1.0);
        assert_eq!(of_squares(f64::INFINITY, 3), 0.0);
        assert!(of_squares(f64::NAN, 3).is_nan());
        assert_eq!(of_least(0.5, 2), 0.75);
        assert!((of_least(1e-20, 10) / 1e-19 - 1.0).abs() < 1e-12);
    }
}
