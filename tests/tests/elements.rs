//! Elements that are no corner cubes, from outside.

use tests::files::argument;
use tests::program::bake;

/// The worked examples of the manual, as printed; what they draw is there afterwards.
#[test]
fn the_manual_runs_as_printed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let manual = std::fs::read_to_string(argument("bake/doc/elements.md")).unwrap();
    let mut ran = 0;
    for line in manual.lines().filter(|line| line.starts_with("    bake ")) {
        let words: Vec<&str> = line.split_whitespace().skip(1).collect();
        let run = bake(here, &words);
        assert_eq!(run.code, Some(0), "{line}\n{}", run.err);
        ran += 1;
    }
    assert_eq!(ran, 6);
    for picture in ["plate.png", "bead.png"] {
        assert!(here.join(picture).is_file(), "{picture}");
    }
    let table = tables::read(&here.join("bead.h5")).unwrap();
    assert!(table.provenance.has_glass() && table.deviations.is_some());
}
