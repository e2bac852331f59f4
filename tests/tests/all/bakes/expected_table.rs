//! Tables of another content hash than the command line or the manifest asks for.

use std::fs;

use tests::files::{argument, bake_table_with};
use tests::program::fit;

/// A table of another content hash than the expected one is not used: option, key, and both.
#[test]
fn an_unexpected_table_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bake_table_with(here, "triangular-pair", "0:45:5", "30", "--bins 16");
    let hash = tables::read(&here.join(&table)).unwrap().content_hash();
    let (capital, other) = (hash.to_uppercase(), "0".repeat(64));
    let photographs = argument("tests/captures/public_shared");
    let plain = fs::read_to_string(format!("{photographs}/captures.toml")).unwrap();
    let plain = plain.replace("image = \"", &format!("image = \"{photographs}/"));
    for (name, key) in [
        ("plain", None),
        ("same", Some(&capital)),
        ("other", Some(&other)),
    ] {
        let key = key.map_or(String::new(), |hash| format!("expect_table = \"{hash}\"\n"));
        let text = plain.replacen("[setup]\n", &format!("[setup]\n{key}"), 1);
        assert_eq!(
            text.len(),
            plain.len() + key.len(),
            "the manifest has [setup]"
        );
        fs::write(here.join(format!("{name}.toml")), text).unwrap();
    }
    let terms = "--kernel eq1 --lobe separable --shared a,c,mu";
    let (found, in_line) = (
        format!("{table}: has the content hash {hash}"),
        "`expect_table` in other.toml:".to_owned(),
    );
    let differ = "toml:2: `expect_table` and --expect-table name different hashes".to_owned();
    // Verb, manifest, option, and what the refusal says.
    let cases: [(&str, &str, Option<&str>, &[&String]); 12] = [
        ("estimate", "plain.toml", None, &[]),
        ("estimate", "plain.toml", Some(&capital), &[]),
        ("estimate", "plain.toml", Some(&other), &[&found]),
        ("estimate", "plain.toml", Some(&hash[..63]), &[&found]),
        ("estimate", "same.toml", None, &[]),
        ("estimate", "same.toml", Some(&hash), &[]),
        ("estimate", "same.toml", Some(&other), &[&differ]),
        ("estimate", "other.toml", None, &[&found, &in_line]),
        ("estimate", "other.toml", Some(&hash), &[&differ]),
        ("estimate", "other.toml", Some(&other), &[&found, &in_line]),
        ("study", "same.toml", None, &[]),
        ("study", "other.toml", None, &[&found, &in_line]),
    ];
    for (verb, manifest, option, says) in cases {
        let mut words = format!("{verb} {manifest} --table {table}");
        words += &format!(" {terms}");
        if verb == "estimate" {
            words += " --loss mtf";
        }
        if let Some(hash) = option {
            words += &format!(" --expect-table {hash}");
        }
        let run = fit(here, &words);
        assert_eq!(
            run.code,
            Some(i32::from(!says.is_empty())),
            "{words:?}\n{}",
            run.err
        );
        for part in says {
            assert!(run.err.contains(*part), "{words:?}\n{}", run.err);
        }
    }
    println!("{} runs", cases.len());
}
