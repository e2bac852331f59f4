//! Imports between the source files of a crate, so that a test can check the order of the rooms.
//!
//! A room is a folder of `src` with a `mod.rs`. Sources are read as tokens, not as text. An import
//! counts wherever it stands: in a `use`, in a path inside an expression, or in a macro call. It
//! may begin with `crate` or `super`, and it may pass through a re-export of a room's `mod.rs`.
//! Comments, and modules under `#[cfg(test)]`, do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::str::FromStr;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use crate::program::sources;

/// A module: the parts of its path from the root of the crate.
type Module = Vec<String>;

/// The sources of one crate: text by file name, relative to `src`.
pub type Sources = BTreeMap<String, String>;

/// One import between two files of a crate. Both file names are relative to `src`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Import {
    /// The file that imports.
    pub from: String,
    /// The file that holds the imported item.
    pub to: String,
}

/// Reads the sources of a crate, without its unit tests (`tests` folders and `tests.rs`).
///
/// # Panics
/// Panics if a file cannot be read.
pub fn read(src: &Path) -> Sources {
    sources(src)
        .into_iter()
        .map(|file| {
            let text = std::fs::read_to_string(&file)
                .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            let name = file.strip_prefix(src).expect("a file of this folder");
            (name.display().to_string(), text)
        })
        .filter(|(name, _)| !name.starts_with("tests/") && !name.contains("/tests/"))
        .filter(|(name, _)| !name.ends_with("/tests.rs"))
        .collect()
}

/// Returns the room of a file, which is the first folder of its path, or `None` at the root.
pub fn room(file: &str) -> Option<&str> {
    file.split_once('/').map(|(room, _)| room)
}

/// Returns all imports between the files of one crate, sorted.
///
/// A name in the crate's root that is no module, such as a public re-export, counts as an import
/// of `lib.rs`: such an import depends on the whole crate.
///
/// # Panics
/// Panics if a file is not Rust.
pub fn imports(sources: &Sources) -> Vec<Import> {
    let house = House::new(sources);
    let mut found = BTreeSet::new();
    for (file, tokens) in &house.tokens {
        let here = module_of(file);
        for path in paths(tokens.clone(), &here, &house.files) {
            let to = house.file_of(&path, 0);
            if to != *file {
                let from = file.clone();
                found.insert(Import { from, to });
            }
        }
    }
    found.into_iter().collect()
}

/// Returns one sentence, with both files, for each import that runs up.
///
/// An import runs up if it leads to a room that stands later in `order` than the importing file's
/// own room, or to the root of the crate.
pub fn upward(sources: &Sources, order: &[&str]) -> Vec<String> {
    let imports = imports(sources);
    let floor = |file: &str| match room(file) {
        Some(room) => order.iter().position(|name| *name == room),
        None => Some(order.len()),
    };
    let runs_up = |import: &&Import| floor(&import.to) > floor(&import.from);
    let sentence = |import: &Import| {
        let Import { from, to } = import;
        let back = imports
            .iter()
            .find(|other| room(&other.from) == room(to) && room(&other.to) == room(from));
        let circle = back.map_or(String::new(), |back| {
            format!(
                "; that is a circle between rooms, because {} imports {}",
                back.from, back.to
            )
        });
        format!("{from} imports {to}, which stands above it{circle}")
    };
    imports.iter().filter(runs_up).map(sentence).collect()
}

/// Returns the groups of files of one room that import each other in a circle, each group sorted.
pub fn circles(sources: &Sources) -> Vec<Vec<String>> {
    let imports = imports(sources);
    let inside = |import: &&Import| room(&import.from) == room(&import.to);
    let mut reach: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for Import { from, to } in imports.iter().filter(inside) {
        reach.entry(from).or_default().insert(to);
    }
    loop {
        let mut grown = false;
        let files: Vec<&str> = reach.keys().copied().collect();
        for file in files {
            let next: BTreeSet<&str> = reach[file]
                .iter()
                .flat_map(|to| reach.get(to).into_iter().flatten().copied())
                .collect();
            let own = reach.get_mut(file).expect("a key of the map");
            let before = own.len();
            own.extend(next);
            grown |= own.len() > before;
        }
        if !grown {
            break;
        }
    }
    let mutual =
        |a: &str, b: &str| reach[a].contains(b) && reach.get(b).is_some_and(|to| to.contains(a));
    let mut found = BTreeSet::new();
    for &file in reach.keys().filter(|file| mutual(file, file)) {
        let others = reach[file].iter().filter(|other| mutual(file, other));
        let mut circle: Vec<String> = others.map(|other| (*other).to_owned()).collect();
        circle.sort();
        found.insert(circle);
    }
    found.into_iter().collect()
}

/// Returns the module that a file holds.
fn module_of(file: &str) -> Module {
    let mut parts: Module = file
        .trim_end_matches(".rs")
        .split('/')
        .map(str::to_owned)
        .collect();
    if matches!(
        parts.last().map(String::as_str),
        Some("mod" | "lib" | "main")
    ) {
        parts.pop();
    }
    parts
}

/// The files of a crate by module, with their tokens and re-exports.
struct House {
    tokens: BTreeMap<String, TokenStream>,
    files: BTreeMap<Module, String>,
    /// Re-exports by module: each name, and the path for which it stands.
    reexports: BTreeMap<Module, Vec<(String, Module)>>,
}

impl House {
    fn new(sources: &Sources) -> House {
        let tokens: BTreeMap<String, TokenStream> = sources
            .iter()
            .filter(|(file, _)| *file != "main.rs")
            .map(|(file, text)| {
                let tokens = TokenStream::from_str(text)
                    .unwrap_or_else(|error| panic!("{file} is no Rust: {error}"));
                (file.clone(), tokens)
            })
            .collect();
        let files: BTreeMap<Module, String> = tokens
            .keys()
            .map(|file| (module_of(file), file.clone()))
            .collect();
        let reexports = tokens
            .iter()
            .filter(|(file, _)| file.ends_with("/mod.rs"))
            .map(|(file, tokens)| {
                let here = module_of(file);
                let mut names = Vec::new();
                uses(tokens.clone(), &here, &files, &mut |path, name| {
                    names.push((name.to_owned(), path));
                });
                (here, names)
            })
            .collect();
        House {
            tokens,
            files,
            reexports,
        }
    }

    /// Returns the file that holds the item of a path. The re-exports of `mod.rs` files are
    /// followed.
    fn file_of(&self, path: &[String], depth: usize) -> String {
        let mut length = path.len();
        while !self.files.contains_key(&path[..length]) {
            length -= 1;
        }
        let (module, rest) = path.split_at(length);
        let through = rest.first().and_then(|name| {
            let names = self.reexports.get(module)?;
            let (_, target) = names.iter().find(|(own, _)| own == name || own == "*")?;
            Some(target)
        });
        match through {
            // Twelve re-exports of one name can only be a circle, which rustc refuses. The limit
            // ends the search.
            Some(target) if depth < 12 => self.file_of(target, depth + 1),
            _ => self.files[module].clone(),
        }
    }
}

/// Returns all paths in the tokens that lead into the crate, each from the crate's root.
fn paths(tokens: TokenStream, here: &[String], files: &BTreeMap<Module, String>) -> Vec<Module> {
    let mut found = Vec::new();
    uses(tokens.clone(), here, files, &mut |path, _| found.push(path));
    inline(tokens, here, here, files, &mut found);
    found
}

/// Returns whether these attributes mark a module of tests, such as `#[cfg(test)]`.
fn is_of_tests(attributes: &[String]) -> bool {
    attributes
        .iter()
        .any(|text| text.starts_with("cfg") && text.contains("test"))
}

/// Calls `visit` with the tokens and the path of every module that is written in this stream.
///
/// Inner modules come first. Modules of tests are left out.
fn bodies(tokens: TokenStream, here: &[String], visit: &mut dyn FnMut(&[TokenTree], &[String])) {
    let mut flat = Vec::new();
    let mut attributes: Vec<String> = Vec::new();
    let mut trees = tokens.into_iter().peekable();
    while let Some(tree) = trees.next() {
        match &tree {
            TokenTree::Punct(mark) if mark.as_char() == '#' => {
                if let Some(TokenTree::Group(group)) = trees.peek()
                    && group.delimiter() == Delimiter::Bracket
                {
                    attributes.push(group.stream().to_string());
                }
            }
            TokenTree::Ident(word) if *word == "mod" => {
                if let Some(TokenTree::Ident(name)) = trees.next() {
                    let of_tests = is_of_tests(&attributes);
                    attributes.clear();
                    if let Some(TokenTree::Group(body)) = trees.peek() {
                        let mut inner = here.to_vec();
                        inner.push(name.to_string());
                        if !of_tests {
                            bodies(body.stream(), &inner, visit);
                        }
                        trees.next();
                    }
                }
                continue;
            }
            TokenTree::Punct(mark) if mark.as_char() == ';' => attributes.clear(),
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => attributes.clear(),
            _ => {}
        }
        flat.push(tree);
    }
    visit(&flat, here);
}

/// Calls `item` with the path and the local name of every leaf of every `use`.
fn uses(
    tokens: TokenStream,
    here: &[String],
    files: &BTreeMap<Module, String>,
    item: &mut dyn FnMut(Module, &str),
) {
    bodies(tokens, here, &mut |trees, at| {
        uses_in(trees, at, files, item);
    });
}

fn uses_in(
    trees: &[TokenTree],
    at: &[String],
    files: &BTreeMap<Module, String>,
    item: &mut dyn FnMut(Module, &str),
) {
    let mut i = 0;
    while i < trees.len() {
        match &trees[i] {
            TokenTree::Ident(word) if *word == "use" => {
                let end = trees[i..]
                    .iter()
                    .position(|t| matches!(t, TokenTree::Punct(p) if p.as_char() == ';'))
                    .map_or(trees.len(), |length| i + length);
                leaves(&trees[i + 1..end], &[], &mut |path, name| {
                    if let Some(path) = absolute(path, at, at, files) {
                        item(path, name);
                    }
                });
                i = end;
            }
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                uses_in(&inner, at, files, item);
            }
            _ => {}
        }
        i += 1;
    }
}

/// Calls `leaf` with the path and the local name of every leaf of one `use` tree.
fn leaves(trees: &[TokenTree], before: &[String], leaf: &mut dyn FnMut(&[String], &str)) {
    let mut path = before.to_vec();
    let mut name = None;
    let mut closed = false;
    let mut i = 0;
    while i < trees.len() {
        match &trees[i] {
            TokenTree::Ident(word) if *word == "as" => {
                name = trees.get(i + 1).map(ToString::to_string);
                i += 1;
            }
            TokenTree::Ident(word) => path.push(word.to_string()),
            TokenTree::Punct(mark) if mark.as_char() == '*' => name = Some("*".to_owned()),
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                let comma = |t: &TokenTree| matches!(t, TokenTree::Punct(p) if p.as_char() == ',');
                for part in inner.split(comma).filter(|part| !part.is_empty()) {
                    leaves(part, &path, leaf);
                }
                closed = true;
            }
            _ => {}
        }
        i += 1;
    }
    if closed {
        return;
    }
    if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    let own = name.unwrap_or_else(|| path.last().cloned().unwrap_or_default());
    leaf(&path, &own);
}

/// Collects the paths in expressions, types and macro calls that lead into the crate, with two
/// parts or more.
fn inline(
    tokens: TokenStream,
    here: &[String],
    file: &[String],
    files: &BTreeMap<Module, String>,
    found: &mut Vec<Module>,
) {
    bodies(tokens, here, &mut |trees, at| {
        inline_in(trees, at, file, files, found);
    });
}

fn inline_in(
    trees: &[TokenTree],
    at: &[String],
    file: &[String],
    files: &BTreeMap<Module, String>,
    found: &mut Vec<Module>,
) {
    let colons = |i: usize| {
        [i, i + 1]
            .iter()
            .all(|&k| matches!(trees.get(k), Some(TokenTree::Punct(p)) if p.as_char() == ':'))
    };
    let mut i = 0;
    while i < trees.len() {
        match &trees[i] {
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                inline_in(&inner, at, file, files, found);
            }
            // `uses` reads the leaves of a `use`.
            TokenTree::Ident(word) if *word == "use" => {
                let semicolon =
                    |t: &TokenTree| matches!(t, TokenTree::Punct(p) if p.as_char() == ';');
                i += trees[i..].iter().position(semicolon).unwrap_or(0);
            }
            TokenTree::Ident(word) if i < 2 || !colons(i - 2) => {
                let mut path = vec![word.to_string()];
                while colons(i + 1) {
                    let Some(TokenTree::Ident(next)) = trees.get(i + 3) else {
                        break;
                    };
                    path.push(next.to_string());
                    i += 3;
                }
                if path.len() > 1
                    && let Some(path) = absolute(&path, at, file, files)
                {
                    found.push(path);
                }
            }
            _ => {}
        }
        i += 1;
    }
}

/// Returns a path from the root of the crate.
///
/// Returns `None` if the path leads to another crate or to an item of the file's own module.
fn absolute(
    path: &[String],
    here: &[String],
    file: &[String],
    files: &BTreeMap<Module, String>,
) -> Option<Module> {
    let (first, rest) = path.split_first()?;
    match first.as_str() {
        "crate" => Some(rest.to_vec()),
        "self" | "super" => {
            let mut base = here.to_vec();
            let mut rest = path;
            while let Some((word, after)) = rest.split_first() {
                match word.as_str() {
                    "self" => {}
                    "super" => {
                        base.pop();
                    }
                    _ => break,
                }
                rest = after;
            }
            base.extend(rest.iter().cloned());
            Some(base)
        }
        child => {
            let mut module = file.to_vec();
            module.push(child.to_owned());
            (files.contains_key(&module)).then(|| {
                let mut whole = file.to_vec();
                whole.extend(path.iter().cloned());
                whole
            })
        }
    }
}
