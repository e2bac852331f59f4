//! A new table, read in Python as a user reads it: with h5py, and with xarray through h5netcdf.

use std::process::Command;

use tests::files::{argument, bake_table_with};
use tests::program::python;

#[test]
fn a_baked_table_opens_in_h5py_and_xarray() {
    let folder = tempfile::tempdir().unwrap();
    for method in ["--method rays --rays 1048576", "--method exact"] {
        let table = bake_table_with(folder.path(), "triangular", "0,10,35", "0,30", method);
        let output = Command::new(python())
            .arg(argument("tests/tests/read_table.py"))
            .arg(folder.path().join(table))
            .arg(method.split(' ').nth(1).unwrap())
            .output()
            .unwrap();
        let (out, err) = (
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr),
        );
        assert!(output.status.success(), "{method:?}: {out}{err}");
        assert_eq!(out.trim(), "read 6 directions twice", "{err}");
    }
}

/// `paths_between` of `read_table.py` against the exact method at an incidence between two of the
/// table. It is exact for lines that keep their slopes, and for polygons that keep their corners.
/// Elsewhere the limits are twice the errors that FORMAT.md states.
#[test]
fn polygons_between_incidences_are_those_of_the_exact_method() {
    let folder = tempfile::tempdir().unwrap();
    let exact = "--method exact";
    for (design, around, between, azimuth, tolerance) in [
        ("triangular", "0,10", "6", "10", "1e-12"),
        ("triangular", "20,30", "26", "10", "1e-12"),
        ("triangular-pair", "10,20", "16", "0", "1e-12"),
        ("triangular-pair", "5,30", "18.5", "10", "1e-12"),
        ("full-cube", "10,20", "16", "0", "1e-12"),
        ("full-cube", "10,20", "16", "10", "3e-4"),
    ] {
        let table = bake_table_with(folder.path(), design, around, azimuth, exact);
        let table = std::fs::rename(folder.path().join(table), folder.path().join("around.h5"));
        table.expect("renames");
        let truth = bake_table_with(folder.path(), design, between, azimuth, exact);
        let output = Command::new(python())
            .arg(argument("tests/tests/read_between.py"))
            .arg(argument("tables"))
            .args([folder.path().join("around.h5"), folder.path().join(&truth)])
            .arg(tolerance)
            .output()
            .unwrap();
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.success(),
            "{design} {around} {azimuth}: {err}"
        );
        std::fs::remove_file(folder.path().join(truth)).expect("removes");
    }
}
