//! Reading by the reader: equal tables and equal refusals, and a crash of the HDF5 library becomes
//! an error.

#[path = "../../tables/tests/all/sample/mod.rs"]
mod sample;

use std::path::Path;

use sample::Numbers;
use tables::reader::Protection;
use tables::{Error, read, write};

#[test]
fn the_reader_reads_what_the_library_reads() {
    tables::apart::start_with(env!("CARGO_BIN_EXE_airr-reader").into());
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
        let bytes = std::fs::read(&file).unwrap();
        let from_memory = tables::read_in_memory(&bytes, Path::new(kind));
        assert_eq!(from_memory.unwrap(), *table, "{kind}, from memory");
    }
    // A name that leads nowhere is refused before the reader starts, other bytes by the reader.
    let none = read(&folder.path().join("none.h5")).unwrap_err();
    assert!(matches!(none, Error::File { .. }), "{none:?}");
    let text = folder.path().join("text.h5");
    std::fs::write(&text, "incidence,azimuth\n").unwrap();
    let told = read(&text).unwrap_err();
    assert!(matches!(told, Error::Told(_)), "{told:?}");
    let told = told.to_string();
    assert!(
        told.contains("text.h5: is not an HDF5 file (18 bytes"),
        "{told}"
    );
    // Nothing is lacking here, or `verify` says what.
    let lacking = tables::apart::read(&file).unwrap().lacking;
    println!("lacking: {lacking:?}");
    if cfg!(target_os = "linux") {
        assert!(!lacking.contains(&Protection::Limits));
    }
    odd_names(folder.path(), &file);
    changes(&file);
    println!(
        "apart: {} kinds of tables, two refusals, 200 changed files",
        kinds.len()
    );
}

/// A name that is no UTF-8, a lock of another program and a link do not make a table damaged.
fn odd_names(folder: &Path, file: &Path) {
    use std::os::unix::ffi::OsStrExt;
    let odd = folder.join(std::ffi::OsStr::from_bytes(b"tab\xffle\x1b.h5"));
    std::fs::copy(file, &odd).unwrap();
    read(&odd).unwrap();
    let link = folder.join("link.h5");
    std::os::unix::fs::symlink(&odd, &link).unwrap();
    read(&link).unwrap();
    // The HDF5 library locks a file in this way while it writes to it.
    let locked = std::fs::File::open(&odd).unwrap();
    locked.lock().unwrap();
    read(&odd).unwrap();
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
            Err(error @ Error::File { .. })
                if error.to_string().contains("the process that reads") =>
            {
                crashed += 1;
            }
            Err(error) => panic!("{error}"),
        }
    }
    println!("{read_again} read, {refused} refused, {crashed} ended the reading process");
    assert!(refused > 20, "the changes did not reach the structures");
}
