//! Commands of the pages: those in blocks marked `sh` run as printed, in the order of the page.

use std::path::Path;
use std::process::Command;

use tests::files::project;
use tests::page::commands;
use tests::program::{python, run};

/// Pages whose commands are run, in this order, after README.md. They read files that it writes.
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

/// Runs the commands of a page and returns their number.
///
/// The folder `here` has links to the folders of the project that the commands use.
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

/// Runs a Python command of a page with the interpreter of the tests, which has h5py.
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
    assert_eq!(ran, 9, "README has nine commands");
    for page in PAGES {
        // A page overwrites only files that it wrote itself. So sheet.h5 and result.json of README
        // stay unchanged.
        let of_page = run_page(page, here);
        assert!(of_page > 0, "{page}: no command was found");
        ran += of_page;
    }
    println!("{ran} commands of {} pages", 1 + PAGES.len());
}
