//! A result of `fit estimate` beside the truth that its photographs were made from.

use std::path::Path;

use serde_json::Value;

/// One number of a result, its truth, and where it belongs.
#[derive(Debug, Clone)]
pub struct Number {
    /// `c`, `a` (1/mm, or A where the kernel is `angular`) or `mu`, with the incidence if there is
    /// one per angle.
    pub name: String,
    /// What was estimated.
    pub value: f64,
    /// Its own standard error.
    pub standard_error: f64,
    /// What was planted.
    pub truth: f64,
}

impl Number {
    /// Difference to the truth, as a part of it.
    pub fn relative(&self) -> f64 {
        self.value / self.truth - 1.0
    }

    /// Difference to the truth in reported standard errors.
    pub fn score(&self) -> f64 {
        (self.value - self.truth) / self.standard_error
    }
}

/// Reads a JSON file.
///
/// # Panics
/// When it is absent or not JSON.
pub fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// All numbers of a result with their truths; `truth` is the whole truth.json.
///
/// # Panics
/// When the result lacks a number, holds one that is not finite, or the truth has none for its
/// angle.
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
