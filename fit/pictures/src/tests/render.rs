//! Tests of mid-air images against sums over every pair of pixels, closed forms and each other.

mod camera;
mod mirrored;
mod samples;
mod views;

use crate::images::Scale;
use crate::images::render;
use crate::images::render::psf::Psf;
use crate::images::render::tiles::Tiles;
use crate::images::render::transform::Convolver;
use crate::images::{SILENT, Sampler, Sheet, Spot, TAIL, Viewpoint, Writing};
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;
use estimator::Error;
use estimator::predict::Fitted;
use estimator::result::ResultFile;
use estimator::result::TableResult;
use lab::planted::{Stream, deviating, table, truth};
use num_complex::Complex64;
use serde_json::json;
use tables::{ShiftLine, Table};

/// A spot of light: an even square of a width in mm.
struct Square {
    width: f64,
    energy: f64,
}

fn sinc(t: f64) -> f64 {
    if t == 0.0 { 1.0 } else { t.sin() / t }
}

impl Spot for Square {
    fn energy(&self) -> Option<f64> {
        Some(self.energy)
    }
    fn otf(&self, f: [f64; 2]) -> Complex64 {
        let along = f.map(|f| sinc(std::f64::consts::PI * f * self.width));
        (along[0] * along[1]).into()
    }
    fn reach_mm(&self) -> f64 {
        self.width
    }
    fn samples(&self) -> Option<Box<Sampler<'_>>> {
        Some(Box::new(|[u, v, _, _]| {
            [u, v].map(|u| self.width * (u - 0.5))
        }))
    }
}

/// A sheet whose spots are squares. Their width is the distance in mm; their energy falls with the
/// incidence.
struct Squares;

impl Sheet for Squares {
    fn spot(&self, place: &Viewpoint, _: f64) -> Result<Box<dyn Spot + '_>, Error> {
        Ok(Box::new(Square {
            width: place.r_mm,
            energy: 1.0 / (1.0 + place.incidence_deg),
        }))
    }
}

fn place(r_mm: f64, incidence_deg: f64) -> Viewpoint {
    Viewpoint {
        incidence_deg,
        azimuth_deg: Some(20.0),
        r_mm,
    }
}

const PIXELS: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];

/// A picture of numbers in 0..1, dark within `margin` of the frame.
fn picture(width: usize, height: usize, margin: usize) -> Picture {
    let mut stream = Stream(7);
    let inside = |i: usize, n: usize| i >= margin && i + margin < n;
    let mut plane = || -> Vec<f32> {
        let pixel = |i: usize| {
            let value = stream.between(0.0, 1.0) as f32;
            let bright = inside(i % width, width) && inside(i / width, height);
            if bright { value } else { 0.0 }
        };
        (0..width * height).map(pixel).collect()
    };
    Picture {
        width,
        height,
        planes: vec![plane(), plane(), plane()],
        transfer: Transfer::Linear,
        warnings: Vec::new(),
    }
}

/// The light of one pixel: a sum of all pixels by their weights.
fn gathered(plane: &[f32], size: [usize; 2], psf: &Psf, at: [usize; 2]) -> f64 {
    let columns = 2 * psf.reach[0] + 1;
    let mut sum = 0.0;
    for y in 0..size[1] {
        for x in 0..size[0] {
            let dx = (at[0] + psf.reach[0]).wrapping_sub(x);
            let dy = (at[1] + psf.reach[1]).wrapping_sub(y);
            if dx < columns && dy < 2 * psf.reach[1] + 1 {
                sum += f64::from(psf.weights[dy * columns + dx] * plane[y * size[0] + x]);
            }
        }
    }
    sum
}

#[test]
fn a_square_spot_on_square_pixels_meets_its_closed_form() {
    // Integral from -inf of the triangle of width 2. Its mean over [d - w/2, d + w/2] is the weight
    // along one axis.
    let integral = |x: f64| {
        let x = x.clamp(-1.0, 1.0);
        0.5 + x - 0.5 * x * x.abs()
    };
    let mut cases = 0;
    for width in [0.5, 1.0, 2.5, 6.0] {
        let psf = Psf::new(&Squares, &place(width, 0.0), PIXELS).unwrap();
        let along = |d: f64| (integral(d + 0.5 * width) - integral(d - 0.5 * width)) / width;
        let columns = 2 * psf.reach[0] + 1;
        let mut sum = 0.0;
        for (i, &weight) in psf.weights.iter().enumerate() {
            let x = (i % columns) as f64 - psf.reach[0] as f64;
            let y = (i / columns) as f64 - psf.reach[1] as f64;
            // An error of the transfer function at every frequency is at most as large in every
            // weight.
            let error = (f64::from(weight) - along(x) * along(y)).abs();
            assert!(
                error <= psf.error,
                "width {width} at {x} {y}: {error} {}",
                psf.error
            );
            sum += f64::from(weight);
            cases += 1;
        }
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        assert!(psf.error < 2e-3, "width {width}: {}", psf.error);
    }
    assert!(cases > 4 * 25, "{cases}");
}

#[test]
fn transforms_meet_the_sum_over_all_pairs() {
    let mut cases = 0;
    for [width, height] in [[31, 18], [40, 7], [5, 5]] {
        let source = picture(width, height, 0);
        // This spot is wider than the smallest picture.
        let psf = Psf::new(&Squares, &place(6.0, 0.0), [[1.2, 0.4], [-0.1, 0.7]]).unwrap();
        let convolver = Convolver::new([width, height], psf.reach);
        let blurred = convolver.blur(&source.planes[0], &convolver.weights(&psf));
        for (i, &value) in blurred.iter().enumerate() {
            let expected = gathered(
                &source.planes[0],
                [width, height],
                &psf,
                [i % width, i / width],
            );
            // Rounding of f32 (6e-8) through four transforms of values below 1.
            assert!(
                (f64::from(value) - expected).abs() < 1e-6,
                "{value} {expected}"
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 31 * 18 + 40 * 7 + 25);
}

pub(crate) fn result(kernel: &str, lobe: Option<&str>, table: &Table) -> ResultFile {
    let number = |value: f64| json!({"value": value, "standard_error": 0.001});
    serde_json::from_value(json!({
        "kernel": kernel, "lobe": lobe, "loss": "edge", "iterations": 1, "stop": "small \
        step", "seconds": 0.1,
        "wavelength_nm": (kernel == "wave").then_some("550"),
        "c_mm": (kernel != "lobe").then(|| number(0.24)),
        "a_per_mm": matches!(kernel, "eq1" | "lobe").then(|| number(4.9)),
        "a_times_r": (kernel == "angular").then(|| number(735.0)),
        "mu": number(0.25),
        "covariance": {"names": [], "matrix": []}, "bounds": {}, "candidates": [], "captures": [],
        "camera": {"pixel_pitch_mm": 0.08, "lens_blur_mm": null, "lens_exponent": null},
        "half_mirror": 0.25, "table": serde_json::to_value(TableResult::of(table)).unwrap(),
        "warnings": []
    }))
    .unwrap()
}

/// Compares the OTF of a spot whose light deviates with that of the table along the same line,
/// which has the deviations apart from the shifts. The latter is accurate to 1.6e-5 for each cube,
/// whose shares sum to 1. The spot is a sum over its polygons.
#[test]
fn spots_of_deviating_light_meet_the_otf_of_the_table() {
    let truth = truth(Kernel::Shift, LobeShape::Radial, 4.9, 0.24, 0.25);
    let straight = table(&truth, &[0.0, 20.0, 40.0], 20.0);
    let table = deviating(straight, |k| [[1.5e-3, -5e-4], [-1e-3, 8e-4]][k % 2]);
    let result = result("shift", None, &table);
    let sheet = Fitted::new(&result, &table).unwrap();
    let mut worst = 0.0_f64;
    for incidence_deg in [0.0, 20.0, 40.0] {
        let direction = table.direction(incidence_deg, Some(20.0)).unwrap();
        let incidence = incidence_deg.to_radians();
        let spot = sheet.spot(&place(150.0, incidence_deg), 6.0).unwrap();
        for turn_deg in [0.0_f64, 35.0, 90.0, 160.0] {
            let (sine, cosine) = turn_deg.to_radians().sin_cos();
            let line = ShiftLine::new(&direction, incidence, [cosine, sine]).unwrap();
            for frequency in [0.0, 0.4, 1.1, 2.7, 5.0] {
                let expected = line.otf(0.24, 150.0, frequency).0;
                let found = spot.otf([frequency * cosine, frequency * sine]);
                worst = worst.max((found - expected).norm());
            }
        }
    }
    assert!(worst < 1.6e-5, "{worst}");
}

/// Checks the reach of a separable lobe by the integral of sinc^2: the share [`TAIL`] lies beyond
/// it along an axis, both sides together. The share beyond X = a x is 1/(pi X) times a number
/// between 1 - 1/X and 1 + 1/X, because sin^2 has the mean 1/2 and its wave integrates to at most
/// 1/(2 X^2). Simpson's rule with steps of 0.01 errs by less than 160 x 0.01^4 x 16 / 180 = 1.4e-7.
#[test]
fn a_separable_lobe_has_its_tail_beyond_the_reach() {
    let truth = truth(Kernel::Lobe, LobeShape::Separable, 4.9, 0.24, 0.25);
    let table = table(&truth, &[0.0, 20.0], 20.0);
    let result = result("lobe", Some("separable"), &table);
    let sheet = Fitted::new(&result, &table).unwrap();
    let reach_mm = sheet.spot(&place(150.0, 20.0), 6.0).unwrap().reach_mm();
    let end = 4.9 * reach_mm;
    let pairs = (end / 0.02).ceil() as usize;
    let step = end / (2 * pairs) as f64;
    let sum: f64 = (0..=2 * pairs)
        .map(|k| {
            let weight = match k {
                0 => 1.0,
                k if k == 2 * pairs => 1.0,
                k if k % 2 == 1 => 4.0,
                _ => 2.0,
            };
            weight * sinc(k as f64 * step).powi(2)
        })
        .sum();
    let beyond = 1.0 - 2.0 / std::f64::consts::PI * sum * step / 3.0;
    println!("X {end:.1}: {beyond:.6} beyond");
    assert!((beyond / TAIL - 1.0).abs() < 1.0 / end + 1e-4, "{beyond}");
}

#[test]
fn energy_is_kept_by_every_kernel() {
    let truth = truth(Kernel::Eq1, LobeShape::Radial, 4.9, 0.24, 0.25);
    let table = table(&truth, &[0.0, 20.0], 20.0);
    let source = picture(240, 200, 60);
    let sum = |plane: &[f32]| plane.iter().map(|&v| f64::from(v)).sum::<f64>();
    let scale = Scale {
        pitch_mm: 0.08,
        tangential_axis_deg: 30.0,
        seen_in_mirror: false,
    };
    let mut cases = 0;
    for (kernel, lobe, tails) in [
        ("eq1", Some("radial"), false),
        ("eq1", Some("separable"), true),
        ("angular", Some("radial"), false),
        ("shift", None, false),
        ("lobe", Some("radial"), false),
        ("wave", None, true),
    ] {
        let result = result(kernel, lobe, &table);
        let sheet = Fitted::new(&result, &table).unwrap();
        let psf = render::uniform_psf(&sheet, &place(150.0, 20.0), &scale, None, SILENT).unwrap();
        let energy = psf.energy.unwrap();
        let eta = table.direction(20.0, Some(20.0)).unwrap().retroreflected;
        assert!((energy - 0.25 * 0.25 * eta).abs() < 1e-12);
        assert!(psf.error <= 1e-4, "{kernel}: {}", psf.error);
        let total: f64 = psf.weights.iter().map(|&w| f64::from(w)).sum();
        // 1e5 weights, each rounded to 6e-8 of itself, and the rounding of the transform.
        assert!((total - 1.0).abs() < 1e-5, "{kernel}: {total}");
        let image = render::uniform(&source, &psf, SILENT);
        for (plane, own) in image.planes.iter().zip(&source.planes) {
            let kept = sum(plane) / (energy * sum(own));
            // The tails of both axes may leave the frame. 60 pixels are 4.8 mm; 2 % of a separable
            // lobe lie further out.
            let lost = if tails {
                2.0 * (1.0 / (3.0 * 4.9 * 4.8) + TAIL)
            } else {
                0.0
            };
            assert!(
                kept < 1.0 + 1e-4 && kept > 1.0 - 1e-4 - lost,
                "{kernel}: {kept}"
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 18);
}

#[test]
fn the_bytes_do_not_depend_on_the_threads() {
    let source = picture(90, 70, 0);
    let render = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let psf = Psf::new(&Squares, &place(5.0, 1.0), PIXELS).unwrap();
            render::uniform(&source, &psf, SILENT)
        })
    };
    let (one, three) = (render(1), render(3));
    assert_eq!(one.planes.len(), 3);
    for writing in [Writing::Exr, Writing::Png, Writing::Tiff, Writing::Jpeg] {
        let bytes = |image: &Picture| writing.bytes(image.clone()).unwrap();
        assert_eq!(bytes(&one), bytes(&three));
    }
}

#[test]
fn tiles_meet_every_pixels_own_weights() {
    let size = [48, 30];
    let source = picture(size[0], size[1], 0);
    // Both the width and the energy change across the picture.
    let at = |[x, y]: [f64; 2]| -> Result<Psf, crate::Error> {
        Psf::new(&Squares, &place(3.0 + 0.05 * x, 0.01 * y), PIXELS)
    };
    let tolerance = 0.01;
    let tiles = Tiles::new(size, tolerance, SILENT, at).unwrap();
    assert!(
        tiles.error <= tolerance && tiles.counts()[0] > 1,
        "{:?}",
        tiles.counts()
    );
    let images = tiles.render(&source.planes, size, SILENT);
    let (mut cases, mut worst) = (0, 0.0_f64);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let psf = at([x as f64, y as f64]).unwrap();
            let own = gathered(&source.planes[1], size, &psf, [x, y]);
            let expected = own * psf.energy.unwrap();
            worst = worst.max((f64::from(images[1][y * size[0] + x]) - expected).abs());
            cases += 1;
        }
    }
    // The brightest source and the greatest energy are 1.
    assert!(worst <= tolerance, "{worst}");
    assert_eq!(cases, 48 * 30);
}

/// Tiles mix the weights of their corners by the place of each pixel's middle. A blur that is the
/// same everywhere, in light that is linear between the corners along both axes, is then exact: the
/// sums of products of f32 below 1 round by less than 1e-6. The light has corners of its own at
/// quarters of the width, so that there are 4 x 2 tiles.
#[test]
fn tiles_of_one_blur_in_linear_light_are_exact() {
    let size = [45, 31];
    let source = picture(size[0], size[1], 0);
    let one = Psf::new(&Squares, &place(2.5, 0.0), PIXELS).unwrap();
    let corners = [1.0, 0.3, 0.7, 0.2, 0.9];
    let light = |[x, y]: [f64; 2]| {
        let at = (x + 0.5) / size[0] as f64 * 4.0;
        let k = (at as usize).min(3);
        let across = corners[k] + (corners[k + 1] - corners[k]) * (at - k as f64);
        across * (0.4 + 0.6 * (y + 0.5) / size[1] as f64)
    };
    let at = |place: [f64; 2]| -> Result<Psf, crate::Error> {
        let energy = Some(light(place));
        Ok(Psf {
            energy,
            ..one.clone()
        })
    };
    let tiles = Tiles::new(size, 1e-3, SILENT, at).unwrap();
    println!("{:?} tiles", tiles.counts());
    assert!(
        tiles.counts()[0] == 4 && tiles.error < 1e-6,
        "{}",
        tiles.error
    );
    let images = tiles.render(&source.planes, size, SILENT);
    let mut cases = 0;
    for (image, plane) in images.iter().zip(&source.planes) {
        for (i, &found) in image.iter().enumerate() {
            let pixel = [i % size[0], i / size[0]];
            let expected = gathered(plane, size, &one, pixel) * light(pixel.map(|i| i as f64));
            assert!(
                (f64::from(found) - expected).abs() < 1e-6,
                "{pixel:?}: {found} {expected}"
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 3 * 45 * 31);
}

#[test]
fn pictures_come_back_from_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let mut cases = 0;
    for (planes, transfer) in [
        (3, Transfer::Linear),
        (3, Transfer::Srgb),
        (1, Transfer::Linear),
    ] {
        let mut own = picture(13, 9, 0);
        own.planes.truncate(planes);
        own.transfer = transfer;
        for (name, writing) in [
            ("a.exr", Writing::Exr),
            ("a.png", Writing::Png),
            ("a.tif", Writing::Tiff),
        ] {
            let file = folder.path().join(name);
            assert_eq!(Writing::of(&file), Some(writing));
            std::fs::write(&file, writing.bytes(own.clone()).unwrap()).unwrap();
            // The file itself says or implies what its values mean.
            let read = edges::photographs::photo::load_colour(&file, None).unwrap();
            assert_eq!(
                [read.width, read.height, read.planes.len()],
                [13, 9, planes]
            );
            assert!(writing == Writing::Exr || read.transfer == transfer);
            for (read, own) in read
                .planes
                .iter()
                .flatten()
                .zip(own.planes.iter().flatten())
            {
                // EXR is exact. Else half a code; the slope of light by sRGB is at most 2.28.
                let allowed = match (writing, transfer) {
                    (Writing::Exr, _) => 0.0,
                    (_, Transfer::Linear) => 0.5 / 65535.0 + 1e-6,
                    (_, Transfer::Srgb) => 2.3 * 0.5 / 255.0 + 1e-6,
                };
                assert!((read - own).abs() <= allowed, "{read} {own}");
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 3 * 7 * 13 * 9);
}

/// A JPEG is in sRGB whatever the source was: an even picture keeps its light.
#[test]
fn a_jpeg_shows_the_light_of_a_linear_picture() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.jpeg");
    for planes in [1, 3] {
        let light = [0.5_f32, 0.25, 0.125];
        let own = Picture {
            planes: light[..planes].iter().map(|&v| vec![v; 13 * 9]).collect(),
            ..picture(13, 9, 0)
        };
        std::fs::write(&file, Writing::Jpeg.bytes(own).unwrap()).unwrap();
        let read = edges::photographs::photo::load_colour(&file, None).unwrap();
        assert_eq!(read.planes.len(), planes);
        for (plane, light) in read.planes.iter().zip(light) {
            // Three roundings to 255 codes: of the value, of luma and of colour differences, which
            // count up to 1.8 times; the slope of light by sRGB is at most 2.28.
            let allowed = 2.28 * 0.5 * (1.0 + 1.0 + 1.8) / 255.0;
            assert!(plane.iter().all(|v| (v - light).abs() < allowed), "{light}");
        }
    }
}
