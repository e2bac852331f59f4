//! Pages that run: every command in a block marked `sh` works as printed, in the order of the page.

use std::path::Path;
use std::process::Command;

use tests::files::project;
use tests::page::commands;
use tests::program::{python, run};

/// The pages, README first: what it writes, the others read.
const PAGES: [&str; 13] = [
    "doc/README.md",
    "doc/cells.md",
    "doc/photographs.md",
    "doc/estimate.md",
    "doc/predict.md",
    "doc/tables.md",
    "doc/python.md",
    "bake/doc/losses.md",
    "bake/doc/imperfect.md",
    "bake/doc/curved.md",
    "fit/doc/mtf.md",
    "fit/doc/render.md",
    "fit/doc/baselines.md",
];

/// Runs a page in a folder that looks like the project's; returns how many commands ran.
fn run_page(page: &str, here: &Path) -> usize {
    let text = std::fs::read_to_string(project().join(page)).unwrap();
    let mut ran = 0;
    for words in commands(&text) {
        let (program, arguments) = words.split_first().unwrap();
        ran += 1;
        if program == "python3" {
            run_python(page, here, arguments);
            continue;
        }
        let run = run(program, here, arguments);
        assert_eq!(run.code, Some(0), "{page}: {}\n{}", run.line, run.err);
    }
    ran
}

/// Runs a Python command of a page by the interpreter of the tests, which has h5py.
fn run_python(page: &str, here: &Path, arguments: &[String]) {
    let run = Command::new(python())
        .args(arguments)
        .current_dir(here)
        .output()
        .unwrap_or_else(|error| panic!("python3 does not start: {error}"));
    let err = String::from_utf8_lossy(&run.stderr);
    let line = arguments.join(" ");
    assert!(run.status.success(), "{page}: python3 {line}\n{err}");
}

#[test]
fn every_page_runs_as_printed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for name in ["tests", "fit", "doc", "tables"] {
        std::os::unix::fs::symlink(project().join(name), here.join(name)).unwrap();
    }
    let mut ran = run_page("README.md", here);
    assert_eq!(ran, 5, "README has five commands");
    for page in PAGES {
        // Pages overwrite files of their own only; README's sheet.h5 and result.json stay as good.
        let of_page = run_page(page, here);
        assert!(of_page > 0, "{page}: no command was found");
        ran += of_page;
    }
    println!("{ran} commands of {} pages", 1 + PAGES.len());
}
