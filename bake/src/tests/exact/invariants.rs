//! Invariants of every cell: light is neither lost nor made, nothing is NaN, in hard directions
//! too.

use crate::beams::{Share, bake, prepare};
use crate::cell::MEAN_ERROR;
use crate::optics::Rules;
use crate::plan::{Plan, Request};
use crate::tests::bakes;
use crate::tests::bakes::asked;
use meshes::Cell;
use tables::{Axes, Fate};

use crate::tests::cells::full_cube;
use crate::tests::exact::cells::{
    Draw, bent_edges, blunt, canted_edges, ideal_edges, pair, single, truncated,
};

fn cells() -> Vec<(&'static str, Cell)> {
    vec![
        ("single", single(ideal_edges())),
        ("pair", pair(ideal_edges(), false)),
        ("periodic pair", pair(ideal_edges(), true)),
        ("full cube", full_cube()),
        ("canted", single(canted_edges(0.12, 0.5))),
        ("canted pair", pair(canted_edges(-0.2, 0.45), true)),
        ("bent 1e-9", single(bent_edges([1e-9, 2e-9, -1e-9]))),
        ("bent 1e-3", pair(bent_edges([1e-3, -2e-3, 5e-4]), true)),
        ("bent 1e-2", single(bent_edges([1e-2, 1e-2, 1e-2]))),
        ("blunt", blunt(0.3)),
        ("truncated", truncated(0.2)),
    ]
}

/// Checks the shares of one direction.
///
/// They are sums of some hundred areas, each good to a few ulp of the longest path: 1e-12 up to 89
/// deg, and beyond that in proportion to the path. `valley` is the share that may run along the
/// lattice without end.
fn check(name: &str, found: &Share, incidence: f64, azimuth: f64, valley: f64) {
    let place = format!("{name} at ({incidence}, {azimuth})");
    let slack = 1e-12 * (0.02 / incidence.to_radians().cos()).max(1.0);
    let sum: f64 = found.fate.iter().sum();
    assert!(
        (sum - 1.0).abs() < slack,
        "{place}: fates sum to 1 {:+e}",
        sum - 1.0
    );
    assert!(
        found.dropped.abs() < slack,
        "{place}: dropped {:e}",
        found.dropped
    );
    for (fate, share) in Fate::ALL.iter().zip(found.fate) {
        assert!(
            (-slack..=1.0 + slack).contains(&share),
            "{place}: {} is {share}",
            fate.name()
        );
    }
    // The cells are closed: nothing misses them, and nothing is trapped for 64 reflections.
    assert!(
        found.fate[Fate::Missed as usize] < slack,
        "{place}: missed {:e}",
        found.fate[Fate::Missed as usize]
    );
    let endless = found.fate[Fate::BounceLimit as usize];
    assert!(endless <= valley, "{place}: {endless:e} without end");
    let inside: f64 = found.histogram.iter().sum();
    assert!(
        (inside - found.fate[Fate::Retroreflected as usize]).abs() < 1e-13,
        "{place}: bins sum to {inside}"
    );
    assert!(
        found
            .histogram
            .iter()
            .all(|mass| (0.0..=1.0).contains(mass)),
        "{place}"
    );
}

#[test]
fn areas_are_conserved_in_every_direction() {
    let mut draw = Draw(5);
    let mut cases = 0;
    for (name, cell) in cells() {
        let exact = bakes::exact(&cell).unwrap();
        let (mut worst, mut returning) = (0.0_f64, 0);
        for _ in 0..150 {
            let (incidence, azimuth) = (89.0 * draw.next(), 360.0 * draw.next());
            let found = exact.direction(incidence, azimuth, 64, 2.0, &Rules::mirrors(1.0));
            check(name, &found, incidence, azimuth, 0.0);
            worst = worst.max((found.fate.iter().sum::<f64>() - 1.0).abs());
            returning += usize::from(found.retroreflected > 0.0);
            cases += 1;
        }
        println!(
            "{name}: fates sum to 1 within {worst:.1e}, {returning} of 150 directions return light"
        );
        // Errors of 1e-2 rad send all light at least 1.9 deg off, which is beyond the tolerance.
        assert_eq!(returning > 15, name != "bent 1e-2", "{name}: {returning}");
    }
    assert_eq!(cases, 11 * 150);
}

#[test]
fn hard_directions_are_ordinary() {
    let edge_on = (1.0_f64 / 2_f64.sqrt()).atan().to_degrees();
    let along_edge = 2_f64.sqrt().atan().to_degrees();
    let mut cases = 0;
    for (name, cell) in cells() {
        let exact = bakes::exact(&cell).unwrap();
        for incidence in [
            0.0,
            1e-9,
            edge_on,
            edge_on - 1e-9,
            edge_on + 1e-9,
            along_edge,
            along_edge + 1e-9,
            89.9,
        ] {
            for azimuth in [
                0.0,
                30.0,
                60.0,
                90.0,
                120.0,
                180.0,
                240.0,
                300.0,
                1e-9,
                59.999999999,
            ] {
                for index in [1.0, 1.0 + 1e-9, 1.49] {
                    let rules = Rules::mirrors(index);
                    let found = exact.direction(incidence, azimuth, 32, 2.0, &rules);
                    // At 1e-9 deg from edge-on, 1e-11 rad of the light runs level, between peaks or
                    // walls. Grazing light goes to and fro between upright walls.
                    let valley = if name == "truncated" && incidence > 89.0 {
                        1.0
                    } else {
                        1e-9
                    };
                    check(name, &found, incidence, azimuth, valley);
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 11 * 8 * 10 * 3);
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let cell = pair(bent_edges([1e-3, 0.0, 0.0]), true);
    let axes = Axes {
        incidence_deg: vec![0.0, 15.0, 30.0],
        azimuth_deg: vec![0.0, 10.0],
        bins: 32,
        range: 2.0,
    };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            bake(
                prepare(&bakes::prepared(&cell), &axes).unwrap(),
                &axes,
                &Rules::mirrors(1.0),
                || true,
            )
        })
        .unwrap()
    };
    let one = on(1);
    assert_eq!(one, on(4));
    assert_eq!(one.exact.paths.len(), 6);
    for (i, paths) in one.exact.paths.iter().enumerate() {
        let area: f64 = paths
            .iter()
            .map(|path| path.weight * shoelace(&path.polygon))
            .sum();
        let eta = one.retroreflected[[i / 2, i % 2]];
        assert!(
            (area / one.exact.entrance_area - eta).abs() < 1e-14,
            "eta is the paths' area"
        );
    }
}

fn shoelace(polygon: &[[f64; 2]]) -> f64 {
    (0..polygon.len())
        .map(|i| {
            let ([a, b], [c, d]) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            0.5 * (a * d - b * c)
        })
        .sum()
}

#[test]
fn a_narrow_histogram_counts_the_rest_as_out_of_range() {
    let cell = single(ideal_edges());
    let exact = bakes::exact(&cell).unwrap();
    let wide = exact.direction(20.0, 40.0, 128, 2.0, &Rules::mirrors(1.0));
    let narrow = exact.direction(20.0, 40.0, 32, 0.5, &Rules::mirrors(1.0));
    assert_eq!(wide.retroreflected, narrow.retroreflected);
    let central: f64 = (48..80)
        .flat_map(|v| (48..80).map(move |u| v * 128 + u))
        .map(|i| wide.histogram[i])
        .sum();
    assert!((narrow.fate[Fate::Retroreflected as usize] - central).abs() < 1e-14);
    assert!(
        (narrow.fate[Fate::OutOfRange as usize] - (wide.retroreflected - central)).abs() < 1e-14
    );
    assert!(central > 0.1 && central < wide.retroreflected - 0.01);
}

#[test]
fn dihedral_errors_split_the_return_into_six_maps_or_two() {
    let spots = |errors: [f64; 3]| {
        let cell = single(bent_edges(errors));
        bakes::exact(&cell)
            .unwrap()
            .direction(0.0, 0.0, 64, 2.0, &Rules::mirrors(1.0))
            .paths
            .len()
    };
    assert_eq!(spots([1e-3; 3]), 6);
    assert_eq!(spots([1e-6; 3]), 6);
    // With one error, sequences differ only by the sense in which its edge is crossed.
    assert_eq!(spots([0.0; 3]), 1);
}

/// The error of a mean over azimuths, which is no finite set of polygons, is below the stated one.
/// The truth is the mean of 36,000 azimuths in the middle of their steps, which the halved degrees
/// never meet.
#[test]
#[ignore = "half a minute: `make test-slowest` runs it"]
fn a_mean_over_azimuths_is_that_of_many_azimuths() {
    let axes = Axes {
        incidence_deg: vec![20.0, 40.0],
        azimuth_deg: vec![f64::NAN],
        bins: 32,
        range: 2.0,
    };
    let rules = Rules::mirrors(1.0);
    let mut compared = 0;
    for cell in [single(ideal_edges()), pair(ideal_edges(), true)] {
        let refused = prepare(&bakes::prepared(&cell), &axes).unwrap_err();
        assert!(refused.contains("a mean over all azimuths"), "{refused}");
        let exact = bakes::exact(&cell).unwrap();
        let pools = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            pool.install(|| bake(&exact, &axes, &rules, || true))
                .unwrap()
        });
        assert_eq!(pools[0], pools[1], "whatever the threads");
        for (i, incidence) in axes.incidence_deg.iter().enumerate() {
            let baked = &pools[0];
            let many = 36_000;
            let (mut eta, mut histogram) = (0.0, vec![0.0; axes.bins * axes.bins]);
            for k in 0..many {
                let azimuth = (f64::from(k) + 0.5) * 360.0 / f64::from(many);
                let share = exact.direction(*incidence, azimuth, axes.bins, axes.range, &rules);
                eta += share.retroreflected / f64::from(many);
                for (sum, mass) in histogram.iter_mut().zip(share.histogram) {
                    *sum += mass / f64::from(many);
                }
            }
            let found = baked.retroreflected[[i, 0]];
            let l1: f64 = baked
                .histogram
                .iter()
                .skip(i * histogram.len())
                .zip(&histogram)
                .map(|(share, mass)| (share * found - mass).abs())
                .sum();
            println!("{incidence} deg: L1 {l1:.1e}, eta {:.1e}", found - eta);
            assert!(l1 < MEAN_ERROR, "{l1}");
            assert!((found - eta).abs() < 1e-6, "{found} is not {eta}");
            assert!(baked.exact.paths[i].is_empty());
            compared += 1;
        }
    }
    assert_eq!(compared, 4);
}

/// The light of one angle inside has one distribution, whatever the index of the front: a table of
/// one index holds those of all others, at other incidences. `fit` relies on it. The angles inside
/// differ by their rounding, 1e-16, and an OTF at kappa has the slope 2 pi kappa x 3 by the shift.
#[test]
fn the_index_acts_through_the_angle_inside_alone() {
    let mut cases = 0;
    for (name, cell) in cells() {
        if name.starts_with("bent") {
            continue;
        }
        let table = |index: f64, incidence_deg: f64| {
            let request = Request {
                incidence: incidence_deg.to_string(),
                refractive_index: Some(index),
                ..asked("--azimuth 0,25,80 --method exact --bins 16")
            };
            bakes::bake(&cell, &Plan::new(&request).expect("a plan")).expect("bakes")
        };
        for (own, other, incidence_deg) in [(1.49, 1.586, 30.0), (1.49, 1.0, 17.0_f64)] {
            let held = (incidence_deg.to_radians().sin() * own / other)
                .asin()
                .to_degrees();
            let (own, other) = (table(own, held), table(other, incidence_deg));
            for azimuth in [0.0, 25.0, 80.0] {
                let own = own.direction(held, Some(azimuth)).expect("it is held");
                let other = other
                    .direction(incidence_deg, Some(azimuth))
                    .expect("it is held");
                let off = (own.retroreflected - other.retroreflected).abs();
                assert!(off < 1e-12, "{name} {azimuth}: {off}");
                for along in [[1.0, 0.0], [0.6, 0.8], [0.0, 1.0]] {
                    let kappa = [0.3, 0.8, 2.0];
                    let pairs = own.otf_along(along, &kappa).into_iter();
                    for (own, other) in pairs.zip(other.otf_along(along, &kappa)) {
                        let off = (own - other).norm();
                        assert!(off < 1e-10, "{name} {azimuth} {along:?}: {off}");
                        cases += 1;
                    }
                }
            }
        }
    }
    assert_eq!(cases, 8 * 2 * 3 * 3 * 3);
}
