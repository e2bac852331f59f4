//! Mid-air images of pictures of every kind, made by the real program (`fit render`).
//!
//! Light must be conserved, and both forward models must agree.

use std::path::Path;

use fit::{Picture, Transfer, Writing, load_colour};
use image::{ImageBuffer, Luma, Rgb};
use serde_json::Value;
use tests::estimate::json;
use tests::files::{argument, bake_table};
use tests::program::fit;

const SIZE: [u32; 2] = [224, 192];

/// Black margin of the pictures, pixels.
///
/// It is wider than the blur: 64 pixels are 3.2 mm, the radial lobe ends 7.54 / a = 2 mm away, and
/// the ray shift stays below 0.5 mm. Blocks of JPEG are 8 x 8 pixels, so the margin of the JPEG is
/// black too.
const MARGIN: u32 = 64;

/// Returns the light of a pixel from 0 to 1; it is 0 in the margin.
fn content(x: u32, y: u32, channel: u32) -> f64 {
    let inside = |at: u32, size: u32| at >= MARGIN && at + MARGIN < size;
    if !inside(x, SIZE[0]) || !inside(y, SIZE[1]) {
        return 0.0;
    }
    f64::from((x * (3 + channel) + y * 7 + (x * y) % 13) % 64) / 63.0
}

/// Writes pictures in grey and colour, of 8 and 16 bits, and of floats up to 40 times white.
///
/// Returns the file names.
fn sources(folder: &Path) -> [&'static str; 4] {
    let [width, height] = SIZE;
    let code = |x, y, channel| (65_535.0 * content(x, y, channel)) as u16;
    let grey = ImageBuffer::from_fn(width, height, |x, y| Luma([code(x, y, 0)]));
    grey.save(folder.join("grey.png")).unwrap();
    let colour = ImageBuffer::from_fn(width, height, |x, y| Rgb([0, 1, 2].map(|k| code(x, y, k))));
    colour.save(folder.join("colour.png")).unwrap();
    let photo = ImageBuffer::from_fn(width, height, |x, y| {
        Rgb([0, 1, 2].map(|k| (code(x, y, k) / 257) as u8))
    });
    photo.save(folder.join("photo.jpg")).unwrap();
    let plane = |channel: u32| -> Vec<f32> {
        let pixels = (0..width * height).map(|i| content(i % width, i / width, channel));
        pixels.map(|light| 40.0 * light.powi(4) as f32).collect()
    };
    let bright = Picture {
        width: width as usize,
        height: height as usize,
        planes: vec![plane(0), plane(1), plane(2)],
        transfer: Transfer::Linear,
        warnings: Vec::new(),
    };
    std::fs::write(
        folder.join("bright.exr"),
        Writing::Exr.bytes(bright).unwrap(),
    )
    .unwrap();
    ["grey.png", "colour.png", "photo.jpg", "bright.exr"]
}

fn light(planes: &[Vec<f32>]) -> Vec<f64> {
    let sum = |plane: &Vec<f32>| plane.iter().map(|&v| f64::from(v)).sum();
    planes.iter().map(sum).collect()
}

#[test]
fn light_is_conserved_and_samples_scatter_about_the_transforms() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bake_table(here, "triangular", "10,25,40", "10");
    let manifest = argument("tests/captures/public_axes/captures.toml");
    let terms = "--kernel eq1 --shared a,mu -o sheet.json";
    let line = format!("estimate {manifest} --table {table} {terms}");
    fit(here, &line).done();
    let place = format!("--table {table} --distance 200 --incidence 25");
    let predicted = "predict sheet.json --frequency 0 --json";
    let predicted = fit(here, &format!("{predicted} {place}")).done();
    let predicted: Value = serde_json::from_str(&predicted).unwrap();
    let luminance = predicted["predictions"][0]["luminance"].as_f64().unwrap();
    // mu times eta, times T_h R_h = 0.25 of a half mirror that passes and reflects one half each.
    let mu = json(&here.join("sheet.json"))["mu"]["value"]
        .as_f64()
        .unwrap();
    let eta = tables::read(&here.join(&table)).unwrap();
    let eta = eta.direction(25.0, Some(10.0)).unwrap().retroreflected;
    assert!(
        (luminance / (mu * eta * 0.25) - 1.0).abs() < 1e-12,
        "{luminance}"
    );

    let sources = sources(here);
    let unsaid = "render --source colour.png --params sheet.json -o a.exr";
    let unsaid = fit(here, &format!("{unsaid} {place}"));
    assert!(
        unsaid.err.contains("give --transfer srgb"),
        "{}",
        unsaid.err
    );
    let mut cases = 0;
    for source in sources {
        let render = |to: &str, options: &str| {
            let files = format!("render --source {source} --params sheet.json -o {to} --json");
            // A colour file of 16 bits that does not say what they mean is warned of.
            let meaning: &str = match source {
                "colour.png" => "--transfer linear",
                _ => "",
            };
            let report = fit(here, &format!("{files} {place} {options} {meaning}")).done();
            let image = load_colour(&here.join(to), None).unwrap();
            (serde_json::from_str::<Value>(&report).unwrap(), image)
        };
        let (report, image) = render("image.exr", "");
        let energy = report["energy"][0].as_f64().unwrap();
        assert!(
            (energy / luminance - 1.0).abs() < 1e-12,
            "{energy} {luminance}"
        );
        let given = load_colour(&here.join(source), None).unwrap();
        assert_eq!(given.planes.len(), image.planes.len(), "{source}");
        for (given, seen) in light(&given.planes).iter().zip(light(&image.planes)) {
            // Light is conserved up to the rounding of the weights' sum in f32, as documented.
            let off = seen / (energy * given) - 1.0;
            println!("{source}: light {off:+.1e} off");
            assert!(off.abs() < 1e-5, "{source}: {off}");
            cases += 1;
        }

        let (report, sampled) = render("sampled.exr", "--forward render --samples 64");
        let error = report["sampling_error"].as_f64().unwrap();
        let pairs = image
            .planes
            .iter()
            .flatten()
            .zip(sampled.planes.iter().flatten());
        let squares: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
        let count = (image.planes.len() * image.planes[0].len()) as f64;
        let ratio = (squares / count).sqrt() / error;
        println!("{source}: samples are {ratio:.3} of their error off");
        // All pixels share 32,768 / 8 = 4,096 blocks of samples. The ratio of a mean square of n =
        // 4,096 errors to one that 8 randomisations estimate is known to sqrt(2/n + 2/7n). The root
        // of the ratio is known to half of that, 1.2 %. The limit is 4.5 times as large.
        assert!((ratio - 1.0).abs() < 0.054, "{source}: {ratio}");
        cases += 1;

        // The ambient light is added to every pixel, then the sum is multiplied by the exposure.
        // The contrast compares the image without ambient light to the ambient light.
        let (report, lit) = render("lit.exr", "--ambient 0.002 --exposure 3");
        for (own, lit) in image
            .planes
            .iter()
            .flatten()
            .zip(lit.planes.iter().flatten())
        {
            let expected = 3.0 * (f64::from(*own) + 0.002);
            // Three roundings of f32 are allowed.
            assert!(
                (f64::from(*lit) - expected).abs() <= 1.8e-7 * expected.abs(),
                "{lit} {expected}"
            );
        }
        let luminance: Vec<f64> = (0..image.planes[0].len())
            .map(|i| image.luminance(i).into())
            .collect();
        let mean = luminance.iter().sum::<f64>() / luminance.len() as f64;
        let peak = luminance.iter().copied().fold(0.0, f64::max);
        for (key, value) in [("mean", mean), ("peak", peak)] {
            let said = report["contrast"][key].as_f64().unwrap();
            // The luminances are f32, and so are their sums.
            assert!(
                (said / (value / 0.002) - 1.0).abs() < 1e-6,
                "{key}: {said} {value}"
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 1 + 3 * 3 + 4 + 2 * 4);
}

/// Under a blur of more pixels than are computed, a picture whose width is given gets fewer pixels.
///
/// The image is that of the picture with squares of 3 x 3 pixels made one, to the rounding of
/// 32-bit floats. A picture whose pixels are given is refused.
#[test]
fn a_picture_under_a_very_wide_blur_gets_fewer_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let [width, height] = [1000_u32, 400];
    let code = |x: u32, y: u32| ((x * 37 + y * 101) % 251 * 261) as u16;
    let fine = ImageBuffer::from_fn(width, height, |x, y| Luma([code(x, y)]));
    fine.save(here.join("fine.png")).unwrap();
    // 1000 = 333 x 3 + 1 and 400 = 133 x 3 + 1: the last squares are dark but for one line.
    let [columns, rows] = [334, 134];
    let mean = |place: usize| {
        let (x, y) = (place % columns * 3, place / columns * 3);
        let inside = |&(x, y): &(usize, usize)| x < 1000 && y < 400;
        let square = (0..9).map(|k| (x + k % 3, y + k / 3)).filter(inside);
        let sum: f64 = square
            .map(|(x, y)| f64::from(code(x as u32, y as u32)) / 65_535.0)
            .sum();
        (sum / 9.0) as f32
    };
    let coarse = Picture {
        width: columns,
        height: rows,
        planes: vec![(0..columns * rows).map(mean).collect()],
        transfer: Transfer::Linear,
        warnings: Vec::new(),
    };
    std::fs::write(
        here.join("coarse.exr"),
        Writing::Exr.bytes(coarse.clone()).unwrap(),
    )
    .unwrap();
    let render = |source: &str, size: &str, to: &str| {
        let place = format!("--distance 3000 --incidence 20 --json -o {to}");
        let sheet = format!("render --sheet prism-0.1 --transfer linear --source {source}");
        fit(here, &format!("{sheet} {size} {place}"))
    };
    let reduced = render("fine.png", "--width 200", "reduced.exr");
    assert!(
        reduced
            .err
            .contains("was reduced from 1000 x 400 to 334 x 134 pixels of 0.600 mm"),
        "{}",
        reduced.err
    );
    let facts: Value = serde_json::from_str(&reduced.out).unwrap();
    assert_eq!(
        (&facts["width"], &facts["height"]),
        (&334.into(), &134.into())
    );
    assert_eq!(
        facts["pixel_pitch_mm"]
            .as_f64()
            .map(|mm| (mm * 1e9).round()),
        Some(6e8)
    );
    render("coarse.exr", "--pixel-pitch 0.6", "by-hand.exr");
    let [own, by_hand] = ["reduced.exr", "by-hand.exr"].map(|file| {
        let image = load_colour(&here.join(file), None).unwrap();
        image.planes.into_iter().next().unwrap()
    });
    let brightest = by_hand.iter().copied().fold(0.0, f32::max);
    assert!(brightest > 1e-3 && own.len() == columns * rows);
    for (own, by_hand) in own.iter().zip(&by_hand) {
        assert!((own - by_hand).abs() <= 1e-6 * brightest, "{own} {by_hand}");
    }
    // This blur is wider than the picture: the light that is not in the image is said.
    let light = |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>();
    let energy = facts["energy"][0].as_f64().unwrap();
    let lost = 1.0 - light(&own) / (energy * light(&coarse.planes[0]));
    let said = format!("{:.0} % of the light falls beyond the rim", 100.0 * lost);
    assert!(
        lost > 0.05 && reduced.err.contains(&said),
        "{said}: {}",
        reduced.err
    );
    let refused = render("fine.png", "--pixel-pitch 0.2", "none.exr");
    assert_eq!(refused.code, Some(1));
    assert!(
        refused
            .err
            .contains("give the size of the picture as --width")
    );
    assert!(!here.join("none.exr").exists());
    // A width that was exchanged with the distance is said.
    let exchanged = render("coarse.exr", "--width 9100", "exchanged.exr");
    assert!(
        exchanged.err.contains("exchange --width and --distance"),
        "{}",
        exchanged.err
    );
}
