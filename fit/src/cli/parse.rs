//! Readers of arguments: numbers, lists of numbers, JSON files.

use std::path::Path;

use tables::cli::list;

use crate::cli::failure::Failure;
use crate::document::Bounds;
use crate::photographs::photo::transfer::Transfer;
use crate::result::ResultFile;

/// Reads a list of incidence angles, degrees.
///
/// # Errors
/// Returns a message for clap if `text` is no list, or if an angle is not in 0 <= angle < 90.
pub(crate) fn incidences(text: &str) -> Result<Vec<f64>, String> {
    let list = list(text).map_err(|error| error.to_string())?;
    match list.iter().find(|v| !(0.0..90.0).contains(*v)) {
        Some(bad) => Err(format!(
            "the incidence {bad} is not in 0 <= angle < 90 degrees"
        )),
        None => Ok(list),
    }
}

/// Reads one incidence, degrees.
///
/// # Errors
/// Returns a message for clap if `text` is no number in 0 <= angle < 90.
pub(crate) fn incidence(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..90.0).contains(&value) => Ok(value),
        _ => Err("must be an angle in 0 <= angle < 90 degrees".into()),
    }
}

/// Returns the azimuth of a table that holds only one, degrees; `None` for other tables.
pub(crate) fn only_azimuth(table: &tables::Table) -> Option<f64> {
    match table.axes.azimuth_deg[..] {
        [azimuth] if !azimuth.is_nan() => Some(azimuth),
        _ => None,
    }
}

/// Returns the azimuth of light that nobody named: that of the table if it holds one, and 0 for a
/// nominal sheet.
pub(crate) fn usual_azimuth(table: &tables::Table, result: &ResultFile) -> Option<f64> {
    let all_around = result.is_nominal() && !table.axes.is_mean();
    only_azimuth(table).or(all_around.then_some(0.0))
}

/// Reads a list of numbers above 0.
///
/// # Errors
/// Returns a message for clap if `text` is no list, or if a number is out of range.
pub(crate) fn positives(text: &str) -> Result<Vec<f64>, String> {
    within_all(text, Bounds::POSITIVE)
}

/// Reads a list of numbers within bounds.
fn within_all(text: &str, bounds: Bounds) -> Result<Vec<f64>, String> {
    let list = list(text).map_err(|error| error.to_string())?;
    match list.iter().find(|&&value| !(bounds.holds)(value)) {
        Some(bad) => Err(format!("{bad} must be {}", bounds.words)),
        None => Ok(list),
    }
}

/// Reads one number within bounds; NaN and infinity are within none.
fn within(text: &str, bounds: Bounds) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && (bounds.holds)(value) => Ok(value),
        Ok(_) => Err(format!("must be {}", bounds.words)),
        Err(_) => Err(format!("must be a number without a unit, {}", bounds.words)),
    }
}

/// Reads one number above 0.
///
/// # Errors
/// Returns a message for clap if `text` is no such number.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    within(text, Bounds::POSITIVE)
}

/// Reads a share of a whole, above 0 and at most 1.
///
/// # Errors
/// Returns a message for clap if `text` is no such number.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    within(text, Bounds::SHARE)
}

/// Reads one number that is 0 or larger.
///
/// # Errors
/// Returns a message for clap if `text` is no such number.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    within(text, Bounds::NOT_NEGATIVE)
}

/// Reads an angle of a turn, degrees.
///
/// # Errors
/// Returns a message for clap if `text` is no angle from -360 to 360.
pub(crate) fn turn(text: &str) -> Result<f64, String> {
    within(text, Bounds::TURN)
}

/// Reads a list of angles of a turn, degrees.
///
/// # Errors
/// Returns a message for clap if `text` is no list, or if an angle is not from -360 to 360.
pub(crate) fn turns(text: &str) -> Result<Vec<f64>, String> {
    within_all(text, Bounds::TURN)
}

/// Reads the transfer function of stored integers: linear or srgb.
///
/// # Errors
/// Returns a message for clap if `text` is another word.
pub(crate) fn transfer(text: &str) -> Result<Transfer, String> {
    let names = Transfer::NAMES.join(" or ");
    Transfer::from_name(text).ok_or_else(|| format!("must be {names}"))
}

/// Size of the longest JSON file that is read, bytes: a hundred times the result of a thousand
/// photographs.
const MOST_JSON: u64 = 1 << 25;

/// Reads a JSON file.
///
/// # Errors
/// Returns [`Failure::Json`] if the file cannot be read or is of another kind.
pub(crate) fn read_json<T: serde::de::DeserializeOwned>(
    path: &Path,
    expected: &'static str,
) -> Result<T, Failure> {
    let error = |message: String| Failure::Json {
        path: path.to_owned(),
        message,
        expected,
    };
    let text = crate::document::read(path, MOST_JSON)
        .map_err(|e| error(format!("cannot be read ({e})")))?;
    serde_json::from_str(&text).map_err(|e| error(format!("cannot be used ({e})")))
}
