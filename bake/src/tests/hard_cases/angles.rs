//! Grazing light, the two sides of a cutoff, an index next to 1, and cells that return nothing.

use crate::optics::Incidence;
use crate::tests::cells::closed_form;
use crate::tests::hard_cases::both::{BothOptions, cell};
use meshes::design::Shape;
use tables::Fate;
use tables::options::Method;

/// Returns eta of one ideal cube by the closed form. The first edge is at azimuth 0, and angles are
/// outside, degrees.
fn eta(incidence_deg: f64, azimuth_deg: f64, index: f64) -> f64 {
    let direction = Incidence::new(incidence_deg.to_radians(), azimuth_deg.to_radians(), index);
    closed_form(direction.travel, 0.0).0
}

/// At 89.9 deg light is neither lost nor made, and both methods agree, for every design, hollow and
/// solid.
#[test]
fn grazing_incidence() {
    let (mut cases, mut worst, mut returning) = (0, 0.0_f64, 0);
    for shape in Shape::ALL {
        for index in [1.0, 1.49] {
            let mut light = BothOptions::new("89.9", "0,30,77,180").inside(index);
            if shape == Shape::FullCube && index == 1.0 {
                // A ray crosses hundreds of cells before it meets a mirror, which makes 0.04
                // million rays a second.
                light.rays = 20_000;
            }
            let both = light.on(&format!("{} at 89.9 deg", shape.name()), &cell(shape));
            worst = worst.max(both.sigmas());
            returning += both
                .exact
                .retroreflected
                .iter()
                .filter(|&&eta| eta > 0.0)
                .count();
            cases += both.exact.retroreflected.len();
        }
    }
    println!("89.9 deg: {cases} directions, {returning} return light, worst fate {worst:.2} sigma");
    assert_eq!(cases, Shape::ALL.len() * 2 * 4);
    // Hollow cubes are cut off. Behind a front face light arrives at 42 deg.
    assert!((4..=16).contains(&returning), "{returning}");
    let solid = BothOptions::new("89.9", "60")
        .inside(1.49)
        .on("solid", &cell(Shape::Triangular));
    let error = (solid.exact.retroreflected[[0, 0]] - eta(89.9, 60.0, 1.49)).abs();
    println!("89.9 deg, solid cube: eta within {error:.1e} of the closed form");
    assert!(error < 1e-13);
}

/// Both methods agree for light along the rows of the full-cube lattice. At 0.1 deg it skims
/// hundreds of cubes and meets a few sides of each. A beam falls into many parts, which see the
/// facets far ahead in common. 0.01 of the light is 5 standard errors.
#[test]
#[ignore = "half a minute: `make test-slowest` runs it"]
fn grazing_incidence_along_the_rows_of_a_lattice() {
    let cube = cell(Shape::FullCube);
    let mut light = BothOptions::new("89.8,89.9", "29.9,29.99,30,150");
    light.rays = 40_000;
    let both = light.on("along the rows", &cube);
    let mut cases = 0;
    for ((i, a), eta) in both.exact.retroreflected.indexed_iter() {
        let after = |fate: Fate| both.exact.fate[[i, a, fate as usize]];
        let [one, two] = [Fate::LeftAfter1, Fate::LeftAfter2].map(after);
        println!(
            "along the rows, direction {i}, {a}: {one:.5} after one mirror, {two:.5} after two"
        );
        assert_eq!(*eta, 0.0);
        assert!((one + two - 1.0).abs() < 1e-10 && two > 0.1, "{one} {two}");
        cases += 1;
    }
    // The rows at 30 and 150 deg are alike.
    for i in 0..2 {
        let [one, other] = [2, 3].map(|a| both.exact.fate[[i, a, Fate::LeftAfter1 as usize]]);
        assert!((one - other).abs() < 1e-10, "{one} {other}");
    }
    println!(
        "along the rows: {cases} directions, worst fate {:.2} sigma",
        both.sigmas()
    );
    assert_eq!(cases, 8);
}

/// Both methods see the cutoffs at the same angle. A hollow cube cuts off where q, the apex seen
/// along the light, leaves the triangle: tan theta = sqrt(1/2) over a side (35.26 deg), sqrt 2 over
/// a corner (54.74 deg).
///
/// Over a side the share falls to 0 in proportion to the angle left: 1e-9 deg leave some 1e-11,
/// which areas with errors of 1e-16 know to 1e-4. Over a corner it falls as the square of that
/// angle.
#[test]
fn both_sides_of_the_cutoffs() {
    let cube = cell(Shape::Triangular);
    let inside = [0.5_f64.sqrt(), 2_f64.sqrt()].map(f64::atan);
    let (mut cases, mut worst) = (0, 0.0_f64);
    for index in [1.0, 1.2] {
        for (inside_rad, azimuth, over_corner) in [(inside[0], "0", false), (inside[1], "60", true)]
        {
            let cutoff_deg = (index * inside_rad.sin()).asin().to_degrees();
            for (offset, lit) in [(-1e-9, true), (1e-9, false)] {
                let incidence = cutoff_deg + offset;
                let name = format!("index {index}, {incidence:.10} deg");
                let light = BothOptions::new(format!("{incidence}"), azimuth).inside(index);
                let both = light.on(&name, &cube);
                let found = both.exact.retroreflected[[0, 0]];
                let expected = eta(incidence, azimuth.parse().expect("a number"), index);
                println!("{name}: exact {found:.4e}, closed form {expected:.4e}");
                if lit && !over_corner {
                    assert!(expected > 1e-12, "the oracle sees the light");
                    let relative = (found / expected - 1.0).abs();
                    worst = worst.max(relative);
                    assert!(relative < 1e-3, "{name}: {found} is not {expected}");
                } else {
                    // The square of 1e-9 deg is 3e-22 rad^2, below the rounding of an area.
                    assert!(
                        found < if lit { 1e-15 } else { f64::MIN_POSITIVE },
                        "{name}: {found}"
                    );
                }
                // The limit is less than one ray in 200,000.
                assert_eq!(both.rays.retroreflected[[0, 0]], 0.0, "{name}");
                cases += 1;
            }
        }
    }
    println!("cutoffs: {cases} directions 1e-9 deg off, eta within {worst:.1e} of itself");
    assert_eq!(cases, 8);
}

/// Both methods see the end of total reflection at the same angle, within 1e-9 deg. Without mirrors
/// a face lets light through that it meets steeper than asin(1/m). For light that leans towards an
/// edge by t, the angle is 54.74 deg - t. This is 18.94 deg outside for m = 1.49.
#[test]
fn both_sides_of_total_internal_reflection() {
    let cube = cell(Shape::Triangular);
    let index = 1.49_f64;
    let inside = 2_f64.sqrt().atan() - (1.0 / index).asin();
    let limit_deg = (index * inside.sin()).asin().to_degrees();
    assert!((limit_deg - 18.94).abs() < 0.005, "{limit_deg}");
    // Azimuth 180 is light that travels away from the first edge and so comes from its side.
    let light = |offset: f64| {
        BothOptions::new(format!("{}", limit_deg + offset), "180")
            .inside(index)
            .without_mirrors()
    };
    let below = light(-1e-9).on("total reflection", &cube);
    let above = light(1e-9).on("no total reflection", &cube);
    let expected = eta(limit_deg, 180.0, index);
    println!(
        "total reflection ends at {limit_deg:.4} deg: eta {:.6} and {:.6} exactly, {:.6} and \
        {:.6} by rays",
        below.exact.retroreflected[[0, 0]],
        above.exact.retroreflected[[0, 0]],
        below.rays.retroreflected[[0, 0]],
        above.rays.retroreflected[[0, 0]],
    );
    assert!((below.exact.retroreflected[[0, 0]] - expected).abs() < 1e-9 && expected > 0.4);
    assert_eq!(below.rays.fate[[0, 0, Fate::Transmitted as usize]], 0.0);
    // Every path that returns meets all three faces.
    assert_eq!(above.exact.retroreflected[[0, 0]], 0.0);
    assert_eq!(above.rays.retroreflected[[0, 0]], 0.0);
    let gone = above.exact.fate[[0, 0, Fate::Transmitted as usize]];
    assert!(gone >= expected - 1e-9, "{gone}");
}

/// A table of the index 1 + 1e-9 is next to that of index 1.
///
/// At 45 deg the angle inside differs by 1e-9 rad, and the shift by at most 2 h / cos^2 times that,
/// 2.3e-9. The outline of the histogram moves by as much. It is less than 6 long, over an area of 4
/// times the entrance of 0.87: L1 is below 2 x 2.3e-9 x 6 / 3.5 = 8e-9. Light that moves between
/// bins, 62 a row, adds as much again.
#[test]
fn an_index_next_to_one() {
    let (mut cases, mut worst) = (0, 0.0_f64);
    for shape in Shape::ALL {
        let cell = cell(shape);
        let hollow = BothOptions::new("0,20,45", "0,60");
        let solid = hollow.clone().inside(1.0 + 1e-9);
        let near = solid.on(shape.name(), &cell);
        let one = hollow.bake(&cell, Method::Exact);
        for (&l1, (&a, &b)) in tables::l1(&near.exact, &one)
            .iter()
            .zip(near.exact.retroreflected.iter().zip(&one.retroreflected))
        {
            assert!((a - b).abs() < 2e-8, "{}: eta {a} and {b}", shape.name());
            worst = worst.max(l1);
            cases += 1;
        }
        // Nothing is totally reflected, because the critical angle is 89.997 deg.
        let lost = solid.without_mirrors().on(shape.name(), &cell).exact;
        assert!(
            lost.retroreflected.iter().all(|&eta| eta == 0.0),
            "{}",
            shape.name()
        );
    }
    println!("index 1 + 1e-9: {cases} directions, L1 to index 1 at most {worst:.1e}");
    assert_eq!(cases, Shape::ALL.len() * 3 * 2);
    assert!(worst < 5e-7 && worst > 0.0, "{worst}");
}

/// In directions in which a hollow cube returns nothing, eta is exactly 0 by both methods, and the
/// table can be written and read.
#[test]
fn a_cell_that_returns_nothing() {
    let cube = cell(Shape::Triangular);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut cases = 0;
    for (incidence, azimuth) in [("40", "0,30"), ("45", "0,90"), ("89.9", "60")] {
        let both = BothOptions::new(incidence, azimuth).on("empty", &cube);
        for table in [&both.rays, &both.exact] {
            assert!(table.retroreflected.iter().all(|&eta| eta == 0.0));
            assert!(table.standard_error.iter().all(|&error| error == 0.0));
            assert!(table.histogram.iter().all(|&p| p == 0.0));
            let file = folder.path().join("empty.h5");
            tables::write(table, &file).expect("writes");
            assert_eq!(tables::read(&file).expect("reads"), *table);
            cases += table.retroreflected.len();
        }
    }
    println!("nothing returned: {cases} directions, written and read again");
    assert_eq!(cases, 2 * 5);
}
