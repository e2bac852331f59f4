//! Baked tables against the closed form for the ideal cube and against known figures of other
//! cells.

use crate::tests::cells;

use crate::optics::Incidence;
use crate::plan::{Plan, Request};
use crate::tests::bakes::rays;
use cells::{bin_areas, closed_form};
use meshes::Cell;
use tables::options::Sampler;
use tables::{Fate, Table};

fn bake(cell: &Cell, request: Request) -> Table {
    let plan = Plan::new(&request).expect("a valid request");
    rays(cell, &plan).expect("bakes")
}

fn request(incidence: &str, azimuth: &str, rays: u64) -> Request {
    let (incidence, azimuth) = (incidence.into(), azimuth.into());
    Request {
        incidence,
        azimuth,
        rays: Some(rays),
        ..Request::default()
    }
}

/// Checks that fates sum to the rays, shares to 1, and the conditional histogram to 1 or to 0.
fn check_sums(table: &Table) {
    let counts = table.fate_counts.as_ref().expect("rays are counted");
    for ((i, a), &rays) in table.rays.indexed_iter() {
        let direction = counts.index_axis(ndarray::Axis(0), i);
        assert_eq!(direction.index_axis(ndarray::Axis(0), a).sum(), rays);
        let fates: f64 = table.fate.slice(ndarray::s![i, a, ..]).sum();
        assert!((fates - 1.0).abs() < 1e-12);
        let histogram = table.histogram.index_axis(ndarray::Axis(0), i);
        let sum = histogram.index_axis(ndarray::Axis(0), a).sum();
        let inside = table.fate[[i, a, Fate::Retroreflected as usize]] > 0.0;
        assert!((sum - if inside { 1.0 } else { 0.0 }).abs() < 1e-9);
    }
}

/// The retroreflected share is within 4 standard errors of plain random sampling, at every
/// direction that the model lists. It is exactly 0 where the model has 0.
#[test]
fn retroreflected_fraction_of_the_hollow_cube() {
    let n = 400_000;
    for (incidence, azimuth, expected) in cells::listed("cube") {
        let asked = request(&incidence.to_string(), &azimuth.to_string(), n);
        let table = bake(
            &cells::triangular(),
            Request {
                sampler: Sampler::Random,
                ..asked
            },
        );
        check_sums(&table);
        let (eta, error) = (table.retroreflected[[0, 0]], table.standard_error[[0, 0]]);
        // The listed figures are rounded to five digits, hence 5e-6.
        assert!(
            (eta - expected).abs() <= 4.0 * error + 5e-6,
            "({incidence}, {azimuth}): {eta} is not {expected}"
        );
        let direction = Incidence::new(incidence.to_radians(), azimuth.to_radians(), 1.0);
        let (exact, _) = closed_form(direction.travel, 0.0);
        assert!(
            (exact - expected).abs() < 6e-6,
            "the oracle itself at ({incidence}, {azimuth}): {exact}"
        );
        if expected == 0.0 {
            assert_eq!(eta, 0.0, "({incidence}, {azimuth}) returns nothing");
            assert_eq!(table.histogram.sum(), 0.0);
        }
    }
}

/// The chi-square of all bins and directions against exact probabilities of the bins is likely.
#[test]
fn every_bin_within_counting_error() {
    let n = 4_194_304_u64;
    let asked = request("0:45:5", "0,60", n);
    let table = bake(
        &cells::triangular(),
        Request {
            sampler: Sampler::Random,
            bins: 64,
            seed: 11,
            ..asked
        },
    );
    check_sums(&table);
    let counts = table.counts.as_ref().expect("rays are counted");
    let (mut chi2, mut freedom, mut tested) = (0.0, 0.0, 0);
    for (i, &incidence) in table.axes.incidence_deg.iter().enumerate() {
        for (a, &azimuth) in table.axes.azimuth_deg.iter().enumerate() {
            let direction = Incidence::new(incidence.to_radians(), azimuth.to_radians(), 1.0);
            let (fraction, polygon) = closed_form(direction.travel, 0.0);
            let polygon: Vec<_> = polygon.into_iter().map(|p| direction.to_frame(p)).collect();
            let areas = bin_areas(&polygon, 64, 2.0);
            let whole: f64 = areas.iter().sum();
            assert!(
                (whole - cells::area(&polygon)).abs() < 1e-12,
                "the oracle's bins fill the polygon"
            );
            // Bins expected to hold fewer than 20 rays are pooled with the rays that do not return.
            let (mut pooled, mut pooled_expected) = (n as f64, n as f64);
            for (bin, area) in areas.iter().enumerate() {
                let count = counts[[i, a, 0, bin / 64, bin % 64]] as f64;
                let expected = if whole > 0.0 {
                    n as f64 * fraction * area / whole
                } else {
                    0.0
                };
                assert!(expected > 0.0 || count == 0.0, "a ray where none can be");
                if expected >= 20.0 {
                    chi2 += (count - expected).powi(2) / expected;
                    freedom += 1.0;
                    pooled -= count;
                    pooled_expected -= expected;
                }
                tested += 1;
            }
            chi2 += (pooled - pooled_expected).powi(2) / pooled_expected;
        }
    }
    assert_eq!(tested, 10 * 2 * 64 * 64);
    // Wilson-Hilferty: (chi2/k)^(1/3) is normal with mean 1 - 2/(9k) and variance 2/(9k); |z| <
    // 3.09 is 1e-3 < p < 1 - 1e-3.
    let variance: f64 = 2.0 / (9.0 * freedom);
    let z = ((chi2 / freedom).cbrt() - (1.0 - variance)) / variance.sqrt();
    println!("chi2 = {chi2:.1} over {freedom} degrees of freedom, z = {z:.2}");
    assert!(
        freedom > 5000.0 && z.abs() < 3.09,
        "chi2 = {chi2}, {freedom} degrees of freedom, z = {z}"
    );
}

/// The pair at index 1.49 equals the hollow cube at the inside angle, with half of it turned by 180
/// deg.
#[test]
fn pair_behind_a_flat_face() {
    let asked = request("0:45:15", "0,30,75", 1 << 20);
    let table = bake(
        &cells::pair(),
        Request {
            refractive_index: Some(1.49),
            ..asked
        },
    );
    check_sums(&table);
    let mut tested = 0;
    for (i, &incidence) in table.axes.incidence_deg.iter().enumerate() {
        for (a, &azimuth) in table.axes.azimuth_deg.iter().enumerate() {
            let inside = (incidence.to_radians().sin() / 1.49).asin();
            let fraction = |turn: f64| {
                closed_form(
                    Incidence::new(inside, azimuth.to_radians(), 1.0).travel,
                    turn,
                )
                .0
            };
            let expected = (fraction(0.0) + fraction(180.0)) / 2.0;
            let (eta, error) = (table.retroreflected[[i, a]], table.standard_error[[i, a]]);
            assert!(
                (eta - expected).abs() <= 4.0 * error,
                "({incidence}, {azimuth}): {eta} is not {expected}"
            );
            assert!(
                error < 2e-4,
                "Sobol points beat 5e-4 of plain random ones by far: {error}"
            );
            tested += 1;
        }
    }
    assert_eq!(tested, 12);
}

/// The mean over all azimuths is that of the model: one entry of the table averages eta over them.
#[test]
fn azimuth_mean() {
    let (_, expected) = cells::listed_means();
    let table = bake(&cells::triangular(), request("0:50:5", "mean", 1 << 18));
    assert_eq!(expected.len(), table.axes.incidence_deg.len());
    check_sums(&table);
    assert!(table.axes.azimuth_deg[0].is_nan());
    for (i, expected) in expected.into_iter().enumerate() {
        let (eta, error) = (table.retroreflected[[i, 0]], table.standard_error[[i, 0]]);
        assert!(
            (eta - expected).abs() <= 4.0 * error + 5e-6,
            "row {i}: {eta} is not {expected}"
        );
    }
}
