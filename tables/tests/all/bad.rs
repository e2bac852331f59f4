//! Damaged and strangers' files: each is refused with a message that says what is wrong, where, and
//! what to do.

use crate::sample;

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use hdf5::types::{FixedAscii, VarLenUnicode};
use ndarray::{Array2, Array4};
use tables::{read, write};

/// Folder with one good table in it.
struct Bench {
    folder: tempfile::TempDir,
    good: Vec<u8>,
}

impl Bench {
    fn new() -> Bench {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("good.h5");
        write(&sample::rays(2, 7), &file).unwrap();
        let good = fs::read(&file).unwrap();
        Bench { folder, good }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("bad.h5")
    }

    fn bytes(&self, bytes: &[u8]) -> String {
        fs::write(self.path(), bytes).unwrap();
        refusal(&self.path())
    }

    /// Opens the good table for writing with the HDF5 library, which cuts the seal off, and damages
    /// it.
    fn spoilt(&self, spoil: impl FnOnce(&hdf5::File)) -> String {
        fs::write(self.path(), &self.good).unwrap();
        let file = hdf5::File::open_rw(self.path()).unwrap();
        spoil(&file);
        file.close().unwrap();
        refusal(&self.path())
    }
}

fn refusal(path: &Path) -> String {
    let message = read(path).expect_err("a bad table was read").to_string();
    assert!(
        message.contains(&path.display().to_string()),
        "names no file: {message}"
    );
    assert!(
        message.contains(';') || message.contains(", copy"),
        "names no remedy: {message}"
    );
    message
}

fn text(value: &str) -> VarLenUnicode {
    VarLenUnicode::from_str(value).unwrap()
}

fn replace(file: &hdf5::File, name: &str, values: &ndarray::ArrayD<f64>) {
    file.unlink(name).unwrap();
    file.new_dataset_builder()
        .with_data(values)
        .create(name)
        .unwrap();
}

fn change(file: &hdf5::File, name: &str, index: usize, value: f64) {
    let dataset = file.dataset(name).unwrap();
    let mut values = dataset.read_raw::<f64>().unwrap();
    values[index] = value;
    dataset.write_raw(&values).unwrap();
}

fn change_count(file: &hdf5::File, name: &str, index: usize, value: u64) {
    let dataset = file.dataset(name).unwrap();
    let mut values = dataset.read_raw::<u64>().unwrap();
    values[index] = value;
    dataset.write_raw(&values).unwrap();
}

fn attribute<T: hdf5::H5Type>(file: &hdf5::File, name: &str, value: &T) {
    file.delete_attr(name).unwrap();
    file.new_attr::<T>()
        .create(name)
        .unwrap()
        .write_scalar(value)
        .unwrap();
}

#[test]
fn every_bad_table_is_refused_with_its_message() {
    let bench = Bench::new();
    let good = &bench.good;
    let sealed = good.len() - 40;
    let mut cases: Vec<(&str, String, &str)> = Vec::new();
    let mut case = |what, message, expected| cases.push((what, message, expected));

    case(
        "no such file",
        refusal(&bench.folder.path().join("none.h5")),
        "cannot be read (No such file",
    );
    case(
        "a folder",
        refusal(bench.folder.path()),
        "is not a regular file",
    );
    case("empty", bench.bytes(b""), "is not an HDF5 file (0 bytes");
    case(
        "text",
        bench.bytes(b"incidence,azimuth,eta\n0,0,0.667\n"),
        "is not an HDF5 file (32 bytes",
    );
    case(
        "signature alone",
        bench.bytes(&good[..8]),
        "file cannot be read",
    );
    case(
        "cut in the superblock",
        bench.bytes(&good[..20]),
        "file cannot be read",
    );
    case(
        "cut in the middle",
        bench.bytes(&good[..good.len() / 2]),
        "the file is cut short or damaged",
    );
    case(
        "cut by the last byte of data",
        bench.bytes(&good[..sealed - 1]),
        "the file is cut short or damaged",
    );
    let mut flipped = good.clone();
    flipped[good.len() / 3] ^= 4;
    case(
        "one bit",
        bench.bytes(&flipped),
        "is damaged (its bytes have SHA-256",
    );
    let empty = |path: PathBuf| {
        hdf5::File::create(&path).unwrap().close().unwrap();
        refusal(&path)
    };
    case(
        "another HDF5 file",
        empty(bench.path()),
        "attribute format is missing",
    );

    let spoilt = |spoil: &dyn Fn(&hdf5::File)| bench.spoilt(spoil);
    case(
        "another format",
        spoilt(&|f| attribute(f, "format", &text("star catalogue"))),
        "attribute format is \"star catalogue\"",
    );
    case(
        "a later version",
        spoilt(&|f| attribute(f, "version", &4_u64)),
        "is of format version 4, this program reads 1 to 3",
    );
    case(
        "version 0",
        spoilt(&|f| attribute(f, "version", &0_u64)),
        "is of format version 0",
    );
    case(
        "version in words",
        spoilt(&|f| attribute(f, "version", &text("1"))),
        "attribute version is ",
    );
    case(
        "no design",
        spoilt(&|f| f.delete_attr("design").unwrap()),
        "attribute design is missing",
    );
    case(
        "design a number",
        spoilt(&|f| attribute(f, "design", &1.5_f64)),
        "attribute design is ",
    );
    case(
        "edge length NaN",
        spoilt(&|f| attribute(f, "edge_length", &f64::NAN)),
        "edge_length is NaN at flat index 0, outside of 1e-12 to 1e12",
    );
    case(
        "range infinite",
        spoilt(&|f| attribute(f, "shift_range", &f64::INFINITY)),
        "shift_range is inf",
    );
    case(
        "other design",
        spoilt(&|f| attribute(f, "design", &text("canted"))),
        "attribute content_hash says",
    );
    case(
        "other seed",
        spoilt(&|f| attribute(f, "seed", &8_u64)),
        "attribute content_hash says",
    );
    case(
        "wrong hash",
        spoilt(&|f| attribute(f, "content_hash", &text(&"0".repeat(64)))),
        "says 0000000000",
    );

    case(
        "no histogram",
        spoilt(&|f| f.unlink("histogram").unwrap()),
        "dataset histogram is missing",
    );
    case(
        "no counts",
        spoilt(&|f| f.unlink("counts").unwrap()),
        "dataset counts is missing",
    );
    case(
        "no fate names",
        spoilt(&|f| f.unlink("fate_name").unwrap()),
        "dataset fate_name is missing",
    );
    case(
        "a link out of the file",
        spoilt(&|f| {
            f.unlink("rays").unwrap();
            f.link_external("good.h5", "/rays", "rays").unwrap();
        }),
        "dataset rays is missing",
    );
    case(
        "a link to itself",
        spoilt(&|f| {
            f.unlink("rays").unwrap();
            f.link_soft("/rays", "rays").unwrap();
        }),
        "dataset rays is missing",
    );
    case(
        "histogram of f32",
        spoilt(&|f| {
            f.unlink("histogram").unwrap();
            f.new_dataset_builder()
                .with_data(&Array4::<f32>::zeros((3, 2, 8, 8)))
                .create("histogram")
                .unwrap();
        }),
        "dataset histogram holds float32, expected float64",
    );
    case(
        "counts of i64",
        spoilt(&|f| {
            f.unlink("rays").unwrap();
            f.new_dataset_builder()
                .with_data(&Array2::<i64>::zeros((3, 2)))
                .create("rays")
                .unwrap();
        }),
        "dataset rays holds int64, expected uint64",
    );
    case(
        "histogram of other bins",
        spoilt(&|f| replace(f, "histogram", &Array4::zeros((3, 2, 8, 7)).into_dyn())),
        "dataset histogram has shape [3, 2, 8, 7], expected [3, 2, 8, 8]",
    );
    case(
        "histogram of two dimensions",
        spoilt(&|f| replace(f, "histogram", &Array2::zeros((8, 8)).into_dyn())),
        "dataset histogram has shape [8, 8]",
    );
    case(
        "2^40 directions claimed",
        spoilt(&|f| {
            f.unlink("incidence_deg").unwrap();
            f.new_dataset::<f64>()
                .chunk(1024)
                .shape(1 << 40)
                .create("incidence_deg")
                .unwrap();
        }),
        "dataset incidence_deg claims 8796093022208 bytes",
    );
    case(
        "2^20 x 2^20 bins claimed",
        spoilt(&|f| {
            f.unlink("histogram").unwrap();
            f.new_dataset::<f64>()
                .chunk((1, 1, 8, 8))
                .shape((3, 2, 1 << 20, 1 << 20))
                .create("histogram")
                .unwrap();
        }),
        "dataset histogram claims",
    );
    case(
        "a chunk of 256 MiB",
        spoilt(&|f| {
            f.unlink("incidence_deg").unwrap();
            f.new_dataset::<f64>()
                .chunk(1 << 25)
                .shape((3..,))
                .create("incidence_deg")
                .unwrap();
        }),
        "dataset incidence_deg is stored in chunks above 128 MiB",
    );
    case(
        "data in another file",
        spoilt(&|f| {
            f.unlink("incidence_deg").unwrap();
            f.new_dataset::<f64>()
                .external("/etc/hostname", 0, 24)
                .shape(3)
                .create("incidence_deg")
                .unwrap();
        }),
        "dataset incidence_deg is stored in another file",
    );
    case(
        "a filter that is never written",
        spoilt(&|f| {
            f.unlink("incidence_deg").unwrap();
            f.new_dataset::<f64>()
                .chunk(3)
                .nbit()
                .shape(3)
                .create("incidence_deg")
                .unwrap();
        }),
        "through a filter other than",
    );
    case(
        "a group in the place of a dataset",
        spoilt(&|f| {
            f.unlink("rays").unwrap();
            f.create_group("rays").unwrap();
        }),
        "dataset rays cannot be read",
    );

    case(
        "NaN in the histogram",
        spoilt(&|f| change(f, "histogram", 5, f64::NAN)),
        "dataset histogram is NaN at flat index 5",
    );
    case(
        "histogram off the counts",
        spoilt(&|f| change(f, "histogram", 0, 0.5)),
        "dataset histogram is 0.5 at flat index 0",
    );
    case(
        "eta off the counts",
        spoilt(&|f| change(f, "retroreflected", 1, 0.25)),
        "dataset retroreflected is 0.25",
    );
    case(
        "error off the counts",
        spoilt(&|f| change(f, "standard_error", 2, 0.25)),
        "dataset standard_error is 0.25",
    );
    case(
        "fate off the counts",
        spoilt(&|f| change(f, "fate", 13, 0.25)),
        "dataset fate is 0.25 at flat index 13",
    );
    case(
        "a count off its fate",
        spoilt(&|f| change_count(f, "counts", 0, 100_000)),
        "fate_counts says",
    );
    case(
        "counts that overflow",
        spoilt(&|f| change_count(f, "counts", 0, u64::MAX)),
        "fate_counts says",
    );
    case(
        "rays off their fates",
        spoilt(&|f| change_count(f, "rays", 3, 1)),
        "rays is 1 at direction (1, 1)",
    );
    case(
        "2^63 rays missed",
        spoilt(&|f| change_count(f, "fate_counts", 7, 1 << 63)),
        "above 2^53",
    );
    case(
        "incidence of 95 deg",
        spoilt(&|f| change(f, "incidence_deg", 2, 95.0)),
        "incidence_deg is 95.0 at index 2",
    );
    case(
        "incidence that falls",
        spoilt(&|f| change(f, "incidence_deg", 1, 50.0)),
        "incidence_deg does not ascend at index 2",
    );
    case(
        "azimuth NaN among others",
        spoilt(&|f| change(f, "azimuth_deg", 0, f64::NAN)),
        "azimuth_deg is NaN at index 0",
    );
    case(
        "bin centres elsewhere",
        spoilt(&|f| change(f, "shift_v", 3, 0.0)),
        "dataset shift_v is 0 at index 3, expected -0.25",
    );
    case(
        "fates in another order",
        spoilt(&|f| {
            let dataset = f.dataset("fate_name").unwrap();
            let mut names = dataset.read_raw::<VarLenUnicode>().unwrap();
            names.swap(1, 2);
            dataset.write_raw(&names).unwrap();
        }),
        "dataset fate_name is left_after_2 at index 1, expected left_after_1",
    );

    for (what, message, expected) in &cases {
        assert!(
            message.contains(expected),
            "{what}: {message:?} lacks {expected:?}"
        );
    }
    let kinds: HashSet<_> = cases.iter().map(|(what, ..)| what).collect();
    assert_eq!((cases.len(), kinds.len()), (50, 50));
}

/// Returns the names of all datasets of floats in a group and below it.
fn floats(group: &hdf5::Group) -> Vec<String> {
    let mut names: Vec<String> = group
        .datasets()
        .unwrap()
        .iter()
        .filter(|dataset| dataset.dtype().unwrap().is::<f64>())
        .map(|dataset| dataset.name())
        .collect();
    for inner in group.groups().unwrap() {
        names.extend(floats(&inner));
    }
    names
}

/// NaN and infinity at both ends of every dataset of every kind of table, each refused by name.
#[test]
fn numbers_that_are_not_finite_are_refused_in_every_dataset() {
    let bench = Bench::new();
    let file = bench.path();
    let mut tried = 0;
    for table in [
        sample::rays(2, 7),
        sample::exact(),
        sample::deviations(7),
        sample::trapped(),
    ] {
        write(&table, &file).unwrap();
        let good = fs::read(&file).unwrap();
        let names = floats(&hdf5::File::open(&file).unwrap());
        assert!(names.len() >= 8, "{names:?}");
        for name in &names {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                for last in [false, true] {
                    fs::write(&file, &good).unwrap();
                    let opened = hdf5::File::open_rw(&file).unwrap();
                    let length = opened.dataset(name).unwrap().size();
                    change(&opened, name, if last { length - 1 } else { 0 }, value);
                    opened.close().unwrap();
                    let message = refusal(&file);
                    let short = name.rsplit('/').next().unwrap();
                    assert!(message.contains(short), "{value} in {name}: {message}");
                    tried += 1;
                }
            }
        }
    }
    println!("{tried} numbers that are not finite");
    assert!(tried > 150, "{tried}");
}

/// Fates, passes and Jones matrices that do not fit the rest of the table.
#[test]
fn bad_light_behind_a_front_is_refused() {
    let bench = Bench::new();
    let file = bench.path();
    let refused = |table: &tables::Table, spoil: &dyn Fn(&hdf5::File)| {
        write(table, &file).unwrap();
        let opened = hdf5::File::open_rw(&file).unwrap();
        spoil(&opened);
        opened.close().unwrap();
        refusal(&file)
    };
    let (once, trapped) = (sample::exact(), sample::trapped());
    let options = |f: &hdf5::File, value: &str| {
        if f.attr("options").is_err() {
            let new = f.new_attr::<hdf5::types::VarLenUnicode>();
            new.create("options").unwrap();
        }
        attribute(f, "options", &text(value));
    };
    let set = |f: &hdf5::File, name: &str, shape: &[usize], values: &[u64]| {
        let group = f.group("exact").unwrap();
        if group.link_exists(name) {
            group.unlink(name).unwrap();
        }
        let dataset = group
            .new_dataset::<u64>()
            .shape(shape)
            .create(name)
            .unwrap();
        dataset.write_raw(values).unwrap();
    };
    let cases = [
        (
            refused(&once, &|f| options(f, "--front trapped")),
            "dataset fate_name has shape [10], expected [11]",
        ),
        (
            refused(&trapped, &|f| options(f, "--normals file")),
            "dataset fate_name has shape [11], expected [10]",
        ),
        (
            refused(&trapped, &|f| set(f, "path_passes", &[10], &[1 << 32; 10])),
            "dataset exact/path_passes is 4294967296 at index 0, expected 0 to 4294967295",
        ),
        (
            refused(&trapped, &|f| set(f, "path_passes", &[9], &[1; 9])),
            "dataset exact/path_passes has shape [9], expected [10]",
        ),
        (
            refused(&trapped, &|f| set(f, "path_passes", &[10], &[1; 10])),
            "attribute content_hash says",
        ),
        (
            refused(&trapped, &|f| {
                set(f, "path_jones", &[10, 2, 2, 2], &[1; 80]);
            }),
            "path_jones",
        ),
        (
            refused(&trapped, &|f| {
                f.group("exact").unwrap().unlink("path_jones").unwrap();
            }),
            "attribute content_hash says",
        ),
        (
            refused(&once, &|f| set(f, "path_passes", &[10], &[1; 10])),
            "attribute content_hash says",
        ),
    ];
    for (message, expected) in &cases {
        assert!(message.contains(expected), "{message}");
    }
    assert_eq!(cases.len(), 8);
}

#[test]
fn bad_polygons_are_refused() {
    let bench = Bench::new();
    let file = bench.path();
    let spoilt = |spoil: &dyn Fn(&hdf5::Group)| {
        write(&sample::exact(), &file).unwrap();
        let opened = hdf5::File::open_rw(&file).unwrap();
        spoil(&opened.group("exact").unwrap());
        opened.close().unwrap();
        refusal(&file)
    };
    let set = |group: &hdf5::Group, name: &str, index: usize, value: u64| {
        let dataset = group.dataset(name).unwrap();
        let mut values = dataset.read_raw::<u64>().unwrap();
        values[index] = value;
        dataset.write_raw(&values).unwrap();
    };
    let set_float = |group: &hdf5::Group, name: &str, index: usize, value: f64| {
        let dataset = group.dataset(name).unwrap();
        let mut values = dataset.read_raw::<f64>().unwrap();
        values[index] = value;
        dataset.write_raw(&values).unwrap();
    };
    let cases = [
        (
            spoilt(&|g| set(g, "polygon_start", 3, u64::MAX)),
            "dataset exact/polygon_start is 18446744073709551615 at index 3",
        ),
        (
            spoilt(&|g| set(g, "polygon_start", 3, 0)),
            "dataset exact/polygon_start is 0 at index 3",
        ),
        (
            spoilt(&|g| set(g, "polygon_start", 10, 39)),
            "dataset exact/polygon_start is 39 at index 10, expected 40",
        ),
        (
            spoilt(&|g| set(g, "path_direction", 9, 6)),
            "dataset exact/path_direction is 6 at index 9",
        ),
        (
            spoilt(&|g| set(g, "path_direction", 0, 3)),
            "dataset exact/path_direction is 0 at index 1",
        ),
        (
            spoilt(&|g| set_float(g, "path_matrix", 2, f64::NAN)),
            "path_matrix is NaN",
        ),
        (
            spoilt(&|g| set_float(g, "polygon_vertex", 2, 9.0)),
            "polygons of direction (0, 0) return",
        ),
        (
            spoilt(&|g| set_float(g, "polygon_vertex", 2, -9.0)),
            "path 0 of direction 0 has a polygon",
        ),
        (
            spoilt(&|g| set_float(g, "path_offset", 2, 9.0)),
            "attribute content_hash says",
        ),
        (
            spoilt(&|g| g.unlink("path_weight").unwrap()),
            "dataset exact/path_weight is missing",
        ),
        (
            spoilt(&|g| g.delete_attr("entrance_area").unwrap()),
            "attribute exact/entrance_area is missing",
        ),
    ];
    for (message, expected) in &cases {
        assert!(message.contains(expected), "{message:?} lacks {expected:?}");
    }
    assert_eq!(cases.len(), 11);
}

/// Rewriting by another program: texts of a fixed length and big-endian numbers keep the content.
#[test]
fn bad_deviations_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("table.h5");
    let spoilt = |spoil: &dyn Fn(&hdf5::Group)| {
        write(&sample::deviations(7), &file).unwrap();
        let opened = hdf5::File::open_rw(&file).unwrap();
        spoil(&opened.group("deviation").unwrap());
        opened.close().unwrap();
        refusal(&file)
    };
    let set = |name: &'static str, index: usize, value: u64| {
        move |group: &hdf5::Group| {
            let dataset = group.dataset(name).unwrap();
            let mut values = dataset.read_1d::<u64>().unwrap();
            values[index] = value;
            dataset.write(&values).unwrap();
        }
    };
    let grid = |name: &'static str, value: u64| {
        move |group: &hdf5::Group| group.attr(name).unwrap().write_scalar(&value).unwrap()
    };
    let range = |value: f64| {
        move |group: &hdf5::Group| group.attr("range").unwrap().write_scalar(&value).unwrap()
    };
    type Spoil<'a> = &'a dyn Fn(&hdf5::Group);
    let cases: [(Spoil, &str); 11] = [
        (
            &set("entry_place", 0, 400),
            "entry 0 of the deviations of direction 0 has the place 400",
        ),
        (
            &set("entry_place", 1, 0),
            "entry 1 of the deviations of direction 0 has the place 0",
        ),
        (&set("entry_rays", 3, 0), "and 0 rays"),
        (
            &set("entry_rays", 0, u64::MAX),
            "rays in the cell (v, u) = (0, 0)",
        ),
        (
            &set("entry_start", 0, 1),
            "deviation/entry_start is 1 at index 0",
        ),
        (&set("entry_start", 1, u64::MAX), "deviation/entry_start"),
        (&set("entry_start", 6, 7), "deviation/entry_start"),
        (&grid("cells", 3), "deviation cells is 3"),
        (&grid("cells", 0), "deviation cells is 0"),
        (&grid("bins", u64::MAX), "deviation bins"),
        (&range(f64::NAN), "deviation range is NaN"),
    ];
    let mut tried = 0;
    for (spoil, expected) in cases {
        let message = spoilt(spoil);
        assert!(
            message.contains(expected),
            "{message}\nshould say\n{expected}"
        );
        tried += 1;
    }
    assert_eq!(tried, 11);
    write(&sample::deviations(7), &file).unwrap();
    let message = spoilt(&|group| group.unlink("entry_rays").unwrap());
    assert!(message.contains("deviation/entry_rays"), "{message}");
}

#[test]
fn a_table_that_another_program_rewrote_is_read() {
    let bench = Bench::new();
    fs::write(bench.path(), &bench.good).unwrap();
    let file = hdf5::File::open_rw(bench.path()).unwrap();
    attribute(
        &file,
        "design",
        &FixedAscii::<24>::from_ascii(b"triangular-pair").unwrap(),
    );
    attribute(&file, "version", &1_i32);
    attribute(&file, "reflectance", &1_i64);
    file.new_attr::<f64>()
        .create("note_of_another_team")
        .unwrap()
        .write_scalar(&1.0)
        .unwrap();
    file.close().unwrap();
    assert_eq!(read(&bench.path()).unwrap(), sample::rays(2, 7));
}

/// An attribute whose type claims 15 of the 16 bytes that a text of variable length needs: libhdf5
/// would read 16, one beyond its memory. The file was made from one that h5py wrote, without
/// checksums, as libFuzzer found it.
#[test]
fn an_attribute_with_too_few_bytes_is_refused() {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/found/table");
    let bytes = fs::read(found.join("text_of_15_bytes.h5")).unwrap();
    let message = Bench::new().bytes(&bytes);
    assert!(message.contains("attribute back"), "{message}");
    assert!(message.contains("in 15 bytes"), "{message}");
}

/// Attributes outside of what `bake` writes, and methods that contradict the content.
#[test]
fn attributes_outside_of_their_range_are_refused() {
    let bench = Bench::new();
    let (below, above) = (f64::from_bits(1), |x: f64| f64::from_bits(x.to_bits() + 1));
    let single: [(&str, &[f64]); 11] = [
        (
            "angular_tolerance_deg",
            &[0.0, above(90.0), 91.0, 180.0, -1.0],
        ),
        ("direction_tolerance", &[0.0, above(1.0), f64::NAN]),
        ("wavelength_nm", &[0.0, above(1e6), 1e308]),
        ("refractive_index", &[0.5, above(10.0), f64::INFINITY]),
        ("reflectance", &[0.0, above(1.0)]),
        ("tolerance", &[-below, above(2.0), 1e308]),
        ("edge_length", &[0.0, 1e-13, 1e13]),
        ("symmetry_mirror_deg", &[-1.0, 360.0]),
        ("metal_index", &[-1.0, above(1e3), 1e308]),
        ("azimuth_zero", &[0.0, 1e13, f64::NAN]),
        ("lattice", &[0.0, above(1e6), 1e308, -1.0]),
    ];
    let mut cases = 0;
    for (name, values) in single {
        for &value in values {
            let message = bench.spoilt(|file| {
                // An attribute of several numbers has this one in the first place, and lattice
                // vectors are (value, 0) and (0, 1).
                let numbers: &[f64] = match name {
                    "metal_index" => &[value, 1.0],
                    "azimuth_zero" => &[value, 0.0, 0.0],
                    "lattice" => &[value, 0.0, 0.0, 1.0],
                    _ => &[value],
                };
                if file.attr(name).is_ok() {
                    file.delete_attr(name).unwrap();
                }
                let numbers = ndarray::arr1(numbers);
                let of = |shape: &[usize]| numbers.to_shape(shape).unwrap().to_owned();
                let shape: &[usize] = match name {
                    "metal_index" => &[2],
                    "azimuth_zero" => &[3],
                    "lattice" => &[2, 2],
                    _ => &[],
                };
                let attribute = file.new_attr::<f64>().shape(shape).create(name).unwrap();
                attribute.write(&of(shape)).unwrap();
            });
            let says = message.contains(name) && message.contains("outside of");
            assert!(says, "{name} {value}: {message}");
            cases += 1;
        }
    }
    for [method, sampler] in [
        ["exact", "none"],
        ["exact", "sobol"],
        ["rays", "none"],
        ["auto", "sobol"],
    ] {
        let message = bench.spoilt(|file| {
            attribute(file, "method", &text(method));
            attribute(file, "sampler", &text(sampler));
        });
        assert!(
            message.contains(&format!("method is \"{method}\"")),
            "{message}"
        );
        cases += 1;
    }
    for azimuth in [above(360.0), 719.0] {
        let message = bench.spoilt(|file| change(file, "azimuth_deg", 1, azimuth));
        assert!(
            message.contains("azimuth_deg") && message.contains("outside of"),
            "{message}"
        );
        cases += 1;
    }
    assert_eq!(cases, 34 + 4 + 2);
}
