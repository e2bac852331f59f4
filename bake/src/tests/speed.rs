//! Rays per second of each tracer and each instruction set, and the number of facets at which the
//! hierarchy overtakes the loop.
//!
//! `cargo test --release -p bake --lib speed -- --ignored --nocapture`

use crate::optics::Rules;
use crate::rays::{Batch, Bins, Index, InstructionSet, Kernel, Scene, Tally};
use crate::samples::{Launch, Stream};
use glam::{DVec2, DVec3};
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Entrance, normalise};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use tables::options::Sampler;

const RULES: Rules = Rules::mirrors(1.0);

#[test]
#[ignore = "figures, a minute: rays per second"]
fn speed() -> Result<(), Box<dyn Error>> {
    let bins = Bins::new(128, 2.0);
    let cube = cell(Shape::Triangular)?;
    for (name, cell) in [
        ("cube", cube.clone()),
        ("pair", cell(Shape::TriangularPair)?),
    ] {
        for sampler in [Sampler::Sobol, Sampler::Random] {
            for set in InstructionSet::available() {
                let speed = fast(&cell, &bins, sampler, set)?;
                println!(
                    "program, {name}, {}, {set:?}: {speed:.1} million rays/s on 1 thread",
                    sampler.name()
                );
            }
        }
    }
    println!(
        "one by one, cube, loop: {:.2} million rays/s on 1 thread",
        slow(&cube, &bins, Index::Loop)
    );
    let full = cell(Shape::FullCube)?;
    println!(
        "one by one, periodic full cube, loop: {:.2}",
        slow(&full, &bins, Index::Loop)
    );
    println!(
        "one by one, periodic full cube, hierarchy: {:.2}",
        slow(&full, &bins, Index::Hierarchy)
    );
    for side in [2_usize, 3, 4, 6, 32] {
        let tiled = tiled(&cell(Shape::TriangularPair)?, side);
        let facets = tiled.facets.len();
        let hierarchy = slow(&tiled, &bins, Index::Hierarchy);
        let plain = if facets < 500 {
            slow(&tiled, &bins, Index::Loop)
        } else {
            f64::NAN
        };
        println!(
            "{facets} facets: bundles {:.2}, hierarchy {hierarchy:.2}, loop {plain:.2} \
             million rays/s on 1 thread",
            bundles(&tiled, &bins)
        );
    }
    Ok(())
}

/// Returns the time that this thread has had a processor, s. On a shared machine the clock on the
/// wall also counts other programs.
fn busy_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds: Option<f64> = text
        .split_whitespace()
        .next()
        .and_then(|word| word.parse().ok());
    nanoseconds.unwrap_or(f64::NAN) * 1e-9
}

fn cell(shape: Shape) -> Result<Cell, Box<dyn Error>> {
    Ok(normalise(
        &Design::new(shape).mesh()?,
        Path::new("design"),
        &CellOptions::default(),
    )?)
}

/// Returns `side` x `side` copies of a cell whose entrance is a parallelogram.
fn tiled(cell: &Cell, side: usize) -> Cell {
    let [a, b, _, d] = cell.entrance.polygon[..] else {
        return cell.clone();
    };
    let (right, up) = (b - a, d - a);
    let copies = (0..side * side).map(|k| right * (k % side) as f64 + up * (k / side) as f64);
    let facets = copies
        .flat_map(|offset: DVec2| {
            cell.facets
                .iter()
                .map(move |f| f.map(|p: DVec3| p + offset.extend(0.0)))
        })
        .collect();
    let size = side as f64;
    let polygon = vec![a, a + right * size, a + (right + up) * size, a + up * size];
    Cell {
        facets,
        entrance: Entrance {
            polygon,
            ..cell.entrance.clone()
        },
        ..cell.clone()
    }
}

fn fast(
    cell: &Cell,
    bins: &Bins,
    sampler: Sampler,
    set: InstructionSet,
) -> Result<f64, Box<dyn Error>> {
    let scene = Arc::new(Scene::new(cell, Index::Auto));
    let launch = Launch::new(&cell.entrance);
    let mut tally = Tally::new(bins);
    let run = 1_u64 << 18;
    let mut seconds = 0.0;
    let angles = [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0];
    let mut rays = 0;
    for incidence in angles {
        let kernel = Kernel::new(&scene, &launch, &RULES, bins, incidence, 0.0);
        let [program] = kernel.programs() else {
            return Err("no program for this cell".into());
        };
        if set == InstructionSet::best() && sampler == Sampler::Sobol {
            println!(
                "  {incidence} deg: {} steps, {} tests, {} maps",
                program.steps.len(),
                program.tests.len(),
                program.maps.len()
            );
        }
        let stream = Stream::new(sampler, 1, incidence, 0.0, 0);
        for part in 0..8 {
            let start = busy_seconds();
            let batch = Batch {
                programs: kernel.programs(),
                launch: &launch,
                bins,
                stream: &stream,
                samples: part * run..(part + 1) * run,
                exits: None,
            };
            batch.trace(set, &mut tally);
            if part > 0 {
                seconds += busy_seconds() - start;
                rays += run;
            }
        }
    }
    Ok(rays as f64 / seconds / 1e6)
}

/// Returns the speed of tracing the whole mesh in bundles, not taken apart into bodies, million
/// rays/s.
fn bundles(cell: &Cell, bins: &Bins) -> f64 {
    let scene = Arc::new(Scene::new(cell, Index::Hierarchy));
    let launch = Launch::new(&cell.entrance);
    let mut tally = Tally::new(bins);
    let (mut seconds, mut rays) = (0.0, 0);
    for incidence in [0.0, 20.0, 40.0] {
        let kernel = Kernel::new(&scene, &launch, &RULES, bins, incidence, 0.0);
        if !kernel.programs().is_empty() {
            return f64::NAN;
        }
        let stream = Stream::new(Sampler::Sobol, 1, incidence, 0.0, 0);
        let run = 1 << 18;
        let start = busy_seconds();
        kernel.trace(&stream, 0..run, &mut tally);
        seconds += busy_seconds() - start;
        rays += run;
    }
    rays as f64 / seconds / 1e6
}

fn slow(cell: &Cell, bins: &Bins, index: Index) -> f64 {
    let scene = Arc::new(Scene::new(cell, index));
    let launch = Launch::new(&cell.entrance);
    let mut tally = Tally::new(bins);
    let (mut seconds, mut rays) = (0.0, 0);
    for incidence in [0.0, 20.0, 40.0] {
        let kernel = Kernel::new(&scene, &launch, &RULES, bins, incidence, 0.0);
        let stream = Stream::new(Sampler::Sobol, 1, incidence, 0.0, 0);
        let run = if scene.facets().len() > 100 && !scene.has_hierarchy() {
            20_000
        } else {
            200_000
        };
        let start = busy_seconds();
        kernel.trace_one_by_one(&stream, 0..run, &mut tally);
        seconds += busy_seconds() - start;
        rays += run;
    }
    rays as f64 / seconds / 1e6
}
