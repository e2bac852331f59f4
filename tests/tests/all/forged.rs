//! Exact tables that were changed and sealed again. `fit` computes with the polygons, so `bake
//! verify` and `bake compare` must look at them.

use std::path::Path;

use tables::Table;
use tests::files::bake_table_with;
use tests::program::bake;

/// Change of a table.
type Change = fn(&mut Table);

/// Scales the maps of all paths: the shifts become half as large again.
fn scaled(table: &mut Table) {
    for path in table.exact.as_mut().unwrap().paths.iter_mut().flatten() {
        path.matrix = path.matrix.map(|row| row.map(|x| 1.5 * x));
        path.offset = path.offset.map(|x| 1.5 * x);
    }
}

/// Turns the light of all paths by a milliradian.
fn turned(table: &mut Table) {
    for path in table.exact.as_mut().unwrap().paths.iter_mut().flatten() {
        path.deviation[0] += 1e-3;
    }
}

/// Moves the light of one direction out of the range, in the fates only.
fn out_of_range(table: &mut Table) {
    use tables::Fate;
    let moved = table.fate[[1, 0, Fate::Retroreflected as usize]];
    table.fate[[1, 0, Fate::Retroreflected as usize]] = 0.0;
    table.fate[[1, 0, Fate::OutOfRange as usize]] += moved;
}

/// Turns each histogram by half a turn, which keeps its sum.
fn reversed(table: &mut Table) {
    let all: Vec<f64> = table.histogram.iter().copied().collect();
    let each = table.axes.bins.pow(2);
    let turned = all.chunks(each).flat_map(|one| one.iter().rev());
    for (to, from) in table.histogram.iter_mut().zip(turned) {
        *to = *from;
    }
    // Ideal cubes have symmetric histograms: one bin more makes a difference.
    let mut first = table.histogram.iter_mut();
    let (a, b) = (first.next().unwrap(), first.next().unwrap());
    (*a, *b) = (0.5 * (*a + *b) + 1e-3, 0.5 * (*a + *b));
    let sum: f64 = table.histogram.iter().take(each).sum();
    table
        .histogram
        .iter_mut()
        .take(each)
        .for_each(|p| *p /= sum);
}

/// Reads the honest table, changes it, and writes it with a new hash and seal.
fn forge(here: &Path, change: Change) {
    let mut table = tables::read(&here.join("honest.h5")).unwrap();
    change(&mut table);
    tables::write(&table, &here.join("forged.h5")).unwrap();
}

#[test]
fn a_changed_and_sealed_table_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let made = bake_table_with(here, "triangular-pair", "0:40:20", "30", &["--bins", "64"]);
    std::fs::rename(here.join(made), here.join("honest.h5")).unwrap();
    let mesh = ["--mesh", "triangular-pair.obj", "--rays", "65536"];

    let verified = bake(here, &[&["verify", "honest.h5"], &mesh[..]].concat()).done();
    assert!(verified.contains("path by path"), "{verified}");
    bake(here, &["compare", "honest.h5", "honest.h5"]).done();

    let inconsistent = "the polygons at incidence";
    let rebaked = "the exact bake of triangular-pair.obj made again";
    let cases: [(&str, Change, Option<&str>, &str); 4] = [
        ("maps times 1.5", scaled, Some(inconsistent), inconsistent),
        ("fates", out_of_range, Some(inconsistent), inconsistent),
        ("histogram", reversed, Some(inconsistent), inconsistent),
        // Polygons that agree with all else: only the mesh tells.
        ("exit directions", turned, None, rebaked),
    ];
    for (what, change, alone, with_mesh) in cases {
        forge(here, change);
        let verify = bake(here, &["verify", "forged.h5"]);
        match alone {
            Some(says) => {
                assert_eq!(verify.code, Some(1), "{what}: {}", verify.out);
                assert!(verify.err.contains(says), "{what}: {}", verify.err);
                assert!(
                    verify.err.contains("bake it again"),
                    "{what}: {}",
                    verify.err
                );
            }
            None => assert_eq!(verify.code, Some(0), "{what}: {}", verify.err),
        }
        let verify = bake(here, &[&["verify", "forged.h5"], &mesh[..]].concat());
        assert_eq!(verify.code, Some(1), "{what}: {}", verify.out);
        assert!(verify.err.contains(with_mesh), "{what}: {}", verify.err);
    }
    for change in [scaled, turned] {
        forge(here, change);
        let compared = bake(here, &["compare", "honest.h5", "forged.h5"]);
        assert_eq!(compared.code, Some(1), "{}", compared.out);
        assert!(
            compared.err.contains("the tables differ"),
            "{}",
            compared.err
        );
    }
    println!("{} forgeries", cases.len());
}

/// Cuts every polygon in two, from its first corner to the middle of its second edge, and turns the
/// order of the paths around.
fn recut(table: &mut Table) {
    for paths in &mut table.exact.as_mut().unwrap().paths {
        let halves = paths.iter().rev().flat_map(|path| {
            let (first, [a, b]) = (path.polygon[0], [path.polygon[1], path.polygon[2]]);
            let middle = [0, 1].map(|k| f64::midpoint(a[k], b[k]));
            let polygons = [
                vec![first, a, middle],
                [&[first, middle], &path.polygon[2..]].concat(),
            ];
            polygons.map(|polygon| tables::Path {
                polygon,
                ..path.clone()
            })
        });
        *paths = halves.collect();
    }
}

/// Moves the light of one half by a millionth of an edge length.
fn moved(table: &mut Table) {
    table.exact.as_mut().unwrap().paths[0][0].offset[0] += 1e-6;
}

/// Tables of equal light in other polygons agree; what is changed besides is noticed.
#[test]
fn tables_with_other_cuts_agree() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let cells = ["triangular-pair", "triangular", "full-cube", "canted"];
    let changes: [(&str, Change); 3] = [
        ("maps times 1.5", scaled),
        ("exit directions", turned),
        ("the shift of one half", moved),
    ];
    for cell in cells {
        let made = bake_table_with(here, cell, "0:40:20", "0,30", &["--bins", "64"]);
        std::fs::rename(here.join(made), here.join("honest.h5")).unwrap();
        forge(here, recut);
        bake(here, &["verify", "forged.h5"]).done();
        bake(here, &["compare", "honest.h5", "forged.h5"]).done();
        bake(here, &["compare", "forged.h5", "honest.h5"]).done();
        for (what, change) in changes {
            let mut table = tables::read(&here.join("honest.h5")).unwrap();
            recut(&mut table);
            change(&mut table);
            tables::write(&table, &here.join("forged.h5")).unwrap();
            let compared = bake(here, &["compare", "honest.h5", "forged.h5"]);
            assert_eq!(compared.code, Some(1), "{cell}, {what}: {}", compared.out);
        }
    }
    println!("{} cells, {} changes of each", cells.len(), changes.len());
}

/// Exit directions of tables of rays: two seeds agree, a turned copy does not.
#[test]
fn exit_directions_of_rays_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let errors = [
        "design",
        "triangular",
        "--dihedral-error-mrad",
        "1,1,1",
        "-o",
        "worn.obj",
    ];
    bake(here, &errors).done();
    for (name, seed) in [("a.h5", "1"), ("b.h5", "2")] {
        let trace = [
            "trace",
            "worn.obj",
            "-o",
            name,
            "--method",
            "rays",
            "--rays",
            "65536",
            "--sampler",
            "random",
            "--seed",
            seed,
            "--incidence",
            "10",
            "--bins",
            "32",
            "--deviations",
            "20",
            "--refractive-index",
            "1",
        ];
        bake(here, &trace).done();
    }
    let agreed = bake(here, &["compare", "a.h5", "b.h5", "--json"]).done();
    assert!(!agreed.contains("\"exits_l1\":null"), "{agreed}");
    let mut table = tables::read(&here.join("a.h5")).unwrap();
    let deviations = table.deviations.as_mut().unwrap();
    let bins = deviations.grid.bins as u64;
    // Two bins across, within the same cell of shifts; counts and shifts stay as they are.
    for entry in deviations.entries.iter_mut().flatten() {
        if entry.place % bins + 2 < bins {
            entry.place += 2;
        }
    }
    tables::write(&table, &here.join("turned.h5")).unwrap();
    let compared = bake(here, &["compare", "a.h5", "turned.h5"]);
    assert_eq!(compared.code, Some(1), "{}", compared.out);
}

/// Exit directions of an exact table and of tables of rays: honest ones agree, those whose light is
/// turned, all of it or one path of it, do not.
#[test]
fn exit_directions_of_polygons_and_rays_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let worn = [
        "design",
        "triangular-pair",
        "--dihedral-error-mrad",
        "1,0.5,-0.7",
    ];
    bake(here, &[&worn[..], &["-o", "worn.obj"]].concat()).done();
    let asked = [
        "--incidence",
        "0:40:5",
        "--azimuth",
        "0:50:10",
        "--bins",
        "16",
    ];
    let trace = |name: &str, method: &[&str]| {
        let files = [
            "trace",
            "worn.obj",
            "-o",
            name,
            "--refractive-index",
            "1.49",
        ];
        bake(here, &[&files[..], &asked, method].concat()).done();
    };
    trace("honest.h5", &["--method", "exact"]);
    let exact = tables::read(&here.join("honest.h5")).unwrap();
    let rows = |first: &str, second: &str| {
        let run = bake(here, &["compare", first, second, "--json"]);
        let said: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        (run.code, said["directions"].as_array().unwrap().clone())
    };
    let ratio = |row: &serde_json::Value| {
        row["exits_l1"].as_f64().unwrap() / row["exits_limit"].as_f64().unwrap()
    };
    let (mut compared, mut largest) = (0, 0.0_f64);
    for seed in ["1", "2", "3"] {
        for sampler in ["random", "sobol"] {
            let rays = [
                "--method",
                "rays",
                "--rays",
                "16384",
                "--seed",
                seed,
                "--sampler",
                sampler,
            ];
            trace("rays.h5", &rays);
            for (first, second) in [("honest.h5", "rays.h5"), ("rays.h5", "honest.h5")] {
                let (_, rows) = rows(first, second);
                compared += rows.len();
                largest = rows.iter().map(ratio).fold(largest, f64::max);
            }
        }
    }
    // The limit is 5 standard deviations above the mean: no row comes near it by chance, and a
    // limit that is far too wide would show here.
    assert!((0.2..1.0).contains(&largest), "{largest}");

    let one: Change = |table| {
        for paths in &mut table.exact.as_mut().unwrap().paths {
            paths[0].deviation[1] += 1e-3;
        }
    };
    let forgeries: [(&str, Change); 2] = [("all", turned), ("one", one)];
    for (what, change) in forgeries {
        let mut table = exact.clone();
        change(&mut table);
        tables::write(&table, &here.join("forged.h5")).unwrap();
        let (code, rows) = rows("forged.h5", "rays.h5");
        assert_eq!(code, Some(1), "{what}");
        let noticed = rows.iter().filter(|row| ratio(row) > 1.0).count();
        println!(
            "turned {what}: noticed in {noticed} of {} directions",
            rows.len()
        );
        assert!(noticed * 10 > rows.len() * 9, "{what}: {noticed}");
    }
    println!("{compared} directions compared, the largest at {largest:.2} of the limit");
}
