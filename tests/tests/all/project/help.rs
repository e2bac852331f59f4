//! Help texts and exit codes: every verb shows an example, every example runs as printed, and each
//! exit code has its documented meaning.

use std::path::Path;

use tests::files::argument;
use tests::program::{Run, bake, fit, run};

const PROGRAMS: [&str; 2] = ["bake", "fit"];

/// Returns the verbs of a program: the names under `Commands:`, without `help`.
fn verbs(program: &str) -> Vec<String> {
    run(program, Path::new("."), "--help")
        .done()
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        // The lines of a wrapped description have a larger indent than a name.
        .filter(|line| !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|verb| *verb != "help")
        .map(str::to_owned)
        .collect()
}

/// Returns the command lines of a help text's examples. A line that a backslash or the terminal's
/// width broke is joined again.
fn examples(help: &str) -> Vec<Vec<String>> {
    let mut lines: Vec<String> = Vec::new();
    let mut inside = false;
    for line in help.lines().skip_while(|line| !line.starts_with("Example")) {
        let command = PROGRAMS
            .iter()
            .any(|name| line.trim_start().starts_with(&format!("{name} ")));
        match (line.starts_with("  "), command, inside) {
            (true, true, _) => lines.push(line.trim().trim_end_matches('\\').to_owned()),
            (true, false, true) => {
                let last = lines.last_mut().expect("a command came before");
                last.push(' ');
                last.push_str(line.trim().trim_end_matches('\\'));
            }
            _ => {}
        }
        inside = line.starts_with("  ") && (command || inside);
    }
    lines
        .iter()
        .map(|line| line.split_whitespace().map(str::to_owned).collect())
        .collect()
}

/// Returns the text of the file of this name that a help shows.
fn shown(help: &str, name: &str) -> String {
    help.lines()
        .skip_while(|line| !line.ends_with(&format!("({name}):")))
        .skip(1)
        .take_while(|line| !line.is_empty())
        .map(|line| format!("{}\n", line.trim()))
        .collect()
}

/// Writes a photograph of an edge as a 16-bit PNG, large enough for the region that the help names.
fn photograph(file: &Path) {
    let bright = |x: u32, y: u32| f64::from(x) + 0.09 * f64::from(y) > 385.0;
    image::ImageBuffer::from_fn(640, 480, |x, y| {
        image::Luma([if bright(x, y) { 50_000_u16 } else { 2_000 }])
    })
    .save(file)
    .unwrap();
}

#[test]
#[ignore = "over a minute: `make test-pages` runs it"]
fn every_example_runs_as_printed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let planted = argument("tests/tests/all/planted/eq1.toml");
    let line = format!("simulate {planted} -o {} --force", here.display());
    fit(here, &line).done();
    std::fs::copy(
        argument("tests/edges/camera_5deg.exr"),
        here.join("edge.exr"),
    )
    .unwrap();
    let ranges = "photographs = { from = 2, to = 3 }\n";
    std::fs::write(here.join("ranges.toml"), ranges).unwrap();
    for name in ["photo.png", "content.png", "photograph.png"] {
        photograph(&here.join(name));
    }
    // The two tables in the example of `bake compare`.
    bake(here, "design triangular -o cell.obj").done();
    for seed in ["1", "2"] {
        let table = format!("seed{seed}.h5");
        let rays = format!("--method rays --rays 65536 --seed {seed} --refractive-index 1");
        bake(here, &format!("trace cell.obj -o {table} {rays}")).done();
    }
    // The examples run in order: later examples read files that earlier ones write.
    let mut helps = Vec::new();
    for program in PROGRAMS {
        helps.push((program.to_owned(), run(program, here, "--help").done()));
        for verb in verbs(program) {
            let help = run(program, here, &format!("{verb} --help")).done();
            assert_eq!(help, run(program, here, &["help", &verb]).done());
            helps.push((format!("{program} {verb}"), help));
        }
    }
    let (mut with_example, mut ran) = (0, 0);
    for (verb, help) in &helps {
        for (of, name) in [
            ("bake optimise", "GOAL.toml"),
            ("fit simulate", "PARAMS.toml"),
            ("fit plan", "PLAN.toml"),
        ] {
            if verb == of {
                std::fs::write(here.join(name.to_lowercase()), shown(help, name)).unwrap();
            }
        }
        let examples = examples(help);
        // The help of the program itself needs no example, because its verbs have some.
        assert!(
            !examples.is_empty() || !verb.contains(' '),
            "{verb} --help has no example"
        );
        with_example += usize::from(!examples.is_empty());
        for words in examples {
            let (program, arguments) = words.split_first().unwrap();
            let Run {
                line, code, err, ..
            } = run(program, here, arguments);
            assert_eq!(code, Some(0), "example of {verb}: {line}\n{err}");
            ran += 1;
        }
    }
    assert!(
        with_example >= helps.len() - 1 && ran >= 12,
        "{with_example} of {}, {ran} ran",
        helps.len()
    );
}

#[test]
fn exit_codes() {
    let here = Path::new(".");
    for program in PROGRAMS {
        for verb in verbs(program) {
            assert_eq!(
                run(program, here, &[verb.as_str(), "--no-such-option"]).code,
                Some(2),
                "{program} {verb}"
            );
        }
        assert_eq!(run(program, here, "--version").code, Some(0));
        assert_eq!(run(program, here, "no-such-verb").code, Some(2));
        assert_eq!(run(program, here, "").code, Some(2));
    }
    assert_eq!(bake(here, "inspect no-such-table.h5").code, Some(1));
    assert_eq!(fit(here, "mtf no-such-image.exr").code, Some(1));
}
