//! The text of a TOML file, the places in it, and its errors in the words of a user.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;

/// A line of a file.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct FileLine {
    /// Path of the file.
    pub file: PathBuf,
    /// Number of the line, from 1; 0 for the file as a whole.
    pub line: usize,
}

impl FileLine {
    /// Makes an error at this place. The message says what is wrong and what to do.
    pub fn error(self, message: impl Into<String>) -> Error {
        Error {
            place: self,
            message: message.into(),
        }
    }
}

impl std::fmt::Display for FileLine {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}", self.file.display())?;
        match self.line {
            0 => Ok(()),
            line => write!(formatter, ":{line}"),
        }
    }
}

/// A reason why a TOML file, or what a line of it names, cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {message}")]
pub struct Error {
    place: FileLine,
    message: String,
}

/// Text of a TOML file, with the path that it was read from.
#[derive(Debug)]
pub struct Document {
    file: PathBuf,
    text: String,
    /// Offsets of the line feeds, ascending.
    feeds: Vec<usize>,
}

/// Size of the longest TOML file that is read, bytes: ten times that of a thousand photographs.
const MOST_BYTES: u64 = 1 << 20;

impl Document {
    /// Reads a TOML file into memory.
    ///
    /// # Errors
    /// Returns an error if the file cannot be opened or read, is not UTF-8, or is longer than
    /// 1 MiB.
    pub fn read(file: &Path) -> Result<Document, Error> {
        match crate::read(file, MOST_BYTES) {
            Ok(text) => Ok(Document::new(file, text)),
            Err(why) => Err(Document::new(file, String::new()).error(format!(
                "cannot be read ({why}); check the path, its permissions and that it is UTF-8 text"
            ))),
        }
    }

    /// Makes the document of a text in memory; `file` is its name for messages.
    pub fn new(file: &Path, text: String) -> Document {
        Document {
            file: file.to_owned(),
            feeds: text.match_indices('\n').map(|(offset, _)| offset).collect(),
            text,
        }
    }

    /// Parses the text of the document as TOML and reads it into a struct.
    ///
    /// # Errors
    /// Returns an error with the line of the first fault: text that is not valid TOML (a duplicate
    /// key is one of these), or a key that is unknown, missing, of the wrong type or out of range.
    pub fn parse<'d, T: Deserialize<'d>>(&'d self) -> Result<T, Error> {
        let parsed = toml::Deserializer::parse(&self.text).map_err(|error| {
            let why = error.message().replace('\n', ", ");
            self.place(error.span().unwrap_or_default())
                .error(format!("is not valid TOML ({why}); correct the line"))
        })?;
        T::deserialize(parsed).map_err(|error| self.explained(error))
    }

    /// Returns the line where a part of the text begins.
    pub fn place(&self, part: Range<usize>) -> FileLine {
        FileLine {
            file: self.file.clone(),
            line: 1 + self.feeds.partition_point(|&feed| feed < part.start),
        }
    }

    /// Makes an error of the file as a whole.
    pub fn error(&self, message: impl Into<String>) -> Error {
        let file = self.file.clone();
        FileLine { file, line: 0 }.error(message)
    }

    /// Makes the error of a key that the table at `part` of the text needs.
    pub fn missing(&self, part: Range<usize>, key: &str, table: &str) -> Error {
        self.place(part)
            .error(format!("`{key}` is missing from {table}; add it"))
    }

    /// Says in a sentence what serde says in its own terms.
    fn explained(&self, mut error: toml::de::Error) -> Error {
        let part = error.span().unwrap_or_default();
        // Without the text, the error is shown as its message and the path of the key or table.
        error.set_input(None);
        let shown = error.to_string();
        let path = shown.rsplit_once("\nin `").map_or("", |(_, path)| path);
        let path = path.trim_end().trim_end_matches('`');
        let key = path.rsplit('.').next().unwrap_or(path);
        let table = match path {
            "" => "the top level".to_owned(),
            path => format!("[{path}]"),
        };
        // Errors of values in arrays come as the whole text of another error, with its line feed.
        let said = error.message().trim_end();
        let (fault, expected) = said.rsplit_once(", expected ").unwrap_or((said, ""));
        let (kind, found) = match fault.split_once([':', '`']) {
            Some(("invalid type", found)) if found.ends_with("128") => ("invalid value", found),
            Some(parts) => parts,
            None => (fault, ""),
        };
        let place = self.place(part.clone());
        match kind {
            "unknown field " => {
                // The part is the key.
                let key = self.text[part].trim_matches(['"', '\'']);
                let known = expected.split('`').skip(1).step_by(2);
                let nearest = known.min_by_key(|name| strsim::damerau_levenshtein(name, key));
                place.error(format!(
                    "unknown key `{key}` in {table}; the nearest valid key is `{}`",
                    nearest.unwrap_or_default()
                ))
            }
            "missing field " => self.missing(part, found.trim_end_matches('`'), &table),
            // TOML has no duplicate keys, so one of the two is an alias. The part is the table.
            "duplicate field " => {
                let name = found.trim_end_matches('`');
                let at = self.text[part.start..].find(&format!("\n{name}"));
                let start = at.map_or(part.start, |at| part.start + at + 1);
                self.place(start..start).error(format!(
                    "`{name}` is given twice in {table}, once by its old name; remove one of them"
                ))
            }
            // Integers beyond 64 bits; the words depend on the type that is read.
            "integer number overflowed" | "u64 value was too large" | "invalid value" => {
                place.error(format!("`{key}` is too large; correct the value"))
            }
            "invalid type" => {
                let found = [
                    ("string", "a string"),
                    ("integer", "a whole number"),
                    ("floating", "a number"),
                    ("boolean", "true or false"),
                    ("sequence", "an array"),
                    ("map", "a table"),
                ]
                .into_iter()
                .find_map(|(word, name)| found.trim_start().starts_with(word).then_some(name))
                .unwrap_or("this");
                let expected = match expected {
                    "f64" => "a number",
                    "i64" => "a whole number",
                    "a boolean" => "true or false",
                    "a sequence" if found == "a table" => {
                        &format!("an array, in brackets or as tables under [[{key}]]")
                    }
                    "a sequence" => "an array",
                    other => other,
                };
                place.error(format!(
                    "`{key}` must be {expected}, not {found}; change the value"
                ))
            }
            _ => place.error(format!("`{key}` {said}")),
        }
    }
}
