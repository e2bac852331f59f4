//! Tables over all azimuths: the sector that is baked stands for the rest.

mod cells;

use bake::plan::{Plan, Request};
use bake::run::bake;
use meshes::Cell;
use tables::Table;

fn table(cell: &Cell, incidence: &str, azimuth: &str) -> Table {
    let request = Request {
        incidence: incidence.into(),
        azimuth: azimuth.into(),
        bins: 64,
        ..Request::default()
    };
    let plan = Plan::new(&request).expect("a valid request").fold(cell);
    bake(cell, &plan, &|_| ()).expect("bakes")
}

/// Total variation of eta x histogram.
fn apart(a: &ndarray::Array2<f64>, b: &ndarray::Array2<f64>) -> f64 {
    0.5 * (a - b).iter().map(|x| x.abs()).sum::<f64>()
}

/// Every azimuth that the symmetry gives, baked by itself, is what the table of the sector says of it.
#[test]
fn a_sector_says_what_all_azimuths_are() {
    let mut turned = cells::triangular();
    let quarter = |p: glam::DVec2| glam::DVec2::from_angle(0.3).rotate(p);
    for corner in turned.facets.iter_mut().flatten() {
        *corner = quarter(corner.truncate()).extend(corner.z);
    }
    turned
        .entrance
        .polygon
        .iter_mut()
        .for_each(|p| *p = quarter(*p));
    let mut compared = 0;
    for (cell, rotations, azimuths) in [
        (cells::pair(), 6, 4),
        (cells::triangular(), 3, 7),
        (turned, 3, 7),
        (cells::full_cube(), 3, 7),
    ] {
        let sector = table(&cell, "0,12,31", "full:10");
        let symmetry = sector.provenance.symmetry;
        assert_eq!(symmetry.rotations, rotations, "{}", cell.design);
        assert!(symmetry.mirror_deg.is_some(), "{}", cell.design);
        assert_eq!(sector.axes.azimuth_deg.len(), azimuths);
        for &own in &sector.axes.azimuth_deg {
            for (image, _) in symmetry.images(own).step_by(2) {
                let alone = table(&cell, "0,12,31", &format!("{image}"));
                for (i, &incidence) in sector.axes.incidence_deg.iter().enumerate() {
                    let found = sector.direction(incidence, Some(image)).unwrap();
                    let expected = alone.direction(incidence, Some(image)).unwrap();
                    // Areas are good to some 1e-15; 64 x 64 bins of them.
                    let apart = apart(&found.probability, &alone.probability(i, 0));
                    assert!(
                        apart < 1e-12,
                        "{} {incidence} {image}: {apart}",
                        cell.design
                    );
                    let (w, kappa) = ([0.8, 0.5], [0.2, 1.0]);
                    let (a, b) = (found.otf_along(w, &kappa), expected.otf_along(w, &kappa));
                    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).norm() < 1e-12));
                    compared += 1;
                }
            }
        }
    }
    println!("{compared} directions");
    // Half of the images: 12 elements of the pair's group, 6 of the others'.
    assert_eq!(compared, 3 * (4 * 6 + 3 * 7 * 3));
}

/// A cell without symmetry has its whole turn, and a table of rays its sector too.
#[test]
fn what_has_no_symmetry_is_baked_all_around() {
    let mut skew = cells::triangular();
    skew.facets[0][1].x += 0.01;
    skew.entrance.polygon[0].x += 0.01;
    let all = table(&skew, "10", "full:45");
    assert_eq!(all.provenance.symmetry, tables::Symmetry::NONE);
    assert_eq!(
        all.axes.azimuth_deg,
        [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0]
    );
    let between = all.direction(10.0, Some(350.0)).unwrap();
    assert!(between.interpolated);
    let request = Request {
        incidence: "10".into(),
        azimuth: "full:15".into(),
        method: bake::plan::Method::Rays,
        rays: Some(4096),
        ..Request::default()
    };
    let plan = Plan::new(&request).unwrap().fold(&cells::pair());
    let rays = bake(&cells::pair(), &plan, &|_| ()).unwrap();
    assert_eq!(rays.axes.azimuth_deg, [0.0, 15.0, 30.0]);
    assert_eq!(
        rays.direction(10.0, Some(75.0)).unwrap().eta,
        rays.retroreflected[[0, 1]]
    );
}
