//! `fit compare`: its numbers against those of `fit predict`, its page in a browser, its refusals.

use std::fs;
use std::path::Path;

use base64::Engine;
use serde_json::Value;
use sha2::{Digest, Sha256};
use tests::browser::Browser;
use tests::files::{argument, bake_table};
use tests::program::{fit, on_terminal};

/// Runs `fit` and returns the JSON that it prints. Warnings are allowed.
fn json(here: &Path, line: &str) -> Value {
    let run = fit(here, line);
    assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
    serde_json::from_str(&run.out).unwrap_or_else(|error| panic!("{error}: {}", run.out))
}

/// Returns the value of a number with its error.
fn number(value: &Value) -> f64 {
    value["value"].as_f64().unwrap_or_else(|| panic!("{value}"))
}

const PLACE: &str = "--distance 300 --incidence 0,20";
const LIGHT: &str = "--luminance 500 --ambient-nits 5";

/// Every number is that of `fit predict` at the same place: luminance, the lesser MTF50, and the
/// MTF at the frequency of the smallest letter. Crossings end at 1e-12 of the frequency, and the
/// MTF is printed by JSON without loss; derivatives of MTFs are below 10 in relative units.
#[test]
fn numbers_are_those_of_predictions() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bake_table(here, "triangular-pair", "0:45:5", "30");
    let manifest = argument("tests/captures/public_per_angle/captures.toml");
    let line = format!("estimate {manifest} --table {table} -o a.json --kernel eq1 --diagnose 0");
    assert_eq!(fit(here, &line).code, Some(0));
    fs::copy(here.join("a.json"), here.join("b.json")).unwrap();
    let sheets = format!("--sheet prism-0.1 a.json:{table} b.json:{table}");
    let found = json(
        here,
        &format!("compare {sheets} {PLACE} {LIGHT} --letter 8 --json"),
    );
    let mut cases = 0;
    for (k, source) in [
        "--sheet prism-0.1".into(),
        format!("a.json --table {table}"),
    ]
    .iter()
    .enumerate()
    {
        let sheet = &found["sheets"][k];
        for (i, deg) in [0, 20].iter().enumerate() {
            let at = &sheet["at"][i];
            let light = number(&at["luminance"]);
            let contrast = number(&at["contrast"]);
            assert!((contrast * (light + 0.02) / light - 1.0).abs() < 1e-12);
            let letter = number(&at["letter"]["height_mm"]);
            let dark = number(&at["letter_in_the_dark"]["height_mm"]);
            let listed = format!("{},{}", 2.5 / letter, 2.5 / dark);
            let line = format!("predict {source} --distance 300 --incidence {deg} --frequency");
            let predicted = json(here, &format!("{line} {listed} --json"));
            let rows = predicted["predictions"].as_array().unwrap();
            assert_eq!(rows.len(), 2);
            let lesser =
                |of: &dyn Fn(&Value) -> f64| rows.iter().map(of).fold(f64::INFINITY, f64::min);
            let near = |found: f64, expected: f64| {
                assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
            };
            near(light, rows[0]["luminance"].as_f64().unwrap());
            let half = lesser(&|row| row["mtf50_per_mm"].as_f64().unwrap());
            near(number(&at["mtf50_per_mm"]), half);
            near(
                lesser(&|row| row["mtf"][0].as_f64().unwrap()) * contrast,
                0.1,
            );
            near(lesser(&|row| row["mtf"][1].as_f64().unwrap()), 0.1);
            cases += 4;
        }
    }
    assert_eq!(cases, 16);
    // A fit beside itself: ratios of 1, and no scatter at all.
    let itself = &found["sheets"][2];
    let of_first = number(&found["sheets"][1]["ratio"][0]["letter"]);
    assert_eq!(number(&itself["ratio"][0]["letter"]), of_first);
    let agreement = found["agreement"].as_array().unwrap();
    assert!(agreement.len() >= 3, "{agreement:?}");
    for own in agreement {
        assert_eq!(own["results"], 2);
        assert!(own["chi2"].as_f64().unwrap() < 1e-20, "{own}");
    }
    // The text and the CSV hold the same sheets.
    let text = fit(here, &format!("compare {sheets} {PLACE} {LIGHT}")).out;
    let csv = format!("compare {sheets} {PLACE} {LIGHT} -o c.csv");
    assert_eq!(fit(here, &csv).code, Some(0));
    let csv = fs::read_to_string(here.join("c.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 3 * 2);
    let columns = |line: &str| line.split(',').count();
    assert!(csv.lines().all(|line| columns(line) == 17), "{csv}");
    for name in ["prism-0.1", "a", "b"] {
        assert!(
            text.lines()
                .any(|line| line.split_whitespace().nth(1) == Some(name)),
            "{text}"
        );
        assert!(
            csv.lines()
                .any(|line| line.starts_with(&format!("{name},"))),
            "{csv}"
        );
    }
    // Letters are readable where the smallest one is no larger.
    let range = found["sheets"][0]["readable_deg"].as_array().unwrap();
    assert_eq!(range.len(), 1, "{range:?}");
    let end = range[0][1].as_f64().unwrap();
    for (deg, is_larger) in [(end - 0.1, false), (end + 0.1, true)] {
        let line = format!("compare --sheet prism-0.1 --distance 300 --incidence {deg}");
        let at = json(here, &format!("{line} {LIGHT} --json"));
        let letter = number(&at["sheets"][0]["at"][0]["letter"]["height_mm"]);
        assert_eq!(letter > 8.0, is_larger, "{deg}: {letter}");
    }
}

/// The page needs nothing else, is well-formed, and follows its menu.
#[test]
fn the_page_follows_its_menu_and_fits_a_screen() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let names = ["prism-0.1", "prism-0.2", "hollow-0.2", "published"];
    let names: Vec<&str> = names.into_iter().cycle().take(6).collect();
    let sheets = names.iter().map(|name| format!("--sheet {name} "));
    let sheets: String = sheets.collect();
    let sign = argument("doc/sign.png");
    let line = format!("compare {sheets} {PLACE} {LIGHT} --source {sign} --width 100 -o p.html");
    let run = fit(here, &line);
    assert_eq!((run.code, run.out.as_str()), (Some(0), ""), "{}", run.err);
    // A slow machine writes lines of progress too.
    let said = run.err.lines().filter(|line| line.starts_with("warning"));
    let said: Vec<&str> = said.collect();
    let expected = format!("warning: {} are no measured sheets", names.join(", "));
    assert!(
        said.len() == 1 && said[0].starts_with(&expected),
        "{said:?}"
    );
    let page = fs::read_to_string(here.join("p.html")).unwrap();
    assert_eq!(charts::check::faults(&page), [""; 0]);
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(&page, options).unwrap();
    for word in ["<script", "http:", "https:", "url("] {
        assert!(!page.contains(word), "{word}");
    }
    assert_eq!(page.matches("data:image/png").count(), 2 * (1 + 6));
    let (open, folded) = page.split_once("<details").unwrap();
    assert!(open.contains("times as bright as they are"));
    assert!(folded.contains("US patent 6,843,571"), "what is assumed");
    let Some(browser) = Browser::find() else {
        return;
    };
    let probe = include_str!("compare_probe.js");
    let hash = base64::engine::general_purpose::STANDARD.encode(Sha256::digest(probe));
    let probed = page
        .replacen(
            "style-src",
            &format!("script-src 'sha256-{hash}'; style-src"),
            1,
        )
        .replace("</body>", &format!("<script>{probe}</script></body>"));
    fs::write(here.join("probe.html"), probed).unwrap();
    for (width, dark) in [(390, false), (1280, false), (1280, true)] {
        let found = browser.probe(&here.join("probe.html"), width, dark);
        let number = |key: &str| {
            found[key]
                .as_f64()
                .unwrap_or_else(|| panic!("{key}: {found}"))
        };
        assert_eq!(found["wide"], serde_json::json!([]), "{width}");
        // Menu: all sheets at the first incidence; without the second sheet; at the other incidence.
        assert_eq!(found["columns"], serde_json::json!([6, 5, 5]), "{found}");
        assert_eq!(
            found["incidences"],
            serde_json::json!(["Incidence 0\u{b0}", "Incidence 20\u{b0}"])
        );
        assert_eq!(found["curves"], serde_json::json!([12, 10]), "{found}");
        assert_eq!(number("broken"), 0.0);
        // WCAG 2.2, 1.4.3 (AA).
        assert!(number("least_contrast") >= 4.5, "{found}");
        if width == 1280 {
            assert!(number("height") <= 1000.0, "one screen: {found}");
            assert_eq!(number("beyond"), 0.0, "columns beyond the screen: {found}");
        }
    }
    let paper = browser.print(&here.join("p.html"), &here.join("p.pdf"));
    let pages = String::from_utf8_lossy(&paper)
        .matches("/Type /Page\n")
        .count();
    assert!((1..=2).contains(&pages), "{pages} pages");
}

/// The letter of a range is the largest of its incidences: prisms fade with the angle, so that the
/// last one decides. Hollow cubes at azimuth 0 lose their light between 20 and 30 degrees, and return
/// it when they are turned by 60 degrees. A viewer in mm is refused.
#[test]
fn a_range_of_incidence_has_one_letter() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let light = "--luminance 500 --ambient-nits 100 --json";
    let sheets = "compare --sheet prism-0.2 --sheet hollow-0.2";
    let line = format!("{sheets} --distance 1000 --incidence 0:40:10 {light}");
    let found = json(here, &line);
    let [prism, hollow] = [0, 1].map(|k| &found["sheets"][k]);
    let letters = prism["at"].as_array().expect("places");
    let letters: Vec<f64> = letters
        .iter()
        .map(|at| number(&at["letter"]["height_mm"]))
        .collect();
    assert!(letters.len() == 5 && letters.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(prism["everywhere"]["height_mm"], letters[4]);
    assert_eq!(prism["everywhere"]["decided_at_deg"], 40.0);
    assert_eq!(hollow["everywhere"]["height_mm"], Value::Null);
    let decided = hollow["everywhere"]["decided_at_deg"].as_f64();
    assert!(decided.is_some_and(|deg| (20.0..=30.0).contains(&deg)));
    let warnings = found["warnings"].to_string();
    assert!(
        warnings.contains("hollow-0.2: turned by 60 deg"),
        "{warnings}"
    );
    assert!(!warnings.contains("prism-0.2: turned"), "{warnings}");
    let run = fit(
        here,
        "compare --sheet prism-0.2 --distance 1000 --viewer 500,300,2000",
    );
    assert!(
        run.code == Some(2) && run.err.contains("metres"),
        "{}",
        run.err
    );
}

/// On a terminal, the long loops of pictures and pages show what is done of how much, and the rate.
/// Nothing of it goes to a pipe.
#[test]
fn long_work_shows_its_progress() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sign = argument("doc/sign.png");
    let sheet = "--sheet prism-0.1 --distance 300 --incidence 20";
    let picture = format!("{sheet} --source {sign} --width 100");
    let near = "--sheet prism-0.1 --nearest 900 --farthest 1000";
    let cases = [
        (
            format!("compare {picture} -o p.html"),
            &["52 directions", "1 pictures"][..],
        ),
        (format!("render {picture} -o p.png"), &[" rows, "]),
        (
            format!("explore {near} -o e.html"),
            &[" directions, ", "200 places"],
        ),
    ];
    for (line, expected) in cases {
        let shown = on_terminal("fit", here, &line);
        assert_eq!(shown.code, Some(0), "{line}\n{}", shown.out);
        for words in expected {
            let is_bar = |part: &str| part.contains(words) && part.contains("left");
            assert!(shown.out.split('\r').any(is_bar), "{words}: {}", shown.out);
        }
        let piped = fit(here, &line);
        let piped = piped.err + &piped.out;
        assert!(!piped.contains(" left"), "{piped}");
    }
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sheet = "--sheet prism-0.1";
    let far = "--distance 300";
    let cases = [
        (format!("{far} --incidence 0"), 2, "--sheet"),
        (format!("{sheet} --incidence 0"), 2, "--distance"),
        (format!("{sheet} {far}"), 2, "--incidence"),
        (format!("{sheet} {far} --viewer 2"), 2, "--incidence"),
        (format!("{sheet} {far} --viewer 1,2"), 2, "three numbers"),
        (
            format!("{sheet} {far} --viewer 0,0,1 --incidence 5"),
            2,
            "leave one",
        ),
        (
            format!("{sheet} {far} --viewer 0,0,-1"),
            2,
            "in front of the image",
        ),
        (
            format!("{sheet} {far} --viewer 0,-1,1 --sheet-tilt 90"),
            2,
            "back of the sheet",
        ),
        (
            format!("{sheet} {far} --viewer 2 --incidence 0 --sheet-tilt 9"),
            2,
            "--sheet-tilt",
        ),
        (
            format!("{sheet} --viewer 0,1,1 --sheet-height 1"),
            2,
            "--sheet-height",
        ),
        (format!("{sheet} {far} --incidence 89"), 1, "prism-0.1"),
        (format!("{far} --incidence 0 result.json"), 2, "colon"),
        (
            format!("{far} --incidence 0 none.json:none.h5"),
            1,
            "none.json",
        ),
        (
            format!("{sheet} {far} --incidence 0 --ambient -1"),
            2,
            "--ambient",
        ),
        (
            format!("{sheet} {far} --incidence 0 --ambient-nits 3"),
            2,
            "--luminance",
        ),
        (
            format!("{sheet} {far} --incidence 0 -o a.png"),
            2,
            ".html, .csv or .json",
        ),
        (
            format!("{sheet} {far} --incidence 0 --source a.png --width 3"),
            2,
            "which.html",
        ),
        (
            format!("{sheet} {far} --incidence 0 --source a.png -o a.html"),
            2,
            "--width",
        ),
    ];
    for (line, code, said) in &cases {
        let run = fit(here, &format!("compare {line}"));
        assert_eq!(run.code, Some(*code), "{line}\n{}", run.err);
        assert!(run.err.contains(said), "{line}\n{}", run.err);
        assert_eq!(run.out, "");
    }
    assert_eq!(
        fs::read_dir(here).unwrap().count(),
        0,
        "nothing is left behind"
    );
    println!("{} refusals", cases.len());
}
