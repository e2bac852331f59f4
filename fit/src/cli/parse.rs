//! How arguments are read: numbers, lists of them, JSON files.

use std::path::Path;

use tables::cli::list;

use crate::cli::failure::Failure;
use crate::photographs::photo::transfer::Transfer;

/// `0 <= incidence < 90`, every one.
///
/// # Errors
/// A sentence for clap.
pub fn incidences(text: &str) -> Result<Vec<f64>, String> {
    let list = list(text).map_err(|error| error.to_string())?;
    match list.iter().find(|v| !(0.0..90.0).contains(*v)) {
        Some(bad) => Err(format!(
            "incidence {bad} is outside of 0 <= angle < 90 degrees"
        )),
        None => Ok(list),
    }
}

/// One incidence, degrees.
///
/// # Errors
/// A sentence for clap.
pub fn incidence(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..90.0).contains(&value) => Ok(value),
        _ => Err("must be an angle of 0 <= angle < 90 degrees".into()),
    }
}

/// The azimuth of a table that holds only one.
pub fn only_azimuth(table: &tables::Table) -> Option<f64> {
    match table.axes.azimuth_deg[..] {
        [azimuth] if !azimuth.is_nan() => Some(azimuth),
        _ => None,
    }
}

/// Numbers > 0, every one.
///
/// # Errors
/// A sentence for clap.
pub fn positives(text: &str) -> Result<Vec<f64>, String> {
    let list = list(text).map_err(|error| error.to_string())?;
    match list.iter().find(|v| **v <= 0.0) {
        Some(bad) => Err(format!("{bad} is not larger than 0")),
        None => Ok(list),
    }
}

/// One number > 0.
///
/// # Errors
/// A sentence for clap.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("must be a number larger than 0".into()),
    }
}

/// One number >= 0.
///
/// # Errors
/// A sentence for clap.
pub fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("must be a number, 0 or larger".into()),
    }
}

/// What stored integers mean.
///
/// # Errors
/// A sentence for clap.
pub fn transfer(text: &str) -> Result<Transfer, String> {
    let names = Transfer::NAMES.join(" or ");
    Transfer::from_name(text).ok_or_else(|| format!("must be {names}"))
}

/// Longest JSON that is read, bytes: a hundred times the result of a thousand photographs.
const MOST_JSON: u64 = 1 << 25;

/// Reads a JSON file.
///
/// # Errors
/// [`Failure::Json`] where it cannot be read or is another kind of file.
pub fn read_json<T: serde::de::DeserializeOwned>(
    path: &Path,
    expected: &'static str,
) -> Result<T, Failure> {
    let error = |message: String| Failure::Json {
        path: path.to_owned(),
        message,
        expected,
    };
    let text = crate::document::text::read(path, MOST_JSON)
        .map_err(|e| error(format!("cannot be read ({e})")))?;
    serde_json::from_str(&text).map_err(|e| error(format!("is not such a file ({e})")))
}
