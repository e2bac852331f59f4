//! Tables that other programs wrote again: if the content is the same, so is the table. The seal is
//! gone.

use crate::sample;

use std::path::Path;
use std::process::Command;

use tables::{Table, is_sealed, read, write};

/// Copies by h5py of every object into a new file, with the oldest structures that HDF5 knows or
/// the newest.
const H5PY: &str = "import h5py, sys\n\
with h5py.File(sys.argv[1]) as new, h5py.File(sys.argv[2], 'w', libver=sys.argv[3]) as old:\n\
\x20   for name in new: new.copy(name, old)\n\
\x20   old.attrs.update(new.attrs)";

/// Bare arrays written by h5py, contiguous and without scales, as a user's own script would write
/// them.
const ARRAYS: &str = "import h5py, sys\n\
with h5py.File(sys.argv[1]) as new, h5py.File(sys.argv[2], 'w') as old:\n\
\x20   for name, data in new.items():\n\
\x20       if isinstance(data, h5py.Dataset): old[name] = data[()]\n\
\x20       else: new.copy(name, old)\n\
\x20   old.attrs.update(new.attrs)";

const XARRAY: &str = "import sys, xarray\n\
with xarray.open_dataset(sys.argv[1], engine='h5netcdf') as table:\n\
\x20   table.to_netcdf(sys.argv[2], engine='h5netcdf')";

fn rewritten(script: &str, from: &Path, to: &Path, option: &str) {
    let output = Command::new(sample::python())
        .args(["-c", script])
        .args([from, to])
        .arg(option)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn tables_from_h5py_and_xarray_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let [from, to] = ["from.h5", "to.h5"].map(|name| folder.path().join(name));
    let kinds: [(&str, Table); 4] = [
        ("deviations", sample::deviations(7)),
        ("rays", sample::rays(2, 7)),
        ("mean", sample::mean()),
        ("exact", sample::exact()),
    ];
    let mut tried = 0;
    for (kind, table) in &kinds {
        write(table, &from).unwrap();
        for (script, option) in [
            (H5PY, "earliest"),
            (H5PY, "latest"),
            (ARRAYS, ""),
            (XARRAY, ""),
        ] {
            rewritten(script, &from, &to, option);
            assert!(!is_sealed(&to).unwrap());
            match read(&to) {
                Ok(back) => {
                    assert_eq!(back, *table, "{kind} {option}");
                    assert_eq!(back.content_hash(), table.content_hash());
                }
                // xarray leaves groups out. A table without its polygons or its deviations is
                // another table.
                Err(error) => {
                    assert!(matches!(*kind, "exact" | "deviations"), "{kind}: {error}");
                    assert_eq!(script, XARRAY, "{error}");
                    let error = error.to_string();
                    let says = match *kind {
                        "exact" => "lacks polygons",
                        _ => "attribute content_hash says",
                    };
                    assert!(error.contains(says), "{error}");
                }
            }
            std::fs::remove_file(&to).unwrap();
            tried += 1;
        }
    }
    assert_eq!(tried, 16);
}

/// Copies by the tools of the HDF5 project, if they are installed. HDFView saves in the same way.
#[test]
fn a_table_from_h5repack_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let [from, to] = ["from.h5", "to.h5"].map(|name| folder.path().join(name));
    write(&sample::exact(), &from).unwrap();
    let ways: [&[&str]; 5] = [
        &["-f", "NONE"],
        &["-f", "SHUF"],
        &["-f", "GZIP=9"],
        &["-l", "CONTI"],
        &["-L"],
    ];
    let mut tried = 0;
    for way in ways {
        match Command::new("h5repack")
            .args(way)
            .args([&from, &to])
            .status()
        {
            Ok(status) => {
                assert!(status.success());
                assert_eq!(read(&to).unwrap(), sample::exact(), "{way:?}");
                std::fs::remove_file(&to).unwrap();
            }
            Err(_) => return println!("h5repack is not installed: not tried"),
        }
        tried += 1;
    }
    assert_eq!(tried, 5);
}
