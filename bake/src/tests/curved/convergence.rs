//! The speed with which facets approach the curved face that they stand for.

use crate::geometry::{Launch, Stream};
use crate::optics::Incidence;
use crate::rays::{Index, Outcome, Scene, trace};
use crate::tests::curved::oracle::Oracle;
use crate::tests::curved::{RULES, cell, design};
use meshes::design::Shape;
use tables::Fate;
use tables::options::Sampler;

const INCIDENCE_RAD: f64 = 0.35;
const AZIMUTH_RAD: f64 = 0.5;

/// Differences from the oracle over rays of equal fate: medians of direction (rad) and shift (edge
/// lengths), and the difference of eta. Medians are taken because near the edges of facets some
/// rays meet another face first.
struct Errors {
    direction: f64,
    shift: f64,
    eta: f64,
    /// Share of the rays with another fate or number of reflections.
    other: f64,
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn eta(outcomes: &[Outcome]) -> f64 {
    let returned = outcomes.iter().filter(|o| o.fate == Fate::Retroreflected);
    returned.count() as f64 / outcomes.len() as f64
}

fn errors(found: &[Outcome], exact: &[Outcome]) -> Errors {
    let pairs = || found.iter().zip(exact);
    let same = |(a, b): &(&Outcome, &Outcome)| a.fate == b.fate && a.bounces == b.bounces;
    let both: Vec<_> = pairs().filter(same).collect();
    let direction = both.iter().map(|(a, b)| a.travel.distance(b.travel));
    let returned = both.iter().filter(|(a, _)| a.fate == Fate::Retroreflected);
    Errors {
        direction: median(direction.collect()),
        shift: median(returned.map(|(a, b)| a.shift.distance(b.shift)).collect()),
        eta: (eta(found) - eta(exact)).abs(),
        other: 1.0 - both.len() as f64 / found.len() as f64,
    }
}

/// Returns the errors with `segments` along an edge: of planar facets, and of interpolated normals.
fn of_segments(shape: Shape, sag: f64, rays: u64, segments: &[u32]) -> Vec<[Errors; 2]> {
    let flat = cell(&design(shape, 0.0, 1), false);
    let oracle = Oracle::new(&flat, sag);
    let launch = Launch::new(&flat.entrance);
    let stream = Stream::new(Sampler::Random, 7, 20.0, 30.0, 0);
    let light = Incidence::new(INCIDENCE_RAD, AZIMUTH_RAD, 1.0);
    let points: Vec<_> = (0..rays)
        .map(|index| launch.entry(&stream, index).1)
        .collect();
    let exact: Vec<Outcome> = points
        .iter()
        .map(|&point| oracle.trace(&RULES, &light, point))
        .collect();
    let of = |segments: &u32| {
        [false, true].map(|normals| {
            let scene = Scene::new(&cell(&design(shape, sag, *segments), normals), Index::Auto);
            let outcome = |&point| trace(&scene, &RULES, &light, point, 0.5);
            errors(&points.iter().map(outcome).collect::<Vec<_>>(), &exact)
        })
    };
    segments.iter().map(of).collect()
}

/// Halving the facets halves the error of planes and, in the limit, quarters the error of
/// interpolated normals. The error of the next order falls too. So factors between 16, 32 and 64
/// segments must be within a quarter of the limit.
#[test]
fn interpolated_normals_converge_with_the_square_of_the_facets() {
    let mut cases = 0;
    for (shape, sag) in [
        (Shape::Triangular, 0.002),
        (Shape::Triangular, -0.01),
        (Shape::TriangularPair, 0.01),
    ] {
        let found = of_segments(shape, sag, 20_000, &[16, 32, 64]);
        for pair in found.windows(2) {
            for (kind, factor) in [(0, 2.0), (1, 4.0)] {
                let (coarse, fine) = (&pair[0][kind], &pair[1][kind]);
                let falls = [coarse.direction / fine.direction, coarse.shift / fine.shift];
                println!(
                    "{shape:?} {sag}, {}: direction {:.2e} rad, shift {:.2e}, falls by \
                    {falls:.2?}; {:.1e} of the rays go elsewhere",
                    ["planes", "normals"][kind],
                    fine.direction,
                    fine.shift,
                    fine.other
                );
                for fall in falls {
                    assert!(
                        (fall / factor - 1.0).abs() < 0.25,
                        "{shape:?} {sag}: {fall}"
                    );
                }
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 12);
}

/// Prints the table of doc/curved.md.
#[test]
#[ignore = "a minute: the figures of doc/curved.md"]
fn table_of_convergence() {
    let segments = [1, 3, 6, 12, 25, 50, 100, 200, 400];
    for sag in [1e-4, 0.01] {
        println!("\nsag {sag}\n");
        println!(
            "| segments | facets | direction, planes (rad) | normals | shift, planes | normals | \
            eta, planes | normals |"
        );
        println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
        let found = of_segments(Shape::TriangularPair, sag, 200_000, &segments);
        for (n, [planes, normals]) in segments.iter().zip(found) {
            println!(
                "| {n} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} |",
                6 * n * n,
                planes.direction,
                normals.direction,
                planes.shift,
                normals.shift,
                planes.eta,
                normals.eta
            );
        }
    }
}
