//! The exact bake of ten directions on one thread, histograms of 128 x 128 bins included.
//!
//! `make bench`, or `cargo bench -p bake --bench exact`

mod cells;

use bake::beams::exact::ExactCell;
use cells::{AZIMUTH_DEG, INCIDENCE_DEG, RULES, design};
use divan::{Bencher, counter::ItemsCount};
use meshes::design::Shape;

fn main() {
    divan::main();
}

/// Taking the sheet apart included.
#[divan::bench]
fn ten_directions_of_a_sheet_of_2048_cubes(bencher: Bencher) {
    let cell = cells::sheet();
    bencher
        .counter(ItemsCount::new(INCIDENCE_DEG.len()))
        .bench(|| {
            let exact = ExactCell::new(&cell).expect("two kinds of cubes");
            INCIDENCE_DEG.map(|incidence| {
                exact
                    .direction(incidence, AZIMUTH_DEG, 128, 2.0, &RULES)
                    .eta
            })
        });
}

#[divan::bench(args = ["triangular", "triangular-pair", "canted", "full-cube"])]
fn ten_directions(bencher: Bencher, name: &str) {
    let cell = design(Shape::from_name(name).expect("a design"));
    let exact = ExactCell::new(&cell).expect("planar");
    bencher
        .counter(ItemsCount::new(INCIDENCE_DEG.len()))
        .bench(|| {
            INCIDENCE_DEG.map(|incidence| {
                exact
                    .direction(incidence, AZIMUTH_DEG, 128, 2.0, &RULES)
                    .eta
            })
        });
}
