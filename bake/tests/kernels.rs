//! The fast kernel against the plain tracer, ray for ray, and against itself on every instruction set.

mod cells;

use bake::kernel::Kernel;
use bake::launch::Launch;
use bake::path::Rules;
use bake::scene::{Index, Scene};
use bake::sequence::{Sampler, Stream};
use bake::simd::InstructionSet;
use bake::tally::{Bins, Tally};
use glam::DVec3;
use meshes::Cell;
use std::sync::Arc;

const MIRROR: Rules = Rules {
    refractive_index: 1.0,
    mirror_back: true,
    angular_tolerance_rad: 0.009,
};

/// A cube whose first edge is bent: dihedral errors of some mrad, six different maps.
fn bent() -> Cell {
    let mut cell = cells::triangular();
    let mut ends = cells::edges(0.0);
    ends[0] = (ends[0] + DVec3::new(0.001, 0.002, 0.0)).normalize();
    ends[0] *= cells::HEIGHT / ends[0].z;
    cell.facets = cells::faces(DVec3::ZERO, ends);
    cell.entrance.polygon = ends.map(|end| end.truncate()).to_vec();
    cell
}

/// Fates and bins of the program are those of the tracer, for every cell, direction, sampler and back.
#[test]
fn program_equals_tracer_ray_for_ray() {
    let bins = Bins::new(32, 1.0);
    let tir = Rules {
        refractive_index: 1.49,
        mirror_back: false,
        ..MIRROR
    };
    // Enough for a block that is traced cell by cell, and for what lies before and after it.
    let (first, rays) = ((1 << 15) - 5, 40_000);
    let (mut directions, mut maps) = (0, 0);
    for cell in [cells::triangular(), cells::pair(), bent()] {
        let scene = Arc::new(Scene::new(&cell, Index::Loop));
        let launch = Launch::new(&cell.entrance);
        for rules in [MIRROR, tir] {
            for incidence in [0.0, 5.0, 20.0, 35.0, 36.0, 45.0, 54.8, 70.0, 89.9] {
                for azimuth in [0.0, 17.0, 60.0, 130.0] {
                    let kernel = Kernel::new(&scene, &launch, &rules, &bins, incidence, azimuth);
                    let program = kernel.program().expect("a small planar cell");
                    maps = maps.max(program.maps.len());
                    let sampler = if azimuth == 17.0 {
                        Sampler::Random
                    } else {
                        Sampler::Sobol
                    };
                    let stream = Stream::new(sampler, 3, incidence, azimuth, 0);
                    let (mut fast, mut plain) = (Tally::new(&bins), Tally::new(&bins));
                    kernel.trace(&stream, first..first + rays, &mut fast);
                    kernel.trace_one_by_one(&stream, first..first + rays, &mut plain);
                    assert_eq!(
                        fast.fates, plain.fates,
                        "{} at ({incidence}, {azimuth})",
                        cell.design
                    );
                    let inside = bins.len();
                    assert!(
                        fast.histogram[..inside] == plain.histogram[..inside],
                        "bins at ({incidence}, {azimuth})"
                    );
                    assert_eq!(fast.fates.iter().sum::<u64>(), rays);
                    directions += 1;
                }
            }
        }
    }
    assert_eq!(directions, 3 * 2 * 9 * 4);
    assert!(maps >= 6, "a bent cube has a map per sequence, got {maps}");
}

/// Bit for bit the same counts on every instruction set of this processor.
#[test]
fn instruction_sets_agree_bit_for_bit() {
    let bins = Bins::new(64, 1.5);
    let mut compared = 0;
    for cell in [cells::pair(), bent()] {
        let scene = Arc::new(Scene::new(&cell, Index::Loop));
        let launch = Launch::new(&cell.entrance);
        for sampler in [Sampler::Random, Sampler::Sobol] {
            let kernel = Kernel::new(&scene, &launch, &MIRROR, &bins, 12.0, 40.0);
            let program = kernel.program().expect("a small planar cell");
            let stream = Stream::new(sampler, 9, 12.0, 40.0, 1);
            let counts: Vec<Tally> = InstructionSet::available()
                .into_iter()
                .map(|set| {
                    let mut tally = Tally::new(&bins);
                    set.run(program, &launch, &bins, &stream, 0..100_003, &mut tally);
                    tally
                })
                .collect();
            assert!(counts.iter().all(|tally| *tally == counts[0]));
            compared += counts.len();
        }
    }
    assert!(compared >= 4);
    println!(
        "{compared} runs compared over {:?}",
        InstructionSet::available()
    );
}

/// A hierarchy, a loop and the program find the same hits.
#[test]
fn hierarchy_equals_loop() {
    let bins = Bins::new(32, 1.0);
    let mut compared = 0;
    for cell in [cells::pair(), bent(), cells::full_cube()] {
        let launch = Launch::new(&cell.entrance);
        let scenes =
            [Index::Loop, Index::Hierarchy].map(|index| Arc::new(Scene::new(&cell, index)));
        assert!(scenes[1].has_hierarchy());
        for incidence in [0.0, 20.0, 60.0, 89.0] {
            let stream = Stream::new(Sampler::Random, 4, incidence, 10.0, 0);
            let [a, b] = scenes.each_ref().map(|scene| {
                let kernel = Kernel::new(scene, &launch, &MIRROR, &bins, incidence, 10.0);
                let mut tally = Tally::new(&bins);
                kernel.trace_one_by_one(&stream, 0..5_000, &mut tally);
                tally
            });
            assert!(a == b, "{} at {incidence}", cell.design);
            compared += 1;
        }
    }
    assert_eq!(compared, 12);
}
