//! Rounded edges, flat apexes and land between cubes: the light that still returns has a closed
//! form.
//!
//! Reflected in the faces, a path through an ideal cube is a straight line through the eight
//! octants about its apex. If this line stays clear of what fills edges and apex, it meets only
//! what is left of the facets and returns as in the ideal cube.

use crate::beams::Share;
use crate::optics::Rules;
use crate::tests::bakes;
use crate::tests::cells::designed;
use glam::{DVec2, DVec3};
use meshes::Cell;
use meshes::design::{Design, Shape};
use tables::Fate;

use crate::tests::exact::cells::ideal_edges;

fn single(change: impl FnOnce(&mut Design)) -> Cell {
    let mut design = Design {
        edge_length: 1.0,
        ..Design::new(Shape::Triangular)
    };
    change(&mut design);
    designed(&design)
}

fn area(polygon: &[DVec2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon
        .iter()
        .zip(next)
        .map(|(a, b)| a.perp_dot(*b) / 2.0)
        .sum()
}

/// Returns the part of a convex polygon where the affine function `inside` is at least 0.
fn clipped(polygon: &[DVec2], inside: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::new();
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (s, t) = (inside(p), inside(q));
        if s >= 0.0 {
            kept.push(p);
        }
        if (s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0) {
            kept.push(p + (q - p) * (s / (s - t)));
        }
    }
    kept
}

/// Light inside a hollow cube.
struct InsideLight {
    travel: DVec3,
    /// Apex, carried along the light to the aperture plane.
    apex: DVec2,
}

impl InsideLight {
    fn new(incidence_deg: f64, azimuth_deg: f64) -> Self {
        let (sin, cos) = incidence_deg.to_radians().sin_cos();
        let (y, x) = azimuth_deg.to_radians().sin_cos();
        let travel = DVec3::new(sin * x, sin * y, -cos);
        let apex = (travel / travel.z).truncate() / 3_f64.sqrt();
        InsideLight { travel, apex }
    }

    /// Returns the polygon through which the light enters that an ideal cube returns: the
    /// intersection of the aperture and its point reflection through the apex's image.
    fn kept(&self) -> Vec<DVec2> {
        let triangle = ideal_edges().map(DVec3::truncate);
        let mut kept = triangle.to_vec();
        for i in 0..3 {
            let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
            let side = |p: DVec2| (b - a).perp_dot(p - a);
            kept = clipped(&kept, |p| side(2.0 * self.apex - p));
        }
        kept
    }
}

const DIRECTIONS: [(f64, f64); 6] = [
    (0.0, 0.0),
    (5.0, 30.0),
    (12.0, 200.0),
    (18.0, 77.0),
    (28.0, 60.0),
    (33.0, 170.0),
];

fn at(cell: &Cell, (incidence, azimuth): (f64, f64)) -> (Share, f64) {
    let exact = bakes::exact(cell).expect("planar");
    let found = exact.direction(incidence, azimuth, 16, 2.0, &Rules::mirrors(1.0));
    let sum: f64 = found.fate.iter().sum();
    assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    (found, exact.entrance_area())
}

/// Rounded edges take three bands from the light that returns.
///
/// Light returns if it meets each facet farther than the radius R from both its edges. Along a ray
/// L = x cross d is constant. Near edge k the ray stays clear of the fillet if |L_k| > R max(|d_i|,
/// |d_j|), whatever the number of strips. So light returns in what is left of the ideal polygon
/// between the three bands.
#[test]
fn rounded_edges_take_three_bands() {
    let axes = ideal_edges();
    let (mut cases, mut worst) = (0, 0.0_f64);
    for radius in [1e-4, 0.01, 0.05, 0.2] {
        for strips in [1, 2, 5] {
            let cell = single(|design| {
                design.edge_radius = radius;
                design.strips = strips;
            });
            for direction in DIRECTIONS {
                let light = InsideLight::new(direction.0, direction.1);
                let d = axes.map(|axis| axis.dot(light.travel));
                let band = |k: usize, p: DVec2| {
                    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                    let point = p.extend(axes[0].z);
                    let moment = axes[i].dot(point) * d[j] - axes[j].dot(point) * d[i];
                    (moment, radius * d[i].abs().max(d[j].abs()))
                };
                let kept: f64 = (0..8)
                    .map(|signs: u32| {
                        let mut part = light.kept();
                        for k in 0..3 {
                            let sign = if signs >> k & 1 == 0 { 1.0 } else { -1.0 };
                            part = clipped(&part, |p| {
                                let (moment, half) = band(k, p);
                                sign * moment - half
                            });
                        }
                        area(&part)
                    })
                    .sum();
                let (found, entrance) = at(&cell, direction);
                let off = (found.retroreflected * entrance - kept).abs();
                worst = worst.max(off);
                assert!(
                    off < 1e-12,
                    "{radius} {strips} {direction:?}: {} not {kept}",
                    found.retroreflected * entrance
                );
                if direction.0 == 0.0 {
                    // Three bands of the width sqrt 2 R lie across a hexagon 2/sqrt 6 wide: 4 R of
                    // the aperture. They cross in three rhombi of 2 R^2 / sin 60 deg, which count
                    // once: 8 R^2 of the aperture.
                    let share = kept / (0.5 * 3_f64.sqrt());
                    let off = share - (2.0 / 3.0 - 4.0 * radius);
                    assert!(
                        (0.0..8.0 * radius * radius).contains(&off),
                        "{radius}: {off}"
                    );
                }
                cases += 1;
            }
        }
    }
    println!("{cases} rounded cubes, area within {worst:.1e} of the bands");
    assert_eq!(cases, 4 * 3 * 6);
}

/// Fates converge as the strips get narrower, because the strips then spread light as the cylinder
/// does.
#[test]
fn strips_converge() {
    let mut cases = 0;
    for direction in [(0.0, 0.0), (18.0, 77.0)] {
        let fates = |strips: u32| {
            let found = at(
                &single(|design| {
                    design.edge_radius = 0.1;
                    design.strips = strips;
                }),
                direction,
            );
            // The fates are areas, because the corners that arcs cut off the aperture differ.
            found.0.fate.map(|share| share * found.1)
        };
        let steps: Vec<[f64; Fate::ALL.len()]> = [2, 4, 8].map(fates).to_vec();
        let apart = |a: &[f64; Fate::ALL.len()], b: &[f64; Fate::ALL.len()]| -> f64 {
            a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum()
        };
        let (first, second) = (apart(&steps[0], &steps[1]), apart(&steps[1], &steps[2]));
        println!("{direction:?}: fates move by {first:.1e} from 2 to 4 strips, {second:.1e} to 8");
        assert!(second < 0.7 * first, "{first} {second}");
        cases += 1;
    }
    assert_eq!(cases, 2);
}

/// A flat at the apex takes the light of an octahedron. Reflected in the faces, the flat is an
/// octahedron of half axis s. It takes its own shadow, half the sum of the projections of its
/// faces, if all light of this shadow would return.
#[test]
fn a_flat_apex_takes_an_octahedron() {
    let mut cases = 0;
    for part in [1e-3, 0.1, 0.3] {
        let blunt = single(|design| design.apex_flat = part);
        for direction in DIRECTIONS {
            let light = InsideLight::new(direction.0, direction.1);
            let d = ideal_edges().map(|axis| axis.dot(light.travel));
            let faces = (0..8_u32).map(|signs| {
                let signed = [0, 1, 2].map(|k| if signs >> k & 1 == 0 { d[k] } else { -d[k] });
                signed.iter().sum::<f64>().abs()
            });
            // Images of the octahedron's corners.
            let corners = ideal_edges().map(|axis| {
                let image = axis - light.travel * (axis.z / light.travel.z);
                [1.0, -1.0].map(|sign| light.apex + image.truncate() * part * sign)
            });
            let kept = light.kept();
            let next = kept.iter().cycle().skip(1);
            let inside = kept.iter().zip(next).all(|(a, b)| {
                let corners = corners.as_flattened().iter();
                corners
                    .into_iter()
                    .all(|p| (*b - *a).perp_dot(*p - *a) >= 0.0)
            });
            if !inside {
                continue;
            }
            let shadow = part * part / 4.0 * faces.sum::<f64>() / -light.travel.z;
            let kept = area(&kept) - shadow;
            let (found, entrance) = at(&blunt, direction);
            assert!(
                (found.retroreflected * entrance - kept).abs() < 1e-12,
                "{part} {direction:?}: {} not {kept}",
                found.retroreflected * entrance
            );
            if direction.0 == 0.0 {
                assert!((found.retroreflected - (2.0 / 3.0 - 2.0 * part * part)).abs() < 1e-12);
            }
            cases += 1;
        }
    }
    println!("{cases} flat apexes");
    assert!(cases >= 10, "{cases}");
}

/// Land in the plane of the rim sends its light away at once and takes none of the cubes' light. So
/// eta falls by the cubes' share of the area, at every angle. The land is a strip around the
/// aperture, whose inradius r becomes r + gap / 2.
#[test]
fn land_dilutes() {
    let mut cases = 0;
    for shape in [Shape::Triangular, Shape::TriangularPair, Shape::Canted] {
        for (gap, radius) in [(0.01, 0.0), (0.3, 0.0), (0.1, 0.05)] {
            let [tight, wide] = [0.0, gap].map(|gap| {
                designed(&Design {
                    edge_length: 1.0,
                    gap,
                    edge_radius: radius,
                    strips: 2,
                    ..Design::new(shape)
                })
            });
            for direction in DIRECTIONS {
                let [(tight, inner), (wide, outer)] =
                    [&tight, &wide].map(|cell| at(cell, direction));
                if shape != Shape::Canted && radius == 0.0 {
                    let grown = (1.0 + 0.5 * gap * 6_f64.sqrt()).powi(2);
                    assert!((outer / inner - grown).abs() < 1e-12);
                }
                let share = inner / outer;
                let fates = [Fate::LeftAfter1, Fate::AntiparallelOther];
                let [before, after] = [&tight, &wide].map(|share| {
                    fates
                        .map(|fate| share.fate[fate as usize])
                        .iter()
                        .sum::<f64>()
                });
                assert!(
                    (wide.retroreflected - share * tight.retroreflected).abs() < 1e-12,
                    "{shape:?} {direction:?}"
                );
                assert!(
                    (after - share * before - (1.0 - share)).abs() < 1e-12,
                    "{shape:?} {direction:?}"
                );
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 9 * 6);
}

/// Open gaps between full cubes let light through. At normal incidence all other light returns.
#[test]
fn open_gaps_between_full_cubes_dilute() {
    let mut cases = 0;
    for gap in [0.0, 0.02, 0.4] {
        let cell = designed(&Design {
            edge_length: 1.0,
            gap,
            ..Design::new(Shape::FullCube)
        });
        let (found, _) = at(&cell, (0.0, 0.0));
        let share = (1.0 + gap / 2_f64.sqrt()).powi(-2);
        assert!(
            (found.retroreflected - share).abs() < 1e-12,
            "{gap}: {}",
            found.retroreflected
        );
        let missed = found.fate[Fate::Missed as usize];
        assert!((missed - (1.0 - share)).abs() < 1e-12, "{gap}: {missed}");
        assert_eq!(
            cell.warnings.len(),
            usize::from(gap > 0.0),
            "{:?}",
            cell.warnings
        );
        cases += 1;
    }
    assert_eq!(cases, 3);
}
