//! Order of the rooms (folders of `src`) of each crate, and checks that a violation would be found.

use std::collections::BTreeSet;

use tests::files::project;
use tests::rooms::{self, Sources, circles, imports, room, upward};

/// Rooms of each crate, from the lowest to the highest. A room imports only rooms before it.
const ORDER: [(&str, &[&str]); 4] = [
    ("meshes", &["mesh", "files", "cell", "design"]),
    (
        "tables",
        &[
            "options", "table", "error", "lookup", "otf", "merge", "file", "cli",
        ],
    ),
    (
        "bake",
        &[
            "geometry", "samples", "optics", "cell", "plan", "rays", "beams", "proof", "run",
            "plots", "study", "cli",
        ],
    ),
    (
        "fit",
        &[
            "numerics",
            "names",
            "document",
            "photographs",
            "model",
            "samples",
            "simulate",
            "compare",
            "estimate",
            "result",
            "predict",
            "images",
            "explore",
            "study",
            "report",
            "cli",
        ],
    ),
];

fn sources_of(package: &str) -> Sources {
    rooms::read(&project().join(package).join("src"))
}

#[test]
fn every_folder_is_a_room_with_a_head() {
    for (package, order) in ORDER {
        let sources = sources_of(package);
        let folders: BTreeSet<&str> = sources.keys().filter_map(|file| room(file)).collect();
        let listed: BTreeSet<&str> = order.iter().copied().collect();
        assert_eq!(folders, listed, "{package}: rooms, and those listed here");
        for name in order {
            let head = &sources[&format!("{name}/mod.rs")];
            let words = head
                .lines()
                .take_while(|line| line.starts_with("//!"))
                .flat_map(str::split_whitespace)
                .count();
            assert!(
                words > 25,
                "{package}/src/{name}/mod.rs does not say what enters and what leaves"
            );
        }
    }
}

#[test]
fn imports_run_down() {
    for (package, order) in ORDER {
        let sources = sources_of(package);
        let wrong = upward(&sources, order);
        assert!(wrong.is_empty(), "{package}: {wrong:#?}");
        let count = imports(&sources).len();
        println!("{package}: {count} imports between {} files", sources.len());
        assert!(
            count > sources.len(),
            "{package}: {count} imports are too few to be read rightly"
        );
    }
}

/// Allowed circles inside a room. ARCHITECTURE.md gives the reason for each of them.
const CIRCLES: [(&str, &[&str]); 0] = [];

#[test]
fn circles_inside_rooms_are_those_that_are_named() {
    let architecture = std::fs::read_to_string(project().join("ARCHITECTURE.md")).unwrap();
    let mut found = BTreeSet::new();
    for (package, _) in ORDER {
        for circle in circles(&sources_of(package)) {
            let files: Vec<String> = circle
                .iter()
                .map(|file| format!("{package}/src/{file}"))
                .collect();
            for file in &files {
                assert!(
                    architecture.contains(file),
                    "ARCHITECTURE.md gives no reason for a circle with {file}: {files:?}"
                );
            }
            found.insert(files);
        }
    }
    let named: BTreeSet<Vec<String>> = CIRCLES
        .iter()
        .map(|(package, files)| {
            files
                .iter()
                .map(|file| format!("{package}/src/{file}"))
                .collect()
        })
        .collect();
    assert_eq!(found, named);
}

/// The simulator tests the model. So it must take no formula of light from the model.
#[test]
fn the_simulator_shares_only_names_with_the_model() {
    let sources = sources_of("fit");
    let shared: BTreeSet<String> = imports(&sources)
        .into_iter()
        .filter(|import| {
            room(&import.from) == Some("simulate") && room(&import.to) != Some("simulate")
        })
        .map(|import| room(&import.to).unwrap_or("the root").to_owned())
        .collect();
    // These rooms hold keys of files, names and numerical methods. None has a formula of light.
    let ground = ["document", "names", "numerics"].map(str::to_owned);
    assert_eq!(shared, BTreeSet::from(ground));
}

/// Returns the findings in a crate of two rooms, with `text` in a file of the lower room `below`.
fn planted(text: &str) -> Vec<String> {
    let files = [
        ("lib.rs", "mod above;\nmod below;\npub use above::Roof;"),
        (
            "above/mod.rs",
            "mod roof;\npub(crate) use roof::Roof;\npub(crate) mod tower;",
        ),
        (
            "above/roof.rs",
            "use crate::below::Ground;\npub struct Roof(Ground);",
        ),
        ("above/tower.rs", "pub fn height() -> f64 { 1.0 }"),
        (
            "below/mod.rs",
            "mod ground;\nmod other;\npub(crate) use ground::Ground;",
        ),
        ("below/ground.rs", "pub struct Ground;"),
        ("below/other.rs", text),
    ];
    let sources: Sources = files
        .map(|(file, text)| (file.to_owned(), text.to_owned()))
        .into();
    upward(&sources, &["below", "above"])
}

#[test]
fn a_planted_violation_is_found_however_it_is_written() {
    let roof = "below/other.rs imports above/roof.rs, which stands above it; that is a circle \
    between rooms, because above/roof.rs \
                imports below/ground.rs";
    let tower = roof.replacen("above/roof.rs", "above/tower.rs", 1);
    let root = "below/other.rs imports lib.rs, which stands above it";
    let cases: [(&str, &str); 13] = [
        ("use crate::above::Roof;", roof),
        (
            "use crate::{below::Ground, above::{self as up, Roof as R}};",
            roof,
        ),
        ("use super::super::above::Roof;", roof),
        ("pub(crate) use crate::above::Roof;", roof),
        ("fn f(r: &crate::above::Roof) {}", roof),
        (
            "fn f() { g(super::super::above::tower::height()); }",
            &tower,
        ),
        (
            "fn f() { println!(\"{}\", crate::above::tower::height()); }",
            &tower,
        ),
        (
            "#[arg(default_value_t = crate::above::tower::height())] struct S;",
            &tower,
        ),
        (
            "mod inner { use super::super::super::above::tower; }",
            &tower,
        ),
        ("use crate::above::tower::*;", &tower),
        ("use crate::Roof;", root),
        ("use crate as house;", root),
        ("fn f() { use crate::above::{tower::height}; }", &tower),
    ];
    for (text, expected) in &cases {
        let found = planted(text);
        assert!(
            found.iter().any(|sentence| sentence == expected),
            "{text}: {found:#?}"
        );
    }
    // These imports are allowed: of the own room in every form, of another crate, in a test, and in
    // a comment.
    let allowed = [
        "use crate::below::Ground;",
        "use super::Ground;",
        "use super::ground::Ground;",
        "use std::above::Roof;",
        "// use crate::above::Roof;",
        "/// See [`crate::above::Roof`].\nfn f() {}",
        "#[cfg(test)]\nmod tests { use crate::above::Roof; }",
        "fn f() -> &'static str { \"crate::above::Roof\" }",
    ];
    for text in allowed {
        assert_eq!(planted(text), Vec::<String>::new(), "{text}");
    }
    println!(
        "{} violations and {} allowed imports",
        cases.len(),
        allowed.len()
    );
}

#[test]
fn a_planted_circle_inside_a_room_is_found() {
    let files = [
        (
            "room/mod.rs",
            "mod a;\nmod b;\nmod c;\npub(crate) use a::A;\npub(crate) use c::C;",
        ),
        ("room/a.rs", "use crate::room::b::B;\npub struct A(B);"),
        ("room/b.rs", "pub struct B(Option<Box<super::A>>);"),
        ("room/c.rs", "use super::A;\npub struct C(A);"),
    ];
    let sources: Sources = files
        .map(|(file, text)| (file.to_owned(), text.to_owned()))
        .into();
    assert_eq!(circles(&sources), [["room/a.rs", "room/b.rs"]]);
}
