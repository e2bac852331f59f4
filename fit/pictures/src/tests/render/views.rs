//! Tests of the places in which a camera sees every pixel.

use crate::images::render::view;
use crate::images::render::view::CameraView;

pub(crate) fn load(text: &str) -> Result<CameraView, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("view.toml");
    std::fs::write(&file, text).unwrap();
    CameraView::load(&file).map_err(|error| error.to_string())
}

/// A view with the camera `far` before the image and a turned sheet 300 mm behind it.
pub(crate) fn view(far: f64, turn_deg: f64, mirror: bool) -> String {
    let (sine, cosine) = turn_deg.to_radians().sin_cos();
    format!(
        "[camera]\nposition_mm = [0, 0, {far}]\n\
         [image]\ncentre_mm = [0, 0, 0]\nright = [1, 0, 0]\ndown = [0, -1, 0]\npixel_pitch_mm = \
         0.1\n\
         [sheet]\nposition_mm = [0, 0, -300]\nnormal = [{}, 0, {cosine}]\nfirst_edge = [0, 1, 0]\n\
         seen_in_mirror = {mirror}\n[coating]\nrefractive_index = 1.5\n",
        sine
    )
}

#[test]
fn a_far_camera_sees_the_uniform_scene() {
    for mirror in [false, true] {
        let view = load(&view(1e7, 20.0, mirror)).unwrap();
        assert_eq!(view.coating, Some(1.5));
        for at in [[0.0, 0.0], [200.0, -100.0], [-300.0, 150.0]] {
            let seen = view.at(at).unwrap();
            // 30 mm of 1e7 turn the ray by 3e-6 rad.
            assert!((seen.place.incidence_deg - 20.0).abs() < 3e-4);
            // The sheet recedes on the side to which its normal leans.
            let r_mm = 300.0 + 0.1 * at[0] * 20.0_f64.to_radians().tan();
            assert!(
                (seen.place.r_mm - r_mm).abs() < 0.01,
                "{:?} {r_mm}",
                seen.place
            );
            // The direction is along the picture's columns, 90 degrees to the first edge, which
            // points up.
            let azimuth = if mirror { 90.0 } else { -90.0 };
            assert!(
                (seen.place.azimuth_deg.unwrap() - azimuth).abs() < 1e-3,
                "{:?}",
                seen.place
            );
            let [[a, b], [c, d]] = seen.pixels_from_mm;
            // The sagittal axis points downwards, as in photographs, if the camera sees the sheet
            // in the mirror.
            let down = if mirror { 10.0 } else { -10.0 };
            for (value, expected) in [(a, 10.0), (b, 0.0), (c, 0.0), (d, down)] {
                assert!((value - expected).abs() < 1e-3, "{:?}", seen.pixels_from_mm);
            }
        }
    }
}

#[test]
fn a_near_camera_sees_what_trigonometry_says() {
    // If the sheet faces the camera, the incidence is the angle of the ray. The mirrored picture is
    // twice as far behind.
    let view = load(&view(600.0, 0.0, false)).unwrap();
    for x in [-1500.0, -10.0, 700.0] {
        let seen = view.at([x, 0.0]).unwrap();
        let tangent = 0.1 * x / 600.0_f64;
        assert!((seen.place.incidence_deg.to_radians().tan() - tangent.abs()).abs() < 1e-9);
        assert!((seen.place.r_mm - 300.0 * tangent.hypot(1.0)).abs() < 1e-9);
        // In the image's plane, the plane across the ray is stretched by 1/cos along the incidence.
        let stretch = 10.0 * tangent.hypot(1.0) * x.signum();
        assert!(
            (seen.pixels_from_mm[0][0] - stretch).abs() < 1e-9,
            "{:?}",
            seen.pixels_from_mm
        );
        // The path is 900 mm from the camera to the sheet, and 300 mm back to the image.
        let mirrored = seen.mirrored.unwrap();
        assert!(
            (mirrored[0] - x * 1200.0 / 600.0).abs() < 1e-6,
            "{mirrored:?}"
        );
    }
    assert!((view::fresnel(1.5, 0.0) - 0.04).abs() < 1e-15);
    // At Brewster's angle only half of the light is reflected at all: sin^2(i - t)/2 with i + t =
    // 90 degrees.
    let brewster = 1.5_f64.atan();
    let s = (2.0 * brewster - std::f64::consts::FRAC_PI_2).sin().powi(2);
    assert!((view::fresnel(1.5, brewster.to_degrees()) - 0.5 * s).abs() < 1e-15);
}

#[test]
fn a_wrong_view_is_said_with_its_place() {
    let good = view(600.0, 0.0, false);
    let cases = [
        (
            "right = [1, 0, 0]",
            "right = [1, 0]",
            "three numbers in brackets",
        ),
        ("right = [1, 0, 0]", "right = [0, 0, 0]", "`right` is"),
        ("down = [0, -1, 0]", "down = [2, 0, 0]", "`down` is"),
        ("centre_mm", "center_mm", "`centre_mm`"),
        ("[sheet]", "[shet]", "`sheet`"),
        (
            "pixel_pitch_mm = 0.1",
            "pixel_pitch_mm = 0",
            "greater than 0",
        ),
    ];
    for (from, to, said) in cases {
        let error = load(&good.replace(from, to)).unwrap_err();
        assert!(
            error.contains("view.toml:") && error.contains(said),
            "{error}"
        );
    }
    let shown = [
        ("[0, 0, -300]", "[0, 0, 300]", "is not behind the image"),
        ("normal = [0, 0, 1]", "normal = [0, 0, -1]", "sees the back"),
        ("[0, 0, 600]", "[50, 0, 0]", "in the image's plane"),
    ];
    for (from, to, said) in shown {
        let text = good.replace(from, to);
        assert_ne!(text, good);
        let error = load(&text).unwrap().at([0.0, 0.0]).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    assert_eq!(cases.len() + shown.len(), 9);
}
