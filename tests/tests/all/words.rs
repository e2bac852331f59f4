//! Checks of the project's words against its rules (CONTRIBUTING.md, "Write").

use std::path::Path;

use tests::files::project;
use tests::words::{
    Term, anchors, dead_links, files, glossary, links, read, unlinked, weak_openings, wide_lines,
};

/// Terms of the glossary that are also words of everyday English, or single letters. A page may use
/// them without a link.
const EVERYDAY: [&str; 26] = [
    "a",
    "c",
    "r",
    "edge",
    "bound",
    "cell",
    "direction",
    "exposure",
    "fate",
    "manifest",
    "pair",
    "path",
    "step",
    "table",
    "seal",
    "edge-length",
    "full-cube",
    "triangular-cube",
    "floating-distance",
    "standard-error",
    "apex",
    "facet",
    "loss",
    "luminance",
    "normal",
    "sequence",
];

/// Pages that explain the project to its users. Other pages hold measurements or formats.
const PAGES: [&str; 4] = ["README.md", "doc", "bake/doc", "fit/doc"];

fn named(root: &Path, file: &Path) -> String {
    file.strip_prefix(root).unwrap().display().to_string()
}

fn fail_on(findings: &[String], counted: usize, what: &str) {
    println!("{counted} {what}, {} findings", findings.len());
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

#[test]
fn lines_are_no_wider_than_the_limit() {
    let root = project();
    let all = files(&root, &[".rs", ".md", ".py", ".toml", "Makefile"]);
    assert!(all.len() > 400, "{}", all.len());
    let findings: Vec<String> = all
        .iter()
        .flat_map(|file| {
            let lines = wide_lines(&read(file));
            lines
                .into_iter()
                .map(|line| format!("{}: {line}", named(&root, file)))
        })
        .collect();
    fail_on(&findings, all.len(), "files");
}

#[test]
fn doc_comments_stand_alone() {
    let root = project();
    let all = files(&root, &[".rs"]);
    let mut findings = Vec::new();
    for file in &all {
        let name = named(&root, file);
        let of_tests = name.contains("/tests/") || name.contains("/benches/");
        let weak = weak_openings(&read(file), !of_tests);
        findings.extend(weak.into_iter().map(|line| format!("{name}: {line}")));
    }
    fail_on(&findings, all.len(), "sources");
}

#[test]
fn links_lead_somewhere() {
    let root = project();
    let pages = files(&root, &[".md"]);
    let counted: usize = pages.iter().map(|page| links(&read(page)).len()).sum();
    assert!(counted > 150, "{counted}");
    let findings: Vec<String> = pages
        .iter()
        .flat_map(|page| {
            let dead = dead_links(page);
            dead.into_iter()
                .map(|link| format!("{}: {link}", named(&root, page)))
        })
        .collect();
    fail_on(&findings, counted, "links");
}

#[test]
fn terms_are_linked_where_a_page_uses_them() {
    let root = project();
    let model = root.join("fit/doc/model.md");
    let terms = glossary(&read(&model));
    assert!(terms.len() > 40, "{}", terms.len());
    for name in EVERYDAY {
        assert!(
            terms.iter().any(|term| term.anchor == name),
            "{name} is no term"
        );
    }
    let trade: Vec<Term> = terms
        .into_iter()
        .filter(|term| !EVERYDAY.contains(&term.anchor.as_str()))
        .collect();
    let pages: Vec<_> = PAGES
        .iter()
        .flat_map(|place| match root.join(place) {
            folder if folder.is_dir() => files(&folder, &[".md"]),
            page => vec![page],
        })
        .filter(|page| *page != model && !page.ends_with("table1/table.md"))
        .collect();
    let findings: Vec<String> = pages
        .iter()
        .flat_map(|page| {
            let text = read(page);
            let name = named(&root, page);
            unlinked(&text, &trade)
                .into_iter()
                .map(|term| format!("{name}: {} is not linked", term.anchor))
                .collect::<Vec<_>>()
        })
        .collect();
    fail_on(&findings, pages.len(), "pages");
}

#[test]
fn planted_violations_are_found() {
    assert_eq!(wide_lines(&"x".repeat(101)), ["line 1: 101 columns"]);
    assert!(wide_lines(&"x".repeat(100)).is_empty());
    assert!(wide_lines(&format!("| {} |", "x".repeat(100))).is_empty());

    let weak = |source: &str| weak_openings(source, true).len();
    for (source, expected) in [
        ("/// Returns the mean.\npub fn mean() {}", 0),
        ("/// The mean.\npub fn mean() {}", 1),
        ("/// The mean is 0.\n#[test]\nfn mean_is_zero() {}", 0),
        ("/// The mean.\n#[must_use]\nfn mean() {}", 1),
        ("/// Rays of a bake.\npub(crate) const fn rays() {}", 1),
        ("/// The mean.\npub mean: f64,", 0),
        ("/// The same over a sheet.\npub mean: f64,", 1),
        ("/// Its mean.\n#[derive(Debug)]\nstruct Mean;", 1),
        ("/// Italic letters.\nstruct Mean;", 0),
        (
            "/// Reads.\n///\n/// # Errors\n///\n/// [`Error`].\npub fn read() {}",
            1,
        ),
        (
            "/// Reads.\n///\n/// # Errors\n///\n/// Returns [`Error`] always.\nfn read() {}",
            0,
        ),
    ] {
        assert_eq!(weak(source), expected, "{source}");
    }
    assert!(weak_openings("/// The mean.\nfn mean() {}", false).is_empty());

    let terms = glossary("| <a id=\"mtf\"></a>MTF | x |\n| <a id=\"eta\"></a>eta, η | y |");
    assert_eq!(terms.len(), 2);
    let missing = |page: &str| unlinked(page, &terms).len();
    assert_eq!(missing("The MTF falls with η."), 2);
    assert_eq!(
        missing("The [MTF](fit/doc/model.md#mtf) falls; `eta` is code."),
        0
    );
    assert_eq!(missing("Two MTFs, mtf.png, an MTF-like thing, beta."), 1);
    assert_eq!(
        missing("![Drawn MTF](mtf.png) and [a page](MTF.md) [beta](#x)."),
        0
    );

    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let text = "# One Head: here\n[a](#one-head-here) [b](#none) [c](no.md) [d](page.md)\n";
    std::fs::write(&page, text).unwrap();
    assert_eq!(dead_links(&page), ["#none", "no.md"]);
    assert!(anchors(text).contains("one-head-here"));
}
