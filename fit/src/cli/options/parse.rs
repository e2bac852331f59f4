//! Readers of arguments: numbers, lists of numbers, JSON files.

use std::path::Path;

use tables::cli::list;

use crate::cli::failure::Failure;
use edges::document::Bounds;
use edges::photographs::photo::transfer::Transfer;
use estimator::result::ResultFile;

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

/// Defines readers of options, which return a message for clap.
macro_rules! readers {
    ($($name:ident: $value:ty = $within:ident($bounds:expr);)*) => {
        $(pub(crate) fn $name(text: &str) -> Result<$value, String> {
            $within(text, $bounds)
        })*
    };
}

readers! {
    positive: f64 = within(Bounds::POSITIVE);
    positives: Vec<f64> = within_all(Bounds::POSITIVE);
    share: f64 = within(Bounds::SHARE);
    not_negative: f64 = within(Bounds::NOT_NEGATIVE);
    not_negatives: Vec<f64> = within_all(Bounds::NOT_NEGATIVE);
    incidence: f64 = within(Bounds::INCIDENCE);
    incidences: Vec<f64> = within_all(Bounds::INCIDENCE);
    turn: f64 = within(Bounds::TURN);
    turns: Vec<f64> = within_all(Bounds::TURN);
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
    let text = edges::document::read(path, MOST_JSON)
        .map_err(|e| error(format!("cannot be read ({e})")))?;
    serde_json::from_str(&text).map_err(|e| error(format!("cannot be used ({e})")))
}
