//! Printing: results to standard output or a file, warnings and remarks to standard error.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;

use crate::cli::error::Error;
use crate::cli::plot_format::PlotFormat;
use crate::file::output::{Output, Outputs};

/// Returns a text without the characters that steer a terminal or turn the direction of writing.
///
/// Names of files, designs and keys come from strangers' files. Line feeds and tabs stay.
pub fn plain(text: &str) -> Cow<'_, str> {
    let steers = |c: char| {
        (c.is_control() && c != '\n' && c != '\t')
            || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if text.contains(steers) {
        Cow::Owned(text.replace(steers, "\u{fffd}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// Prints an error as a line `error: ...` to standard error.
///
/// A standard error that cannot be written is ignored.
pub fn fail(error: impl Display) {
    let _ = writeln!(std::io::stderr(), "error: {}", plain(&error.to_string()));
}

/// Prints a result to standard output.
///
/// A pipe that its reader has closed (`... | head`) is no error.
///
/// # Errors
/// Returns [`Error::Stdout`] if standard output cannot be written, for example to a full disk.
pub fn print(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    match out
        .write_all(plain(text).as_bytes())
        .and_then(|()| out.flush())
    {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::Stdout(error)),
        _ => Ok(()),
    }
}

/// Writes a result to the file that was reserved for it, or prints it if there is none.
///
/// # Errors
/// Returns [`Error::Output`] if the file cannot be written, and [`Error::Stdout`] if standard
/// output cannot be written.
pub fn deliver(text: &str, output: Option<Output>) -> Result<(), Error> {
    match output {
        Some(output) => Ok(output.commit(text.as_bytes())?),
        None => print(text),
    }
}

/// Prints each warning as a line `warning: ...` to standard error.
///
/// A standard error that cannot be written is ignored.
pub fn warn<W: Display>(warnings: impl IntoIterator<Item = W>) {
    for warning in warnings {
        let _ = writeln!(
            std::io::stderr(),
            "warning: {}",
            plain(&warning.to_string())
        );
    }
}

/// Prints a remark to standard error if it is a terminal; a pipe or a file gets nothing.
pub fn note(remark: impl Display) {
    let mut stderr = std::io::stderr();
    if stderr.is_terminal() {
        let _ = writeln!(stderr, "{}", plain(&remark.to_string()));
    }
}

/// Reserves the file that was asked for, if any.
///
/// # Errors
/// Returns [`Error::Output`] if the file cannot be written, is an input, or is named twice.
pub fn reserve(file: Option<&Path>, outputs: &mut Outputs) -> Result<Option<Output>, Error> {
    Ok(file.map(|file| outputs.reserve(file)).transpose()?)
}

/// Reserves the file of the plot that was asked for, if any.
///
/// # Errors
/// Returns [`Error::PlotExtension`] if the extension is neither .png nor .svg, which is checked
/// first, and [`Error::Output`] if the file cannot be written, is an input, or is named twice.
pub fn reserve_plot<'a>(
    file: Option<&'a Path>,
    outputs: &mut Outputs,
) -> Result<Option<(&'a Path, Output)>, Error> {
    let Some(file) = file else { return Ok(None) };
    PlotFormat::of(file)?;
    Ok(Some((file, outputs.reserve(file)?)))
}
