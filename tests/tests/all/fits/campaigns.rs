//! All steps with the real programs: a design, its table, and a, c and mu from photographs whose
//! truth is known.

use std::path::Path;

use serde_json::Value;
use tests::estimate::{json, numbers};
use tests::files::{argument, bake_table};
use tests::program::fit;

struct Campaign {
    name: &'static str,
    design: &'static str,
    incidence: &'static str,
    azimuth: &'static str,
    lobe: &'static str,
    /// Options that fix the sharing, for the run that leaves no choice to `auto`.
    sharing: [&'static str; 2],
    /// Greatest relative error of a.
    a_within: f64,
    /// Count of the numbers in the result.
    numbers: usize,
}

const CAMPAIGNS: [Campaign; 3] = [
    Campaign {
        name: "public_per_angle",
        design: "triangular-pair",
        incidence: "0:45:5",
        azimuth: "30",
        lobe: "radial",
        sharing: ["--per-angle", "a,mu"],
        a_within: 0.01,
        numbers: 21,
    },
    Campaign {
        name: "public_shared",
        design: "triangular-pair",
        incidence: "0:45:15",
        azimuth: "30",
        lobe: "separable",
        sharing: ["--shared", "a,c,mu"],
        a_within: 0.005,
        numbers: 3,
    },
    // One cube, lit off its symmetry axes, with edges in four directions. Only this campaign shows
    // a wrong sign of an axis.
    Campaign {
        name: "public_axes",
        design: "triangular",
        incidence: "10,25,40",
        azimuth: "10",
        lobe: "radial",
        sharing: ["--shared", "a,c,mu"],
        a_within: 0.01,
        numbers: 3,
    },
];

/// Greatest distance of an estimate from its truth, in reported standard errors.
///
/// 54 numbers are compared. If they were independent and normal, one of them would exceed this
/// limit in one of 2,700 sets of photographs. The photographs are one fixed set. So the limit does
/// not reject bad luck; it rejects standard errors that are reported too small. The tables are
/// baked as a user bakes them, with `--method auto`.
const STANDARD_ERRORS: f64 = 4.5;

#[test]
fn the_three_campaigns_give_back_their_truth() {
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    for campaign in &CAMPAIGNS {
        let table = bake_table(
            folder.path(),
            campaign.design,
            campaign.incidence,
            campaign.azimuth,
        );
        let told = format!(
            "--kernel eq1 --lobe {} {} {}",
            campaign.lobe, campaign.sharing[0], campaign.sharing[1]
        );
        for options in [&told[..], "--lobe auto"] {
            compared += compare(folder.path(), campaign, &table, options);
        }
    }
    assert_eq!(compared, 2 * (21 + 3 + 3));
}

/// One photograph of twenty has a wrong incidence in the manifest. The fit is poor and names the
/// photograph, and c stays near the truth. The wrong photograph pulls c by 0.05 and 0.8 %, and
/// twice the larger is allowed. A fit that takes the noise about a wrong blur loses c: it was 74 % off in
/// one case, and a millionth of the truth in the other.
#[test]
#[ignore = "half a minute: `make test-slowest` runs it"]
fn one_wrong_angle_leaves_c_near_its_truth() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let photographs = tests::files::project().join("tests/captures/public_per_angle");
    for entry in std::fs::read_dir(&photographs).unwrap().flatten() {
        std::fs::copy(entry.path(), here.join(entry.file_name())).unwrap();
    }
    let manifest = std::fs::read_to_string(here.join("captures.toml")).unwrap();
    let table = bake_table(here, "triangular-pair", "0:45:5", "30");
    let mut cases = 0;
    for wrong in ["20.0", "35.0"] {
        let wrong = format!("incidence_deg = {wrong}");
        let told = manifest.replacen("incidence_deg = 10.0", &wrong, 1);
        assert_ne!(told, manifest);
        std::fs::write(here.join("wrong.toml"), told).unwrap();
        let run = fit(
            here,
            &format!("estimate wrong.toml --table {table} -o wrong.json --diagnose 0"),
        );
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(
            run.err.contains("aerial_150mm_10deg_tan.exr fits worst"),
            "{}",
            run.err
        );
        let result = json(&here.join("wrong.json"));
        let c = result["c_mm"]["value"].as_f64().expect("c is known");
        println!("{wrong}: c {c}");
        assert_eq!(result["fit"]["verdict"], "poor");
        assert!((c / 0.24 - 1.0).abs() < 0.016, "{c}");
        cases += 1;
    }
    assert_eq!(cases, 2);
}

/// A lobe of fixed angle, whose a times R is a number of its own in the result.
#[test]
fn a_lobe_of_fixed_angle_gives_back_its_truth() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let parameters = argument("tests/tests/all/planted/angular.toml");
    fit(here, &format!("simulate {parameters} -o angular")).done();
    let table = bake_table(here, "triangular-pair", "0,30", "30");
    let files = format!("estimate angular/captures.toml --table {table} -o result.json");
    let terms = "--kernel angular --lobe separable --shared a,mu";
    fit(here, &format!("{files} {terms}")).done();
    let truth = json(&here.join("angular/truth.json"));
    let numbers = numbers(&json(&here.join("result.json")), &truth);
    assert_eq!(numbers.len(), 3);
    for number in numbers {
        assert!(number.score().abs() < STANDARD_ERRORS, "{number:?}");
        assert!(number.relative().abs() < 0.02, "{number:?}");
    }
}

fn compare(folder: &Path, campaign: &Campaign, table: &str, options: &str) -> usize {
    let photographs = format!("tests/captures/{}", campaign.name);
    let manifest = argument(&format!("{photographs}/captures.toml"));
    let truth_file = argument(&format!("{photographs}/truth.json"));
    let files = format!("estimate {manifest} --table {table} --truth {truth_file} -o result.json");
    let run = fit(folder, &format!("{files} {options}"));
    assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
    // public_axes has a single distance. If the kernel is left open, `fit` guesses how a changes
    // with the distance, and warns. All other runs are silent.
    let guessed = campaign.name == "public_axes" && !options.contains("--kernel");
    let said = run.err.lines().count() == 1 && run.err.contains("one floating distance");
    assert_eq!(
        (run.err.is_empty(), said),
        (!guessed, guessed),
        "{}\n{}",
        run.line,
        run.err
    );
    let printed = run.out;
    let (result, truth) = (
        json(&folder.join("result.json")),
        json(Path::new(&truth_file)),
    );
    let name = campaign.name;
    for key in ["kernel", "lobe"] {
        assert_eq!(
            result[key], truth["truth"][key],
            "{name} {options:?}: {key}"
        );
    }
    let numbers = numbers(&result, &truth);
    assert_eq!(
        numbers.len(),
        campaign.numbers,
        "{name} {options:?}: sharing"
    );
    for number in &numbers {
        let within = match number.name.as_bytes()[0] {
            b'c' => 0.02,
            b'a' => campaign.a_within,
            _ => 0.005,
        };
        assert!(
            number.relative().abs() < within,
            "{name} {options:?}: {number:?}"
        );
        assert!(
            number.score().abs() < STANDARD_ERRORS,
            "{name} {options:?}: {number:?}"
        );
        // A far too large standard error would pass the check above.
        assert!(
            number.standard_error < within * number.truth,
            "{name} {options:?}: {number:?}"
        );
        assert!(
            printed.contains(&format!("{}", number.truth)),
            "{} is not beside the estimate",
            number.name
        );
    }
    has_the_keys_of_a_result(&result);
    numbers.len()
}

type Is = fn(&Value) -> bool;

/// Checks that a result has the keys on which scripts rely, each with the right type.
fn has_the_keys_of_a_result(result: &Value) {
    let kinds: [(&str, Is); 19] = [
        ("/kernel", Value::is_string),
        ("/lobe", Value::is_string),
        ("/iterations", Value::is_u64),
        ("/stop", Value::is_string),
        ("/seconds", Value::is_f64),
        ("/c_mm/value", Value::is_f64),
        ("/c_mm/standard_error", Value::is_f64),
        ("/a_per_mm", Value::is_object),
        ("/a_times_r", Value::is_null),
        ("/mu", Value::is_object),
        ("/covariance/names/0", Value::is_string),
        ("/covariance/matrix/0/0", Value::is_f64),
        ("/bounds", Value::is_object),
        ("/candidates/0/criterion", Value::is_f64),
        ("/captures/0/image", Value::is_string),
        ("/captures/0/mtf50_per_mm", Value::is_f64),
        ("/table/content_hash", Value::is_string),
        ("/table/design", Value::is_string),
        ("/warnings", Value::is_array),
    ];
    for (pointer, right) in kinds {
        let found = result.pointer(pointer);
        assert!(found.is_some_and(right), "{pointer}: {found:?}");
    }
    let every = |list: &str, keys: &[&str]| {
        for entry in result[list].as_array().unwrap() {
            for key in keys {
                assert!(entry.get(key).is_some(), "{list} lacks {key}: {entry}");
            }
        }
    };
    every(
        "candidates",
        &[
            "kernel",
            "lobe",
            "sharing",
            "criterion",
            "loss",
            "parameters",
        ],
    );
    every(
        "captures",
        &[
            "image",
            "edge_angle_deg",
            "mtf50_per_mm",
            "loss",
            "warnings",
        ],
    );
    let names = result["covariance"]["names"].as_array().unwrap().len();
    let rows = result["covariance"]["matrix"].as_array().unwrap();
    assert_eq!(rows.len(), names);
    assert!(
        rows.iter()
            .all(|row| row.as_array().unwrap().len() == names)
    );
}
