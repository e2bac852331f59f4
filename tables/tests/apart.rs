//! Reading in a process of its own: equal tables and equal refusals, and a crash of the HDF5
//! library becomes an error.
//!
//! It runs without the test harness, because `serve` must come first in `main`: the reading process
//! is this program again.

#[path = "all/sample/mod.rs"]
mod sample;

use std::path::Path;

use sample::Numbers;
use tables::{Error, read, write};

fn main() {
    tables::apart::serve();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("table.h5");
    let kinds = [
        ("rays", sample::rays(2, 7)),
        ("mean", sample::mean()),
        ("deviations", sample::deviations(7)),
        ("exact", sample::exact()),
    ];
    for (kind, table) in &kinds {
        write(table, &file).unwrap();
        assert_eq!(read(&file).unwrap(), *table, "{kind}");
    }
    let told = read(&folder.path().join("none.h5")).unwrap_err();
    assert!(matches!(told, Error::Told(_)), "{told:?}");
    let told = told.to_string();
    assert!(
        told.contains("none.h5: cannot be read (No such file"),
        "{told}"
    );
    changes(&file);
    println!(
        "apart: {} kinds of tables, one refusal, 200 changed files",
        kinds.len()
    );
}

/// Bytes changed all over a file without seal: each read ends in a table or an error, and never
/// ends this program.
fn changes(file: &Path) {
    let sealed = std::fs::read(file).unwrap();
    let whole = &sealed[..sealed.len() - 40];
    let mut numbers = Numbers(5);
    let (mut read_again, mut refused, mut crashed) = (0, 0, 0);
    for _ in 0..200 {
        let mut changed = whole.to_vec();
        for _ in 0..1 + numbers.below(4) {
            let at = numbers.below(changed.len() as u64) as usize;
            changed[at] = [0, 1, 0x7f, 0x80, 0xff][numbers.below(5) as usize];
        }
        std::fs::write(file, changed).unwrap();
        match read(file) {
            Ok(_) => read_again += 1,
            Err(Error::Told(_)) => refused += 1,
            Err(Error::Apart { .. }) => crashed += 1,
            Err(error) => panic!("{error}"),
        }
    }
    println!("{read_again} read, {refused} refused, {crashed} ended the reading process");
    assert!(refused > 20, "the changes did not reach the structures");
}
