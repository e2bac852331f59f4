//! Links of the pages: each leads to a file, and to a heading where it names one.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use tests::files::project;

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// Returns the pages below a folder. Hidden folders and those of built files are left out.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let left_out = name.starts_with('.') || ["target", "demo", "dist"].contains(&&*name);
        if path.is_dir() && !left_out {
            found.extend(pages(&path));
        } else if name.ends_with(".md") {
            found.push(path);
        }
    }
    found
}

/// Returns the targets of the links and pictures of a page, without those in blocks of code.
fn links(page: &str) -> Vec<String> {
    let prose: Vec<&str> = page.split("```").step_by(2).collect();
    let parts = prose.iter().flat_map(|part| part.split("](").skip(1));
    let targets = parts.filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.to_owned()).collect()
}

/// Returns the names that may follow `#` in a link to a page: its headings, as GitHub names them,
/// and its anchors.
fn anchors(page: &str) -> BTreeSet<String> {
    let slug = |heading: &str| -> String {
        let words = heading.trim_start_matches('#').trim().chars();
        words
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
            .map(|c| {
                if c == ' ' {
                    '-'
                } else {
                    c.to_ascii_lowercase()
                }
            })
            .collect()
    };
    let headings = page.lines().filter(|line| line.starts_with('#')).map(slug);
    let tags = page.split("<a id=\"").skip(1);
    let named = tags.filter_map(|rest| Some(rest.split_once('"')?.0.to_owned()));
    headings.chain(named).collect()
}

/// Returns whether a link of the page `file` leads somewhere. Addresses of the network are not
/// followed.
fn leads(file: &Path, target: &str) -> bool {
    if target.contains("://") || target.starts_with("mailto:") {
        return true;
    }
    let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
    let to = match path {
        "" => file.to_owned(),
        _ => file.parent().expect("a file has a folder").join(path),
    };
    to.exists() && (anchor.is_empty() || anchors(&read(&to)).contains(anchor))
}

#[test]
fn links_lead_somewhere() {
    let mut counted = 0;
    for page in pages(&project()) {
        for target in links(&read(&page)) {
            assert!(leads(&page, &target), "{}: {target}", page.display());
            counted += 1;
        }
    }
    println!("{counted} links");
    assert!(counted > 150, "{counted}");
    let page = project().join("README.md");
    for dead in ["doc/none.md", "#none", "fit/doc/model.md#none"] {
        assert!(!leads(&page, dead), "{dead}");
    }
}
