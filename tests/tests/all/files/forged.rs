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
    let made = bake_table_with(here, "triangular-pair", "0:40:20", "30", "--bins 64");
    std::fs::rename(here.join(made), here.join("honest.h5")).unwrap();
    let mesh = "--mesh triangular-pair.obj --rays 65536";

    let verified = bake(here, &format!("verify honest.h5 {mesh}")).done();
    assert!(verified.contains("path by path"), "{verified}");
    bake(here, "compare honest.h5 honest.h5").done();

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
        let verify = bake(here, "verify forged.h5");
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
        let verify = bake(here, &format!("verify forged.h5 {mesh}"));
        assert_eq!(verify.code, Some(1), "{what}: {}", verify.out);
        assert!(verify.err.contains(with_mesh), "{what}: {}", verify.err);
    }
    for change in [scaled, turned] {
        forge(here, change);
        let compared = bake(here, "compare honest.h5 forged.h5");
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
        let made = bake_table_with(here, cell, "0:40:20", "0,30", "--bins 64");
        std::fs::rename(here.join(made), here.join("honest.h5")).unwrap();
        forge(here, recut);
        bake(here, "verify forged.h5").done();
        bake(here, "compare honest.h5 forged.h5").done();
        bake(here, "compare forged.h5 honest.h5").done();
        for (what, change) in changes {
            let mut table = tables::read(&here.join("honest.h5")).unwrap();
            recut(&mut table);
            change(&mut table);
            tables::write(&table, &here.join("forged.h5")).unwrap();
            let compared = bake(here, "compare honest.h5 forged.h5");
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
    let errors = "design triangular --dihedral-error-mrad 1,1,1 -o worn.obj";
    bake(here, errors).done();
    for (name, seed) in [("a.h5", "1"), ("b.h5", "2")] {
        let trace = format!(
            "trace worn.obj -o {name} --method rays --rays 65536 --sampler random --seed {seed} \
                --incidence 10 --bins 32 --deviations 20 --refractive-index 1"
        );
        bake(here, &trace).done();
    }
    let agreed = bake(here, "compare a.h5 b.h5 --json").done();
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
    let compared = bake(here, "compare a.h5 turned.h5");
    assert_eq!(compared.code, Some(1), "{}", compared.out);
}

/// Exit directions of an exact table and of tables of rays: honest ones agree, those whose light is
/// turned, all of it or one path of it, do not.
#[test]
fn exit_directions_of_polygons_and_rays_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let worn = "design triangular-pair --dihedral-error-mrad 1,0.5,-0.7";
    bake(here, &format!("{worn} -o worn.obj")).done();
    let asked = "--incidence 0:40:5 --azimuth 0:50:10 --bins 16";
    let trace = |name: &str, method: &str| {
        let files = format!("trace worn.obj -o {name} --refractive-index 1.49");
        bake(here, &format!("{files} {asked} {method}")).done();
    };
    trace("honest.h5", "--method exact");
    let exact = tables::read(&here.join("honest.h5")).unwrap();
    let rows = |first: &str, second: &str| {
        let run = bake(here, &format!("compare {first} {second} --json"));
        let said: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        (run.code, said["directions"].as_array().unwrap().clone())
    };
    let ratio = |row: &serde_json::Value| {
        row["exits_l1"].as_f64().unwrap() / row["exits_limit"].as_f64().unwrap()
    };
    let (mut compared, mut largest) = (0, 0.0_f64);
    for seed in ["1", "2", "3"] {
        for sampler in ["random", "sobol"] {
            let rays = format!("--method rays --rays 16384 --seed {seed} --sampler {sampler}");
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

/// Returns what `bake verify --mesh --json` said of a table, and its exit code.
fn judged(here: &Path, table: &str, mesh: &str, more: &str) -> (Option<i32>, serde_json::Value) {
    let words = format!("verify {table} --mesh {mesh} --rays 65536 --json");
    let run = bake(here, &format!("{words} {more}"));
    let said = serde_json::from_str(&run.out);
    let said = said.unwrap_or(serde_json::Value::String(run.err));
    (run.code, said)
}

/// Names of the attributes that `bake verify` lists under `key`.
fn listed(said: &serde_json::Value, key: &str) -> Vec<String> {
    let all = said[key].as_array().into_iter().flatten();
    let names = all.map(|one| one["attribute"].as_str().unwrap().to_owned());
    names.collect()
}

/// Stretches the counted shifts of a direction by 1/1.5: the number in each bin goes to the bin at
/// two thirds of its place.
fn stretched(table: &mut Table, i: usize, j: usize) {
    let bins = table.axes.bins;
    let mut counts = table.counts.clone().unwrap();
    let half = 0.5 * bins as f64;
    let to = |k: usize| ((k as f64 + 0.5 - half) / 1.5 + half) as usize;
    for r in 0..counts.shape()[2] {
        let mut moved = vec![vec![0; bins]; bins];
        for (v, u) in (0..bins).flat_map(|v| (0..bins).map(move |u| (v, u))) {
            moved[to(v)][to(u)] += counts[[i, j, r, v, u]];
        }
        for (v, row) in moved.iter().enumerate() {
            for (u, &rays) in row.iter().enumerate() {
                counts[[i, j, r, v, u]] = rays;
            }
        }
    }
    let (fates, from) = (table.fate_counts.clone(), table.provenance.clone());
    *table = Table::from_counts(table.axes.clone(), counts, fates.unwrap(), from);
}

/// Tables of counts whose shifts are stretched in some directions: the seed of the check cannot be
/// known before, so those that an earlier check left out are no better; and where the exact method
/// takes the cell, one direction of ten is noticed too.
#[test]
fn stretched_directions_are_noticed_wherever_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let rays = |n| format!("--method rays --rays {n} --bins 64");
    let mut cases = 0;
    // 2,000 rays have more noise in their bins than light, but not in bins taken together.
    for n in ["262144", "2000"] {
        let made = bake_table_with(here, "triangular-pair", "0:45:5", "30", &rays(n));
        let honest = tables::read(&here.join(&made)).unwrap();
        let mesh = "triangular-pair.obj";
        for seed in ["1", "2", "3"] {
            let (code, said) = judged(here, &made, mesh, &format!("--seed {seed}"));
            assert_eq!(
                (code, &said["exact_bake_agrees"]),
                (Some(0), &true.into()),
                "{said}"
            );
            assert_eq!(said["directions_baked"], 10);
        }
        // The directions that the seed 1 left out, all of them and one.
        for which in [&[0, 1, 2, 4, 5, 7][..], &[4]] {
            let mut table = honest.clone();
            which.iter().for_each(|&i| stretched(&mut table, i, 0));
            tables::write(&table, &here.join("forged.h5")).unwrap();
            let (code, said) = judged(here, "forged.h5", mesh, "");
            assert_eq!(
                (code, &said["exact_bake_agrees"]),
                (Some(1), &false.into()),
                "{said}"
            );
            cases += 1;
        }
    }
    // Facets that stand for curved ones: rays look at all directions.
    let curved = "design triangular-pair --sag 0.0002 --segments 4 -o curved.glb";
    let curved = bake(here, curved);
    assert_eq!(curved.code, Some(0), "{}", curved.err);
    let trace = "trace curved.glb -o curved.h5 --normals file --method rays --incidence 0:45:5 \
        --azimuth 30 --rays 65536 --bins 64 --refractive-index 1.49";
    bake(here, trace).done();
    let (code, said) = judged(here, "curved.h5", "curved.glb", "");
    assert_eq!(
        (code, &said["directions_traced"]),
        (Some(0), &10.into()),
        "{said}"
    );
    let mut table = tables::read(&here.join("curved.h5")).unwrap();
    let exits = table.deviations.take();
    assert!(exits.is_some());
    tables::write(&table, &here.join("forged.h5")).unwrap();
    let (code, said) = judged(here, "forged.h5", "curved.glb", "");
    assert_eq!(
        (code, listed(&said, "contradictions")),
        (Some(1), vec!["group deviation".into()])
    );
    cases += 1;
    println!("{cases} forgeries");
}

/// Each change of what a table says about its bake is refused, or listed as not checked.
#[test]
fn what_a_table_says_is_checked_or_listed() {
    use tables::Fate;
    use tables::options::{Back, Method, Word};
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let options = "--bins 32 --direction-tolerance 0.02";
    let made = bake_table_with(here, "full-cube", "0,15", "0,30", options);
    let mesh = "full-cube.obj";
    let honest = tables::read(&here.join(&made)).unwrap();
    let (code, said) = judged(here, &made, mesh, "");
    assert_eq!(code, Some(0), "{said}");
    let texts = "frame, azimuths, units, long_name";
    // Below 18.9 degrees bare facets of index 1.49 reflect all light, as mirrors do; but they turn its
    // polarisation.
    assert_eq!(listed(&said, "unchecked"), [texts]);
    assert!(said["error_between"].as_f64().unwrap() <= 0.02);
    let seed = said["seed"].as_u64().unwrap().to_string();
    assert_eq!(
        judged(here, &made, mesh, &format!("--seed {seed}")),
        (code, said.clone())
    );
    assert_ne!(judged(here, &made, mesh, "").1["seed"], said["seed"]);

    // How a change is found: by the attribute that contradicts the mesh, by a comparison that
    // fails, by a sentence, or only as listed.
    enum By {
        Attribute(&'static str),
        Comparison,
        Word(&'static str),
        Listed(&'static str),
    }
    use By::{Attribute, Comparison, Listed};
    let unknown = "of-a-later-version";
    let changes: [(Change, By); 25] = [
        (
            |t| t.provenance.method = Word::Other("zzz".into()),
            By::Word("zzz"),
        ),
        (
            |t| t.provenance.back = Word::Other("of-a-later-version".into()),
            By::Word(unknown),
        ),
        (
            |t| t.provenance.losses = Word::Other("of-a-later-version".into()),
            By::Word(unknown),
        ),
        (
            |t| t.provenance.options = "--of-a-later-version 3".into(),
            By::Word(unknown),
        ),
        (|t| t.provenance.reflectance = 0.5, Attribute("reflectance")),
        (
            |t| t.provenance.metal_index = Some([0.97, 6.5]),
            Attribute("metal_index"),
        ),
        (|t| t.provenance.tolerance = 1e-3, Attribute("tolerance")),
        (|t| t.provenance.seed = 7, Attribute("seed")),
        (
            |t| t.provenance.edge_length_unit = "mm".into(),
            Attribute("edge_length_unit"),
        ),
        (
            |t| t.provenance.azimuth_zero = [2.0, 0.0, 0.0],
            Attribute("azimuth_zero"),
        ),
        (|t| t.provenance.lattice = None, Attribute("lattice")),
        (
            |t| t.provenance.lattice.as_mut().unwrap()[0][0] *= 1.001,
            Attribute("lattice"),
        ),
        (
            |t| t.provenance.direction_tolerance = Some(1e-6),
            Comparison,
        ),
        (|t| t.provenance.refractive_index = 1.5, Comparison),
        (|t| t.provenance.edge_length *= 1.1, Attribute("lattice")),
        (|t| t.provenance.angular_tolerance_deg = 1e-9, Listed(texts)),
        (|t| t.provenance.back = Back::Tir.into(), Comparison),
        (
            |t| t.provenance.wavelength_nm = Some(550.0),
            Listed("wavelength_nm"),
        ),
        (|t| t.provenance.design = "canted".into(), Listed("design")),
        (
            |t| t.provenance.mesh_hash = "00ff".repeat(16),
            Listed("mesh_hash"),
        ),
        (
            |t| t.provenance.generator = "bake 0.1.0".into(),
            Listed("generator"),
        ),
        (
            |t| t.exact.as_mut().unwrap().paths[1][0].passes = 1,
            Comparison,
        ),
        (
            |t| {
                let paths = t.exact.as_mut().unwrap().paths.iter_mut().flatten();
                paths.for_each(|path| path.jones = Some([[[1.0, 0.0]; 2]; 2]));
            },
            Comparison,
        ),
        (
            |t| {
                t.fate[[1, 0, Fate::LeftAfter1 as usize]] += 1e-3;
                t.fate[[1, 0, Fate::LeftAfter2 as usize]] -= 1e-3;
            },
            Comparison,
        ),
        (
            |t| t.exact.as_mut().unwrap().paths[1].reverse(),
            Listed(texts),
        ),
    ];
    assert!(honest.provenance.method.is(Method::Exact));
    let mut kinds = [0; 4];
    for (k, (change, by)) in changes.iter().enumerate() {
        let mut table = honest.clone();
        change(&mut table);
        tables::write(&table, &here.join("forged.h5")).unwrap();
        let (code, said) = judged(here, "forged.h5", mesh, "");
        let wrong = listed(&said, "contradictions");
        match by {
            Attribute(name) => {
                assert_eq!(
                    (code, wrong),
                    (Some(1), vec![(*name).into()]),
                    "{k}: {said}"
                );
                kinds[0] += 1;
            }
            Comparison => {
                assert_eq!((code, wrong.len()), (Some(1), 0), "{k}: {said}");
                assert!(said.is_object(), "{k}: {said}");
                kinds[1] += 1;
            }
            By::Word(word) => {
                assert_eq!(code, Some(1), "{k}");
                assert!(said.as_str().unwrap().contains(word), "{k}: {said}");
                let alone = bake(here, "verify forged.h5");
                assert_eq!(alone.code, Some(1), "{k}: {}", alone.out);
                kinds[2] += 1;
            }
            Listed(name) => {
                assert_eq!(code, Some(0), "{k}: {said}");
                let listed = listed(&said, "unchecked");
                assert!(listed.iter().any(|one| one == name), "{k}: {said}");
                kinds[3] += 1;
            }
        }
    }
    assert_eq!(kinds, [9, 6, 4, 6]);

    // A table in another unit of length than the mesh's own is right in its own unit, and that is
    // said.
    let scaled =
        format!("trace {mesh} -o scaled.h5 --edge-length 3.15 --refractive-index 1.49 --bins 16");
    bake(here, &scaled).done();
    let (code, said) = judged(here, "scaled.h5", mesh, "");
    assert_eq!(code, Some(0), "{said}");
    assert!(
        listed(&said, "unchecked").contains(&"edge_length".into()),
        "{said}"
    );
}
