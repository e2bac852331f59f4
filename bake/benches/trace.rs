//! Rays per second of one thread: programs, one by one, and a sheet of 2,048 cubes.
//!
//! `make bench`, or `cargo bench -p bake --bench trace`

mod cells;

use bake::rays::kernel::Kernel;
use bake::rays::scene::{Index, Scene};
use bake::rays::sheet::Sheet;
use bake::rays::tally::{Bins, Tally};
use bake::samples::launch::Launch;
use bake::samples::sequence::{Sampler, Stream};
use cells::{AZIMUTH_DEG, INCIDENCE_DEG, RULES, design, sheet};
use divan::{Bencher, counter::ItemsCount};
use meshes::Cell;
use meshes::design::Shape;
use std::sync::Arc;

fn main() {
    divan::main();
}

/// Rays of one direction per iteration.
const PROGRAM_RAYS: u64 = 1 << 16;
const SINGLE_RAYS: u64 = 1 << 11;

/// Measures `trace` over ten directions of `kernels`, `rays` rays each.
fn ten_directions(
    bencher: Bencher,
    kernels: Vec<Kernel>,
    sampler: Sampler,
    rays: u64,
    trace: impl Fn(&Kernel, &Stream, &mut Tally) + Sync,
) {
    let streams = INCIDENCE_DEG.map(|incidence| Stream::new(sampler, 1, incidence, AZIMUTH_DEG, 0));
    let mut tally = Tally::new(&bins());
    bencher
        .counter(ItemsCount::new(rays * INCIDENCE_DEG.len() as u64))
        .bench_local(|| {
            tally.clear();
            for (kernel, stream) in kernels.iter().zip(&streams) {
                trace(kernel, stream, &mut tally);
            }
            divan::black_box(&tally.fates);
        });
}

fn bins() -> Bins {
    Bins::new(128, 2.0)
}

fn kernels(cell: &Cell, index: Index) -> Vec<Kernel> {
    let scene = Arc::new(Scene::new(cell, index));
    let launch = Launch::new(&cell.entrance);
    let kernel = |&incidence| Kernel::new(&scene, &launch, &RULES, &bins(), incidence, AZIMUTH_DEG);
    INCIDENCE_DEG.iter().map(kernel).collect()
}

#[divan::bench]
fn program_sobol_pair(bencher: Bencher) {
    let kernels = kernels(&design(Shape::TriangularPair), Index::Auto);
    ten_directions(
        bencher,
        kernels,
        Sampler::Sobol,
        PROGRAM_RAYS,
        |kernel, stream, tally| {
            kernel.trace(stream, 0..PROGRAM_RAYS, tally);
        },
    );
}

#[divan::bench]
fn program_random_pair(bencher: Bencher) {
    let kernels = kernels(&design(Shape::TriangularPair), Index::Auto);
    ten_directions(
        bencher,
        kernels,
        Sampler::Random,
        PROGRAM_RAYS,
        |kernel, stream, tally| {
            kernel.trace(stream, 0..PROGRAM_RAYS, tally);
        },
    );
}

#[divan::bench]
fn one_by_one_pair(bencher: Bencher) {
    let kernels = kernels(&design(Shape::TriangularPair), Index::Auto);
    ten_directions(
        bencher,
        kernels,
        Sampler::Sobol,
        SINGLE_RAYS,
        |kernel, stream, tally| {
            kernel.trace_one_by_one(stream, 0..SINGLE_RAYS, tally);
        },
    );
}

#[divan::bench]
fn one_by_one_full_cube_lattice(bencher: Bencher) {
    let kernels = kernels(&design(Shape::FullCube), Index::Auto);
    ten_directions(
        bencher,
        kernels,
        Sampler::Sobol,
        SINGLE_RAYS,
        |kernel, stream, tally| {
            kernel.trace_one_by_one(stream, 0..SINGLE_RAYS, tally);
        },
    );
}

/// 12,288 facets in one hierarchy.
#[divan::bench]
fn hierarchy_2048_cubes(bencher: Bencher) {
    let kernels = kernels(&sheet(), Index::Hierarchy);
    ten_directions(
        bencher,
        kernels,
        Sampler::Sobol,
        SINGLE_RAYS,
        |kernel, stream, tally| {
            kernel.trace_one_by_one(stream, 0..SINGLE_RAYS, tally);
        },
    );
}

/// The same sheet taken apart into bodies, as `bake trace` does.
#[divan::bench]
fn bodies_2048_cubes(bencher: Bencher) {
    let sheet = Sheet::new(&sheet(), Index::Auto);
    assert_eq!(
        sheet.scenes.len(),
        2,
        "a cube and its copy turned by 180 degrees"
    );
    let kernel = |&incidence| Kernel::over(&sheet, &RULES, &bins(), incidence, AZIMUTH_DEG);
    let kernels = INCIDENCE_DEG.iter().map(kernel).collect();
    ten_directions(
        bencher,
        kernels,
        Sampler::Sobol,
        PROGRAM_RAYS,
        |kernel, stream, tally| {
            kernel.trace(stream, 0..PROGRAM_RAYS, tally);
        },
    );
}
