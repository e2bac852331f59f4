//! Nominal sheets: the tables that are part of `fit`, and its verbs with them.

use tests::files::{argument, project};
use tests::page::commands;
use tests::program::{bake, fit, run};

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
    assert_eq!(ran, 5);
    let mut compared = 0;
    for entry in std::fs::read_dir(&sheets).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|ending| ending == "h5") {
            let made = std::fs::read(here.join(file.file_name().unwrap())).unwrap();
            assert!(made == std::fs::read(&file).unwrap(), "{}", file.display());
            compared += 1;
        }
    }
    assert_eq!(compared, 3);
}

/// The luminance of the sheets is that of exact bakes at directions between those of their tables.
///
/// It is within 1 % wherever a hundredth of the light returns, of mirrors without losses. With
/// those of aluminium it is so too, except where the reflectance of hollow cubes depends on the
/// azimuth. Below a hundredth a warning says so.
#[test]
fn sheets_return_what_exact_bakes_between_their_directions_do() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // Many of these lie next to mirror planes (0, 30, 60, 120 degrees), where sides of polygons
    // end.
    let azimuths = "0.2,1.1,7.3,14.9,22.2,29.6,31.6,38.8,46.1,53.7,59.4,60.3,75.2,93.2,119.8";
    let prisms = "0,3.3,8.9,17.1,26.4,33,38.2,44.7,49.6";
    let hollow = "0,1.7,8.8,13.1,18.4,21.2,26.9,28.2,31.3,33.7,35.4,36.6,37.3,38.02,38.7,39.9";
    let sheets = [
        ("prism-0.1", "triangular-pair", "1.49", prisms),
        ("hollow-0.2", "full-cube", "1", hollow),
    ];
    let losses = "--losses fresnel --metal aluminium --wavelength-nm 550";
    let (mut compared, mut dim) = (0, 0);
    for (sheet, design, index, incidences) in sheets {
        bake(here, &format!("design {design} -o cell.obj")).done();
        let directions = format!("--incidence {incidences} --azimuth {azimuths}");
        let words = format!("trace cell.obj --refractive-index {index} --bins 8");
        let trace = |name: &str, options: &str| {
            let made = run(
                "bake",
                here,
                &format!("{words} {directions} -o {name} {options}"),
            );
            assert_eq!(made.code, Some(0), "{}", made.err);
            tables::read(&here.join(name)).unwrap()
        };
        let (ideal, lossy) = (trace("ideal.h5", ""), trace("lossy.h5", losses));
        let words = format!("predict --sheet {sheet} --distance 1000 --half-mirror 1");
        let made = fit(here, &format!("{words} {directions} --frequency 1 --json"));
        let found: serde_json::Value = serde_json::from_str(&made.out).unwrap();
        for place in found["predictions"].as_array().unwrap() {
            let number = |key: &str| place[key].as_f64().unwrap();
            let (incidence, azimuth) = (number("incidence_deg"), number("azimuth_deg"));
            let share = |table: &tables::Table| {
                table
                    .direction(incidence, Some(azimuth))
                    .unwrap()
                    .retroreflected
            };
            let (eta, lit) = (share(&ideal), share(&lossy));
            if eta < 0.01 {
                dim += 1;
                continue;
            }
            let off = number("retroreflected") / eta - 1.0;
            assert!(off.abs() < 0.01, "{sheet} {incidence} {azimuth}: {off:.4}");
            // Means over azimuths of hollow cubes, as the description of the sheet says.
            let by_azimuth = match incidence {
                _ if index != "1" => 0.0025,
                ..=25.0 => 0.002,
                ..=30.0 => 0.03,
                _ => 0.16,
            };
            let off = number("luminance") / lit - 1.0;
            let allowed = 0.01 + by_azimuth;
            assert!(
                off.abs() < allowed,
                "{sheet} {incidence} {azimuth}: {off:.4}"
            );
            compared += 1;
        }
        let warned = made.err.contains("may err by more than 1 %");
        assert_eq!(warned, sheet == "hollow-0.2", "{}", made.err);
    }
    println!("{compared} compared, {dim} below a hundredth");
    assert_eq!(compared + dim, 2 * 15 * (9 + 16));
    assert!(compared > 2 * 300);
}

/// A picture needs one command: no mesh, no table, no result. The help names all sheets.
#[test]
fn a_picture_needs_one_command() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sign = argument("doc/sign.png");
    let help = fit(here, "render --help").done();
    let names = ["prism-0.1", "prism-0.2", "hollow-0.2", "published"];
    for name in names {
        assert!(help.contains(&format!("- {name}:")), "{name} in the help");
        let words = format!(
            "render --source {sign} --sheet {name} --width 200 --distance 1000 --incidence 10 -o \
                air.png --json"
        );
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
    let place = "--distance 300 --incidence 10";
    let cases: [(&str, i32, &str); 6] = [
        ("--sheet prism", 2, "prism-0.1"),
        ("--sheet prism-0.1 --c 0.2", 2, "cannot be used with"),
        (
            "--sheet prism-0.1 --wavelength-nm 500",
            2,
            "cannot be used with",
        ),
        ("--mu 0.5", 2, "name a sheet"),
        ("--sheet prism-0.1 --frequency=-1", 2, "must be 0, or from"),
        (
            &format!("--sheet hollow-0.2 --table {table}"),
            2,
            "--sheet hollow-0.2 is a sheet of full-cube",
        ),
    ];
    for (words, code, text) in cases {
        let refused = fit(here, &format!("predict {words} {place}"));
        assert_eq!(refused.code, Some(code), "{words:?}: {}", refused.err);
        assert!(refused.err.contains(text), "{words:?}: {}", refused.err);
    }
    println!("{} refusals", cases.len());
}
