//! Printing: results to standard output or a file, warnings and remarks to standard error.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;

use crate::error::Error;
use crate::file::output::{Output, Outputs};

/// Returns whether a character steers a terminal, ends a line or turns the direction of writing.
fn steers(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Returns a text whose steering characters are written as escapes; those in `kept` stay.
fn escaped<'a>(text: &'a str, kept: &[char]) -> Cow<'a, str> {
    let steers = |c: char| steers(c) && !kept.contains(&c);
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match steers(c) {
            true => plain.extend(c.escape_default()),
            false => plain.push(c),
        }
    }
    Cow::Owned(plain)
}

/// Returns a text of some lines with escapes such as `\u{1b}` for the characters that steer a
/// terminal or turn the direction of writing. Line feeds and tabs stay.
fn plain(text: &str) -> Cow<'_, str> {
    escaped(text, &['\n', '\t'])
}

/// Returns a text as one line, with escapes such as `\n` for the characters that end it, steer a
/// terminal or turn the direction of writing.
///
/// Names of files, designs and keys come from strangers' files. One that is printed within a text
/// of some lines passes through here.
pub fn in_a_line(text: &str) -> Cow<'_, str> {
    escaped(text, &[])
}

/// Prints an error as a line `error: ...` to standard error.
///
/// A standard error that cannot be written is ignored.
pub fn fail(error: impl Display) {
    let error = error.to_string();
    let _ = writeln!(std::io::stderr(), "error: {}", in_a_line(&error));
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
/// Returns an [`Error`] if the file or standard output cannot be written.
pub fn deliver(text: &str, output: Option<Output>) -> Result<(), Error> {
    match output {
        Some(output) => output.commit(text.as_bytes()),
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
            in_a_line(&warning.to_string())
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
/// Returns an [`Error`] if the file cannot be written, is an input, or is named twice.
pub fn reserve(file: Option<&Path>, outputs: &mut Outputs) -> Result<Option<Output>, Error> {
    file.map(|file| outputs.reserve(file)).transpose()
}

/// Reserves the file of the plot that was asked for, if any.
///
/// # Errors
/// Returns [`Error::PlotExtension`] if the extension is not .svg, which is checked first, and
/// the errors of [`reserve`].
pub fn reserve_plot(file: Option<&Path>, outputs: &mut Outputs) -> Result<Option<Output>, Error> {
    let is_svg = |file: &Path| {
        file.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("svg"))
    };
    match file.filter(|file| !is_svg(file)) {
        Some(other) => Err(Error::PlotExtension(other.to_owned())),
        None => reserve(file, outputs),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_is_escaped() {
        let named = "a\u{1b}[2J\nerror: b\r\tc\u{9b}\u{202e}\u{2028}\u{e9}";
        let cases = [
            (
                in_a_line(named),
                "a\\u{1b}[2J\\nerror: b\\r\\tc\\u{9b}\\u{202e}\\u{2028}\u{e9}",
            ),
            (
                plain(named),
                "a\\u{1b}[2J\nerror: b\\r\tc\\u{9b}\\u{202e}\\u{2028}\u{e9}",
            ),
            (in_a_line("caf\u{e9}"), "caf\u{e9}"),
        ];
        for (found, expected) in cases {
            assert_eq!(found, expected);
        }
    }
}
