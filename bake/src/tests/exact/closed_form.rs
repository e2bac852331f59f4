//! Ideal cubes, whose whole distribution is known.
//!
//! The oracle carries the apex along the light to the aperture plane, at q. Light that enters at p
//! leaves at 2q - p. So the shift is uniform over 2(q - K), with K the intersection of the aperture
//! T and its point reflection through q. The oracle has polygon code of its own and computes bins
//! by clipping the polygon at the sides of each bin. It shares nothing with the crate.

use crate::beams::bake;
use crate::optics::Rules;
use crate::tests::bakes;
use crate::tests::cells;
use glam::DVec2;
use meshes::Cell;
use tables::{Axes, Fate};

use crate::tests::cells::full_cube;
use crate::tests::exact::cells::{Draw, ideal_edges, pair, single};

const BINS: usize = 128;
const RANGE: f64 = 2.0;

/// Returns eta and eta x histogram of one cube, at the inside angle and the azimuth from its first
/// edge.
fn cube(inside_rad: f64, azimuth_rad: f64) -> (f64, Vec<f64>) {
    let (sine, cosine) = inside_rad.sin_cos();
    let along = DVec2::from_angle(azimuth_rad);
    let (eta, shifts) = cells::closed_form((along * sine).extend(-cosine), 0.0);
    // The shifts in the incidence frame, whose first axis is along the light.
    let shifts: Vec<DVec2> = shifts
        .iter()
        .map(|&shift| DVec2::new(along.dot(shift), along.perp_dot(shift)))
        .collect();
    // The map of the shift has determinant 4.
    let whole = 4.0 * cells::area(&ideal_edges().map(|edge| edge.truncate()));
    let bins = cells::bin_areas(&shifts, BINS, RANGE).into_iter();
    (eta, bins.map(|area| area / whole).collect())
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
    let rules = Rules::mirrors(index);
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
    let mut dark = 0;
    for (incidence, azimuth, eta) in cells::listed("cube") {
        let found = exact.direction(incidence, azimuth, 128, 2.0, &Rules::mirrors(1.0));
        // The list has five digits.
        let off = (found.retroreflected - eta).abs();
        assert!(off < 5.1e-6, "({incidence}, {azimuth}): {off:e}");
        if eta == 0.0 {
            assert_eq!(found.retroreflected, 0.0, "({incidence}, {azimuth})");
            assert!(found.paths.is_empty() && found.histogram.iter().all(|&mass| mass == 0.0));
            dark += 1;
        } else {
            assert_eq!(found.paths.len(), 1, "the six sequences are one polygon");
        }
    }
    assert_eq!(dark, 5);
}

#[test]
fn listed_fractions_of_the_full_cube_array() {
    let cell = full_cube();
    let exact = bakes::exact(&cell).unwrap();
    assert_eq!(exact.facet_count(), 3, "each square is one facet");
    for (incidence, azimuth, eta) in cells::listed("array") {
        let found = exact.direction(incidence, azimuth, 16, 2.0, &Rules::mirrors(1.0));
        let off = (found.retroreflected - eta).abs();
        assert!(off < 5.1e-5, "({incidence}, {azimuth}): {off:e}");
        assert_eq!(found.paths.len(), 1, "one cube, one polygon");
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
    let (incidence_deg, listed) = cells::listed_means();
    for cell in [single(ideal_edges()), pair(ideal_edges(), true)] {
        let found = mean(&cell, incidence_deg.clone(), &Rules::mirrors(1.0));
        assert_eq!(found.len(), listed.len());
        for ((found, listed), incidence) in found.iter().zip(&listed).zip(&incidence_deg) {
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
        ..Rules::mirrors(1.49)
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
        let mirror = Rules::mirrors(1.49);
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
            // The six orders of the facets stay apart, because each turns the polarisation. Sums
            // over their bins round by 1e-16 a path.
            assert!(with.paths.len() >= without.paths.len() && with.paths.len() <= 6);
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14);
            assert!(near(&with.fate, &without.fate) && near(&with.histogram, &without.histogram));
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
