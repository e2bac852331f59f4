//! Directions of a table: held, interpolated, refused.

use crate::sample;

use ndarray::{Array2, Array4};
use tables::{Error, Exact, Path, Symmetry, l1};

#[test]
fn a_held_direction_is_the_tables_own() {
    let table = sample::exact();
    let mut cases = 0;
    for (i, incidence) in [0.0, 10.0, 45.5].into_iter().enumerate() {
        for (j, azimuth) in [0.0, 30.0].into_iter().enumerate() {
            for turn in [0.0, 360.0, -720.0, 5e-10] {
                let direction = table
                    .direction(incidence + 5e-10, Some(azimuth + turn))
                    .unwrap();
                assert!(!direction.interpolated);
                assert_eq!(direction.retroreflected, table.retroreflected[[i, j]]);
                assert_eq!(direction.probability, table.probability(i, j));
                assert_eq!(
                    direction.paths.as_ref(),
                    Some(&table.exact.as_ref().unwrap().paths[2 * i + j])
                );
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 24);
}

#[test]
fn between_directions_eta_times_histogram_is_bilinear() {
    let table = sample::rays(1, 5);
    let mut cases = 0;
    for (incidence, i, p) in [(2.5, 0, 0.25), (10.0, 1, 0.0), (36.625, 1, 0.75)] {
        for (azimuth, q) in [(0.0, 0.0), (7.5, 0.25), (30.0, 1.0)] {
            let direction = table.direction(incidence, Some(azimuth)).unwrap();
            assert_eq!(direction.interpolated, p > 0.0 || (q > 0.0 && q < 1.0));
            let next = (i + 1).min(2);
            let shares = [
                ((i, 0), (1.0 - p) * (1.0 - q)),
                ((i, 1), (1.0 - p) * q),
                ((next, 0), p * (1.0 - q)),
                ((next, 1), p * q),
            ];
            let expected = shares
                .iter()
                .map(|&((i, j), share)| table.probability(i, j) * share)
                .reduce(|a, b| a + b)
                .unwrap();
            let eta: f64 = shares
                .iter()
                .map(|&((i, j), share)| table.retroreflected[[i, j]] * share)
                .sum();
            // The sum has four products of numbers below 1, each rounded to 1e-16.
            assert!((direction.retroreflected - eta).abs() < 1e-15);
            assert!(
                (&direction.probability - &expected)
                    .iter()
                    .all(|difference| difference.abs() < 1e-15)
            );
            let variance: f64 = shares
                .iter()
                .map(|&((i, j), share)| (share * table.standard_error[[i, j]]).powi(2))
                .sum();
            assert!((direction.standard_error - variance.sqrt()).abs() < 1e-15);
            assert!(direction.paths.is_none());
            cases += 1;
        }
    }
    assert_eq!(cases, 9);
    // A direction where nothing returns is looked up like any other.
    let empty = table.direction(45.5, Some(30.0)).unwrap();
    assert_eq!((empty.retroreflected, empty.probability.sum()), (0.0, 0.0));
}

#[test]
fn azimuths_wrap_only_where_the_table_goes_around() {
    let mut around = sample::rays(1, 5);
    around.axes.azimuth_deg = vec![10.0, 190.0];
    let direction = around.direction(0.0, Some(-80.0)).unwrap(); // halfway from 190 to 370
    let expected = 0.5 * (around.retroreflected[[0, 0]] + around.retroreflected[[0, 1]]);
    assert!(direction.interpolated && (direction.retroreflected - expected).abs() < 1e-15);
    let quarter = around.direction(0.0, Some(235.0)).unwrap();
    let expected = 0.75 * around.retroreflected[[0, 1]] + 0.25 * around.retroreflected[[0, 0]];
    assert!((quarter.retroreflected - expected).abs() < 1e-15);
    // 0 and 30 deg say nothing about 200 deg.
    assert!(sample::rays(1, 5).direction(0.0, Some(200.0)).is_err());
}

#[test]
fn a_symmetric_table_answers_for_the_images_of_its_azimuths() {
    let mut table = sample::symmetric();
    table.axes.azimuth_deg = vec![0.0, 30.0];
    let mut cases = 0;
    for (place, azimuth) in [(0, 0.0), (1, 30.0)] {
        let own = table.direction(10.0, Some(azimuth)).unwrap();
        for turn in 0..6 {
            // Azimuths 0 and 30 deg lie on mirror planes, so they need no mirror.
            let image = table.direction(10.0, Some(azimuth - 60.0 * f64::from(turn)));
            let image = image.unwrap();
            assert!(!image.interpolated);
            assert_eq!(image.probability, table.probability(1, place));
            assert_eq!(image.paths, own.paths);
            cases += 1;
        }
    }
    table.axes.azimuth_deg = vec![10.0, 30.0];
    let own = table.direction(10.0, Some(10.0)).unwrap();
    for azimuth in [-10.0, 50.0, 170.0, 350.0] {
        let image = table.direction(10.0, Some(azimuth)).unwrap();
        assert_eq!(image.retroreflected, own.retroreflected);
        let turned = own.probability.slice(ndarray::s![..;-1, ..]);
        assert_eq!(image.probability, turned);
        // The transform of a mirrored distribution along (x, y) is that of the own one along (x,
        // -y).
        let line = image.otf_along([0.7, 0.4], &[0.3, 1.1]);
        let expected = own.otf_along([0.7, -0.4], &[0.3, 1.1]);
        for (a, b) in line.iter().zip(&expected) {
            assert!((a - b).norm() < 1e-14, "{azimuth}: {a} {b}");
        }
        cases += 1;
    }
    // The gap from 30 to 50 deg is no wider than the table's own gap from 10 to 30 deg. The gap
    // from -10 to 10 deg is not either.
    table.exact = None;
    let middle = table.direction(10.0, Some(40.0)).unwrap();
    assert!(
        (middle.retroreflected - 0.5 * (own.retroreflected + table.retroreflected[[1, 1]])).abs()
            < 1e-15
    );
    table.axes.azimuth_deg = vec![12.0, 30.0];
    assert!(table.direction(10.0, Some(40.0)).is_ok(), "18 deg");
    assert!(table.direction(10.0, Some(0.0)).is_err(), "24 deg");
    assert_eq!(cases, 12 + 4);
}

#[test]
fn outside_the_nearest_direction_is_named() {
    let table = sample::rays(1, 5);
    let mut cases = 0;
    for (incidence, azimuth, nearest) in [
        (46.0, 0.0, (45.5, 0.0)),
        (-1.0, 29.0, (0.0, 30.0)),
        (9.0, 31.0, (10.0, 30.0)),
        (0.0, 359.0, (0.0, 0.0)),
    ] {
        let error = table.direction(incidence, Some(azimuth)).unwrap_err();
        let (incidence_deg, azimuth_deg) = nearest;
        let named = format!("is incidence {incidence_deg} deg, azimuth {azimuth_deg} deg;");
        assert!(matches!(error, Error::Direction(_)), "{error:?}");
        assert!(error.to_string().contains(&named), "{named} {error}");
        cases += 1;
    }
    assert_eq!(cases, 4);
    let needed = table.direction(0.0, None).unwrap_err();
    assert!(needed.to_string().contains("0 to 30 deg"), "{needed}");
    for (incidence, azimuth) in [(f64::NAN, 0.0), (0.0, f64::INFINITY)] {
        let error = table.direction(incidence, Some(azimuth)).unwrap_err();
        assert!(
            error.to_string().contains("is no direction; give finite"),
            "{error}"
        );
    }
}

#[test]
fn a_mean_table_answers_every_azimuth() {
    let table = sample::mean();
    let expected = table.direction(10.0, None).unwrap();
    assert_eq!(expected.retroreflected, table.retroreflected[[1, 0]]);
    for azimuth in [0.0, 77.0, -400.0, f64::NAN] {
        let direction = table.direction(10.0, Some(azimuth)).unwrap();
        assert_eq!(
            (direction.retroreflected, &direction.probability),
            (expected.retroreflected, &expected.probability)
        );
    }
}

#[test]
fn l1_is_a_distance_per_launched_ray() {
    let (a, b) = (sample::rays(1, 5), sample::rays(1, 6));
    assert_eq!(l1(&a, &a).sum(), 0.0);
    let distance = l1(&a, &b);
    assert_eq!(distance[[2, 1]], 0.0, "both empty");
    let by_hand: f64 = a
        .probability(0, 1)
        .iter()
        .zip(b.probability(0, 1).iter())
        .map(|(a, b)| (a - b).abs())
        .sum();
    assert!(by_hand > 0.0 && (distance[[0, 1]] - by_hand).abs() < 1e-15);
}

/// Checks that directions lie at the tangent of the refracted angle. The share of one path is made
/// affine in this tangent, so it is exact between the directions: 0.6 + 0.4 tan, over an entrance
/// of 2. The least squares leave a ridge of 1e-12 of their weights.
#[test]
fn between_directions_polygons_follow_snells_law() {
    let incidence_deg = vec![20.0, 40.0, 60.0];
    let index = 1.5;
    let tangent = |deg: f64| (deg.to_radians().sin() / index).asin().tan();
    let path = |&deg: &f64| Path {
        polygon: vec![
            [-0.3, -0.5],
            [0.3 + 0.4 * tangent(deg), -0.5],
            [0.3 + 0.4 * tangent(deg), 0.5],
            [-0.3, 0.5],
        ],
        matrix: [[-2.0, 0.0], [0.0, -2.0]],
        offset: [0.0; 2],
        weight: 1.0,
        deviation: [0.0; 2],
        passes: 0,
        jones: None,
        cube: None,
    };
    let mut table = sample::exact();
    let bins = table.axes.bins;
    table.exact = Some(Exact {
        entrance_area: 2.0,
        paths: incidence_deg.iter().map(|deg| vec![path(deg)]).collect(),
    });
    table.provenance.refractive_index = index;
    table.provenance.symmetry = Symmetry::NONE;
    table.axes.incidence_deg = incidence_deg;
    table.axes.azimuth_deg = vec![0.0];
    table.histogram = Array4::zeros((3, 1, bins, bins));
    table.retroreflected = Array2::zeros((3, 1));
    table.standard_error = Array2::zeros((3, 1));
    let mut cases = 0;
    for deg in [21.0, 30.0, 45.0, 55.5] {
        let eta = table.direction(deg, Some(0.0)).unwrap().retroreflected;
        let expected = (0.6 + 0.4 * tangent(deg)) / 2.0;
        assert!((eta - expected).abs() < 1e-11, "{deg}: {eta} {expected}");
        cases += 1;
    }
    assert_eq!(cases, 4);
}
