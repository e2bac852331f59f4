//! Version, shell completions and manual pages of a program, made from clap's description of it.

use std::path::PathBuf;

use clap::Command;
use clap_complete::Shell;

use crate::cli::terminal::print;
use crate::error::Error;
use crate::file::output::Outputs;

/// Returns the text behind `--version`: the version, and the commit if the build knew it.
pub fn version(version: &str, commit: Option<&str>) -> String {
    match commit.filter(|commit| !commit.is_empty()) {
        Some(commit) => format!("{version} ({commit})"),
        None => version.to_owned(),
    }
}

/// Prints completions for a shell
#[derive(Debug, clap::Args)]
pub struct Completions {
    /// Shell that reads the completions
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// Prints the completions of `program`.
    ///
    /// # Errors
    /// Returns [`Error::Stdout`] if standard output cannot be written.
    pub fn run(&self, mut program: Command) -> Result<(), Error> {
        let name = program.get_name().to_owned();
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut program, name, &mut text);
        print(&String::from_utf8_lossy(&text))
    }
}

/// Writes manual pages, one for the program and one for each verb
#[derive(Debug, clap::Args)]
pub struct Manual {
    /// Folder for the pages; it is made if it is missing
    folder: PathBuf,
}

impl Manual {
    /// Writes the pages of `program` and its verbs, and prints the names of the files.
    ///
    /// # Errors
    /// Returns an [`Error`] if the folder cannot be made, if a page cannot be written or rendered,
    /// or if the names cannot be printed.
    pub fn run(&self, mut program: Command) -> Result<(), Error> {
        std::fs::create_dir_all(&self.folder).map_err(|error| {
            let fault = format!("the folder cannot be made ({error})");
            Error::file(&self.folder, fault, "name a folder that can")
        })?;
        // Gives every verb its full name (`bake trace`), which its page shows.
        program.build();
        let verbs = program
            .get_subcommands()
            .filter(|verb| verb.get_name() != "help" && !verb.is_hide_set());
        let mut outputs = Outputs::beside([]);
        let mut names = String::new();
        for page in std::iter::once(&program).chain(verbs) {
            let name = page.get_display_name().unwrap_or(page.get_name());
            let file = self.folder.join(format!("{name}.1"));
            let mut text = Vec::new();
            clap_mangen::Man::new(page.clone())
                .render(&mut text)
                .map_err(Error::Stdout)?;
            outputs.reserve(&file)?.commit(&text)?;
            names += &format!("{}\n", file.display());
        }
        print(&names)
    }
}
