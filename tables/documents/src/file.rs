//! Opening and reading of files that come from strangers, or whose names do.

use std::fs::{File, Metadata, metadata};
use std::io::{self, Read};
use std::path::Path;

/// Opens a regular file for reading.
///
/// # Errors
/// Returns an error for a folder, a pipe and a device, which could be waited for without end, and
/// the errors of opening a file.
pub fn open(path: &Path) -> io::Result<File> {
    // Opening a pipe would wait already. The name may lead elsewhere a moment later.
    regular(&metadata(path)?)?;
    let file = File::open(path)?;
    regular(&file.metadata()?)?;
    Ok(file)
}

fn regular(found: &Metadata) -> io::Result<()> {
    let why = match (found.is_file(), found.is_dir()) {
        (true, _) => return Ok(()),
        (false, true) => "it is a folder; name a file in it",
        (false, false) => "it is a pipe or a device, not a regular file",
    };
    Err(io::Error::new(io::ErrorKind::InvalidInput, why))
}

/// Reads a text file of at most `most` bytes. The limit exists because a parser takes many times
/// the memory of the text that it parses.
///
/// # Errors
/// Returns the error of the system if the file cannot be opened or read, one of kind `InvalidData`
/// if it is not UTF-8, and one of kind `FileTooLarge` if it is longer.
pub fn read(file: &Path, most: u64) -> io::Result<String> {
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
