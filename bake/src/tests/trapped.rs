//! Light that the front face traps, against a plain tracer of one ray in a slab of cubes.
//!
//! The oracle knows facets, their copies and a plane above them. It looks at every copy near the
//! ray and takes the nearest, with no order, no walls and no hierarchy.

use crate::beams::Share;
use crate::cell::Prepared;
use crate::optics::{Backing, Incidence, Rules};
use crate::plan::{Plan, Request};
use crate::rays::{Index, Scene, trace};
use crate::tests::bakes;
use crate::tests::cells::of_mesh;
use crate::tests::exact::designs::chi_square_sigmas;
use glam::{DMat3, DVec2, DVec3};
use meshes::Cell;
use meshes::design::{Design, Shape};
use rayon::prelude::*;
use tables::Fate;
use tables::options::{Front, Method, Sampler, SceneOptions};

/// Returns a periodic cell.
fn cell(shape: Shape) -> Cell {
    let mesh = Design::new(shape).mesh().expect("a design");
    of_mesh(&mesh, |options| options.periodic = true)
}

fn trapped(index: f64) -> Rules {
    Rules {
        front: Front::Trapped,
        ..Rules::mirrors(index)
    }
}

/// A slab of cubes: one period of facets, its lattice, and the height of the front face.
struct Slab {
    facets: Vec<[DVec3; 3]>,
    lattice: [DVec2; 2],
    height: f64,
}

impl Slab {
    fn of(cell: &Cell) -> Slab {
        Slab {
            facets: cell.facets.clone(),
            lattice: cell.entrance.lattice.expect("a lattice"),
            height: cell.entrance.height,
        }
    }

    /// Returns the nearest facet ahead. All copies are looked at that lie beside the way of the ray
    /// and at most 40 periods away. Light that goes farther runs within a degree of the sheet.
    fn nearest(
        &self,
        from: DVec3,
        toward: DVec3,
        left: Option<(usize, [i32; 2])>,
    ) -> Option<OracleHit> {
        const REACH: i32 = 40;
        /// No facet is farther than this from the corner of its period, edge lengths.
        const SIZE: f64 = 3.0;
        let [a, b] = self.lattice;
        let here = from.truncate();
        let at = |x: f64| x.floor() as i32;
        let (i, j) = (
            at(here.perp_dot(b) / a.perp_dot(b)),
            at(a.perp_dot(here) / a.perp_dot(b)),
        );
        let mut nearest: Option<OracleHit> = None;
        for i in i - REACH..=i + REACH {
            for j in j - REACH..=j + REACH {
                let moved = (f64::from(i) * a + f64::from(j) * b).extend(0.0);
                let (off, way) = (moved.truncate() - here, toward.truncate());
                if off.perp_dot(way).abs() > SIZE * way.length() || off.dot(way) < -SIZE {
                    continue;
                }
                for (number, facet) in self.facets.iter().enumerate() {
                    if left == Some((number, [i, j])) {
                        continue;
                    }
                    let [p, q, r] = facet.map(|corner| corner + moved - from);
                    let normal = (q - p).cross(r - p).normalize();
                    let distance = normal.dot(p) / normal.dot(toward);
                    let x = toward * distance;
                    let inside = [(p, q), (q, r), (r, p)]
                        .into_iter()
                        .all(|(s, t)| normal.dot((t - s).cross(x - s)) >= 0.0);
                    let is_nearer = nearest.is_none_or(|met| distance < met.distance);
                    if distance > -1e-12 && normal.dot(toward) < 0.0 && inside && is_nearer {
                        nearest = Some(OracleHit {
                            distance,
                            normal,
                            facet: (number, [i, j]),
                        });
                    }
                }
            }
        }
        nearest
    }

    /// Follows a ray to the place and the direction in which it leaves. Returns them with the
    /// numbers of facets and of total reflections at the front; `None` for the place if the ray
    /// does not leave.
    fn follow(&self, point: DVec2, travel: DVec3, index: f64) -> (Option<DVec2>, DMat3, [u32; 2]) {
        let (mut at, mut toward) = (point.extend(self.height), travel);
        let (mut map, mut facets, mut fronts) = (DMat3::IDENTITY, 0, 0);
        let mut left = None;
        let mut mirror = |toward: &mut DVec3, normal: DVec3| {
            let fold = |x: DVec3| x - 2.0 * normal.dot(x) * normal;
            *toward = fold(*toward);
            map = DMat3::from_cols(fold(map.x_axis), fold(map.y_axis), fold(map.z_axis));
        };
        loop {
            if let Some(met) = self.nearest(at, toward, left) {
                if facets == 64 * (fronts + 1) {
                    return (None, map, [facets, fronts]);
                }
                at += met.distance * toward;
                left = Some(met.facet);
                mirror(&mut toward, met.normal);
                facets += 1;
                continue;
            }
            at += toward * ((self.height - at.z) / toward.z);
            let sine = index * toward.truncate().length();
            if sine < 1.0 {
                return (Some(at.truncate()), map, [facets, fronts]);
            }
            if fronts == 64 {
                return (None, map, [facets, fronts]);
            }
            mirror(&mut toward, DVec3::Z);
            left = None;
            fronts += 1;
        }
    }
}

/// Facet that a ray of the oracle meets.
#[derive(Clone, Copy)]
struct OracleHit {
    distance: f64,
    normal: DVec3,
    facet: (usize, [i32; 2]),
}

/// Returns point number `k` of a net in the period, at which no symmetry puts two rays on a rim.
fn entry(slab: &Slab, k: usize) -> DVec2 {
    let part = |step: f64| (0.137 + step * k as f64).fract();
    let [a, b] = slab.lattice;
    part(0.754_877_666_246_692_7) * a + part(0.569_840_290_998_053_2) * b
}

/// Cells, indices and directions: incidence and azimuth, degrees.
fn cases() -> Vec<(Shape, f64, f64, f64)> {
    let mut all = Vec::new();
    for (shape, index) in [
        (Shape::TriangularPair, 1.49),
        (Shape::FullCube, 1.49),
        (Shape::TriangularPair, 1.586),
        (Shape::FullCube, 1.586),
    ] {
        for (incidence, azimuth) in [
            (0.0, 0.0),
            (20.0, 0.0),
            (30.0, 0.0),
            (40.0, 0.0),
            (45.0, 0.0),
            (55.0, 0.0),
            (35.0, 7.0),
            (45.0, 30.0),
            (50.0, 180.0),
            (60.0, 100.0),
        ] {
            all.push((shape, index, incidence, azimuth));
        }
    }
    all
}

/// Each ray ends as the plain tracer says. Rays that pass within rounding of a rim may differ: 1e-9
/// of the area, so none of these 8,000.
#[test]
fn rays_go_the_way_of_a_plain_tracer() {
    const RAYS: usize = 200;
    let mut counts = [0; 3];
    for (shape, index, incidence, azimuth) in cases() {
        let cell = cell(shape);
        let slab = Slab::of(&cell);
        let scene = Scene::new(&cell, Index::Auto);
        let rules = trapped(index);
        let light = Incidence::new(incidence.to_radians(), azimuth.to_radians(), index);
        for k in 0..RAYS {
            let point = entry(&slab, k);
            let (left, map, [facets, fronts]) = slab.follow(point, light.travel, index);
            let found = trace(&scene, &rules, &light, point, 0.5);
            let name = format!("{shape:?} {index} {incidence} {azimuth} {k}");
            assert_eq!(found.bounces, facets, "{name}");
            let is_back = is_minus_identity(map);
            assert_eq!(found.fate == Fate::Trapped, left.is_none(), "{name}");
            if let Some(left) = left {
                assert_eq!(found.fate == Fate::Retroreflected, is_back, "{name}");
                if is_back {
                    let off = (found.shift - light.to_frame(left - point)).length();
                    assert!(off < 1e-9, "{name}: {off:e}");
                    counts[1] += 1;
                    counts[2] += usize::from(fronts > 0);
                }
            }
            counts[0] += 1;
        }
    }
    println!("{counts:?} rays, retroreflected, of these after the front");
    assert_eq!(counts[0], 40 * RAYS);
    assert!(counts[2] > 50);
}

fn share(prepared: &Prepared, incidence: f64, azimuth: f64, rules: Rules) -> Share {
    let exact = prepared.exact().expect("an exact cell");
    exact.direction(incidence, azimuth, 32, 8.0, &rules)
}

/// Returns the shares without and with light that the front face sends back.
fn shares(prepared: &Prepared, incidence: f64, azimuth: f64, rules: Rules) -> [Share; 2] {
    let share = |front| share(prepared, incidence, azimuth, Rules { front, ..rules });
    [Front::Once, Front::Trapped].map(share)
}

fn is_minus_identity(map: DMat3) -> bool {
    let off = (map + DMat3::IDENTITY).to_cols_array();
    off.iter().all(|x| x.abs() < 1e-9)
}

/// Shares of beams against counts of plain rays, within counting error: 5 standard deviations of
/// each share, which chance exceeds in one of 15,000 runs of these 120 comparisons. All fates sum
/// to 1.
#[test]
#[ignore = "half a minute: `make test-slowest` runs it"]
fn beams_are_the_mean_of_plain_rays() {
    const RAYS: usize = 1000;
    let compared: Vec<usize> = cases()
        .into_par_iter()
        .map(|(shape, index, incidence, azimuth)| {
            let cell = cell(shape);
            let slab = Slab::of(&cell);
            let prepared = Prepared::new(cell);
            let [once, all] = shares(&prepared, incidence, azimuth, trapped(index));
            let name = format!("{shape:?} {index} {incidence} {azimuth}");
            let sum: f64 = all.fate.iter().sum::<f64>() + all.dropped;
            assert!((sum - 1.0).abs() < 1e-12, "{name}: {:e}", sum - 1.0);
            assert!(all.dropped.abs() < 1e-12, "{name}: {:e}", all.dropped);
            let light = Incidence::new(incidence.to_radians(), azimuth.to_radians(), index);
            // Retroreflected, of it after the front face, and light that does not leave.
            let mut counts = [0.0; 3];
            for k in 0..RAYS {
                let point = entry(&slab, k);
                let (left, map, [_, fronts]) = slab.follow(point, light.travel, index);
                let is_back = is_minus_identity(map);
                counts[0] += f64::from(u8::from(is_back && left.is_some()));
                counts[1] += f64::from(u8::from(is_back && left.is_some() && fronts > 0));
                counts[2] += f64::from(u8::from(left.is_none()));
            }
            let extra = (all.retroreflected - once.retroreflected).max(0.0);
            let limit = all.fate[Fate::Trapped as usize];
            println!(
                "{name}: eta {:.5} once {:.5}, extra {:.2} %, left over {limit:.1e}, {} paths",
                all.retroreflected,
                once.retroreflected,
                100.0 * extra / once.retroreflected,
                all.paths.len(),
            );
            for (expected, count) in [all.retroreflected, extra, limit].into_iter().zip(counts) {
                let deviation = (expected * (1.0 - expected) / RAYS as f64).sqrt();
                let off = count / RAYS as f64 - expected;
                assert!(off.abs() <= 5.0 * deviation, "{name}: {off} {deviation}");
            }
            3
        })
        .collect();
    assert_eq!(compared.into_iter().sum::<usize>(), 120);
}

/// Chi-square of rays against beams, bins of shift and fates together: in 899 of 900 seeds 40 cases
/// stay within 4.2 standard deviations.
#[test]
fn histograms_of_rays_are_those_of_beams() {
    let (mut cases, mut worst) = (0, f64::NEG_INFINITY);
    for shape in [Shape::TriangularPair, Shape::FullCube] {
        for index in [1.49, 1.586] {
            let request = Request {
                incidence: "0,20,30,40,45".into(),
                azimuth: "0,30".into(),
                refractive_index: Some(index),
                sampler: Sampler::Random,
                rays: Some(1 << 16),
                bins: 32,
                range: 3.0,
                scene: SceneOptions {
                    front: Front::Trapped,
                    ..SceneOptions::default()
                },
                ..Request::default()
            };
            let [exact, traced] = [Method::Exact, Method::Rays].map(|method| {
                let request = Request {
                    method,
                    ..request.clone()
                };
                let plan = Plan::new(&request).expect("a plan");
                bakes::bake(&cell(shape), &plan).expect("bakes")
            });
            for at in ndarray::indices(traced.rays.dim()) {
                let sigmas = chi_square_sigmas(&exact, &traced, at);
                assert!(sigmas < 4.2, "{shape:?} {index} {at:?}: {sigmas}");
                worst = worst.max(sigmas);
                cases += 1;
            }
        }
    }
    println!("{cases} directions, at most {worst:.2} standard deviations");
    assert_eq!(cases, 40);
}

/// All light ends in a fate: the sum is 1 to 1e-12 in directions near the planes of symmetry, where
/// polygons have edges that are shorter than their rounding.
#[test]
fn no_light_is_lost_near_the_planes_of_symmetry() {
    let mut cases = 0;
    for shape in [Shape::TriangularPair, Shape::FullCube] {
        let prepared = Prepared::new(cell(shape));
        for (incidence, index) in [(25.0, 1.49), (40.0, 1.49), (45.0, 1.49), (50.0, 1.586)] {
            for plane in [0.0, 30.0, 60.0, 150.0, 240.0] {
                for k in 0..10 {
                    let off = 10_f64.powf(-f64::from(k));
                    for azimuth in [plane - off, plane + off] {
                        let [once, all] = shares(&prepared, incidence, azimuth, trapped(index));
                        for found in [once, all] {
                            let sum = found.fate.iter().sum::<f64>() - 1.0;
                            assert!(
                                sum.abs() < 1e-12,
                                "{shape:?} {incidence} {azimuth}: {sum:e}"
                            );
                            cases += 1;
                        }
                    }
                }
            }
        }
    }
    assert_eq!(cases, 2 * 800);
}

/// With losses, total reflection at the front leaves rounding, which is no light: no path has a
/// weight below 0.
#[test]
fn no_path_has_a_negative_weight() {
    let mut paths = 0;
    for shape in [Shape::Canted, Shape::TriangularPair] {
        let prepared = Prepared::new(cell(shape));
        let rules = Rules {
            losses: Some(Backing::Mirror { reflectance: 0.9 }),
            ..trapped(1.586)
        };
        for incidence in [45.0, 70.0, 89.0] {
            for azimuth in [1e-6, 30.0, 59.9999] {
                let found = share(&prepared, incidence, azimuth, rules);
                assert!(found.paths.iter().all(|path| path.weight > 0.0));
                paths += found.paths.len();
            }
        }
    }
    println!("{paths} paths");
    assert!(paths > 100);
}

/// Between media of one index there is no front face, so nothing changes.
#[test]
fn a_front_of_index_1_changes_nothing() {
    let mut cases = 0;
    for shape in [Shape::TriangularPair, Shape::FullCube] {
        let prepared = Prepared::new(cell(shape));
        for losses in [None, Some(Backing::Mirror { reflectance: 0.9 })] {
            for (incidence, azimuth) in [(0.0, 0.0), (30.0, 10.0), (60.0, 100.0)] {
                let rules = Rules {
                    losses,
                    ..trapped(1.0)
                };
                let [once, all] = shares(&prepared, incidence, azimuth, rules);
                // The beams of the sheet start from other facets than those of its recesses.
                assert!((once.retroreflected - all.retroreflected).abs() < 1e-13);
                for (once, all) in once.fate.iter().zip(all.fate) {
                    assert!((once - all).abs() < 1e-13, "{shape:?} {incidence}");
                }
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 12);
}

/// At normal incidence a full cube returns all light. With R = ((m - 1) / (m + 1))^2 of the front
/// face, the light that comes back after k reflections there is (1 - R)^2 R^k: by -I for even k,
/// and by a mirrored map for odd k. What is below the least power, 1e-6, is not followed.
#[test]
fn light_between_front_and_cubes_is_a_geometric_series() {
    let mut cases = 0;
    for index in [1.33, 1.49, 1.586, 1.9] {
        let prepared = Prepared::new(cell(Shape::FullCube));
        let rules = Rules {
            losses: Some(Backing::Mirror { reflectance: 1.0 }),
            ..trapped(index)
        };
        let found = share(&prepared, 0.0, 0.0, rules);
        let r = ((index - 1.0) / (index + 1.0_f64)).powi(2);
        let back = (1.0 - r).powi(2) / (1.0 - r * r);
        assert!((found.retroreflected - back).abs() < 1e-6, "{index}");
        let mirrored = found.fate[Fate::AntiparallelOther as usize];
        assert!((mirrored - r * back).abs() < 1e-6, "{index}: {mirrored}");
        let sum: f64 = found.fate.iter().sum::<f64>() + found.dropped;
        assert!((sum - 1.0).abs() < 1e-12, "{index}: {:e}", sum - 1.0);
        cases += 1;
    }
    assert_eq!(cases, 4);
}

/// With Fresnel's losses photons have the shares of beams: within 5 standard deviations of the
/// counting. All power ends in a fate.
#[test]
fn photons_agree_with_beams_behind_a_front() {
    const RAYS: usize = 4000;
    let mut cases = 0;
    for (surface, incidence, azimuth) in [
        (Backing::Mirror { reflectance: 0.95 }, 40.0, 0.0),
        (Backing::Mirror { reflectance: 0.95 }, 10.0, 20.0),
        (Backing::Bare, 45.0, 0.0),
        (Backing::Bare, 20.0, 50.0),
    ] {
        let rules = Rules {
            losses: Some(surface),
            ..trapped(1.49)
        };
        let cell = cell(Shape::TriangularPair);
        let scene = Scene::new(&cell, Index::Auto);
        let slab = Slab::of(&cell);
        let prepared = Prepared::new(cell);
        let beams = share(&prepared, incidence, azimuth, rules);
        let sum: f64 = beams.fate.iter().sum::<f64>() + beams.dropped;
        assert!((sum - 1.0).abs() < 1e-12, "{incidence}: {:e}", sum - 1.0);
        let light = Incidence::new(incidence.to_radians(), f64::to_radians(azimuth), 1.49);
        let mut counts = [0.0; Fate::ALL.len()];
        for k in 0..RAYS {
            let chance = (0.5 + 0.438_579_021_9 * k as f64).fract();
            let found = trace(&scene, &rules, &light, entry(&slab, k), chance);
            counts[found.fate as usize] += 1.0 / RAYS as f64;
        }
        for (expected, count) in beams.fate.into_iter().zip(counts) {
            let deviation = (expected * (1.0 - expected) / RAYS as f64).sqrt();
            println!("{incidence} {azimuth}: {expected:.5} {count:.5}");
            assert!((count - expected).abs() <= 5.0 * deviation, "{incidence}");
            cases += 1;
        }
    }
    assert_eq!(cases, 4 * Fate::ALL.len());
}
