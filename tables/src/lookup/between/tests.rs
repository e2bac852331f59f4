//! Interpolation against the closed form of a cube, and cases by hand.

use super::*;
use crate::lookup::course::clipped;
use crate::lookup::shape::{Line, astray};

/// Returns the aperture of an ideal cube of edge 1, its centroid in the origin, its first
/// corner at azimuth 0.
fn triangle() -> Vec<[f64; 2]> {
    let radius = (2.0_f64 / 3.0).sqrt();
    let corner = |k: u32| turned([radius, 0.0], f64::from(k) * 120_f64.to_radians());
    (0..3).map(corner).collect()
}

fn tau(incidence_deg: f64, azimuth_deg: f64) -> [f64; 2] {
    let tangent = incidence_deg.to_radians().tan();
    turned([tangent, 0.0], azimuth_deg.to_radians())
}

/// Returns the path of a cube by its closed form, or `None` if nothing returns.
///
/// Light that enters at p in T leaves at 2 q - p in T, where q is the apex seen along the
/// light.
fn path(tau: [f64; 2], turn: f64) -> Option<Path> {
    let q = tau.map(|x| -x / 3_f64.sqrt());
    let corners: Vec<[f64; 2]> = triangle().iter().map(|&p| turned(p, turn)).collect();
    let mut polygon = corners.clone();
    for (k, a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % 3];
        // Edge of the triangle turned about q by half a turn: the normal changes its sign.
        let normal = [a[1] - b[1], b[0] - a[0]];
        let offset = 2.0 * dot(normal, q) - dot(normal, *a);
        polygon = clipped(&polygon, Line { normal, offset });
    }
    (area(&polygon) > 1e-9).then(|| Path {
        polygon,
        matrix: [[-2.0, 0.0], [0.0, -2.0]],
        offset: q.map(|x| 2.0 * x),
        weight: 1.0,
        deviation: [0.0; 2],
        passes: 0,
        jones: None,
        cube: None,
    })
}

/// Returns directions all around in steps of `step_deg`, each in its own frame.
fn nodes(incidences: &[f64], step_deg: f64, cubes: &[f64]) -> Vec<NearDirection> {
    let azimuths: Vec<f64> = (0..(360.0 / step_deg) as u32)
        .map(|k| f64::from(k) * step_deg)
        .collect();
    let count = (azimuths.len() * incidences.len()) as f64;
    let node = |azimuth: f64, incidence: f64| {
        let (tau, azimuth_rad) = (tau(incidence, azimuth), azimuth.to_radians());
        let paths = cubes.iter().filter_map(|&turn| path(tau, turn));
        let turned = |path: Path| Path {
            polygon: path
                .polygon
                .iter()
                .map(|&p| turned(p, -azimuth_rad))
                .collect(),
            offset: turned(path.offset, -azimuth_rad),
            ..path
        };
        NearDirection {
            tau,
            azimuth_rad,
            paths: paths.map(turned).collect(),
            share: 1.0 / count,
            corner: [0.0; 2],
        }
    };
    let around = azimuths
        .iter()
        .flat_map(|&a| incidences.iter().map(move |&i| node(a, i)));
    around.collect()
}

include!("../../../../tests/eta.rs");

/// Returns the known shares of the hollow cube up to 45 degrees.
fn known() -> Vec<(f64, f64, f64)> {
    let within = |&(incidence, azimuth, _): &(f64, f64, f64)| {
        (1.0..=45.0).contains(&incidence) && !azimuth.is_nan()
    };
    known_eta("cube").into_iter().filter(within).collect()
}

/// Checks an ideal cube between few directions.
///
/// Hexagons lose corners at 19.47 deg and paths end at 35.26 deg. Neither incidence is in the
/// table.
#[test]
fn an_ideal_cube_is_exact_between_few_directions() {
    let whole = area(&triangle());
    let nodes = nodes(&[0.0, 15.0, 28.0], 60.0, &[0.0]);
    let mut cases = 0;
    for (incidence, azimuth, eta) in known() {
        let paths = paths(&nodes, tau(incidence, azimuth), 0.0, 1.0).unwrap();
        let found: f64 = paths.iter().map(|path| area(&path.polygon)).sum();
        // The figures are rounded to 5 digits.
        assert!(
            (found / whole - eta).abs() < 6e-6,
            "{incidence} {azimuth}: {}",
            found / whole
        );
        cases += 1;
    }
    // Below 19.47 deg the share is (2/3)(1 - 2 tan^2); the ridge costs 1e-10 of the slopes.
    for step in 0..200 {
        let (incidence, azimuth) = (f64::from(step) * 0.0973, f64::from(step) * 1.9);
        let paths = paths(&nodes, tau(incidence, azimuth), azimuth.to_radians(), 1.0).unwrap();
        let found: f64 = paths.iter().map(|path| area(&path.polygon)).sum();
        let tangent = incidence.to_radians().tan();
        let eta = 2.0 / 3.0 * (1.0 - 2.0 * tangent * tangent);
        assert!(
            (found / whole - eta).abs() < 1e-8,
            "{incidence}: {} {eta}",
            found / whole
        );
        cases += 1;
    }
    assert_eq!(cases, 212);
}

/// Checks that two cubes stay two: cubes of both orientations look alike at normal incidence,
/// and the families must not mix them.
#[test]
fn a_pair_stays_two_cubes() {
    let half_turn = std::f64::consts::PI;
    let mut cases = 0;
    for step in 0..300 {
        let azimuth = f64::from(step) * 7.3;
        let tau = tau(f64::from(step % 60) * 0.5, azimuth);
        // Keep the two azimuths around and the next ones beyond them.
        let mut nodes = nodes(&[0.0, 15.0, 28.0], 30.0, &[0.0, half_turn]);
        let away = |node: &NearDirection| {
            let away = (node.azimuth_rad.to_degrees() - azimuth).rem_euclid(360.0);
            away.min(360.0 - away)
        };
        nodes.retain(|node| away(node) < 60.0);
        for node in &mut nodes {
            node.share = if away(node) < 30.0 { 1.0 / 6.0 } else { 0.0 };
        }
        let found = paths(&nodes, tau, 0.0, 1.0).unwrap();
        let mut areas: Vec<f64> = found.iter().map(|path| area(&path.polygon)).collect();
        let expected = [0.0, half_turn].map(|turn| path(tau, turn));
        let mut expected: Vec<f64> = expected
            .iter()
            .flatten()
            .map(|p| area(&p.polygon))
            .collect();
        areas.sort_by(f64::total_cmp);
        expected.sort_by(f64::total_cmp);
        assert_eq!(areas.len(), expected.len(), "{step}");
        assert!(
            areas
                .iter()
                .zip(&expected)
                .all(|(a, b)| (a - b).abs() < 1e-8),
            "{step}: {areas:?} {expected:?}"
        );
        cases += 1;
    }
    assert_eq!(cases, 300);
}

#[test]
fn a_path_that_jumps_away_keeps_the_share_of_those_that_have_it() {
    let mut nodes = nodes(&[0.0, 15.0], 60.0, &[0.0]);
    nodes[1].paths.clear();
    let paths = paths(&nodes, tau(10.0, 0.0), 0.0, 1.0).unwrap();
    assert_eq!(paths.len(), 1);
    assert!((paths[0].weight - 11.0 / 12.0).abs() < 1e-9);
}

/// Checks deviations between directions: the light of a path is off by one rotation at every
/// direction, seen through the front face.
#[test]
fn deviations_are_exact_between_directions() {
    let (index, axis) = (1.49, [3e-3, -2e-3, 5e-3]);
    // (M + 1) d for M = -(1 + axis x), a rotation by the angles of `axis` to first order. Any
    // other linear map would do.
    let off = |tau: [f64; 2]| {
        let [x, y, z] = [tau[0], tau[1], -1.0];
        [axis[2] * y - axis[1] * z, axis[0] * z - axis[2] * x]
    };
    let seen = |at: [f64; 2], azimuth_rad: f64| deviation(turned(off(at), -azimuth_rad), at, index);
    let mut nodes = nodes(&[0.0, 15.0, 28.0], 60.0, &[0.0]);
    for node in &mut nodes {
        for path in &mut node.paths {
            path.deviation = seen(node.tau, node.azimuth_rad);
        }
    }
    let mut cases = 0;
    for step in 0..200 {
        let (incidence, azimuth) = (f64::from(step) * 0.0973, f64::from(step) * 1.9);
        let (at, azimuth_rad) = (tau(incidence, azimuth), azimuth.to_radians());
        let paths = paths(&nodes, at, azimuth_rad, index).unwrap();
        let truth = seen(at, azimuth_rad);
        // The angles are about 1e-2, in doubles, through a dozen operations.
        assert!(distance(paths[0].deviation, truth) < 1e-12, "{step}");
        let again = deviation(astray(truth, at, index), at, index);
        assert!(distance(again, truth) < 1e-12, "{step}");
        cases += 1;
    }
    assert_eq!(cases, 200);
}

#[test]
fn what_cannot_be_interpolated_is_not() {
    let mut bent = nodes(&[0.0, 15.0], 60.0, &[0.0]);
    bent[3].paths[0].polygon.insert(1, [0.0, 0.0]);
    assert!(
        paths(&bent, tau(10.0, 0.0), 0.0, 1.0).is_none(),
        "not convex"
    );
    let mut flat = nodes(&[0.0, 15.0], 60.0, &[0.0]);
    flat[3].paths[0].matrix = [[1.0, 2.0], [0.5, 1.0]];
    assert!(
        paths(&flat, tau(10.0, 0.0), 0.0, 1.0).is_none(),
        "no fixed point"
    );
}

/// Weights by hand: on a cross about `tau` the slopes are 0 by symmetry, and the weights are in
/// proportion to the inverse fourth power of the distance.
#[test]
fn weights_fall_with_the_fourth_power_of_the_distance() {
    let cross = [[1.5, 0.5], [-0.5, 0.5], [0.5, 2.5], [0.5, -1.5]];
    let found = weights(&cross, [0.5, 0.5]);
    let expected = [8.0 / 17.0, 8.0 / 17.0, 1.0 / 34.0, 1.0 / 34.0];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }
}

/// Computes a deviation by Snell's law in three dimensions, from its definition alone: light is
/// launched down along (tau, 0, -1) and leaves along (off, 0) less that.
#[test]
fn deviations_follow_snells_law() {
    let index = 1.49;
    let outside = |inside: [f64; 3]| {
        let length = inside.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [x, y] = [0, 1].map(|k| index * inside[k] / length);
        [x, y, (1.0 - x * x - y * y).sqrt()]
    };
    let scalar = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut cases = 0;
    for tangent in [0.0, 0.2, 0.5, 0.8] {
        let back = outside([-tangent, 0.0, 1.0]);
        // The axis across the way back, in the plane of incidence, towards u.
        let across = [back[2], 0.0, -back[0]];
        for [x, y] in [[3e-3, 0.0], [0.0, -2e-3], [-4e-3, 5e-3]] {
            // A small rotation keeps the length of the light's direction.
            let steep = 1.0 + tangent * tangent;
            let along = [x - tangent, y];
            let up = (steep - along[0] * along[0] - along[1] * along[1]).sqrt();
            let left = outside([along[0], along[1], up]);
            let straight = scalar(left, back);
            let expected = [scalar(left, across) / straight, left[1] / straight];
            let tau = [tangent, 0.0];
            let found = deviation([x, y], tau, index);
            // Angles of 1e-2 from sums of numbers up to 1, divided by cosines above 0.3.
            assert!(distance(found, expected) < 1e-14, "{found:?} {expected:?}");
            assert!(distance(astray(expected, tau, index), [x, y]) < 1e-14);
            cases += 1;
        }
    }
    assert_eq!(cases, 12);
}

/// A direction that lacks a path counts as a jump if the path's lines leave more than a quarter
/// of its area there. The area that they leave is known from the closed form.
#[test]
fn a_path_jumps_away_above_a_quarter_of_its_area() {
    let area_at = |incidence| path(tau(incidence, 0.0), 0.0).map_or(0.0, |p| area(&p.polygon));
    let held = area_at(15.0);
    for (part, expected) in [(0.26, 6.0 / 7.0), (0.24, 1.0)] {
        let (mut low, mut high) = (20.0, 36.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if area_at(middle) > part * held {
                low = middle;
            } else {
                high = middle;
            }
        }
        let mut nodes = nodes(&[15.0], 60.0, &[0.0]);
        nodes.push(NearDirection {
            tau: tau(low, 0.0),
            azimuth_rad: 0.0,
            paths: Vec::new(),
            share: 1.0,
            corner: [0.0; 2],
        });
        nodes.iter_mut().for_each(|node| node.share = 1.0 / 7.0);
        let found = paths(&nodes, tau(10.0, 0.0), 0.0, 1.0).unwrap();
        assert_eq!(found.len(), 1);
        assert!((found[0].weight - expected).abs() < 1e-15, "{part}");
    }
}

/// Returns a path of weight 1 that mirrors `polygon` at the origin.
fn point_mirror(polygon: Vec<[f64; 2]>) -> Path {
    Path {
        polygon,
        matrix: [[-2.0, 0.0], [0.0, -2.0]],
        offset: [0.0; 2],
        weight: 1.0,
        deviation: [0.0; 2],
        passes: 0,
        jones: None,
        cube: None,
    }
}

/// The square of the third direction lacks the edge across a corner that the first two have.
/// That edge moves out by too little to clear the corner by itself. In its own direction the
/// square stays whole.
#[test]
fn a_line_keeps_clear_of_a_polygon_that_lacks_it() {
    let node = |x: f64, cut: f64| {
        let corner = [[1.0, 1.0 - cut], [1.0 - cut, 1.0]];
        let mut polygon = vec![[-1.0, -1.0], [1.0, -1.0]];
        polygon.extend(&corner[..if cut > 0.0 { 2 } else { 1 }]);
        polygon.push([-1.0, 1.0]);
        NearDirection {
            tau: [x, 0.0],
            azimuth_rad: 0.0,
            paths: vec![point_mirror(polygon)],
            share: 1.0 / 3.0,
            corner: [0.0; 2],
        }
    };
    // Continued to 0.2, the edge would cut off 0.3 of both sides.
    let nodes = [node(0.0, 0.5), node(0.1, 0.4), node(0.2, 0.0)];
    for (node, expected) in nodes.iter().zip([4.0 - 0.125, 4.0 - 0.08, 4.0]) {
        let found = paths(&nodes, node.tau, 0.0, 1.0).unwrap();
        assert_eq!(found.len(), 1);
        // The cuts of the square round by an ulp of 1000, the size of the first frame.
        let area = found[0].area();
        assert!((area - expected).abs() < 1e-12, "{area} {expected}");
    }
}

/// Returns two directions at `at` and `-at` in tau, each with half of the share and one
/// polygon.
fn two(at: f64, polygons: [Vec<[f64; 2]>; 2]) -> [NearDirection; 2] {
    let mut side = 1.0;
    polygons.map(|polygon| {
        side = -side;
        NearDirection {
            tau: [side * at, 0.3],
            azimuth_rad: 0.0,
            paths: vec![point_mirror(polygon)],
            share: 0.5,
            corner: [0.0; 2],
        }
    })
}

/// Two paths have one polygon and one exit direction, as two facet orders of a cube with errors
/// may have near normal incidence, but turn the light about the normal by opposite angles. They
/// are told apart in whatever order a direction lists them.
#[test]
fn paths_are_told_apart_by_their_turn_about_the_normal() {
    let turn = 4e-4;
    let path = |turn: f64| Path {
        matrix: [[-2.0, -turn], [turn, -2.0]],
        deviation: [1e-3, 0.0],
        ..point_mirror(square(1.0, 0.0))
    };
    let mut nodes = two(0.01, [square(1.0, 0.0), square(1.0, 0.0)]);
    nodes[0].paths = vec![path(turn), path(-turn)];
    nodes[1].paths = vec![path(-turn), path(turn)];
    let found = paths(&nodes, [0.0, 0.3], 0.0, 1.0).unwrap();
    let mut turns: Vec<f64> = found.iter().map(|path| path.matrix[1][0]).collect();
    turns.sort_by(f64::total_cmp);
    assert_eq!(turns.len(), 2);
    // Means of equal numbers; the matrices have ulps of 2.
    assert!(
        (turns[0] + turn).abs() < 1e-15 && (turns[1] - turn).abs() < 1e-15,
        "{turns:?}"
    );
}

/// Returns the square of half side `half`, turned by `turn` about its centre in the origin.
fn square(half: f64, turn: f64) -> Vec<[f64; 2]> {
    let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
    corners.map(|p| turned(p, turn)).to_vec()
}
