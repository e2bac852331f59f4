//! Tests of the slanted-edge estimator on edges of known place and OTF.

use crate::planted::{Stream, camera, params, truth};
use crate::simulate::PlantedEdge;
use crate::simulate::photograph as simulate;
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::photographs::Estimator;
use edges::photographs::Profile;
use edges::photographs::Window;
use edges::photographs::edge::fault::Fault;
use edges::photographs::locate;
use edges::photographs::photo::plane::Photo;
use edges::photographs::photo::taken::Taken;
use estimator::model::{Camera, Lens};

fn photo(width: usize, height: usize, luminance: Vec<f32>) -> Photo {
    Photo {
        width,
        height,
        luminance,
        clip_level: None,
        clips_alone: true,
        transfer: Taken::default(),
        warnings: Vec::new(),
    }
}

/// A noise-free photograph of the source edge (camera blur only) in any direction.
fn source(normal_deg: f64, offset_px: f64) -> Photo {
    let truth = truth(Kernel::Lobe, LobeShape::Radial, 3.0, 0.3, 0.6);
    let mut params = params(1, truth, &[0.0], &[200.0], camera(1e12));
    params.reference = Some(PlantedEdge {
        normal_deg,
        offset_px,
        ..PlantedEdge::SOURCE
    });
    let light = simulate::light(&params, None).expect("the parameters are valid");
    photo(
        params.camera.width,
        params.camera.height,
        light.iter().map(|&v| v as f32).collect(),
    )
}

/// The MTF is within 0.002 up to half the sampling frequency, and the angle within 1e-3 deg (0.001
/// px at the end of a 128-row edge), for every direction and polarity.
///
/// 14.04 and 26.57 deg (tangents 1/4 and 1/2) are left to the next test, because there the pixels
/// fall on few phases.
#[test]
fn known_edges_of_all_directions() {
    let (mut worst, mut worst_angle) = (0.0_f64, 0.0_f64);
    for quarter in [0.0, 90.0, 180.0, -90.0] {
        for tilt in [
            1.3, 2.0, 4.0, 7.7, 12.0, 17.0, 23.0, 31.0, 38.0, 44.0, -3.0, -29.0,
        ] {
            let normal_deg = quarter + tilt;
            let photo = source(normal_deg, 0.4);
            let window = Window::of(&photo, None).expect("the whole picture");
            let line = locate(&window).unwrap_or_else(|fault| panic!("{normal_deg} deg: {fault}"));
            let turn =
                (line.normal_rad.to_degrees() - normal_deg + 540.0).rem_euclid(360.0) - 180.0;
            worst_angle = worst_angle.max(turn.abs());
            let profile = Profile::new(&window, &line).expect("the picture is large enough");
            let pitch_mm = 0.08;
            let frequencies: Vec<f64> = (1..=50).map(|k| 0.01 * f64::from(k) / pitch_mm).collect();
            let mtf = Estimator::new(&profile, pitch_mm, 400, 50).measure(&profile);
            let blur_mm = std::f64::consts::SQRT_2 * std::f64::consts::PI * 0.55 * pitch_mm;
            let lenses = vec![Lens::new(blur_mm, 2.0)];
            let known = Camera { pitch_mm, lenses };
            for (f, measured) in frequencies.iter().zip(&mtf.modulus[1..]) {
                worst = worst.max((measured - known.otf(*f, normal_deg.to_radians()).abs()).abs());
            }
        }
    }
    println!("largest MTF error {worst:.5}, largest angle error {worst_angle:.1e} deg");
    assert!(worst < 0.002, "largest MTF error {worst}");
    assert!(worst_angle < 1e-3, "largest angle error {worst_angle} deg");
}

/// Angles whose tangent is a simple fraction give an MTF too, with a warning if bins stay empty.
#[test]
fn simple_fractions_are_bridged() {
    for tangent in [0.25_f64, 0.5, 1.0] {
        let photo = source(tangent.atan().to_degrees(), 0.0);
        let window = Window::of(&photo, None).expect("the whole picture");
        let line = locate(&window).expect("there is an edge");
        let profile = Profile::new(&window, &line).expect("the picture is large enough");
        assert_eq!(
            profile.empty_bins() > 0,
            !profile.warnings(&line).is_empty()
        );
        let mtf = Estimator::new(&profile, 1.0, 16, 1).measure(&profile);
        assert!(mtf.modulus[1].is_finite() && mtf.modulus[1] < 1.0);
    }
}

/// An edge whose blur fades out within the window causes no warning. An edge that the window cuts
/// off causes one.
///
/// The radial lobe ends 7.54/a from the edge, and the profile reaches 7.8 mm. At a = 1 the lobe
/// ends at 7.5 mm, at a = 0.3 at 25 mm. The rises at the ends are 1 % and 4 %; the limit for a
/// warning is 2 %.
#[test]
fn a_blur_wider_than_the_window_is_noticed() {
    for (a, cut) in [
        (4.0, false),
        (1.5, false),
        (1.0, false),
        (0.3, true),
        (0.15, true),
    ] {
        let truth = truth(Kernel::Lobe, LobeShape::Radial, a, 0.3, 0.6);
        for full_well_e in [1e12, 2e4] {
            let params = params(1, truth.clone(), &[0.0], &[200.0], camera(full_well_e));
            let pixels = simulate::photograph(&params, Some(0)).expect("the parameters are valid");
            let photo = photo(params.camera.width, params.camera.height, pixels);
            let window = Window::of(&photo, None).expect("the whole picture");
            let line = locate(&window).expect("there is an edge");
            let profile = Profile::new(&window, &line).expect("the picture is large enough");
            let rise = profile.rise_at_the_ends();
            println!(
                "a {a}, {full_well_e:e} electrons: rise {rise:.4}, reach {}",
                profile.reach
            );
            let warned = profile
                .warnings(&line)
                .iter()
                .any(|w| w.contains("does not fade out"));
            assert_eq!(warned, cut, "a {a}: {rise}");
        }
    }
}

/// Pictures that do not hold exactly one edge are refused, each with its own fault. None causes a
/// panic.
#[test]
fn pictures_without_one_edge() {
    let (w, h) = (64, 48);
    let mut stream = Stream(3);
    let noise: Vec<f32> = (0..w * h)
        .map(|_| stream.between(0.4, 0.6) as f32)
        .collect();
    let bar: Vec<f32> = (0..w * h)
        .map(|i| {
            if (24..40).contains(&(i % w)) {
                0.9
            } else {
                0.1
            }
        })
        .collect();
    let point: Vec<f32> = (0..w * h)
        .map(|i| if i == 24 * w + 32 { 1.0 } else { 0.0 })
        .collect();
    let locate_in = |pixels: Vec<f32>| {
        locate(&Window::of(&photo(w, h, pixels), None).expect("the whole picture"))
    };
    assert!(matches!(
        locate_in(vec![0.5; w * h]),
        Err(Fault::NoContrast { .. })
    ));
    assert!(matches!(
        locate_in(vec![0.0; w * h]),
        Err(Fault::NoContrast { .. })
    ));
    assert!(matches!(
        locate_in(noise),
        Err(Fault::NoContrast { .. } | Fault::SeveralEdges { .. })
    ));
    assert!(locate_in(bar).is_err());
    assert!(locate_in(point).is_err());
    let tiny = locate(
        &Window::of(
            &photo(6, 6, (0..36).map(|i| (i % 6) as f32).collect()),
            None,
        )
        .expect("all"),
    );
    assert!(matches!(tiny, Err(Fault::TooSmall)));
    let one = locate(&Window::of(&photo(1, 1, vec![0.3]), None).expect("all"));
    assert!(one.is_err());
    // 300 pictures of random structure give an edge or a fault, but no panic and no value that is
    // not finite.
    let mut found = 0;
    for case in 0..300 {
        let (w, h) = (8 + case % 40, 8 + case % 23);
        let pixels: Vec<f32> = (0..w * h)
            .map(|i| (stream.between(0.0, 1.0) + (i % (1 + case % 9)) as f64) as f32)
            .collect();
        if let Ok(line) = locate(&Window::of(&photo(w, h, pixels), None).expect("all")) {
            assert!(line.normal_rad.is_finite() && line.offset_px.is_finite());
            found += 1;
        }
    }
    println!("{found} of 300 random pictures were taken for an edge");
}
