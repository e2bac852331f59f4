//! Files of `fuzz/corpus`, given to the functions that the fuzz targets call.
//!
//! Each file must end in a value or an error, without a panic and within a time limit.

use std::time::{Duration, Instant};

use tests::files::project;

#[path = "../../../../fuzz/src/lib.rs"]
mod fuzz;

/// Greatest time for one file.
///
/// A file that takes a second under the fuzzer is a finding, and a test machine may be ten times
/// slower.
const MOST: Duration = Duration::from_secs(10);

type Target = (&'static str, fn(&[u8]));

#[test]
fn the_corpus_is_answered() {
    let targets: [Target; 10] = [
        ("obj", fuzz::obj),
        ("gltf", fuzz::gltf),
        ("stl", fuzz::stl),
        ("ply", fuzz::ply),
        ("table", fuzz::table),
        ("photograph", fuzz::photograph),
        ("toml", fuzz::toml),
        ("result", fuzz::result),
        ("polygons", fuzz::polygons),
        ("view", fuzz::view),
    ];
    for (name, answer) in targets {
        let folder = project().join("fuzz/corpus").join(name);
        let (mut files, mut bytes) = (0, 0);
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let content = std::fs::read(&path).unwrap();
            let start = Instant::now();
            answer(&content);
            assert!(start.elapsed() < MOST, "{}", path.display());
            (files, bytes) = (files + 1, bytes + content.len());
        }
        println!("{name}: {files} files, {bytes} bytes");
        assert!(files >= 4, "{}", folder.display());
        assert!(
            bytes < 100_000,
            "minimise the corpus of {name}: {bytes} bytes"
        );
    }
}
