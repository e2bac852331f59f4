//! `fit mtf` on several photographs and on folders: one row each, refusals among them.

use std::path::Path;

use tests::files::argument;
use tests::program::fit;

/// Reads CSV as RFC 4180 describes it. Line breaks may be single.
fn rows(text: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut field) = (Vec::new(), Vec::new(), String::new());
    let mut quoted = false;
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match (c, quoted) {
            ('"', true) if rest.peek() == Some(&'"') => {
                field.push('"');
                rest.next();
            }
            ('"', _) => quoted = !quoted,
            (',', false) => row.push(std::mem::take(&mut field)),
            ('\n', false) => {
                row.push(std::mem::take(&mut field));
                rows.push(std::mem::take(&mut row));
            }
            _ => field.push(c),
        }
    }
    assert!(!quoted && field.is_empty() && row.is_empty(), "{text}");
    rows
}

/// Fills a folder: two edges that can be measured, one along the columns, and two other files.
fn fill(folder: &Path) {
    for (edge, name) in [("camera_92deg", "a.exr"), ("camera_5deg", "b, \"c\".exr")] {
        let from = argument(&format!("tests/edges/{edge}.exr"));
        std::fs::copy(from, folder.join(name)).unwrap();
    }
    image::ImageBuffer::from_fn(96, 96, |x, _| {
        image::Luma([if x < 48 { 2_000_u16 } else { 50_000 }])
    })
    .save(folder.join("z.png"))
    .unwrap();
    std::fs::write(folder.join("notes.txt"), "no picture").unwrap();
    std::fs::write(folder.join(".hidden.png"), "no picture").unwrap();
}

#[test]
fn a_folder_gives_a_row_for_each_photograph() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::create_dir(here.join("edges")).unwrap();
    fill(&here.join("edges"));
    let run = fit(here, "mtf edges -o rows.csv --pixel-pitch 0.05 --at 2,5");
    assert_eq!(run.code, Some(1), "{}\n{}", run.line, run.err);
    for part in [
        "warning: refused: edges/z.png: the edge is aligned with the pixel grid",
        "tilt it by 2 to 10 degrees",
        "error: 1 of 3 photographs were refused",
    ] {
        assert!(run.err.contains(part), "{part}: {}", run.err);
    }
    let rows = rows(&std::fs::read_to_string(here.join("rows.csv")).unwrap());
    let column = |name: &str| {
        let found = rows[0].iter().position(|held| held == name);
        found.unwrap_or_else(|| panic!("{name}: {:?}", rows[0]))
    };
    let images: Vec<&str> = rows[1..].iter().map(|row| row[0].as_str()).collect();
    assert_eq!(images, ["edges/a.exr", "edges/b, \"c\".exr", "edges/z.png"]);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let mut numbers = 0;
    for (row, image) in rows[1..3].iter().zip(&images) {
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        // The name of one of them has spaces.
        let words = [
            "mtf",
            image,
            "--json",
            "--pixel-pitch",
            "0.05",
            "--at",
            "2,5",
        ];
        let alone = fit(here, &words).done();
        let alone: serde_json::Value = serde_json::from_str(&alone).unwrap();
        for (name, held) in [
            ("mtf50_per_mm", &alone["mtf50_per_mm"]),
            ("mtf50_cycles_per_pixel", &alone["mtf50_cycles_per_pixel"]),
            (
                "mtf50_per_mm_standard_error",
                &alone["mtf50_standard_error"],
            ),
            ("mtf10_per_mm", &alone["mtf10_per_mm"]),
            ("mtf_at_2_per_mm", &alone["at"][0]["mtf"]),
            ("mtf_at_5_per_mm", &alone["at"][1]["mtf"]),
        ] {
            let held = held.as_f64().unwrap();
            // The CSV has six digits after the point.
            assert!((number(name) - held).abs() <= 5e-7, "{name}: {held}");
            numbers += 1;
        }
        assert!((number("mtf50_per_mm") * 0.05 - number("mtf50_cycles_per_pixel")).abs() < 1e-6);
        assert_eq!(row[column("error")], "");
    }
    assert_eq!(numbers, 12);
    let refused = &rows[3];
    assert!(refused[column("error")].contains("aligned with the pixel grid"));
    assert_eq!(refused[column("mtf50_per_mm")], "");
    // JSON holds the entries in the same order.
    let run = fit(here, "mtf edges/z.png edges/a.exr --json");
    assert_eq!(run.code, Some(1));
    let object: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let entries = object["photographs"].as_array().unwrap();
    assert_eq!(entries.len(), 2);
    assert!(entries[0]["error"].as_str().unwrap().contains("aligned"));
    assert!(entries[1]["mtf"].as_array().unwrap().len() > 500);
}

#[test]
fn what_cannot_be_measured_leaves_files_alone() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fill(here);
    std::fs::create_dir(here.join("empty")).unwrap();
    std::fs::write(here.join("kept.csv"), "kept").unwrap();
    for (arguments, code, part) in [
        ("z.png", 1, "the edge is aligned with the pixel grid"),
        ("empty", 1, "empty: the folder holds no picture"),
        (
            "a.exr --at 1.5",
            2,
            "--at 1.5: lies above the sampling frequency",
        ),
        ("a.exr --plot curve.bmp", 2, "curve.bmp"),
        ("a.exr --plot a.exr", 2, "a.exr"),
        ("a.exr --plot z.png", 2, "must be .svg"),
        ("", 2, "<IMAGE>"),
    ] {
        let run = fit(here, &format!("mtf -o kept.csv {arguments}"));
        assert_eq!(run.code, Some(code), "{}\n{}", run.line, run.err);
        assert!(run.err.contains(part), "{}\n{}", run.line, run.err);
        assert_eq!(
            std::fs::read_to_string(here.join("kept.csv")).unwrap(),
            "kept"
        );
    }
    assert!(!here.join("curve.bmp").exists());
}

#[test]
fn a_plot_shows_each_photograph() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fill(here);
    let plot = [
        "mtf",
        "a.exr",
        "b, \"c\".exr",
        "--plot",
        "curves.svg",
        "-o",
        "rows.csv",
    ];
    fit(here, &plot).done();
    let drawn = std::fs::read_to_string(here.join("curves.svg")).unwrap();
    assert!(
        drawn.contains("<svg") && drawn.contains("a.exr: 0.300"),
        "{drawn}"
    );
    assert!(drawn.contains("cycles/pixel"));
}
