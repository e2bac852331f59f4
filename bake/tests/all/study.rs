//! Tests of `bake study` from outside.

use crate::program::Folder;

const SMALL: &str = "study triangular.obj --rays 4096 --incidence 10 --bins 8";

#[test]
fn the_verb_writes_what_it_measures() {
    let folder = Folder::with(&["triangular"]);
    let console = folder.quiet(&format!("{SMALL} --csv study.csv --plot study.svg"));
    for part in [
        "against the exact table",
        "slope of the mean L1",
        "seconds to L1 = 0.008",
    ] {
        assert!(console.contains(part), "{part}: {console}");
    }
    let csv = String::from_utf8(folder.read("study.csv")).expect("text");
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    // The rows are a heading, the exact bake, and two tracers x two samplers x 1,024 and 4,096
    // rays.
    assert_eq!(rows.len(), 1 + 1 + 2 * 2 * 2);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{csv}");
    assert_eq!(rows[1][..4], ["exact", "beams", "none", "0"]);
    let numbers = rows[1..].iter().flat_map(|row| &row[3..]);
    assert!(numbers.clone().count() == 9 * 6);
    for number in numbers {
        assert!(number.parse::<f64>().is_ok_and(f64::is_finite), "{number}");
    }
    let svg = String::from_utf8(folder.read("study.svg")).expect("text");
    assert!(svg.contains("no sampling error"));
    assert_eq!(charts::check::faults(&svg), [""; 0]);

    let value = folder.json(&format!("{SMALL} --json --repeats 1"));
    assert_eq!(value["reference"]["method"], "exact");
    assert_eq!(value["series"].as_array().expect("a list").len(), 4);
    assert_eq!(value["series"][0]["points"][1]["rays"], 4096);

    // Every bake takes longer than a quarter of a nanosecond, so one point of each series is left.
    let value = folder.json(&format!("{SMALL} --json --longest 1e-9 --repeats 1"));
    for series in value["series"].as_array().expect("a list") {
        assert_eq!(series["points"].as_array().expect("a list").len(), 1);
        assert!(series["slope"].is_null());
    }

    let few = "study triangular.obj --rays 1000";
    folder.refused(few, 2, "--rays 1000: a study begins with 1024");
    for (options, code, sentence) in [
        ("--repeats 0", 2, ": give a whole number"),
        ("--longest -1", 2, ": give a number of seconds"),
        ("--target 0", 2, ": give a number above 0"),
        ("--plot study.png", 2, ": the extension must be .svg"),
        ("--csv no/study.csv", 1, ": there is no folder no"),
    ] {
        let value = options.split(' ').next_back().expect("a value");
        let sentence = format!("{value}{sentence}");
        folder.refused(&format!("{SMALL} {options}"), code, &sentence);
    }
    assert!(folder.good("study --help").contains("Example"));
    let outputs = ["study.csv", "study.svg", "triangular.obj"];
    assert_eq!(folder.names(), outputs, "no half-written file");
}
