//! Sheets whose numbers are given by hand, and pictures beside their sources.

use crate::planted::{table, truth};
use edges::names::{Kernel, LobeShape, Spectrum};
use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;
use estimator::predict::{Places, Viewpoint, predict, remarks};
use estimator::result::{ByHand, ResultFile, Spread, TableResult};
use serde_json::json;

/// Numbers by hand predict what a result with these numbers predicts, for every kernel that they
/// may have. A lobe that is the same at all distances causes a remark.
#[test]
fn numbers_by_hand_are_those_of_a_result() {
    let table = table(
        &truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.24, 0.25),
        &[0.0, 20.0],
        0.0,
    );
    let spectrum = Spectrum::parse("450:0.5,550").unwrap();
    let number = |value: f64| json!({"value": value, "standard_error": null});
    let mut compared = 0;
    for (kernel, key, spread, value) in [
        (Kernel::Eq1, "a_per_mm", Spread::Lobe(4.5), 4.5),
        (Kernel::Angular, "a_times_r", Spread::Angle(700.0), 700.0),
        (Kernel::Wave, "", Spread::Wave(spectrum.clone()), 0.0),
    ] {
        let by_hand = ByHand {
            c_mm: 0.2,
            spread,
            angular_spread_mrad: None,
            mu: Some(0.4),
            half_mirror: 0.2,
            pixel_pitch_mm: 0.1,
        };
        let by_hand = by_hand.result(TableResult::of(&table));
        let mut fitted = json!({
            "kernel": kernel, "lobe": kernel.has_lobe().then_some(LobeShape::Radial),
            "loss": "edge", "iterations": 3, "stop": "small step", "seconds": 1.0,
            "wavelength_nm": (kernel == Kernel::Wave).then_some(&spectrum),
            "c_mm": number(0.2), "a_per_mm": null, "a_times_r": null, "mu": number(0.4),
            "covariance": {"names": [], "matrix": []}, "bounds": {}, "candidates": [],
            "captures": [], "half_mirror": 0.2, "seen_in_mirror": false, "warnings": [],
            "camera": {"pixel_pitch_mm": 0.1, "lens_blur_mm": null, "lens_exponent": null},
            "table": TableResult::of(&table),
        });
        if kernel.has_lobe() {
            fitted[key] = number(value);
        }
        let fitted: ResultFile = serde_json::from_value(fitted).unwrap();
        assert!(by_hand.is_by_hand() && !fitted.is_by_hand());
        let places = Places {
            floating_distance_mm: vec![150.0, 2000.0],
            incidence_deg: vec![0.0, 20.0],
            azimuth_deg: Some(0.0),
            frequency_per_mm: vec![0.0, 0.05, 0.5, 2.0],
        };
        let one = predict(&by_hand, &table, &places).unwrap();
        let other = predict(&fitted, &table, &places).unwrap();
        assert_eq!(one.len(), other.len());
        for (one, other) in one.iter().zip(&other) {
            assert_eq!((&one.mtf, one.luminance), (&other.mtf, other.luminance));
            assert!(one.mtf[1] < 1.0 && one.luminance.is_some_and(|light| light < 0.08));
            compared += 1;
        }
        let place = Viewpoint {
            incidence_deg: 20.0,
            azimuth_deg: Some(0.0),
            r_mm: 2000.0,
        };
        let remarks = remarks(&by_hand, &table, &[place]).unwrap();
        assert_eq!(
            remarks.len(),
            usize::from(kernel == Kernel::Eq1),
            "{remarks:?}"
        );
        assert!(
            remarks
                .iter()
                .all(|remark| remark.contains("every distance"))
        );
        // A result by hand is read back as one.
        let again: ResultFile =
            serde_json::from_str(&serde_json::to_string(&by_hand).unwrap()).unwrap();
        assert_eq!(again, by_hand);
    }
    assert_eq!(compared, 3 * 8);
}

/// Every pixel of two pictures beside each other, of one plane and of three, of unlike heights.
#[test]
fn pictures_stand_beside_each_other() {
    let picture = |width: usize, height: usize, planes: usize, first: f32| Picture {
        width,
        height,
        planes: (0..planes)
            .map(|plane| {
                let value = |k| first + (plane * width * height + k) as f32;
                (0..width * height).map(value).collect()
            })
            .collect(),
        transfer: Transfer::Linear,
        warnings: Vec::new(),
    };
    let mut pixels = 0;
    for (left, right) in [
        (picture(64, 3, 3, 1.0), picture(5, 4, 1, 5000.0)),
        (picture(3, 4, 1, 1.0), picture(70, 2, 3, 5000.0)),
        (picture(33, 2, 1, 1.0), picture(33, 2, 1, 5000.0)),
    ] {
        let made = right.beside(&left);
        let gap = (left.width / 32).max(1);
        assert_eq!(made.width, left.width + gap + right.width);
        assert_eq!(made.height, left.height.max(right.height));
        assert_eq!(made.planes.len(), left.planes.len().max(right.planes.len()));
        for (number, plane) in made.planes.iter().enumerate() {
            for (k, &value) in plane.iter().enumerate() {
                let (x, y) = (k % made.width, k / made.width);
                let of = |picture: &Picture, x: usize| {
                    let plane = &picture.planes[number.min(picture.planes.len() - 1)];
                    if y < picture.height {
                        plane[y * picture.width + x]
                    } else {
                        0.0
                    }
                };
                let expected = if x < left.width {
                    of(&left, x)
                } else if x < left.width + gap {
                    0.0
                } else {
                    of(&right, x - left.width - gap)
                };
                assert_eq!(value, expected, "{x} {y}");
                pixels += 1;
            }
        }
    }
    assert_eq!(pixels, 3 * 4 * 71 + 3 * 4 * 74 + 2 * 67);
}
