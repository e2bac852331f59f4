//! Agreement of several results of one sheet: their scatter against their standard errors.

use serde::Serialize;

use crate::result::{Number, Parameter, ResultFile};
use edges::names::{ParameterId, ParameterKind};
use edges::numerics::chance::of_squares;

/// One parameter in several results of one sheet.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Agreement {
    /// Parameter, with its incidence if the results have one number per angle.
    pub parameter: ParameterId,
    /// Number of results that have it with a standard error.
    pub results: usize,
    /// Mean, weighted by the inverse variances, and its standard error.
    pub mean: Number,
    /// Sum of the squared differences from the mean, each divided by its variance.
    pub chi2: f64,
    /// Number of results less one.
    pub degrees_of_freedom: usize,
    /// Probability of this chi-square or a larger one, if the stated errors are right and the sheet
    /// is the same.
    pub p_value: f64,
}

/// Compares c, the spread and mu of several results.
///
/// A parameter that fewer than two results have, with a standard error above 0, is left out.
pub fn agreement(results: &[&ResultFile]) -> Vec<Agreement> {
    let all: Vec<(ParameterId, [f64; 2])> = results.iter().flat_map(|own| known(own)).collect();
    let mut named: Vec<ParameterId> = Vec::new();
    for (id, _) in &all {
        if !named.contains(id) {
            named.push(*id);
        }
    }
    let of = |&parameter: &ParameterId| {
        let own = all.iter().filter(|(id, _)| *id == parameter);
        let own: Vec<[f64; 2]> = own.map(|(_, number)| *number).collect();
        (own.len() > 1).then(|| compared(parameter, &own))
    };
    named.iter().filter_map(of).collect()
}

/// Compares the values of a parameter, each with its standard error.
fn compared(parameter: ParameterId, own: &[[f64; 2]]) -> Agreement {
    let weights = own.iter().map(|[_, error]| error.powi(-2));
    let sum: f64 = weights.clone().sum();
    let mean = weights
        .zip(own)
        .map(|(w, [value, _])| w * value)
        .sum::<f64>()
        / sum;
    let squares = own
        .iter()
        .map(|[value, error]| ((value - mean) / error).powi(2));
    let chi2 = squares.sum();
    Agreement {
        parameter,
        results: own.len(),
        mean: Number {
            value: Some(mean),
            standard_error: Some(sum.sqrt().recip()),
        },
        chi2,
        degrees_of_freedom: own.len() - 1,
        p_value: of_squares(chi2, own.len() - 1),
    }
}

/// Returns the parameters of a result that have a value and a standard error.
fn known(result: &ResultFile) -> Vec<(ParameterId, [f64; 2])> {
    let c = result.c_mm.map(Parameter::Shared);
    let parameters = [
        (ParameterKind::CornerSize, c.as_ref()),
        (ParameterKind::spread_of(result.kernel), result.spread()),
        (ParameterKind::Mu, result.mu.as_ref()),
    ];
    let mut found = Vec::new();
    let mut add = |id: ParameterId, value: Option<f64>, error: Option<f64>| {
        let known = value.zip(error).filter(|(_, error)| *error > 0.0);
        found.extend(known.map(|(value, error)| (id, [value, error])));
    };
    for (kind, parameter) in parameters {
        for (id, own) in parameter.iter().flat_map(|own| own.numbers(kind)) {
            add(id, own.value, own.standard_error);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two values 3 and 4 standard errors from their mean, by hand: weights 1/9 and 1/16 in units
    /// of 0.01 make the mean of 1.00 and 1.05 1.018, whose distances are 0.6 and -0.8 errors.
    #[test]
    fn chi_square_is_that_of_the_weighted_mean() {
        let found = compared(ParameterKind::Mu.shared(), &[[1.0, 0.03], [1.05, 0.04]]);
        let mean = found.mean.value.expect("there are two");
        // Sums of two terms round by less than 1e-15 of themselves.
        assert!((mean - 1.018).abs() < 1e-14, "{mean}");
        assert!((found.chi2 - 1.0).abs() < 1e-12, "{}", found.chi2);
        let error = found.mean.standard_error.expect("there are two");
        assert!((error - 0.024).abs() < 1e-15, "{error}");
        assert_eq!((found.degrees_of_freedom, found.results), (1, 2));
        // A normal number lies beyond one standard error with a probability of 0.3173.
        assert!((found.p_value - 0.3173).abs() < 1e-4, "{}", found.p_value);
    }
}
