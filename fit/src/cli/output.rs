//! What verbs print, and the files that they reserve.

use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use tables::{Output, Outputs};

use crate::cli::failure::Failure;
#[cfg(feature = "report")]
use crate::report::plot;

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
