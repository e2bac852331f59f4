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
    // Manifests with another fault name the good ones, which are read, but are too small to measure.
    let mut named = ["expected.toml", "good.exr", "good.png"]
        .map(String::from)
        .to_vec();
    for (group, files) in &groups {
        for (file, part) in files.as_table().unwrap() {
            named.push(file.clone());
            let line = match group.as_str() {
                "manifests" => format!("fit estimate bad/{file} --table {table} -o OUT"),
                "images" => format!("fit mtf bad/{file} -o OUT"),
                "simulate" => format!("fit simulate bad/{file} -o OUT"),
                other => panic!("no verb for the group {other}"),
            };
            bench.refuses(&folder, &line, 1, &[part.as_str().unwrap()]);
            cases += 1;
        }
    }
    assert!(groups.len() == 3 && cases > 40);
    bench.all_refused(cases);
    for entry in std::fs::read_dir(folder.join("bad")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(named.contains(&name), "{name} has no expected message");
    }
    for good in ["good.exr", "good.png"] {
        let run = fit(&folder, &format!("mtf bad/{good}"));
        assert!(run.err.contains("on one side of the edge"), "{}", run.err);
    }
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

/// Wrong command lines: a command, and under it the exit code, what is added to the command, and a
/// part of the sentence.
const REFUSED: &str = r#"
bake trace triangular.obj -o OUT
    2 | --incidence 90 | --incidence 90
    2 | --incidence -1 | --incidence -1
    2 | --incidence 0:45 | --incidence 0:45
    2 | --incidence 0:45:0 | --incidence 0:45:0
    2 | --incidence ten | --incidence ten
    2 | --azimuth nan | --azimuth nan
    2 | --azimuth= | --azimuth
    2 | --azimuth -361 | from -360 to 360
    2 | --azimuth full:x | "x" is not a number
    2 | --refractive-index 0.5 | --refractive-index 0.5
    2 | --refractive-index wood | pmma, polycarbonate, bk7
    2 | --refractive-index bk7 | depends on the wavelength
    2 | --rays 0 | --rays
    2 | --rays many | --rays
    2 | --bins 0 | --bins
    2 | --bins many | whole number from 1 to 4096
    2 | --range 0 | --range
    2 | --range 1e6 | --range 1000000
    2 | --tolerance 0 | --tolerance
    2 | --angular-tolerance -3 | --angular-tolerance
    2 | --angular-tolerance 20 | at most 10 degrees
    2 | --lattice 1,0,0 | --lattice
    2 | --azimuth-zero 1,0 | --azimuth-zero
    2 | --edge-length -2 | --edge-length
    2 | --edge-length 1e20 | does not fit a cell 3 wide
    2 | --metal tin | --metal tin
    2 | --reflectance 0.9 | needs --losses fresnel
    2 | --deviations wide | auto, off, or a range in mrad
    2 | --wavelength-nm 0 | --wavelength-nm 0
    2 | --wavelength-nm 450,650 | write {nm}
    2 | --roughness ggx:2 | ALPHA above 0 and at most 1
    2 | --glass-index 0.9 | --glass-index 0.9
    1 | --glass-index 1.9 | no face of the material "glass"
    2 | --element bead | retroreflector, plate
    2 | --threads 0 | --threads
    2 | --method guess | --method
    2 | --back glass | --back
bake trace triangular.obj
    1 | -o ./triangular.obj | is an input of this command
    1 | -o no/such/folder/t.h5 | no/such
    1 | -o . |
    2 | | --output
bake study triangular.obj
    1 | --csv triangular.obj | is an input of this command
bake design canted -o x.obj
    2 | --cant-deg 80 | 80 is outside -34.5 to 52
bake design plate -o x.obj
    2 | --depth -3 | -3 is outside 0.001 to 1000
bake design triangular -o x.obj
    2 | --depth 3 | triangular does not take a depth
    2 | --edge-radius 1 | of 1 is outside 0 to 0.6
    2 | --dihedral-error-mrad 0,900,0 | of 900 is outside -100 to 100
bake design pentagon
    2 | -o OUT | pentagon
bake design triangular
    2 | -o OUT | .obj or .glb
bake inspect {table}
    2 | --plot OUT | must be .svg
fit estimate {manifest} --table {table} -o OUT
    2 | --kernel eq2 | --kernel
    2 | --lobe round | --lobe
    2 | --per-angle c | --per-angle
    1 | --fit-azimuth | bake trace --azimuth full
    2 | --threads 0 | --threads
    2 | --threads 2.5 | whole number, 1 or larger
    2 | --plot mtf.bmp | mtf.bmp
fit estimate {manifest} --table {table}
    1 | -o mtf.svg --plot ./mtf.svg | is named for two outputs
    1 | -o {of_campaign} | is an input of this command
    1 | -o no/such/folder/r.json | no/such
fit estimate {manifest}
    2 | -o OUT | --table
fit mtf {edge} -o OUT
    2 | --roi 1,2,3 | --roi
    1 | --roi 0,0,9999,9999 | camera_5deg.exr
    1 | --roi 0,0,4,4 | camera_5deg.exr
    2 | --pixel-pitch -1 | --pixel-pitch
    2 | --transfer gamma | --transfer
    1 | --channel infrared | infrared
fit predict none.json --table {table} --distance 9 --incidence 10 -o OUT
    1 | | none.json
fit predict {manifest} --table {table} --distance 9 --incidence 10 -o OUT
    1 | | captures.toml
fit predict r.json --table {table} -o OUT
    2 | --distance 0 --incidence 10 | --distance
    2 | --distance 9 --incidence 90 | --incidence
"#;

#[test]
fn options() {
    let mut bench = Bench::new();
    let here = bench.path().to_owned();
    let names = [
        ("{table}", bake_table(&here, "triangular", "10,25,40", "10")),
        (
            "{manifest}",
            argument("tests/captures/public_axes/captures.toml"),
        ),
        (
            "{of_campaign}",
            argument("tests/captures/public_axes/source.exr"),
        ),
        ("{edge}", argument("tests/edges/camera_5deg.exr")),
    ];
    let mut command = "";
    for line in REFUSED.trim().lines() {
        let parts: Vec<&str> = line.split('|').map(str::trim).collect();
        let [code, more, part] = parts[..] else {
            command = line;
            continue;
        };
        let line = format!("{command} {more}");
        let replaced = |line: String, (name, path): &(&str, String)| line.replace(name, path);
        let line = names.iter().fold(line, replaced);
        bench.refuses(&here, &line, code.parse().unwrap(), &[part]);
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
        assert_eq!(fit(&here, &line).code, Some(0), "{azimuth}");
    }
    bench.all_refused(4 * 3);
}
