//! Data sheets as a maker makes them: a page, CSV, JSON, and what is refused.

use serde_json::Value;
use std::fs;
use tests::program::bake;

/// A page, maps and numbers of one design agree with its table, and with each other. The same words
/// write the same bytes.
#[test]
fn a_data_sheet_says_what_the_table_says() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bake(
        here,
        "design triangular-pair -o pair.obj --edge-length 0.18",
    )
    .done();
    let common = "pair.obj --refractive-index 1.49 --unit mm --step 10 --up-to 50 --cells 3";
    let made = |words: &str| bake(here, &format!("datasheet {common} {words}"));
    let text = made("-o pair.html").done();
    let page = fs::read_to_string(here.join("pair.html")).unwrap();
    assert_eq!(made("-o pair.html").done(), text);
    assert!(fs::read_to_string(here.join("pair.html")).unwrap() == page);
    for word in [
        "0.18 mm (longest edge from the apex)",
        "6 rotations",
        "total reflection",
    ] {
        assert!(text.contains(word) && page.contains(word), "{word}\n{text}");
    }
    assert!(
        !page.contains("http://") || page.contains("www.w3.org"),
        "no network"
    );
    assert!(!page.contains("<script") && page.matches("<svg").count() == 2);

    let found: Value = serde_json::from_str(&made("--json -o pair.csv").done()).unwrap();
    let cell = &found["cells"][0];
    assert_eq!(cell["c_mm"].as_f64(), Some(0.18));
    let directions = "--incidence 0:50:10 --azimuth 0:350:10 --refractive-index 1.49 --bins 8";
    let losses = "--losses fresnel --metal aluminium --wavelength-nm 550";
    let total = "--losses fresnel --back tir";
    let csv = fs::read_to_string(here.join("pair.csv")).unwrap();
    let mut lines = csv.lines().skip(1);
    let mut compared = 0;
    for (k, options) in ["", losses, total].into_iter().enumerate() {
        let table = format!("trace pair.obj -o t{k}.h5 {directions} {options}");
        bake(here, &table).done();
        let table = tables::read(&here.join(format!("t{k}.h5"))).unwrap();
        let maps = &cell["surfaces"][k]["eta"];
        for ((i, a), &eta) in table.retroreflected.indexed_iter() {
            let own = maps[i][a].as_f64().unwrap();
            // Azimuths that one sector stands for are the same to rounding.
            assert!((own - eta).abs() < 1e-10, "{k}, {i}, {a}: {own} {eta}");
            let line = lines.next().expect("a line for each direction");
            assert!(
                line.ends_with(&format!(",{},{},{own}", 10 * i, 10 * a)),
                "{line}"
            );
            compared += 1;
        }
    }
    assert_eq!((compared, lines.next()), (3 * 6 * 36, None));
}

/// Of two cells the second is compared with the first, on the surfaces that both have.
#[test]
fn two_cells_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bake(here, "design triangular-pair -o pair.obj").done();
    bake(here, "design canted -o canted.obj --cant-deg 7.9").done();
    let common = "--refractive-index 1.49 --unit mm --step 10 --up-to 50 --cells 2";
    let made = bake(
        here,
        &format!("datasheet pair.obj canted.obj -o both.json {common}"),
    );
    let text = made.done();
    assert!(text.contains("canted against pair"), "{text}");
    let found = fs::read_to_string(here.join("both.json")).unwrap();
    let found: Value = serde_json::from_str(&found).unwrap();
    let pairs = found["second_against_first"].as_array().unwrap();
    assert_eq!(pairs.len(), 3);
    let at = |cell: usize| {
        found["cells"][cell]["surfaces"][0]["eta"][4][0]
            .as_f64()
            .unwrap()
    };
    // The cant of 7.9 degrees is best at 40 degrees, azimuth 0: eta 0.387.
    assert!((at(1) - 0.387).abs() < 5e-4 && at(1) > at(0));
    let ratio = pairs[0]["ratio"][4][0].as_f64().unwrap();
    assert!((ratio - at(1) / at(0)).abs() < 1e-12);
    let conditions =
        "azimuth 0\u{b0}, 300 mm from the sheet, 550 nm, corner size c 3 mm, kernel wave";
    assert_eq!(text.matches(conditions).count(), 2, "{text}");
    let mut ratios = 0;
    for (s, pair) in pairs.iter().enumerate() {
        for (i, own) in pair["mtf50_ratio"].as_array().unwrap().iter().enumerate() {
            for axis in ["tangential", "sagittal"] {
                let [first, second] = [0, 1].map(|cell| {
                    let at = &found["cells"][cell]["tolerances"][2 * s + i];
                    at["mtf50_per_mm"][axis].as_f64().unwrap()
                });
                let ratio = own[axis].as_f64().unwrap();
                assert!((ratio - second / first).abs() < 1e-12, "{own}");
                let line = format!("{first:.4} and {second:.4}, ratio {ratio:.4}");
                assert!(text.contains(&line), "{line}\n{text}");
                ratios += 1;
            }
        }
    }
    assert_eq!(ratios, 3 * 2 * 2);
}

/// Wrong words are refused before any work, and files that were there stay.
#[test]
fn wrong_words_leave_files_alone() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bake(here, "design triangular-pair -o pair.obj").done();
    bake(here, "design bead -o bead.obj --segments 40").done();
    fs::write(here.join("old.html"), "old").unwrap();
    let mesh = fs::read(here.join("pair.obj")).unwrap();
    let cases = [
        ("pair.obj -o old.txt", 2, ".html, .csv or .json"),
        ("pair.obj -o pair.obj", 2, ".html, .csv or .json"),
        ("none.obj -o old.html", 1, "none.obj"),
        ("pair.obj none.obj -o old.html", 1, "none.obj"),
        ("pair.obj -o no/folder.html", 1, "no/folder.html"),
        ("pair.obj -o old.html --cells 1000", 2, "--cells 1000"),
        ("pair.obj -o old.html --step 0.1", 2, "--step 0.1"),
        ("pair.obj -o old.html --incidence 0:40:5", 2, "--incidence"),
        ("pair.obj -o old.html --incidence x", 2, "--incidence x"),
        ("pair.obj -o old.html --metal gold", 2, "gold"),
        ("pair.obj -o old.html --refractive-index glass", 2, "glass"),
        (
            "bead.obj -o old.html --edge-length 1 --azimuth-zero 1,0,0",
            1,
            "bead.obj",
        ),
    ];
    for (words, code, expected) in cases {
        let run = bake(here, &format!("datasheet {words}"));
        assert_eq!(run.code, Some(code), "{words}\n{}", run.err);
        assert!(run.err.contains(expected), "{words}\n{}", run.err);
        assert_eq!(run.out, "", "{words}");
        assert_eq!(
            fs::read_to_string(here.join("old.html")).unwrap(),
            "old",
            "{words}"
        );
    }
    assert!(fs::read(here.join("pair.obj")).unwrap() == mesh);
}

/// A name in a mesh becomes no markup of the page and steers no terminal.
#[test]
fn names_of_strangers_are_text() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bake(here, "design triangular-pair -o pair.obj").done();
    let name = "<img src=x onerror=alert(1)>.obj";
    fs::rename(here.join("pair.obj"), here.join(name)).unwrap();
    let words = [
        "datasheet",
        name,
        "-o",
        "page.html",
        "--unit",
        "mm",
        "--cells",
        "2",
        "--step",
        "15",
    ];
    let run = bake(here, &words);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let page = fs::read_to_string(here.join("page.html")).unwrap();
    assert!(page.contains("&lt;img src=x") && !page.contains("<img src=x"));
}

/// Two writings of one cell are compared, although single precision hides a symmetry of one; tables
/// without errors print no number of standard errors.
#[test]
fn tables_of_two_writings_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let errors = "--dihedral-error-mrad 1,1,1";
    for file in ["cell.obj", "cell.glb"] {
        bake(here, &format!("design triangular-pair -o {file} {errors}")).done();
        let table = file.replace('.', "-");
        let words = format!("trace {file} -o {table}.h5 --refractive-index 1 --azimuth full:15");
        assert_eq!(
            bake(here, &format!("{words} --incidence 0,20")).code,
            Some(0)
        );
    }
    let run = bake(here, "compare cell-obj.h5 cell-glb.h5");
    // Single precision moves corners by 1e-7, and exact tables are compared to 1e-9.
    assert_eq!(run.code, Some(1), "{}", run.err);
    assert!(
        run.err.contains("differ by more than their errors allow"),
        "{}",
        run.err
    );
    assert!(
        !run.out.contains("inf") && run.out.lines().count() > 3,
        "{}",
        run.out
    );
    let json = bake(here, "compare cell-obj.h5 cell-glb.h5 --json").out;
    let found: Value = serde_json::from_str(&json).unwrap();
    for row in found["directions"].as_array().unwrap() {
        assert!(row["sigmas"].is_null());
        assert!(
            row["eta_difference"].as_f64().unwrap().abs() < 1e-5,
            "{row}"
        );
        assert!(
            row["polygons"].is_null() && row["l1"].as_f64().unwrap() < 1e-4,
            "{row}"
        );
    }
    let same = bake(here, "compare cell-obj.h5 cell-obj.h5");
    assert_eq!(same.code, Some(0), "{}", same.err);
}

/// Tables of one cell agree if its files have 12 digits, and the message about 7 digits says so.
#[test]
fn few_digits_explain_a_small_difference() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for file in ["pair.obj", "pair.glb"] {
        bake(
            here,
            &format!("design triangular-pair -o {file} --edge-length 0.18"),
        )
        .done();
    }
    let rounded = |line: &str| match line.strip_prefix("v ") {
        Some(numbers) => {
            let numbers = numbers.split(' ').map(|x| x.parse::<f64>().unwrap());
            numbers.fold(String::from("v"), |line, x| format!("{line} {x:.12}"))
        }
        None => line.to_owned(),
    };
    let text = fs::read_to_string(here.join("pair.obj")).unwrap();
    let lines: Vec<String> = text.lines().map(rounded).collect();
    fs::write(here.join("rounded.obj"), lines.join("\n")).unwrap();
    for file in ["pair.obj", "rounded.obj", "pair.glb"] {
        let words = format!("trace {file} -o {file}.h5 --refractive-index 1.49 --incidence 0,20");
        bake(here, &words).done();
    }
    assert_eq!(
        bake(here, "compare pair.obj.h5 rounded.obj.h5").code,
        Some(0)
    );
    let run = bake(here, "compare pair.obj.h5 pair.glb.h5");
    assert_eq!(run.code, Some(1), "{}", run.err);
    assert!(run.err.contains("few digits"), "{}", run.err);
    bake(
        here,
        "design triangular-pair -o other.obj --edge-length 0.18 --gap 0.001",
    )
    .done();
    bake(
        here,
        "trace other.obj -o other.h5 --refractive-index 1.49 --incidence 0,20",
    )
    .done();
    let run = bake(here, "compare pair.obj.h5 other.h5");
    assert!(
        run.code == Some(1) && !run.err.contains("few digits"),
        "{}",
        run.err
    );
}
