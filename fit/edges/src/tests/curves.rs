//! Tests of edges that follow a curve. The light of each pixel follows from its nearest distance to
//! the curve, found point by point, which shares nothing with the polynomials of the estimator.

use std::f64::consts::TAU;

use crate::photographs::measure::edge;
use crate::photographs::{Estimator, standard_error};
use crate::tests::photographs::{BRIGHT, DARK, NOISE, noisy, photo, rise};

/// Returns the signed distance of (x, y) from the curve, whose height over an upright line, tilted
/// by `deg`, is `height` of the place along it.
fn nearest(x: f64, y: f64, deg: f64, height: &impl Fn(f64) -> f64) -> f64 {
    let (sin, cos) = deg.to_radians().sin_cos();
    let (across, along) = (x * cos + y * sin, y * cos - x * sin);
    let far = |t: f64| (across - height(t)).hypot(along - t);
    // The least of a smooth function by thirds. The foot is near the place itself.
    let (mut low, mut high) = (along - 6.0, along + 6.0);
    for _ in 0..40 {
        let (a, b) = ((2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0);
        if far(a) < far(b) {
            high = b;
        } else {
            low = a;
        }
    }
    let t = 0.5 * (low + high);
    far(t).copysign(across - height(along))
}

/// The MTF of a curved edge is that of the blur: a normal one, exp(-2 (pi sigma f)^2).
///
/// Errors stay below 4 standard errors by noise, plus what the order leaves. A bow of 3 px is a
/// polynomial of order 2 and leaves nothing. One period of a sine of 2 px leaves 0.3 % of it after
/// order 9, and the estimate need not use all orders: waves below half the noise of a place are
/// left. Both lower the MTF by less than 1e-3. Distances along the normal differ from the nearest
/// ones by 1e-3 px in the reach of the blur.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn curved_edges_have_the_mtf_of_the_blur() {
    let (mut cases, mut most) = (0, 0.0_f64);
    for sigma in [0.8, 3.0, 11.0] {
        for (name, bow) in [("bow", 3.0), ("bow", -1.0), ("sine", 2.0), ("cubic", 1.5)] {
            for deg in [5.0, -12.0, 95.0] {
                let height = |t: f64| match name {
                    "bow" => bow * (t / 100.0).powi(2),
                    "sine" => bow * (TAU * t / 230.0 + 0.4).sin(),
                    _ => bow * (t / 100.0).powi(3) - 0.5 * bow * (t / 100.0),
                };
                let (half_x, half_y) = (120.3, 99.1);
                let light = photo(240, 200, |x, y| {
                    let s = nearest(x - half_x, y - half_y, deg, &height);
                    DARK + (BRIGHT - DARK) * rise(s, sigma)
                });
                let photo = noisy(light, 3 + cases);
                let what = format!("sigma {sigma}, {name} of {bow} px, {deg} deg");
                let found = edge(&photo, None, &[]).unwrap_or_else(|e| panic!("{what}: {e}"));
                let count = if sigma > 5.0 { 6 } else { 50 };
                let estimator = Estimator::new(&found.profile, 1.0, 400, count);
                let mtf = estimator.measure(&found.profile);
                let response = estimator.response(&found.profile);
                let noise = standard_error(&response, &found.profile);
                let known = |k: usize| (-2.0 * (0.005 * TAU * sigma * k as f64).powi(2)).exp();
                for (k, (modulus, noise)) in mtf.modulus.iter().zip(&noise).enumerate().skip(1) {
                    let error = (modulus - known(k)).abs();
                    most = most.max(error);
                    assert!(
                        error < 4.5 * noise + 2e-3,
                        "{what}: {error:.5} at {k}, noise {noise:.5}, {:?}",
                        found.line
                    );
                }
                cases += 1;
            }
        }
    }
    println!("{cases} edges, largest difference {most:.5}");
    assert_eq!(cases, 36);
}

/// The direction of a curved edge is known as that of a straight one in the same noise: the orders of
/// the curve do not look like a turn. The noise of a bin, from some 100 pixels, is known to a tenth,
/// and the bins' mean to far less; the sum over the steep pixels changes by the slope of the curve
/// squared, 0.4 %. About a straight line, a bow of 3 pixels would scatter pixels by its height.
#[test]
fn a_curve_does_not_add_to_the_error_of_the_direction() {
    let error = |bow: f64| {
        let height = |t: f64| bow * (t / 100.0).powi(2);
        let light = photo(240, 200, |x, y| {
            let s = nearest(x - 120.3, y - 99.1, 5.0, &height);
            DARK + (BRIGHT - DARK) * rise(s, 1.0)
        });
        let line = edge(&noisy(light, 3), None, &[]).expect("an edge").line;
        assert_eq!(line.bend.is_some(), bow != 0.0);
        line.normal_standard_error_rad
    };
    let straight = error(0.0);
    for bow in [1.0, 3.0] {
        let ratio = error(bow) / straight;
        println!("bow of {bow} px: {ratio:.3} times the error of the direction");
        assert!((ratio - 1.0).abs() < 0.05, "{bow}: {ratio}");
    }
}

/// A straight edge stays straight. Bayes' criterion with its margin adds an order by chance where
/// a normal number exceeds sqrt(ln n + 4) = 3.5 for n = 4,000 pixels: 5e-4 for each of 8 orders,
/// so 0.4 % of the edges. Of 150, two or more are bent with a probability of 12 %, five or more
/// with 0.04 %. A bend by chance is as small as its noise: 4 px of noise over the step, over the
/// root of the pixels, which is below 0.02 px.
#[test]
fn straight_edges_stay_straight() {
    let mut bent = 0;
    for seed in 0..150 {
        let deg = 3.0 + 0.2 * f64::from(seed);
        let (sin, cos) = deg.to_radians().sin_cos();
        let clean = photo(120, 100, |x, y| {
            let s = (x - 60.2) * cos + (y - 49.4) * sin;
            DARK + (BRIGHT - DARK) * rise(s, 2.0)
        });
        let mut noise = noisy(clean.clone(), 100 + seed as u64);
        // Ten times the noise of the other photographs.
        for (value, clean) in noise.luminance.iter_mut().zip(&clean.luminance) {
            *value = clean + 10.0 * (*value - clean);
        }
        let found = edge(&noise, None, &[]).expect("an edge");
        assert!(found.line.bow_px() < 20.0 * 4.0 * NOISE, "{:?}", found.line);
        bent += usize::from(found.line.bend.is_some());
    }
    println!("{bent} of 150 edges are bent by chance");
    assert!(bent < 5, "{bent}");
}
