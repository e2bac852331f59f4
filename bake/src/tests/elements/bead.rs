//! A glass bead on its mirror, in closed form.
//!
//! Let light meet a sphere of radius r and index n at the distance b from the line through its
//! centre. Refraction turns it from theta = asin(b / r) into theta' = asin(b / (r n)); then follow
//! one reflection and a second refraction. The light leaves at the angle 2 theta - 4 theta' from
//! straight back, away from the axis if positive. The line on which it leaves has the distance b
//! from the centre too.

use crate::optics::{Incidence, Rules};
use crate::plan::{Plan, Request};
use crate::rays::{Index, Scene, trace};
use crate::tests::bakes;
use crate::tests::cells::of_mesh;
use glam::{DVec2, DVec3};
use meshes::Cell;
use meshes::design::Bead;
use tables::Fate;
use tables::options::{NormalsFrom, Sampler, SceneOptions};

fn cell(diameter: f64, segments: u32) -> Cell {
    let bead = Bead {
        pitch: 2.0,
        diameter,
        segments,
    };
    let mesh = bead.mesh().expect("a legal design");
    of_mesh(&mesh, |o| (o.file_normals, o.glass) = (true, true))
}

/// Returns the angle from straight back, rad, for a bead of radius 1.
fn turn(b: f64, index: f64) -> f64 {
    2.0 * b.asin() - 4.0 * (b / index).asin()
}

/// Returns the direction in which light leaves a bead of radius `r` and the point of its line at
/// the height `top` above the centre. The light arrives along `travel` on a line `beside` the
/// centre.
fn leaving(travel: DVec3, beside: DVec3, r: f64, index: f64, top: f64) -> (DVec3, DVec2) {
    let b = beside.length();
    let outward = beside / b;
    let (sin, cos) = turn(b / r, index).sin_cos();
    let direction = outward * sin - travel * cos;
    let foot = -(outward * cos + travel * sin) * b;
    (
        direction,
        (foot + direction * ((top - foot.z) / direction.z)).truncate(),
    )
}

/// Each ray leaves at the place and in the direction of the closed form, for sparse beads and for
/// dense ones. Dense beads overlap the walls of their lattice's prisms, where light passes between
/// neighbours.
///
/// Place and direction are off by the square of the facets' size: a facet's sag and the error of an
/// interpolated normal. So a quarter of the size should leave a 16th of the rms. The limits are
/// 1/12 and 1/20, because a cap of some facets sees only one pattern of them.
#[test]
fn rays_converge_to_the_meridional_trace() {
    let index = 1.93;
    let mut checked = 0;
    for (diameter, incidence, azimuth, part) in [
        (0.3, 0.0_f64, 0.7_f64, 0.85),
        (0.3, 15.0, 0.7, 0.85),
        (0.3, 30.0, 0.7, 0.85),
        (0.95, 30.0, 0.0, 0.6),
        (0.95, 40.0, 2.0, 0.5),
    ] {
        let r = diameter / 2.0;
        let direction = Incidence::new(incidence.to_radians(), azimuth, 1.0);
        let mut errors = Vec::new();
        for segments in [12, 24, 48] {
            let cell = cell(diameter, segments);
            let scene = Scene::new(&cell, Index::Auto);
            // All light that leaves upward counts as retroreflected, so that every exit is looked
            // at.
            let rules = Rules {
                glass_index: Some(index),
                angular_tolerance_rad: 0.17,
                ..Rules::mirrors(1.0)
            };
            let centre = DVec3::new(0.0, 0.0, r);
            let (mut sum, mut rays) = (0.0, 0);
            for k in 0..4000 {
                // The rays are spread evenly over the disc of the bead without its rim, which is
                // behind the equator at 30 degrees. The first ray at normal incidence runs along an
                // edge of facets.
                let b = part * r * ((f64::from(k) + 0.5) / 4000.0).sqrt();
                let around = f64::from(k) * 2.399_963;
                let across = direction.travel.any_orthonormal_pair();
                let beside = across.0 * (b * around.cos()) + across.1 * (b * around.sin());
                let line = centre + beside;
                let travel = direction.travel;
                let point = (line + travel * ((scene.height() - line.z) / travel.z)).truncate();
                let outcome = trace(&scene, &rules, &direction, point, 0.5);
                let (way, exit) = leaving(travel, beside, r, index, r);
                let angle = turn(b / r, index).abs();
                if angle > 0.16 {
                    continue;
                }
                assert_eq!(outcome.fate, Fate::Retroreflected, "{incidence}, {b}");
                assert_eq!(outcome.bounces, 1);
                let shift = direction.to_frame(exit - point);
                sum += (outcome.shift - shift).length_squared() / (r * r)
                    + (outcome.travel - way).length_squared();
                rays += 1;
            }
            errors.push((sum / f64::from(rays)).sqrt());
            checked += rays;
        }
        println!("diameter {diameter}, incidence {incidence}: rms errors {errors:.6?}");
        let ratio = errors[0] / errors[2];
        assert!((12.0..20.0).contains(&ratio), "{incidence}: {errors:?}");
        assert!(errors[2] < 5e-4, "{errors:?}");
    }
    println!("{checked} rays");
    assert!(checked > 20_000);
}

/// The share within the angular tolerance at normal incidence is that of the closed form: of the
/// intervals of b with |2 theta - 4 theta'| below the tolerance. The beads are as dense as
/// possible, with several indices. The limit is 4.5 sigma of the count plus the error of the
/// facets.
#[test]
fn shares_are_those_of_rings() {
    let (diameter, rays) = (0.95, 1 << 15);
    let r: f64 = diameter / 2.0;
    let mut shares = Vec::new();
    for (index, tolerance_deg) in [(1.93, 2.0), (1.93, 0.5), (2.0, 5.0), (1.8, 4.0), (1.5, 5.0)] {
        let request = Request {
            incidence: "0".into(),
            sampler: Sampler::Random,
            rays: Some(rays),
            angular_tolerance_deg: tolerance_deg,
            scene: SceneOptions {
                normals: NormalsFrom::File,
                glass_index: Some(index),
                ..SceneOptions::default()
            },
            ..Request::default()
        };
        let plan = Plan::new(&request).expect("a valid request");
        let table = bakes::bake(&cell(diameter, 64), &plan).expect("bakes");
        // With midpoints of 10^5 rings, the ends of an interval are known to 1e-5 of r.
        let steps = 100_000;
        let within = |k: &i32| {
            let b = (f64::from(*k) + 0.5) / f64::from(steps);
            turn(b, index).abs() <= f64::to_radians(tolerance_deg)
        };
        let ring = |k: i32| 2.0 * (f64::from(k) + 0.5) / f64::from(steps).powi(2);
        let part: f64 = (0..steps).filter(within).map(ring).sum();
        let area = 0.75_f64.sqrt();
        let expected = part * std::f64::consts::PI * r * r / area;
        let found = table.retroreflected[[0, 0]];
        let sigma = (expected * (1.0 - expected) / rays as f64).sqrt();
        // A direction is off by some (pi / 2 / 64)^2 / 2 = 3e-4 rad, which is 2 % of the narrowest
        // tolerance.
        let facets = 3e-4 / f64::to_radians(tolerance_deg) * expected;
        assert!(
            (found - expected).abs() < 4.5 * sigma + facets,
            "index {index}, {tolerance_deg} deg: {found}, not {expected}"
        );
        let between = table.fate[[0, 0, Fate::Missed as usize]];
        let gaps = 1.0 - std::f64::consts::PI * r * r / area;
        assert!(
            (between - gaps).abs() < 4.5 * (gaps / rays as f64).sqrt() + 1e-3,
            "{between}"
        );
        shares.push(found);
    }
    println!("shares {shares:.4?}");
    assert!(shares[0] > shares[1] && shares.len() == 5);
}
