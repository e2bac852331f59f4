//! Text that verbs write: objects as JSON, and the command line as a shell reads it.

use std::ffi::OsString;
use std::path::PathBuf;

/// Returns an object as JSON text, with the keys in the order of the struct.
pub(crate) fn json(object: &impl serde::Serialize) -> String {
    let text = serde_json::to_string_pretty(object)
        .expect("all keys are strings and all values are numbers or text");
    text + "\n"
}

/// Returns a command line that can be pasted into a shell, with the program's folder left out.
pub(crate) fn command_line(arguments: impl IntoIterator<Item = OsString>) -> String {
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
