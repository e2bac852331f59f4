//! Benchmarks of the exact bake: ten directions on one thread.
//!
//! They include histograms of 128 x 128 bins and the making of the table. Run them with `make
//! bench`, or `cargo bench -p bake --bench exact`.

mod cells;

use bake::{Prepared, Request};
use cells::{bake, design, request};
use divan::{Bencher, counter::ItemsCount};
use meshes::design::Shape;
use tables::options::Method;

fn main() {
    divan::main();
}

fn exactly() -> Request {
    Request {
        method: Method::Exact,
        ..request()
    }
}

/// Measures a whole bake, which takes the sheet apart first.
#[divan::bench]
fn ten_directions_of_a_sheet_of_2048_cubes(bencher: Bencher) {
    let cell = cells::sheet();
    bencher
        .counter(ItemsCount::new(10_usize))
        .bench(|| bake(&Prepared::new(cell.clone()), &exactly()));
}

#[divan::bench(args = ["triangular", "triangular-pair", "canted", "full-cube"])]
fn ten_directions(bencher: Bencher, name: &str) {
    let cell = Prepared::new(design(Shape::from_name(name).expect("a design")));
    bencher
        .counter(ItemsCount::new(10_usize))
        .bench(|| bake(&cell, &exactly()));
}
