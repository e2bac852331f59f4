//! Tests of the program from outside: exit codes, messages, and outputs that stay whole.

use crate::program::{Folder, said};

#[test]
fn from_design_to_picture() {
    let folder = Folder::with(&[]);
    assert_eq!(folder.quiet("design --list").lines().count(), 6);
    folder.quiet("design triangular-pair -o pair.obj");
    folder.quiet("design triangular-pair -o pair.glb");
    let trace = "trace pair.obj --rays 20000 --incidence 0,20 --method rays";
    let line = format!("{trace} -o pair.h5 --refractive-index 1.49 --unit mm --json");
    let report: serde_json::Value = serde_json::from_str(&folder.quiet(&line)).expect("JSON");
    assert_eq!(report["directions"].as_array().expect("a list").len(), 2);
    let fates = report["directions"][0]["fates"].as_object().expect("fates");
    let sum: f64 = fates.values().filter_map(serde_json::Value::as_f64).sum();
    assert!((sum - 1.0).abs() < 1e-12);
    assert!(folder.quiet("inspect pair.h5").contains("triangular-pair"));
    let inspected = folder.quiet("inspect pair.h5 --plot pair.SVG --json");
    let inspected: serde_json::Value = serde_json::from_str(&inspected).expect("JSON");
    assert!(inspected.to_string().contains(r#""edge_length_unit":"mm""#));
    let picture = String::from_utf8(folder.read("pair.SVG")).expect("a picture");
    assert_eq!(charts::check::faults(&picture), [""; 0]);
    assert!(folder.quiet("verify pair.h5").contains("valid"));
    // The seal is cut off, as a program does that opens the table for writing.
    let sealed = folder.read("pair.h5");
    folder.write("cut.h5", &sealed[..sealed.len() - 40]);
    let cut = folder.quiet("verify cut.h5");
    assert!(cut.contains("its seal is gone"), "{cut}");
    // A table with another seed agrees within the errors. A table with another index does not, and
    // the exit code is 1.
    folder.quiet(&format!(
        "{trace} --seed 2 --refractive-index 1.49 -o seed.h5"
    ));
    folder.quiet(&format!(
        "{trace} --seed 1 --refractive-index 1.3 -o index.h5"
    ));
    folder.quiet("compare pair.h5 seed.h5");
    folder.refused("compare pair.h5 index.h5", 1, "the tables differ");
}

#[test]
fn wrong_usage_and_failed_work() {
    let folder = Folder::with(&["triangular"]);
    folder.write("old.h5", "precious");
    folder.write("bad.obj", "v 0 0 0\n");
    let trace = "trace triangular.obj -o old.h5";
    let mut refused = 0;
    for (line, code, sentence) in [
        ("trace triangular.obj", 2, "--output"),
        ("--incidence 95", 2, "--incidence 95: the angle must be"),
        ("--lattice 1,2", 2, "--lattice 1,2: give 6 numbers"),
        ("--tolerance -1", 2, "--tolerance -1: give a number"),
        ("--sampler halton", 2, "invalid value 'halton'"),
        ("trace none.obj -o old.h5", 1, "none.obj"),
        ("trace bad.obj -o old.h5", 1, "bad.obj"),
        ("trace triangular.obj -o no/such/folder.h5", 1, "no/such"),
        ("inspect old.h5", 1, "old.h5: is not an HDF5 file"),
        ("design pentagon -o x.obj", 2, "pentagon"),
        ("design triangular -o x.stl", 2, "x.stl: the extension must"),
    ] {
        match line.starts_with("--") {
            true => folder.refused(&format!("{trace} {line}"), code, sentence),
            false => folder.refused(line, code, sentence),
        }
        assert_eq!(folder.read("old.h5"), b"precious");
        refused += 1;
    }
    assert_eq!(refused, 11);
    let names = ["bad.obj", "old.h5", "triangular.obj"];
    assert_eq!(folder.names(), names, "no half-written file stays");
}

/// Bakes a table for each wavelength with the indices of that wavelength, and checks it by photons.
#[test]
fn prisms_with_losses_at_several_wavelengths() {
    let folder = Folder::with(&["triangular-pair"]);
    let losses = "--losses fresnel --metal silver --incidence 0,30";
    let glass = "--refractive-index pmma --wavelength-nm 450,650 --json";
    let trace = "trace triangular-pair.obj -o pair-{nm}.h5";
    let report = folder.quiet(&format!("{trace} {losses} {glass}"));
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    let mut etas = Vec::new();
    for (k, nm, index) in [(0, 450.0, 1.50061), (1, 650.0, 1.48809)] {
        let file = format!("pair-{nm}.h5");
        assert_eq!(report["tables"][k]["table"], file.as_str());
        let held = folder.json(&format!("inspect {file} --json"));
        let number = |value: &serde_json::Value| value.as_f64().expect("a number");
        assert_eq!(held["wavelength_nm"], nm);
        assert!((number(&held["refractive_index"]) - index).abs() <= 5e-6);
        assert_eq!(held["losses"], "fresnel");
        assert!(number(&held["metal_index"][1]) > 2.0);
        etas.push(number(&held["directions"][0]["retroreflected"]));
        let text = folder.quiet(&format!("inspect {file}"));
        assert!(
            text.contains("mirror, fresnel, metal of index 0.1"),
            "{text}"
        );
        let mesh = "--mesh triangular-pair.obj --rays 65536";
        let judged = folder.quiet(&format!("verify {file} {mesh}"));
        assert!(
            judged.contains("yes") && !judged.contains(" no\n"),
            "{judged}"
        );
    }
    // Silver reflects red better than blue. Both tables keep less than two thirds of the light,
    // because of the front face and three reflections.
    let [blue, red] = etas[..] else {
        panic!("two tables")
    };
    assert!(0.4 < blue && blue < red && red < 0.6, "{blue} {red}");
    for (options, sentence) in [
        ("--wavelength-nm 450,650", "names 2 wavelengths"),
        ("--refractive-index pmma", "pmma depends on the wavelength"),
        ("--refractive-index wood", "pmma, polycarbonate, bk7"),
        (
            "--metal silver --wavelength-nm 550",
            "--metal needs --losses",
        ),
        ("--metal tin", "--metal tin: give aluminium, silver"),
        ("--losses fresnel --reflectance 0", "--reflectance 0"),
    ] {
        let line = format!("trace triangular-pair.obj -o x.h5 {options}");
        folder.refused(&line, 2, sentence);
    }
    folder.refused(trace, 2, "{nm} stands for a wavelength");
    assert!(!folder.file("x.h5").exists());
}

/// Checks that a sheet of many cubes is taken apart without a message.
///
/// Where the digits of the file do not allow it, one line says why.
#[test]
fn a_sheet_that_is_traced_as_a_whole() {
    let folder = Folder::with(&["triangular-pair"]);
    let pair = meshes::load(&folder.file("triangular-pair.obj")).expect("a mesh");
    let [right, up] = [1, 2].map(|corner| pair.positions[corner] - pair.positions[3]);
    let sheet = |number: &dyn Fn(f64) -> String| {
        let (mut obj, mut first) = (String::new(), 1);
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (f64::from(i), f64::from(j)))) {
            for &p in &pair.positions {
                let [x, y, z] = (p + right * i + up * j).to_array().map(number);
                obj += &format!("v {x} {y} {z}\n");
            }
            for [a, b, c] in &pair.triangles {
                obj += &format!("f {} {} {}\n", a + first, b + first, c + first);
            }
            first += pair.positions.len() as u32;
        }
        obj
    };
    let trace = "trace sheet.obj -o sheet.h5 --refractive-index 1.49 --incidence 20";
    folder.write("sheet.obj", sheet(&|x| x.to_string()));
    assert!(folder.quiet(trace).contains("method exact"));
    folder.write("sheet.obj", sheet(&|x| format!("{:.6}", x * 0.057_735_03)));
    let output = folder.run(trace);
    assert!(output.status.success());
    for part in ["the mesh is traced as a whole", "to the last digit"] {
        assert!(said(&output).contains(part), "{}", said(&output));
    }
}

/// Checks that a picture cannot take the place of a table or of another output.
#[test]
fn outputs_that_would_be_lost_are_refused() {
    let folder = Folder::with(&["triangular"]);
    folder.quiet("trace triangular.obj -o cube.h5 --incidence 0 --refractive-index 1");
    // `bake` would not give a table this name.
    std::fs::rename(folder.file("cube.h5"), folder.file("cube.svg")).expect("a table");
    let table = folder.read("cube.svg");
    let over = "inspect cube.svg --plot ./cube.svg";
    folder.refused(over, 1, "is an input of this command");
    let twice = "study triangular.obj --csv a.svg --plot ./a.svg --rays 1024";
    folder.refused(twice, 1, "named for two outputs");
    assert_eq!(folder.read("cube.svg"), table);
}

/// Checks that the program fails if its results cannot be written.
#[test]
fn a_full_standard_output_is_a_failure() {
    let full = std::fs::File::options().write(true).open("/dev/full");
    let mut command = Folder::with(&[]).command("design --list");
    let command = command
        .current_dir("/")
        .stdout(full.expect("Linux has one"));
    let output = command.output().expect("bake runs");
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("standard output cannot be written"));
}

#[test]
fn every_verb_helps_with_an_example() {
    let folder = Folder::with(&[]);
    for verb in "design trace study inspect compare verify merge".split(' ') {
        let help = folder.quiet(&format!("{verb} --help"));
        assert!(help.contains("Example"), "{help}");
    }
}

/// Checks that one process refuses a run of several processes without the feature `mpi`.
///
/// Without MPI the processes do not know of each other. Each would do the whole bake and write over
/// the others.
#[cfg(not(feature = "mpi"))]
#[test]
fn without_mpi_a_run_of_many_is_refused_once() {
    let folder = Folder::with(&[]);
    let run = |rank: &str, line: &str| {
        let places = [
            ("OMPI_COMM_WORLD_SIZE", "2"),
            ("OMPI_COMM_WORLD_RANK", rank),
        ];
        let output = folder.command(line).envs(places).output();
        let output = output.expect("bake runs");
        (output.status.code(), said(&output))
    };
    let silent = (Some(0), String::new());
    assert_eq!(run("0", "design triangular -o cell.obj"), silent);
    let (code, message) = run("0", "trace cell.obj -o table.h5");
    assert_eq!(code, Some(2), "{message}");
    assert!(message.contains("one of 2 processes"), "{message}");
    assert_eq!(run("1", "trace cell.obj -o table.h5"), silent);
    assert!(!folder.file("table.h5").exists());
    let share = "trace cell.obj -o table.h5 --method rays --rays 1000 --shard 1/2 \
    --refractive-index 1";
    assert_eq!(run("0", share), silent);
}

/// The edge length of a truncated cube is that of the whole one, which the mesh states. A table is
/// named if another one replaces it, and only then.
#[test]
fn the_edge_length_and_what_is_replaced_are_said() {
    let folder = Folder::with(&[]);
    let design = "design triangular --edge-length 0.18 --truncation 0.2 -o cut.obj";
    folder.quiet(design);
    let stated = folder.quiet("trace cut.obj -o t.h5 --refractive-index 1 --incidence 0");
    assert!(
        stated.contains("edge length: 0.18 file unit (stated by the mesh)"),
        "{stated}"
    );
    assert!(!stated.contains("replaced"), "{stated}");
    let again = folder.quiet("trace cut.obj -o t.h5 --refractive-index 1 --incidence 0");
    assert!(!again.contains("replaced"), "{again}");
    let other = folder.quiet("trace cut.obj -o t.h5 --refractive-index 1 --incidence 0,10");
    assert!(
        other.contains("replaced: a table of triangular, 1 directions, content "),
        "{other}"
    );
}
