//! What verbs write besides tables: text on stdout, warnings on stderr, pictures.

use crate::cli::failure::Failure;
use crate::plots::Format;
use std::io::Write;
use std::path::Path;
use tables::{Output, Outputs};

/// Prints a result. A closed pipe (`bake inspect ... | head`) is the reader's wish, not a failure; a full disk is one.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::Stdout(error)),
        _ => Ok(()),
    }
}

/// Warns the user.
pub(crate) fn warn(warnings: &[String]) {
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
}

/// Reserves the picture that was asked for; its extension is checked first.
pub(crate) fn reserve_picture<'a>(
    file: Option<&'a Path>,
    outputs: &mut Outputs,
) -> Result<Option<(&'a Path, Output)>, Failure> {
    let Some(file) = file else { return Ok(None) };
    Format::of(file)?;
    Ok(Some((file, outputs.reserve(file)?)))
}
