//! Damaged and strangers' files: each is refused with a message that says what is wrong, where, and
//! what to do.

use crate::sample;

use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use hdf5::types::{FixedAscii, VarLenUnicode};
use ndarray::{Array2, Array4};
use tables::{Table, read, write};

/// Folder with one good table in it.
struct Bench {
    folder: tempfile::TempDir,
    good: Vec<u8>,
}

impl Bench {
    fn new() -> Bench {
        Bench::of(&sample::rays(2, 7))
    }

    fn of(table: &Table) -> Bench {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("good.h5");
        write(table, &file).unwrap();
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

    /// Makes the change of each line, and checks that the message of the refusal has what stands
    /// behind it.
    fn refuses(&self, lines: &str) {
        for line in lines.lines() {
            let (change, expected) = line.split_once(" | ").unwrap();
            let message = self.spoilt(|file| spoil(file, change));
            assert!(message.contains(expected), "{change}: {message}");
        }
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

/// Makes the change that a line describes: its kind, the name of a dataset or an attribute, for a
/// dataset the index of an element, and the value.
fn spoil(file: &hdf5::File, line: &str) {
    let [kind, place, rest] = line.splitn(3, ' ').collect::<Vec<_>>()[..] else {
        let (kind, place) = line.split_once(' ').unwrap();
        let (group, name) = within(file, place);
        return match kind {
            "unlink" => group.unlink(name).unwrap(),
            "delete" => group.delete_attr(name).unwrap(),
            other => panic!("{other}"),
        };
    };
    let (group, name) = within(file, place);
    let element = || rest.split_once(' ').unwrap();
    match kind {
        "float" => change(
            file,
            place,
            element().0.parse().unwrap(),
            element().1.parse().unwrap(),
        ),
        "count" => {
            let dataset = file.dataset(place).unwrap();
            let mut values = dataset.read_raw::<u64>().unwrap();
            let index: usize = element().0.parse().unwrap();
            values[index] = element().1.parse().unwrap();
            dataset.write_raw(&values).unwrap();
        }
        "text" => attribute(&group, name, &text(rest)),
        "number" => attribute(&group, name, &rest.parse::<f64>().unwrap()),
        "whole" => attribute(&group, name, &rest.parse::<u64>().unwrap()),
        other => panic!("{other}"),
    }
}

/// Returns the group and the name of an object such as `exact/path_matrix`.
fn within<'a>(file: &hdf5::File, place: &'a str) -> (hdf5::Group, &'a str) {
    let (group, name) = place.split_once('/').unwrap_or(("/", place));
    (file.group(group).unwrap(), name)
}

fn text(value: &str) -> VarLenUnicode {
    VarLenUnicode::from_str(value).unwrap()
}

/// Puts another dataset in the place of one.
fn replace<T: hdf5::H5Type, D: ndarray::Dimension>(
    file: &hdf5::File,
    name: &str,
    values: &ndarray::Array<T, D>,
) {
    file.unlink(name).unwrap();
    let builder = file.new_dataset_builder().with_data(values);
    builder.create(name).unwrap();
}

fn change(file: &hdf5::File, name: &str, index: usize, value: f64) {
    let dataset = file.dataset(name).unwrap();
    let mut values = dataset.read_raw::<f64>().unwrap();
    values[index] = value;
    dataset.write_raw(&values).unwrap();
}

fn attribute<T: hdf5::H5Type>(group: &hdf5::Group, name: &str, value: &T) {
    if group.attr(name).is_ok() {
        group.delete_attr(name).unwrap();
    }
    let attribute = group.new_attr::<T>().create(name).unwrap();
    attribute.write_scalar(value).unwrap();
}

#[test]
fn other_files_and_cut_ones_are_refused() {
    let bench = Bench::new();
    let good = &bench.good;
    let sealed = good.len() - 40;
    let mut flipped = good.clone();
    flipped[good.len() / 3] ^= 4;
    let empty = bench.folder.path().join("empty.h5");
    hdf5::File::create(&empty).unwrap().close().unwrap();
    let none = bench.folder.path().join("none.h5");
    let cases = [
        (refusal(&none), "cannot be read (No such file"),
        (refusal(bench.folder.path()), "is not a regular file"),
        (refusal(&empty), "attribute format is missing"),
        (bench.bytes(b""), "is not an HDF5 file (0 bytes"),
        (
            bench.bytes(b"a,b\n0,0.6\n"),
            "is not an HDF5 file (10 bytes",
        ),
        (bench.bytes(&good[..8]), "file cannot be read"),
        (bench.bytes(&good[..20]), "file cannot be read"),
        (bench.bytes(&good[..sealed / 2]), "cut short or damaged"),
        (bench.bytes(&good[..sealed - 1]), "cut short or damaged"),
        (bench.bytes(&flipped), "is damaged (its bytes have SHA-256"),
    ];
    for (message, expected) in &cases {
        assert!(message.contains(expected), "{message:?} lacks {expected:?}");
    }
}

/// Changes of one attribute or one number, and missing objects.
#[test]
fn changed_attributes_and_numbers_are_refused() {
    Bench::new().refuses(
        "\
text format star catalogue | attribute format is \"star catalogue\"
whole version 5 | is of format version 5, this program reads 1 to 4
whole version 0 | is of format version 0
text version 1 | attribute version is
delete design | attribute design is missing
number design 1.5 | attribute design is
number edge_length NaN | edge_length is NaN at flat index 0, outside of 1e-12 to 1e12
number shift_range inf | shift_range is inf
text design canted | attribute content_hash says
whole seed 8 | attribute content_hash says
text content_hash 0000000000000000000000000000000000000000 | says 0000000000
unlink histogram | dataset histogram is missing
unlink counts | dataset counts is missing
unlink fate_name | dataset fate_name is missing
float histogram 5 NaN | dataset histogram is NaN at flat index 5
float histogram 0 0.5 | dataset histogram is 0.5 at flat index 0
float retroreflected 1 0.25 | dataset retroreflected is 0.25
float standard_error 2 0.25 | dataset standard_error is 0.25
float fate 13 0.25 | dataset fate is 0.25 at flat index 13
count counts 0 100000 | fate_counts says
count counts 0 18446744073709551615 | fate_counts says
count rays 3 1 | rays is 1 at direction (1, 1)
count fate_counts 7 9223372036854775808 | above 2^53
float incidence_deg 2 95 | incidence_deg is 95.0 at index 2
float incidence_deg 1 50 | incidence_deg does not ascend at index 2
float azimuth_deg 0 NaN | azimuth_deg is NaN at index 0
float shift_v 3 0 | dataset shift_v is 0 at index 3, expected -0.25",
    );
}

/// Datasets of another kind, and datasets that are stored as a table never is.
#[test]
fn datasets_of_another_kind_are_refused() {
    let bench = Bench::new();
    // Another dataset of floats in the place of the incidences.
    let stored = |of: &dyn Fn(hdf5::DatasetBuilder, &str)| {
        bench.spoilt(|file| {
            file.unlink("incidence_deg").unwrap();
            of(file.new_dataset_builder(), "incidence_deg");
        })
    };
    let bins = |shape: (usize, usize, usize, usize)| Array4::<f64>::zeros(shape);
    let cases = [
        (
            bench.spoilt(|f| {
                f.unlink("rays").unwrap();
                f.link_external("good.h5", "/rays", "rays").unwrap();
            }),
            "dataset rays is missing",
        ),
        (
            bench.spoilt(|f| {
                f.unlink("rays").unwrap();
                f.link_soft("/rays", "rays").unwrap();
            }),
            "dataset rays is missing",
        ),
        (
            bench.spoilt(|f| {
                f.unlink("rays").unwrap();
                f.create_group("rays").unwrap();
            }),
            "dataset rays cannot be read",
        ),
        (
            bench.spoilt(|f| replace(f, "histogram", &bins((3, 2, 8, 8)).mapv(|x| x as f32))),
            "dataset histogram holds float32, expected float64",
        ),
        (
            bench.spoilt(|f| replace(f, "rays", &Array2::<i64>::zeros((3, 2)))),
            "dataset rays holds int64, expected uint64",
        ),
        (
            bench.spoilt(|f| replace(f, "histogram", &bins((3, 2, 8, 7)))),
            "dataset histogram has shape [3, 2, 8, 7], expected [3, 2, 8, 8]",
        ),
        (
            bench.spoilt(|f| replace(f, "histogram", &Array2::<f64>::zeros((8, 8)))),
            "dataset histogram has shape [8, 8]",
        ),
        (
            stored(&|new, name| {
                let empty = new.chunk(1024).empty::<f64>();
                empty.shape(1 << 40).create(name).unwrap();
            }),
            "dataset incidence_deg claims 8796093022208 bytes",
        ),
        (
            bench.spoilt(|f| {
                f.unlink("histogram").unwrap();
                let empty = f.new_dataset::<f64>().chunk((1, 1, 8, 8));
                let empty = empty.shape((3, 2, 1 << 20, 1 << 20));
                empty.create("histogram").unwrap();
            }),
            "dataset histogram claims",
        ),
        (
            stored(&|new, name| {
                let empty = new.chunk(1 << 25).empty::<f64>();
                empty.shape((3..,)).create(name).unwrap();
            }),
            "dataset incidence_deg is stored in chunks above 128 MiB",
        ),
        (
            stored(&|new, name| {
                let empty = new.external("/etc/hostname", 0, 24).empty::<f64>();
                empty.shape(3).create(name).unwrap();
            }),
            "dataset incidence_deg is stored in another file",
        ),
        (
            stored(&|new, name| {
                let empty = new.chunk(3).nbit().empty::<f64>();
                empty.shape(3).create(name).unwrap();
            }),
            "through a filter other than",
        ),
        (
            bench.spoilt(|f| {
                let dataset = f.dataset("fate_name").unwrap();
                let mut names = dataset.read_raw::<VarLenUnicode>().unwrap();
                names.swap(1, 2);
                dataset.write_raw(&names).unwrap();
            }),
            "dataset fate_name is left_after_2 at index 1, expected left_after_1",
        ),
    ];
    for (message, expected) in &cases {
        assert!(message.contains(expected), "{message:?} lacks {expected:?}");
    }
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
    Bench::of(&sample::exact())
        .refuses("text options --front trapped | dataset fate_name has shape [10], expected [11]");
    Bench::of(&sample::lossy()).refuses(
        "\
text losses none | dataset fate_name has shape [12], expected [10]
number refractive_index 1 | dataset fate_name has shape [12], expected [10]",
    );
    let bench = Bench::of(&sample::trapped());
    bench.refuses(
        "\
text options --normals file | dataset fate_name has shape [11], expected [10]
count exact/path_passes 0 4294967296 | path_passes is 4294967296 at index 0, expected 0 to 429496
count exact/path_passes 0 7 | attribute content_hash says
unlink exact/path_jones | attribute content_hash says",
    );
    let set = |bench: &Bench, name: &str, shape: &[usize]| {
        bench.spoilt(|file| {
            let group = file.group("exact").unwrap();
            if group.link_exists(name) {
                group.unlink(name).unwrap();
            }
            let dataset = group.new_dataset::<u64>().shape(shape);
            let dataset = dataset.create(name).unwrap();
            let ones = vec![1_u64; shape.iter().product()];
            dataset.write_raw(&ones).unwrap();
        })
    };
    let wrong = set(&bench, "path_passes", &[9]);
    assert!(
        wrong.contains("path_passes has shape [9], expected [10]"),
        "{wrong}"
    );
    let wrong = set(&bench, "path_jones", &[10, 2, 2, 2]);
    assert!(wrong.contains("path_jones"), "{wrong}");
    let wrong = set(&bench, "path_cube", &[10, 3, 3]);
    assert!(wrong.contains("path_cube holds uint64"), "{wrong}");
    let wrong = bench.spoilt(|file| {
        let cubes = file.dataset("exact/path_cube").unwrap();
        let mut normals: Vec<f64> = cubes.read_raw().unwrap();
        normals[1] += 0.5;
        cubes.write_raw(&normals).unwrap();
    });
    assert!(wrong.contains("no cube's"), "{wrong}");
    let wrong = set(&Bench::of(&sample::exact()), "path_passes", &[10]);
    assert!(wrong.contains("attribute content_hash says"), "{wrong}");
}

#[test]
fn bad_polygons_are_refused() {
    Bench::of(&sample::exact()).refuses(
        "\
count exact/polygon_start 3 18446744073709551615 | start is 18446744073709551615 at index 3
count exact/polygon_start 3 0 | dataset exact/polygon_start is 0 at index 3
count exact/polygon_start 10 39 | dataset exact/polygon_start is 39 at index 10, expected 40
count exact/path_direction 9 6 | dataset exact/path_direction is 6 at index 9
count exact/path_direction 0 3 | dataset exact/path_direction is 0 at index 1
float exact/path_matrix 2 NaN | path_matrix is NaN
float exact/polygon_vertex 2 9 | polygons of direction (0, 0) return
float exact/polygon_vertex 2 -9 | path 0 of direction 0 has a polygon
float exact/path_offset 2 9 | attribute content_hash says
unlink exact/path_weight | dataset exact/path_weight is missing
delete exact/entrance_area | attribute exact/entrance_area is missing",
    );
}

#[test]
fn bad_deviations_are_refused() {
    Bench::of(&sample::deviations(7)).refuses(
        "\
count deviation/entry_place 0 400 | entry 0 of the deviations of direction 0 has the place 400
count deviation/entry_place 1 0 | entry 1 of the deviations of direction 0 has the place 0
count deviation/entry_rays 3 0 | and 0 rays
count deviation/entry_rays 0 18446744073709551615 | rays in the cell (v, u) = (0, 0)
count deviation/entry_start 0 1 | deviation/entry_start is 1 at index 0
count deviation/entry_start 1 18446744073709551615 | deviation/entry_start
count deviation/entry_start 6 7 | deviation/entry_start
whole deviation/cells 3 | deviation cells is 3
whole deviation/cells 0 | deviation cells is 0
whole deviation/bins 18446744073709551615 | deviation bins
number deviation/range NaN | deviation range is NaN
unlink deviation/entry_rays | deviation/entry_rays",
    );
}

/// Rewriting by another program: texts of a fixed length and big-endian numbers keep the content.
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
