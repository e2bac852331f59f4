//! Tests of a bake in parts, through the program: shards, directions and more rays.
//!
//! They also check a table against its mesh.

use std::path::Path;
use std::process::{Command, Output};

fn bake(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bake"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("bake runs")
}

fn good(folder: &Path, arguments: &[&str]) -> String {
    let output = bake(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "bake {arguments:?}: {message}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn refused(folder: &Path, arguments: &[&str], code: i32, sentence: &str) {
    let output = bake(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(
        output.status.code(),
        Some(code),
        "bake {arguments:?}: {message}"
    );
    assert!(
        message.contains(sentence),
        "\"{message}\" should say \"{sentence}\""
    );
}

fn trace<'a>(file: &'a str, options: &[&'a str]) -> Vec<&'a str> {
    let common = ["trace", "pair.obj", "-o", file, "--bins", "32"];
    [&common[..], options].concat()
}

#[test]
fn a_bake_in_parts_has_the_bytes_of_the_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    good(here, &["design", "triangular-pair", "-o", "pair.obj"]);
    let bytes = |file: &str| std::fs::read(here.join(file)).expect("a table");
    let mut compared = 0;
    for sampler in ["sobol", "random"] {
        let rays = [
            "--method",
            "rays",
            "--rays",
            "100003",
            "--incidence",
            "0,20,40",
            "--azimuth",
            "0,30",
            "--sampler",
            sampler,
        ];
        good(here, &trace("whole.h5", &rays));
        for of in [2, 5] {
            let files: Vec<String> = (1..=of).rev().map(|k| format!("{k}.h5")).collect();
            for (file, k) in files.iter().zip((1..=of).rev()) {
                let shard = format!("{k}/{of}");
                good(
                    here,
                    &[&trace(file, &rays)[..], &["--shard", &shard]].concat(),
                );
            }
            let names: Vec<&str> = files.iter().map(String::as_str).collect();
            good(here, &[&["merge", "-o", "merged.h5"], &names[..]].concat());
            assert!(
                bytes("merged.h5") == bytes("whole.h5"),
                "{sampler}, {of} shards"
            );
            compared += 1;
        }
    }
    // Tables of some directions are merged too, made by rays and by the exact method.
    for method in ["rays", "exact"] {
        let of = |incidence: &'static str, azimuth: &'static str| {
            [
                "--method",
                method,
                "--incidence",
                incidence,
                "--azimuth",
                azimuth,
            ]
        };
        good(here, &trace("whole.h5", &of("0:40:20", "0,30")));
        good(here, &trace("a.h5", &of("0,40", "0,30")));
        good(here, &trace("b.h5", &of("20", "30")));
        good(here, &trace("c.h5", &of("20", "0")));
        good(here, &["merge", "a.h5", "b.h5", "c.h5", "-o", "merged.h5"]);
        assert!(bytes("merged.h5") == bytes("whole.h5"), "{method}");
        refused(
            here,
            &["merge", "a.h5", "b.h5", "-o", "merged.h5"],
            1,
            "no table holds incidence 20 deg, azimuth 0 deg",
        );
        refused(
            here,
            &["merge", "a.h5", "a.h5", "-o", "merged.h5"],
            1,
            "counted twice",
        );
        compared += 1;
    }
    assert_eq!(compared, 6);
    assert!(
        bytes("merged.h5") == bytes("whole.h5"),
        "a refusal leaves the output"
    );
}

#[test]
fn rays_are_added_in_place() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    good(here, &["design", "triangular-pair", "-o", "pair.obj"]);
    let rays = [
        "--method",
        "rays",
        "--rays",
        "50000",
        "--sampler",
        "random",
        "--incidence",
        "10",
    ];
    good(
        here,
        &[&trace("table.h5", &rays)[..], &["--seed", "7"]].concat(),
    );
    good(
        here,
        &[&trace("more.h5", &rays)[..], &["--seed", "8"]].concat(),
    );
    let report = good(
        here,
        &["merge", "table.h5", "more.h5", "-o", "table.h5", "--json"],
    );
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["rays"], 100_000);
    assert_eq!(report["seed"], 7);
    good(
        here,
        &[&trace("far.h5", &rays)[..], &["--seed", "11"]].concat(),
    );
    refused(
        here,
        &["merge", "table.h5", "far.h5", "-o", "table.h5"],
        1,
        "--seed 9",
    );
    // The message names the field in which two bakes differ.
    let index = ["--refractive-index", "1.5", "--seed", "9"];
    good(here, &[&trace("other.h5", &rays)[..], &index].concat());
    refused(
        here,
        &["merge", "table.h5", "other.h5", "-o", "x.h5"],
        1,
        "refractive_index of table 1 is 1.5",
    );
    // Some shards alone make a table too, which says what it lacks.
    good(
        here,
        &[&trace("some.h5", &rays)[..], &["--shard", "2/3"]].concat(),
    );
    assert!(good(here, &["inspect", "some.h5"]).contains("2/3 of 50000 rays"));
    refused(
        here,
        &[&trace("x.h5", &[])[..], &["--shard", "1/2"]].concat(),
        2,
        "--method rays",
    );
}

#[test]
fn a_mesh_judges_its_table() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = folder.path();
    good(here, &["design", "triangular-pair", "-o", "pair.obj"]);
    good(here, &["design", "canted", "-o", "canted.obj"]);
    let mut judged = 0;
    for (file, options) in [
        (
            "exact.h5",
            vec!["--azimuth", "0:60:20", "--refractive-index", "1.49"],
        ),
        ("sobol.h5", vec!["--method", "rays", "--rays", "200000"]),
        (
            "mean.h5",
            vec!["--method", "rays", "--rays", "200000", "--azimuth", "mean"],
        ),
    ] {
        good(here, &trace(file, &options));
        for seed in ["1", "2", "3"] {
            let rays = ["--rays", "100000", "--seed", seed];
            let report = good(
                here,
                &[&["verify", file, "--mesh", "pair.obj", "--json"], &rays[..]].concat(),
            );
            let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
            assert_eq!(report["mesh_agrees"], true, "{file}, seed {seed}");
            judged += 1;
        }
        refused(
            here,
            &["verify", file, "--mesh", "canted.obj"],
            1,
            "does not agree with the rays through canted.obj",
        );
    }
    assert_eq!(judged, 9);
}
