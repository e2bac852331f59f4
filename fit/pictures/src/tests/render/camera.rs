//! Tests of images that a camera photographs.

use super::{PIXELS, Squares, place};
use crate::images::SILENT;
use crate::images::render::camera::Camera;
use crate::images::render::psf::Psf;
use estimator::result::CameraResult;
use serde_json::{Value, json};

fn camera(pixel_pitch_mm: f64, lens_blur_mm: Option<f64>, lens: Value) -> Option<Camera> {
    Camera::of(
        &serde_json::from_value::<CameraResult>(json!({
            "pixel_pitch_mm": pixel_pitch_mm, "lens_blur_mm": lens_blur_mm, "lens_exponent": 2.0,
            "lens": lens
        }))
        .unwrap(),
    )
}

/// Numbers that no camera has are refused by the name of their key.
#[test]
fn numbers_that_no_camera_has_are_refused() {
    let good = json!({
        "pixel_pitch_mm": 0.1, "lens_blur_mm": 0.1, "lens_exponent": 2.0,
        "lens": [{
            "edge_angle_deg": 0.0, "terms": 3, "frequency_per_px": [0.0, 0.5, 1.0, 1.5],
            "otf": [1.0, 1.3, 0.2, -0.1],
        }],
    });
    let read = |value: &Value| serde_json::from_value::<CameraResult>(value.clone()).unwrap();
    assert!(Camera::of(&read(&good)).is_some());
    let mut cases = 0;
    for (at, values) in [
        ("/pixel_pitch_mm", vec![0.0, -0.1, 1e300]),
        ("/lens_blur_mm", vec![-0.1, 1e300]),
        ("/lens_exponent", vec![0.0, -2.0, 1e300]),
        ("/lens/0/edge_angle_deg", vec![1e300, -361.0]),
        ("/lens/0/frequency_per_px/0", vec![-0.1]),
        ("/lens/0/otf/1", vec![1e300, -5.0]),
    ] {
        for value in values {
            let mut wrong = good.clone();
            *wrong.pointer_mut(at).unwrap() = json!(value);
            let wrong = read(&wrong);
            let said = wrong.check().unwrap_err().to_string();
            let key = at
                .split('/')
                .rfind(|own| own.parse::<u8>().is_err())
                .unwrap();
            assert!(said.contains(&format!("{key} is ")), "{at} {value}: {said}");
            assert_eq!(Camera::of(&wrong), None, "{at} {value}");
            cases += 1;
        }
    }
    assert_eq!(cases, 13);
    let mut wrong = read(&good);
    wrong.lens[0].otf[2] = f64::NAN;
    assert!(wrong.check().is_err());
}

/// Blur length of a Gaussian: exp(-(f blur)^2) = exp(-2 (pi f sigma)^2).
fn blur(sigma: f64) -> f64 {
    sigma * std::f64::consts::PI * std::f64::consts::SQRT_2
}

/// Mean over a square spot, the pixel of the source and that of the camera, of a Gaussian along one
/// axis. The mean over the spot is a difference of error functions, and those over the pixels are
/// sums at 100 x 100 midpoints.
fn mean(d: f64, spot: f64, pixel: f64, sigma: f64) -> f64 {
    let below = |x: f64| 0.5 * libm::erfc(-x / (sigma * std::f64::consts::SQRT_2));
    let middles = || (0..100).map(|k| (f64::from(k) + 0.5) / 100.0 - 0.5);
    let of_pixels = middles().flat_map(|u| middles().map(move |v| d + u + v * pixel));
    let means = of_pixels.map(|x| (below(x + 0.5 * spot) - below(x - 0.5 * spot)) / spot);
    means.sum::<f64>() / 1e4
}

/// Compares all weights with products of [`mean`] along both axes, and returns their number.
fn compare(psf: &Psf, spot: f64, pixel: f64, sigma: [f64; 2], allowed: f64) -> usize {
    let lines = [0, 1].map(|axis| {
        let reach = psf.reach[axis] as i32;
        let all = (-reach..=reach).map(|d| mean(f64::from(d), spot, pixel, sigma[axis]));
        all.collect::<Vec<_>>()
    });
    for (i, &weight) in psf.weights.iter().enumerate() {
        let expected = lines[0][i % lines[0].len()] * lines[1][i / lines[0].len()];
        let error = (f64::from(weight) - expected).abs();
        assert!(
            error < allowed,
            "{spot} {pixel} {sigma:?}, weight {i}: {error}"
        );
    }
    psf.weights.len()
}

/// A square spot behind a Gaussian lens, and a pixel that is narrower or wider than that of the
/// image. The second derivative of the mean over the spot is at most 0.25 / (sigma^2 spot), so the
/// midpoints err by (0.01^2 + (0.01 pixel)^2) / 24 times that: 3e-5 at most.
#[test]
fn pixel_and_lens_of_a_camera_meet_their_integrals() {
    let mut cases = 0;
    for (spot, pixel, sigma) in [(2.5, 1.0, 0.4), (2.5, 3.0, 0.4), (1.0, 0.5, 0.9)] {
        let own = camera(pixel, Some(blur(sigma)), json!([]));
        // A pixel of the image is 1 mm wide.
        let psf = Psf::seen(&Squares, &place(spot, 0.0), PIXELS, own.as_ref(), SILENT).unwrap();
        assert!(psf.error < 1e-3, "{}", psf.error);
        cases += compare(&psf, spot, pixel, [sigma; 2], psf.error + 3e-5);
    }
    println!("{cases} weights");
    assert!(cases > 300, "{cases}");
}

/// A lens with another Gaussian along each axis, as tables of the OTF: it is an elliptic Gaussian,
/// because the logarithm of the OTF is a quadratic form of the direction. Between the 49 points the
/// polynomial of four errs by at most 9/384 h^4 times the fourth derivative, 3 (2 pi sigma)^4 at
/// frequency 0, where h is below 0.004, and 1e-4 of that at the frequency 0.5, where h is 0.04: by
/// 1e-5, in every weight too.
#[test]
fn tables_of_the_lens_along_two_axes_meet_an_elliptic_gaussian() {
    let sigma = [0.5, 0.9];
    let pixel = 1.5;
    let frequency: Vec<f64> = (0..49)
        .map(|k| 1.5 * (f64::from(k) / 48.0).powi(2))
        .collect();
    let lens: Vec<Value> = [0, 1]
        .map(|axis| {
            let own = blur(sigma[axis]) / pixel;
            let otf: Vec<f64> = frequency
                .iter()
                .map(|f| (-(f * own).powi(2)).exp())
                .collect();
            json!({
                "edge_angle_deg": 90.0 * axis as f64, "terms": 3, "frequency_per_px": frequency,
                "otf": otf
            })
        })
        .to_vec();
    let of = |lens: Value| camera(pixel, Some(blur(sigma[0])), lens);
    let own = of(json!(lens));
    let psf = Psf::seen(&Squares, &place(2.5, 0.0), PIXELS, own.as_ref(), SILENT).unwrap();
    let cases = compare(&psf, 2.5, pixel, sigma, psf.error + 3e-5 + 1e-5);
    println!("{cases} weights");
    assert!(psf.error < 1e-3 && cases > 300, "{} {cases}", psf.error);
    // Tables that cannot be read, and a result without a lens.
    let mut damaged = lens.clone();
    damaged[1]["otf"] = json!([1.0, 0.5]);
    assert_eq!(of(json!(damaged)), None);
    assert_eq!(camera(pixel, None, json!([])), None);
    // A round lens without terms is the parametric one, whatever its table.
    let round = json!([{
        "edge_angle_deg": null, "terms": 0, "frequency_per_px": [0.0, 1.0], "otf": [1.0, 0.5]
    }]);
    assert_eq!(of(round), of(json!([])));
}
