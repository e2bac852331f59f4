//! `bake study`: measured slopes against those of theory, its estimate of errors, and the verb from outside.

use bake::plan::plan;
use bake::run::run::Tracer;
use bake::samples::sequence::Sampler;
use bake::study::fit::Reached;
use bake::study::report;
use bake::study::report::expected_exponent;
use bake::study::study::{Checked, Reference, Request, Study};
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions};
use std::path::Path;
use std::process::Command;

fn pair() -> Cell {
    let mesh = Design::new(Shape::TriangularPair).mesh().expect("a design");
    meshes::normalise(&mesh, Path::new("pair"), &CellOptions::default()).expect("a cell")
}

fn study(trace: plan::Request, repeats: usize, target: f64) -> Study {
    Checked::new(Request {
        trace,
        repeats,
        target,
        longest_seconds: f64::INFINITY,
    })
    .expect("a valid request")
    .run(&pair(), &|_, _, _| ())
    .expect("bakes")
}

/// Two directions, 16 x 16 bins of which some 100 are met in each, 4 repeats.
///
/// The error of a bin is half normal: standard deviation 0.756 of its mean. The mean L1 of 2 directions x 4 repeats is
/// a sum of 800 of them, some larger than others (half as many count): good to 0.756 / sqrt 400 = 3.8 %. The six
/// points from 1,024 rays on (4 rays per bin) lie ln 4 apart, so the slope of random rays is good to 3.8 % /
/// (ln 4 sqrt 17.5) = 0.0065. Sobol errors of neighbouring bins are one elementary box lost by one and found by the
/// other: a third as many independent ones, 6.5 %; four points from 16,384 on (4 rays per bin and randomisation):
/// 6.5 % / (ln 4 sqrt 5) = 0.021. Four standard deviations each.
#[test]
fn errors_fall_as_theory_says() {
    let target = 0.02;
    let found = study(
        plan::Request {
            incidence: "0,20".into(),
            azimuth: "30".into(),
            refractive_index: Some(1.49),
            bins: 16,
            rays: Some(1 << 20),
            ..plan::Request::default()
        },
        4,
        target,
    );
    assert!(matches!(found.reference, Reference::Exact { seconds } if seconds > 0.0));
    assert_eq!((found.directions, found.programs), (2, 2));
    assert_eq!(found.series.len(), 4);
    let mut points = 0;
    for series in &found.series {
        let name = report::title(series);
        let slope = series.slope.expect("enough rays");
        let (expected, error, first) = match series.sampler {
            Sampler::Random => (-0.5, 0.0065, 1024.0),
            Sampler::Sobol => (-0.75, 0.021, 16_384.0),
        };
        println!(
            "{name}: slope {:.4} over {:?} rays",
            slope.exponent, slope.range
        );
        assert_eq!(expected_exponent(series.sampler, false), expected);
        assert_eq!(slope.range, [first, f64::from(1 << 20)], "{name}");
        assert!(
            (slope.exponent - expected).abs() < 4.0 * error,
            "{name}: {}",
            slope.exponent
        );
        for point in &series.points {
            assert!(point.seconds > 0.0 && point.l1 <= point.worst_l1, "{name}");
            assert!(point.estimated_l1 <= point.worst_estimated_l1, "{name}");
            if point.rays as f64 >= first {
                println!(
                    "{name}, {} rays: true/estimated {:.3}",
                    point.rays,
                    point.ratio()
                );
                // The scatter of the error itself, four times; the estimate knows its sigmas 15 times better (random)
                // or to 18 % each (16 randomisations), which the sum over bins averages out.
                let scatter = if series.sampler == Sampler::Random {
                    0.031
                } else {
                    0.053
                };
                assert!(
                    (point.ratio() - 1.0).abs() < 4.0 * scatter,
                    "{name}, {} rays: {}",
                    point.rays,
                    point.ratio()
                );
            }
            points += 1;
        }
        let after = series
            .points
            .iter()
            .position(|point| point.worst_l1 <= target)
            .expect("within reach");
        let ends = [after - 1, after].map(|at| series.points[at].seconds);
        let Reached::At(seconds) = series.reached else {
            panic!("{name}: the first point is above the target");
        };
        assert!(
            seconds >= ends[0].min(ends[1]) && seconds <= ends[0].max(ends[1]),
            "{name}"
        );
    }
    assert_eq!(points, 4 * 6);
    // The same samples whoever traces them: at most a ray on a boundary of a bin may change sides.
    let of = |tracer, sampler| {
        found
            .series
            .iter()
            .find(|series| (series.tracer, series.sampler) == (tracer, sampler))
            .expect("all four")
    };
    for sampler in [Sampler::Random, Sampler::Sobol] {
        let [fast, plain] = [Tracer::Fastest, Tracer::OneByOne].map(|tracer| of(tracer, sampler));
        for (fast, plain) in fast.points.iter().zip(&plain.points) {
            assert!(
                (fast.l1 - plain.l1).abs() <= 4.0 / fast.rays as f64,
                "{} rays",
                fast.rays
            );
        }
    }
}

/// No exact table of a mean over azimuths: more Sobol rays are the reference, and every report says so.
#[test]
fn without_an_exact_table() {
    let found = study(
        plan::Request {
            incidence: "0,20".into(),
            azimuth: "mean".into(),
            bins: 8,
            rays: Some(20_000),
            ..plan::Request::default()
        },
        1,
        1e-9,
    );
    let Reference::Sobol {
        rays, estimated_l1, ..
    } = found.reference
    else {
        panic!("{:?}", found.reference);
    };
    assert_eq!(rays, 4 * 16_384);
    assert!(estimated_l1 > 0.0);
    assert_eq!(found.series.len(), 2, "no program for a mean over azimuths");
    for series in &found.series {
        assert_eq!(series.tracer, Tracer::OneByOne);
        assert_eq!(series.points.len(), 3);
        assert_eq!(series.reached, Reached::Never);
    }
    let text = report::text(&found);
    assert!(
        text.contains("against a Sobol table of 65536 rays per direction"),
        "{text}"
    );
    assert!(
        text.contains("the exact mean over azimuths is a quadrature"),
        "{text}"
    );
    assert!(text.contains("not reached; give more --rays"), "{text}");
    assert!(!report::csv(&found).contains("exact"));
}

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
    // A heading, the exact bake, and two tracers x two samplers x 1,024 and 4,096 rays.
    assert_eq!(rows.len(), 1 + 1 + 2 * 2 * 2);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{csv}");
    assert_eq!(rows[1][..4], ["exact", "beams", "none", "0"]);
    let numbers = rows[1..].iter().flat_map(|row| &row[3..]);
    assert!(numbers.clone().count() == 9 * 6);
    for number in numbers {
        assert!(number.parse::<f64>().is_ok_and(f64::is_finite), "{number}");
    }
    let svg = std::fs::read_to_string(folder.path().join("study.svg")).expect("a picture");
    assert!(svg.starts_with("<svg") && svg.contains("no sampling error"));

    let json = run(&["--json", "--plot", "study.png", "--repeats", "1"]);
    let value: serde_json::Value = serde_json::from_slice(&json.stdout).expect("JSON");
    assert_eq!(value["reference"]["method"], "exact");
    assert_eq!(value["series"].as_array().expect("a list").len(), 4);
    assert_eq!(value["series"][0]["points"][1]["rays"], 4096);
    let png = std::fs::read(folder.path().join("study.png")).expect("a picture");
    assert!(png.starts_with(b"\x89PNG"));

    // Every bake takes longer than a quarter of a nanosecond: one point a series is left.
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
            &["--plot", "study.jpg"],
            2,
            "study.jpg: the extension must be .png or .svg",
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
