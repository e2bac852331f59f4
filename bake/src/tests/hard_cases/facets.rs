//! Facets as badly shaped as files have them, and dihedral errors from the last digit to visible
//! ones.

use crate::optics::{Incidence, Rules};
use crate::rays::{Index, Scene, trace};
use crate::tests::hard_cases::both::{BothOptions, cell, normalised};
use meshes::design::{Design, Shape};
use meshes::{Fault, Mesh};
use tables::Fate;
use tables::options::Method;

/// Returns the design with one face cut in three by a point `height` edges above the middle of one
/// of its sides, so that one part is a sliver of that height. Sides 0 and 2 are edges of the cube;
/// side 1 is its rim.
fn with_sliver(height: f64, side: usize) -> Mesh {
    let mut mesh = Design::new(Shape::TriangularPair).mesh().expect("a design");
    let [a, b, c] = [0, 1, 2].map(|i| mesh.triangles[1][(side + i) % 3]);
    let corner = |v: u32| mesh.positions[v as usize];
    let middle = (corner(a) + corner(b)) / 2.0;
    let up = (corner(c) - middle) * (height * 3.0 / (corner(c) - middle).length());
    let new = mesh.positions.len() as u32;
    mesh.positions.push(middle + up);
    mesh.triangles
        .splice(1..2, [[a, b, new], [b, c, new], [c, a, new]]);
    mesh
}

/// Slivers down to 1e-11 of an edge high change the table by no more than rounding.
///
/// The rounding of its corners, 1e-16, tilts a sliver about its long side by 1e-16 / height. The
/// light that meets it is a share of at most the height. So the mean displacement of light is
/// 1e-16. Besides, each of a dozen more facet sequences gives up parts of up to 9e-16 of the light
/// as rounding, which count twice in L1.
#[test]
fn slivers() {
    let light = BothOptions::new("0,20,40", "0,30").inside(1.49);
    let whole = light.bake(&cell(Shape::TriangularPair), Method::Exact);
    let mut cases = 0;
    let heights = [1e-2, 1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11];
    for (height, side) in heights
        .iter()
        .flat_map(|&h| [0, 1, 2].map(|side| (h, side)))
    {
        let sliver = normalised(&with_sliver(height, side)).expect("a legal mesh");
        let both = light.on(&format!("sliver {height} at side {side}"), &sliver);
        let l1 = tables::l1(&both.exact, &whole)
            .into_iter()
            .fold(0.0, f64::max);
        println!(
            "sliver {height:e} high at side {side}: L1 {l1:.1e} to the whole face, rays within \
            {:.2} sigma",
            both.sigmas()
        );
        assert!(l1 < 3e-14, "{height}: {l1}");
        let lost = both
            .exact
            .fate
            .slice(ndarray::s![.., .., Fate::Missed as usize])
            .sum()
            + both
                .rays
                .fate
                .slice(ndarray::s![.., .., Fate::Missed as usize])
                .sum();
        assert!(lost < 1e-12, "{height}: {lost} missed");
        cases += 1;
    }
    assert_eq!(cases, 24);
    let error = normalised(&with_sliver(1e-13, 0)).expect_err("no normal is left");
    assert!(
        matches!(*error.fault, Fault::DegenerateFace { face: 2, .. }),
        "{error}"
    );
}

/// The errors are the documented ones, and each names file, face and remedy.
#[test]
fn duplicated_and_coincident_faces() {
    let design = Design::new(Shape::Triangular).mesh().expect("a design");
    let with = |face: [u32; 3]| {
        let mut mesh = design.clone();
        mesh.triangles.push(face);
        normalised(&mesh).expect_err("refused").to_string()
    };
    let [a, b, c] = design.triangles[0];
    let mut cases = 0;
    for (face, sentence) in [
        (
            [a, b, c],
            "face 4 repeats face 1 (same three vertices, same side); delete one of them",
        ),
        (
            [b, c, a],
            "face 4 repeats face 1 (same three vertices, same side); delete one of them",
        ),
        (
            [c, b, a],
            "face 4 lies back to back on face 1 (same three vertices, other side); delete one of \
            them",
        ),
        ([a, a, b], "face 4 is degenerate"),
    ] {
        let message = with(face);
        println!("{message}");
        assert!(message.starts_with("mesh.obj: "), "{message}");
        assert!(message.contains(sentence), "{message}");
        cases += 1;
    }
    assert_eq!(cases, 4);
}

/// Three equal errors eps send light into six spots at 4 sqrt(2/3) eps (1 - eps/2) from
/// antiparallel, to second order, at normal incidence.
///
/// Relative to that, 2 eps^2 is left to the third order. The directions of two nearly antiparallel
/// rays are known to 1e-15, over 3.3 eps. The composite map turns by no more than 4 eps. So light
/// is retroreflected for eps up to 1e-3 and deviated at 1e-2 (tolerance 0.5 deg = 8.7e-3 rad), by
/// both methods; no error is too small to be seen.
#[test]
fn dihedral_errors() {
    let mut cases = 0;
    for decade in -9..=-2 {
        let error = 10_f64.powi(decade);
        let design = Design {
            dihedral_error_rad: [error; 3],
            ..Design::new(Shape::Triangular)
        };
        let bent = normalised(&design.mesh().expect("a design")).expect("a cell");
        let scene = Scene::new(&bent, Index::Loop);
        let rules = Rules::mirrors(1.0);
        let normal = Incidence::new(0.0, 0.0, 1.0);
        let expected = 4.0 * (2.0_f64 / 3.0).sqrt() * error * (1.0 - error / 2.0);
        let (mut worst, mut spots) = (0.0_f64, Vec::<glam::DVec3>::new());
        for turn in 0..24 {
            // Near the centre a ray meets all three faces, in the six orders.
            let (y, x) = (f64::from(turn) * 15.0 + 7.0).to_radians().sin_cos();
            let outcome = trace(&scene, &rules, &normal, glam::DVec2::new(x, y) * 0.15, 0.5);
            assert_eq!(outcome.bounces, 3);
            let off = outcome.travel + normal.travel;
            worst = worst.max((off.length() / expected - 1.0).abs());
            if spots.iter().all(|spot| spot.distance(off) > 0.1 * expected) {
                spots.push(off);
            }
        }
        let both = BothOptions::new("0,15", "0,40").on(&format!("dihedral {error}"), &bent);
        let eta = both.exact.retroreflected[[0, 0]];
        println!(
            "dihedral error {error:.0e}: {} spots, off by {worst:.1e} of their distance; eta \
            {eta:.6}, rays within {:.2} sigma",
            spots.len(),
            both.sigmas()
        );
        assert_eq!(spots.len(), 6, "{error}");
        assert!(
            worst < 2.0 * error * error + 1e-15 / error,
            "{error}: {worst}"
        );
        if decade < -2 {
            assert!(
                (eta - 2.0 / 3.0).abs() < 4.0 * error + 1e-14,
                "{error}: {eta}"
            );
        } else {
            assert_eq!(eta, 0.0, "{error}");
            assert!(both.exact.fate[[0, 0, Fate::Deviated as usize]] > 0.6);
        }
        cases += 1;
    }
    assert_eq!(cases, 8);
}
