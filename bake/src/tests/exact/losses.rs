//! Losses: closed forms, the sums of power, a plain Jones trace of the ideal cube, and photons.
//!
//! The oracle works in the cube's own axes. There a face turns one sign of the direction, so a path
//! is an order of the three faces. Jones matrices of 2 x 2 in the s and p of each surface are
//! turned from one surface to the next, with textbook amplitudes by complex cosines. Only the
//! polygons, whose weights are judged, are shared with the crate.

use crate::cli::comparison_text;
use crate::optics::{Backing, Rules};
use crate::plan::{Plan, Request};
use crate::run::Comparison;
use crate::tests::bakes;
use crate::tests::bakes::asked;
use glam::DVec3;
use ndarray::s;
use num_complex::Complex64;
use std::path::Path;
use tables::options::{Front, Losses, Method, Sampler};
use tables::{Fate, Table};

use crate::tests::cells::full_cube;
use crate::tests::exact::cells::{
    Draw, bent_edges, blunt, canted_edges, ideal_edges, pair, single, truncated,
};

const ALUMINIUM: Complex64 = Complex64::new(0.967, 6.462);
const SURFACES: [Backing; 4] = [
    Backing::Mirror { reflectance: 1.0 },
    Backing::Mirror { reflectance: 0.91 },
    Backing::Metal(ALUMINIUM),
    Backing::Bare,
];

fn lossy(index: f64, surface: Backing) -> Rules {
    Rules {
        losses: Some(surface),
        ..Rules::mirrors(index)
    }
}

type Jones = [[Complex64; 2]; 2];

fn product(a: Jones, b: Jones) -> Jones {
    [0, 1].map(|i| [0, 1].map(|k| a[i][0] * b[0][k] + a[i][1] * b[1][k]))
}

/// Returns the Jones matrix from the components along `from` to those along `to`.
fn turned(from: [DVec3; 2], to: [DVec3; 2]) -> Jones {
    to.map(|to| from.map(|from| Complex64::from(to.dot(from))))
}

/// Returns s and p before and after a surface that light meets along `d`, with p = s x d.
fn frame(d: DVec3, after: DVec3, normal: DVec3) -> [[DVec3; 2]; 2] {
    let s = normal.cross(d);
    let s = if s.length() < 1e-9 {
        d.any_orthonormal_vector()
    } else {
        s.normalize()
    };
    [[s, s.cross(d)], [s, s.cross(after)]]
}

/// Returns the amplitudes (r_s, r_p) and (t_s, t_p) from index n1 to n2. The sign of r_p goes with
/// s x d.
fn fresnel(n1: f64, cosine: f64, n2: Complex64) -> ([Complex64; 2], [Complex64; 2]) {
    let sine = Complex64::from(n1 * (1.0 - cosine * cosine).sqrt()) / n2;
    let inner = (Complex64::ONE - sine * sine).sqrt();
    // With exp(-i omega t), a field that decays has a positive imaginary part of n cos.
    let inner = if (n2 * inner).im < 0.0 { -inner } else { inner };
    let (a, b) = (cosine * n1, n2 * inner);
    let (c, d) = (n2 * cosine, inner * n1);
    let r = [(a - b) / (a + b), (c - d) / (c + d)];
    (r, [2.0 * a / (a + b), 2.0 * a / (c + d)])
}

/// Returns the Jones matrix of the ray that enters an ideal cube at (u, v) over its apex. The axes
/// are s, which is -v for the light that leaves, and p = s x d.
fn oracle(index: f64, surface: Backing, incidence: f64, azimuth: f64, entry: [f64; 2]) -> Jones {
    let edges = ideal_edges();
    let up = DVec3::Z;
    let (sine, inner) = (incidence.sin(), (incidence.sin() / index).asin());
    let t = DVec3::new(azimuth.cos(), azimuth.sin(), 0.0);
    let outside = t * sine - up * incidence.cos();
    let mut d = t * inner.sin() - up * inner.cos();
    let through = |n1: f64, c1: f64, n2: f64, c2: f64| {
        let (_, t) = fresnel(n1, c1, Complex64::from(n2));
        t.map(|t| t * (n2 * c2 / (n1 * c1)).sqrt())
    };
    let diagonal = |[a, b]: [Complex64; 2]| [[a, Complex64::ZERO], [Complex64::ZERO, b]];
    let [_, mut basis] = frame(outside, d, up);
    let mut jones = diagonal(through(1.0, incidence.cos(), index, inner.cos()));
    let point = t * entry[0] + up.cross(t) * entry[1] + up * edges[0].z;
    let mut faces = [0, 1, 2];
    let arrival = |k: &usize| -point.dot(edges[*k]) / d.dot(edges[*k]);
    faces.sort_by(|a, b| arrival(a).total_cmp(&arrival(b)));
    for k in faces {
        let normal = edges[k];
        let after = d - 2.0 * d.dot(normal) * normal;
        let [before, next] = frame(d, after, normal);
        let r = match surface {
            Backing::Mirror { reflectance } => {
                let amplitude = Complex64::from(reflectance.sqrt());
                [-amplitude, amplitude]
            }
            Backing::Metal(metal) => fresnel(index, d.dot(normal).abs(), metal).0,
            Backing::Bare => fresnel(index, d.dot(normal).abs(), Complex64::ONE).0,
        };
        jones = product(diagonal(r), product(turned(basis, before), jones));
        (d, basis) = (after, next);
    }
    let [before, _] = frame(d, -outside, up);
    jones = product(turned(basis, before), jones);
    product(
        diagonal(through(index, inner.cos(), 1.0, incidence.cos())),
        jones,
    )
}

fn power(jones: &Jones) -> f64 {
    let squares = jones.as_flattened().iter().map(Complex64::norm_sqr);
    squares.sum::<f64>() / 2.0
}

/// Returns how far rounding may move an amplitude: some twenty products, and three faces whose phase
/// goes as the root of the distance from the critical angle.
fn rounding(index: f64, incidence: f64, azimuth: f64) -> f64 {
    let inner = (incidence.to_radians().sin() / index).asin();
    let (sin, cos) = azimuth.to_radians().sin_cos();
    let travel = DVec3::new(inner.sin() * cos, inner.sin() * sin, -inner.cos());
    let beyond = ideal_edges().map(|normal| {
        let cosine = normal.dot(travel);
        (index * index * (1.0 - cosine * cosine) - 1.0).abs()
    });
    let nearest = beyond.into_iter().fold(1.0, f64::min);
    1e-12 + 20.0 * f64::EPSILON * index * index / nearest.sqrt()
}

/// Weights and Jones matrices of paths equal those of the plain Jones trace to 1e-12. Both multiply some twenty
/// amplitudes, each good to some ulp. Near the critical angle a cosine is the root of a difference,
/// which costs at most a factor of some hundred at the directions drawn, and for the phases what
/// [`rounding`] says.
#[test]
fn weights_are_those_of_a_plain_jones_trace() {
    let exact = bakes::exact(&single(ideal_edges())).unwrap();
    let mut draw = Draw(17);
    let (mut compared, mut apart) = (0, 0.0_f64);
    for step in 0..300 {
        let (incidence, azimuth) = (
            if step == 0 { 0.0 } else { 60.0 * draw.next() },
            360.0 * draw.next(),
        );
        for index in [1.0, 1.49, 1.586] {
            for surface in SURFACES {
                if index == 1.0 && surface == Backing::Bare {
                    continue;
                }
                let found = exact.direction(incidence, azimuth, 16, 2.0, &lossy(index, surface));
                let allowed = rounding(index, incidence, azimuth);
                for path in &found.paths {
                    let n = path.polygon.len() as f64;
                    let middle = [0, 1].map(|k| path.polygon.iter().map(|p| p[k]).sum::<f64>() / n);
                    let (theta, phi) = (incidence.to_radians(), azimuth.to_radians());
                    let matrix = oracle(index, surface, theta, phi, middle);
                    let expected = power(&matrix);
                    let own = path.jones.expect("there are losses");
                    // The axes of the oracle are arbitrary along the normal.
                    let pairs = own.as_flattened().iter().zip(matrix.as_flattened());
                    for (&[re, im], other) in pairs.filter(|_| step > 0) {
                        let off = (Complex64::new(re, im) + other).norm();
                        assert!(
                            off < allowed,
                            "({incidence}, {azimuth}), {index}, {surface:?}: {off:e}, {allowed:e}"
                        );
                    }
                    let of_fields = own.as_flattened().iter().flatten().map(|x| x * x);
                    assert!((of_fields.sum::<f64>() / 2.0 - path.weight).abs() < 1e-12);
                    let error = (path.weight - expected).abs();
                    assert!(
                        error < 1e-12,
                        "({incidence}, {azimuth}), {index}, {surface:?}: {} is not {expected}",
                        path.weight
                    );
                    compared += 1;
                }
                let weights = || found.paths.iter().map(|path| path.weight);
                let span = weights().fold(0.0, f64::max) - weights().fold(1.0, f64::min);
                apart = apart.max(if found.paths.is_empty() { 0.0 } else { span });
            }
        }
    }
    assert!(compared > 5_000, "{compared}");
    assert!(
        apart > 1e-3,
        "orders of the faces must differ somewhere: {apart:e}"
    );
}

#[test]
fn power_is_neither_lost_nor_made() {
    let cells = [
        single(ideal_edges()),
        pair(ideal_edges(), true),
        full_cube(),
        pair(canted_edges(-0.2, 0.45), true),
        pair(bent_edges([1e-3, -2e-3, 5e-4]), true),
        blunt(0.3),
        truncated(0.2),
    ];
    let mut draw = Draw(23);
    let mut cases = 0;
    for cell in &cells {
        let exact = bakes::exact(cell).unwrap();
        for _ in 0..20 {
            let (incidence, azimuth) = (80.0 * draw.next(), 360.0 * draw.next());
            for surface in SURFACES {
                let lossy = lossy(1.49, surface);
                let found = exact.direction(incidence, azimuth, 32, 2.0, &lossy);
                let sum: f64 = found.fate.iter().sum();
                assert!((sum - 1.0).abs() < 1e-12, "{sum}");
                assert!(found.dropped.abs() < 1e-12);
                assert!(found.fate.iter().all(|share| *share > -1e-14));
                // Without losses no less light comes back, and nothing is absorbed.
                let whole = exact.direction(incidence, azimuth, 32, 2.0, &Rules::mirrors(1.49));
                assert!(found.retroreflected <= whole.retroreflected + 1e-13);
                assert_eq!(whole.fate[Fate::Absorbed as usize], 0.0);
                let metal = !matches!(
                    surface,
                    Backing::Bare | Backing::Mirror { reflectance: 1.0 }
                );
                assert_eq!(found.fate[Fate::Absorbed as usize] > 1e-13, metal);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 560);
}

/// What the front reflects on the way in is Fresnel's mean reflectance of s and p, whatever is behind
/// it: some ten operations on numbers of at most 1. Light that it sends back inside is `trapped`.
/// Without `--front trapped`, ideal mirrors lose light to nothing else.
#[test]
fn the_front_reflects_what_fresnel_says() {
    let mut cases = 0;
    for cell in [single(ideal_edges()), pair(ideal_edges(), true)] {
        let exact = bakes::exact(&cell).unwrap();
        for index in [1.49, 1.586, 2.4] {
            for incidence in [0.0, 20.0, 45.0, f64::atan(index).to_degrees(), 80.0] {
                let ([s, p], _) = fresnel(1.0, f64::to_radians(incidence).cos(), index.into());
                let expected = f64::midpoint(s.norm_sqr(), p.norm_sqr());
                for surface in SURFACES {
                    let rules = lossy(index, surface);
                    let found = exact.direction(incidence, 20.0, 16, 2.0, &rules);
                    let share = found.fate[Fate::ReflectedByFront as usize];
                    let off = (share - expected).abs();
                    assert!(off < 1e-14, "{index} {incidence} {surface:?}: {off:e}");
                    cases += 1;
                }
                let mirrors = lossy(index, SURFACES[0]);
                let found = exact.direction(incidence, 20.0, 16, 2.0, &mirrors);
                let whole = exact.direction(incidence, 20.0, 16, 2.0, &Rules::mirrors(index));
                let kinds = [Fate::Retroreflected, Fate::LeftAfter1, Fate::LeftAfter2];
                let of = |fates: &[f64]| kinds.map(|fate| fates[fate as usize]).iter().sum::<f64>();
                let back = (1.0 - expected) * of(&whole.fate) - of(&found.fate);
                let kept = found.fate[Fate::Trapped as usize];
                assert!(
                    (kept - back).abs() < 1e-13,
                    "{index} {incidence}: {kept} {back}"
                );
            }
        }
    }
    assert_eq!(cases, 120);
}

/// A table from before the front had a fate of its own says the same light, as `absorbed`. They
/// agree to the 1e-9 of a comparison.
#[test]
fn older_tables_count_the_front_as_absorbed() {
    let kept = |name: &str| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tables/tests/kept");
        tables::read(&folder.join(name)).unwrap()
    };
    let [older, newer] = ["version_1_lossy.h5", "version_4_exact.h5"].map(kept);
    for [a, b] in [[&older, &newer], [&newer, &older]] {
        let judged = Comparison::new(a, b).unwrap();
        assert!(judged.agrees(), "{}", comparison_text(&judged));
    }
    let mut other = newer.clone();
    let front = Fate::ReflectedByFront as usize;
    other
        .fate
        .slice_mut(s![.., .., front])
        .mapv_inplace(|share| share - 1e-4);
    assert!(!Comparison::new(&older, &other).unwrap().agrees());
}

/// Perfect mirrors without a front face lose nothing.
#[test]
fn losses_of_ideal_surfaces_are_none() {
    let exact = bakes::exact(&pair(ideal_edges(), true)).unwrap();
    let mut draw = Draw(29);
    for _ in 0..50 {
        let (incidence, azimuth) = (60.0 * draw.next(), 360.0 * draw.next());
        let mirror = Backing::Mirror { reflectance: 1.0 };
        let [with, without] = [lossy(1.0, mirror), Rules::mirrors(1.0)]
            .map(|rules| exact.direction(incidence, azimuth, 32, 2.0, &rules));
        assert_eq!(with.paths.len(), without.paths.len());
        for (a, b) in with.fate.iter().zip(without.fate) {
            assert!((a - b).abs() < 1e-14);
        }
    }
}

/// At normal incidence three faces of 96 % lose 12 % and three of 91 % lose 25 %. A front face
/// passes 4 m/(m + 1)^2, twice.
#[test]
fn known_losses_at_normal_incidence() {
    let exact = bakes::exact(&single(ideal_edges())).unwrap();
    let eta = |index, surface| {
        exact
            .direction(0.0, 0.0, 16, 2.0, &lossy(index, surface))
            .retroreflected
    };
    for (reflectance, percent) in [(0.96_f64, 12.0_f64), (0.91, 25.0)] {
        let found = eta(1.0, Backing::Mirror { reflectance });
        assert!((found - 2.0 / 3.0 * reflectance.powi(3)).abs() < 1e-14);
        assert_eq!(((1.0 - found * 1.5) * 100.0).round(), percent);
    }
    for index in [1.49_f64, 1.5168, 1.586] {
        let passed = 4.0 * index / (index + 1.0).powi(2);
        for surface in [Backing::Bare, Backing::Mirror { reflectance: 1.0 }] {
            // The angle of 54.7 deg is beyond every critical angle, so that bare faces lose
            // nothing.
            let found = eta(index, surface);
            assert!((found - 2.0 / 3.0 * passed * passed).abs() < 1e-14);
        }
    }
}

/// Total reflection ends at the known angles. Beyond |d_i| = sqrt(1 - 1/m^2) a face lets light
/// through. This happens first at the three azimuths where the light leans away from an edge, at
/// the angle known for m.
#[test]
fn total_reflection_ends_at_the_known_angles() {
    let exact = bakes::exact(&single(ideal_edges())).unwrap();
    for (index, known) in [(1.49, 18.94), (1.5168, 20.72), (1.586, 25.33)] {
        let tir = Rules {
            mirror_back: false,
            ..Rules::mirrors(index)
        };
        let limit = |azimuth: f64| {
            let (mut low, mut high) = (0.0, 60.0);
            for _ in 0..40 {
                let middle = f64::midpoint(low, high);
                let lost = exact
                    .direction(middle, azimuth, 4, 2.0, &tir)
                    .retroreflected
                    == 0.0;
                (low, high) = if lost { (low, middle) } else { (middle, high) };
            }
            high
        };
        let limits: Vec<f64> = (0..72).map(|k| limit(5.0 * f64::from(k))).collect();
        let least = limits.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((least - known).abs() < 0.005, "{index}: {least}");
        let worst: Vec<usize> = (0..72).filter(|&k| limits[k] < least + 1e-6).collect();
        assert_eq!(worst, [12, 36, 60], "60, 180 and 300 deg");
        // With Fresnel's losses the step is a slope: all light is kept below it and a part above
        // it.
        let share =
            |incidence: f64| exact.direction(incidence, 60.0, 4, 2.0, &lossy(index, Backing::Bare));
        let [below, above] = [least - 0.01, least + 0.5].map(share);
        assert!(below.fate[Fate::Transmitted as usize].abs() < 1e-14);
        assert!(above.fate[Fate::Transmitted as usize] > 0.1);
        assert!(
            above.retroreflected > 0.01 && above.retroreflected < 0.8 * below.retroreflected,
            "{}",
            above.retroreflected
        );
    }
}

fn tables(azimuth: &str, sampler: Sampler, threads: usize) -> [Table; 2] {
    let cell = pair(ideal_edges(), true);
    [Method::Exact, Method::Rays].map(|method| {
        let request = Request {
            azimuth: azimuth.into(),
            refractive_index: Some(1.49),
            losses: Losses::Fresnel,
            metal: Some(ALUMINIUM),
            wavelength_nm: Some(550.0),
            threads: Some(threads),
            method,
            sampler,
            ..asked("--incidence 0,25 --back mirror --rays 131072 --bins 32")
        };
        let plan = Plan::new(&request).unwrap();
        bakes::bake(&cell, &plan).unwrap()
    })
}

/// Photons agree with the weights of beams within their counting errors. A photon is kept by
/// chance, so that counts are whole.
#[test]
fn photons_agree_with_beams() {
    let mut cases = 0;
    for azimuth in ["10", "mean"] {
        for sampler in [Sampler::Random, Sampler::Sobol] {
            let [exact, rays] = tables(azimuth, sampler, 2);
            let judged = Comparison::new(&exact, &rays).unwrap();
            assert!(judged.agrees(), "{}", comparison_text(&judged));
            for ((i, a), &n) in rays.rays.indexed_iter() {
                for &fate in Fate::of(Front::Once, true) {
                    let expected = exact.fate[[i, a, fate as usize]];
                    let sigma = (expected * (1.0 - expected) / n as f64).max(0.0).sqrt();
                    let error = (rays.fate[[i, a, fate as usize]] - expected).abs();
                    assert!(error <= 5.0 * sigma + 1e-12, "{}: {error}", fate.name());
                    cases += 1;
                }
            }
            assert!(exact.fate[[0, 0, Fate::Absorbed as usize]] > 0.2);
        }
    }
    assert_eq!(cases, 96);
    let [one, two] = [1, 2].map(|threads| tables("10", Sampler::Sobol, threads));
    for (one, two) in one.iter().zip(&two) {
        assert_eq!(one.content_hash(), two.content_hash(), "threads");
        assert_eq!(one.provenance.metal_index, Some([0.967, 6.462]));
        assert_eq!(one.provenance.wavelength_nm, Some(550.0));
        assert_eq!(one.provenance.losses.text(), "fresnel");
    }
}
