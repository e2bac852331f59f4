//! Dependencies between the packages, `meshes <- bake -> tables <- fit` and
//! `reader -> tables`, and code that may stand
//! in certain files only: HDF5, the bounding volume hierarchy and `unsafe`.

use std::collections::BTreeSet;
use std::path::Path;

use tests::files::project;
use tests::program::sources;

const PACKAGES: [&str; 10] = [
    "meshes",
    "tables",
    "tables/documents",
    "reader",
    "bake",
    "fit",
    "fit/edges",
    "fit/estimator",
    "fit/lab",
    "fit/pictures",
];

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Returns the names under every heading of dependencies, with those of tests, build scripts and
/// single platforms.
fn dependencies(manifest: &toml::Table) -> Vec<String> {
    let mut found = Vec::new();
    for (heading, value) in manifest {
        let Some(table) = value.as_table() else {
            continue;
        };
        if heading.ends_with("dependencies") {
            found.extend(table.keys().cloned());
        } else if heading == "target" {
            found.extend(
                table
                    .values()
                    .filter_map(toml::Value::as_table)
                    .flat_map(dependencies),
            );
        }
    }
    found
}

fn of(package: &str) -> Vec<String> {
    let manifest = project().join(package).join("Cargo.toml");
    dependencies(&read(&manifest).parse().unwrap())
}

/// Returns the paths, from the root, of the sources with a line of code for which `is` is true.
fn files_with(is: impl Fn(&str) -> bool) -> Vec<String> {
    let root = project();
    PACKAGES
        .iter()
        .flat_map(|package| sources(&root.join(package).join("src")))
        .filter(|file| {
            read(file)
                .lines()
                .any(|line| !line.trim_start().starts_with("//") && is(line))
        })
        .map(|file| file.strip_prefix(&root).unwrap().display().to_string())
        .collect()
}

#[test]
fn dependencies_go_one_way() {
    let allowed: [(&str, &[&str]); 11] = [
        ("meshes", &[]),
        ("tables", &[]),
        ("tables/documents", &[]),
        ("reader", &["tables"]),
        ("bake", &["meshes", "tables", "documents"]),
        ("fit/edges", &["documents"]),
        ("fit/estimator", &["tables", "edges"]),
        ("fit/lab", &["tables", "edges", "estimator"]),
        ("fit/pictures", &["tables", "edges", "estimator", "lab"]),
        ("fit", &["tables", "edges", "estimator", "lab", "pictures"]),
        ("python", &["meshes", "tables", "bake", "fit"]),
    ];
    let crates = allowed.map(|(folder, _)| folder.rsplit('/').next().unwrap_or(folder));
    for (package, may) in allowed {
        let names = of(package);
        let own = |name: &&String| crates.contains(&name.as_str());
        let found: BTreeSet<&str> = names.iter().filter(own).map(String::as_str).collect();
        assert!(names.len() > 3, "{package}: {names:?}");
        assert_eq!(found, may.iter().copied().collect(), "{package}");
    }
}

#[test]
fn only_tables_knows_hdf5() {
    for package in PACKAGES {
        let named = of(package).iter().any(|name| name.contains("hdf5"));
        assert_eq!(named, package == "tables", "{package}");
    }
    let files = files_with(|line| line.contains("hdf5::") || line.contains("hdf5_sys"));
    assert!(
        !files.is_empty() && files.iter().all(|file| file.starts_with("tables/")),
        "{files:?}"
    );
}

#[test]
fn one_file_names_the_bvh() {
    for package in PACKAGES {
        assert_eq!(
            of(package).iter().any(|name| name == "obvhs"),
            package == "bake",
            "{package}"
        );
    }
    assert_eq!(
        files_with(|line| line.contains("obvhs")),
        ["bake/src/rays/hierarchy/tree.rs"]
    );
}

#[test]
fn unsafe_code_stays_behind_its_fences() {
    let fences = [
        "bake/src/rays/simd.rs",
        "reader/src/calls.rs",
        "reader/src/tries.rs",
        "tables/src/library/memory.rs",
        "tables/src/library/scales.rs",
    ];
    let keyword = |line: &str| {
        line.split(|c: char| !c.is_alphanumeric() && c != '_')
            .any(|word| word == "unsafe")
    };
    for file in files_with(keyword) {
        assert!(fences.contains(&file.as_str()), "{file} holds unsafe code");
    }
    for package in PACKAGES {
        let library = read(&project().join(package).join("src/lib.rs"));
        let fenced = fences.iter().any(|fence| fence.starts_with(package));
        let level = if fenced {
            "#![deny(unsafe_code)]"
        } else {
            "#![forbid(unsafe_code)]"
        };
        assert!(
            library.contains(level) || library.contains("#![forbid(unsafe_code)]"),
            "{package} lacks {level}"
        );
    }
}

/// The simulator tests the model, so it must take no formula of light from it. These modules hold
/// keys of files, names and numerical methods.
#[test]
fn the_simulator_shares_only_names_with_the_model() {
    const GROUND: [&str; 4] = ["document", "names", "numerics", "readers"];
    let lab = project().join("fit/lab/src");
    let mut files = sources(&lab.join("simulate"));
    files.push(lab.join("tracer.rs"));
    let mut imports = 0;
    for file in &files {
        let text = read(file);
        assert!(!text.contains("estimator::"), "{}", file.display());
        for rest in text.split("edges::").skip(1) {
            let module = rest.split([':', ';', ' ', '{']).next().unwrap_or_default();
            assert!(GROUND.contains(&module), "{}: {module}", file.display());
            imports += 1;
        }
    }
    assert!(imports > 10, "{imports} imports of {} files", files.len());
}
