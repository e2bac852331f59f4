//! Periodic cells: effective areas, neighbours against a patch of copies, several cells in one
//! period.

use crate::optics::{Incidence, Rules};
use crate::plan::{Plan, Request};
use crate::rays::{Index, Scene, trace};
use crate::tests::bakes;
use crate::tests::bakes::asked;
use crate::tests::cells::designed;
use glam::{DMat2, DVec2, DVec3};
use meshes::design::{Design, Shape};
use meshes::{Cell, Entrance};
use tables::Fate;

use crate::tests::exact::cells::{Draw, ideal_edges};

/// Returns the effective area perpendicular to the light, by its cosines p <= q <= r on the axes of
/// the cube, for a triangular aperture or square faces.
fn effective_area(shape: Shape, travel: DVec3) -> f64 {
    let mut cosines = ideal_edges().map(|edge| -edge.dot(travel));
    cosines.sort_by(f64::total_cmp);
    let [p, q, r] = cosines;
    let sum = p + q + r;
    match shape {
        _ if p <= 0.0 => 0.0,
        Shape::FullCube if q <= r / 2.0 => 4.0 * p * q / r,
        Shape::FullCube => p * (4.0 - r / q),
        _ if p + q <= r => 4.0 * p * q / sum,
        _ => sum - 2.0 / sum,
    }
}

#[test]
fn effective_areas_are_those_of_the_model() {
    let mut draw = Draw(17);
    let (mut beams, mut rays, mut returning) = (0, 0, 0);
    for shape in [Shape::Triangular, Shape::FullCube] {
        let cell = designed(&Design::new(shape));
        let exact = bakes::exact(&cell).expect("planar");
        for k in 0..300 {
            let (incidence, azimuth) = (60.0 * draw.next(), 360.0 * draw.next());
            let light = Incidence::new(incidence.to_radians(), azimuth.to_radians(), 1.0);
            let area = effective_area(shape, light.travel);
            let eta = area / (exact.entrance_area() * -light.travel.z);
            let found = exact
                .direction(incidence, azimuth, 4, 2.0, &Rules::mirrors(1.0))
                .retroreflected;
            assert!(
                (found - eta).abs() < 1e-10,
                "{shape:?} {incidence} {azimuth}: {found} {eta}"
            );
            returning += usize::from(eta > 0.0);
            beams += 1;
            if k % 10 == 0 {
                let n = 1 << 16;
                let request = Request {
                    incidence: incidence.to_string(),
                    azimuth: azimuth.to_string(),
                    rays: Some(n),
                    ..asked("--method rays --sampler random --bins 4")
                };
                let plan = Plan::new(&request).expect("a plan");
                let traced = bakes::bake(&cell, &plan).expect("bakes").retroreflected[[0, 0]];
                // In 2,499 of 2,500 seeds 60 counts stay within 4.5 sigma.
                let sigma = (eta * (1.0 - eta) / n as f64).sqrt();
                assert!(
                    (traced - eta).abs() <= 4.5 * sigma,
                    "{shape:?} {incidence} {azimuth}"
                );
                rays += 1;
            }
        }
    }
    println!("{beams} directions by beams, {rays} by rays, {returning} return light");
    assert!(beams == 600 && rays == 60 && returning > 300);
}

/// Rays that enter the middle cell of 7 x 7 copies without a lattice have the fates and shifts that
/// they have in the periodic cell. Fates are as frequent as the exact method says.
#[test]
fn neighbours_are_those_of_a_patch() {
    const RAYS: u32 = 4000;
    let mut draw = Draw(23);
    let (mut compared, mut crossed, mut sideways) = (0, 0, 0);
    for (truncation, gap) in [(0.0, 0.0), (0.2, 0.0), (0.0, 0.5), (0.1, 0.3)] {
        let cell = designed(&Design {
            truncation,
            gap,
            ..Design::new(Shape::FullCube)
        });
        let entrance = &cell.entrance;
        let [a, b] = entrance.lattice.expect("periodic");
        let copies = (0..49).flat_map(|k| {
            let step = a * f64::from(k % 7 - 3) + b * f64::from(k / 7 - 3);
            let moved = move |facet: &[DVec3; 3]| facet.map(|p| p + step.extend(0.0));
            cell.facets.iter().map(moved)
        });
        let copies: Vec<[DVec3; 3]> = copies.collect();
        let alone = Entrance {
            lattice: None,
            ..entrance.clone()
        };
        let periodic = Scene::new(&cell, Index::Loop);
        let patch = Scene::of(&copies, &alone, Index::Loop);
        let exact = bakes::exact(&cell).expect("planar");
        for (incidence, azimuth) in [(0.0, 0.0), (20.0, 10.0), (35.0, 100.0), (50.0, 250.0_f64)] {
            let incidence: f64 = incidence;
            let light = Incidence::new(incidence.to_radians(), azimuth.to_radians(), 1.0);
            let rules = Rules::mirrors(1.0);
            let share = exact.direction(incidence, azimuth, 4, 2.0, &rules);
            let mut fates = [0_u32; Fate::ALL.len()];
            for _ in 0..RAYS {
                let at = |x: f64, y: f64| entrance.polygon[0] + a * x + b * y;
                let point = at(draw.next(), draw.next());
                let [one, other] =
                    [&periodic, &patch].map(|scene| trace(scene, &rules, &light, point, 0.5));
                fates[one.fate as usize] += 1;
                // Under open gaps light may run level for a long way, and the patch ends three
                // periods off.
                if other.travel.z.abs() < 0.4 && one.fate != other.fate {
                    sideways += 1;
                    continue;
                }
                assert_eq!(
                    one.fate, other.fate,
                    "{truncation} {gap} {incidence} {point}"
                );
                assert_eq!(one.bounces, other.bounces);
                // A path has up to ten lengths of some four edges, each rounded to 1e-15.
                assert!((one.shift - other.shift).length() < 1e-12);
                crossed += usize::from(one.shift.length() > 0.5 * a.length());
                compared += 1;
            }
            for (fate, &count) in fates.iter().enumerate() {
                let out = Fate::OutOfRange as usize;
                let expected = match fate {
                    f if f == Fate::Retroreflected as usize => share.retroreflected,
                    f if f == out => continue,
                    f => share.fate[f],
                };
                let sigma = (expected * (1.0 - expected) * f64::from(RAYS))
                    .max(0.0)
                    .sqrt();
                // There are 144 counts. Fates that no ray has get half a ray.
                let off = (f64::from(count) - expected * f64::from(RAYS)).abs();
                assert!(
                    off <= 4.5 * sigma + 0.5,
                    "{truncation} {gap} {incidence} {fate}: {off} {sigma}"
                );
            }
        }
    }
    println!(
        "{compared} rays compared, {sideways} leave the patch, {crossed} return farther off than \
        half a period"
    );
    assert_eq!(compared + sideways, 4 * 4 * RAYS);
    assert!(
        sideways < compared / 50 && crossed > 0,
        "{sideways} {crossed}"
    );
}

/// One period holds a pair, a turned pair, a pair of another size and a canted pair, apart. What
/// returns is the sum of what each returns alone, times its share of the area.
#[test]
fn a_period_of_several_cells_is_their_mean() {
    let pair = designed(&Design::new(Shape::TriangularPair));
    let canted = designed(&Design {
        cant_rad: 0.2,
        ..Design::new(Shape::Canted)
    });
    let parts: [(&Cell, f64, f64); 4] = [
        (&pair, 1.0, 0.0),
        (&pair, 1.0, 90.0),
        (&pair, 0.5, 25.0),
        (&canted, 0.8, 140.0),
    ];
    let (width, top) = (4.0, pair.entrance.height);
    let mut facets = Vec::new();
    for (k, (cell, size, turn)) in parts.iter().enumerate() {
        let map = DMat2::from_angle(turn.to_radians()) * *size;
        let place = |p: DVec3| {
            let flat = map * p.truncate() + DVec2::new(width * k as f64, 0.0);
            flat.extend(top + size * (p.z - cell.entrance.height))
        };
        facets.extend(cell.facets.iter().map(|facet| facet.map(place)));
    }
    let lattice = [DVec2::new(4.0 * width, 0.0), DVec2::new(0.0, width)];
    let period = lattice[0].perp_dot(lattice[1]);
    let sheet = Cell {
        facets,
        entrance: Entrance {
            height: top,
            polygon: vec![DVec2::ZERO, lattice[0], lattice[0] + lattice[1], lattice[1]],
            lattice: Some(lattice),
        },
        ..pair.clone()
    };
    let exact = bakes::exact(&sheet).expect("planar");
    let (mut cases, mut worst) = (0, 0.0_f64);
    for index in [1.0, 1.49] {
        for (incidence, azimuth) in [(0.0, 0.0), (10.0, 33.0), (25.0, 190.0), (40.0, 301.0)] {
            let bins = 32;
            let found = exact.direction(incidence, azimuth, bins, 2.0, &Rules::mirrors(index));
            let mut eta = 0.0;
            let mut histogram = vec![0.0; bins * bins];
            for (cell, size, turn) in parts {
                let alone = bakes::exact(cell).expect("planar");
                // Shifts of a smaller cell are smaller: its table has equal bins over a wider
                // range, in its own edge lengths.
                let range = 2.0 / size;
                let share = alone.direction(
                    incidence,
                    azimuth - turn,
                    bins,
                    range,
                    &Rules::mirrors(index),
                );
                let weight = alone.entrance_area() * size * size / period;
                eta += weight * share.retroreflected;
                let weighted = histogram.iter_mut().zip(&share.histogram);
                weighted.for_each(|(sum, part)| *sum += weight * part);
            }
            let pairs = found.histogram.iter().zip(&histogram);
            let l1: f64 = pairs.map(|(a, b)| (a - b).abs()).sum();
            worst = worst.max(l1);
            assert!(
                (found.retroreflected - eta).abs() < 1e-12 && l1 < 1e-12,
                "{index} {incidence}: {l1:e}"
            );
            cases += 1;
        }
    }
    println!("{cases} directions of four cells in one period: L1 to their mean {worst:.1e}");
    assert_eq!(cases, 8);
}
