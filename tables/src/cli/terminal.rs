//! Results to standard output or a file, warnings and remarks to standard error.

use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;

use crate::cli::error::Error;
use crate::cli::plot_format::PlotFormat;
use crate::file::output::{Output, Outputs};

/// Prints a result to standard output. A pipe that was closed (`... | head`) is its reader's wish
/// and no error.
///
/// # Errors
/// [`Error::Stdout`] when the disk behind it is full, for example.
pub fn print(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::Stdout(error)),
        _ => Ok(()),
    }
}

/// Writes a result to the file that was reserved for it, or prints it where none was asked for.
///
/// # Errors
/// [`Error::Stdout`] or [`Error::Output`].
pub fn deliver(text: &str, output: Option<Output>) -> Result<(), Error> {
    match output {
        Some(output) => Ok(output.commit(text.as_bytes())?),
        None => print(text),
    }
}

/// Prints each warning as a line `warning: ...` to standard error. A closed standard error is
/// ignored.
pub fn warn<W: Display>(warnings: impl IntoIterator<Item = W>) {
    for warning in warnings {
        let _ = writeln!(std::io::stderr(), "warning: {warning}");
    }
}

/// Prints a remark to standard error where a person reads it; a pipe stays quiet.
pub fn note(remark: impl Display) {
    let mut stderr = std::io::stderr();
    if stderr.is_terminal() {
        let _ = writeln!(stderr, "{remark}");
    }
}

/// Reserves the file that was asked for, if any.
///
/// # Errors
/// [`Error::Output`].
pub fn reserve(file: Option<&Path>, outputs: &mut Outputs) -> Result<Option<Output>, Error> {
    Ok(file.map(|file| outputs.reserve(file)).transpose()?)
}

/// Reserves the file of the plot that was asked for, if any. Its extension is checked first.
///
/// # Errors
/// [`Error::PlotExtension`] or [`Error::Output`].
pub fn reserve_plot<'a>(
    file: Option<&'a Path>,
    outputs: &mut Outputs,
) -> Result<Option<(&'a Path, Output)>, Error> {
    let Some(file) = file else { return Ok(None) };
    PlotFormat::of(file)?;
    Ok(Some((file, outputs.reserve(file)?)))
}
