//! Rays on facets with interpolated normals: their fates, and the options that allow or refuse
//! them.

use crate::cell::Whole;
use crate::geometry::{Launch, Stream};
use crate::optics::Incidence;
use crate::plan::{Plan, Request};
use crate::rays::{
    Accumulator, Bins, Event, Index, Kernel, Outcome, SampleRange, Scene, Tracer, trace,
};
use crate::tests::bakes;
use crate::tests::bakes::asked;
use crate::tests::curved::{RULES, cell, design};
use glam::{DVec2, DVec3};
use meshes::design::Shape;
use meshes::{Cell, Entrance};
use num_complex::Complex64;
use std::num::NonZeroUsize;
use std::sync::Arc;
use tables::options::{Method, Sampler};
use tables::{Fate, Symmetry};

const RAYS: u64 = 20_000;

fn outcomes(cell: &Cell, index: Index) -> Vec<Outcome> {
    let scene = Scene::new(cell, index);
    let launch = Launch::new(&cell.entrance);
    let stream = Stream::new(Sampler::Random, 3, 30.0, 10.0, 0);
    let light = Incidence::new(0.5, 0.2, 1.0);
    (0..RAYS)
        .map(|index| trace(&scene, &RULES, &light, launch.entry(&stream, index).1, 0.5))
        .collect()
}

#[test]
fn loop_and_hierarchy_agree_to_the_last_bit() {
    let cell = cell(&design(Shape::TriangularPair, 0.01, 5), true);
    let (plain, fast) = (
        outcomes(&cell, Index::Loop),
        outcomes(&cell, Index::Hierarchy),
    );
    assert!(plain == fast);
    let fates: Vec<usize> = Fate::ALL
        .iter()
        .map(|&fate| plain.iter().filter(|o| o.fate == fate).count())
        .collect();
    println!("{RAYS} rays by fate: {fates:?}");
    assert!(fates[Fate::Retroreflected as usize] > 1000);
}

/// Interpolated normals that equal those of the facets change nothing but rounding: three
/// reflections about vectors that are known to 4e-16, over paths of at most three edges.
#[test]
fn normals_of_planes_are_planes() {
    let mut flat = design(Shape::TriangularPair, 0.0, 4);
    for triangle in 0..flat.triangles.len() {
        let [a, b, c] = flat.corners(triangle);
        flat.normals.push((b - a).cross(c - a));
        let number = std::num::NonZeroU32::new(triangle as u32 + 1);
        flat.corner_normals.push([number; 3]);
    }
    let (planes, normals) = (cell(&flat, false), cell(&flat, true));
    let pairs = outcomes(&planes, Index::Auto);
    let pairs = pairs.iter().zip(outcomes(&normals, Index::Auto));
    let mut cases = 0;
    for (a, b) in pairs {
        assert_eq!((a.fate, a.bounces), (b.fate, b.bounces));
        assert!((a.shift - b.shift).length() < 1e-14 && a.travel.distance(b.travel) < 1e-14);
        cases += 1;
    }
    assert_eq!(cases, RAYS);
}

/// Two facets of one period, each moved to another period, give an equal sheet, whose copies have
/// equal normals.
#[test]
fn copies_of_a_periodic_cell_have_its_normals() {
    let e = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
        let (x, y) = (
            DVec3::new(1.0, -1.0, 0.0).normalize(),
            DVec3::new(1.0, 1.0, -2.0).normalize(),
        );
        DVec3::new(axis.dot(x), axis.dot(y), 1.0 / 3_f64.sqrt())
    });
    let lattice = [(e[0] - e[2]).truncate(), (e[1] - e[2]).truncate()];
    let lattice = match lattice[0].perp_dot(lattice[1]) > 0.0 {
        true => lattice,
        false => [lattice[1], lattice[0]],
    };
    let mut facets = Vec::new();
    for i in 0..3 {
        let (a, b) = (e[i], e[(i + 1) % 3]);
        facets.extend([[DVec3::ZERO, a, a + b], [DVec3::ZERO, a + b, b]]);
    }
    // The normals are bent, each corner another way.
    let vectors: Vec<DVec3> = facets
        .iter()
        .flat_map(|&[a, b, c]| {
            let own = (b - a).cross(c - a).normalize();
            [a, b, c].map(|p| (own + (p - (a + b + c) / 3.0) * 0.05).normalize())
        })
        .collect();
    let corners = (0..facets.len() as u32)
        .map(|f| [3 * f, 3 * f + 1, 3 * f + 2])
        .collect();
    let corner = -(lattice[0] + lattice[1]) / 2.0;
    let one = Cell {
        facets,
        normals: Some(meshes::Normals { vectors, corners }),
        entrance: Entrance {
            height: 2.0 / 3_f64.sqrt(),
            polygon: vec![
                corner,
                corner + lattice[0],
                corner + lattice[0] + lattice[1],
                corner + lattice[1],
            ],
            lattice: Some(lattice),
        },
        ..cell(&design(Shape::Triangular, 0.0, 1), false)
    };
    let mut other = one.clone();
    for (facet, step) in
        other
            .facets
            .iter_mut()
            .zip([(0, 0), (1, 0), (-1, 2), (0, 1), (3, 0), (0, 0)])
    {
        let by = lattice[0] * f64::from(step.0) + lattice[1] * f64::from(step.1);
        *facet = facet.map(|p| p + by.extend(0.0));
    }
    let (one, other) = (outcomes(&one, Index::Auto), outcomes(&other, Index::Auto));
    let mut alike = 0;
    for (a, b) in one.iter().zip(&other) {
        // A ray within rounding of an edge may take either side.
        let near = (a.shift - b.shift).length() < 1e-12 && a.travel.distance(b.travel) < 1e-12;
        alike += usize::from(a.fate == b.fate && near);
    }
    let returned = one
        .iter()
        .filter(|o| o.fate == Fate::Retroreflected)
        .count();
    println!("{alike} of {} alike, {returned} returned", one.len());
    assert_eq!(alike as u64, RAYS);
    assert!(returned > 1000);
}

/// The normal at a point is the mean of the corners' normals by the areas opposite. Cramer's rule
/// gives an equal result.
#[test]
fn normals_are_interpolated_by_area() {
    let cell = cell(&design(Shape::Triangular, 0.03, 3), true);
    let scene = Scene::new(&cell, Index::Loop);
    let normals = cell.normals.as_ref().expect("curved");
    let down = -DVec3::Z;
    let mut cases = 0;
    for (facet, numbers) in cell.facets.iter().zip(&normals.corners) {
        for weights in [[0.2, 0.3, 0.5], [0.98, 0.01, 0.01], [1.0 / 3.0; 3]] {
            let mix = |v: [DVec3; 3]| v[0] * weights[0] + v[1] * weights[1] + v[2] * weights[2];
            let point = mix(*facet);
            let ray = scene.enter(point.truncate(), down);
            let Event::Hit {
                normal,
                front_normal,
                arrival,
                ..
            } = scene.next(&ray)
            else {
                panic!("{point} is on a facet");
            };
            let expected = mix(numbers.map(|n| normals.vectors[n as usize])).normalize();
            // Weights are known to some 1e-16 over the height of the facet, 0.3.
            assert!(arrival.origin.distance(point) < 1e-14);
            assert!(normal.distance(expected) < 1e-14, "{normal} {expected}");
            let own = (facet[1] - facet[0]).cross(facet[2] - facet[0]).normalize();
            assert!(front_normal.distance(own) < 1e-14);
            cases += 1;
        }
    }
    assert_eq!(cases, 81);
}

/// A flat mirror whose normals lean by 60 degrees sends level light below itself, where it meets no
/// facet.
#[test]
fn light_sent_behind_its_facet_is_absorbed() {
    let facet = [
        DVec3::new(-1.0, -1.0, 0.0),
        DVec3::new(2.0, -1.0, 0.0),
        DVec3::new(-1.0, 2.0, 0.0),
    ];
    let lean = |tilt: f64| {
        let cell = Cell {
            facets: vec![facet],
            normals: Some(meshes::Normals {
                vectors: vec![DVec3::new(tilt.sin(), 0.0, tilt.cos())],
                corners: vec![[0; 3]],
            }),
            entrance: Entrance {
                height: 0.1,
                polygon: vec![
                    DVec2::new(-0.5, -0.5),
                    DVec2::new(0.5, -0.5),
                    DVec2::new(-0.5, 0.5),
                ],
                lattice: None,
            },
            ..cell(&design(Shape::Triangular, 0.0, 1), false)
        };
        // The light is 80 degrees from the sheet's normal, that is 10 degrees over the mirror.
        let light = Incidence::new(80_f64.to_radians(), 0.0, 1.0);
        let scene = Scene::new(&cell, Index::Loop);
        trace(&scene, &RULES, &light, DVec2::new(-0.4, -0.4), 0.5).fate
    };
    // Up to a lean of 5 degrees away from it, the light leaves above the mirror. With a larger lean
    // it does not, also if the lean is larger than the light's own 10 degrees.
    let cases = [
        (-40, false),
        (0, false),
        (4, false),
        (6, true),
        (30, true),
        (60, true),
    ];
    for (degrees, absorbed) in cases {
        let fate = lean(f64::from(degrees).to_radians());
        assert_eq!(fate == Fate::Absorbed, absorbed, "{degrees}: {fate:?}");
    }
}

fn plan(method: Method, threads: usize) -> Plan {
    let mut plan = Plan::new(&Request {
        method,
        ..asked("--incidence 0,20 --azimuth 30 --rays 60000 --normals file")
    })
    .expect("a plan");
    plan.threads = NonZeroUsize::new(threads);
    plan
}

#[test]
fn tables_do_not_depend_on_threads_or_the_way_of_tracing() {
    let cell = cell(&design(Shape::TriangularPair, 1e-4, 12), true);
    let bake = |threads, tracer| {
        let table = bakes::rays_by(tracer, &cell, &plan(Method::Rays, threads)).expect("a table");
        assert_eq!(table.provenance.options.text(), "--normals file");
        table.content_hash()
    };
    let one = bake(1, Tracer::Fastest);
    assert_eq!(one, bake(3, Tracer::Fastest));
    assert_eq!(one, bake(2, Tracer::OneByOne));
}

/// A scene that is too large for caches is traced in another order, with equal counts.
#[test]
fn large_scenes_are_traced_in_any_order() {
    let cell = cell(&design(Shape::TriangularPair, 1e-4, 53), true);
    let scene = Arc::new(Scene::new(&cell, Index::Auto));
    assert!(scene.is_large());
    let (launch, bins) = (Launch::new(&cell.entrance), Bins::new(64, 2.0));
    let stream = Stream::new(Sampler::Sobol, 1, 20.0, 30.0, 0);
    let kernel = Kernel::new(&scene, &launch, &RULES, &bins, 20.0, 30.0);
    let (mut sorted, mut plain) = (Accumulator::new(&bins), Accumulator::new(&bins));
    kernel.trace(&stream, 0..RAYS, &mut sorted);
    let light = Incidence::new(20_f64.to_radians(), 30_f64.to_radians(), 1.0);
    for index in 0..RAYS {
        let point = launch.entry(&stream, index).1;
        plain.count(&bins, &trace(&scene, &RULES, &light, point, 0.5));
    }
    assert_eq!(sorted.fates.iter().sum::<u64>(), RAYS);
    assert_eq!(sorted.fates, plain.fates);
    assert!(sorted.histogram == plain.histogram);
}

/// Samples of several randomisations are traced together, in swarms, on curved facets and on planar
/// ones. Each accumulator is the one that its samples give alone.
#[test]
fn samples_traced_together_are_counted_apart() {
    let (mut cases, mut counted) = (0, 0);
    for with_normals in [true, false] {
        let cell = cell(&design(Shape::TriangularPair, 1e-3, 12), with_normals);
        let scene = Arc::new(Scene::new(&cell, Index::Auto));
        let (launch, bins) = (Launch::new(&cell.entrance), Bins::new(32, 2.0));
        let kernel = Kernel::new(&scene, &launch, &RULES, &bins, 20.0, 30.0);
        assert!(kernel.mixes());
        let part = |number: u64| SampleRange {
            stream: Stream::new(Sampler::Sobol, 1, 20.0, 30.0, number),
            samples: 10 * number..10 * number + 3_000 + number,
        };
        let parts: Vec<SampleRange> = (0..5).map(part).collect();
        let mut together = vec![Accumulator::new(&bins); parts.len()];
        kernel.trace_parts(&parts, &mut together);
        for (part, accumulator) in parts.iter().zip(&together) {
            let mut alone = Accumulator::new(&bins);
            kernel.trace_one_by_one(&part.stream, part.samples.clone(), &mut alone);
            assert_eq!(*accumulator, alone);
            cases += 1;
            counted += accumulator.fates.iter().sum::<u64>();
        }
    }
    assert_eq!((cases, counted), (10, 2 * (5 * 3_000 + 10)));
}

#[test]
fn methods_for_planes_are_refused() {
    let curved = cell(&design(Shape::TriangularPair, 1e-4, 4), true);
    let refused = bakes::exact(&curved).expect_err("refused");
    assert!(refused.contains("no plane mirrors"), "{refused}");
    let error = bakes::bake(&curved, &plan(Method::Exact, 1)).expect_err("refused");
    assert!(
        error
            .to_string()
            .starts_with("--method exact: --normals file leaves no plane"),
        "{error}"
    );
    let table = bakes::bake(&curved, &plan(Method::Auto, 1)).expect("rays");
    assert_eq!(table.provenance.method.text(), "rays");
    assert_eq!(bakes::kinds(&curved).err(), Some(Whole::Curved));
    assert_eq!(bakes::symmetry(&curved), Symmetry::NONE);
}

/// A cell of 16,854 facets is refused by the exact method: it has too many facets to join them to
/// planes, whatever planes they lie in.
#[test]
fn fine_meshes_are_traced_by_rays() {
    for sag in [0.0, 1e-3] {
        let fine = cell(&design(Shape::TriangularPair, sag, 53), false);
        let refused = bakes::exact(&fine).expect_err("refused");
        assert!(refused.contains("triangles in one piece"), "{refused}");
        assert_eq!(bakes::symmetry(&fine), Symmetry::NONE);
    }
}

/// The bins of exit directions that are chosen for curved faces hold 1 % of MTF at every distance,
/// however slight the sag: against the sum over single rays, which knows no bins. Bins for all
/// light that counts as retroreflected, 0.4 mrad, do not.
///
/// The frequency times the distance decides, cycles a radian; shifts are left out by corners of no
/// size.
#[test]
fn bins_of_curved_faces_hold_one_per_cent_of_mtf() {
    let (mut cases, mut worst, mut coarse) = (0, 0.0_f64, 0.0_f64);
    for (sag, index) in [(2e-5, 1.0), (2e-5, 1.49), (1e-4, 1.49), (4e-4, 1.0)] {
        let cell = cell(&design(Shape::TriangularPair, sag, 12), true);
        let request = |deviations: &str| Request {
            rays: Some(1 << 17),
            refractive_index: Some(index),
            scene: tables::options::StatedOptions::from(&*format!("--normals file{deviations}"))
                .known()
                .expect("options"),
            incidence: "0,30".into(),
            azimuth: "30".into(),
            method: Method::Rays,
            ..Request::default()
        };
        let bake = |deviations| {
            let plan = Plan::new(&request(deviations)).expect("a plan");
            (plan.rules(&cell), bakes::bake(&cell, &plan).expect("bakes"))
        };
        let (rules, chosen) = bake("");
        let (_, wide) = bake(" --deviations 26");
        let (scene, launch) = (Scene::new(&cell, Index::Auto), Launch::new(&cell.entrance));
        for incidence in [0.0_f64, 30.0] {
            let light = Incidence::new(incidence.to_radians(), 30_f64.to_radians(), index);
            let stream = Stream::new(Sampler::Sobol, 3, incidence, 30.0, 0);
            let rays = (0..1 << 16).map(|ray| {
                let point = launch.entry(&stream, ray).1;
                trace(&scene, &rules, &light, point, 0.5)
            });
            let returned = rays.filter(|ray| ray.fate == Fate::Retroreflected);
            let off: Vec<DVec2> = returned
                .map(|ray| light.deviation(ray.travel, index))
                .collect();
            for normal in [[1.0, 0.0], [0.0, 1.0]] {
                let along: Vec<f64> = off.iter().map(|off| off.dot(normal.into())).collect();
                let square = along.iter().map(|off| off * off).sum::<f64>() / along.len() as f64;
                let lines = [&chosen, &wide].map(|table| {
                    let direction = table.direction(incidence, Some(30.0)).expect("a direction");
                    tables::ShiftLine::new(&direction, incidence.to_radians(), normal)
                });
                for step in 1..=20 {
                    let turns = 0.02 * f64::from(step) / square.sqrt();
                    let wave = |off: &f64| Complex64::cis(-std::f64::consts::TAU * turns * off);
                    let sum: Complex64 = along.iter().map(wave).sum();
                    let expected = sum.norm() / along.len() as f64;
                    let [off, wide] = lines.each_ref().map(|line| {
                        let line = line.as_ref().expect("light");
                        let (value, _) = line.otf(1e-12, 1.0, turns);
                        (value.norm() - expected).abs()
                    });
                    worst = worst.max(off);
                    coarse = coarse.max(if sag < 1e-4 { wide } else { 0.0 });
                    cases += 1;
                }
            }
        }
    }
    println!("{cases} MTFs within {worst:.4}; in bins of 0.4 mrad {coarse:.3}");
    assert_eq!(cases, 320);
    assert!(worst < 0.01 && coarse > 0.05, "{worst} {coarse}");
}
