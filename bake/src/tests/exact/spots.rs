//! Dihedral errors: the direction of the light of each path.
//!
//! There are two oracles: the closed form of the six spots, and single rays that the other method
//! reflects facet by facet.

use crate::optics::{Backing, Incidence, Rules};
use crate::rays::{Index, Scene, trace};
use crate::tests::bakes;
use crate::tests::cells::designed;
use glam::{DVec2, DVec3};
use meshes::Cell;
use meshes::design::{Design, Shape};
use tables::Path;

use crate::tests::exact::cells::Draw;

fn cell(dihedral_error_rad: [f64; 3]) -> Cell {
    designed(&Design {
        dihedral_error_rad,
        ..Design::new(Shape::Triangular)
    })
}

fn paths(cell: &Cell, incidence: f64, azimuth: f64, rules: &Rules) -> Vec<Path> {
    let exact = bakes::exact(cell).unwrap();
    exact.direction(incidence, azimuth, 8, 2.0, rules).paths
}

/// Returns the distinct directions of the paths.
fn spots(paths: &[Path]) -> Vec<DVec2> {
    let mut spots: Vec<DVec2> = Vec::new();
    for path in paths {
        let spot = DVec2::from_array(path.deviation);
        if spots.iter().all(|known| (spot - known).length() > 1e-9) {
            spots.push(spot);
        }
    }
    spots
}

/// Spots are where the model has them. Three equal errors e give six spots at 4 sqrt(2/3) e (1 -
/// e/2), to second order. One error gives two spots at 1.633 e, to first order. Behind a front face
/// of index m the sine is m times as large.
#[test]
fn spots_are_where_the_model_has_them() {
    let mut cases = 0;
    for error in [-1e-3, -3e-4, 1e-5, 1e-4, 3e-4, 1e-3_f64] {
        for index in [1.0, 1.49] {
            let outside = |inside: f64| (index * inside.sin()).asin();
            // The third order is some e^3, here 1e-9 at most.
            let slack = 10.0 * error.abs().powi(3) + 1e-12;
            let rules = Rules::mirrors(index);
            let six = spots(&paths(&cell([error; 3]), 0.0, 0.0, &rules));
            assert_eq!(six.len(), 6);
            let expected = 4.0 * (2.0_f64 / 3.0).sqrt() * error.abs() * (1.0 - error / 2.0);
            for spot in six {
                let found = spot.length().atan();
                let off = (found - outside(expected)).abs();
                assert!(
                    off < index * slack,
                    "{error}, {index}: {found} is off by {off:e}"
                );
                cases += 1;
            }
            let two = spots(&paths(&cell([error, 0.0, 0.0]), 0.0, 0.0, &rules));
            assert_eq!(two.len(), 2);
            for spot in two {
                let expected = outside(2.0 * (2.0_f64 / 3.0).sqrt() * error.abs());
                // The tolerance is the second order.
                let off = (spot.length().atan() - expected).abs();
                assert!(
                    off < 4.0 * index * error * error,
                    "{error}, {index}: {off:e}"
                );
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 12 * 8);
}

#[test]
fn right_angles_deviate_nothing() {
    let cell = cell([0.0; 3]);
    let mut draw = Draw(41);
    let mut cases = 0;
    for surface in [None, Some(Backing::Bare)] {
        for _ in 0..50 {
            let (incidence, azimuth) = (60.0 * draw.next(), 360.0 * draw.next());
            let rules = Rules {
                losses: surface,
                ..Rules::mirrors(1.49)
            };
            for path in paths(&cell, incidence, azimuth, &rules) {
                assert_eq!(path.deviation, [0.0; 2]);
                cases += 1;
            }
        }
    }
    assert!(cases > 100, "{cases}");
}

/// The direction of each path equals that of a ray through the middle of its polygon, refracted by
/// angles.
#[test]
fn directions_are_those_of_rays() {
    let mut draw = Draw(43);
    let mut cases = 0;
    for _ in 0..60 {
        let errors = [0, 1, 2].map(|_| 4e-3 * (draw.next() - 0.5));
        let cell = cell(errors);
        let scene = Scene::new(&cell, Index::Loop);
        let (incidence, azimuth) = (50.0 * draw.next(), 360.0 * draw.next());
        let rules = Rules::mirrors(1.49);
        let (theta, phi) = (incidence.to_radians(), azimuth.to_radians());
        let light = Incidence::new(theta, phi, 1.49);
        for path in paths(&cell, incidence, azimuth, &rules) {
            let n = path.polygon.len() as f64;
            let middle: DVec2 = path
                .polygon
                .iter()
                .map(|&p| DVec2::from_array(p))
                .sum::<DVec2>()
                / n;
            let entry = middle.x * light.u + middle.y * light.v();
            let out = trace(&scene, &rules, &light, entry, 0.5).travel;
            // The angles are spherical and outside: from the normal, and about it from u.
            let polar = (1.49 * out.truncate().length()).asin();
            let about = light.to_frame(out.truncate()).to_angle();
            let out = DVec3::new(
                polar.sin() * about.cos(),
                polar.sin() * about.sin(),
                polar.cos(),
            );
            let back = DVec3::new(-theta.sin(), 0.0, theta.cos());
            let expected = out / out.dot(back) - back;
            let [across, along] = path.deviation;
            let found = across * DVec3::new(theta.cos(), 0.0, theta.sin()) + along * DVec3::Y;
            assert!(
                (found - expected).length() < 1e-13,
                "{found} is not {expected}"
            );
            cases += 1;
        }
    }
    assert!(cases > 200, "{cases}");
}
