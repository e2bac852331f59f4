//! Commands of the pages: those in blocks marked `sh` run as printed, in the order of the page, and
//! print what the block marked `text` after them shows.

use std::path::Path;
use std::process::Command;

use tempfile::TempDir;
use tests::files::project;
use tests::page::{blocks, missing};
use tests::program::{on_terminal, python, run};

/// Pages whose commands are run, in this order, after README.md. They read files that it writes.
const PAGES: [&str; 17] = [
    "doc/README.md",
    "doc/cells.md",
    "doc/photographs.md",
    "doc/estimate.md",
    "doc/predict.md",
    "doc/light.md",
    "doc/which.md",
    "doc/maker.md",
    "doc/tables.md",
    "doc/python.md",
    "doc/compare.md",
    "bake/doc/losses.md",
    "bake/doc/imperfect.md",
    "bake/doc/curved.md",
    "fit/doc/mtf.md",
    "fit/doc/render.md",
    "fit/doc/baselines.md",
];

/// Runs the commands of a page, and compares what they print with the page.
///
/// Returns the numbers of commands and of lines that the page shows. The folder `here` has links to
/// the folders of the project that the commands use.
fn run_page(page: &str, here: &Path) -> [usize; 2] {
    let text = std::fs::read_to_string(project().join(page)).unwrap();
    let (mut ran, mut compared, mut other) = (0, 0, Vec::new());
    for block in blocks(&text) {
        let mut printed = String::new();
        for words in &block.commands {
            let (program, arguments) = words.split_first().unwrap();
            ran += 1;
            if program == "python3" {
                run_python(page, here, arguments);
                continue;
            }
            // `fit mtf` shows its summary on a terminal only.
            let run = match program == "fit" && arguments[0] == "mtf" {
                true => on_terminal(program, here, arguments),
                false => run(program, here, arguments),
            };
            assert_eq!(run.code, Some(0), "{page}: {}\n{}", run.line, run.err);
            printed += &run.out;
        }
        if let Some(line) = missing(&block.printed, &printed) {
            other.push(format!("{line}\n{printed}"));
        }
        compared += block.printed.len();
    }
    let other = other.join("\n");
    assert!(
        other.is_empty(),
        "{page} shows lines that are not printed:\n{other}"
    );
    [ran, compared]
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

/// Makes a folder in which the commands of README.md and of the pages find their files, and runs
/// README.md in it.
fn after_readme() -> (TempDir, [usize; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for name in ["tests", "fit", "bake", "doc", "tables"] {
        std::os::unix::fs::symlink(project().join(name), here.join(name)).unwrap();
    }
    let counts = run_page("README.md", here);
    (folder, counts)
}

#[test]
fn readme_runs_and_prints_as_shown() {
    let (_, [ran, compared]) = after_readme();
    assert_eq!(ran, 9, "README has nine commands");
    println!("{ran} commands of README.md, {compared} lines that they print");
    assert!(compared >= 6, "{compared} lines");
}

#[test]
#[ignore = "two minutes: `make test-pages` runs it"]
fn every_page_runs_and_prints_as_shown() {
    let (folder, [mut ran, mut compared]) = after_readme();
    for page in PAGES {
        // A page overwrites only files that it wrote itself. So sheet.h5 and result.json of README
        // stay unchanged.
        let of_page = run_page(page, folder.path());
        assert!(of_page[0] > 0, "{page}: no command was found");
        ran += of_page[0];
        compared += of_page[1];
    }
    println!(
        "{ran} commands of {} pages, {compared} lines that they print",
        1 + PAGES.len()
    );
    assert!(compared >= 20, "{compared} lines");
}

#[test]
fn wrong_lines_of_a_page_are_noticed() {
    let printed =
        "t.h5: 10 directions in 0.0033 s\nc (mm)    0.24002  0.00028\nmu  0.520  4.1e-5\n";
    let cases = [
        ("t.h5: 10 directions in 0.2 s", true),
        ("t.h5: 11 directions in 0.0033 s", false),
        ("c (mm) 0.24002 0.00028", true),
        ("c (mm) 0.240 ...", true),
        ("c (mm) 0.24002 0.00029", false),
        ("c (mm) 0.24002 0.000280", false),
        ("c (mm) 0.24002", false),
        ("a (mm) 0.24002 0.00028", false),
        ("mu 0.52 4.1e-5", true),
        ("mu 0.52 4.2e-5", false),
    ];
    for (line, is_right) in cases {
        let page = format!("```sh\nfit x\n```\n\n```text\n...\n{line}\n```\n");
        let block = blocks(&page).remove(0);
        assert_eq!(block.commands, [["fit", "x"]]);
        assert_eq!(
            missing(&block.printed, printed).is_none(),
            is_right,
            "{line}"
        );
    }
    // Lines in another order than they are printed.
    let swapped = ["mu 0.52 4.1e-5", "c (mm) 0.24 0.00028"].map(String::from);
    assert_eq!(missing(&swapped, printed), Some("c (mm) 0.24 0.00028"));
}
