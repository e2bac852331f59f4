//! Mid-air images against sums over every pair of pixels, closed forms and each other.

mod planted;

use fit::kernel::Kernel;
use fit::lobe::Shape;
use fit::photo::{Picture, Transfer, Writing};
use fit::render::psf::{Fault, Psf};
use fit::render::sampled::{self, Sampled};
use fit::render::tiles::Tiles;
use fit::render::transform::Convolver;
use fit::render::view::{self, View};
use fit::render::{self, Scale};
use fit::report::{ResultFile, TableResult};
use fit::sample::Sequence;
use fit::sampled::Sampling;
use fit::sheet::Fitted;
use fit::spot::{Error, Place, Sampler, Sheet, Spot, TAIL};
use num_complex::Complex64;
use planted::{Stream, table, truth};
use serde_json::json;
use tables::Table;

/// A spot that is an even square of a width in mm.
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

/// Squares whose width is the distance in mm, and whose energy falls with the incidence.
struct Squares;

impl Sheet for Squares {
    fn spot(&self, place: &Place, _: f64) -> Result<Box<dyn Spot + '_>, Error> {
        Ok(Box::new(Square {
            width: place.r_mm,
            energy: 1.0 / (1.0 + place.incidence_deg),
        }))
    }
}

fn place(r_mm: f64, incidence_deg: f64) -> Place {
    Place {
        incidence_deg,
        azimuth_deg: Some(20.0),
        r_mm,
    }
}

const PIXELS: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];

/// Numbers in 0..1, dark within `margin` of the frame.
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

/// The weights gathered over all pairs of pixels.
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
    // Integral from -inf of the triangle of width 2: its mean over [d - w/2, d + w/2] is the weight along one axis.
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
            // An error of the transfer everywhere is at most as large in every weight.
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
        // Wider than the smallest picture, too.
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

fn result(kernel: &str, lobe: Option<&str>, table: &Table) -> ResultFile {
    let number = |value: f64| json!({"value": value, "standard_error": 0.001});
    serde_json::from_value(json!({
        "kernel": kernel, "lobe": lobe, "loss": "edge", "iterations": 1, "stop": "small step", "seconds": 0.1,
        "wavelength_nm": (kernel == "wave").then_some("550"),
        "c_mm": (kernel != "lobe").then(|| number(0.24)),
        "a_per_mm": matches!(kernel, "eq1" | "lobe").then(|| number(4.9)),
        "a_times_r": (kernel == "angular").then(|| number(735.0)),
        "mu": number(0.25),
        "covariance": {"names": [], "matrix": []}, "bounds": {}, "candidates": [], "captures": [],
        "camera": {"pixel_pitch_mm": 0.08, "lens_blur_mm": null, "lens_exponent": null},
        "half_mirror": 0.25, "table": serde_json::to_value(TableResult::of(table)).unwrap(), "warnings": []
    }))
    .unwrap()
}

#[test]
fn energy_is_kept_by_every_kernel() {
    let truth = truth(Kernel::Eq1, Shape::Radial, 4.9, 0.24, 0.25);
    let table = table(&truth, &[0.0, 20.0], 20.0);
    let source = picture(240, 200, 60);
    let sum = |plane: &[f32]| plane.iter().map(|&v| f64::from(v)).sum::<f64>();
    let scale = Scale {
        pitch_mm: 0.08,
        tangential_axis_deg: 30.0,
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
        let psf = render::uniform_psf(&sheet, &place(150.0, 20.0), &scale).unwrap();
        let energy = psf.energy.unwrap();
        let eta = table.direction(20.0, Some(20.0)).unwrap().eta;
        assert!((energy - 0.25 * 0.25 * eta).abs() < 1e-12);
        assert!(psf.error <= 1e-4, "{kernel}: {}", psf.error);
        let total: f64 = psf.weights.iter().map(|&w| f64::from(w)).sum();
        // 1e5 weights, each rounded to 6e-8 of itself, and the transform's own rounding.
        assert!((total - 1.0).abs() < 1e-5, "{kernel}: {total}");
        let image = render::uniform(&source, &psf);
        for (plane, own) in image.planes.iter().zip(&source.planes) {
            let kept = sum(plane) / (energy * sum(own));
            // The tails of both axes may leave the frame; 60 pixels are 4.8 mm, where 2 % of a separable lobe lie outside.
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
            render::uniform(&source, &psf)
        })
    };
    let (one, three) = (render(1), render(3));
    assert_eq!(one.planes.len(), 3);
    for writing in [Writing::Exr, Writing::Png] {
        let bytes = |image: &Picture| image.clone().encode(writing).unwrap();
        assert_eq!(bytes(&one), bytes(&three));
    }
}

#[test]
fn tiles_meet_every_pixels_own_weights() {
    let size = [48, 30];
    let source = picture(size[0], size[1], 0);
    // Both the width and the energy change across the picture.
    let at = |[x, y]: [f64; 2]| -> Result<Psf, Fault> {
        Psf::new(&Squares, &place(3.0 + 0.05 * x, 0.01 * y), PIXELS)
    };
    let tolerance = 0.01;
    let tiles = Tiles::new(size, tolerance, at).unwrap();
    assert!(
        tiles.error <= tolerance && tiles.counts()[0] > 1,
        "{:?}",
        tiles.counts()
    );
    let images = tiles.render(&source.planes, size);
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

/// Root mean square difference of two images.
fn distance(image: &Picture, other: &Picture) -> f64 {
    let both = image.planes.iter().zip(&other.planes);
    let values: Vec<f64> = both
        .flat_map(|(plane, other)| {
            plane
                .iter()
                .zip(other)
                .map(|(a, b)| f64::from(a - b).powi(2))
        })
        .collect();
    (values.iter().sum::<f64>() / values.len() as f64).sqrt()
}

fn sampling(samples: usize, sequence: Sequence) -> Sampling {
    Sampling {
        samples,
        seed: 3,
        sequence,
    }
}

#[test]
fn samples_meet_the_transforms_within_their_error() {
    let truth = truth(Kernel::Eq1, Shape::Radial, 4.9, 0.24, 0.25);
    let table = table(&truth, &[0.0, 20.0], 20.0);
    let scale = Scale {
        pitch_mm: 0.08,
        tangential_axis_deg: 30.0,
    };
    // The image of a point is the spot itself.
    let (width, height) = (81, 61);
    let mut point = picture(width, height, 0);
    for plane in &mut point.planes {
        plane.fill(0.0);
        plane[(height / 2) * width + width / 2] = 1.0;
    }
    let mut cases = 0;
    for (kernel, lobe) in [
        ("eq1", Some("radial")),
        ("eq1", Some("separable")),
        ("angular", Some("radial")),
        ("shift", None),
        ("lobe", Some("radial")),
    ] {
        let result = result(kernel, lobe, &table);
        let sheet = Fitted::new(&result, &table).unwrap();
        let place = place(150.0, 20.0);
        let psf = render::uniform_psf(&sheet, &place, &scale).unwrap();
        for source in [&point, &picture(width, height, 8)] {
            let spectral = render::uniform(source, &psf);
            for sequence in [Sequence::Sobol, Sequence::Independent] {
                let Sampled {
                    image,
                    standard_error,
                    seen,
                } = sampled::uniform(source, &sheet, &place, &scale, sampling(256, sequence))
                    .unwrap();
                let error = standard_error.unwrap();
                let distance = distance(&image, &spectral);
                // Pixels whose errors count: of a point those that it lights (their variance is as their light), of a picture
                // the blocks of samples that they share, 32,768 samples by 32. The mean square of n errors is known to
                // sqrt(2/n), the error from 8 randomisations to sqrt(2/7n); half of that for the roots.
                let counting = if std::ptr::eq(source, &point) {
                    let light = || spectral.planes[0].iter().map(|&v| f64::from(v.abs()));
                    light().sum::<f64>().powi(2) / light().map(|v| v * v).sum::<f64>()
                } else {
                    1024.0
                };
                let scatter = 0.5 * (2.0 / counting + 2.0 / (7.0 * counting)).sqrt();
                let own = psf.error * psf.energy.unwrap();
                assert!(
                    (distance / error.hypot(own) - 1.0).abs() < 4.0 * scatter,
                    "{kernel} {lobe:?} {sequence:?}: {distance} against {error}"
                );
                assert_eq!(seen[0].energy, psf.energy);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 20);
    let wave = result("wave", None, &table);
    let sheet = Fitted::new(&wave, &table).unwrap();
    let refused = sampled::uniform(
        &point,
        &sheet,
        &place(150.0, 20.0),
        &scale,
        sampling(8, Sequence::Sobol),
    );
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("use --forward spectral"), "{message}");
}

#[test]
fn samples_of_a_view_meet_its_tiles() {
    let source = picture(40, 30, 0);
    let view = load(&view(400.0, 20.0, false)).unwrap();
    let tolerance = 0.002;
    let (tiled, _) = render::viewed(&source, &Millimetre, &view, 1.0, tolerance).unwrap();
    let sampled = sampled::viewed(
        &source,
        &Millimetre,
        &view,
        1.0,
        sampling(512, Sequence::Sobol),
    )
    .unwrap();
    let error = sampled.standard_error.unwrap();
    let energy = sampled
        .seen
        .iter()
        .map(|seen| seen.energy.unwrap())
        .fold(0.0, f64::max);
    let distance = distance(&sampled.image, &tiled);
    // 1,200 pixels of three planes, each with samples of its own: its root mean square is known to 2 %.
    assert!(
        distance < 1.1 * error + tolerance * energy,
        "{distance} against {error}"
    );
    assert_eq!(sampled.seen.len(), 40 * 30);
}

/// A square away from the point, so that neither the sign nor the turn of a spot can be wrong unseen.
struct Displaced(Square);

const AWAY_MM: [f64; 2] = [0.3, -0.7];

impl Spot for Displaced {
    fn energy(&self) -> Option<f64> {
        self.0.energy()
    }
    fn otf(&self, f: [f64; 2]) -> Complex64 {
        let turn = -std::f64::consts::TAU * (f[0] * AWAY_MM[0] + f[1] * AWAY_MM[1]);
        self.0.otf(f) * Complex64::from_polar(1.0, turn)
    }
    fn reach_mm(&self) -> f64 {
        self.0.reach_mm() + 0.7
    }
    fn samples(&self) -> Option<Box<Sampler<'_>>> {
        let square = self.0.samples()?;
        Some(Box::new(move |point| {
            let at = square(point);
            [at[0] + AWAY_MM[0], at[1] + AWAY_MM[1]]
        }))
    }
}

/// Squares of half a millimetre and more the farther they are, energy falling with the incidence.
struct Millimetre;

impl Sheet for Millimetre {
    fn spot(&self, place: &Place, _: f64) -> Result<Box<dyn Spot + '_>, Error> {
        Ok(Box::new(Displaced(Square {
            width: place.r_mm / 600.0,
            energy: 1.0 / (1.0 + place.incidence_deg),
        })))
    }
}

fn load(text: &str) -> Result<View, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("view.toml");
    std::fs::write(&file, text).unwrap();
    View::load(&file).map_err(|error| error.to_string())
}

/// The camera `far` before the image, the sheet 300 mm behind it and turned.
fn view(far: f64, turn_deg: f64, mirror: bool) -> String {
    let (sine, cosine) = turn_deg.to_radians().sin_cos();
    format!(
        "[camera]\nposition_mm = [0, 0, {far}]\n\
         [image]\ncentre_mm = [0, 0, 0]\nright = [1, 0, 0]\ndown = [0, -1, 0]\npixel_pitch_mm = 0.1\n\
         [sheet]\nposition_mm = [0, 0, -300]\nnormal = [{}, 0, {cosine}]\nfirst_edge = [0, 1, 0]\n\
         seen_in_mirror = {mirror}\n[coating]\nrefractive_index = 1.5\n",
        sine
    )
}

#[test]
fn a_far_camera_sees_the_uniform_scene() {
    let mut cases = 0;
    for mirror in [false, true] {
        let view = load(&view(1e7, 20.0, mirror)).unwrap();
        assert_eq!(view.coating, Some(1.5));
        for at in [[0.0, 0.0], [200.0, -100.0], [-300.0, 150.0]] {
            let seen = view.at(at).unwrap();
            // 30 mm of 1e7 turn the ray by 3e-6 rad.
            assert!((seen.place.incidence_deg - 20.0).abs() < 3e-4);
            // The sheet falls back on the side that its normal leans to.
            let r_mm = 300.0 + 0.1 * at[0] * 20.0_f64.to_radians().tan();
            assert!(
                (seen.place.r_mm - r_mm).abs() < 0.01,
                "{:?} {r_mm}",
                seen.place
            );
            // Along the picture's columns, 90 degrees to the first edge, which points up.
            let azimuth = if mirror { 90.0 } else { -90.0 };
            assert!(
                (seen.place.azimuth_deg.unwrap() - azimuth).abs() < 1e-3,
                "{:?}",
                seen.place
            );
            let [[a, b], [c, d]] = seen.pixels_from_mm;
            // Sagittal: downwards as in the photographs where the sheet is seen in the mirror.
            let down = if mirror { 10.0 } else { -10.0 };
            for (value, expected) in [(a, 10.0), (b, 0.0), (c, 0.0), (d, down)] {
                assert!((value - expected).abs() < 1e-3, "{:?}", seen.pixels_from_mm);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 24);
}

#[test]
fn a_near_camera_sees_what_trigonometry_says() {
    // A sheet that faces the camera: the incidence is the ray's own angle, the mirrored picture twice as far behind.
    let view = load(&view(600.0, 0.0, false)).unwrap();
    let mut cases = 0;
    for x in [-1500.0, -10.0, 700.0] {
        let seen = view.at([x, 0.0]).unwrap();
        let tangent = 0.1 * x / 600.0_f64;
        assert!((seen.place.incidence_deg.to_radians().tan() - tangent.abs()).abs() < 1e-9);
        assert!((seen.place.r_mm - 300.0 * tangent.hypot(1.0)).abs() < 1e-9);
        // Carried to the image's plane, the plane across the ray is stretched by 1/cos along the incidence.
        let stretch = 10.0 * tangent.hypot(1.0) * x.signum();
        assert!(
            (seen.pixels_from_mm[0][0] - stretch).abs() < 1e-9,
            "{:?}",
            seen.pixels_from_mm
        );
        // From the camera to the sheet 900 mm, and back to the image 300.
        let mirrored = seen.mirrored.unwrap();
        assert!(
            (mirrored[0] - x * 1200.0 / 600.0).abs() < 1e-6,
            "{mirrored:?}"
        );
        cases += 1;
    }
    assert_eq!(cases, 3);
    assert!((view::fresnel(1.5, 0.0) - 0.04).abs() < 1e-15);
    // At Brewster's angle only half of the light is reflected at all: sin^2(i - t)/2 with i + t = 90 degrees.
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
        for (name, writing) in [("a.exr", Writing::Exr), ("a.png", Writing::Png)] {
            let file = folder.path().join(name);
            assert_eq!(Writing::of(&file), Some(writing));
            std::fs::write(&file, own.clone().encode(writing).unwrap()).unwrap();
            let read = fit::photo::load_colour(&file, Some(transfer)).unwrap();
            assert_eq!(
                [read.width, read.height, read.planes.len()],
                [13, 9, planes]
            );
            for (read, own) in read
                .planes
                .iter()
                .flatten()
                .zip(own.planes.iter().flatten())
            {
                // Half a code of 65535, where sRGB is steepest 2.28 times that in light; EXR as it is.
                let allowed = if writing == Writing::Exr {
                    0.0
                } else {
                    2.3 * 0.5 / 65535.0 + 1e-6
                };
                assert!((read - own).abs() <= allowed, "{read} {own}");
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 2 * 7 * 13 * 9);
}
