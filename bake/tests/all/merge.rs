//! Tests of a bake in parts, through the program: shards, directions and more rays.
//!
//! They also check a table against its mesh.

use crate::program::Folder;

/// Bakes a table of the pair.
fn trace(folder: &Folder, file: &str, options: &str) {
    let line = format!("trace triangular-pair.obj -o {file} --bins 32 {options}");
    folder.good(&line);
}

#[test]
fn a_bake_in_parts_has_the_bytes_of_the_whole() {
    let folder = Folder::with(&["triangular-pair"]);
    let same = || folder.read("merged.h5") == folder.read("whole.h5");
    let mut compared = 0;
    for sampler in ["sobol", "random"] {
        let rays = "--method rays --rays 100003 --incidence 0,20,40 --azimuth 0,30";
        let rays = format!("{rays} --sampler {sampler}");
        trace(&folder, "whole.h5", &rays);
        for of in [2, 5] {
            let mut line = String::from("merge -o merged.h5");
            for k in (1..=of).rev() {
                trace(
                    &folder,
                    &format!("{k}.h5"),
                    &format!("{rays} --shard {k}/{of}"),
                );
                line += &format!(" {k}.h5");
            }
            folder.good(&line);
            assert!(same(), "{sampler}, {of} shards");
            compared += 1;
        }
    }
    // Tables of some directions are merged too, made by rays and by the exact method.
    for method in ["rays", "exact"] {
        for (file, incidence, azimuth) in [
            ("whole.h5", "0:40:20", "0,30"),
            ("a.h5", "0,40", "0,30"),
            ("b.h5", "20", "30"),
            ("c.h5", "20", "0"),
        ] {
            let directions = format!("--incidence {incidence} --azimuth {azimuth}");
            trace(&folder, file, &format!("--method {method} {directions}"));
        }
        folder.good("merge a.h5 b.h5 c.h5 -o merged.h5");
        assert!(same(), "{method}");
        let gap = "no table holds incidence 20 deg, azimuth 0 deg";
        folder.refused("merge a.h5 b.h5 -o merged.h5", 1, gap);
        folder.refused("merge a.h5 a.h5 -o merged.h5", 1, "counted twice");
        compared += 1;
    }
    assert_eq!(compared, 6);
    assert!(same(), "a refusal leaves the output");
}

#[test]
fn rays_are_added_in_place() {
    let folder = Folder::with(&["triangular-pair"]);
    for (file, options) in [
        ("table.h5", "--seed 7"),
        ("more.h5", "--seed 8"),
        ("far.h5", "--seed 11"),
        ("other.h5", "--seed 9 --refractive-index 1.5"),
        ("some.h5", "--shard 2/3"),
    ] {
        let rays = "--method rays --rays 50000 --sampler random --incidence 10";
        trace(&folder, file, &format!("{rays} {options}"));
    }
    let report = folder.json("merge table.h5 more.h5 -o table.h5 --json");
    assert_eq!(report["rays"], 100_000);
    assert_eq!(report["seed"], 7);
    folder.refused("merge table.h5 far.h5 -o table.h5", 1, "--seed 9");
    // The message names the field in which two bakes differ.
    let field = "refractive_index of table 1 is 1.5";
    folder.refused("merge table.h5 other.h5 -o x.h5", 1, field);
    // Some shards alone make a table too, which says what it lacks.
    let some = folder.good("inspect some.h5");
    assert!(some.contains("2/3 of 50000 rays"), "{some}");
    let exact = "trace triangular-pair.obj -o x.h5 --shard 1/2";
    folder.refused(exact, 2, "--method rays");
}

#[test]
fn a_mesh_judges_its_table() {
    let folder = Folder::with(&["triangular-pair", "canted"]);
    let mut judged = 0;
    for (file, options) in [
        ("exact.h5", "--azimuth 0:60:20 --refractive-index 1.49"),
        ("sobol.h5", "--method rays --rays 200000"),
        ("mean.h5", "--method rays --rays 200000 --azimuth mean"),
    ] {
        trace(&folder, file, options);
        for seed in [1, 2, 3] {
            let rays = format!("--rays 100000 --seed {seed} --json");
            let line = format!("verify {file} --mesh triangular-pair.obj {rays}");
            assert_eq!(folder.json(&line)["mesh_agrees"], true, "{file}, {seed}");
            judged += 1;
        }
        let other = "does not agree with the rays through canted.obj";
        folder.refused(&format!("verify {file} --mesh canted.obj"), 1, other);
    }
    assert_eq!(judged, 9);
}
