//! Tests of the samples of shift and lobe: their OTF is the OTF of the model.

use crate::planted::{Stream, table, truth};
use edges::names::Kernel;
use edges::names::LobeShape;
use estimator::model::Lobe;
use estimator::samples::ShiftSampler;
use estimator::samples::{Points, Sequence};
use ndarray::Array2;
use num_complex::Complex64;
use tables::Direction;

/// Number of independent randomisations.
const STREAMS: u64 = 16;
/// Number of points of each randomisation.
const POINTS: u32 = 1 << 15;

/// The mean over all randomisations of exp(-i k.x), and the standard error of its parts by their
/// scatter.
fn transform(
    sequence: Sequence,
    k: [f64; 2],
    sample: &dyn Fn([f64; 4]) -> [f64; 2],
) -> (Complex64, f64) {
    let means: Vec<Complex64> = (0..STREAMS)
        .map(|stream| {
            let points = Points::new(sequence, 5, stream);
            let one = |i| {
                let x = sample(points.at(i));
                Complex64::cis(-(k[0] * x[0] + k[1] * x[1]))
            };
            (0..POINTS).map(one).sum::<Complex64>() / f64::from(POINTS)
        })
        .collect();
    let n = STREAMS as f64;
    let mean = means.iter().sum::<Complex64>() / n;
    let squares: f64 = means.iter().map(|m| (m - mean).norm_sqr()).sum();
    (mean, (squares / (n * (n - 1.0))).sqrt())
}

/// The sampled OTF agrees with the exact one within six standard errors of 16 randomisations
/// (Student's t with 15 degrees of freedom: 2 in 10^5) and `rest`, the error of the sampler's
/// tables.
fn agree(sampled: (Complex64, f64), exact: Complex64, rest: f64, what: &str) {
    let (mean, error) = sampled;
    let off = (mean - exact).norm();
    assert!(
        off < 6.0 * error + rest,
        "{what}: {mean} +- {error:.1e}, exactly {exact}"
    );
}

#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn the_lobes_samples_have_its_otf() {
    let (mut cases, mut gains) = (0, Vec::new());
    for shape in LobeShape::ALL.into_iter().chain(LobeShape::MICROFACETS) {
        for k in [0.05, 0.4, 1.1, 1.7, 2.3, 4.0, 9.0] {
            for angle in [0.0_f64, 0.1, 0.7] {
                let normal = [angle.cos(), angle.sin()];
                // A spatial frequency of 1 is k = 2 pi, at a = 1.
                let (exact, _) = shape.otf(1.0, k / std::f64::consts::TAU, normal);
                let along = normal.map(|n| n * k);
                let at = |p: [f64; 4]| shape.offset([p[2], p[3]]);
                let [even, free] =
                    [Sequence::Sobol, Sequence::Independent].map(|s| transform(s, along, &at));
                let what = format!("{shape:?} k {k} at {angle}");
                agree(even, exact.into(), 2e-5, &what);
                agree(free, exact.into(), 2e-5, &what);
                gains.push((free.1 / even.1).powi(2));
                cases += 1;
            }
        }
    }
    gains.sort_by(f64::total_cmp);
    println!(
        "{cases} frequencies; variance of independent points over that of Sobol points: least \
        {:.0}, median {:.0}",
        gains[0],
        gains[gains.len() / 2]
    );
    assert_eq!(
        cases,
        (LobeShape::ALL.len() + LobeShape::MICROFACETS.len()) * 7 * 3
    );
    // An Owen-scrambled net never has more than e = 2.72 times the variance (Owen 1997). Two
    // variances with 15 degrees of freedom each scatter by a factor of 6 in 1 of 10^3.
    assert!(gains[0] > 1.0 / (2.72 * 6.0));
    assert!(
        gains[gains.len() / 2] > 10.0,
        "evenly spread points should pay"
    );
}

#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn the_shifts_samples_have_its_otf() {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.0, 0.3, 0.5);
    let incidence = [0.0, 20.0, 45.0];
    let table = table(&planted, &incidence, 20.0);
    let mut directions: Vec<Direction> = incidence
        .iter()
        .map(|&i| table.direction(i, Some(20.0)).expect("it is in the table"))
        .collect();
    // The histogram has empty rows and columns.
    let mut stream = Stream(9);
    let probability = Array2::from_shape_fn((16, 16), |(v, u)| {
        let inside = (3..12).contains(&v) && (2..9).contains(&u) && v != 6;
        if inside {
            stream.between(0.0, 1e-2)
        } else {
            0.0
        }
    });
    directions.push(Direction {
        retroreflected: probability.sum(),
        probability,
        paths: None,
        exits: None,
        ..directions[0].clone()
    });
    let mut cases = 0;
    for direction in &directions {
        let sampler = ShiftSampler::new(direction).expect("something returns");
        for w in [[1.0, 0.0], [0.3, 0.9], [-0.7, 0.2]] {
            for kappa in [0.02, 0.2, 0.7, 1.5, 4.0] {
                let exact = direction.otf_along(w, &[kappa])[0];
                let k = w.map(|w| w * kappa * std::f64::consts::TAU);
                let at = |p: [f64; 4]| sampler.at([p[0], p[1]]).shift;
                for sequence in [Sequence::Sobol, Sequence::Independent] {
                    let what = format!("{} deg {w:?} {kappa}", direction.incidence_deg);
                    agree(transform(sequence, k, &at), exact, 1e-9, &what);
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 4 * 3 * 5 * 2);
    let dark = Direction {
        retroreflected: 0.0,
        probability: Array2::zeros((4, 4)),
        ..directions[3].clone()
    };
    assert!(ShiftSampler::new(&dark).is_none());
}
