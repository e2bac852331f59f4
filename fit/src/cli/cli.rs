//! What the verbs share: why they end, what they print and reserve, how arguments are read.

use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use tables::{Output, OutputError, Outputs};

use crate::estimate::error as estimate;
use crate::estimate::scene;
#[cfg(feature = "images")]
use crate::images::{metrics, render};
use crate::model::kernel::Family;
use crate::photographs::{captures, edge, photo};
use crate::predict::error as predict;
#[cfg(feature = "report")]
use crate::report::plot;
use crate::simulate::photograph as simulate;

/// Anything that ends a verb.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// The manifest.
    #[error(transparent)]
    Captures(#[from] captures::Error),
    /// A photograph.
    #[error(transparent)]
    Photo(#[from] photo::Error),
    /// The scene.
    #[error(transparent)]
    Scene(#[from] scene::Error),
    /// The table.
    #[error(transparent)]
    Table(#[from] tables::Error),
    /// The estimate.
    #[error(transparent)]
    Estimate(#[from] estimate::Error),
    /// The result is of another model than the one that was named.
    #[error("{}: is the fit of another model; fit this one: fit estimate captures.toml --table table.h5 --model {} -o result.json",
        path.display(), asked.name())]
    Model {
        /// The result.
        path: PathBuf,
        /// The model named.
        asked: Family,
    },
    /// The prediction.
    #[error(transparent)]
    Predict(#[from] predict::Error),
    /// The comparison.
    #[cfg(feature = "images")]
    #[error(transparent)]
    Evaluate(#[from] metrics::error::Error),
    /// The mid-air image.
    #[cfg(feature = "images")]
    #[error(transparent)]
    Render(#[from] render::Error),
    /// The simulation.
    #[error(transparent)]
    Simulate(#[from] simulate::Error),
    /// An output.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A picture.
    #[cfg(feature = "report")]
    #[error(transparent)]
    Plot(#[from] plot::Error),
    /// No edge.
    #[error("{}: {fault}", image.display())]
    Edge {
        /// The photograph.
        image: PathBuf,
        /// What is wrong.
        fault: edge::Fault,
    },
    /// A region outside of the photograph.
    #[error("{}: --roi {},{},{},{} does not lie in the picture ({width} x {height}); give x,y,width,height in pixels",
        image.display(), roi.x, roi.y, roi.width, roi.height)]
    Roi {
        /// The photograph.
        image: PathBuf,
        /// The region.
        roi: captures::Roi,
        /// Width of the picture.
        width: usize,
        /// Height of the picture.
        height: usize,
    },
    /// A JSON file that is none, or another.
    #[error("{}: {message}; give a file that {expected}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What the parser said.
        message: String,
        /// What writes such files.
        expected: &'static str,
    },
    /// A result of several channels, of which one must be named.
    #[error("{}: holds one result for each of the channels {held}; name one with --channel", path.display())]
    Channel {
        /// The file.
        path: PathBuf,
        /// Names of its channels.
        held: String,
    },
    /// A table of another cell than the ranges name.
    #[error("{}: is not the table of the ideal cell that is simulated; bake it: bake design {design} -o cell.obj, then \
             bake trace cell.obj --refractive-index {ior} --incidence 0:45:15 --azimuth 30", table.display())]
    OtherCell {
        /// The table.
        table: PathBuf,
        /// Refractive index of the cell.
        ior: f64,
        /// Its design.
        design: &'static str,
    },
    /// The azimuth cannot be told by such a table.
    #[error("--fit-azimuth: {} says nothing of other azimuths ({held}); bake them all: bake trace --azimuth full \
             --direction-tolerance 0.005", table.display())]
    OneAzimuth {
        /// The table.
        table: PathBuf,
        /// What it holds.
        held: &'static str,
    },
    /// Standard output is closed or full.
    #[error("standard output cannot be written ({0}); check the pipe, or use -o")]
    Stdout(std::io::Error),
    /// Threads could not be started.
    #[error("--threads {threads}: the threads could not be started ({message}); ask for fewer")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// What the library said.
        message: String,
    },
}

impl Failure {
    /// 2 for wrong usage that clap cannot see, 1 for work that failed.
    pub fn code(&self) -> u8 {
        match self {
            #[cfg(feature = "report")]
            Failure::Plot(plot::Error::Ending { .. }) => 2,
            #[cfg(feature = "images")]
            Failure::Render(render::Error::Ending { .. }) => 2,
            _ => 1,
        }
    }
}

/// Prints to standard output.
///
/// # Errors
/// [`Failure::Stdout`].
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(Failure::Stdout)
}

/// Writes a verb's text to the file that was reserved for it, or to standard output.
///
/// # Errors
/// [`Failure::Output`], [`Failure::Stdout`].
pub fn deliver(text: &str, output: Option<Output>) -> Result<(), Failure> {
    match output {
        Some(output) => Ok(output.commit(text.as_bytes())?),
        None => print(text),
    }
}

/// Reserves the file that was asked for.
///
/// # Errors
/// [`Failure::Output`].
pub fn reserve(path: Option<&Path>, outputs: &mut Outputs) -> Result<Option<Output>, Failure> {
    Ok(path.map(|path| outputs.reserve(path)).transpose()?)
}

/// Reserves the picture that was asked for; its ending is checked first.
///
/// # Errors
/// [`Failure::Plot`], [`Failure::Output`].
#[cfg(feature = "report")]
pub fn reserve_picture<'a>(
    path: Option<&'a Path>,
    outputs: &mut Outputs,
) -> Result<Option<(&'a Path, Output)>, Failure> {
    let Some(path) = path else { return Ok(None) };
    plot::Format::of(path)?;
    Ok(Some((path, outputs.reserve(path)?)))
}

/// Prints a warning to standard error.
pub fn warn(text: &str) {
    let _ = writeln!(std::io::stderr(), "warning: {text}");
}

/// An object as JSON text, keys in the order of the struct.
pub fn json(object: &impl serde::Serialize) -> String {
    let text = serde_json::to_string_pretty(object)
        .expect("all keys are strings and all values are numbers or text");
    text + "\n"
}

/// A command line as a shell would take it again; the program without its folder.
pub fn command_line(arguments: impl IntoIterator<Item = OsString>) -> String {
    let quoted = |text: String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
        if !text.is_empty() && text.chars().all(plain) {
            text
        } else {
            format!("'{}'", text.replace('\'', "'\\''"))
        }
    };
    let mut arguments = arguments.into_iter();
    let program = PathBuf::from(arguments.next().unwrap_or_default());
    let program = program.file_name().map(OsString::from);
    let words = program.into_iter().chain(arguments);
    let words: Vec<String> = words
        .map(|word| quoted(word.to_string_lossy().into_owned()))
        .collect();
    words.join(" ")
}

/// Prints a remark to standard error where a person reads it; a pipe stays quiet.
pub fn note(text: &str) {
    let mut stderr = std::io::stderr();
    if stderr.is_terminal() {
        let _ = writeln!(stderr, "{text}");
    }
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
    let text = crate::photographs::captures::text::read(path, MOST_JSON)
        .map_err(|e| error(format!("cannot be read ({e})")))?;
    serde_json::from_str(&text).map_err(|e| error(format!("is not such a file ({e})")))
}

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
pub fn transfer(text: &str) -> Result<photo::Transfer, String> {
    let names = photo::Transfer::NAMES.join(" or ");
    photo::Transfer::from_name(text).ok_or_else(|| format!("must be {names}"))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_line_can_be_pasted() {
        let words = [
            "/usr/bin/fit",
            "estimate",
            "my sheet.toml",
            "it's",
            "",
            "--table=a.h5",
        ];
        assert_eq!(
            command_line(words.map(OsString::from)),
            r"fit estimate 'my sheet.toml' 'it'\''s' '' --table=a.h5"
        );
    }
}
