//! What a verb says: an object as JSON, a command line as a shell takes it.

use std::ffi::OsString;
use std::path::PathBuf;

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
