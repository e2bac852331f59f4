//! Rules for the project's words: widths of lines, openings of doc comments, links and glossary.
//!
//! Each rule is a function from a text to its findings, so that a test can plant a violation.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Greatest number of columns of a line.
pub const WIDEST: usize = 100;

/// Words with which no doc comment may begin. They point to another item, or are neither verb nor
/// noun.
const POINTING: [&str; 28] = [
    "The same", "Same", "As", "Like", "Likewise", "Ditto", "See", "It", "Its", "Their", "Those",
    "That", "Whose", "Which", "Also", "And", "So", "Else", "Too", "Such", "This", "These", "What",
    "Whether", "How", "Where", "Why", "Who",
];

/// Plural nouns that end like a verb of the third person.
const NOUNS: [&str; 14] = [
    "Rays",
    "Bins",
    "Samples",
    "Directions",
    "Axes",
    "Facets",
    "Pixels",
    "Columns",
    "Terms",
    "Weights",
    "Bytes",
    "Corners",
    "Cells",
    "Edges",
];

/// Returns the lines of a text that are wider than [`WIDEST`], with their numbers from 1.
///
/// Tables and pictures of Markdown, and lines that hold an address, cannot be broken and are left
/// out.
pub fn wide_lines(text: &str) -> Vec<String> {
    let cannot_be_broken = |line: &str| {
        let line = line.trim_start();
        line.starts_with('|') || line.starts_with("![") || line.contains("://")
    };
    text.lines()
        .enumerate()
        .filter(|(_, line)| line.chars().count() > WIDEST && !cannot_be_broken(line))
        .map(|(number, line)| format!("line {}: {} columns", number + 1, line.chars().count()))
        .collect()
}

/// Returns what is wrong with the doc comments of a Rust source, with line numbers from 1.
///
/// `# Errors` begins with "Returns" or "Fails". No comment begins with a word that points to
/// another one. If `verbs` is true, the comment of a function begins with a verb in the third
/// person, unless the function is a test: the comment of a test says why it holds.
pub fn weak_openings(source: &str, verbs: bool) -> Vec<String> {
    let lines: Vec<&str> = source.lines().map(str::trim).collect();
    let comment = |line: &str| {
        line.strip_prefix("///")
            .map(|words| words.trim().to_owned())
    };
    let mut found = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        let body: Vec<String> = lines[at..].iter().map_while(|line| comment(line)).collect();
        let Some(first) = body.first() else {
            at += 1;
            continue;
        };
        let number = at + 1;
        at += body.len();
        let before_item = |line: &&&str| line.starts_with("#[") || line.starts_with("//");
        let attributes = lines[at..].iter().take_while(before_item);
        let is_test = attributes.clone().any(|line| *line == "#[test]");
        let item = lines.get(at + attributes.count());
        if points_elsewhere(first) {
            found.push(format!(
                "line {number}: begins with a pointing word: {first}"
            ));
        } else if verbs && !is_test && item.is_some_and(|item| is_function(item)) && !is_verb(first)
        {
            found.push(format!("line {number}: begins with no verb: {first}"));
        }
        for (k, line) in body.iter().enumerate() {
            let after = body[k + 1..].iter().find(|line| !line.is_empty());
            let plain = |line: &&String| line.starts_with("Returns ") || line.starts_with("Fails ");
            if line == "# Errors" && !after.is_some_and(|line| plain(&line)) {
                found.push(format!("line {}: # Errors is no sentence", number + k));
            }
        }
    }
    found
}

fn points_elsewhere(comment: &str) -> bool {
    POINTING.iter().any(|opening| {
        comment
            .strip_prefix(opening)
            .is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
    })
}

fn is_verb(comment: &str) -> bool {
    let word = comment.split(' ').next().unwrap_or_default();
    let word = word.trim_end_matches(['.', ',', ':']);
    word.ends_with('s')
        && word.starts_with(char::is_uppercase)
        && word.chars().all(char::is_alphabetic)
        && !NOUNS.contains(&word)
}

fn is_function(item: &str) -> bool {
    let visible = item.strip_prefix("pub").map_or(item, |rest| {
        let rest = rest.trim_start();
        rest.strip_prefix('(')
            .and_then(|inside| inside.split_once(')'))
            .map_or(rest, |(_, rest)| rest.trim_start())
    });
    let words = visible.split_whitespace();
    words
        .take_while(|word| ["const", "unsafe", "extern", "async", "fn"].contains(word))
        .any(|word| word == "fn")
}

/// Returns a page without its blocks of code and without code within lines.
pub fn prose(page: &str) -> String {
    let mut inside = false;
    let mut out = String::new();
    for line in page.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if !inside {
            out.extend(line.split('`').step_by(2).flat_map(|part| [part, " "]));
            out.push('\n');
        }
    }
    out
}

/// Returns the targets of the links and pictures of a page, in order.
pub fn links(page: &str) -> Vec<String> {
    let text = prose(page);
    text.split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')'))
        .map(|(target, _)| target.to_owned())
        .collect()
}

/// Returns the anchors of a page: the names that may follow `#` in a link to it.
pub fn anchors(page: &str) -> BTreeSet<String> {
    let of_headings = page
        .lines()
        .filter(|line| line.starts_with('#'))
        .map(|line| slug(line.trim_start_matches('#').trim()));
    let of_tags = page
        .split("<a id=\"")
        .skip(1)
        .filter_map(|rest| rest.split_once('"'))
        .map(|(name, _)| name.to_owned());
    of_headings.chain(of_tags).collect()
}

/// Returns the name that GitHub gives to a heading.
fn slug(heading: &str) -> String {
    heading
        .chars()
        .filter_map(|c| match c {
            ' ' => Some('-'),
            '-' | '_' => Some(c),
            _ => c.is_alphanumeric().then(|| c.to_ascii_lowercase()),
        })
        .collect()
}

/// Returns the links of a page that lead to no file or to no heading.
///
/// `file` is the page itself; links are relative to its folder.
pub fn dead_links(file: &Path) -> Vec<String> {
    let page = read(file);
    let leads = |target: &str| {
        if target.contains("://") || target.starts_with("mailto:") {
            return true; // the test does not use the network
        }
        let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
        let to = if path.is_empty() {
            file.to_owned()
        } else {
            file.parent().expect("a file has a folder").join(path)
        };
        to.exists() && (anchor.is_empty() || anchors(&read(&to)).contains(anchor))
    };
    links(&page)
        .into_iter()
        .filter(|target| !leads(target))
        .collect()
}

/// A term of the glossary.
#[derive(Clone, Debug)]
pub struct Term {
    /// Anchor of the term: the part of a link after `#`.
    pub anchor: String,
    /// Spellings that a page may use.
    pub spellings: Vec<String>,
}

/// Returns the terms of a glossary: the rows of a table whose first cell holds an anchor.
pub fn glossary(page: &str) -> Vec<Term> {
    let row = |line: &str| {
        let (anchor, rest) = line.strip_prefix("| <a id=\"")?.split_once("\"></a>")?;
        let (names, _) = rest.split_once(" |")?;
        Some(Term {
            anchor: anchor.to_owned(),
            spellings: names.split(", ").map(str::to_owned).collect(),
        })
    };
    page.lines().filter_map(row).collect()
}

/// Returns the terms that a page uses without linking them once.
pub fn unlinked<'a>(page: &str, terms: &'a [Term]) -> Vec<&'a Term> {
    let targets = links(page);
    let words = without_targets(&prose(page));
    terms
        .iter()
        .filter(|term| term.spellings.iter().any(|spelling| uses(&words, spelling)))
        .filter(|term| {
            let end = format!("model.md#{}", term.anchor);
            !targets.iter().any(|target| target.ends_with(&end))
        })
        .collect()
}

/// Returns prose without the targets of its links and without its pictures.
fn without_targets(prose: &str) -> String {
    let mut parts = prose.split("](");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        if let Some(picture) = out.rfind("![").filter(|at| !out[*at..].contains(']')) {
            out.truncate(picture);
        }
        out.push_str(part.split_once(')').map_or(part, |(_, rest)| rest));
    }
    out
}

/// Returns whether a text uses a word, in the singular or plural, as a whole word.
fn uses(text: &str, word: &str) -> bool {
    let borders = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric() && !"_-.".contains(c));
    let ends = |rest: &str| {
        let mut rest = rest.strip_prefix('s').unwrap_or(rest).chars();
        match rest.next() {
            None => true,
            // "baseline." ends a sentence, and "baselines.md" is a file.
            Some('.') => rest.next().is_none_or(|c| !c.is_alphanumeric()),
            Some(c) => !c.is_alphanumeric() && !"_-".contains(c),
        }
    };
    text.match_indices(word)
        .any(|(at, _)| borders(text[..at].chars().next_back()) && ends(&text[at + word.len()..]))
}

/// Returns the text of a file of the project.
///
/// # Panics
///
/// Panics if the file cannot be read as UTF-8.
pub fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// Returns all files of the project whose names end in one of `endings`, sorted.
///
/// Hidden folders and folders with built, downloaded or test files are left out.
pub fn files(root: &Path, endings: &[&str]) -> Vec<PathBuf> {
    const LEFT_OUT: [&str; 8] = [
        "target",
        "demo",
        "dist",
        "corpus",
        "found",
        "bad",
        "planted",
        "node_modules",
    ];
    let mut found = Vec::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder)
            .unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for entry in entries.map(|entry| entry.expect("the folder can be read")) {
            let name = entry.file_name().to_string_lossy().into_owned();
            let kind = entry.file_type().expect("the file has a type");
            if kind.is_dir() && !name.starts_with('.') && !LEFT_OUT.contains(&name.as_str()) {
                folders.push(entry.path());
            } else if kind.is_file() && endings.iter().any(|ending| name.ends_with(ending)) {
                found.push(entry.path());
            }
        }
    }
    found.sort();
    found
}
