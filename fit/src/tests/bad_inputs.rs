//! Tests that every file in tests/bad is refused with the message in tests/bad/expected.toml.
//!
//! good.exr and good.png belong to manifests that have another fault. These two files must load.

use std::path::Path;

use crate::photographs::{captures, photo};

/// The message with which a manifest or one of its photographs is refused.
fn manifest_error(file: &Path) -> Option<String> {
    let campaign = match captures::load(file) {
        Ok(campaign) => campaign,
        Err(error) => return Some(error.to_string()),
    };
    campaign
        .captures
        .iter()
        .find_map(|capture| capture.shot.load().err())
        .map(|error| error.to_string())
}

fn image_error(file: &Path) -> Option<String> {
    photo::load(file, &photo::channel::Decode::default())
        .err()
        .map(|error| error.to_string())
}

fn simulate_error(file: &Path) -> Option<String> {
    crate::simulate::Params::load(file)
        .err()
        .map(|error| error.to_string())
}

type Refuse = fn(&Path) -> Option<String>;

#[test]
fn every_bad_file_is_refused_with_its_message() {
    // Messages name files by their full path. The folder is removed, so that the expectations are
    // short.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let before = format!("{}/", folder.display());
    let bad = folder.join("bad");
    let expected: toml::Table = std::fs::read_to_string(bad.join("expected.toml"))
        .unwrap()
        .parse()
        .unwrap();
    let groups: [(&str, Refuse, usize); 3] = [
        ("manifests", manifest_error, 32),
        ("images", image_error, 22),
        ("simulate", simulate_error, 4),
    ];
    let mut failures = Vec::new();
    let mut named = vec![
        "expected.toml".to_owned(),
        "good.exr".to_owned(),
        "good.png".to_owned(),
    ];
    for (group, refuse, count) in groups {
        let cases = expected[group].as_table().unwrap();
        assert_eq!(cases.len(), count, "{group}");
        for (name, message) in cases {
            named.push(name.clone());
            let found = refuse(&bad.join(name)).unwrap_or_else(|| "accepted".to_owned());
            let found = found.replace(&before, "");
            if !found.contains(message.as_str().unwrap()) {
                failures.push(format!("{name}\n  expected {message}\n  found    {found}"));
            }
            if found.contains('\n') || found.len() > 300 {
                failures.push(format!("{name}: more than one sentence: {found}"));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    for entry in std::fs::read_dir(&bad).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(named.contains(&name), "{name} has no expected message");
    }
    for good in ["good.exr", "good.png"] {
        assert_eq!(image_error(&bad.join(good)), None, "{good}");
    }
}
