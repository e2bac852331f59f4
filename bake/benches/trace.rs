//! Benchmarks of rays: rays per second of one thread, from the dissected cell to the table.
//!
//! They measure programs, single rays, a hierarchy, and a sheet of 2,048 cubes. Tables have 32 x 32
//! bins, so that they take little of the time.
//!
//! Run them with `make bench`, or `cargo bench -p bake --bench trace`.

mod cells;

use bake::{Prepared, Request};
use cells::{bake, design, request, sheet};
use divan::{Bencher, counter::ItemsCount};
use meshes::Cell;
use meshes::design::{Design, Shape};
use tables::options::{Losses, Method, Sampler};

fn main() {
    divan::main();
}

/// Number of rays of one direction per iteration, for fast tracers.
const MANY: u64 = 1 << 19;

/// Number of rays of one direction per iteration, for slow tracers.
const FEW: u64 = 1 << 14;

/// Measures ten directions, `rays` rays each.
fn ten_directions(bencher: Bencher, cell: Cell, asked: Request) {
    let rays = asked.rays.expect("a number of rays");
    let cell = Prepared::new(cell);
    bencher
        .counter(ItemsCount::new(10 * rays))
        .bench_local(|| bake(&cell, &asked));
}

fn rays(rays: u64) -> Request {
    Request {
        method: Method::Rays,
        rays: Some(rays),
        bins: 32,
        ..request()
    }
}

#[divan::bench]
fn program_sobol_pair(bencher: Bencher) {
    ten_directions(bencher, design(Shape::TriangularPair), rays(MANY));
}

#[divan::bench]
fn program_random_pair(bencher: Bencher) {
    let asked = Request {
        sampler: Sampler::Random,
        ..rays(MANY)
    };
    ten_directions(bencher, design(Shape::TriangularPair), asked);
}

/// Measures photons, which are traced one by one.
#[divan::bench]
fn one_by_one_pair_with_losses(bencher: Bencher) {
    let asked = Request {
        losses: Losses::Fresnel,
        ..rays(FEW)
    };
    ten_directions(bencher, design(Shape::TriangularPair), asked);
}

#[divan::bench]
fn full_cube_lattice(bencher: Bencher) {
    ten_directions(bencher, design(Shape::FullCube), rays(FEW));
}

/// Measures 4,800 facets in one hierarchy; to the tracer they are planes.
#[divan::bench]
fn hierarchy_of_a_curved_pair(bencher: Bencher) {
    let design = Design {
        sag: 1e-3,
        segments: 20,
        ..Design::new(Shape::TriangularPair)
    };
    let cell = cells::cell(&design.mesh().expect("a design"));
    ten_directions(bencher, cell, rays(FEW));
}

/// Measures a sheet that is taken apart into bodies.
#[divan::bench]
fn bodies_2048_cubes(bencher: Bencher) {
    ten_directions(bencher, sheet(), rays(MANY));
}
