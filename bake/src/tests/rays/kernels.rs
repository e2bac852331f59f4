//! The fast kernel against the plain tracer, ray for ray, and against itself on every instruction
//! set.

use crate::tests::bakes;
use crate::tests::bakes::compare;
use crate::tests::cells;

use crate::cell::Whole;
use crate::geometry::{Launch, Stream};
use crate::optics::{Backing, Incidence, Rules};
use crate::rays::{
    Accumulator, Batch, Bins, End, Index, InstructionSet, Kernel, Program, Scene, Sheet, trace,
};
use glam::DVec3;
use meshes::design::{Design, Shape};
use meshes::{Cell, Entrance};
use std::collections::HashSet;
use std::sync::Arc;
use tables::deviation::Grid;
use tables::options::Sampler;

const MIRROR: Rules = Rules {
    angular_tolerance_rad: 0.009,
    ..Rules::mirrors(1.0)
};

/// Returns a cube whose first edge is bent: dihedral errors of some mrad and six different maps.
fn bent() -> Cell {
    let mut cell = cells::triangular();
    let mut ends = cells::edges(0.0);
    ends[0] = (ends[0] + DVec3::new(0.001, 0.002, 0.0)).normalize();
    ends[0] *= cells::HEIGHT / ends[0].z;
    cell.facets = cells::faces(DVec3::ZERO, ends);
    cell.entrance.polygon = ends.map(|end| end.truncate()).to_vec();
    cell
}

/// The fates and bins of the program are those of the tracer, for every cell, direction, sampler
/// and kind of back.
#[test]
fn program_equals_tracer_ray_for_ray() {
    let bins = Bins::new(32, 1.0);
    let tir = Rules {
        refractive_index: 1.49,
        mirror_back: false,
        ..MIRROR
    };
    // The number of rays is enough for a block that is traced cell by cell, and for the rays before
    // and after the block.
    let (first, rays) = ((1 << 15) - 5, 40_000);
    let (mut directions, mut maps) = (0, 0);
    for cell in [cells::triangular(), cells::pair(), bent()] {
        let scene = Arc::new(Scene::new(&cell, Index::Loop));
        let launch = Launch::new(&cell.entrance);
        for rules in [MIRROR, tir] {
            for incidence in [0.0, 5.0, 20.0, 35.0, 36.0, 45.0, 54.8, 70.0, 89.9] {
                for azimuth in [0.0, 17.0, 60.0, 130.0] {
                    let kernel = Kernel::new(&scene, &launch, &rules, &bins, incidence, azimuth);
                    let [program] = kernel.programs() else {
                        panic!("a small planar cell has a program")
                    };
                    maps = maps.max(program.maps.len());
                    assert!(counts_every_ray_once(program), "{incidence} {azimuth}");
                    let sampler = if azimuth == 17.0 {
                        Sampler::Random
                    } else {
                        Sampler::Sobol
                    };
                    let stream = Stream::new(sampler, 3, incidence, azimuth, 0);
                    compare(&kernel, &bins, &stream, first..first + rays);
                    directions += 1;
                }
            }
        }
    }
    assert_eq!(directions, 3 * 2 * 9 * 4);
    assert!(maps >= 6, "a bent cube has a map per sequence, got {maps}");
}

/// Periodic cells have programs too, which hold every copy of a facet that a ray can meet.
///
/// The cells are full cubes that are ideal, have errors, and have their top corners cut off. Some
/// directions have no program, because light runs far along the sheet.
#[test]
fn periodic_programs_equal_the_tracer_ray_for_ray() {
    let bins = Bins::new(32, 2.0);
    let solid = Rules {
        refractive_index: 1.49,
        ..MIRROR
    };
    let ideal = Design::new(Shape::FullCube);
    let uneven = Design {
        dihedral_error_rad: [5e-4, 0.0, -3e-4],
        ..ideal
    };
    let truncated = Design {
        truncation: 0.2,
        ..ideal
    };
    let rays = 5_000;
    let (mut directions, mut programs) = (0, 0);
    for cell in [ideal, uneven, truncated].map(|design| cells::designed(&design)) {
        let scene = Arc::new(Scene::new(&cell, Index::Loop));
        assert!(scene.is_periodic());
        let launch = Launch::new(&cell.entrance);
        for rules in [MIRROR, solid] {
            for incidence in [0.0, 8.0, 20.0, 30.0, 45.0, 60.0, 80.0, 89.9] {
                for azimuth in [0.0, 7.0, 30.0, 100.0] {
                    let kernel = Kernel::new(&scene, &launch, &rules, &bins, incidence, azimuth);
                    directions += 1;
                    let [program] = kernel.programs() else {
                        continue;
                    };
                    programs += 1;
                    assert!(counts_every_ray_once(program), "{incidence} {azimuth}");
                    let stream = Stream::new(Sampler::Sobol, 3, incidence, azimuth, 0);
                    compare(&kernel, &bins, &stream, 0..rays);
                }
            }
        }
    }
    println!("{programs} of {directions} directions have a program");
    assert!(directions == 3 * 2 * 8 * 4 && programs > directions * 3 / 4);
}

/// The counts are equal, bit for bit, on every instruction set of this processor.
#[test]
fn instruction_sets_agree_bit_for_bit() {
    let bins = Bins::new(64, 1.5);
    let mut compared = 0;
    for cell in [cells::pair(), bent()] {
        let scene = Arc::new(Scene::new(&cell, Index::Loop));
        let launch = Launch::new(&cell.entrance);
        for sampler in [Sampler::Random, Sampler::Sobol] {
            let kernel = Kernel::new(&scene, &launch, &MIRROR, &bins, 12.0, 40.0);
            assert_eq!(kernel.programs().len(), 1, "a small planar cell");
            let stream = Stream::new(sampler, 9, 12.0, 40.0, 1);
            let counts: Vec<Accumulator> = InstructionSet::available()
                .into_iter()
                .map(|set| {
                    let mut accumulator = Accumulator::new(&bins);
                    let batch = Batch {
                        programs: kernel.programs(),
                        launch: &launch,
                        bins: &bins,
                        stream: &stream,
                        samples: 0..100_003,
                        exits: None,
                    };
                    batch.trace(set, &mut accumulator);
                    accumulator
                })
                .collect();
            assert!(counts.iter().all(|accumulator| *accumulator == counts[0]));
            compared += counts.len();
        }
    }
    assert!(compared >= 4);
    println!(
        "{compared} runs compared over {:?}",
        InstructionSet::available()
    );
}

/// Returns whether every node of a program ends with a step that takes all rays that are left, and
/// has no other such step. Then every ray is counted once, wherever it enters.
fn counts_every_ray_once(program: &Program) -> bool {
    // The entry at each depth says whether the node that is open there has had its last step.
    let mut ended = vec![false];
    program.steps.iter().all(|step| {
        let deeper = ended.drain(step.from + 1..).all(|ended| ended);
        let open = !ended[step.from];
        ended[step.from] = step.tests.0 == step.tests.1;
        if step.end == End::Onward {
            ended.push(false);
        }
        deeper && open
    }) && ended.iter().all(|&ended| ended)
}

/// No ray counts twice if the entrance reaches over a side of the cube's rim by about the width of
/// rounding. No test sees the strip beside the last facet; it must not be a second end for all
/// rays.
#[test]
fn a_strip_of_rounding_counts_no_ray_twice() {
    let bins = Bins::new(32, 1.5);
    let mut cases = 0;
    for (side, decade) in [0, 1, 2]
        .into_iter()
        .flat_map(|s| (-15..=-9).map(move |d| (s, d)))
    {
        for incidence in [0.0, 13.0, 40.0] {
            let mut cell = cells::triangular();
            let corners = &mut cell.entrance.polygon;
            let outward = -corners[(side + 2) % 3].normalize() * 10_f64.powi(decade);
            corners[side] += outward;
            corners[(side + 1) % 3] += outward;
            let scene = Arc::new(Scene::new(&cell, Index::Loop));
            let launch = Launch::new(&cell.entrance);
            let kernel = Kernel::new(&scene, &launch, &MIRROR, &bins, incidence, 20.0);
            let [program] = kernel.programs() else {
                panic!("a small planar cell has a program")
            };
            assert!(
                counts_every_ray_once(program),
                "{side} {decade} {incidence}"
            );
            let stream = Stream::new(Sampler::Random, 12, incidence, 20.0, 0);
            compare(&kernel, &bins, &stream, 0..5_000);
            cases += 1;
        }
    }
    assert_eq!(cases, 3 * 7 * 3);
}

/// A hierarchy, a loop and the program find equal hits.
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
                let mut accumulator = Accumulator::new(&bins);
                kernel.trace_one_by_one(&stream, 0..5_000, &mut accumulator);
                accumulator
            });
            assert!(a == b, "{} at {incidence}", cell.design);
            compared += 1;
        }
    }
    assert_eq!(compared, 12);
}

/// Returns a parallelogram of `columns` x `rows` pairs of cubes, welded along the rims.
pub(crate) fn patch(columns: usize, rows: usize) -> Cell {
    let pair = cells::pair();
    let [a, b, _, d] = pair.entrance.polygon[..] else {
        panic!("the pair's entrance is a parallelogram")
    };
    let (right, up) = (b - a, d - a);
    let place = |p: DVec3, i: usize, j: usize| {
        let offset = right * i as f64 + up * j as f64;
        p + offset.extend(0.0)
    };
    let mut known: Vec<DVec3> = Vec::new();
    let mut weld = |p: DVec3| match known.iter().find(|q| q.distance(p) < 1e-9) {
        Some(&q) => q,
        None => {
            known.push(p);
            p
        }
    };
    let mut facets = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            facets.extend(
                pair.facets
                    .iter()
                    .map(|facet| facet.map(|p| weld(place(p, i, j)))),
            );
        }
    }
    let (right, up) = (right * columns as f64, up * rows as f64);
    Cell {
        facets,
        entrance: Entrance {
            polygon: vec![a, a + right, a + right + up, a + up],
            ..pair.entrance.clone()
        },
        ..pair
    }
}

/// A patch of 120 pairs falls into two kinds of cubes. One cube of each kind gives, ray for ray,
/// the outcomes of the whole mesh by the hierarchy and, for fewer rays, by the loop over all its
/// facets. The body of its kind that a ray of the whole enters is chosen at random.
#[test]
fn bodies_equal_the_whole_mesh_ray_for_ray() {
    let cell = patch(12, 10);
    let kinds = bakes::kinds(&cell).expect("a patch of cubes");
    assert_eq!(
        kinds
            .iter()
            .map(|kind| kind.places.len())
            .collect::<Vec<_>>(),
        [120, 120]
    );
    let sheet = Sheet::new(&bakes::prepared(&cell), Index::Auto);
    assert_eq!(sheet.scenes.len(), 2);
    let wholes = [Index::Hierarchy, Index::Loop].map(|index| Scene::new(&cell, index));
    let bins = Bins::new(32, 1.5);
    let tir = Rules {
        refractive_index: 1.49,
        mirror_back: false,
        ..MIRROR
    };
    let (first, rays) = ((1 << 15) - 5, 40_000_u64);
    let mut entered = vec![[false; 2]; 120];
    let mut compared = 0;
    for (incidence, azimuth) in [
        (0.0, 0.0),
        (11.0, 200.0),
        (20.0, 0.0),
        (34.0, 75.0),
        (54.0, 60.0),
        (80.0, 33.0),
    ] {
        for sampler in [Sampler::Random, Sampler::Sobol] {
            for rules in [MIRROR, tir] {
                let kernel = Kernel::over(&sheet, &rules, &bins, incidence, azimuth);
                assert_eq!(kernel.programs().len(), 2, "one program per kind");
                let stream = Stream::new(sampler, 5, incidence, azimuth, 0);
                let choices = Stream::new(Sampler::Random, 6, incidence, azimuth, 0);
                let angles = [incidence, azimuth].map(f64::to_radians);
                let direction = Incidence::new(angles[0], angles[1], rules.refractive_index);
                for (whole, rays) in wholes.iter().zip([rays, 500]) {
                    let (mut parts, mut all) = (Accumulator::new(&bins), Accumulator::new(&bins));
                    kernel.trace(&stream, first..first + rays, &mut parts);
                    for index in first..first + rays {
                        let (kind, point) = sheet.launch.entry(&stream, index);
                        let choice = choices.pair(index)[0] as usize % 120;
                        entered[choice][kind] = true;
                        let point = point + kinds[kind].places[choice];
                        all.count(&bins, &trace(whole, &rules, &direction, point, 0.5));
                    }
                    assert_eq!(parts.fates, all.fates, "at ({incidence}, {azimuth})");
                    let size = bins.len();
                    assert!(parts.histogram[..size] == all.histogram[..size]);
                    assert_eq!(parts.fates.iter().sum::<u64>(), rays);
                    compared += rays;
                }
            }
        }
    }
    assert_eq!(compared, 6 * 2 * 2 * 40_500);
    assert!(entered.iter().flatten().all(|&entered| entered));
}

/// A cell that is not a set of separate bodies is traced as a whole.
#[test]
fn what_is_no_set_of_bodies_is_left_whole() {
    let cell = patch(3, 3);
    assert!(bakes::kinds(&cell).is_ok());
    let spoilt = |spoil: &dyn Fn(&mut Cell)| {
        let mut cell = cell.clone();
        spoil(&mut cell);
        bakes::kinds(&cell).err()
    };
    let rims = |cell: &mut Cell, change: &dyn Fn(&mut DVec3)| {
        let corner = cell.facets[0][1];
        let corners = cell.facets.iter_mut().flatten();
        corners.filter(|p| **p == corner).for_each(change);
    };
    let cases = [
        spoilt(&|cell| cell.entrance.lattice = Some([glam::DVec2::X, glam::DVec2::Y])),
        // A facet is missing: there is a hole below the entrance plane.
        spoilt(&|cell| cell.facets.truncate(cell.facets.len() - 1)),
        // A facet occurs twice.
        spoilt(&|cell| cell.facets.push(cell.facets[0])),
        // A facet is turned over.
        spoilt(&|cell| cell.facets[4].swap(0, 1)),
        // A rim vertex is off the entrance plane.
        spoilt(&|cell| rims(cell, &|p| p.z -= 1e-6)),
        // A body is missing: the apertures do not cover the entrance.
        spoilt(&|cell| drop(cell.facets.drain(0..3))),
        // A body is moved over its neighbours.
        spoilt(&|cell| {
            cell.facets[..3]
                .iter_mut()
                .flatten()
                .for_each(|p| p.x += 0.1);
        }),
        // An apex is outside its aperture.
        spoilt(&|cell| {
            let apex = cell.facets[0][0];
            let corners = cell.facets.iter_mut().flatten();
            corners.filter(|p| **p == apex).for_each(|p| p.x += 2.0);
        }),
        // A facet lies in the entrance plane.
        spoilt(&|cell| {
            cell.facets
                .push(cell.facets[0].map(|p| p.with_z(cells::HEIGHT)));
        }),
    ];
    let mut expected = [Some(Whole::Connected); 9];
    expected[0] = Some(Whole::Periodic);
    assert_eq!(cases, expected);
    assert_eq!(bakes::kinds(&patch(3, 1)).err(), Some(Whole::Small));
    // Bodies of 9 facets have programs, so there may be many kinds. Bodies of 27 facets have none.
    let nine = split(uneven(3, 3));
    assert_eq!(bakes::kinds(&nine).map(|kinds| kinds.len()), Ok(18));
    assert_eq!(bakes::kinds(&split(nine)).err(), Some(Whole::Unlike));
    assert_eq!(bakes::kinds(&uneven(50, 41)).err(), Some(Whole::Unlike));
}

/// Splits each facet of a cell in three at its middle.
fn split(cell: Cell) -> Cell {
    let thirds = |[a, b, c]: [DVec3; 3]| {
        let middle = (a + b + c) / 3.0;
        [[a, b, middle], [b, c, middle], [c, a, middle]]
    };
    Cell {
        facets: cell.facets.into_iter().flat_map(thirds).collect(),
        ..cell
    }
}

/// Sheets of 8, 60 and 240 cubes that all differ are traced cube by cube. Each ray has the fate and
/// bin that it has in the whole mesh by the hierarchy, whatever the order of the samples, on every
/// instruction set.
#[test]
fn unlike_bodies_equal_the_whole_mesh_ray_for_ray() {
    let bins = Bins::new(32, 1.5);
    let (first, rays) = ((1 << 15) - 5, 40_000_u64);
    let mut compared = 0;
    for (columns, rows) in [(2, 2), (6, 5), (12, 10)] {
        let cell = uneven(columns, rows);
        let kinds = bakes::kinds(&cell).expect("a sheet of cubes");
        assert!(kinds.iter().all(|kind| kind.places.len() == 1));
        let sheet = Sheet::new(&bakes::prepared(&cell), Index::Auto);
        assert_eq!(sheet.scenes.len(), 2 * columns * rows);
        let whole = Scene::new(&cell, Index::Hierarchy);
        for (incidence, azimuth) in [(0.0, 0.0), (11.0, 200.0), (34.0, 75.0), (80.0, 33.0)] {
            for sampler in [Sampler::Random, Sampler::Sobol] {
                let stream = Stream::new(sampler, 5, incidence, azimuth, 0);
                let direction = Incidence::new(incidence.to_radians(), azimuth.to_radians(), 1.0);
                let mut all = Accumulator::new(&bins);
                for index in first..first + rays {
                    let (kind, point) = sheet.launch.entry(&stream, index);
                    let point = point + kinds[kind].places[0];
                    all.count(&bins, &trace(&whole, &MIRROR, &direction, point, 0.5));
                }
                for set in InstructionSet::available() {
                    let kernel = Kernel::over(&sheet, &MIRROR, &bins, incidence, azimuth).on(set);
                    assert_eq!(kernel.programs().len(), 2 * columns * rows);
                    let mut parts = Accumulator::new(&bins);
                    kernel.trace(&stream, first..first + rays, &mut parts);
                    assert_eq!(parts.fates, all.fates, "at ({incidence}, {azimuth})");
                    let size = bins.len();
                    assert!(parts.histogram[..size] == all.histogram[..size]);
                    assert_eq!(parts.fates.iter().sum::<u64>(), rays);
                    compared += rays;
                }
            }
        }
    }
    let sets = InstructionSet::available().len() as u64;
    assert_eq!(compared, 3 * 4 * 2 * sets * 40_000);
}

/// Exit directions of unlike cubes are those of single rays, where they are few and counted and
/// where they are many and listed, on every instruction set, without and with losses. Photons of
/// sheets of many pieces are sorted by piece, and keep the chance that their index gives them.
#[test]
fn exit_directions_of_unlike_bodies_equal_those_of_single_rays() {
    let grid = Grid {
        cells: 8,
        bins: 401,
        range: 0.01,
    };
    let lossy = Rules {
        refractive_index: 1.49,
        mirror_back: false,
        losses: Some(Backing::Bare),
        ..MIRROR
    };
    // 8 MB of counters hold 2,048 exit directions of 32 x 32 bins, and 128 of 128 x 128.
    let (mut compared, mut most) = (0, [0; 4]);
    let cases = [(2, 2, 32), (6, 5, 32), (2, 2, 128), (12, 10, 128)];
    for (most, (columns, rows, bins)) in most.iter_mut().zip(cases) {
        let sheet = Sheet::new(&bakes::prepared(&uneven(columns, rows)), Index::Auto);
        let bins = Bins::new(bins, 1.5);
        for ((incidence, azimuth), rules) in [
            ((0.0, 0.0), &MIRROR),
            ((20.0, 75.0), &MIRROR),
            ((20.0, 75.0), &lossy),
        ] {
            for sampler in [Sampler::Random, Sampler::Sobol] {
                let stream = Stream::new(sampler, 5, incidence, azimuth, 0);
                for set in InstructionSet::available() {
                    let kernel = Kernel::over(&sheet, rules, &bins, incidence, azimuth).on(set);
                    let kernel = kernel.recording(Some(grid));
                    assert_eq!(kernel.programs().len(), 2 * columns * rows);
                    let (mut fast, mut plain) = (Accumulator::new(&bins), Accumulator::new(&bins));
                    kernel.trace(&stream, 3..20_003, &mut fast);
                    kernel.trace_one_by_one(&stream, 3..20_003, &mut plain);
                    let exits = fast.take_exits();
                    assert_eq!(exits, plain.take_exits(), "{columns} x {rows}");
                    assert_eq!(fast, plain);
                    let directions: HashSet<u64> = exits
                        .iter()
                        .map(|entry| entry.place % (401 * 401))
                        .collect();
                    *most = directions.len().max(*most);
                    compared += 20_000;
                }
            }
        }
    }
    println!("{compared} rays, up to {most:?} exit directions");
    // Six paths a cube: the first three cases are counted, and the last is listed.
    assert!(most[2] <= 48 && most[1] <= 360 && most[3] > 128, "{most:?}");
    let sets = InstructionSet::available().len();
    assert_eq!(compared, 4 * 3 * 2 * sets * 20_000);
}

/// Returns a patch whose cubes all differ, so that each is a kind of its own: every vertex below
/// the entrance plane is moved.
pub(crate) fn uneven(columns: usize, rows: usize) -> Cell {
    let mut cell = patch(columns, rows);
    for corner in cell.facets.iter_mut().flatten() {
        if corner.z < cells::HEIGHT / 2.0 {
            let t = 37.0 * corner.x + 91.0 * corner.y;
            *corner += DVec3::new(t.sin(), (1.3 * t).sin(), (1.7 * t).sin()) * 1e-3;
        }
    }
    cell
}

/// Rays in swarms have the outcomes of single rays and of a loop over all facets, bit for bit, on
/// every instruction set. The meshes have equal cubes, different cubes, and one whose rays stay in
/// it for long.
#[test]
fn swarms_equal_single_rays_bit_for_bit() {
    let bins = Bins::new(64, 1.5);
    let tir = Rules {
        refractive_index: 1.49,
        mirror_back: false,
        ..MIRROR
    };
    let mut compared = 0;
    for cell in [patch(5, 4), uneven(12, 9), uneven(3, 2)] {
        let launch = Launch::new(&cell.entrance);
        let [scene, oracle] =
            [Index::Hierarchy, Index::Loop].map(|index| Arc::new(Scene::new(&cell, index)));
        assert!(scene.for_groups().is_some());
        for (incidence, azimuth) in [
            (0.0, 0.0),
            (20.0, 0.0),
            (33.0, 90.0),
            (54.8, 12.0),
            (89.0, 60.0),
        ] {
            for rules in [MIRROR, tir] {
                for sampler in [Sampler::Random, Sampler::Sobol] {
                    let kernel = Kernel::new(&scene, &launch, &rules, &bins, incidence, azimuth);
                    assert!(kernel.programs().is_empty());
                    let stream = Stream::new(sampler, 8, incidence, azimuth, 0);
                    let mut on_sets: Vec<Accumulator> = Vec::new();
                    for set in InstructionSet::available() {
                        let kernel =
                            Kernel::new(&scene, &launch, &rules, &bins, incidence, azimuth).on(set);
                        let mut accumulator = Accumulator::new(&bins);
                        kernel.trace(&stream, 1_000..6_001, &mut accumulator);
                        on_sets.push(accumulator);
                    }
                    assert!(on_sets.iter().all(|accumulator| *accumulator == on_sets[0]));
                    let accumulators = [0, 1, 2].map(|way| {
                        let mut accumulator = Accumulator::new(&bins);
                        let rays = 1_000..6_001;
                        match way {
                            0 => kernel.trace(&stream, rays, &mut accumulator),
                            1 => kernel.trace_one_by_one(&stream, rays, &mut accumulator),
                            _ => Kernel::new(&oracle, &launch, &rules, &bins, incidence, azimuth)
                                .trace_one_by_one(&stream, rays, &mut accumulator),
                        }
                        accumulator
                    });
                    assert!(
                        accumulators[0] == accumulators[1],
                        "single at ({incidence}, {azimuth})"
                    );
                    assert!(
                        accumulators[0] == accumulators[2],
                        "loop at ({incidence}, {azimuth})"
                    );
                    assert_eq!(accumulators[0].fates.iter().sum::<u64>(), 5_001);
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 3 * 5 * 2 * 2);
}
