//! Parameters of a result, with one number for all incidences or one at each, and their covariance.

use serde::{Deserialize, Serialize};

use edges::names::{ParameterId, ParameterKind};

/// Parameter with one number for all incidence angles, or with one per angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Parameter {
    /// One number per incidence angle.
    PerAngle {
        /// Numbers in ascending order of incidence.
        per_angle: Vec<AtAngle>,
    },
    /// One number for all incidence angles.
    Shared(Number),
}

/// Blur of the mid-air photographs that the reference does not have, pixels: one number for all of
/// them, or one for each floating distance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum OwnBlur {
    /// One number per floating distance.
    PerDistance {
        /// Numbers in ascending order of distance.
        per_distance: Vec<AtDistance>,
    },
    /// One number for all photographs.
    Shared(Number),
}

/// Number at one floating distance, with its error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AtDistance {
    /// Floating distance, mm.
    pub floating_distance_mm: f64,
    /// Estimate.
    #[serde(deserialize_with = "Option::deserialize")]
    pub value: Option<f64>,
    /// Standard error: one standard deviation.
    #[serde(deserialize_with = "Option::deserialize")]
    pub standard_error: Option<f64>,
}

/// Number with its error.
///
/// The value is null if the photographs give only a bound (see
/// [`bounds`](crate::result::ResultFile::bounds)). It has to be written: without the attributes
/// below, serde would read a missing or misspelt key as null.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// Estimate.
    #[serde(deserialize_with = "Option::deserialize")]
    pub value: Option<f64>,
    /// Standard error: one standard deviation.
    #[serde(deserialize_with = "Option::deserialize")]
    pub standard_error: Option<f64>,
}

/// Number at one incidence angle, with its error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AtAngle {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Estimate.
    #[serde(deserialize_with = "Option::deserialize")]
    pub value: Option<f64>,
    /// Standard error: one standard deviation.
    #[serde(deserialize_with = "Option::deserialize")]
    pub standard_error: Option<f64>,
}

/// Covariance of the parameters, with rows and columns in the order of `names`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Covariance {
    /// Names of the parameters.
    ///
    /// They are c_mm, a_per_mm or a_times_r, own_blur_px, angular_spread_mrad, the dihedral errors,
    /// and mu, followed by `_at_<incidence>` if there is one number per angle,
    /// and by `_at_<floating distance>` if there is one own blur per distance.
    pub names: Vec<ParameterId>,
    /// Covariance matrix.
    ///
    /// An entry is null if it is not finite: the photographs do not determine these parameters, or
    /// they cannot tell them apart. A warning says so.
    pub matrix: Vec<Vec<Option<f64>>>,
}

/// Covariance as a file has it.
#[derive(Deserialize)]
struct Unchecked {
    names: Vec<ParameterId>,
    matrix: Vec<Vec<Option<f64>>>,
}

impl TryFrom<Unchecked> for Covariance {
    type Error = String;

    fn try_from(read: Unchecked) -> Result<Covariance, String> {
        let Unchecked { names, matrix } = read;
        let n = names.len();
        if matrix.len() != n || matrix.iter().any(|row| row.len() != n) {
            return Err(format!(
                "the covariance names {n} parameters, but its matrix is not {n} x {n}"
            ));
        }
        let variances = names
            .iter()
            .enumerate()
            .map(|(i, name)| (name, matrix[i][i]));
        for (name, variance) in variances {
            if let Some(variance) = variance.filter(|&own| own < 0.0) {
                return Err(format!("the variance of {name} is {variance}, below 0"));
            }
        }
        Ok(Covariance { names, matrix })
    }
}

impl Number {
    /// Number that is not known.
    pub const UNKNOWN: Number = Number {
        value: None,
        standard_error: None,
    };
}

impl OwnBlur {
    /// Returns all numbers with their names.
    pub fn numbers(&self) -> Vec<(ParameterId, Number)> {
        let kind = ParameterKind::OwnBlur;
        match self {
            OwnBlur::Shared(number) => vec![(kind.shared(), *number)],
            OwnBlur::PerDistance { per_distance } => {
                let number = |own: &AtDistance| Number {
                    value: own.value,
                    standard_error: own.standard_error,
                };
                let all = per_distance.iter();
                all.map(|own| (kind.at(own.floating_distance_mm), number(own)))
                    .collect()
            }
        }
    }
}

impl Parameter {
    /// Returns all numbers with their names, as those of a parameter of this kind.
    pub fn numbers(&self, kind: ParameterKind) -> Vec<(ParameterId, Number)> {
        match self {
            Parameter::Shared(number) => vec![(kind.shared(), *number)],
            Parameter::PerAngle { per_angle } => {
                let number = |own: &AtAngle| Number {
                    value: own.value,
                    standard_error: own.standard_error,
                };
                let all = per_angle.iter();
                all.map(|own| (kind.at(own.incidence_deg), number(own)))
                    .collect()
            }
        }
    }

    /// Returns the value at an incidence angle.
    ///
    /// It is linear between the fitted angles and constant beyond them. It is `None` if a value
    /// that it needs is null.
    pub fn at(&self, incidence_deg: f64) -> Option<f64> {
        let parts = self.parts(incidence_deg);
        let of = |part: &Part| Some(part.weight * part.value?);
        (!parts.is_empty()).then(|| parts.iter().map(of).sum())?
    }

    /// Returns the numbers whose weighted mean is the value at an incidence angle.
    pub(crate) fn parts(&self, incidence_deg: f64) -> Vec<Part> {
        let per_angle = match self {
            Parameter::Shared(number) => {
                return vec![Part {
                    incidence_deg: None,
                    value: number.value,
                    weight: 1.0,
                }];
            }
            Parameter::PerAngle { per_angle } => per_angle,
        };
        let part = |number: &AtAngle, weight: f64| Part {
            incidence_deg: Some(number.incidence_deg),
            value: number.value,
            weight,
        };
        let beyond = |number: &AtAngle| number.incidence_deg >= incidence_deg;
        match per_angle.iter().position(beyond) {
            Some(0) => vec![part(&per_angle[0], 1.0)],
            None => per_angle
                .last()
                .map(|last| part(last, 1.0))
                .into_iter()
                .collect(),
            Some(i) => {
                let (a, b) = (&per_angle[i - 1], &per_angle[i]);
                let whole = b.incidence_deg - a.incidence_deg;
                let weights = [
                    b.incidence_deg - incidence_deg,
                    incidence_deg - a.incidence_deg,
                ];
                let [of_a, of_b] = weights.map(|weight| weight / whole);
                let parts = [part(a, of_a), part(b, of_b)];
                parts.into_iter().filter(|part| part.weight > 0.0).collect()
            }
        }
    }
}

/// Part of a parameter's value at an incidence angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Incidence that the number belongs to, degrees; `None` if all angles share it.
    pub incidence_deg: Option<f64>,
    /// Estimate.
    pub value: Option<f64>,
    /// Share of the number in the value.
    pub weight: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both forms of an own blur come back from JSON, with a name for each number.
    #[test]
    fn an_own_blur_is_one_number_or_one_of_each_distance() {
        let number = |value| format!("\"value\":{value},\"standard_error\":0.25");
        let at = |mm: f64, value| format!("{{\"floating_distance_mm\":{mm:?},{}}}", number(value));
        let apart = format!("[{},{}]", at(150.0, 0.5), at(300.0, -1.5));
        let cases = [
            (format!("{{{}}}", number(0.5)), vec!["own_blur_px"]),
            (
                format!("{{\"per_distance\":{apart}}}"),
                vec!["own_blur_px_at_150", "own_blur_px_at_300"],
            ),
        ];
        for (text, names) in cases {
            let read: OwnBlur = serde_json::from_str(&text).expect("it is an own blur");
            assert_eq!(serde_json::to_string(&read).expect("it is JSON"), text);
            let numbers = read.numbers();
            let found: Vec<String> = numbers.iter().map(|(id, _)| id.to_string()).collect();
            assert_eq!(found, names);
            assert_eq!(numbers[0].1.value, Some(0.5));
        }
        for bad in ["{}", "{\"per_distance\":[{\"value\":1}]}", "1"] {
            assert!(serde_json::from_str::<OwnBlur>(bad).is_err(), "{bad}");
        }
    }

    /// Compares values between and beyond the fitted angles with values calculated by hand. All
    /// numbers are short binary fractions, so the results are exact.
    #[test]
    fn a_value_between_two_angles_has_the_weights_of_a_straight_line() {
        let at = |incidence_deg: f64, value: f64| AtAngle {
            incidence_deg,
            value: Some(value),
            standard_error: None,
        };
        let parameter = Parameter::PerAngle {
            per_angle: vec![at(0.0, 3.0), at(40.0, 7.0), at(50.0, 2.0)],
        };
        for (incidence_deg, expected) in [
            (-5.0, 3.0),
            (0.0, 3.0),
            // 3/4 of 3 and 1/4 of 7.
            (10.0, 4.0),
            (20.0, 5.0),
            (35.0, 6.5),
            (40.0, 7.0),
            // 3/4 of 7 and 1/4 of 2.
            (42.5, 5.75),
            (50.0, 2.0),
            (60.0, 2.0),
        ] {
            assert_eq!(
                parameter.at(incidence_deg),
                Some(expected),
                "{incidence_deg}"
            );
        }
    }
}
