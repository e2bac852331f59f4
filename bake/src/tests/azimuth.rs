//! Tables over all azimuths: the sector that is baked stands for the other azimuths.

use crate::tests::bakes;
use crate::tests::bakes::asked;
use crate::tests::cells;

use crate::beams::spread;
use crate::plan::{Plan, Request};
use crate::run::{Bake, Comparison, Progress};
use crate::tests::bakes::bake;
use meshes::Cell;
use meshes::design::{Design, Shape};
use tables::{Path, Table};

fn table(cell: &Cell, incidence: &str, azimuth: &str) -> Table {
    let request = Request {
        incidence: incidence.into(),
        azimuth: azimuth.into(),
        bins: 64,
        ..Request::default()
    };
    let plan = Plan::new(&request).expect("a valid request");
    bake(cell, &plan).expect("bakes")
}

/// Returns the total variation of eta x histogram.
fn apart(a: &ndarray::Array2<f64>, b: &ndarray::Array2<f64>) -> f64 {
    0.5 * (a - b).iter().map(|x| x.abs()).sum::<f64>()
}

/// Every azimuth that the symmetry gives, baked on its own, equals what the table of the sector
/// says of it.
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
                    // Areas are good to some 1e-15, and there are 64 x 64 bins of them.
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
    // Half of the images are compared: 12 elements of the pair's group, 6 of the others' groups.
    assert_eq!(compared, 3 * (4 * 6 + 3 * 7 * 3));
}

/// A table of one sector that is unfolded equals the table that is baked at all azimuths, and the
/// comparison unfolds it by itself. Azimuths for which none stands are refused.
#[test]
fn an_unfolded_table_is_that_of_its_azimuths() {
    let one = cells::uneven_pair([1e-3, 0.0, 0.0]);
    let mut compared = 0;
    for (cell, rotations) in [(cells::pair(), 6), (one, 2), (cells::full_cube(), 3)] {
        let sector = table(&cell, "0,20", "full:15");
        assert_eq!(sector.provenance.symmetry.rotations, rotations);
        let whole = table(&cell, "0,20", "0:345:15");
        let unfolded = sector
            .unfolded(&whole.axes.azimuth_deg)
            .expect("all azimuths");
        assert_eq!(unfolded.axes, whole.axes);
        assert!(apart_in_bins(&unfolded, &whole) < 1e-9);
        for [a, b] in [[&sector, &whole], [&whole, &sector]] {
            let comparison = Comparison::new(a, b).expect("the same directions");
            assert_eq!(comparison.rows.len(), 2 * 24);
            assert!(comparison.agrees());
            assert!(comparison.rows.iter().all(|row| row.sigmas.is_none()));
            compared += comparison.rows.len();
        }
        assert!(sector.unfolded(&[7.0]).is_none());
        let few = table(&cell, "0,20", "0,15");
        assert!(
            Comparison::new(&few, &whole).is_err(),
            "directions would be left out"
        );
    }
    assert_eq!(compared, 3 * 2 * 48);
}

/// Returns the largest difference of two histograms.
fn apart_in_bins(a: &Table, b: &Table) -> f64 {
    let pairs = a.histogram.iter().zip(&b.histogram);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Returns a cube whose angles are off 90 deg: the ends of its edges lie `stretch` times as far
/// from the axis as in an ideal cube. Only a mirror plane is left if the first differs.
fn stretched(stretch: [f64; 3]) -> Cell {
    let mut cell = cells::triangular();
    let ideal = cells::edges(0.0).map(|end| end.truncate());
    let moved = |p: glam::DVec2| {
        let which = ideal.iter().position(|&end| end == p);
        which.map_or(p, |k| stretch[k] * p)
    };
    for corner in cell.facets.iter_mut().flatten() {
        *corner = moved(corner.truncate()).extend(corner.z);
    }
    for corner in &mut cell.entrance.polygon {
        *corner = moved(*corner);
    }
    cell
}

/// Sums of all paths of one direction that share a map and a deviation.
struct PathSum {
    matrix: [[f64; 2]; 2],
    offset: [f64; 2],
    deviation: [f64; 2],
    /// Area and its first moments, weighted by the power.
    moments: [f64; 3],
}

impl PathSum {
    /// Returns the largest difference of two spots in all their numbers.
    fn apart(&self, other: &PathSum) -> f64 {
        let all = |spot: &PathSum| {
            let [[a, b], [c, d]] = spot.matrix;
            let ([e, f], [g, h]) = (spot.offset, spot.deviation);
            let [i, j, k] = spot.moments;
            [a, b, c, d, e, f, g, h, i, j, k]
        };
        let pairs = all(self).into_iter().zip(all(other));
        pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    }
}

/// Adds up the paths that share a map, however their light is cut into polygons.
fn spots(paths: &[tables::Path]) -> Vec<PathSum> {
    let mut spots: Vec<PathSum> = Vec::new();
    for path in paths {
        let mut moments = [0.0; 3];
        let ends = path.polygon.iter().zip(path.polygon.iter().cycle().skip(1));
        for (a, b) in ends {
            let cross = path.weight * (a[0] * b[1] - b[0] * a[1]);
            let parts = [0.5, (a[0] + b[0]) / 6.0, (a[1] + b[1]) / 6.0];
            for (sum, part) in moments.iter_mut().zip(parts) {
                *sum += part * cross;
            }
        }
        // The map of a facet sequence is computed once, so equal maps are equal to the last bit.
        let same = |spot: &&mut PathSum| {
            (spot.matrix, spot.offset, spot.deviation) == (path.matrix, path.offset, path.deviation)
        };
        match spots.iter_mut().find(same) {
            Some(spot) => {
                for (sum, part) in spot.moments.iter_mut().zip(moments) {
                    *sum += part;
                }
            }
            None => spots.push(PathSum {
                matrix: path.matrix,
                offset: path.offset,
                deviation: path.deviation,
                moments,
            }),
        }
    }
    spots
}

/// A cube with dihedral errors and a mirror plane, baked as a sector and at every image of its
/// azimuths: maps, light and deviations of the unfolded paths are those of the baked ones.
#[test]
fn unfolded_paths_deviate_as_baked_ones_do() {
    let (mut compared, mut turned_over) = (0, 0);
    // Azimuths on a mirror plane are their own images, so some lie between two planes.
    for (stretch, rotations, azimuths) in [
        ([1.001; 3], 3, "full:20"),
        ([1.0015, 1.0005, 1.0005], 1, "full:60"),
    ] {
        let cell = stretched(stretch);
        let sector = table(&cell, "0,17", azimuths);
        let symmetry = sector.provenance.symmetry;
        assert_eq!(symmetry.rotations, rotations);
        assert!(symmetry.mirror_deg.is_some());
        let azimuths = sector.axes.azimuth_deg.iter();
        let images = azimuths.flat_map(|&own| symmetry.images(own));
        for (image, mirrored) in images {
            let alone = table(&cell, "0,17", &format!("{image}"));
            for &incidence in &sector.axes.incidence_deg {
                let of = |table: &Table| {
                    let found = table.direction(incidence, Some(image)).unwrap();
                    assert!(!found.interpolated);
                    spots(&found.paths.expect("exact"))
                };
                let (found, baked) = (of(&sector), of(&alone));
                assert_eq!(found.len(), baked.len(), "{incidence} {image}");
                for spot in &baked {
                    let apart = found.iter().map(|other| spot.apart(other));
                    let apart = apart.fold(f64::INFINITY, f64::min);
                    // Three reflections, a carry and the sums of some ten corners round by some
                    // tens of ulps of numbers below 4, which is less than 1e-13.
                    assert!(apart < 1e-13, "{incidence} {image}: {apart}");
                    compared += 1;
                    turned_over += usize::from(mirrored && spot.deviation[1].abs() > 1e-4);
                }
            }
        }
    }
    println!("{compared} spots, {turned_over} of them with a deviation along v");
    // The 64 images, half of them mirrored, see all six sequences of facets.
    assert_eq!((compared, turned_over), (64 * 6, 32 * 6));
}

/// The lines of an ideal cube are affine in the tangent of the incidence inside, so polygons
/// between the directions of a table behind a front face are those of a bake there.
#[test]
fn an_ideal_cube_behind_a_front_face_is_exact_between_directions() {
    let cell = cells::triangular();
    let index = 1.49;
    let bake_at = |incidence: &str, azimuth: &str| {
        let request = Request {
            incidence: incidence.into(),
            azimuth: azimuth.into(),
            refractive_index: Some(index),
            ..asked("--bins 16 --back mirror")
        };
        bake(&cell, &Plan::new(&request).expect("a valid request")).expect("bakes")
    };
    let coarse = bake_at("0,14,28", "full:60");
    let mut compared = 0;
    for incidence in [4.0, 9.0, 19.0, 25.0] {
        for azimuth in [7.0, 31.0, 100.0, 250.0] {
            let alone = bake_at(&incidence.to_string(), &azimuth.to_string());
            let found = coarse.direction(incidence, Some(azimuth)).unwrap();
            assert!(found.interpolated);
            let sine = incidence.to_radians().sin() / index;
            let squared = sine * sine / (1.0 - sine * sine);
            let eta = 2.0 / 3.0 * (1.0 - 2.0 * squared);
            // The ridge of the fit costs 1e-10 of the slopes.
            let off = (found.retroreflected - eta).abs();
            assert!(off < 1e-8, "{incidence} {azimuth}: {off:e}");
            assert!((alone.retroreflected[[0, 0]] - eta).abs() < 1e-12);
            compared += 1;
        }
    }
    assert_eq!(compared, 16);
}

/// Light by shift and deviation between two directions of rays is their mixture: every place holds
/// the parts of its rays among those launched.
#[test]
fn exits_between_directions_are_a_mixture() {
    let request = asked("--incidence 0,20 --azimuth 10,40 --method rays --rays 4096 --bins 16");
    let plan = Plan::new(&request).expect("a valid request");
    let table = bake(&cells::uneven_pair([5e-4, 0.0, -3e-4]), &plan).expect("bakes");
    let held = table.deviations.as_ref().expect("recorded");
    let found = table.direction(5.0, Some(20.0)).unwrap();
    let found = found.exits.expect("recorded");
    let mut expected = std::collections::BTreeMap::new();
    for (i, along) in [0.75, 0.25].into_iter().enumerate() {
        for (j, across) in [2.0 / 3.0, 1.0 / 3.0].into_iter().enumerate() {
            for entry in &held.entries[2 * i + j] {
                let part = entry.rays as f64 / table.rays[[i, j]] as f64;
                *expected.entry(entry.place).or_insert(0.0) += along * across * part;
            }
        }
    }
    assert!(expected.len() > 20);
    assert_eq!(found.probability.len(), expected.len());
    for ((place, p), (at, q)) in found.probability.iter().zip(expected) {
        // Four products of numbers below 1.
        assert!(*place == at && (p - q).abs() < 1e-15, "{place} {p} {q}");
    }
}

/// A cell without symmetry is baked over the whole turn. A table of rays has its sector too.
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
    let request = asked("--incidence 10 --azimuth full:15 --method rays --rays 4096");
    let plan = Plan::new(&request).unwrap();
    let rays = bake(&cells::pair(), &plan).unwrap();
    assert_eq!(rays.axes.azimuth_deg, [0.0, 15.0, 30.0]);
    assert_eq!(
        rays.direction(10.0, Some(75.0)).unwrap().retroreflected,
        rays.retroreflected[[0, 1]]
    );
}

fn design(name: &str, change: impl FnOnce(&mut Design)) -> Cell {
    let mut design = Design::new(Shape::from_name(name).unwrap());
    change(&mut design);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cell.obj");
    std::fs::write(&file, meshes::write::obj(&design.mesh().unwrap())).unwrap();
    meshes::load_cell(&file, &meshes::CellOptions::default()).unwrap()
}

/// Returns the area of a polygon, positive if it runs counter-clockwise.
fn area(polygon: &[[f64; 2]]) -> f64 {
    let ends = polygon.iter().zip(polygon.iter().cycle().skip(1));
    0.5 * ends.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>()
}

/// Returns direction `k` of a low-discrepancy sequence over incidences up to `steepest_deg` and all
/// azimuths, degrees. The steps are the first two powers of the reciprocal plastic number.
fn anywhere(k: u32, steepest_deg: f64) -> (f64, f64) {
    let part = |step: f64| (f64::from(k) * step + 0.37).fract();
    (
        steepest_deg * part(0.754_877_666_246_693),
        360.0 * part(0.569_840_290_998_053),
    )
}

/// Tables whose directions were chosen for a tolerance keep it at 500 directions that the choice
/// did not try. The exact method gives the truth.
#[test]
#[ignore = "half a minute: `make test-slowest` runs it"]
fn between_chosen_directions_polygons_keep_the_tolerance() {
    let tolerance = 0.005;
    let uneven = |design: &mut Design| design.dihedral_error_rad = [5e-4, 0.0, -3e-4];
    // Each case is cell, index, steepest incidence, most directions. Mixing bins instead would take
    // hundreds of directions.
    let cases = [
        (design("triangular-pair", |_| ()), 1.49, 45.0, 9),
        (design("triangular-pair", |_| ()), 1.0, 60.0, 12),
        (design("triangular", |_| ()), 1.49, 45.0, 15),
        (
            design("canted", |design| design.cant_rad = 0.2),
            1.49,
            45.0,
            30,
        ),
        (design("full-cube", |_| ()), 1.49, 45.0, 45),
        (design("triangular-pair", uneven), 1.49, 45.0, 40),
        // Beyond the limit of 35.26 deg of a hollow cube, near which its six paths end at slightly
        // different angles.
        (design("triangular-pair", uneven), 1.0, 38.0, 90),
    ];
    let mut tried = 0;
    for (cell, index, steepest, most) in cases {
        let request = Request {
            incidence: format!("0,{steepest}"),
            azimuth: "full".into(),
            refractive_index: Some(index),
            direction_tolerance: Some(tolerance),
            ..Request::default()
        };
        let plan = Plan::new(&request).unwrap();
        let table = bake(&cell, &plan).unwrap();
        let (prepared, rules) = (bakes::exact(&cell).unwrap(), plan.rules(&cell));
        let (mut by_polygons, mut by_mixing, mut by_eta) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut astray = 0.0_f64;
        for k in 0..500 {
            let (incidence, azimuth) = anywhere(k, steepest);
            let truth = prepared.direction(incidence, azimuth, 128, 2.0, &rules);
            let found = table.direction(incidence, Some(azimuth)).unwrap();
            let total = |mass: &[f64]| -> f64 {
                let bins = mass
                    .iter()
                    .zip(&truth.histogram)
                    .map(|(a, b)| (a - b).abs());
                0.5 * bins.sum::<f64>()
            };
            let paths = found.paths.as_ref().expect("interpolated polygons");
            let (mass, _) = spread(paths, prepared.entrance_area(), 128, 2.0);
            by_polygons = by_polygons.max(total(&mass));
            by_mixing = by_mixing.max(total(found.probability.as_slice().unwrap()));
            by_eta = by_eta.max((found.retroreflected - truth.retroreflected).abs());
            // The limit is 5 um at a distance of 1 m, a twentieth of the smallest corners.
            let turned = |path: &&Path| {
                let apart = truth.paths.iter().map(|own| {
                    let [x, y] = [0, 1].map(|k| own.deviation[k] - path.deviation[k]);
                    x.hypot(y)
                });
                apart.fold(f64::INFINITY, f64::min) > 5e-6
            };
            let lost: f64 = paths
                .iter()
                .filter(turned)
                .map(|path| path.weight * area(&path.polygon))
                .sum();
            astray = astray.max(lost / prepared.entrance_area());
            tried += 1;
        }
        let (incidences, azimuths) = table.axes.shape();
        println!(
            "{} m {index}: {incidences} x {azimuths} directions, polygons within \
            {by_polygons:.5}, eta within {by_eta:.5}, \
             {astray:.1e} of the light in wrong exit directions; mixed bins of the same table \
             within {by_mixing:.3}",
            cell.design
        );
        assert!(by_polygons <= tolerance, "{}: {by_polygons}", cell.design);
        // Affine functions are exact, but beyond the limit of a cube a path that only two
        // neighbouring directions have is known along one line only.
        let most_astray = if steepest == 38.0 { tolerance } else { 0.0 };
        assert!(astray <= most_astray, "{}: {astray}", cell.design);
        // |difference of eta| is at most twice the total variation.
        assert!(by_eta <= 2.0 * tolerance, "{}: {by_eta}", cell.design);
        assert!(
            incidences * azimuths <= most,
            "{}: {incidences} x {azimuths}",
            cell.design
        );
    }
    println!("{tried} directions");
    assert_eq!(tried, 7 * 500);
}

/// The error names the place where no grid reaches the tolerance: the distribution jumps where
/// total reflection ends.
#[test]
#[ignore = "half a minute: `make test-slowest` runs it"]
fn a_jump_is_said() {
    let cell = cells::pair();
    let request = Request {
        refractive_index: Some(1.49),
        ..asked("--incidence 0,45 --azimuth full --back tir --direction-tolerance 0.005 --bins 16")
    };
    let plan = Plan::new(&request).unwrap();
    let prepared = bakes::prepared(&cell);
    let error = Bake::new(&prepared, &plan, Progress::none())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("still") && error.contains("at incidence"),
        "{error}"
    );
    // Below the limit of 18.9 deg there is no jump.
    let request = Request {
        incidence: "0,18".into(),
        ..request
    };
    let plan = Plan::new(&request).unwrap();
    let baked = Bake::new(&prepared, &plan, Progress::none()).unwrap();
    assert_eq!(baked.symmetry, prepared.symmetry());
    assert!(baked.axes.shape().0 <= 3, "{:?}", baked.axes);
}
