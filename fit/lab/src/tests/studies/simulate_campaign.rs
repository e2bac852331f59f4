//! Tests of a simulated campaign on disk: it can be read and repeated, its noise is the stated one,
//! and it never overwrites other files.

use std::collections::BTreeMap;
use std::path::Path;

use crate::planted;
use crate::simulate::Error;
use crate::simulate::photograph as simulate;
use crate::simulate::{ByIncidence, Params, PlantedCamera, PlantedEdge, PlantedSheet, PlantedShot};
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::photographs::{manifest::captures, photo};

fn params() -> Params {
    let shot = |distance, incidence, normal| PlantedShot {
        edge: PlantedEdge {
            normal_deg: normal,
            offset_px: 0.62,
            ..PlantedEdge::AERIAL
        },
        floating_distance_mm: distance,
        path_mm: None,
        incidence_deg: incidence,
        azimuth_deg: 30.0,
        tangential_axis_deg: 0.0,
        shifts: None,
    };
    Params {
        seed: 11,
        camera: PlantedCamera {
            width: 96,
            height: 80,
            ..PlantedCamera::default()
        },
        truth: PlantedSheet {
            kernel: Kernel::Eq1,
            lobe: LobeShape::Radial,
            spectrum: None,
            refractive_index: 1.49,
            pair: true,
            a: ByIncidence::Table(vec![(0.0, 4.9), (20.0, 3.75)]),
            c_mm: 0.24,
            angular_spread_mrad: 0.0,
            mu: ByIncidence::Shared(0.5),
        },
        reference: Some(PlantedEdge::SOURCE),
        captures: vec![shot(150.0, 0.0, 5.0), shot(300.0, 20.0, 96.0)],
    }
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let read = |entry: std::io::Result<std::fs::DirEntry>| {
        let path = entry.unwrap().path();
        (
            path.file_name().unwrap().to_str().unwrap().to_owned(),
            std::fs::read(path).unwrap(),
        )
    };
    std::fs::read_dir(folder).unwrap().map(read).collect()
}

#[test]
fn campaigns_are_readable_repeatable_and_protected() {
    let folder = tempfile::tempdir().unwrap();
    let (one, two) = (folder.path().join("one"), folder.path().join("deeper/two"));
    let report = crate::simulate::run(&params(), &one, false).unwrap();
    assert_eq!(
        (report.photographs, report.clipped, report.warnings.len()),
        (3, 0, 0)
    );
    crate::simulate::run(&params(), &two, false).unwrap();
    let first = files(&one);
    assert_eq!(first.len(), 5);
    assert_eq!(first, files(&two), "the same seed gives the same bytes");
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        2,
        "no temporary folder is left"
    );

    assert!(matches!(
        crate::simulate::run(&params(), &one, false),
        Err(Error::NotEmpty { .. })
    ));
    assert_eq!(first, files(&one));
    crate::simulate::run(
        &Params {
            seed: 12,
            ..params()
        },
        &one,
        true,
    )
    .unwrap();
    assert_ne!(
        first["source.exr"],
        files(&one)["source.exr"],
        "another seed gives other noise"
    );

    let campaign = captures::load(&report.manifest).unwrap();
    assert!(campaign.warnings.is_empty() && campaign.references.len() == 1);
    assert_eq!(campaign.captures.len(), 2);
    assert_eq!(campaign.captures[1].incidence_deg, 20.0);
    for (index, capture) in campaign.captures.iter().enumerate() {
        let shown = capture.shot.load().unwrap();
        let expected = simulate::photograph(
            &Params {
                seed: 12,
                ..params()
            },
            Some(index),
        )
        .unwrap();
        assert_eq!(
            shown.luminance, expected,
            "photograph {index} comes back bit for bit"
        );
    }
    let truth: serde_json::Value = serde_json::from_slice(&first["truth.json"]).unwrap();
    assert_eq!(truth["truth"]["a"]["20"], 3.75);
    assert_eq!(truth["captures"][1]["edge_normal_deg"], 96.0);
}

#[test]
fn order_does_not_matter_and_noise_is_what_it_says() {
    let params = params();
    let camera = &params.camera;
    let backwards: Vec<_> = [Some(1), Some(0), None]
        .map(|i| simulate::photograph(&params, i).unwrap())
        .into();
    let step = f64::from((1_u32 << camera.bits) - 1).recip();
    let mut cases = 0;
    for (index, photo) in [Some(1), Some(0), None].into_iter().zip(&backwards) {
        assert_eq!(*photo, simulate::photograph(&params, index).unwrap());
        let light = simulate::light(&params, index).unwrap();
        // Shot noise, read noise and rounding: chi-square of n pixels is n with the standard
        // deviation sqrt(2 n). The limit is 5 of these.
        let chi: f64 = light
            .iter()
            .zip(photo)
            .map(|(mean, &value)| {
                let reading =
                    (camera.read_noise_e / camera.full_well_e).powi(2) + step * step / 12.0;
                (f64::from(value) - mean).powi(2) / (mean / camera.full_well_e + reading)
            })
            .sum();
        let n = light.len() as f64;
        assert!(
            (chi - n).abs() < 5.0 * (2.0 * n).sqrt(),
            "{index:?}: {chi} of {n}"
        );
        cases += 1;
    }
    assert_eq!(cases, 3);
}

#[test]
fn levels_follow_the_luminance_ratio() {
    // The plateaus of the source are veil + 0.9 and veil + 0.009. For the capture at normal
    // incidence the contrast is mu eta T R = 0.5 x 2/3 x 0.25 of that, times the exposure 6. At
    // +-2.4 mm the lobe of 7.5/4.9 = 1.54 mm has ended.
    let params = params();
    let (source, aerial) = (
        simulate::light(&params, None).unwrap(),
        simulate::light(&params, Some(0)).unwrap(),
    );
    let row = 40 * params.camera.width;
    let (dark, bright) = (row, row + params.camera.width - 1);
    assert!((source[bright] - 0.904).abs() < 1e-9 && (source[dark] - 0.013).abs() < 1e-9);
    let gain = 6.0 * 0.5 * (2.0 / 3.0) * 0.25;
    assert!(
        (aerial[bright] - (0.004 + gain * 0.9)).abs() < 1e-7,
        "{}",
        aerial[bright]
    );
    assert!(
        (aerial[dark] - (0.004 + gain * 0.009)).abs() < 1e-7,
        "{}",
        aerial[dark]
    );
    // The normal of the second capture points down, so the bright side is below.
    let second = simulate::light(&params, Some(1)).unwrap();
    assert!(second[second.len() - 48] > 2.0 * second[48]);
}

#[test]
fn an_empty_direction_is_a_veil() {
    let mut params = params();
    params.truth.refractive_index = 1.0;
    params.truth.a = ByIncidence::Shared(4.0);
    params.captures[0].incidence_deg = 45.0;
    params.captures[0].azimuth_deg = 0.0;
    params.truth.pair = false;
    let light = simulate::light(&params, Some(0)).unwrap();
    assert!(light.iter().all(|&level| level == params.camera.veil));
}

#[test]
fn the_photograph_is_the_same_through_its_own_file() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("campaign");
    crate::simulate::run(&params(), &out, false).unwrap();
    let source = photo::load(&out.join("source.exr"), &photo::channel::Decode::default()).unwrap();
    assert_eq!(
        source.luminance,
        simulate::photograph(&params(), None).unwrap()
    );
    assert_eq!((source.width, source.height, source.clipped()), (96, 80, 0));
}

/// Compares the place at which light of a planted deviation meets the image with that by hand:
/// off by R times the deviation along each axis, on top of its shift, which the incidence
/// foreshortens. The places are below 10 mm and have a few roundings.
#[test]
fn deviating_light_meets_the_image_off_by_distance_times_angle() {
    let (c_mm, r_mm, deviation) = (0.31_f64, 240.0_f64, [2e-3, -1.5e-3]);
    let incidence = [0.0, 20.0, 40.0];
    let truth = planted::truth(Kernel::Eq1, LobeShape::Radial, 3.4, c_mm, 0.6);
    let straight = planted::table(&truth, &incidence, 20.0);
    let off = planted::deviating(straight.clone(), |_| deviation);
    let params = planted::params(3, truth, &incidence, &[r_mm], planted::camera(4e4));
    let seen = |table| params.clone().of_sheet(table).unwrap().captures;
    let mut cases = 0;
    for (one, other) in seen(&straight).iter().zip(&seen(&off)) {
        let cosine = one.incidence_deg.to_radians().cos();
        let pairs = [one, other].map(|shot| shot.shifts.as_deref().unwrap());
        for (one, other) in pairs[0].iter().zip(pairs[1]) {
            assert_eq!(one.polygon.len(), other.polygon.len());
            for (p, q) in one.polygon.iter().zip(&other.polygon) {
                let tangential = c_mm * cosine * (q[0] - p[0]);
                let sagittal = c_mm * (q[1] - p[1]);
                assert!(
                    (tangential - r_mm * deviation[0]).abs() < 1e-13
                        && (sagittal - r_mm * deviation[1]).abs() < 1e-13,
                    "cosine {cosine}: {tangential} {sagittal} mm"
                );
                cases += 1;
            }
        }
    }
    assert!(cases >= 3 * 3, "{cases} corners");
}

/// Checks a photograph that goes through JPEG against the one that does not. At quality 100 a
/// coefficient is rounded to whole codes, so a pixel errs by 8 x 0.5 codes at most and by 0.29 x
/// sqrt 2 codes as a standard deviation: once by the coefficients, once by its own code. A code is
/// 1/255 of the coded light; its slope d light / d code is at most 2.28. Hot pixels are as many as
/// planted, within 5 deviations of their number.
#[test]
fn photographs_go_through_jpeg_and_have_hot_pixels() {
    let mut plain = params();
    plain.camera.full_well_e = 1e9;
    plain.camera.read_noise_e = 0.0;
    let mut packed = plain.clone();
    packed.camera.jpeg_quality = Some(100);
    let of = |params: &Params| simulate::saved(params, Some(0)).expect("it can be simulated");
    let (linear, through) = (of(&plain), of(&packed));
    let squares = linear
        .iter()
        .zip(&through)
        .map(|(a, b)| f64::from(a - b).powi(2));
    let rms = (squares.sum::<f64>() / linear.len() as f64).sqrt();
    println!("{rms:.5} root mean square");
    assert!(
        rms > 0.0 && rms < 0.29 * 2.0_f64.sqrt() * 2.28 / 255.0,
        "{rms}"
    );
    plain.camera.hot_share = 0.01;
    let hot = of(&plain).iter().filter(|&&value| value == 1.0).count() as f64;
    let expected = 0.01 * linear.len() as f64;
    println!("{hot} hot pixels for {expected}");
    assert!((hot - expected).abs() < 5.0 * expected.sqrt(), "{hot}");

    let folder = tempfile::tempdir().expect("a temporary folder");
    crate::simulate::run(&packed, folder.path(), true).expect("the campaign can be written");
    let campaign =
        captures::load(&folder.path().join("captures.toml")).expect("the manifest is valid");
    let photo = campaign.captures[0]
        .shot
        .load()
        .expect("it is a photograph");
    // The decoder is the same, and both compute the curve of sRGB in f32.
    let worst = photo
        .luminance
        .iter()
        .zip(&through)
        .map(|(a, b)| (a - b).abs());
    assert!(worst.fold(0.0, f32::max) < 1e-6);
}
