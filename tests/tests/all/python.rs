//! A new table, read in Python as a user reads it: with h5py, and with xarray through h5netcdf.

use std::process::Command;

use tests::files::{argument, bake_table_with};
use tests::program::python;

#[test]
fn a_baked_table_opens_in_h5py_and_xarray() {
    let folder = tempfile::tempdir().unwrap();
    let mut read = 0;
    for method in [
        &["--method", "rays", "--rays", "1048576"][..],
        &["--method", "exact"],
    ] {
        let table = bake_table_with(folder.path(), "triangular", "0,10,35", "0,30", method);
        let output = Command::new(python())
            .arg(argument("tests/tests/read_table.py"))
            .arg(folder.path().join(table))
            .arg(method[1])
            .output()
            .unwrap();
        let (out, err) = (
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr),
        );
        assert!(output.status.success(), "{method:?}: {out}{err}");
        assert_eq!(out.trim(), "read 6 directions twice", "{err}");
        read += 1;
    }
    assert_eq!(read, 2);
}
