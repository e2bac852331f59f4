//! Uneven light of a lamp, which is blurred with the edge, and of a camera, which is not. Both are
//! planted by sums over pixels in two dimensions, which share nothing with the estimator.

use crate::planted::Stream;
use crate::planted::{photo, with_noise};
use crate::tests::studies::statistics::check;
use edges::photographs::PixelNoise;
use edges::photographs::edge::line::{Bend, EdgeLine, ORDERS};
use edges::photographs::measure;
use edges::photographs::photo::plane::Photo;
use estimator::compare::{Nuisances, Photograph, Pixels, are_uneven};
use estimator::model::{Camera, Lens};
use rayon::prelude::*;
use std::f64::consts::{PI, SQRT_2};

const SIZE: [usize; 2] = [192, 128];

/// Standard deviation of the blur, pixels.
const SIGMA_PX: f64 = 3.0;

/// Standard deviation of the part of the blur that the lamp is not given, pixels. With it an edge
/// can be sampled at points.
const FIRST_PX: f64 = 1.0;

/// Convolves a picture with a normal blur along both axes. Beyond the border the picture goes on as
/// at the border.
fn blurred(values: &[f64], [width, height]: [usize; 2], sigma: f64) -> Vec<f64> {
    let reach = (6.0 * sigma) as i64;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp() / (sigma * (2.0 * PI).sqrt()))
        .collect();
    let along = |values: &[f64], by_x: i64, by_y: i64| -> Vec<f64> {
        (0..width * height)
            .map(|at| {
                let (x, y) = ((at % width) as i64, (at / width) as i64);
                let offsets = (-reach..=reach).zip(&kernel);
                let value = |k: i64| {
                    let x = (x - k * by_x).clamp(0, width as i64 - 1) as usize;
                    let y = (y - k * by_y).clamp(0, height as i64 - 1) as usize;
                    values[y * width + x]
                };
                offsets.map(|(k, weight)| weight * value(k)).sum()
            })
            .collect()
    };
    along(&along(values, 1, 0), 0, 1)
}

/// Noise of a pixel, a sensor's of 40,000 electrons at this light.
const NOISE: f64 = 0.004;

/// Returns a photograph of an edge under a hot spot that is up to 30 % brighter than its border.
fn lit(seed: u64, of_lamp: bool) -> Photo {
    let mut stream = Stream(0x1a3b << 20 | seed);
    let deg = stream.between(3.0, 12.0);
    let spot = [stream.between(20.0, 170.0), stream.between(10.0, 118.0)];
    let (height, width) = (stream.between(0.05, 0.35), stream.between(80.0, 160.0));
    let margin = 24;
    let size = SIZE.map(|n| n + 2 * margin);
    let (sin, cos) = deg.to_radians().sin_cos();
    let at = |pixel: usize| {
        let (x, y) = (pixel % size[0], pixel / size[0]);
        (x as f64 - margin as f64, y as f64 - margin as f64)
    };
    let lamp = |(x, y): (f64, f64)| {
        let r2 = (x - spot[0]).powi(2) + (y - spot[1]).powi(2);
        1.0 + height * (-0.5 * r2 / (width * width)).exp()
    };
    let pixels = size[0] * size[1];
    let edge = |pixel: usize| {
        let (x, y) = at(pixel);
        let d = (x - 95.3) * cos + (y - 63.1) * sin;
        0.5 * libm::erfc(-d / (FIRST_PX * SQRT_2))
    };
    let before = |pixel: usize| edge(pixel) * if of_lamp { lamp(at(pixel)) } else { 1.0 };
    let values: Vec<f64> = (0..pixels).map(before).collect();
    let rest = (SIGMA_PX.powi(2) - FIRST_PX.powi(2)).sqrt();
    let values = blurred(&values, size, rest);
    let clean = photo(SIZE[0], SIZE[1], |x, y| {
        let pixel = (y as usize + margin) * size[0] + x as usize + margin;
        let after = if of_lamp { 1.0 } else { lamp((x, y)) };
        0.01 + 0.6 * after * values[pixel]
    });
    with_noise(clean, seed, NOISE)
}

/// Fits the blur of a photograph, and returns its pull in ln sigma.
fn pull(photo: &Photo) -> f64 {
    let measured = measure::edge(photo, None, &[]).expect("there is an edge");
    let pixels = Pixels::new(&measured.as_lit, &measured.line);
    let pitch_mm = 1.0;
    let camera = |ln_blur: f64| Camera {
        pitch_mm,
        lenses: vec![Lens::new(ln_blur.exp(), 2.0)],
    };
    // The box of a pixel adds a twelfth of a squared pixel. It is nearly normal beside the blur.
    let sigma = (SIGMA_PX * SIGMA_PX - 1.0 / 12.0).sqrt();
    let truth = (SQRT_2 * PI * sigma * pitch_mm).ln();
    let mut photograph = Photograph::new(&pixels, pitch_mm);
    let curves = photograph.curves(None, &camera(truth + 0.02), &[0]);
    if are_uneven(&[photograph.settle(&curves)]) {
        photograph.settle_unevenly(&curves);
    }
    let (mut at, mut error) = (truth + 0.02, f64::INFINITY);
    for _ in 0..6 {
        let fitted = photograph.fit(&photograph.curves(None, &camera(at), &[0]));
        let own = fitted.columns;
        error = 1.0 / fitted.factor[(own, own)];
        at -= fitted.factor[(own, own + 1)] * error;
    }
    (at - truth) / error
}

/// Standard deviation of a wide blur, pixels.
const WIDE_PX: f64 = 9.0;

/// Direction of the edge's normal, radians.
const NORMAL_RAD: f64 = 0.14;

/// Returns a photograph of a straight edge behind a blur, whose light falls to 3/4 at its borders.
fn vignetted(blur_px: f64) -> Photo {
    let (sin, cos) = NORMAL_RAD.sin_cos();
    photo(SIZE[0], SIZE[1], |x, y| {
        let (x, y) = (x - 95.5, y - 63.5);
        let light = 1.0 / (1.0 + 0.15 * (x * x + y * y) / (96.0 * 96.0)).powi(2);
        let edge = 0.5 * libm::erfc(-(x * cos + y * sin) / (blur_px * SQRT_2));
        0.01 + light * (0.005 + 0.6 * edge)
    })
}

/// Returns the fitted ln of the step of such a photograph and its standard error. The line of the
/// edge is taken for a curve up to `order`, whose highest term is wrong by `by_px`.
fn step(photo: &Photo, blur_px: f64, order: usize, by_px: f64) -> [f64; 2] {
    let mut terms_px = [0.0; ORDERS - 1];
    terms_px[order - 2] = by_px;
    let line = EdgeLine {
        normal_rad: NORMAL_RAD,
        offset_px: 0.0,
        normal_standard_error_rad: 0.0,
        bend: Some(Bend {
            middle_px: 0.0,
            half_px: 80.0,
            terms_px,
            order,
        }),
    };
    let measured = measure::edge(photo, None, &[]).expect("there is an edge");
    let pixels = Pixels::new(&measured.as_lit, &line);
    let camera = Camera {
        pitch_mm: 1.0,
        lenses: vec![Lens::new(SQRT_2 * PI * blur_px, 2.0)],
    };
    let mut photograph = Photograph::new(&pixels, 1.0);
    let curves = photograph.curves(None, &camera, &[]);
    assert!(are_uneven(&[photograph.settle(&curves)]));
    photograph.settle_unevenly(&curves);
    let fitted = photograph.fit(&curves);
    let own = fitted.columns - 1;
    [
        fitted.nuisances.step.ln(),
        1.0 / fitted.factor[(own, own)].abs(),
    ]
}

/// Light that falls along an edge looks like a bow of the edge, and a wrong bow like light. So the
/// curve is estimated with the light: a curve that is wrong by a third of a pixel leaves the step
/// where it was. With the curve held, a bow of 0.3 px moves the step by 9.3 of its errors here. The
/// rest is of second order: h^2 E'' / 2 beside h E' is h / (2 blur) = 1/60, or 0.16 errors at the
/// ends of the curve and a fifth of that on the mean. The limit lies between.
#[test]
fn a_wrong_curve_does_not_move_the_step_in_uneven_light() {
    let picture = with_noise(vignetted(WIDE_PX), 5, 0.002);
    for order in [2, 3, 4] {
        let [right, error] = step(&picture, WIDE_PX, order, 0.0);
        let off = (step(&picture, WIDE_PX, order, 0.3)[0] - right) / error;
        println!("order {order}: {off:.3} of {error:.1e}");
        assert!(off.abs() < 0.1, "{order}: {off}");
    }
}

/// What the pixels do not tell keeps the mean and the deviation that it has before. A number that
/// lies anywhere between 0 and m has m/2 and m/sqrt(12): the share of the lamp (m = 1), and the lit
/// part of the dark plateau (m = the plateau). In even light the pixels tell nothing of both: the
/// picture leaves 1e-4 of uneven light, by which they tell less than 1e-3 of what the range does,
/// and the dark plateau is found to 1e-3. In endless noise they tell nothing of the curve either,
/// whose orders have 0.5 px.
#[test]
fn what_the_pixels_do_not_tell_keeps_its_range() {
    const DARK: f64 = 0.05;
    const BLUR_PX: f64 = 3.0;
    const ORDER: usize = 4;
    let (sin, cos) = NORMAL_RAD.sin_cos();
    let picture = photo(SIZE[0], SIZE[1], |x, y| {
        let (x, y) = (x - 95.5, y - 63.5);
        let blur = (BLUR_PX * BLUR_PX + 1.0 / 12.0).sqrt();
        DARK + 0.3 * libm::erfc(-(x * cos + y * sin) / (blur * SQRT_2))
    });
    let measured = measure::edge(&picture, None, &[]).expect("there is an edge");
    let line = EdgeLine {
        bend: Some(Bend {
            middle_px: 0.0,
            half_px: 80.0,
            terms_px: [0.0; ORDERS - 1],
            order: ORDER,
        }),
        ..measured.line
    };
    let pixels = Pixels::new(&measured.as_lit, &line);
    let camera = Camera {
        pitch_mm: 1.0,
        lenses: vec![Lens::new(SQRT_2 * PI * BLUR_PX, 2.0)],
    };
    let mut photograph = Photograph::new(&pixels, 1.0);
    let curves = photograph.curves(None, &camera, &[]);
    photograph.settle(&curves);
    photograph.settle_unevenly(&curves);
    let mut cases = 0;
    for (read, bends) in [(1e-4, 0), (1e8, ORDER - 1)] {
        photograph.with_noise(&curves, PixelNoise { read, gain: 0.0 });
        let fitted = photograph.fit(&curves);
        let own = fitted.columns;
        let factor = fitted.factor.view((0, 0), (own, own)).into_owned();
        let inverse = factor
            .try_inverse()
            .expect("all have a range or a photograph");
        let error = |column: usize| inverse.row(column).norm();
        println!("{:?}", fitted.nuisances);
        let Nuisances { lamp, lit, .. } = fitted.nuisances;
        for (value, column, most) in [(lamp, own - 2, 1.0), (lit, own - 3, DARK)] {
            let (mean, error) = (value / (0.5 * most), error(column) * 12.0_f64.sqrt() / most);
            println!("{read:e}: {mean:.5} {error:.5}");
            assert!(
                (mean - 1.0).abs() < 2e-3 && (error - 1.0).abs() < 2e-3,
                "{mean} {error}"
            );
            cases += 1;
        }
        for k in 0..bends {
            let error = error(own - 4 - k);
            assert!((error / 0.5 - 1.0).abs() < 2e-3, "{k}: {error}");
            cases += 1;
        }
    }
    assert_eq!(cases, 4 + ORDER - 1);
}

/// In little light the four strips do not hold the high orders of a curve. The orders stay where
/// they were found, and the step is that of a low order. Both fits see the same pixels, so their
/// difference is below the error of one.
#[test]
fn high_orders_of_a_curve_do_not_run_away_in_little_light() {
    const BLUR_PX: f64 = 1.5;
    for seed in 0..8 {
        let picture = with_noise(vignetted(BLUR_PX), seed, 0.06);
        let [low, error] = step(&picture, BLUR_PX, 2, 0.0);
        let off = (step(&picture, BLUR_PX, ORDERS, 0.0)[0] - low) / error;
        println!("seed {seed}: {off:.3} of {error:.1e}");
        assert!(off.abs() < 1.0, "{seed}: {off}");
    }
}

/// The errors of a blur stay true in uneven light, whether a lamp or the camera makes it. The hot
/// spot is not smooth enough for a polynomial: this may add a tenth of an error to the mean.
#[test]
#[ignore = "minutes: `make test-full` runs it"]
fn statistics_of_lamps_and_cameras() {
    const DRAWS: u64 = 120;
    for (name, of_lamp) in [("lamp", true), ("camera", false)] {
        let pulls: Vec<f64> = (0..DRAWS)
            .into_par_iter()
            .map(|seed| pull(&lit(seed, of_lamp)))
            .collect();
        check(name, &pulls, 0.1);
    }
}
