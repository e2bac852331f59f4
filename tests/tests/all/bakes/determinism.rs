//! Outputs do not depend on the number of threads: equal inputs give equal bytes.

use std::path::Path;

use tests::estimate::json;
use tests::files::{argument, bake_table};
use tests::program::{bake, fit};

/// Returns the name and the bytes of every file of a folder, sorted by name.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| {
            (
                entry.file_name().into_string().unwrap(),
                std::fs::read(entry.path()).unwrap(),
            )
        })
        .collect();
    files.sort();
    files
}

#[test]
fn a_table_does_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut compared = 0;
    for (design, azimuth) in [
        ("triangular-pair", "0:90:30"),
        ("full-cube", "15"),
        ("triangular", "mean"),
    ] {
        bake(here, &format!("design {design} -o cell.glb")).done();
        let mut written = Vec::new();
        for (run, threads) in ["1", "2", "3", "2"].iter().enumerate() {
            let table = format!("{design}-{run}.h5");
            let directions =
                format!("--incidence 0,20,50 --azimuth {azimuth} --refractive-index 1.49");
            let work = format!("--method rays --rays 100003 --threads {threads}");
            let line = format!("trace cell.glb -o {table} {directions} {work}");
            bake(here, &line).done();
            written.push(std::fs::read(here.join(table)).unwrap());
        }
        assert!(written.iter().all(|bytes| *bytes == written[0]), "{design}");
        compared += written.len() - 1;
    }
    assert_eq!(compared, 9);
}

#[test]
fn a_result_does_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let table = bake_table(folder.path(), "triangular-pair", "0:45:15", "30");
    let manifest = argument("tests/captures/public_shared/captures.toml");
    let [one, two] = ["1", "2"].map(|threads| {
        let file = format!("{threads}.json");
        fit(
            folder.path(),
            &format!(
                "estimate {manifest} --lobe auto --table {table} -o {file} --threads {threads}"
            ),
        )
        .done();
        let mut result = json(&folder.path().join(file));
        let seconds = result.as_object_mut().unwrap().remove("seconds");
        assert!(seconds.is_some_and(|seconds| seconds.as_f64() > Some(0.0)));
        result
    });
    assert_eq!(one, two);
}

#[test]
fn a_simulated_campaign_does_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let parameters = argument("tests/tests/all/planted/angular.toml");
    let [one, two] = ["1", "2"].map(|threads| {
        let line = format!("simulate {parameters} -o {threads} --threads {threads}");
        fit(folder.path(), &line).done();
        contents(&folder.path().join(threads))
    });
    assert!(one.len() > 3 && one == two);
}
