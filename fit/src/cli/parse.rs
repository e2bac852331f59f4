//! How arguments are read: numbers, lists of them, JSON files, threads.

use std::num::NonZeroUsize;
use std::path::Path;

use crate::cli::failure::Failure;
use crate::photographs::photo::transfer::Transfer;

/// A list of numbers: `0,5,10` or `start:stop:step`, both ends included.
///
/// # Errors
/// A sentence for clap, naming what is wrong.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    const MOST: f64 = 100_000.0;
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!(
            "\"{part}\" is not a number; write 0,5,10 or start:stop:step"
        )),
    };
    let list = if text.contains(':') {
        let parts: Vec<f64> = text.split(':').map(number).collect::<Result<_, _>>()?;
        let [start, stop, step] = parts[..] else {
            return Err("a range has three parts, start:stop:step".into());
        };
        let count = ((stop - start) / step + 1e-9).floor();
        if !(step > 0.0 && (0.0..MOST).contains(&count)) {
            return Err(
                "a range needs stop >= start and a step > 0 (at most 100000 values)".into(),
            );
        }
        (0..=count as usize)
            .map(|i| start + i as f64 * step)
            .collect()
    } else {
        text.split(',')
            .map(number)
            .collect::<Result<Vec<f64>, _>>()?
    };
    Ok(list)
}

/// `0 <= incidence < 90`, every one.
///
/// # Errors
/// A sentence for clap.
pub fn incidences(text: &str) -> Result<Vec<f64>, String> {
    let list = numbers(text)?;
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
    let list = numbers(text)?;
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

/// A thread pool of the size asked for; `None` for the default, one thread per core.
///
/// # Errors
/// [`Failure::Threads`].
pub fn pool(threads: Option<NonZeroUsize>) -> Result<rayon::ThreadPool, Failure> {
    let threads = threads.map_or(0, NonZeroUsize::get);
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| Failure::Threads {
            threads,
            message: e.to_string(),
        })
}
