//! Figures of both programs in a browser: no text leaves its figure, or covers another one.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tests::browser::Browser;
use tests::files::{argument, bake_table};
use tests::program::{bake, fit};

/// Widest number that one text may overlap another by, pixels: boxes are rounded to the font's
/// hinting.
const ROUNDING: f64 = 0.5;

/// Draws every kind of figure in `here`, and returns their names.
fn drawn(here: &Path) -> Vec<&'static str> {
    let table = bake_table(here, "triangular-pair", "0:45:5", "30");
    let manifest = argument("tests/captures/public_per_angle/captures.toml");
    let edge = argument("tests/edges/camera_5deg.exr");
    let fitted = format!("--table {table}");
    let place = format!("predict r.json {fitted} --distance 150,300");
    let around = format!("predict r.json {fitted} --distance 150 --frequency 0.5,1,2");
    bake(
        here,
        "design triangular-pair --dihedral-error-mrad 0.3,0.3,0.3 -o errors.obj",
    )
    .done();
    bake(
        here,
        "trace errors.obj -o errors.h5 --refractive-index 1.49",
    )
    .done();
    let lines = [
        (
            "fit",
            format!("estimate {manifest} {fitted} --plot fitted.svg -o r.json"),
        ),
        ("fit", format!("mtf {edge} --plot measured.svg -o m.csv")),
        (
            "fit",
            format!("{place} --incidence 0:45:5 --plot mtf.svg -o m.csv"),
        ),
        (
            "fit",
            format!(
                "{around} --incidence 0:45:5 --against incidence --plot incidence.svg -o m.csv"
            ),
        ),
        (
            "fit",
            format!("{around} --incidence 0:45:15 --against direction --plot polar.svg -o m.csv"),
        ),
        (
            "fit",
            "predict --sheet prism-0.1 --distance 500:3000:500 --incidence 0,20 --frequency \
             0.02,0.05,0.1 --against distance --plot distance.svg -o m.csv"
                .into(),
        ),
        ("bake", format!("inspect {table} --plot shifts.svg")),
        (
            "bake",
            "inspect errors.h5 --plot-deviations spots.svg".into(),
        ),
    ];
    let mut names = Vec::new();
    for (program, line) in lines {
        let run = match program {
            "fit" => fit(here, &line),
            _ => bake(here, &line),
        };
        assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
        let figure = line.split_whitespace().find(|word| word.ends_with(".svg"));
        names.push(figure.expect("it draws").to_owned().leak() as &str);
    }
    names
}

/// The crate of charts estimates widths of texts; here a browser lays them out.
#[test]
fn no_text_of_a_figure_is_cut_or_covered() {
    let Some(browser) = Browser::find() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let names = drawn(here);
    let figures: String = names
        .iter()
        .map(|name| fs::read_to_string(here.join(name)).unwrap())
        .collect();
    let probe = include_str!("figures_probe.js");
    // A text that is moved over another, and one that leaves: the probe has to find both.
    let broken = "<svg viewBox=\"0 0 100 40\" width=\"100\" height=\"40\" aria-label=\"broken\">\
        <text x=\"10\" y=\"20\">a name</text><text x=\"14\" y=\"21\">another</text>\
        <text x=\"90\" y=\"38\">gone</text></svg>";
    let page = format!(
        "<!DOCTYPE html><html><body>{figures}{broken}<script>{probe}</script></body></html>"
    );
    fs::write(here.join("figures.html"), page).unwrap();
    let found = browser.probe(&here.join("figures.html"), 1400, false);
    let all = found.as_array().expect("a list of figures");
    assert_eq!(all.len(), names.len() + 1);
    let mut texts = 0;
    for (figure, name) in all.iter().zip(names.iter().copied().chain(["broken"])) {
        let count = |key: &str| -> Vec<&Value> {
            let faults = figure[key].as_array().expect("a list");
            let real = |fault: &&Value| fault["by"].as_f64().unwrap() > ROUNDING;
            faults.iter().filter(real).collect()
        };
        texts += figure["texts"].as_u64().unwrap();
        let (outside, covered) = (count("outside"), count("covered"));
        match name {
            "broken" => assert_eq!((outside.len(), covered.len()), (1, 1), "{figure}"),
            _ => assert!(outside.is_empty() && covered.is_empty(), "{name}: {figure}"),
        }
    }
    println!("{texts} texts of {} figures", names.len());
    assert!(texts > 200, "{texts}");
}
