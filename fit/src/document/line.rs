//! A place in a file, for messages.

use std::path::PathBuf;

/// A line of a TOML file.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct FileLine {
    /// Path of the file.
    pub file: PathBuf,
    /// Number of the line, from 1.
    pub line: usize,
}

impl std::fmt::Display for FileLine {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}:{}", self.file.display(), self.line)
    }
}
