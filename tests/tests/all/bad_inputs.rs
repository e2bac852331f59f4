//! Bad files and wrong options, given to the real programs.
//!
//! Each must end with one sentence on standard error and the right exit code. A file that existed
//! at the place of the output must be unchanged, byte for byte, and no half-written file may lie
//! beside it.

use std::path::Path;

use tests::files::{argument, bake_table, project};
use tests::program::{fit, run};

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
    /// It runs in the folder `from`. The word OUT stands for a file that exists already.
    fn refuses(&mut self, from: &Path, line: &str, code: i32, parts: &[&str]) {
        let outputs = tempfile::tempdir_in(self.path()).unwrap();
        let kept = outputs.path().join("kept");
        std::fs::write(&kept, KEPT).unwrap();
        let (program, words) = line.split_once(' ').unwrap();
        let run = run(
            program,
            from,
            &words.replace("OUT", &kept.display().to_string()),
        );
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
        let parts = parts.as_array().unwrap().iter();
        let mut parts: Vec<&str> = parts.filter_map(toml::Value::as_str).collect();
        parts.push(file);
        bench.refuses(
            &folder,
            &format!("bake trace {file} -o OUT --rays 1000"),
            1,
            &parts,
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
            let line = match group.as_str() {
                "manifests" => format!("fit estimate {file} --table {table} -o OUT"),
                "images" => format!("fit mtf {file} -o OUT"),
                "simulate" => format!("fit simulate {file} -o OUT"),
                other => panic!("no verb for the group {other}"),
            };
            bench.refuses(&folder, &line, 1, &[part.as_str().unwrap()]);
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
    let estimate = |table: &str| format!("fit estimate {manifest} --table {table} -o OUT");
    for (file, bytes, part) in &damaged {
        std::fs::write(here.join(file), bytes).unwrap();
        for line in [
            format!("bake inspect {file}"),
            format!("bake verify {file}"),
            estimate(file),
        ] {
            bench.refuses(&here, &line, 1, &[part, file]);
        }
    }
    bench.refuses(&here, "bake inspect none.h5", 1, &["none.h5"]);
    bench.refuses(&here, &estimate("none.h5"), 1, &["none.h5"]);
    // A good table, but of other directions and another cell.
    let other = bake_table(&here, "triangular", "0:20:10", "5");
    bench.refuses(
        &here,
        &estimate(&other),
        1,
        &["does not cover incidence", "nearest"],
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
    let estimate = format!("fit estimate {manifest} --table {table}");
    let to_out = format!("{estimate} -o OUT");
    let trace = "bake trace triangular.obj -o OUT";
    let mtf = format!("fit mtf {edge} -o OUT");
    let predict = format!("fit predict r.json --table {table} -o OUT");
    let predict_of = |result: &str| {
        format!("fit predict {result} --table {table} --distance 9 --incidence 10 -o OUT")
    };
    // A command, what is added to it, the exit code, and a part of the sentence.
    let cases: [(&str, &str, i32, &str); 71] = [
        (trace, "--incidence 90", 2, "--incidence 90"),
        (trace, "--incidence -1", 2, "--incidence -1"),
        (trace, "--incidence 0:45", 2, "--incidence 0:45"),
        (trace, "--incidence 0:45:0", 2, "--incidence 0:45:0"),
        (trace, "--incidence ten", 2, "--incidence ten"),
        (trace, "--azimuth nan", 2, "--azimuth nan"),
        (trace, "--azimuth=", 2, "--azimuth"),
        (trace, "--azimuth -361", 2, "from -360 to 360"),
        (trace, "--azimuth full:x", 2, "\"x\" is not an angle"),
        (trace, "--refractive-index 0.5", 2, "--refractive-index 0.5"),
        (
            trace,
            "--refractive-index wood",
            2,
            "pmma, polycarbonate, bk7",
        ),
        (
            trace,
            "--refractive-index bk7",
            2,
            "depends on the wavelength",
        ),
        (trace, "--rays 0", 2, "--rays"),
        (trace, "--rays many", 2, "--rays"),
        (trace, "--bins 0", 2, "--bins"),
        (trace, "--bins many", 2, "whole number from 1 to 4096"),
        (trace, "--range 0", 2, "--range"),
        (trace, "--range 1e6", 2, "--range 1000000"),
        (trace, "--tolerance 0", 2, "--tolerance"),
        (trace, "--angular-tolerance -3", 2, "--angular-tolerance"),
        (trace, "--angular-tolerance 20", 2, "at most 10 degrees"),
        (trace, "--lattice 1,0,0", 2, "--lattice"),
        (trace, "--azimuth-zero 1,0", 2, "--azimuth-zero"),
        (trace, "--edge-length -2", 2, "--edge-length"),
        (trace, "--edge-length 1e20", 2, "does not fit a cell 3 wide"),
        (trace, "--metal tin", 2, "--metal tin"),
        (trace, "--reflectance 0.9", 2, "needs --losses fresnel"),
        (
            trace,
            "--deviations wide",
            2,
            "auto, off, or a range in mrad",
        ),
        (trace, "--wavelength-nm 0", 2, "--wavelength-nm 0"),
        (trace, "--wavelength-nm 450,650", 2, "write {nm}"),
        (trace, "--roughness ggx:2", 2, "ALPHA above 0 and at most 1"),
        (trace, "--glass-index 0.9", 2, "--glass-index 0.9"),
        (
            trace,
            "--glass-index 1.9",
            1,
            "no face of the material \"glass\"",
        ),
        (trace, "--element bead", 2, "retroreflector, plate"),
        (trace, "--threads 0", 2, "--threads"),
        (trace, "--method guess", 2, "--method"),
        (trace, "--back glass", 2, "--back"),
        (
            "bake trace triangular.obj",
            "-o ./triangular.obj",
            1,
            "is an input of this command",
        ),
        (
            "bake trace triangular.obj",
            "-o no/such/folder/t.h5",
            1,
            "no/such",
        ),
        ("bake trace triangular.obj", "-o .", 1, ""),
        ("bake trace triangular.obj", "", 2, "--output"),
        (
            "bake study triangular.obj",
            "--csv triangular.obj",
            1,
            "is an input of this command",
        ),
        (
            "bake design canted -o x.obj",
            "--cant-deg 80",
            2,
            "80 is outside -34.5 to 52",
        ),
        (
            "bake design plate -o x.obj",
            "--depth -3",
            2,
            "-3 is outside 0.001 to 1000",
        ),
        (
            "bake design triangular -o x.obj",
            "--depth 3",
            2,
            "triangular does not take a depth",
        ),
        (
            "bake design triangular -o x.obj",
            "--edge-radius 1",
            2,
            "of 1 is outside 0 to 0.6",
        ),
        (
            "bake design triangular -o x.obj",
            "--dihedral-error-mrad 0,900,0",
            2,
            "of 900 is outside -100 to 100",
        ),
        ("bake design pentagon", "-o OUT", 2, "pentagon"),
        ("bake design triangular", "-o OUT", 2, ".obj or .glb"),
        (
            &format!("bake inspect {table}"),
            "--plot OUT",
            2,
            ".png or .svg",
        ),
        (&to_out, "--kernel eq2", 2, "--kernel"),
        (&to_out, "--lobe round", 2, "--lobe"),
        (&to_out, "--per-angle c", 2, "--per-angle"),
        (&to_out, "--fit-azimuth", 1, "bake trace --azimuth full"),
        (&to_out, "--threads 0", 2, "--threads"),
        (&to_out, "--threads 2.5", 2, "whole number, 1 or larger"),
        (&to_out, "--plot mtf.bmp", 2, "mtf.bmp"),
        (
            &estimate,
            "-o mtf.svg --plot ./mtf.svg",
            1,
            "is named for two outputs",
        ),
        (
            &estimate,
            &format!("-o {edge_of_campaign}"),
            1,
            "is an input of this command",
        ),
        (&estimate, "-o no/such/folder/r.json", 1, "no/such"),
        (&format!("fit estimate {manifest}"), "-o OUT", 2, "--table"),
        (&mtf, "--roi 1,2,3", 2, "--roi"),
        (&mtf, "--roi 0,0,9999,9999", 1, "camera_5deg.exr"),
        (&mtf, "--roi 0,0,4,4", 1, "camera_5deg.exr"),
        (&mtf, "--pixel-pitch -1", 2, "--pixel-pitch"),
        (&mtf, "--transfer gamma", 2, "--transfer"),
        (&mtf, "--channel infrared", 1, "infrared"),
        (&predict_of("none.json"), "", 1, "none.json"),
        (&predict_of(&manifest), "", 1, "captures.toml"),
        (&predict, "--distance 0 --incidence 10", 2, "--distance"),
        (&predict, "--distance 9 --incidence 90", 2, "--incidence"),
    ];
    for (command, more, code, part) in cases {
        bench.refuses(&here, &format!("{command} {more}"), code, &[part]);
    }
    bench.all_refused(71);
}

/// Azimuths have one rule at all doors: from -360 to 360 degrees. Those of manifests have it too
/// (`azimuth_beyond_a_turn.toml`).
#[test]
fn azimuths_have_one_rule() {
    let mut bench = Bench::new();
    let here = bench.path().to_owned();
    bake_table(&here, "triangular", "0,20", "-360,0,360");
    let sheet = "--sheet hollow-0.2 --distance 150 --incidence 20";
    let doors = [
        "bake trace triangular.obj -o OUT --incidence 20",
        &format!("fit predict {sheet} -o OUT"),
        &format!("fit render {sheet} -o OUT --source none.png"),
        &format!("fit explore {sheet} -o OUT"),
    ];
    for door in doors {
        for azimuth in ["719", "-360.5", "360.0000001"] {
            let line = format!("{door} --azimuth {azimuth}");
            bench.refuses(&here, &line, 2, &["from -360 to 360"]);
        }
    }
    for azimuth in ["-360,-30,360", "-360:360:90"] {
        let line = format!("predict {sheet} -o p.csv --azimuth {azimuth}");
        fit(&here, &line).done();
    }
    bench.all_refused(4 * 3);
}
