//! Tables as Python reads them: h5py, xarray with h5netcdf, and the reader of `FORMAT.md`.

use crate::sample;

use std::path::Path;
use std::process::Command;

use tables::write;

fn some_shards() -> tables::Table {
    let mut table = sample::rays(4, 7);
    table.provenance.shards = Some("1-3,7/8 of 4194304 rays".parse().unwrap());
    table
}

#[test]
fn h5py_and_xarray_read_every_kind_of_table() {
    let python = sample::python();
    let folder = tempfile::tempdir().unwrap();
    let mut tried = 0;
    for (kind, table) in [
        ("rays", sample::rays(4, 7)),
        ("mean", sample::mean()),
        ("shards", some_shards()),
        ("deviations", sample::deviations(7)),
        ("exact", sample::exact()),
        ("symmetric", sample::symmetric()),
        ("trapped", sample::trapped()),
        ("trapped rays", sample::trapped_rays()),
        ("lossy", sample::lossy()),
        ("lossy rays", sample::lossy_rays()),
    ] {
        let file = folder.path().join(kind).with_extension("h5");
        write(&table, &file).unwrap();
        let (i, j) = table.axes.shape();
        let values = [
            table.content_hash(),
            format!("{i}"),
            format!("{j}"),
            format!("{}", table.axes.bins),
            format!("{:?}", table.histogram[[1, 0, 3, 4]]),
            format!("{:?}", table.retroreflected[[1, 0]]),
            format!("{}", table.rays.sum()),
        ];
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_with_python.py");
        let output = Command::new(&python)
            .arg(script)
            .arg(kind)
            .arg(&file)
            .args(&values)
            .output()
            .unwrap();
        let (out, err) = (
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr),
        );
        assert!(output.status.success(), "{kind}: {out}{err}");
        assert!(out.starts_with("checks passed: "), "{kind}: {out}");
        tried += 1;
    }
    assert_eq!(tried, 10);
}
