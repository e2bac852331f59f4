//! The program in a folder of its own. A command line is one text.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Temporary folder in which the program runs.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    /// Makes a folder with the mesh `NAME.obj` of each design.
    pub(crate) fn with(designs: &[&str]) -> Folder {
        let folder = Folder(tempfile::tempdir().expect("a temporary folder"));
        for name in designs {
            folder.good(&format!("design {name} -o {name}.obj"));
        }
        folder
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.file(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.file(name), content).expect("writes");
    }

    /// Returns the names of all files, in order.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path()).expect("lists").flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    pub(crate) fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bake"));
        command.current_dir(self.path());
        command.args(line.split_whitespace());
        command
    }

    pub(crate) fn run(&self, line: &str) -> Output {
        self.command(line).output().expect("bake runs")
    }

    /// Runs a command that succeeds and returns what it prints.
    #[track_caller]
    pub(crate) fn good(&self, line: &str) -> String {
        let output = self.run(line);
        assert!(output.status.success(), "{line}: {}", said(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Runs a command that succeeds, without a message in a pipe.
    #[track_caller]
    pub(crate) fn quiet(&self, line: &str) -> String {
        let output = self.run(line);
        assert_eq!(said(&output), "", "{line}");
        assert!(output.status.success(), "{line}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    #[track_caller]
    pub(crate) fn json(&self, line: &str) -> serde_json::Value {
        serde_json::from_str(&self.good(line)).expect("one JSON object")
    }

    /// Runs a command that fails with this code and a message that has this part.
    #[track_caller]
    pub(crate) fn refused(&self, line: &str, code: i32, part: &str) {
        let output = self.run(line);
        let message = said(&output);
        assert_eq!(output.status.code(), Some(code), "{line}: {message}");
        assert!(message.contains(part), "{line}: {part}: {message}");
    }
}

/// Returns what a run prints to standard error.
pub(crate) fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
