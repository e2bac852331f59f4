//! Tests of the program as a shell and a reader of manual pages see it. (Because this target
//! exists, cargo builds the program for the tests of the workspace.)

use std::path::Path;
use std::process::{Command, Output};

fn fit(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fit"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns the verbs that the help lists.
fn verbs(folder: &Path) -> Vec<String> {
    let help = text(&fit(&["--help"], folder).stdout);
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    lines
        .take_while(|line| !line.is_empty())
        .filter(|line| !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|verb| *verb != "help")
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_verb_is_completed_and_has_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let verbs = verbs(here);
    assert!(verbs.len() >= 8, "{verbs:?}");
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let output = fit(&["completions", shell], here);
        assert!(output.status.success(), "{shell}");
        let script = text(&output.stdout);
        for verb in &verbs {
            assert!(script.contains(verb.as_str()), "{shell}: {verb}");
        }
    }
    let output = fit(&["manual", "pages"], here);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let pages = text(&output.stdout);
    assert_eq!(pages.lines().count(), verbs.len() + 1);
    for verb in &verbs {
        let page = std::fs::read_to_string(here.join(format!("pages/fit-{verb}.1"))).unwrap();
        assert!(
            page.contains(".SH EXTRA") || page.contains("Example"),
            "{verb}"
        );
    }
    // A folder that cannot be created gives one sentence, no panic.
    std::fs::write(here.join("file"), "").unwrap();
    let refused = fit(&["manual", "file"], here);
    assert_eq!(refused.status.code(), Some(1));
    assert!(text(&refused.stderr).starts_with("error: file: the folder cannot be made"));
    println!("{} verbs, 5 shells", verbs.len());
}

#[test]
fn the_version_names_the_commit_that_the_build_was_told() {
    let shown = text(&fit(&["--version"], Path::new(".")).stdout);
    let expected = match option_env!("AIRR_COMMIT") {
        Some(commit) => format!("fit {} ({commit})\n", env!("CARGO_PKG_VERSION")),
        None => format!("fit {}\n", env!("CARGO_PKG_VERSION")),
    };
    assert_eq!(shown, expected);
}
