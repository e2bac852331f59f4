//! Rays aimed exactly at shared edges and at the apex, and rays relaunched from where they hit.
//! None may be lost.

use crate::tests::cells;

use crate::optics::{Incidence, Rules, reflect};
use crate::rays::{Event, Index, Scene, trace};
use crate::samples::{Stream, centred};
use glam::{DVec2, DVec3};
use meshes::Cell;
use tables::Fate;
use tables::options::Sampler;

const MIRROR: Rules = Rules::mirrors(1.0);

/// Returns three numbers in (0, 1) as functions of the index.
fn numbers(index: u64) -> [f64; 3] {
    let stream = Stream::new(Sampler::Random, 2024, 0.0, 0.0, 0);
    let [a, b] = stream.pair(index);
    [a, b, stream.third(index)].map(|cell| centred(cell) + 0.5)
}

fn inside(polygon: &[DVec2], p: DVec2, margin: f64) -> bool {
    (0..polygon.len()).all(|i| {
        let side = polygon[(i + 1) % polygon.len()] - polygon[i];
        side.perp_dot(p - polygon[i]) >= margin * side.length()
    })
}

/// Returns whether a ray has leaked. A ray that left the cell must travel upward; one that travels
/// downward has gone through a mirror.
fn has_leaked(fate: Fate, travel: DVec3) -> bool {
    matches!(fate, Fate::Missed | Fate::Absorbed | Fate::BounceLimit) || travel.z <= 0.0
}

/// Traces rays through points of the edges that facets share, and through the apex. Returns the
/// numbers of rays and of leaks.
fn aimed(cell: &Cell, index: Index, targets: &[(DVec3, DVec3)], rays: u64) -> (u64, u64) {
    let scene = Scene::new(cell, index);
    let (mut launched, mut leaks) = (0, 0);
    let mut sample = 0;
    while launched < rays {
        let [a, b, c] = numbers(sample);
        sample += 1;
        let (from, to) = targets[(sample % targets.len() as u64) as usize];
        // Every eighth ray aims at the apex itself, and some aim at round fractions of the edge.
        let along = match sample % 8 {
            0 => 0.0,
            1 => (c * 16.0).floor() / 16.0,
            _ => c,
        };
        let target = from + (to - from) * along;
        // Incidences go up to 89.9 deg. Azimuths are often multiples of 15 deg, where rays run in
        // planes of symmetry.
        let azimuth = if sample % 3 == 0 {
            (b * 24.0).floor() * 15.0
        } else {
            b * 360.0
        };
        let direction = Incidence::new((a * 89.9).to_radians(), azimuth.to_radians(), 1.0);
        let back = (scene.height() - target.z) / direction.travel.z;
        let entry = target.truncate() + direction.travel.truncate() * back;
        if !scene.is_periodic() && !inside(&cell.entrance.polygon, entry, 0.0) {
            continue;
        }
        launched += 1;
        let outcome = trace(&scene, &MIRROR, &direction, entry, 0.5);
        leaks += u64::from(has_leaked(outcome.fate, outcome.travel));
    }
    (launched, leaks)
}

#[test]
fn a_million_rays_at_edges_and_apices() {
    let ends = cells::edges(0.0);
    let edges = ends.map(|end| (DVec3::ZERO, end));
    let cube = aimed(&cells::triangular(), Index::Loop, &edges, 600_000);
    let hierarchy = aimed(&cells::triangular(), Index::Hierarchy, &edges, 100_000);
    let pair = aimed(&cells::pair(), Index::Loop, &edges, 200_000);
    // The array adds the ridges between neighbours and the seams inside the square faces.
    let mut seams = edges.to_vec();
    for i in 0..3 {
        let (a, b) = (ends[i], ends[(i + 1) % 3]);
        seams.extend([(a + b, a), (a + b, b), (DVec3::ZERO, a + b)]);
    }
    let array = aimed(&cells::full_cube(), Index::Loop, &seams, 50_000);
    let array_hierarchy = aimed(&cells::full_cube(), Index::Hierarchy, &seams, 50_000);
    let all = [cube, hierarchy, pair, array, array_hierarchy];
    assert_eq!(all.iter().map(|(rays, _)| rays).sum::<u64>(), 1_000_000);
    println!("rays and leaks: {all:?}");
    assert_eq!(all.map(|(_, leaks)| leaks), [0; 5]);
}

/// Aimed rays have the fates and shifts of the closed form, away from its boundary.
#[test]
fn aimed_rays_have_the_right_shift() {
    let cell = cells::triangular();
    let scene = Scene::new(&cell, Index::Loop);
    let ends = cells::edges(0.0);
    let triangle = &cell.entrance.polygon;
    let (mut back, mut lost) = (0, 0);
    for sample in 0..200_000 {
        let [a, b, c] = numbers(sample);
        let direction = Incidence::new((a * 60.0).to_radians(), b * std::f64::consts::TAU, 1.0);
        let target = if sample % 5 == 0 {
            DVec3::ZERO
        } else {
            ends[(sample % 3) as usize] * c
        };
        let along = |z: f64| direction.travel * ((scene.height() - z) / direction.travel.z);
        let entry = (target + along(target.z)).truncate();
        let q = along(0.0).truncate();
        let outcome = trace(&scene, &MIRROR, &direction, entry, 0.5);
        if inside(triangle, entry, 1e-9) && inside(triangle, 2.0 * q - entry, 1e-9) {
            assert_eq!(outcome.fate, Fate::Retroreflected, "sample {sample}");
            let expected = direction.to_frame(2.0 * (q - entry));
            assert!(
                (outcome.shift - expected).length() < 1e-12,
                "sample {sample}"
            );
            back += 1;
        } else if inside(triangle, entry, 0.0) && !inside(triangle, 2.0 * q - entry, -1e-9) {
            assert_ne!(outcome.fate, Fate::Retroreflected, "sample {sample}");
            lost += 1;
        }
    }
    assert!(
        back > 30_000 && lost > 30_000,
        "{back} returned, {lost} did not"
    );
}

/// A ray relaunched from its hit never meets the facet that it leaves. It meets each other facet
/// from the front, is reflected at most three times and leaves upward.
#[test]
fn a_million_relaunched_rays() {
    let cell = cells::triangular();
    let scene = Scene::new(&cell, Index::Loop);
    let (mut relaunched, mut sample) = (0_u64, 0);
    while relaunched < 1_000_000 {
        let [a, b, c] = numbers(sample);
        sample += 1;
        // Half of the rays graze: the cosines with the plane of the aperture go down to 1e-9.
        let grazing = std::f64::consts::FRAC_PI_2 - 10_f64.powf(-9.0 * c);
        let incidence = if sample % 2 == 0 { grazing } else { c * 1.55 };
        let direction = Incidence::new(incidence.max(0.0), a * std::f64::consts::TAU, 1.0);
        let corners = &cell.entrance.polygon;
        let entry = corners[0]
            + (corners[1] - corners[0]) * a.max(b)
            + (corners[2] - corners[1]) * a.min(b);
        let mut ray = scene.enter(entry, direction.travel);
        let mut last = None;
        let mut bounces = 0;
        while let Event::Hit {
            arrival,
            normal,
            front,
            ..
        } = scene.next(&ray)
        {
            assert!(front, "sample {sample} came out behind a mirror");
            assert_ne!(
                last,
                Some(normal),
                "sample {sample} hit the facet that it left"
            );
            last = Some(normal);
            ray = arrival;
            ray.direction = reflect(ray.direction, normal);
            bounces += 1;
            relaunched += 1;
        }
        // The three mirrors are at right angles, so each reflects a ray at most once.
        assert!(
            (1..=3).contains(&bounces),
            "sample {sample} was reflected {bounces} times"
        );
        assert!(ray.direction.z > 0.0, "sample {sample} left downward");
    }
}
