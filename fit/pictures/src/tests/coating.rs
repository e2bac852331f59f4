//! Tests of the light that the coating of a sheet mirrors into a picture, against the virtual image
//! behind a plane mirror.

use crate::images::render::sampled;
use crate::images::render::view::CameraView;
use crate::images::viewed;
use crate::images::{SILENT, Sheet, Spot, Viewpoint};
use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;
use estimator::Error;
use estimator::samples::Sampling;
use estimator::samples::Sequence;
use nalgebra::Vector3;
use num_complex::Complex64;

/// A sheet that returns no light: all light of the picture comes from its coating.
struct Dark;

impl Spot for Dark {
    fn energy(&self) -> Option<f64> {
        Some(0.0)
    }
    fn otf(&self, _: [f64; 2]) -> Complex64 {
        Complex64::ONE
    }
    fn reach_mm(&self) -> f64 {
        1.0
    }
}

impl Sheet for Dark {
    fn spot(&self, _: &Viewpoint, _: f64) -> Result<Box<dyn Spot + '_>, Error> {
        Ok(Box::new(Dark))
    }
}

const SIZE: [usize; 2] = [301, 241];
const PITCH_MM: f64 = 0.5;
const INDEX: f64 = 1.5;
const HALF_MIRROR: f64 = 0.21;

/// A camera in front of the image, which lies in z = 0, and a sheet behind the image, turned about
/// the picture's columns.
#[derive(Clone, Copy)]
struct Scene {
    camera: Vector3<f64>,
    sheet: Vector3<f64>,
    normal: Vector3<f64>,
}

fn scene(camera_mm: [f64; 3], behind_mm: f64, turn_deg: f64) -> Scene {
    let (sine, cosine) = turn_deg.to_radians().sin_cos();
    Scene {
        camera: Vector3::from(camera_mm),
        sheet: Vector3::new(0.0, 0.0, -behind_mm),
        normal: Vector3::new(sine, 0.0, cosine),
    }
}

fn view(scene: Scene, coated: bool) -> CameraView {
    let [camera, sheet, n] = [scene.camera, scene.sheet, scene.normal].map(|v| [v.x, v.y, v.z]);
    let coating = format!("[coating]\nrefractive_index = {INDEX}\n");
    let text = format!(
        "[camera]\nposition_mm = {camera:?}\n\
         [image]\ncentre_mm = [0, 0, 0]\nright = [1, 0, 0]\ndown = [0, -1, 0]\npixel_pitch_mm = \
         {PITCH_MM}\n\
         [sheet]\nposition_mm = {sheet:?}\nnormal = {n:?}\nfirst_edge = [0, 1, 0]\n{}",
        if coated { &coating } else { "" }
    );
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("view.toml");
    std::fs::write(&file, text).expect("written");
    CameraView::load(&file).expect("it is a view")
}

/// Position of a pixel, from the middle of the picture, pixels.
fn from_middle(pixel: usize) -> [f64; 2] {
    let at = [pixel % SIZE[0], pixel / SIZE[0]];
    [0, 1].map(|k| at[k] as f64 - 0.5 * (SIZE[k] as f64 - 1.0))
}

/// A picture of a smooth spot of light about a place.
fn spot_of_light(about: [f64; 2]) -> Picture {
    const SIGMA: f64 = 8.0;
    let value = |pixel| {
        let at = from_middle(pixel);
        let squared = (at[0] - about[0]).powi(2) + (at[1] - about[1]).powi(2);
        (-0.5 * squared / (SIGMA * SIGMA)).exp() as f32
    };
    Picture {
        width: SIZE[0],
        height: SIZE[1],
        planes: vec![(0..SIZE[0] * SIZE[1]).map(value).collect()],
        transfer: Transfer::Linear,
        warnings: Vec::new(),
    }
}

/// Position where the camera sees a place of the source in the sheet's front face (pixels from the
/// middle), and the share of the light that the face mirrors there. The face shows the source as
/// far behind itself as the source lies before it. The camera sees the mirrored source through the
/// image's plane z = 0. The share is that of Fresnel's equations, by the angles on both sides.
fn seen_in_the_face(place: [f64; 2], scene: Scene) -> ([f64; 2], f64) {
    let source = Vector3::new(place[0] * PITCH_MM, -place[1] * PITCH_MM, 0.0);
    let (camera, sheet, n) = (scene.camera, scene.sheet, scene.normal);
    let behind = source - n * (2.0 * (source - sheet).dot(&n));
    let ray = (behind - camera).normalize();
    let at = camera - ray * (camera.z / ray.z);
    let outside = (-ray.dot(&n)).acos();
    let inside = (outside.sin() / INDEX).asin();
    let [less, more] = [outside - inside, outside + inside];
    let share = 0.5 * ((less.sin() / more.sin()).powi(2) + (less.tan() / more.tan()).powi(2));
    ([at.x / PITCH_MM, -at.y / PITCH_MM], share)
}

/// The mirrored picture has the right light and the right place. An integral over the picture is
/// one over the source with the area that a pixel of the source has in the picture (differences of
/// the place over +-0.5 pixel: error 1e-7).
///
/// The source is taken as straight between its pixels, which multiplies its spectrum by sinc^2(f).
/// If the picture's pixels are off the pixels of the source by d, the sum over them has an alias:
/// d^2 exp(-2 (pi sigma d)^2) of the light. This is at most exp(-1) / (2 (pi sigma)^2) = 2.9e-4 for
/// 8 pixels, from either side and along two axes: 1.2e-3. The place has its derivative by 2 pi d,
/// at most 1.3e-3 pixels for each, 5e-3 in all.
///
/// At an incidence of 58 degrees Fresnel's share is 0.08, twice that of the middle, and p and s
/// light differ.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn the_mirrored_picture_is_where_a_mirror_shows_it_and_as_bright() {
    // The camera is on no pixel's perpendicular, where the ratios of sines are 0/0.
    let before = [3.1, 2.2, 600.0];
    for (scene, about) in [
        (scene(before, 300.0, 0.0), [0.5, 0.0]),
        (scene(before, 300.0, 0.0), [90.0, -70.0]),
        (scene(before, 300.0, 8.0), [-20.0, 60.0]),
        (scene([20.0, -40.0, 700.0], 250.0, -8.0), [60.0, -30.0]),
        (scene([1000.0, 0.0, 600.0], 20.0, 0.0), [-60.0, 10.0]),
    ] {
        let (at, share) = seen_in_the_face(about, scene);
        println!("{about:?} is seen at {at:.1?}, share {share:.4}");
        let source = spot_of_light(about);
        let (mut light, mut moment) = (0.0, [0.0; 2]);
        for (pixel, &value) in source.planes[0].iter().enumerate() {
            let [x, y] = from_middle(pixel);
            let (at, share) = seen_in_the_face([x, y], scene);
            let difference = |step: [f64; 2]| {
                let beside = |k: f64| seen_in_the_face([x + k * step[0], y + k * step[1]], scene).0;
                let ([a, b], [c, d]) = (beside(0.5), beside(-0.5));
                [a - c, b - d]
            };
            let (by_x, by_y) = (difference([1.0, 0.0]), difference([0.0, 1.0]));
            let area = (by_x[0] * by_y[1] - by_x[1] * by_y[0]).abs();
            let part = HALF_MIRROR * share * area * f64::from(value);
            light += part;
            moment = [moment[0] + part * at[0], moment[1] + part * at[1]];
        }
        let centre = moment.map(|m| m / light);

        let sampling = Sampling {
            samples: 1,
            seed: 1,
            sequence: Sequence::Sobol,
        };
        let coated = view(scene, true);
        let by_transforms =
            viewed(&source, &Dark, &coated, HALF_MIRROR, 0.01, SILENT).expect("it is seen");
        let by_samples = sampled::viewed(&source, &Dark, &coated, HALF_MIRROR, sampling, SILENT);
        for image in [by_transforms.0, by_samples.expect("it is seen").image] {
            let (mut sum, mut first) = (0.0, [0.0; 2]);
            for (pixel, &value) in image.planes[0].iter().enumerate() {
                let at = from_middle(pixel);
                sum += f64::from(value);
                first = [0, 1].map(|k| first[k] + f64::from(value) * at[k]);
            }
            let found = first.map(|m| m / sum);
            println!("light {sum:.6} of {light:.6}, at {found:.5?} of {centre:.5?}");
            assert!((sum / light - 1.0).abs() < 1.2e-3, "{sum} {light}");
            for k in [0, 1] {
                assert!((found[k] - centre[k]).abs() < 5e-3, "{found:?} {centre:?}");
            }
        }
        // Without a coating the face mirrors nothing.
        let bare = viewed(
            &source,
            &Dark,
            &view(scene, false),
            HALF_MIRROR,
            0.01,
            SILENT,
        )
        .expect("seen");
        assert!(bare.0.planes[0].iter().all(|&value| value == 0.0));
    }
}
