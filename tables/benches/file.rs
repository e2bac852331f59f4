//! Time of writing and reading tables of ten directions, 128 x 128 bins: 16 randomisations of
//! counts, or exact; and of the transform of one direction's bins at a thousand frequencies.
//!
//! Run `make bench`, or `cargo bench -p tables --bench file`.

#[path = "../tests/all/sample/mod.rs"]
mod sample;

use divan::Bencher;
use ndarray::{Array2, Array3, Array4, Array5};
use sample::Numbers;
use tables::options::{Front, Method};
use tables::{Axes, Exact, Fate, Path, Table};

fn main() {
    divan::main();
}

const BINS: usize = 128;
const DIRECTIONS: usize = 10;

fn axes() -> Axes {
    Axes {
        incidence_deg: (0..DIRECTIONS).map(|i| 5.0 * i as f64).collect(),
        azimuth_deg: vec![30.0],
        bins: BINS,
        range: 2.0,
    }
}

/// Bins that hold light: a disc of radius 1, a fifth of the histogram.
fn is_met(v: usize, u: usize) -> bool {
    let axes = axes();
    axes.bin_centre(u).hypot(axes.bin_centre(v)) < 1.0
}

/// Counts of four million rays: some tens in a bin and randomisation.
fn rays() -> Table {
    let mut numbers = Numbers(1);
    let counts = Array5::from_shape_fn((DIRECTIONS, 1, 16, BINS, BINS), |(_, _, _, v, u)| {
        if is_met(v, u) {
            40 + numbers.below(20)
        } else {
            0
        }
    });
    let fates = Array4::from_shape_fn(
        (DIRECTIONS, 1, 16, Fate::of(Front::Once, false).len()),
        |(i, a, r, fate)| {
            if fate == Fate::Retroreflected as usize {
                counts.slice(ndarray::s![i, a, r, .., ..]).sum()
            } else {
                10_000
            }
        },
    );
    Table::from_counts(axes(), counts, fates, sample::provenance())
}

fn exact() -> Table {
    let mut numbers = Numbers(2);
    let mut histogram = Array4::from_shape_fn((DIRECTIONS, 1, BINS, BINS), |(_, _, v, u)| {
        if is_met(v, u) { numbers.unit() } else { 0.0 }
    });
    for mut direction in histogram.outer_iter_mut() {
        let sum = direction.sum();
        direction.mapv_inplace(|p| p / sum);
    }
    let path = Path {
        polygon: vec![[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]],
        matrix: [[-2.0, 0.0], [0.0, -2.0]],
        offset: [0.0, 0.0],
        weight: 1.0,
        deviation: [0.0; 2],
        passes: 0,
        jones: None,
        cube: None,
    };
    let mut fate = Array3::zeros((DIRECTIONS, 1, Fate::of(Front::Once, false).len()));
    fate.slice_mut(ndarray::s![.., .., Fate::Retroreflected as usize])
        .fill(0.25);
    fate.slice_mut(ndarray::s![.., .., Fate::Missed as usize])
        .fill(0.75);
    let mut provenance = sample::provenance();
    (provenance.method, provenance.sampler) = (Method::Exact.into(), None);
    Table {
        axes: axes(),
        histogram,
        counts: None,
        retroreflected: Array2::from_elem((DIRECTIONS, 1), 0.25),
        standard_error: Array2::zeros((DIRECTIONS, 1)),
        fate,
        fate_counts: None,
        rays: Array2::zeros((DIRECTIONS, 1)),
        deviations: None,
        exact: Some(Exact {
            entrance_area: 1.0,
            paths: vec![vec![path]; DIRECTIONS],
        }),
        provenance,
        passage: None,
        errors_rad: [0.0; 3],
    }
}

fn table(kind: &str) -> Table {
    if kind == "exact" { exact() } else { rays() }
}

#[divan::bench(args = ["rays", "exact"], sample_count = 10, sample_size = 1)]
fn write(bencher: Bencher, kind: &str) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (table, file) = (table(kind), folder.path().join("table.h5"));
    bencher.bench(|| tables::write(&table, &file).expect("writes"));
}

#[divan::bench(args = ["rays", "exact"], sample_count = 10, sample_size = 1)]
fn read(bencher: Bencher, kind: &str) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("table.h5");
    tables::write(&table(kind), &file).expect("writes");
    bencher.bench(|| tables::read(&file).expect("reads"));
}

#[divan::bench(sample_count = 10)]
fn transform(bencher: Bencher) {
    let direction = rays().direction(0.0, Some(30.0)).expect("it is held");
    let kappa: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.01).collect();
    bencher.bench(|| direction.otf_and_slope_along([0.9, 0.1], &kappa));
}
