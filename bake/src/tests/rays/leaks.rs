//! Rays aimed exactly at shared edges and at the apex, and rays relaunched from where they hit.
//!
//! That no such ray is lost is tested in `hard_cases::leaks`.

use crate::tests::cells;

use crate::geometry::{Stream, centred};
use crate::optics::{Incidence, Rules, reflect};
use crate::rays::{Event, Index, Scene, trace};
use glam::DVec3;
use tables::Fate;
use tables::options::Sampler;

use crate::tests::hard_cases::leaks::inside;

const MIRROR: Rules = Rules::mirrors(1.0);

/// Returns three numbers in (0, 1) as functions of the index.
fn numbers(index: u64) -> [f64; 3] {
    let stream = Stream::new(Sampler::Random, 2024, 0.0, 0.0, 0);
    let [a, b] = stream.pair(index);
    [a, b, stream.third(index)].map(|cell| centred(cell) + 0.5)
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
