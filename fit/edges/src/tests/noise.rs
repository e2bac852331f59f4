//! Tests of the noise of pixels that a camera without a black offset cuts off at 0.

use crate::numerics::Stream;
use crate::numerics::clip;
use crate::numerics::clip::Cut;
use crate::photographs::PixelNoise;

const AT_ZERO: Cut = Cut {
    zero: true,
    full: None,
};

/// Compares the noise of cut-off pixels with one that is known exactly. Without light, half of
/// the pixels are cut off, and the variance of the rest is v (1/2 - 1/(2 pi)). Bright pixels
/// keep theirs. Two bins determine both numbers, so only rounding is left: 25 rounds of a few
/// operations.
#[test]
fn the_variance_that_the_cut_off_removes_is_put_back() {
    let left = 0.5 - 0.5 / std::f64::consts::PI;
    for (read, gain) in [(4e-4, 0.0), (4e-4, 2e-3), (1e-6, 1e-4)] {
        let bright = 0.5;
        let scatter = [
            [900.0, 0.0, left * read],
            [400.0, bright, read + gain * bright],
        ];
        let found = PixelNoise::most_likely(&scatter, AT_ZERO, 1e-12);
        let allowed = 1e-13 * found.variance(bright);
        assert!((found.read - read).abs() < allowed, "{found:?}");
        assert!((found.gain - gain).abs() < allowed / bright, "{found:?}");
    }
}

/// Compares the estimate with the known variance of normal draws that are cut off at 0. The
/// variance s^2 of n draws has the error sqrt((m4 - s^4) / n), with their fourth central moment
/// m4. The estimate v solves c(v) = s^2, where c is the variance that the cut leaves, so its
/// error is that of s^2 over dc/dv. The limit is 4.5 errors. The terms that this leaves out are
/// of the order of the relative error, below 2 % of it.
#[test]
fn the_noise_of_cut_off_draws_is_found() {
    const DRAWS: usize = 60_000;
    let (sigma, mut stream) = (0.02_f64, Stream(91));
    let mut normal = || {
        let radius = (-2.0 * f64::ln(1.0 - stream.between(0.0, 1.0))).sqrt();
        radius * (std::f64::consts::TAU * stream.between(0.0, 1.0)).cos()
    };
    for z in [0.0, 0.5, 1.0, 2.0] {
        let light = z * sigma;
        let draws: Vec<f64> = (0..DRAWS)
            .map(|_| (light + sigma * normal()).max(0.0))
            .collect();
        let mean = draws.iter().sum::<f64>() / DRAWS as f64;
        let moment = |k: i32| draws.iter().map(|x| (x - mean).powi(k)).sum::<f64>();
        let variance = moment(2) / (DRAWS - 1) as f64;
        let of_variance = (moment(4) / DRAWS as f64 - variance.powi(2)) / DRAWS as f64;
        let left = |v: f64| clip::clipped(light, v.sqrt()).2;
        let (v, h) = (sigma * sigma, 1e-3 * sigma * sigma);
        let slope = (left(v + h) - left(v - h)) / (2.0 * h);
        let scatter = [[(DRAWS - 1) as f64, light, variance]];
        let found = PixelNoise::most_likely(&scatter, AT_ZERO, 1e-12);
        let error = of_variance.sqrt() / slope;
        let pull = (found.variance(light) - v) / error;
        println!(
            "z {z}: {:.4} of v, pull {pull:.2}",
            found.variance(light) / v
        );
        assert!(pull.abs() < 4.5, "z {z}: {found:?}, {v} +- {error}");
    }
}

/// Checks the estimate by the equations that it solves: the derivatives of the sum of freedom x
/// (ln v + scatter / v) by read and by gain are 0. The scatter of the four bins lies on no line, so
/// the weights matter: those of 1/v for 1/v^2 leave a tenth of the terms. Each of the 25 rounds
/// leaves less than a hundredth of the error here, so only the rounding of a few sums is left.
#[test]
fn the_noise_is_where_the_likelihood_is_flat() {
    let scatter = [
        [40.0, 0.02, 1.1e-4],
        [25.0, 0.2, 4.0e-4],
        [60.0, 0.5, 7.0e-4],
        [30.0, 0.9, 1.6e-3],
    ];
    let found = PixelNoise::most_likely(&scatter, Cut::default(), 1e-12);
    assert!(found.read > 0.0 && found.gain > 0.0, "{found:?}");
    for power in [0, 1] {
        let terms = scatter.map(|[freedom, light, variance]| {
            let v = found.variance(light);
            freedom * light.powi(power) * (variance - v) / (v * v)
        });
        let sum = terms.iter().sum::<f64>().abs();
        let size = terms.iter().map(|term| term.abs()).sum::<f64>();
        assert!(sum < 1e-12 * size, "{power}: {sum} of {size}");
    }
}
