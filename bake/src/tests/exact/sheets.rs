//! Meshes of many cubes, of which one cube of each kind is baked.

use crate::cell::ExactCell;
use crate::optics::Rules;
use crate::tests::bakes;
use crate::tests::cells::of_mesh;
use glam::DVec3;
use meshes::design::{Design, Shape};
use meshes::{Cell, Mesh};

use crate::tests::exact::cells::Draw;

/// Returns the design's pair of cubes at `places`, given in steps along its sides. Of each pair
/// only the first `facets` facets are kept.
fn sheet(places: impl Iterator<Item = (usize, usize, usize)>) -> Cell {
    // All coordinates are whole file units, so that neighbours share vertices.
    let pair = Design::new(Shape::TriangularPair).mesh().unwrap();
    let [_, a, b, c, ..] = pair.positions[..] else {
        unreachable!("a pair has an apex and three edge ends first");
    };
    let mut mesh = Mesh {
        positions: Vec::new(),
        triangles: Vec::new(),
        ..pair.clone()
    };
    for (i, j, facets) in places {
        let place: DVec3 = (a - c) * i as f64 + (b - c) * j as f64;
        let first = mesh.positions.len() as u32;
        mesh.positions
            .extend(pair.positions.iter().map(|&p| p + place));
        let triangles = pair.triangles[..facets].iter();
        mesh.triangles
            .extend(triangles.map(|t| t.map(|v| v + first)));
    }
    of_mesh(&mesh, |_| ())
}

/// A sheet of a thousand pairs bakes like one pair. The sheet is 66 edges across. Its coordinates
/// are rounded to 7e-15, and so are the cubes taken out of it. The outlines of the histogram's
/// polygons, at most 12 long, move by a few times that over an area of 3.5: an L1 of some 1e-13.
#[test]
fn a_thousand_pairs_bake_like_one() {
    let one = sheet([(0, 0, 6)].into_iter());
    let many = sheet((0..1000).map(|k| (k / 25, k % 25, 6)));
    let [one, many] = [&one, &many].map(|cell| bakes::exact(cell).unwrap());
    assert_eq!([one.facet_count(), many.facet_count()], [6, 6]);
    let mut draw = Draw(11);
    let (mut cases, mut returning, mut worst) = (0, 0, 0.0_f64);
    for index in [1.0, 1.49] {
        for _ in 0..50 {
            let (incidence, azimuth) = (70.0 * draw.next(), 360.0 * draw.next());
            let [a, b] = [&one, &many]
                .map(|cell| cell.direction(incidence, azimuth, 64, 2.0, &Rules::mirrors(index)));
            let apart =
                |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum() };
            let l1 = apart(&a.histogram, &b.histogram);
            worst = worst.max(l1).max(apart(&a.fate, &b.fate));
            returning += usize::from(a.retroreflected > 0.0);
            cases += 1;
        }
    }
    println!(
        "1,000 pairs: {cases} directions, {returning} return light, L1 to one pair {worst:.1e}"
    );
    assert!(worst < 1e-12, "{worst}");
    assert!(cases == 100 && returning > 60, "{returning}");
}

/// A triangle of 6 cubes and 3 turned cubes gives the mean of the two kinds, 2 to 1, and the stored
/// data add up to it.
#[test]
fn kinds_count_as_often_as_they_occur() {
    let places = [0, 1, 2]
        .into_iter()
        .flat_map(|i| (0..3 - i).map(move |j| (i, j, if i + j < 2 { 6 } else { 3 })));
    let triangle = bakes::exact(&sheet(places)).unwrap();
    let single = bakes::exact(&sheet([(0, 0, 3)].into_iter())).unwrap();
    assert_eq!([triangle.facet_count(), single.facet_count()], [6, 3]);
    let mut cases = 0;
    for (incidence, azimuth) in [(0.0, 0.0), (12.0, 7.0), (30.0, 0.0), (40.0, 60.0)] {
        let at = |cell: &ExactCell, azimuth| {
            cell.direction(incidence, azimuth, 64, 2.0, &Rules::mirrors(1.0))
        };
        let found = at(&triangle, azimuth);
        let [upright, turned] = [azimuth, azimuth + 180.0].map(|azimuth| at(&single, azimuth));
        let eta = (2.0 * upright.retroreflected + turned.retroreflected) / 3.0;
        assert!(
            (found.retroreflected - eta).abs() < 1e-12,
            "{} {eta}",
            found.retroreflected
        );
        // Light from the other side sees a turned cube upright, in its own incidence frame.
        let bins = found.histogram.len();
        for bin in 0..bins {
            let mean = (2.0 * upright.histogram[bin] + turned.histogram[bin]) / 3.0;
            assert!((found.histogram[bin] - mean).abs() < 1e-12, "bin {bin}");
        }
        let weights: Vec<f64> = found.paths.iter().map(|path| path.weight).collect();
        assert!(weights.iter().all(|weight| [1.0, 0.5].contains(weight)));
        let stored = found.paths.iter().map(|path| path.weight * path.area());
        let stored = stored.sum::<f64>() / triangle.entrance_area();
        assert!((stored - eta).abs() < 1e-12, "{stored} {eta}");
        cases += bins;
    }
    assert_eq!(cases, 4 * 64 * 64);
}
