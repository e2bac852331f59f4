//! Rays of rough facets side by side against single rays, ray for ray, on every instruction set.

use crate::geometry::{Launch, Stream};
use crate::optics::Rules;
use crate::rays::{Accumulator, Bins, Index, InstructionSet, Kernel, Scene, Sheet};
use crate::tests::bakes::compare;
use crate::tests::rays::kernels::patch;
use crate::tests::{bakes, cells};
use meshes::Cell;
use std::sync::Arc;
use tables::deviation::Grid;
use tables::options::{Element, Roughness, Sampler, Slopes};

/// Number of rays of a case, and of the rays that are compared at a time.
///
/// A run begins and ends within a vector.
const RAYS: u64 = 20_000;
const SOME: u64 = 100;

fn rules(slopes: Slopes, alpha: f64) -> Rules {
    Rules {
        angular_tolerance_rad: 0.05,
        roughness: Some(Roughness::new(slopes, alpha).expect("a roughness")),
        ..Rules::mirrors(1.0)
    }
}

/// Every ray has the fate, the shift and the exit direction that it has alone: in a cube, in a pair
/// of cubes and in a sheet of unlike scenes, for smooth to very rough facets, mirrors and total
/// reflection, from the normal to grazing incidence.
#[test]
fn flights_equal_single_rays_ray_for_ray() {
    let bins = Bins::new(32, 1.0);
    let grid = Grid {
        cells: 8,
        bins: 33,
        range: 0.02,
    };
    let (mut cases, mut fates) = (0, [0_u64; tables::Fate::ALL.len()]);
    for cell in [cells::triangular(), cells::pair()] {
        for (slopes, alpha) in [
            (Slopes::Beckmann, 1e-3),
            (Slopes::Beckmann, 0.3),
            (Slopes::Ggx, 2e-3),
        ] {
            let mirrors = rules(slopes, alpha);
            let solid = Rules {
                refractive_index: 1.49,
                mirror_back: false,
                ..mirrors
            };
            for rules in [mirrors, solid] {
                for (incidence, azimuth) in [
                    (0.0, 0.0),
                    (20.0, 17.0),
                    (45.0, 60.0),
                    (80.0, 130.0),
                    (89.9, 5.0),
                ] {
                    let scene = Arc::new(Scene::new(&cell, Index::Loop));
                    let launch = Launch::new(&cell.entrance);
                    let kernel = Kernel::new(&scene, &launch, &rules, &bins, incidence, azimuth)
                        .recording(Some(grid));
                    let sampler = match azimuth {
                        17.0 => Sampler::Random,
                        _ => Sampler::Sobol,
                    };
                    let stream = Stream::new(sampler, 3, incidence, azimuth, 0);
                    assert!(kernel.flies());
                    for first in (5..RAYS + 5).step_by(SOME as usize) {
                        let accumulator = compare(&kernel, &bins, &stream, first..first + SOME);
                        for (sum, count) in fates.iter_mut().zip(accumulator.fates) {
                            *sum += count;
                        }
                    }
                    cases += 1;
                }
            }
        }
    }
    let rays: u64 = fates.iter().sum();
    println!("{cases} cases, {rays} rays, by fate {fates:?}");
    assert_eq!((cases, rays), (60, 60 * RAYS));
    let met = fates.iter().filter(|&&count| count > 0).count();
    assert!(met >= 8, "{met} fates of {fates:?}");
}

/// Every instruction set gives the same counts, also for a sheet whose cubes are scenes of their
/// own and for a plate.
#[test]
fn flights_agree_on_all_instruction_sets() {
    let bins = Bins::new(64, 1.0);
    let sheets: [(Cell, Element); 2] = [
        (patch(7, 5), Element::Retroreflector),
        (cells::triangular(), Element::Plate),
    ];
    let (mut cases, mut scenes) = (0, 0);
    for (cell, element) in sheets {
        for slopes in [Slopes::Beckmann, Slopes::Ggx] {
            let rules = Rules {
                element,
                ..rules(slopes, 0.01)
            };
            let prepared = bakes::prepared(&cell);
            let sheet = Sheet::new(&prepared, Index::Auto);
            scenes = scenes.max(sheet.scenes.len());
            let stream = Stream::new(Sampler::Sobol, 9, 30.0, 10.0, 0);
            let counts = InstructionSet::available().into_iter().map(|set| {
                let kernel = Kernel::over(&sheet, &rules, &bins, 30.0, 10.0).on(set);
                compare(&kernel, &bins, &stream, 0..30_000)
            });
            let counts: Vec<Accumulator> = counts.collect();
            assert!(counts.iter().all(|accumulator| *accumulator == counts[0]));
            cases += counts.len();
        }
    }
    println!("{cases} runs, {scenes} scenes");
    assert!(scenes > 1, "the patch is taken apart");
    assert_eq!(cases, 4 * InstructionSet::available().len());
}
