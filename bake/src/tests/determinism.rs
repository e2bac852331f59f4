//! Equal inputs give equal bytes, whatever the number of threads.

use crate::plan::{Plan, Request};
use crate::tests::bakes::asked;
use crate::tests::bakes::rays;
use crate::tests::cells;
use tables::options::Sampler;

#[test]
fn one_two_and_three_threads_write_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut compared = 0;
    for (cell, sampler, azimuth) in [
        (cells::pair(), Sampler::Sobol, "10,70"),
        (cells::triangular(), Sampler::Random, "0"),
        (cells::full_cube(), Sampler::Sobol, "0"),
        (cells::triangular(), Sampler::Sobol, "mean"),
        (
            cells::uneven_pair([5e-4, 0.0, -3e-4]),
            Sampler::Sobol,
            "10,70",
        ),
    ] {
        let bytes: Vec<Vec<u8>> = [1, 2, 3]
            .map(|threads| {
                let plan = Plan::new(&Request {
                    azimuth: azimuth.into(),
                    sampler,
                    threads: Some(threads),
                    ..asked("--incidence 0:40:20 --rays 70001 --bins 32")
                })
                .expect("a valid request");
                let table = rays(&cell, &plan).expect("bakes");
                let file = folder.path().join(format!("{threads}.h5"));
                tables::write(&table, &file).expect("writes");
                std::fs::read(&file).expect("reads")
            })
            .into();
        assert!(bytes[0] == bytes[1] && bytes[0] == bytes[2]);
        compared += 1;
    }
    assert_eq!(compared, 5);
}

/// A bake to a tolerance stops when its estimate reaches it, and the true error is about as large.
#[test]
fn tolerance_is_reached() {
    let request = asked("--incidence 0,20 --tolerance 0.01 --bins 32");
    let table = rays(&cells::triangular(), &Plan::new(&request).expect("valid")).expect("bakes");
    for (i, incidence) in [0.0_f64, 20.0].into_iter().enumerate() {
        let direction = crate::optics::Incidence::new(incidence.to_radians(), 0.0, 1.0);
        let (fraction, polygon) = cells::closed_form(direction.travel, 0.0);
        let polygon: Vec<_> = polygon.into_iter().map(|p| direction.to_frame(p)).collect();
        let whole = cells::area(&polygon);
        let exact = cells::bin_areas(&polygon, 32, 2.0)
            .into_iter()
            .map(|area| area * fraction / whole);
        let l1: f64 = table
            .probability(i, 0)
            .iter()
            .zip(exact)
            .map(|(p, exact)| (p - exact).abs())
            .sum();
        // The estimate sums some 300 bins, each with 15 degrees of freedom, and is good to a few
        // percent. Every round doubles the rays, so the error may lie well below the tolerance.
        assert!(
            l1 < 0.011 && l1 > 0.001,
            "L1 error at {incidence} deg is {l1}"
        );
    }
}
