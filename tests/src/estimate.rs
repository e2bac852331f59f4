//! Comparison of a result of `fit estimate` with the truth from which its photographs were made.

use std::path::Path;

use serde_json::Value;

/// One number of a result, with its name, standard error and truth.
#[derive(Debug, Clone)]
pub struct Number {
    /// Name: `c` (mm), `a` (1/mm; A = a R without unit if the kernel is `angular`) or `mu`,
    /// followed by the incidence if the number belongs to one incidence.
    pub name: String,
    /// Estimated value, in the unit of the number.
    pub value: f64,
    /// Standard error that the result reports, in the unit of the value.
    pub standard_error: f64,
    /// True value, from which the photographs were made.
    pub truth: f64,
}

impl Number {
    /// Returns the relative error: (value - truth) / truth.
    pub fn relative(&self) -> f64 {
        self.value / self.truth - 1.0
    }

    /// Returns the error, value - truth, in reported standard errors.
    pub fn score(&self) -> f64 {
        (self.value - self.truth) / self.standard_error
    }
}

/// Reads a JSON file.
///
/// # Panics
/// Panics if the file cannot be read or is not JSON.
pub fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Returns all numbers of a result with their truths. `truth` is the whole truth.json.
///
/// # Panics
/// Panics if the result lacks a number or holds one that is not finite, or if the truth has no
/// number for one of the angles.
pub fn numbers(result: &Value, truth: &Value) -> Vec<Number> {
    let a = if result["kernel"] == "angular" {
        "a_times_r"
    } else {
        "a_per_mm"
    };
    [("c", "c_mm"), ("a", a), ("mu", "mu")]
        .iter()
        // The wave kernel has no a.
        .filter(|(name, _)| *name != "a" || result["kernel"] != "wave")
        .flat_map(|(name, key)| parameter(name, &result[*key], &truth["truth"][*name]))
        .collect()
}

fn parameter(name: &str, found: &Value, truth: &Value) -> Vec<Number> {
    let number = |name: String, entry: &Value, truth: &Value| {
        let get = |key: &str| {
            entry[key]
                .as_f64()
                .unwrap_or_else(|| panic!("{name} has no {key}: {entry}"))
        };
        Number {
            value: get("value"),
            standard_error: get("standard_error"),
            truth: truth
                .as_f64()
                .unwrap_or_else(|| panic!("no truth for {name}: {truth}")),
            name,
        }
    };
    let Some(angles) = found["per_angle"].as_array() else {
        return vec![number(name.to_owned(), found, truth)];
    };
    angles
        .iter()
        .map(|entry| {
            let incidence = &entry["incidence_deg"];
            let planted = match truth.as_object() {
                Some(table) => table
                    .iter()
                    .find(|(angle, _)| angle.parse().ok() == incidence.as_f64())
                    .map_or(&Value::Null, |(_, value)| value),
                None => truth,
            };
            number(format!("{name} at {incidence} deg"), entry, planted)
        })
        .collect()
}
