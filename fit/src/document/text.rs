//! Reading of texts of limited length. The limit exists because a parser takes many times the
//! memory of the text that it parses.

use std::io::{self, Read};
use std::path::Path;

use crate::document::regular::open;

/// Reads a text file of at most `most` bytes.
///
/// # Errors
/// Returns the error of the system if the file cannot be opened or read, one of kind `InvalidData`
/// if it is not UTF-8, and one of kind `FileTooLarge` if it is longer.
pub(crate) fn read(file: &Path, most: u64) -> io::Result<String> {
    let mut text = String::new();
    let read = open(file)?
        .take(most + 1)
        .read_to_string(&mut text)
        .map_err(|error| match error.kind() {
            io::ErrorKind::InvalidData => io::Error::new(error.kind(), "it is no text in UTF-8"),
            _ => error,
        })?;
    if read as u64 > most {
        let what = format!("it is longer than {most} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, what));
    }
    Ok(text)
}
