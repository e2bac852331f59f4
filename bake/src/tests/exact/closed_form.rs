//! Ideal cubes, whose whole distribution is known.
//!
//! The oracle carries the apex along the light to the aperture plane, at q. Light that enters at p
//! leaves at 2q - p. So the shift is uniform over 2(q - K), with K the intersection of the aperture
//! T and its point reflection through q. The oracle has polygon code of its own and computes bins
//! by clipping the square of each bin. It shares nothing with the crate.

use crate::beams::bake;
use crate::optics::Rules;
use crate::tests::bakes;
use meshes::Cell;
use tables::{Axes, Fate};

use crate::tests::exact::cells::{Draw, full_cube, ideal_edges, pair, rules, single};

const BINS: usize = 128;
const RANGE: f64 = 2.0;

type Point = [f64; 2];

/// Clips a polygon by the convex polygon `frame` (Sutherland and Hodgman). Both are
/// counter-clockwise.
fn clipped(mut polygon: Vec<Point>, frame: &[Point]) -> Vec<Point> {
    for i in 0..frame.len() {
        let (a, b) = (frame[i], frame[(i + 1) % frame.len()]);
        let side = |p: Point| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
        let mut kept = Vec::new();
        for k in 0..polygon.len() {
            let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            let (s, t) = (side(p), side(q));
            if s >= 0.0 {
                kept.push(p);
            }
            if (s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0) {
                let w = s / (s - t);
                kept.push([p[0] + w * (q[0] - p[0]), p[1] + w * (q[1] - p[1])]);
            }
        }
        polygon = kept;
    }
    polygon
}

fn area(polygon: &[Point]) -> f64 {
    (1..polygon.len().max(1))
        .map(|i| {
            let (o, p, q) = (polygon[0], polygon[i], polygon[(i + 1) % polygon.len()]);
            0.5 * ((p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]))
        })
        .sum()
}

/// Returns eta and eta x histogram of one cube, at the inside angle and the azimuth from its first
/// edge.
fn cube(inside_rad: f64, azimuth_rad: f64) -> (f64, Vec<f64>) {
    let corner = |k: usize| {
        let angle = k as f64 * std::f64::consts::TAU / 3.0 - azimuth_rad;
        let radius = (2.0_f64 / 3.0).sqrt();
        [radius * angle.cos(), radius * angle.sin()]
    };
    let triangle: Vec<Point> = (0..3).map(corner).collect();
    let q = [-inside_rad.tan() / 3_f64.sqrt(), 0.0];
    let reflected: Vec<Point> = triangle
        .iter()
        .map(|p| [2.0 * q[0] - p[0], -p[1]])
        .collect();
    let k = clipped(triangle.clone(), &reflected);
    let eta = area(&k) / area(&triangle);
    let mut histogram = vec![0.0; BINS * BINS];
    if k.is_empty() {
        return (0.0, histogram);
    }
    let support: Vec<Point> = k
        .iter()
        .map(|p| [2.0 * (q[0] - p[0]), -2.0 * p[1]])
        .collect();
    let width = 2.0 * RANGE / BINS as f64;
    let ends = |axis: usize| {
        let index = |x: f64| ((x + RANGE) / width).floor() as usize;
        let values = || support.iter().map(|p| p[axis]);
        (
            index(values().fold(f64::MAX, f64::min)),
            index(values().fold(f64::MIN, f64::max)),
        )
    };
    let ((left, right), (bottom, top)) = (ends(0), ends(1));
    for row in bottom..=top.min(BINS - 1) {
        for column in left..=right.min(BINS - 1) {
            let (x, y) = (column as f64 * width - RANGE, row as f64 * width - RANGE);
            let square = vec![
                [x, y],
                [x + width, y],
                [x + width, y + width],
                [x, y + width],
            ];
            // The map of the shift has determinant 4.
            histogram[row * BINS + column] =
                area(&clipped(square, &support)) / 4.0 / area(&triangle);
        }
    }
    (eta, histogram)
}

fn closed_form(inside_rad: f64, azimuth_rad: f64, is_pair: bool) -> (f64, Vec<f64>) {
    let (eta, mut histogram) = cube(inside_rad, azimuth_rad);
    if !is_pair {
        return (eta, histogram);
    }
    let (other_eta, other) = cube(inside_rad, azimuth_rad + std::f64::consts::PI);
    histogram
        .iter_mut()
        .zip(&other)
        .for_each(|(a, b)| *a = 0.5 * (*a + b));
    (0.5 * (eta + other_eta), histogram)
}

/// Returns the inside angle at which a cube cuts off: where q leaves the triangle. q moves along
/// -u.
fn cutoff_rad(azimuth_rad: f64) -> f64 {
    let inradius = 1.0 / 6_f64.sqrt();
    // The outward normals of the triangle's sides in the incidence frame. On each, -u has the
    // component -cos.
    let steepest = (0..3)
        .map(|k| -((2 * k + 1) as f64 * std::f64::consts::FRAC_PI_3 - azimuth_rad).cos())
        .fold(f64::MIN, f64::max);
    (inradius / steepest * 3_f64.sqrt()).atan()
}

/// Returns the largest total variation over 500 directions. A third of them lies within 1e-9 to
/// 1e-3 deg of a cutoff.
fn worst_total_variation(cell: &Cell, index: f64, is_pair: bool, seed: u64) -> f64 {
    let exact = bakes::exact(cell).unwrap();
    let rules = rules(index);
    let mut draw = Draw(seed);
    let (mut worst, mut nonzero, mut empty, mut tried) = (0.0_f64, 0, 0, 0);
    while tried < 500 {
        let mut incidence_deg = 89.0 * draw.next();
        let azimuth_deg = 360.0 * draw.next();
        let azimuth_rad = azimuth_deg.to_radians();
        if tried % 3 == 0 {
            let half_turn = if is_pair && draw.next() < 0.5 {
                std::f64::consts::PI
            } else {
                0.0
            };
            let sine = index * cutoff_rad(azimuth_rad + half_turn).sin();
            let side = if draw.next() < 0.5 { -1.0 } else { 1.0 };
            if sine < 0.999 {
                incidence_deg =
                    sine.asin().to_degrees() + side * 10_f64.powf(-9.0 + 6.0 * draw.next());
            }
        }
        tried += 1;
        let inside_rad = if index == 1.0 {
            incidence_deg.to_radians()
        } else {
            (incidence_deg.to_radians().sin() / index).asin()
        };
        let (eta, expected) = closed_form(inside_rad, azimuth_rad, is_pair);
        let found = exact.direction(incidence_deg, azimuth_deg, BINS, RANGE, &rules);
        let l1: f64 = found
            .histogram
            .iter()
            .zip(&expected)
            .map(|(a, b)| (a - b).abs())
            .sum();
        assert!(
            (found.retroreflected - eta).abs() < 1e-12,
            "{incidence_deg} {azimuth_deg}: eta {} not {eta}",
            found.retroreflected
        );
        assert_eq!(found.fate[Fate::OutOfRange as usize], 0.0);
        worst = worst.max(0.5 * l1);
        if eta > 0.0 { nonzero += 1 } else { empty += 1 }
    }
    assert!(
        nonzero >= 100 && empty >= 20,
        "{nonzero} directions return light, {empty} none"
    );
    worst
}

#[test]
fn ideal_cubes_agree_with_the_closed_form() {
    let edges = ideal_edges();
    let mut cases = 0;
    for (name, cell, is_pair) in [
        ("single", single(edges), false),
        ("pair", pair(edges, false), true),
        ("periodic pair", pair(edges, true), true),
    ] {
        for index in [1.0, 1.49] {
            let worst = worst_total_variation(&cell, index, is_pair, 7 + cases);
            println!("{name}, index {index}: total variation {worst:.2e}");
            assert!(worst < 1e-12, "{name}, index {index}: {worst}");
            cases += 1;
        }
    }
    assert_eq!(cases, 6);
}

#[test]
fn listed_fractions_of_the_hollow_cube() {
    let cell = single(ideal_edges());
    let exact = bakes::exact(&cell).unwrap();
    // The model lists five digits.
    let listed = [
        (0.0, 0.0, 2.0 / 3.0),
        (10.0, 0.0, 0.62521),
        (20.0, 0.0, 0.49003),
        (30.0, 0.0, 0.22222),
        (30.0, 30.0, 0.26035),
        (30.0, 60.0, 0.31126),
        (35.0, 0.0, 0.01295),
        (40.0, 60.0, 0.14700),
        (45.0, 60.0, 0.07625),
    ];
    for (incidence, azimuth, eta) in listed {
        let found = exact.direction(incidence, azimuth, 128, 2.0, &rules(1.0));
        assert!(
            (found.retroreflected - eta).abs() < 5.1e-6,
            "({incidence}, {azimuth}): {} not {eta}",
            found.retroreflected
        );
        assert_eq!(
            found.paths.len(),
            1,
            "the six facet sequences are one polygon"
        );
    }
    for (incidence, azimuth) in [
        (40.0, 0.0),
        (40.0, 30.0),
        (45.0, 0.0),
        (45.0, 90.0),
        (89.9, 60.0),
    ] {
        let found = exact.direction(incidence, azimuth, 128, 2.0, &rules(1.0));
        assert_eq!(found.retroreflected, 0.0, "({incidence}, {azimuth})");
        assert!(found.paths.is_empty() && found.histogram.iter().all(|&mass| mass == 0.0));
    }
}

/// Returns the effective area of a full cube perpendicular to the light, from the sorted components
/// of -d on the axes of the cube.
fn full_cube_area(inside_rad: f64, azimuth_rad: f64) -> f64 {
    let back = glam::DVec3::new(
        -inside_rad.sin() * azimuth_rad.cos(),
        -inside_rad.sin() * azimuth_rad.sin(),
        inside_rad.cos(),
    );
    let mut cosines = ideal_edges().map(|edge| edge.dot(back));
    cosines.sort_by(f64::total_cmp);
    let [p, q, r] = cosines;
    if p <= 0.0 {
        0.0
    } else if q <= r / 2.0 {
        4.0 * p * q / r
    } else {
        p * (4.0 - r / q)
    }
}

#[test]
fn the_full_cube_array_returns_the_effective_area() {
    let cell = full_cube();
    let exact = bakes::exact(&cell).unwrap();
    assert_eq!(exact.facet_count(), 3, "each square is one facet");
    let mut draw = Draw(3);
    let (mut nonzero, mut worst) = (0, 0.0_f64);
    for _ in 0..400 {
        let (incidence, azimuth) = (70.0 * draw.next(), 360.0 * draw.next());
        let expected = full_cube_area(incidence.to_radians(), azimuth.to_radians())
            / (3_f64.sqrt() * incidence.to_radians().cos());
        let found = exact.direction(incidence, azimuth, 16, 2.0, &rules(1.0));
        worst = worst.max((found.retroreflected - expected).abs());
        assert!(
            (found.retroreflected - expected).abs() < 1e-10,
            "({incidence}, {azimuth}): {} not {expected}",
            found.retroreflected
        );
        nonzero += usize::from(expected > 0.0);
    }
    println!("full cube: eta within {worst:.2e}");
    assert!(nonzero > 200);
    for (incidence, azimuth, eta) in [
        (0.0, 0.0, 1.0),
        (10.0, 0.0, 0.7506),
        (10.0, 30.0, 0.7276),
        (20.0, 0.0, 0.4853),
        (30.0, 60.0, 0.2570),
        (40.0, 60.0, 0.1008),
    ] {
        let found = exact.direction(incidence, azimuth, 16, 2.0, &rules(1.0));
        assert!(
            (found.retroreflected - eta).abs() < 5.1e-5,
            "({incidence}, {azimuth}): {}",
            found.retroreflected
        );
        assert_eq!(
            found.paths.len(),
            1,
            "({incidence}, {azimuth}): one cube, one polygon"
        );
    }
}

fn mean(cell: &Cell, incidence_deg: Vec<f64>, rules: &Rules) -> Vec<f64> {
    let axes = Axes {
        incidence_deg,
        azimuth_deg: vec![f64::NAN],
        bins: 16,
        range: RANGE,
    };
    let baked = bake(&bakes::exact(cell).unwrap(), &axes, rules, || true).unwrap();
    baked.retroreflected.into_iter().collect()
}

/// Means over all azimuths are those that the model lists. The list has five digits, each rounded
/// by up to 5e-6.
#[test]
fn means_over_azimuths_are_those_of_the_model() {
    let listed = [
        0.66667, 0.65646, 0.62521, 0.57094, 0.49006, 0.38482, 0.26273, 0.12326, 0.04366, 0.01263,
        0.00156,
    ];
    let incidence_deg: Vec<f64> = (0..11).map(|i| 5.0 * f64::from(i)).collect();
    for cell in [single(ideal_edges()), pair(ideal_edges(), true)] {
        let found = mean(&cell, incidence_deg.clone(), &rules(1.0));
        assert_eq!(found.len(), listed.len());
        for ((found, listed), incidence) in found.iter().zip(listed).zip(&incidence_deg) {
            assert!(
                (found - listed).abs() < 1e-5,
                "{incidence} deg: {found} is not {listed}"
            );
        }
    }
}

/// A mean over azimuths finds the azimuths where total reflection fails. There light jumps from all
/// to nothing at once: up to 19.47 deg inside, a cube returns (2/3)(1 - 2 tan^2) at every azimuth,
/// or nothing where a face transmits.
#[test]
fn a_mean_over_azimuths_sees_where_total_reflection_fails() {
    let prism = Rules {
        mirror_back: false,
        ..rules(1.49)
    };
    let limit = (1.0 - 1.0 / (1.49_f64 * 1.49)).sqrt();
    let incidence_deg = vec![15.0, 20.0, 25.0];
    let found = mean(&single(ideal_edges()), incidence_deg.clone(), &prism);
    let mut partly = 0;
    for (found, incidence) in found.into_iter().zip(incidence_deg) {
        let inside = (incidence.to_radians().sin() / 1.49).asin();
        let all = 2.0 / 3.0 * (1.0 - 2.0 * inside.tan().powi(2));
        let many = 1_000_000;
        let survives = |k: &i32| {
            let (sin, cos) =
                ((f64::from(*k) + 0.5) / f64::from(many) * std::f64::consts::TAU).sin_cos();
            let travel = glam::DVec3::new(inside.sin() * cos, inside.sin() * sin, -inside.cos());
            let within = |edge: &glam::DVec3| edge.dot(travel).abs() < limit;
            ideal_edges().iter().all(within)
        };
        let surviving = (0..many).filter(survives).count() as f64 / f64::from(many);
        partly += usize::from(surviving < 1.0);
        // There are six jumps, and the count sees each within 1e-6 of a turn.
        let error = (found - all * surviving).abs();
        assert!(
            error < 1e-5,
            "{incidence} deg: {found} is not {}",
            all * surviving
        );
    }
    assert_eq!(partly, 2, "20 and 25 deg are beyond the limit of 18.94 deg");
}

#[test]
fn total_internal_reflection_fails_where_it_should() {
    // In the model light survives if and only if every |d_i| < sqrt(1 - 1/m^2) on the axes of the
    // cube.
    let cell = single(ideal_edges());
    let exact = bakes::exact(&cell).unwrap();
    let mut draw = Draw(11);
    let (mut lossy, mut whole) = (0, 0);
    for _ in 0..200 {
        let (incidence, azimuth) = (60.0 * draw.next(), 360.0 * draw.next());
        let mirror = rules(1.49);
        let prism = Rules {
            mirror_back: false,
            ..mirror
        };
        let inside = (incidence.to_radians().sin() / 1.49).asin();
        let (sin, cos) = azimuth.to_radians().sin_cos();
        let travel = glam::DVec3::new(inside.sin() * cos, inside.sin() * sin, -inside.cos());
        let limit = (1.0 - 1.0 / (1.49_f64 * 1.49)).sqrt();
        let survives = ideal_edges()
            .iter()
            .all(|edge| edge.dot(travel).abs() < limit);
        let (with, without) = (
            exact.direction(incidence, azimuth, 16, 2.0, &prism),
            exact.direction(incidence, azimuth, 16, 2.0, &mirror),
        );
        assert_eq!(without.fate[Fate::Transmitted as usize], 0.0);
        if survives {
            assert_eq!(with, without);
            whole += 1;
        } else {
            assert_eq!(
                with.retroreflected, 0.0,
                "every returning path meets all three faces"
            );
            assert!(with.fate[Fate::Transmitted as usize] >= without.retroreflected - 1e-14);
            lossy += 1;
        }
    }
    assert!(
        lossy > 20 && whole > 20,
        "{lossy} lossy directions, {whole} others"
    );
}
