//! Intervals of predictions, from the covariance of the estimate.
//!
//! A number of a prediction is taken as linear in the parameters across their errors. So its
//! standard error is the square root of gᵀ C g, where C is the covariance of the result and g the
//! derivatives by its parameters. A parameter between two fitted angles is their weighted mean, and
//! g has the weights.
//!
//! Two errors are added as independent ones. The eta of a table of rays has the error of their
//! number. Where the sheet was photographed, mu has it too, with the other sign, so the interval of
//! the luminance is too wide there rather than too narrow. And an azimuth that was fitted has an
//! error: numbers are compared one standard error of it to either side.

use crate::predict::curve::Derived;
use crate::result::{Parameter, Part, ResultFile};
use edges::names::{ParameterId, ParameterKind};

/// Half width of the 95 % interval of a normal distribution, in standard deviations.
const HALF_WIDTH: f64 = 1.959_964;

/// Rows of the covariance on which a parameter at one incidence depends, with their weights.
/// `None` if the covariance lacks one of them.
type Rows = Option<Vec<(usize, f64)>>;

/// Errors of the parameters at one incidence.
pub(crate) struct Uncertainty<'a> {
    matrix: &'a [Vec<Option<f64>>],
    /// Spread, c, angular spread, dihedral errors at the edges 1, 2 and 3, and mu.
    rows: [Rows; 7],
}

impl<'a> Uncertainty<'a> {
    /// Takes the errors of the parameters at an incidence from a result.
    pub(crate) fn new(result: &'a ResultFile, incidence_deg: f64) -> Uncertainty<'a> {
        let names = &result.covariance.names;
        let row = |id: ParameterId| names.iter().position(|&name| name == id);
        let kernel = result.kernel;
        let rows = |kind: ParameterKind, parameter: &Parameter| -> Rows {
            let parts = parameter.parts(incidence_deg).into_iter();
            let row_of = |part: Part| {
                let at = part.incidence_deg;
                Some((row(ParameterId { kind, at })?, part.weight))
            };
            parts.map(row_of).collect()
        };
        let one = |kind: ParameterKind| row(kind.shared()).map(|row| vec![(row, 1.0)]);
        let size = one(ParameterKind::size_of(kernel));
        let of = |kind, parameter: Option<&Parameter>| parameter.and_then(|own| rows(kind, own));
        let [e1, e2, e3] = ParameterKind::DIHEDRAL_ERRORS.map(one);
        Uncertainty {
            matrix: &result.covariance.matrix,
            rows: [
                of(ParameterKind::spread_of(kernel), result.spread()),
                size,
                one(ParameterKind::AngularSpread),
                e1,
                e2,
                e3,
                of(ParameterKind::Mu, result.mu.as_ref()),
            ],
        }
    }

    /// Returns the standard error of a number with the given derivatives by spread, c, the angular
    /// spread, the dihedral errors and mu.
    ///
    /// It is `None` without a covariance, and if that has no finite entry for a parameter on which
    /// the number depends.
    pub(crate) fn standard_error(&self, blur: [f64; 6], by_mu: f64) -> Option<f64> {
        if self.matrix.is_empty() {
            return None;
        }
        let mut gradient = vec![0.0; self.matrix.len()];
        let all = blur.into_iter().chain([by_mu]);
        for (by, rows) in all.zip(&self.rows) {
            if by != 0.0 {
                for &(row, weight) in rows.as_ref()? {
                    *gradient.get_mut(row)? += by * weight;
                }
            }
        }
        let used = || gradient.iter().enumerate().filter(|(_, by)| **by != 0.0);
        let mut variance = 0.0;
        for (i, a) in used() {
            for (j, b) in used() {
                variance += a * b * self.matrix.get(i)?.get(j).copied()??;
            }
        }
        (variance >= 0.0).then(|| variance.sqrt())
    }

    /// Returns the standard error of a number of the blur. `beside` is a standard error that the
    /// parameters do not cause.
    pub(crate) fn of_blur(&self, number: &Derived, beside: f64) -> Option<f64> {
        Some(self.standard_error(number.by_blur, 0.0)?.hypot(beside))
    }

    /// Returns the standard error of a luminance, which is `by_mu` times mu. `beside` is a standard
    /// error that mu does not cause.
    pub(crate) fn of_luminance(&self, by_mu: f64, beside: f64) -> Option<f64> {
        Some(self.standard_error([0.0; 6], by_mu)?.hypot(beside))
    }
}

/// Returns the 95 % interval of a number with this standard error, within `least` and `most`.
pub(crate) fn interval(value: f64, standard_error: f64, [least, most]: [f64; 2]) -> [f64; 2] {
    let half = HALF_WIDTH * standard_error;
    [value - half, value + half].map(|v| v.clamp(least, most))
}
