//! Standard output and standard error that are closed, full, or a pipe without a reader: no verb
//! panics, and each ends with the exit code that is documented.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

use tests::program::fresh;

use crate::files::kills::cases;

/// Commands that write nothing or fail, beside those of [`cases`].
const OTHERS: [&str; 15] = [
    "bake compare ../one.h5 ../one.h5",
    "bake verify ../pair.h5",
    "bake verify ../pair.h5 --json",
    "bake inspect ../pair.h5",
    "bake design --list",
    "bake completions bash",
    "bake --help",
    "bake --version",
    "bake inspect none.h5",
    "bake inspect --no-such-option",
    "fit mtf none.exr",
    "fit study --no-such-option",
    "fit completions zsh",
    "fit evaluate a.png b.png",
    "fit estimate ../campaign/captures.toml --table ../pair.h5 --kernel eq1 --lobe radial --json",
];

/// Damage to the standard streams of a command.
#[derive(Debug, Clone, Copy)]
enum Broken {
    NoErrors,
    NoOutput,
    Neither,
    FullErrors,
    FullOutput,
    ErrorsUnread,
    OutputUnread,
}

const BROKEN: [Broken; 7] = [
    Broken::NoErrors,
    Broken::NoOutput,
    Broken::Neither,
    Broken::FullErrors,
    Broken::FullOutput,
    Broken::ErrorsUnread,
    Broken::OutputUnread,
];

/// A pipe whose reader is gone.
fn unread() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

/// Runs a command with a broken stream, and returns its exit code and what it said.
fn code(folder: &Path, words: &[String], broken: Option<Broken>) -> (Option<i32>, [String; 2]) {
    let program = fresh(&words[0]);
    let close = match broken {
        Some(Broken::NoErrors) => "exec \"$@\" 2>&-",
        Some(Broken::NoOutput) => "exec \"$@\" >&-",
        Some(Broken::Neither) => "exec \"$@\" >&- 2>&-",
        _ => "exec \"$@\"",
    };
    let mut command = Command::new("sh");
    command
        .args(["-c", close, "sh"])
        .arg(program)
        .args(&words[1..])
        .current_dir(folder);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let full = || Stdio::from(File::options().write(true).open("/dev/full").unwrap());
    match broken {
        Some(Broken::FullErrors) => command.stderr(full()),
        Some(Broken::FullOutput) => command.stdout(full()),
        Some(Broken::ErrorsUnread) => command.stderr(unread()),
        Some(Broken::OutputUnread) => command.stdout(unread()),
        _ => &mut command,
    };
    let output = command.output().unwrap();
    let said = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into());
    (output.status.code(), said)
}

#[test]
#[ignore = "half a minute: `make test-kills` runs it"]
fn broken_streams_end_no_verb() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let cases = cases(here);
    let own = cases.into_iter().map(|case| case.words);
    let others = OTHERS.map(|line| line.split_whitespace().map(str::to_owned).collect());
    let mut tried = 0;
    for (number, mut words) in own.chain(others).enumerate() {
        let inside = here.join(number.to_string());
        std::fs::create_dir(&inside).unwrap();
        let line = words.join(" ");
        // A campaign is not written twice to one folder without it.
        if line.starts_with("fit simulate") && !line.contains("--force") {
            words.push("--force".to_owned());
        }
        let (whole, [out, _]) = code(&inside, &words, None);
        assert!(whole.is_some_and(|code| code < 3), "{line}: {whole:?}");
        for broken in BROKEN {
            let (found, said) = code(&inside, &words, Some(broken));
            // What cannot be printed is work that failed, except for help and version, which clap
            // prints. A reader that went away has read enough.
            let of_clap = line.ends_with("--help") || line.ends_with("--version");
            let expected = match broken {
                Broken::FullOutput if whole == Some(0) && !out.is_empty() && !of_clap => Some(1),
                _ => whole,
            };
            assert_eq!(found, expected, "{line}, {broken:?}: {said:?}");
            assert!(
                !said.concat().contains("panicked"),
                "{line}, {broken:?}: {said:?}"
            );
            tried += 1;
        }
    }
    println!("{tried} runs");
}
