//! A table to its file and back, and the old file when writing fails.

use crate::sample;

use std::fs;
use std::path::Path;

use tables::{Output, Outputs, Table, read, write};

fn kinds() -> Vec<(&'static str, Table)> {
    let mut plain = sample::rays(1, 7);
    plain.provenance.lattice = None;
    let mut pathless = sample::exact();
    pathless
        .exact
        .as_mut()
        .unwrap()
        .paths
        .iter_mut()
        .for_each(Vec::clear);
    pathless.retroreflected.fill(0.0);
    pathless.histogram.fill(0.0);
    pathless.fate.fill(0.0);
    pathless.fate.slice_mut(ndarray::s![.., .., 7]).fill(1.0);
    vec![
        ("rays, one randomisation", plain),
        ("rays, 16 randomisations", sample::rays(16, 8)),
        ("mean over azimuths", sample::mean()),
        ("rays with deviations", sample::deviations(8)),
        ("exact with polygons", sample::exact()),
        ("exact with a symmetry", sample::symmetric()),
        ("rays behind a front", sample::trapped_rays()),
        ("exact behind a front", sample::trapped()),
        ("exact with losses", sample::lossy()),
        ("rays with losses", sample::lossy_rays()),
        ("exact, nothing returns", pathless),
    ]
}

#[test]
fn every_kind_of_table_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let mut tried = 0;
    for (kind, table) in kinds() {
        let (first, second) = (folder.path().join("a.h5"), folder.path().join("b.h5"));
        write(&table, &first).unwrap_or_else(|error| panic!("{kind}: {error}"));
        let back = read(&first).unwrap_or_else(|error| panic!("{kind}: {error}"));
        assert_eq!(back, table, "{kind}");
        assert_eq!(back.content_hash(), table.content_hash(), "{kind}");
        std::thread::sleep(std::time::Duration::from_millis(1100));
        write(&back, &second).unwrap();
        assert!(
            fs::read(&first).unwrap() == fs::read(&second).unwrap(),
            "{kind}: bytes depend on the time"
        );
        // A block of the user's before the file, of a length that HDF5 allows, with the seal or
        // without it.
        let whole = fs::read(&first).unwrap();
        for (block, end) in [(512, 0), (4096, 40), (100, 0), (768, 0)] {
            let end = whole.len() - end;
            fs::write(&second, [&vec![b'x'; block], &whole[..end]].concat()).unwrap();
            match read(&second) {
                Ok(back) => assert_eq!((back, block % 512), (table.clone(), 0), "{kind}, {block}"),
                Err(error) => assert!(
                    error.to_string().contains("is not an HDF5 file")
                        && ![512, 4096].contains(&block),
                    "{kind}, {block}: {error}"
                ),
            }
        }
        tried += 1;
    }
    assert_eq!(tried, 11);
}

#[test]
fn a_failed_write_leaves_the_old_table_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("table.h5");
    write(&sample::rays(1, 7), &file).unwrap();
    let old = fs::read(&file).unwrap();

    let mut wrong = sample::rays(1, 7);
    wrong.histogram[[0, 0, 0, 0]] = f64::NAN;
    let error = write(&wrong, &file).unwrap_err().to_string();
    assert!(error.contains("histogram is NaN"), "{error}");
    drop(Output::reserve(&file).unwrap());

    assert_eq!(fs::read(&file).unwrap(), old);
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        1,
        "a temporary file was left"
    );
}

#[test]
fn a_place_that_cannot_be_written_is_refused_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("no/such/folder/table.h5");
    let refused = |path: &Path, reason: &str| {
        let error = Output::reserve(path).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    };
    refused(&inside, "there is no folder");
    assert!(
        !Output::reserve(&inside)
            .unwrap_err()
            .to_string()
            .contains(".partial")
    );
    refused(folder.path(), "is not a regular file");
    // A device that was renamed over would be gone for every program.
    refused(Path::new("/dev/full"), "is not a regular file");
    let file = folder.path().join("table.h5");
    fs::write(&file, "kept").unwrap();
    let mut permissions = fs::metadata(&file).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&file, permissions).unwrap();
    refused(&file, "is write-protected");
    assert_eq!(fs::read(&file).unwrap(), b"kept");
}

#[test]
fn outputs_spare_inputs_and_each_other_under_any_name() {
    let folder = tempfile::tempdir().unwrap();
    let [input, link, new] = ["in.h5", "link.h5", "new.h5"].map(|name| folder.path().join(name));
    fs::write(&input, "kept").unwrap();
    std::os::unix::fs::symlink(&input, &link).unwrap();
    let roundabout = folder.path().join(".").join("new.h5");
    let mut outputs = Outputs::beside([input.as_path()]);
    let mut refused = 0;
    for (path, reserved) in [
        (&input, false),
        (&link, false),
        (&new, true),
        (&new, false),
        (&roundabout, false),
    ] {
        match (outputs.reserve(path), reserved) {
            (Ok(output), true) => assert!(!output.path().exists(), "a reservation leaves no file"),
            (Err(error), false) => {
                let reasons = ["is an input", "is named for two outputs"];
                let error = error.to_string();
                assert!(
                    reasons.iter().any(|reason| error.contains(reason)),
                    "{error}"
                );
                refused += 1;
            }
            (other, _) => panic!("{}: {other:?}", path.display()),
        }
    }
    assert_eq!(refused, 4);
    assert_eq!(fs::read(&input).unwrap(), b"kept");
}
