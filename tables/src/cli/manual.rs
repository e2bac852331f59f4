//! What a shell and a reader of manual pages want of a program: its version, completions and pages, from clap's description.

use std::path::Path;

use clap::Command;
use clap_complete::Shell;

use crate::cli::Error;
use crate::file::output::Outputs;

/// The text behind `--version`: `version`, and the commit that a build was told of.
pub fn version(version: &str, commit: Option<&str>) -> String {
    match commit.filter(|commit| !commit.is_empty()) {
        Some(commit) => format!("{version} ({commit})"),
        None => version.to_owned(),
    }
}

/// Returns the completions of a program for a shell, to be put where that shell looks for them.
pub fn completions(mut program: Command, shell: Shell) -> String {
    let name = program.get_name().to_owned();
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut program, name, &mut text);
    String::from_utf8_lossy(&text).into_owned()
}

/// Writes the manual pages of a program into a folder that exists: one for itself, one for each verb. Returns their names.
///
/// # Errors
/// [`Error::Output`] when a page cannot be written; [`Error::Stdout`] never.
pub fn manual(mut program: Command, folder: &Path) -> Result<Vec<String>, Error> {
    // Gives every verb its full name (`bake trace`), which its page shows.
    program.build();
    let mut outputs = Outputs::beside([]);
    let mut pages = Vec::new();
    let own = program.get_name().to_owned();
    let verbs = program.get_subcommands().cloned();
    for page in std::iter::once(program.clone()).chain(verbs) {
        if page.get_name() == "help" {
            continue;
        }
        let name = match page.get_name() {
            verb if verb != own => format!("{own}-{verb}.1"),
            _ => format!("{own}.1"),
        };
        let mut text = Vec::new();
        clap_mangen::Man::new(page)
            .render(&mut text)
            .map_err(Error::Stdout)?;
        pages.push((outputs.reserve(&folder.join(&name))?, text, name));
    }
    let write = |(output, text, name): (crate::file::output::Output, Vec<u8>, String)| {
        output.commit(&text)?;
        Ok(name)
    };
    pages.into_iter().map(write).collect()
}
