//! Nominal sheets: the tables that are part of `fit`, and its verbs with them.

use tests::files::{argument, project};
use tests::page::commands;
use tests::program::{fit, run};

/// The tables of the nominal sheets are those that the commands of their page make, byte for byte.
#[test]
fn the_tables_of_the_sheets_are_baked_again() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sheets = project().join("fit/sheets");
    let page = std::fs::read_to_string(sheets.join("README.md")).unwrap();
    let mut ran = 0;
    for words in commands(&page) {
        let (program, arguments) = words.split_first().unwrap();
        run(program, here, arguments).done();
        ran += 1;
    }
    assert_eq!(ran, 4);
    let mut compared = 0;
    for entry in std::fs::read_dir(&sheets).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|ending| ending == "h5") {
            let made = std::fs::read(here.join(file.file_name().unwrap())).unwrap();
            assert!(made == std::fs::read(&file).unwrap(), "{}", file.display());
            compared += 1;
        }
    }
    assert_eq!(compared, 2);
}

/// A picture needs one command: no mesh, no table, no result. The help names all sheets.
#[test]
fn a_picture_needs_one_command() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sign = argument("doc/sign.png");
    let help = fit(here, &["render", "--help"]).done();
    let names = ["prism-0.1", "prism-0.2", "hollow-0.2", "published"];
    for name in names {
        assert!(help.contains(&format!("- {name}:")), "{name} in the help");
        let words = [
            "render",
            "--source",
            &sign,
            "--sheet",
            name,
            "--width",
            "200",
            "--distance",
            "1000",
            "--incidence",
            "10",
            "-o",
            "air.png",
            "--json",
        ];
        let made = fit(here, &words);
        assert!(made.err.contains("is no measured sheet"), "{}", made.err);
        assert_eq!(made.code, Some(0), "{}", made.err);
        let facts: serde_json::Value = serde_json::from_str(&made.out).unwrap();
        assert_eq!(facts["size_mm"], serde_json::json!([200.0, 150.0]));
        assert!(here.join("air.png").exists());
    }
    println!("{} sheets", names.len());
}

/// Options that contradict each other, and a table of another cell, are refused.
#[test]
fn what_is_no_sheet_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = argument("tables/tests/kept/version_1_exact.h5");
    let place = ["--distance", "300", "--incidence", "10"];
    let cases: [(&[&str], i32, &str); 5] = [
        (&["--sheet", "prism"], 2, "prism-0.1"),
        (
            &["--sheet", "prism-0.1", "--c", "0.2"],
            2,
            "cannot be used with",
        ),
        (
            &["--sheet", "prism-0.1", "--wavelength-nm", "500"],
            2,
            "cannot be used with",
        ),
        (&["--mu", "0.5"], 2, "name a sheet"),
        (
            &["--sheet", "hollow-0.2", "--table", &table],
            2,
            "--sheet hollow-0.2 is a sheet of full-cube",
        ),
    ];
    for (words, code, text) in cases {
        let all: Vec<&str> = [&["predict"], words, &place].concat();
        let refused = fit(here, &all);
        assert_eq!(refused.code, Some(code), "{words:?}: {}", refused.err);
        assert!(refused.err.contains(text), "{words:?}: {}", refused.err);
    }
    println!("{} refusals", cases.len());
}
