//! Tests of `bake study` from outside.

use std::process::Command;

#[test]
fn the_verb_writes_what_it_measures() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bake = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_bake"))
            .current_dir(folder.path())
            .args(arguments)
            .output()
            .expect("bake runs")
    };
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        bake(&["design", "triangular", "-o", "cube.obj"])
            .status
            .success()
    );
    let small = [
        "study",
        "cube.obj",
        "--rays",
        "4096",
        "--incidence",
        "10",
        "--bins",
        "8",
    ];
    let run = |more: &[&str]| bake(&[&small[..], more].concat());

    let plain = run(&["--csv", "study.csv", "--plot", "study.svg"]);
    assert!(plain.status.success(), "{}", text(&plain.stderr));
    assert_eq!(text(&plain.stderr), "", "a good run is quiet in a pipe");
    let console = text(&plain.stdout);
    for part in [
        "against the exact table",
        "slope of the mean L1",
        "seconds to L1 = 0.008",
    ] {
        assert!(console.contains(part), "{part}: {console}");
    }
    let csv = std::fs::read_to_string(folder.path().join("study.csv")).expect("a CSV file");
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
    let svg = std::fs::read_to_string(folder.path().join("study.svg")).expect("a picture");
    assert!(svg.contains("no sampling error"));
    assert_eq!(charts::check::faults(&svg), [""; 0]);

    let json = run(&["--json", "--repeats", "1"]);
    let value: serde_json::Value = serde_json::from_slice(&json.stdout).expect("JSON");
    assert_eq!(value["reference"]["method"], "exact");
    assert_eq!(value["series"].as_array().expect("a list").len(), 4);
    assert_eq!(value["series"][0]["points"][1]["rays"], 4096);

    // Every bake takes longer than a quarter of a nanosecond, so one point of each series is left.
    let short = run(&["--json", "--longest", "1e-9", "--repeats", "1"]);
    let value: serde_json::Value = serde_json::from_slice(&short.stdout).expect("JSON");
    for series in value["series"].as_array().expect("a list") {
        assert_eq!(series["points"].as_array().expect("a list").len(), 1);
        assert!(series["slope"].is_null());
    }

    let wrong: [(&[&str], i32, &str); 6] = [
        (
            &["--rays", "1000"],
            2,
            "--rays 1000: a study begins with 1024",
        ),
        (&["--repeats", "0"], 2, "--repeats 0: give a whole number"),
        (
            &["--longest", "-1"],
            2,
            "--longest -1: give a number of seconds",
        ),
        (&["--target", "0"], 2, "--target 0: give a number above 0"),
        (
            &["--plot", "study.png"],
            2,
            "study.png: the extension must be .svg",
        ),
        (
            &["--csv", "no/study.csv"],
            1,
            "no/study.csv: cannot be written",
        ),
    ];
    for (arguments, code, sentence) in wrong {
        let base: Vec<&str> = match arguments[0] {
            "--rays" => vec!["study", "cube.obj"],
            _ => small.to_vec(),
        };
        let output = bake(&[&base[..], arguments].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        assert!(message.contains(sentence), "{arguments:?}: {message}");
    }
    let help = text(&bake(&["study", "--help"]).stdout);
    assert!(help.contains("Example"), "{help}");
    let left = std::fs::read_dir(folder.path()).expect("lists").count();
    assert_eq!(left, 4, "the mesh and three outputs, no half-written file");
}
