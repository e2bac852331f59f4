//! Tests of the program from outside: exit codes, messages, and outputs that stay whole.

use std::path::Path;
use std::process::{Command, Output};

fn bake(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bake"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("bake runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn good(folder: &Path, arguments: &[&str]) -> String {
    let output = bake(folder, arguments);
    assert!(
        output.status.success(),
        "bake {arguments:?}: {}",
        text(&output.stderr)
    );
    assert_eq!(text(&output.stderr), "", "a good run is quiet in a pipe");
    text(&output.stdout)
}

#[test]
fn from_design_to_picture() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    assert_eq!(good(here, &["design", "--list"]).lines().count(), 6);
    good(here, &["design", "triangular-pair", "-o", "pair.obj"]);
    good(here, &["design", "triangular-pair", "-o", "pair.glb"]);
    let trace = [
        "trace",
        "pair.obj",
        "-o",
        "pair.h5",
        "--rays",
        "20000",
        "--incidence",
        "0,20",
        "--method",
        "rays",
    ];
    let report = good(
        here,
        &[
            &trace[..],
            &["--refractive-index", "1.49", "--unit", "mm", "--json"],
        ]
        .concat(),
    );
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["directions"].as_array().expect("a list").len(), 2);
    let fates = report["directions"][0]["fates"].as_object().expect("fates");
    let sum: f64 = fates.values().filter_map(serde_json::Value::as_f64).sum();
    assert!((sum - 1.0).abs() < 1e-12);
    assert!(good(here, &["inspect", "pair.h5"]).contains("triangular-pair"));
    let inspected = good(
        here,
        &["inspect", "pair.h5", "--plot", "pair.SVG", "--json"],
    );
    let inspected: serde_json::Value = serde_json::from_str(&inspected).expect("JSON");
    assert!(inspected.to_string().contains(r#""edge_length_unit":"mm""#));
    let picture = std::fs::read_to_string(here.join("pair.SVG")).expect("a picture");
    assert_eq!(charts::check::faults(&picture), [""; 0]);
    assert!(good(here, &["verify", "pair.h5"]).contains("valid"));
    // The seal is cut off, as a program does that opens the table for writing.
    let sealed = std::fs::read(here.join("pair.h5")).expect("a table");
    std::fs::write(here.join("cut.h5"), &sealed[..sealed.len() - 40]).expect("writes");
    assert!(good(here, &["verify", "cut.h5"]).contains("its seal is gone"));
    // A table with another seed agrees within the errors. A table with another index does not, and
    // the exit code is 1.
    let again = |seed: &str, index: &str, file: &str| {
        let more = ["--seed", seed, "--refractive-index", index, "-o", file];
        let [verb, mesh, _, _, rest @ ..] = trace;
        good(here, &[&[verb, mesh], &rest[..], &more[..]].concat());
    };
    again("2", "1.49", "seed.h5");
    again("1", "1.3", "index.h5");
    good(here, &["compare", "pair.h5", "seed.h5"]);
    assert_eq!(
        bake(here, &["compare", "pair.h5", "index.h5"])
            .status
            .code(),
        Some(1)
    );
}

#[test]
fn wrong_usage_and_failed_work() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    good(here, &["design", "triangular", "-o", "cube.obj"]);
    std::fs::write(here.join("old.h5"), b"precious").expect("writes");
    std::fs::write(here.join("bad.obj"), b"v 0 0 0\n").expect("writes");
    let cases: [(&[&str], i32, &str); 11] = [
        (&["trace", "cube.obj"], 2, "--output"),
        (
            &["trace", "cube.obj", "-o", "old.h5", "--incidence", "95"],
            2,
            "--incidence 95: the angle must be",
        ),
        (
            &["trace", "cube.obj", "-o", "old.h5", "--lattice", "1,2"],
            2,
            "--lattice 1,2: give 6 numbers",
        ),
        (
            &["trace", "cube.obj", "-o", "old.h5", "--tolerance", "-1"],
            2,
            "--tolerance -1: give a number",
        ),
        (
            &["trace", "cube.obj", "-o", "old.h5", "--sampler", "halton"],
            2,
            "invalid value 'halton'",
        ),
        (&["trace", "none.obj", "-o", "old.h5"], 1, "none.obj"),
        (&["trace", "bad.obj", "-o", "old.h5"], 1, "bad.obj"),
        (
            &["trace", "cube.obj", "-o", "no/such/folder.h5"],
            1,
            "no/such",
        ),
        (&["inspect", "old.h5"], 1, "old.h5: is not an HDF5 file"),
        (&["design", "pentagon", "-o", "x.obj"], 2, "pentagon"),
        (
            &["design", "triangular", "-o", "x.stl"],
            2,
            "x.stl: the extension must be .obj or .glb",
        ),
    ];
    let mut refused = 0;
    for (arguments, code, sentence) in cases {
        let output = bake(here, arguments);
        let message = text(&output.stderr);
        assert_eq!(
            output.status.code(),
            Some(code),
            "bake {arguments:?}: {message}"
        );
        assert!(
            message.contains(sentence),
            "bake {arguments:?} should say \"{sentence}\": {message}"
        );
        assert_eq!(
            std::fs::read(here.join("old.h5")).expect("still there"),
            b"precious"
        );
        refused += 1;
    }
    assert_eq!(refused, 11);
    let left: Vec<_> = std::fs::read_dir(here)
        .expect("lists")
        .flatten()
        .map(|entry| entry.file_name())
        .collect();
    assert_eq!(left.len(), 3, "no half-written file stays: {left:?}");
}

/// Bakes a table for each wavelength with the indices of that wavelength, and checks it by photons.
#[test]
fn prisms_with_losses_at_several_wavelengths() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    good(here, &["design", "triangular-pair", "-o", "pair.obj"]);
    let losses = [
        "--losses",
        "fresnel",
        "--metal",
        "silver",
        "--incidence",
        "0,30",
    ];
    let glass = [
        "--refractive-index",
        "pmma",
        "--wavelength-nm",
        "450,650",
        "--json",
    ];
    let trace = ["trace", "pair.obj", "-o", "pair-{nm}.h5"];
    let said = good(here, &[&trace[..], &losses, &glass].concat());
    let said: serde_json::Value = serde_json::from_str(&said).expect("one JSON object");
    let mut etas = Vec::new();
    for (k, (nm, index)) in [(450.0, "1.50061"), (650.0, "1.48809")]
        .into_iter()
        .enumerate()
    {
        let file = format!("pair-{nm}.h5");
        assert_eq!(said["tables"][k]["table"], file.as_str());
        let held = good(here, &["inspect", &file, "--json"]);
        let held: serde_json::Value = serde_json::from_str(&held).expect("JSON");
        assert_eq!(held["wavelength_nm"], nm);
        assert_eq!(
            format!(
                "{:.5}",
                held["refractive_index"].as_f64().expect("a number")
            ),
            index
        );
        assert_eq!(held["losses"], "fresnel");
        assert!(held["metal_index"][1].as_f64().expect("k") > 2.0);
        etas.push(
            held["directions"][0]["retroreflected"]
                .as_f64()
                .expect("eta"),
        );
        let text = good(here, &["inspect", &file]);
        assert!(
            text.contains("mirror, fresnel, metal of index 0.1"),
            "{text}"
        );
        let judged = good(
            here,
            &["verify", &file, "--mesh", "pair.obj", "--rays", "65536"],
        );
        assert!(
            judged.contains("yes") && !judged.contains(" no\n"),
            "{judged}"
        );
    }
    // Silver reflects red better than blue. Both tables keep less than two thirds of the light,
    // because of the front face and three reflections.
    assert!(
        0.4 < etas[0] && etas[0] < etas[1] && etas[1] < 0.6,
        "{etas:?}"
    );
    let refusals: [(&[&str], &str); 6] = [
        (&["--wavelength-nm", "450,650"], "names 2 wavelengths"),
        (
            &["--refractive-index", "pmma"],
            "pmma depends on the wavelength",
        ),
        (&["--refractive-index", "wood"], "pmma, polycarbonate, bk7"),
        (
            &["--metal", "silver", "--wavelength-nm", "550"],
            "--metal needs --losses fresnel",
        ),
        (&["--metal", "tin"], "--metal tin: give aluminium, silver"),
        (
            &["--losses", "fresnel", "--reflectance", "0"],
            "--reflectance 0",
        ),
    ];
    for (options, sentence) in refusals {
        let refused = bake(
            here,
            &[&["trace", "pair.obj", "-o", "x.h5"], options].concat(),
        );
        let message = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{message}");
        assert!(message.contains(sentence), "{message}");
    }
    let refused = bake(here, &trace);
    assert!(text(&refused.stderr).contains("{nm} stands for a wavelength"));
    assert!(!here.join("x.h5").exists());
}

/// Checks that a sheet of many cubes is taken apart without a message.
///
/// Where the digits of the file do not allow it, one line says why.
#[test]
fn a_sheet_that_is_traced_as_a_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    good(here, &["design", "triangular-pair", "-o", "pair.obj"]);
    let pair = meshes::load(&here.join("pair.obj")).expect("a mesh");
    let [right, up] = [1, 2].map(|corner| pair.positions[corner] - pair.positions[3]);
    let sheet = |number: &dyn Fn(f64) -> String| {
        let (mut obj, mut first) = (String::new(), 1);
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (f64::from(i), f64::from(j)))) {
            for &p in &pair.positions {
                let [x, y, z] = (p + right * i + up * j).to_array().map(number);
                obj += &format!("v {x} {y} {z}\n");
            }
            for [a, b, c] in &pair.triangles {
                obj += &format!("f {} {} {}\n", a + first, b + first, c + first);
            }
            first += pair.positions.len() as u32;
        }
        obj
    };
    let solid = ["--refractive-index", "1.49", "--incidence", "20"];
    let trace = [&["trace", "sheet.obj", "-o", "sheet.h5"], &solid[..]].concat();
    std::fs::write(here.join("sheet.obj"), sheet(&|x| x.to_string())).expect("writes");
    assert!(good(here, &trace).contains("method exact"));
    let rounded = sheet(&|x| format!("{:.6}", x * 0.057_735_03));
    std::fs::write(here.join("sheet.obj"), rounded).expect("writes");
    let output = bake(here, &trace);
    assert!(output.status.success());
    let message = text(&output.stderr);
    assert!(
        message.contains("the mesh is traced as a whole") && message.contains("to the last digit"),
        "{message}"
    );
}

/// Checks that a picture cannot take the place of a table or of another output.
#[test]
fn outputs_that_would_be_lost_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    good(here, &["design", "triangular", "-o", "cube.obj"]);
    good(
        here,
        &[
            "trace",
            "cube.obj",
            "-o",
            "cube.h5",
            "--incidence",
            "0",
            "--refractive-index",
            "1",
        ],
    );
    // `bake` would not give a table this name.
    std::fs::rename(here.join("cube.h5"), here.join("cube.svg")).expect("a table");
    let table = std::fs::read(here.join("cube.svg")).expect("a table");
    let refused = bake(here, &["inspect", "cube.svg", "--plot", "./cube.svg"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(text(&refused.stderr).contains("is an input of this command"));
    let refused = bake(
        here,
        &[
            "study", "cube.obj", "--csv", "a.svg", "--plot", "./a.svg", "--rays", "1024",
        ],
    );
    assert_eq!(refused.status.code(), Some(1));
    assert!(text(&refused.stderr).contains("named for two outputs"));
    assert_eq!(
        std::fs::read(here.join("cube.svg")).expect("still there"),
        table
    );
}

/// Checks that the program fails if its results cannot be written.
#[test]
fn a_full_standard_output_is_a_failure() {
    let full = std::fs::File::options()
        .write(true)
        .open("/dev/full")
        .expect("Linux has one");
    let output = Command::new(env!("CARGO_BIN_EXE_bake"))
        .args(["design", "--list"])
        .stdout(full)
        .output()
        .expect("bake runs");
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("standard output cannot be written"));
}

#[test]
fn every_verb_helps_with_an_example() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut verbs = 0;
    for verb in [
        "design", "trace", "study", "inspect", "compare", "verify", "merge",
    ] {
        assert!(
            good(folder.path(), &[verb, "--help"]).contains("Example"),
            "bake {verb} --help"
        );
        verbs += 1;
    }
    assert_eq!(verbs, 7);
}

/// Checks that one process refuses a run of several processes without the feature `mpi`.
///
/// Without MPI the processes do not know of each other. Each would do the whole bake and write over
/// the others.
#[cfg(not(feature = "mpi"))]
#[test]
fn without_mpi_a_run_of_many_is_refused_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = |rank: &str, line: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_bake"))
            .current_dir(folder.path())
            .args(line.split(' '))
            .envs([
                ("OMPI_COMM_WORLD_SIZE", "2"),
                ("OMPI_COMM_WORLD_RANK", rank),
            ])
            .output()
            .expect("bake runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), said)
    };
    assert_eq!(
        run("0", "design triangular -o cell.obj"),
        (Some(0), String::new())
    );
    let (code, said) = run("0", "trace cell.obj -o table.h5");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("one of 2 processes"), "{said}");
    assert_eq!(
        run("1", "trace cell.obj -o table.h5"),
        (Some(0), String::new())
    );
    assert!(!folder.path().join("table.h5").exists());
    let share = "trace cell.obj -o table.h5 --method rays --rays 1000 --shard 1/2 \
                 --refractive-index 1";
    assert_eq!(run("0", share), (Some(0), String::new()));
}
