//! Texts of limited length: a parser takes many times the memory of what it parses.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Reads a text of at most `most` bytes.
///
/// # Errors
/// The system does not give it, it is not UTF-8, or it is longer.
pub(crate) fn read(file: &Path, most: u64) -> io::Result<String> {
    let mut text = String::new();
    let read = File::open(file)?.take(most + 1).read_to_string(&mut text)?;
    if read as u64 > most {
        let what = format!("it is longer than {most} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, what));
    }
    Ok(text)
}
