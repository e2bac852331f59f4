//! Light that the front face sends back inside, from the mesh to the picture, by the two programs.

use std::fs;
use std::path::Path;

use tests::estimate::json;
use tests::files::{argument, bake_table_with};
use tests::program::{bake, fit};

/// Options of a bake at which this light matters.
const TRAPPED: &str = "--front trapped --refractive-index 1.49 --azimuth 0";

/// Bakes the mesh `name`.obj with these options, and returns the name of the table.
fn trace(here: &Path, name: &str, options: &str) -> String {
    let (mesh, table) = (format!("{name}.obj"), format!("{name}.h5"));
    let words = format!("trace {mesh} -o {table}");
    bake(here, &format!("{words} {TRAPPED} {options}")).done();
    table
}

/// Rays of shards, of one and of two threads make the same table, and it is that of the beams.
#[test]
fn rays_and_beams_agree_however_the_work_is_split() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut compared = 0;
    for design in ["triangular-pair", "full-cube"] {
        bake(here, &format!("design {design} -o {design}.obj")).done();
        let options = "--incidence 30,45 --method rays --rays 40001";
        let whole = fs::read(here.join(trace(here, design, options))).unwrap();
        for threads in ["1", "2"] {
            let more = format!("{options} --threads {threads}");
            let table = trace(here, design, &more);
            assert!(
                fs::read(here.join(table)).unwrap() == whole,
                "{threads} threads"
            );
            compared += 1;
        }
        let parts = ["1/3", "2/3", "3/3"].map(|shard| {
            let table = trace(here, design, &format!("{options} --shard {shard}"));
            let part = format!("{design}-{}.h5", &shard[..1]);
            fs::rename(here.join(table), here.join(&part)).unwrap();
            part
        });
        let words = format!("merge {} {} {} -o merged.h5", parts[0], parts[1], parts[2]);
        bake(here, &words).done();
        assert!(fs::read(here.join("merged.h5")).unwrap() == whole, "shards");
        let exact = trace(here, design, "--incidence 30,45");
        bake(here, &format!("compare {exact} merged.h5")).done();
        compared += 2;
        let mesh = format!("{design}.obj");
        for table in [exact.as_str(), "merged.h5"] {
            bake(here, &format!("verify {table} --mesh {mesh} --rays 65536")).done();
            compared += 1;
        }
    }
    assert_eq!(compared, 12);
}

/// Light that is nearly all out of the range of the histogram is no difference: 98 % of the light
/// of this direction is.
#[test]
fn light_out_of_range_is_verified_by_its_share() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bake(here, "design full-cube -o cube.obj").done();
    let words = "trace cube.obj -o cube.h5 --refractive-index 1.586";
    let steep = "--losses fresnel --incidence 70 --azimuth 0";
    bake(here, &format!("{words} {steep} --front trapped")).done();
    let table = tables::read(&here.join("cube.h5")).unwrap();
    let outside = table.fate[[0, 0, tables::Fate::OutOfRange as usize]];
    assert!(outside > 0.9 * table.retroreflected[[0, 0]]);
    for seed in ["1", "2", "3"] {
        let words = format!("verify cube.h5 --mesh cube.obj --seed {seed}");
        bake(here, &format!("{words} --rays 262144")).done();
    }
}

/// All azimuths of a symmetric cell, with directions that are chosen for a tolerance: verified by
/// rays, and interpolated within the tolerance at a direction between them.
#[test]
fn directions_are_chosen_and_interpolated() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bake(here, "design triangular-pair -o pair.obj").done();
    let front = "--front trapped --refractive-index 1.49";
    let words = "trace pair.obj -o all.h5 --incidence 0,45";
    let all = "--azimuth full --direction-tolerance 0.02";
    bake(here, &format!("{words} {all} {front}")).done();
    bake(here, "verify all.h5 --mesh pair.obj --rays 65536").done();
    let between = tables::read(&here.join("all.h5")).unwrap();
    for (incidence, azimuth) in [("37", "4"), ("42", "11"), ("44", "61"), ("33", "356")] {
        let words = format!("trace pair.obj -o one.h5 --incidence {incidence}");
        bake(here, &format!("{words} --azimuth {azimuth} {front}")).done();
        let one = tables::read(&here.join("one.h5")).unwrap();
        let found = between
            .direction(incidence.parse().unwrap(), Some(azimuth.parse().unwrap()))
            .unwrap();
        let off = found.retroreflected - one.retroreflected[[0, 0]];
        // The shares of two distributions differ by at most twice their total variation.
        assert!(off.abs() <= 0.04, "{incidence} {azimuth}: {off}");
    }
}

/// Photographs with this light: the table that has it gives the planted numbers, the table without
/// it is noticed. Every model, prediction and picture takes the table.
#[test]
fn photographs_at_a_steep_angle_need_the_light() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let bins = "--range 3 --bins 96";
    let table = bake_table_with(
        here,
        "triangular-pair",
        "0:45:15",
        "0",
        &format!("{bins} --front trapped"),
    );
    fs::rename(here.join(table), here.join("trapped.h5")).unwrap();
    let once = bake_table_with(here, "triangular-pair", "0:45:15", "0", bins);
    let mut text = String::from(
        "seed = 3\n[camera]\nwidth = 224\nheight = 128\n[truth]\nkernel = \"eq1\"\n\
        lobe = \"radial\"\nrefractive_index = 1.49\npair = true\na = 4.0\nc = 0.3\nmu = 0.5\n",
    );
    for incidence in [0, 45] {
        for (distance, normal) in [(120, 5), (120, 95), (300, 5), (300, 95)] {
            text += &format!(
                "[[capture]]\nfloating_distance_mm = {distance}\nincidence_deg = {incidence}\n\
                azimuth_deg = 0\nedge_normal_deg = {normal}\nexposure = 6.0\n"
            );
        }
    }
    fs::write(here.join("params.toml"), text).unwrap();
    let words = "simulate params.toml -o photos --table trapped.h5";
    fit(here, words).done();
    let estimate = |table: &str, options: &str| {
        let words = format!("estimate photos/captures.toml --table {table} -o result.json");
        let run = fit(here, &format!("{words} {options}"));
        assert_eq!(run.code, Some(0), "{options:?}: {}", run.err);
        json(&here.join("result.json"))
    };
    let right = estimate("trapped.h5", "--lobe radial");
    assert_eq!(right["fit"]["verdict"], "good", "{}", right["fit"]);
    for (key, truth) in [("c_mm", 0.3), ("a_per_mm", 4.0), ("mu", 0.5)] {
        let [value, error] =
            ["value", "standard_error"].map(|name| right[key][name].as_f64().unwrap());
        // Chance exceeds 5 standard errors in one of 600,000 runs of three numbers.
        assert!(
            (value - truth).abs() < 5.0 * error,
            "{key}: {value} +- {error}"
        );
    }
    let wrong = estimate(&once, "--lobe radial");
    assert_ne!(wrong["fit"]["verdict"], "good", "{}", wrong["fit"]);
    for options in [
        "--kernel angular --loss mtf",
        "--kernel shift --loss mtf",
        "--kernel lobe --loss mtf",
        "--kernel wave --wavelength-nm 550 --loss mtf",
        "--loss mtf",
        "--model saito --loss mtf",
        "--model guo --loss mtf",
        "--model mrm --loss mtf",
    ] {
        estimate("trapped.h5", options);
    }
    estimate("trapped.h5", "--lobe radial");
    let view = "--table trapped.h5 --distance 200 --incidence 40 --azimuth 0";
    let predicted = fit(here, &format!("predict result.json {view} --json"));
    assert_eq!(predicted.code, Some(0), "{}", predicted.err);
    let source = argument("tests/captures/public_per_angle/source.exr");
    let words = format!("render --source {source} --params result.json -o aerial.exr");
    let rendered = fit(here, &format!("{words} {view}"));
    assert_eq!(rendered.code, Some(0), "{}", rendered.err);
}

/// Cells and options without neighbours to go on to end in one error with its remedy.
#[test]
fn cells_without_neighbours_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for design in ["triangular", "triangular-pair"] {
        bake(here, &format!("design {design} -o {design}.obj")).done();
    }
    let cases: [(&str, &str, &str); 5] = [
        (
            "triangular",
            "--front trapped",
            "triangular.obj: has no lattice, and a rim of 3 corners",
        ),
        (
            "triangular",
            "--front trapped",
            "give --lattice, or one period",
        ),
        (
            "triangular-pair",
            "--front trapped --element plate",
            "--element plate exclude each other",
        ),
        (
            "triangular-pair",
            "--front trapped --glass-index 1.5",
            "--front trapped exclude each other",
        ),
        ("triangular-pair", "--front never", "invalid value 'never'"),
    ];
    for (mesh, options, says) in cases {
        let words = format!("trace {mesh}.obj -o table.h5 --refractive-index 1.49 {options}");
        let run = bake(here, &words);
        assert!(run.code.is_some_and(|code| code != 0), "{words:?}");
        assert!(run.err.contains(says), "{words:?}: {}", run.err);
        assert!(!here.join("table.h5").exists(), "{words:?}");
    }
    let words = "trace triangular-pair.obj -o table.h5 --refractive-index 1";
    let run = bake(here, &format!("{words} --front trapped"));
    assert_eq!(run.code, Some(0));
    assert!(
        run.err.contains("--front trapped has no effect"),
        "{}",
        run.err
    );
}
