//! Bad files and wrong options, given to the real programs.
//!
//! Each must end with one sentence on standard error and the right exit code. A file that existed
//! at the place of the output must be unchanged, byte for byte, and no half-written file may lie
//! beside it.

use std::path::Path;

use tests::files::{argument, bake_table, project};
use tests::program::run;

/// Content of the file that exists at the place of the output before a run.
const KEPT: &[u8] = b"an older result that nobody wants to lose";

/// A temporary folder for runs that must be refused, with the failures found so far.
struct Bench {
    folder: tempfile::TempDir,
    failures: Vec<String>,
    cases: usize,
}

impl Bench {
    fn new() -> Bench {
        Bench {
            folder: tempfile::tempdir().unwrap(),
            failures: Vec::new(),
            cases: 0,
        }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Runs a command line that must be refused, and records what is wrong with the refusal.
    ///
    /// The run must end with the exit code `code` and with one sentence that holds all of `parts`.
    /// It runs in the folder `from`. The word `OUT` in `arguments` stands for a file that exists
    /// already.
    fn refuses(
        &mut self,
        from: &Path,
        program: &str,
        arguments: &[&str],
        code: i32,
        parts: &[&str],
    ) {
        let outputs = tempfile::tempdir_in(self.path()).unwrap();
        let kept = outputs.path().join("kept");
        std::fs::write(&kept, KEPT).unwrap();
        let arguments: Vec<String> = arguments
            .iter()
            .map(|word| {
                if *word == "OUT" {
                    kept.display().to_string()
                } else {
                    (*word).to_owned()
                }
            })
            .collect();
        let run = run(program, from, &arguments);
        let told: Vec<&str> = run
            .err
            .lines()
            .filter(|line| line.starts_with("error: "))
            .collect();
        let mut wrong = Vec::new();
        if run.code != Some(code) {
            wrong.push(format!("exit code {:?}, not {code}", run.code));
        }
        if told.len() != 1
            || (code == 1
                && run
                    .err
                    .lines()
                    .any(|line| !line.starts_with("error: ") && !line.starts_with("warning: ")))
        {
            wrong.push("not one sentence".to_owned());
        }
        for part in parts.iter().filter(|part| !run.err.contains(**part)) {
            wrong.push(format!("without {part:?}"));
        }
        if run.err.contains("panicked") || !run.out.is_empty() {
            wrong.push(format!("a panic, or output: {}", run.out));
        }
        if std::fs::read(&kept).ok().as_deref() != Some(KEPT) {
            wrong.push("the output was changed".to_owned());
        }
        if std::fs::read_dir(outputs.path()).unwrap().count() != 1 {
            wrong.push("a file was left beside the output".to_owned());
        }
        if !wrong.is_empty() {
            self.failures
                .push(format!("{}: {}\n{}", run.line, wrong.join(", "), run.err));
        }
        self.cases += 1;
    }

    #[track_caller]
    fn all_refused(self, cases: usize) {
        assert!(
            self.failures.is_empty(),
            "{} of {}:\n{}",
            self.failures.len(),
            self.cases,
            self.failures.join("\n")
        );
        assert_eq!(self.cases, cases);
    }
}

fn expected(file: &str) -> toml::Table {
    std::fs::read_to_string(argument(file))
        .unwrap()
        .parse()
        .unwrap()
}

#[test]
fn meshes() {
    let mut bench = Bench::new();
    let folder = project().join("meshes/tests/bad");
    let cases = expected("meshes/tests/bad/expected.toml");
    for (file, parts) in &cases {
        let parts: Vec<&str> = parts
            .as_array()
            .unwrap()
            .iter()
            .filter_map(toml::Value::as_str)
            .collect();
        bench.refuses(
            &folder,
            "bake",
            &["trace", file, "-o", "OUT", "--rays", "1000"],
            1,
            &[&parts[..], &[file]].concat(),
        );
    }
    assert!(cases.len() > 60);
    bench.all_refused(cases.len());
}

#[test]
fn photographs_manifests_and_parameters() {
    let mut bench = Bench::new();
    let table = bake_table(bench.path(), "triangular-pair", "0:45:15", "30");
    let table = bench.path().join(table).display().to_string();
    let folder = project().join("fit/tests");
    let groups = expected("fit/tests/bad/expected.toml");
    let mut cases = 0;
    for (group, files) in &groups {
        for (file, part) in files.as_table().unwrap() {
            let file = format!("bad/{file}");
            let arguments = match group.as_str() {
                "manifests" => vec!["estimate", &file, "--table", &table, "-o", "OUT"],
                "images" => vec!["mtf", &file, "-o", "OUT"],
                "simulate" => vec!["simulate", &file, "-o", "OUT"],
                other => panic!("no verb for the group {other}"),
            };
            bench.refuses(&folder, "fit", &arguments, 1, &[part.as_str().unwrap()]);
            cases += 1;
        }
    }
    assert!(groups.len() == 3 && cases > 40);
    bench.all_refused(cases);
}

#[test]
fn tables() {
    let mut bench = Bench::new();
    let here = bench.path().to_owned();
    let name = bake_table(&here, "triangular-pair", "0,45", "30");
    let good = std::fs::read(here.join(name)).unwrap();
    let flipped = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 1;
        bytes
    };
    let damaged: [(&str, Vec<u8>, &str); 7] = [
        ("empty.h5", Vec::new(), "is not an HDF5 file"),
        (
            "text.h5",
            b"incidence,azimuth,eta\n".to_vec(),
            "is not an HDF5 file",
        ),
        (
            "picture.h5",
            b"\x89PNG\r\n\x1a\n".repeat(100),
            "is not an HDF5 file",
        ),
        ("head_only.h5", good[..512].to_vec(), "head_only.h5"),
        (
            "cut_short.h5",
            good[..good.len() / 2].to_vec(),
            "cut_short.h5",
        ),
        ("first_bit.h5", flipped(0), "is not an HDF5 file"),
        ("one_bit.h5", flipped(good.len() / 2), "one_bit.h5"),
    ];
    let manifest = argument("tests/captures/public_shared/captures.toml");
    for (file, bytes, part) in &damaged {
        std::fs::write(here.join(file), bytes).unwrap();
        bench.refuses(&here, "bake", &["inspect", file], 1, &[part, file]);
        bench.refuses(&here, "bake", &["verify", file], 1, &[part, file]);
        bench.refuses(
            &here,
            "fit",
            &["estimate", &manifest, "--table", file, "-o", "OUT"],
            1,
            &[part, file],
        );
    }
    bench.refuses(&here, "bake", &["inspect", "none.h5"], 1, &["none.h5"]);
    bench.refuses(
        &here,
        "fit",
        &["estimate", &manifest, "--table", "none.h5", "-o", "OUT"],
        1,
        &["none.h5"],
    );
    // A good table, but of other directions and another cell.
    let other = bake_table(&here, "triangular", "0:20:10", "5");
    let nearest = ["does not cover incidence", "nearest"];
    bench.refuses(
        &here,
        "fit",
        &["estimate", &manifest, "--table", &other, "-o", "OUT"],
        1,
        &nearest,
    );
    bench.all_refused(3 * 7 + 3);
}

#[test]
fn options() {
    let mut bench = Bench::new();
    let here = bench.path().to_owned();
    let table = bake_table(&here, "triangular", "10,25,40", "10");
    let manifest = argument("tests/captures/public_axes/captures.toml");
    let edge = argument("tests/edges/camera_5deg.exr");
    let edge_of_campaign = argument("tests/captures/public_axes/source.exr");
    let trace = |option: &'static str, value: &'static str, part: &'static str| {
        (
            "bake",
            vec!["trace", "triangular.obj", "-o", "OUT", option, value],
            2,
            part,
        )
    };
    let design = |name: &'static str, [option, value]: [&'static str; 2], part: &'static str| {
        (
            "bake",
            vec!["design", name, option, value, "-o", "x.obj"],
            2,
            part,
        )
    };
    let estimate = |option: &'static str, value: &'static str, part: &'static str| {
        (
            "fit",
            vec![
                "estimate", &manifest, "--table", &table, "-o", "OUT", option, value,
            ],
            2,
            part,
        )
    };
    let mtf = |option: &'static str, value: &'static str, code: i32, part: &'static str| {
        (
            "fit",
            vec!["mtf", &edge, "-o", "OUT", option, value],
            code,
            part,
        )
    };
    let cases = [
        trace("--incidence", "90", "--incidence 90"),
        trace("--incidence", "-1", "--incidence -1"),
        trace("--incidence", "0:45", "--incidence 0:45"),
        trace("--incidence", "0:45:0", "--incidence 0:45:0"),
        trace("--incidence", "ten", "--incidence ten"),
        trace("--azimuth", "nan", "--azimuth nan"),
        trace("--azimuth", "", "--azimuth"),
        trace("--refractive-index", "0.5", "--refractive-index 0.5"),
        trace("--rays", "0", "--rays"),
        trace("--rays", "many", "--rays"),
        trace("--bins", "0", "--bins"),
        trace("--bins", "many", "whole number from 1 to 4096"),
        trace("--range", "0", "--range"),
        trace("--tolerance", "0", "--tolerance"),
        trace("--angular-tolerance", "-3", "--angular-tolerance"),
        trace("--lattice", "1,0,0", "--lattice"),
        trace("--azimuth-zero", "1,0", "--azimuth-zero"),
        trace("--edge-length", "-2", "--edge-length"),
        trace("--edge-length", "1e20", "does not fit a cell 3 wide"),
        trace("--azimuth", "-361", "from -360 to 360"),
        trace("--range", "1e6", "--range 1000000"),
        trace("--azimuth", "full:x", "\"x\" is not a number"),
        trace("--angular-tolerance", "20", "at most 10 degrees"),
        trace("--refractive-index", "wood", "pmma, polycarbonate, bk7"),
        trace("--refractive-index", "bk7", "depends on the wavelength"),
        trace("--metal", "tin", "--metal tin"),
        trace("--reflectance", "0.9", "needs --losses fresnel"),
        trace("--deviations", "wide", "auto, off, or a range in mrad"),
        trace("--wavelength-nm", "0", "--wavelength-nm 0"),
        trace("--roughness", "ggx:2", "ALPHA above 0 and at most 1"),
        trace("--glass-index", "0.9", "--glass-index 0.9"),
        trace("--element", "bead", "retroreflector, plate"),
        trace("--wavelength-nm", "450,650", "write {nm}"),
        (
            "bake",
            vec![
                "trace",
                "triangular.obj",
                "-o",
                "OUT",
                "--glass-index",
                "1.9",
            ],
            1,
            "no face of the material \"glass\"",
        ),
        (
            "bake",
            vec!["trace", "triangular.obj", "-o", "./triangular.obj"],
            1,
            "is an input of this command",
        ),
        (
            "bake",
            vec!["study", "triangular.obj", "--csv", "triangular.obj"],
            1,
            "is an input of this command",
        ),
        design(
            "canted",
            ["--cant-deg", "80"],
            "cant in degrees of 80 is outside -34.5 to 52",
        ),
        design(
            "plate",
            ["--depth", "-3"],
            "depth of -3 is outside 0.001 to 1000",
        ),
        design(
            "triangular",
            ["--depth", "3"],
            "triangular does not take a depth",
        ),
        design(
            "triangular",
            ["--edge-radius", "1"],
            "edge radius of 1 is outside 0 to 0.6",
        ),
        (
            "bake",
            vec![
                "design",
                "triangular",
                "--dihedral-error-mrad",
                "0,900,0",
                "-o",
                "x.obj",
            ],
            2,
            "dihedral error in mrad of 900 is outside -100 to 100",
        ),
        (
            "fit",
            vec![
                "estimate",
                &manifest,
                "--table",
                &table,
                "-o",
                "mtf.svg",
                "--plot",
                "./mtf.svg",
            ],
            1,
            "is named for two outputs",
        ),
        (
            "fit",
            vec![
                "estimate",
                &manifest,
                "--table",
                &table,
                "-o",
                &edge_of_campaign,
            ],
            1,
            "is an input of this command",
        ),
        trace("--threads", "0", "--threads"),
        trace("--method", "guess", "--method"),
        trace("--back", "glass", "--back"),
        ("bake", vec!["trace", "triangular.obj"], 2, "--output"),
        (
            "bake",
            vec!["trace", "triangular.obj", "-o", "no/such/folder/t.h5"],
            1,
            "no/such",
        ),
        ("bake", vec!["trace", "triangular.obj", "-o", "."], 1, ""),
        (
            "bake",
            vec!["design", "pentagon", "-o", "OUT"],
            2,
            "pentagon",
        ),
        (
            "bake",
            vec!["design", "triangular", "-o", "OUT"],
            2,
            ".obj or .glb",
        ),
        (
            "bake",
            vec!["inspect", &table, "--plot", "OUT"],
            2,
            "must be .svg",
        ),
        estimate("--kernel", "eq2", "--kernel"),
        estimate("--lobe", "round", "--lobe"),
        estimate("--per-angle", "c", "--per-angle"),
        (
            "fit",
            vec![
                "estimate",
                &manifest,
                "--table",
                &table,
                "--fit-azimuth",
                "-o",
                "OUT",
            ],
            1,
            "bake trace --azimuth full",
        ),
        estimate("--threads", "0", "--threads"),
        estimate("--threads", "2.5", "whole number, 1 or larger"),
        (
            "fit",
            vec!["estimate", &manifest, "-o", "OUT"],
            2,
            "--table",
        ),
        (
            "fit",
            vec![
                "estimate",
                &manifest,
                "--table",
                &table,
                "-o",
                "no/such/folder/r.json",
            ],
            1,
            "no/such",
        ),
        (
            "fit",
            vec![
                "estimate", &manifest, "--table", &table, "-o", "OUT", "--plot", "mtf.bmp",
            ],
            2,
            "mtf.bmp",
        ),
        mtf("--roi", "1,2,3", 2, "--roi"),
        mtf("--roi", "0,0,9999,9999", 1, "camera_5deg.exr"),
        mtf("--roi", "0,0,4,4", 1, "camera_5deg.exr"),
        mtf("--pixel-pitch", "-1", 2, "--pixel-pitch"),
        mtf("--transfer", "gamma", 2, "--transfer"),
        mtf("--channel", "infrared", 1, "infrared"),
        (
            "fit",
            vec![
                "predict",
                "none.json",
                "--table",
                &table,
                "--distance",
                "9",
                "--incidence",
                "10",
                "-o",
                "OUT",
            ],
            1,
            "none.json",
        ),
        (
            "fit",
            vec![
                "predict",
                &manifest,
                "--table",
                &table,
                "--distance",
                "9",
                "--incidence",
                "10",
                "-o",
                "OUT",
            ],
            1,
            "captures.toml",
        ),
        (
            "fit",
            vec![
                "predict",
                "r.json",
                "--table",
                &table,
                "--distance",
                "0",
                "--incidence",
                "10",
                "-o",
                "OUT",
            ],
            2,
            "--distance",
        ),
        (
            "fit",
            vec![
                "predict",
                "r.json",
                "--table",
                &table,
                "--distance",
                "9",
                "--incidence",
                "90",
                "-o",
                "OUT",
            ],
            2,
            "--incidence",
        ),
    ];
    let count = cases.len();
    for (program, arguments, code, part) in cases {
        bench.refuses(&here, program, &arguments, code, &[part]);
    }
    assert_eq!(count, 71);
    bench.all_refused(count);
}

/// Azimuths have one rule at all doors: from -360 to 360 degrees. Those of manifests have it too
/// (`azimuth_beyond_a_turn.toml`).
#[test]
fn azimuths_have_one_rule() {
    let mut bench = Bench::new();
    let here = bench.path().to_owned();
    bake_table(&here, "triangular", "0,20", "-360,0,360");
    let mesh = ["trace", "triangular.obj", "-o", "OUT", "--incidence", "20"];
    let sheet = ["--sheet", "hollow-0.2", "--distance", "150"];
    let place =
        |verb: &'static str| [&[verb][..], &sheet, &["--incidence", "20", "-o", "OUT"]].concat();
    let doors: [(&str, Vec<&str>); 4] = [
        ("bake", mesh.to_vec()),
        ("fit", place("predict")),
        (
            "fit",
            [&place("render")[..], &["--source", "none.png"]].concat(),
        ),
        ("fit", place("explore")),
    ];
    let mut cases = 0;
    for (program, door) in &doors {
        for azimuth in ["719", "-360.5", "360.0000001"] {
            let words = [&door[..], &["--azimuth", azimuth]].concat();
            bench.refuses(&here, program, &words, 2, &["from -360 to 360"]);
            cases += 1;
        }
    }
    for azimuth in ["-360,-30,360", "-360:360:90"] {
        let words = [&place("predict")[..], &["--azimuth", azimuth]].concat();
        let words: Vec<&str> = words
            .iter()
            .map(|&word| if word == "OUT" { "p.csv" } else { word })
            .collect();
        assert_eq!(run("fit", &here, &words).code, Some(0), "{azimuth}");
    }
    bench.all_refused(cases);
}
