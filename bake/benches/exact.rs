//! Benchmarks of the exact bake: ten directions on one thread.
//!
//! They include histograms of 128 x 128 bins and the making of the table. Run them with `make
//! bench`, or `cargo bench -p bake --bench exact`.

mod cells;

use bake::{Prepared, Request};
use cells::{bake, design, request};
use divan::{Bencher, counter::ItemsCount};
use meshes::design::Shape;
use tables::WaveLine;
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

/// Measures one value of the OTF by wave optics, which a fit evaluates ten thousand times.
#[divan::bench]
fn a_value_of_the_wave_otf(bencher: Bencher) {
    let table = bake(&Prepared::new(design(Shape::TriangularPair)), &exactly());
    let (incidence_deg, azimuth_deg) = (table.axes.incidence_deg[4], table.axes.azimuth_deg[0]);
    let direction = table
        .direction(incidence_deg, Some(azimuth_deg))
        .expect("the table holds the direction");
    let line = WaveLine::new(
        &direction,
        incidence_deg.to_radians(),
        [0.8, 0.6],
        &[(550.0, 1.0)],
    )
    .expect("ideal cubes have waves");
    bencher.bench(|| line.otf(0.2, 150.0, divan::black_box(1.0)));
}
