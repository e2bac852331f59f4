//! Tests that every format, sample type and channel gives the light that was written, and that
//! damaged files never cause a panic.

use std::path::{Path, PathBuf};

use crate::photographs::photo;
use crate::photographs::photo::channel::{Channel, Decode};
use crate::photographs::photo::transfer::Transfer;
use exr::prelude::*;
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb, Rgba};

const WIDTH: usize = 37;
const HEIGHT: usize = 23;

/// A ramp with structure in both directions, in [0, 1).
fn value(x: usize, y: usize) -> f32 {
    ((x * 7 + y * 11) % 97) as f32 / 100.0
}

fn plane(scale: f32) -> Vec<f32> {
    (0..WIDTH * HEIGHT)
        .map(|i| scale * value(i % WIDTH, i / WIDTH))
        .collect()
}

fn write_exr(
    file: &Path,
    channels: Vec<(&str, FlatSamples)>,
    encoding: Encoding,
    position: Vec2<i32>,
) {
    let list = channels
        .into_iter()
        .map(|(name, samples)| AnyChannel::new(name, samples))
        .collect();
    let attributes = LayerAttributes::default().with_position(position);
    let layer = Layer::new(
        (WIDTH, HEIGHT),
        attributes,
        encoding,
        AnyChannels::sort(list),
    );
    Image::from_layer(layer).write().to_file(file).unwrap();
}

fn assert_light(file: &Path, options: &Decode, expected: impl Fn(f32) -> f32, tolerance: f32) {
    let photo = photo::load(file, options).unwrap();
    assert_eq!(
        (photo.width, photo.height),
        (WIDTH, HEIGHT),
        "{}",
        file.display()
    );
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let (found, wanted) = (photo.at(x, y).unwrap(), expected(value(x, y)));
            assert!(
                (found - wanted).abs() <= tolerance,
                "{} ({x}, {y}): {found}, not {wanted}",
                file.display()
            );
        }
    }
    assert_eq!(photo.at(WIDTH, 0), None);
}

fn of(channel: Channel) -> Decode {
    Decode {
        transfer: None,
        channel,
    }
}

fn by(transfer: Transfer) -> Decode {
    Decode {
        transfer: Some(transfer),
        channel: Channel::Luminance,
    }
}

#[test]
fn exr_sample_types_encodings_and_windows() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.exr");
    let encodings = [
        Encoding::UNCOMPRESSED,
        Encoding::FAST_LOSSLESS,
        Encoding::SMALL_LOSSLESS,
    ];
    let mut cases = 0;
    for encoding in encodings {
        for position in [Vec2(0, 0), Vec2(-5, 12)] {
            // Float samples come back bit for bit, halves to half a unit of their 11 bits, integers
            // exactly.
            write_exr(
                &file,
                vec![("Y", FlatSamples::F32(plane(1.0)))],
                encoding,
                position,
            );
            assert_light(&file, &Decode::default(), |v| v, 0.0);
            let half = plane(1.0).into_iter().map(f16::from_f32).collect();
            write_exr(
                &file,
                vec![("Y", FlatSamples::F16(half))],
                encoding,
                position,
            );
            assert_light(&file, &Decode::default(), |v| v, 2.5e-4);
            let whole = plane(100.0).into_iter().map(|v| v.round() as u32).collect();
            write_exr(
                &file,
                vec![("Y", FlatSamples::U32(whole))],
                encoding,
                position,
            );
            assert_light(&file, &Decode::default(), |v| (100.0 * v).round(), 0.0);
            cases += 3;
        }
    }
    assert_eq!(cases, 18);
}

#[test]
fn exr_channels_and_layers() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.exr");
    let float = |scale| FlatSamples::F32(plane(scale));
    let colour = vec![
        ("R", float(1.0)),
        ("G", float(2.0)),
        ("B", float(4.0)),
        ("A", float(1.0)),
    ];
    write_exr(&file, colour, Encoding::SMALL_LOSSLESS, Vec2(0, 0));
    let luminance = 0.2126 + 2.0 * 0.7152 + 4.0 * 0.0722;
    let wanted = [
        (Channel::Luminance, luminance),
        (Channel::Red, 1.0),
        (Channel::Green, 2.0),
        (Channel::Blue, 4.0),
        (Channel::Named("B".to_owned()), 4.0),
    ];
    for (channel, scale) in &wanted {
        // The tolerance is that of three products and two sums in f32.
        assert_light(&file, &of(channel.clone()), |v| scale * v, 1e-6);
    }
    let photo = photo::load(&file, &Decode::default()).unwrap();
    assert!(
        photo
            .warnings
            .iter()
            .any(|text| text.contains("alpha channel")),
        "{:?}",
        photo.warnings
    );

    let layered = vec![
        ("one.R", float(1.0)),
        ("one.G", float(1.0)),
        ("one.B", float(1.0)),
        ("two.Y", float(3.0)),
    ];
    write_exr(&file, layered, Encoding::SMALL_LOSSLESS, Vec2(0, 0));
    assert_light(&file, &Decode::default(), |v| v, 1e-6);
    let photo = photo::load(&file, &Decode::default()).unwrap();
    assert!(
        photo.warnings[0].contains("2 layers hold a picture; one was used"),
        "{:?}",
        photo.warnings
    );
    let named = of(Channel::from_name("two.Y"));
    assert_light(&file, &named, |v| 3.0 * v, 0.0);
    assert_eq!(wanted.len(), 5);
}

/// An EXR of luminance and colour differences, as its own primaries define them, has the colours
/// that were written. The weights of BT.2020 are those of ITU-R BT.2020-2, table 4, which rounds
/// them to 5e-5: green is off by that over 0.678, twice, and f32 rounds by less.
#[test]
fn exr_of_luma_and_differences_has_colours() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.exr");
    let bt2020 = exr::meta::attribute::Chromaticities {
        red: Vec2(0.708, 0.292),
        green: Vec2(0.170, 0.797),
        blue: Vec2(0.131, 0.046),
        white: Vec2(0.3127, 0.3290),
    };
    let cases = [
        (None, [0.2126, 0.7152, 0.0722], 1e-5),
        (Some(bt2020), [0.2627, 0.6780, 0.0593], 1.5e-4),
    ];
    let rgb = |v: f32| [0.2 + v, 0.9 - 0.5 * v, 0.1 + 0.7 * v];
    let mut count = 0;
    for (primaries, weights, tolerance) in cases {
        let luma = |v: f32| -> f32 { rgb(v).iter().zip(weights).map(|(c, w)| c * w).sum() };
        let of = |light: &dyn Fn(f32) -> f32| {
            FlatSamples::F32(plane(1.0).into_iter().map(light).collect())
        };
        let channels = [
            ("Y", of(&luma)),
            ("RY", of(&|v| (rgb(v)[0] - luma(v)) / luma(v))),
            ("BY", of(&|v| (rgb(v)[2] - luma(v)) / luma(v))),
        ];
        let channels = channels
            .into_iter()
            .map(|(name, samples)| AnyChannel::new(name, samples));
        let layer = Layer::new(
            (WIDTH, HEIGHT),
            LayerAttributes::default(),
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort(channels.collect()),
        );
        let mut picture = Image::from_layer(layer);
        picture.attributes.chromaticities = primaries;
        picture.write().to_file(&file).unwrap();
        let picture = photo::load_colour(&file, None).unwrap();
        assert_eq!(picture.planes.len(), 3);
        for (k, plane) in picture.planes.iter().enumerate() {
            for (i, found) in plane.iter().enumerate() {
                let wanted = rgb(value(i % WIDTH, i / WIDTH))[k];
                assert!(
                    (found - wanted).abs() < tolerance,
                    "{weights:?} {k} {i}: {found} {wanted}"
                );
                count += 1;
            }
        }
        assert_light(&file, &Decode::default(), luma, 1e-6);
    }
    assert_eq!(count, 2 * 3 * WIDTH * HEIGHT);
    // Differences for every second pixel are told: the decoder does not read them. The sampling is
    // the last part of a channel's entry.
    let mut bytes = std::fs::read(&file).unwrap();
    let at = bytes.windows(3).position(|name| name == b"BY\0").unwrap() + 3 + 8;
    bytes[at] = 2;
    bytes[at + 4] = 2;
    std::fs::write(&file, bytes).unwrap();
    let error = photo::load_colour(&file, None).unwrap_err().to_string();
    assert!(
        error.contains("save it as an EXR of scan lines that has R, G and B"),
        "{error}"
    );
}

fn save(
    folder: &Path,
    name: &str,
    picture: impl Into<DynamicImage>,
    format: ImageFormat,
) -> PathBuf {
    let file = folder.join(name);
    picture.into().save_with_format(&file, format).unwrap();
    file
}

#[test]
fn integer_formats() {
    let folder = tempfile::tempdir().unwrap();
    let at = |x: u32, y: u32| value(x as usize, y as usize);
    let word = |v: f32| (v * 65535.0).round() as u16;
    let byte = |v: f32| (v * 255.0).round() as u8;
    let size = (WIDTH as u32, HEIGHT as u32);
    let grey16 = ImageBuffer::from_fn(size.0, size.1, |x, y| Luma([word(at(x, y))]));
    let greya16 = ImageBuffer::from_fn(size.0, size.1, |x, y| LumaA([word(at(x, y)), 9]));
    let rgb16 = ImageBuffer::from_fn(size.0, size.1, |x, y| {
        Rgb([word(at(x, y)), 0, word(0.5 * at(x, y))])
    });
    let grey8 = ImageBuffer::from_fn(size.0, size.1, |x, y| Luma([byte(at(x, y))]));
    let rgba8 = ImageBuffer::from_fn(size.0, size.1, |x, y| {
        Rgba([byte(at(x, y)), byte(at(x, y)), byte(at(x, y)), 7])
    });
    let (plain, half_step) = (Decode::default(), 0.5 / 65535.0 + 1e-7);
    let srgb = |v: f32| Transfer::Srgb.to_linear(byte(v) as f32 / 255.0);
    let mut cases = 0;
    for format in [ImageFormat::Png, ImageFormat::Tiff] {
        let grey = save(folder.path(), "grey16.x", grey16.clone(), format);
        assert_light(&grey, &plain, |v| v, half_step);
        let encoded = by(Transfer::Srgb);
        // The slope of the sRGB curve is at most 2.3.
        assert_light(
            &grey,
            &encoded,
            |v| Transfer::Srgb.to_linear(v),
            2.3 * half_step,
        );
        let colour = save(folder.path(), "rgb16.x", rgb16.clone(), format);
        assert_light(&colour, &plain, |v| (0.2126 + 0.5 * 0.0722) * v, half_step);
        assert_light(&colour, &of(Channel::Blue), |v| 0.5 * v, half_step);
        let grey = save(folder.path(), "grey8.x", grey8.clone(), format);
        assert_light(&grey, &plain, srgb, 1e-6);
        let warnings = photo::load(&grey, &plain).unwrap().warnings;
        assert!(
            warnings[0].contains("in spite of its name") && warnings[1].contains("8-bit"),
            "{warnings:?}"
        );
        let linear = by(Transfer::Linear);
        assert_light(&grey, &linear, |v| byte(v) as f32 / 255.0, 1e-6);
        assert_light(
            &save(folder.path(), "rgba8.x", rgba8.clone(), format),
            &plain,
            srgb,
            1e-6,
        );
        cases += 7;
    }
    // Only PNG can be written with grey and alpha here.
    let transparent = save(folder.path(), "greya16.x", greya16, ImageFormat::Png);
    assert_light(&transparent, &plain, |v| v, half_step);
    // JPEG is lossy. In a constant picture only the rounding of its colour conversion is left, one
    // code of 255.
    let flat = ImageBuffer::from_fn(64, 48, |_, _| Luma([100_u8]));
    let photo = photo::load(
        &save(folder.path(), "flat.jpg", flat, ImageFormat::Jpeg),
        &plain,
    )
    .unwrap();
    let step = Transfer::Srgb.to_linear(101.0 / 255.0) - Transfer::Srgb.to_linear(100.0 / 255.0);
    assert!(
        photo
            .luminance
            .iter()
            .all(|v| (v - Transfer::Srgb.to_linear(100.0 / 255.0)).abs() <= step)
    );
    assert_eq!((photo.width, photo.height, cases), (64, 48, 14));
}

/// A picture whose pixels are half transparent gives the light of its codes times alpha, once: of
/// 8 bits 128/255, of 16 bits 32768/65535.
#[test]
fn alpha_takes_its_part_of_the_light_once() {
    let folder = tempfile::tempdir().unwrap();
    let size = (WIDTH as u32, HEIGHT as u32);
    let code = |x: u32, y: u32| ((x * 7 + y * 11) % 250) as u8;
    let rgba8 = ImageBuffer::from_fn(size.0, size.1, |x, y| {
        Rgba([code(x, y), 255, code(y, x), 128])
    });
    let rgba16 = ImageBuffer::from_fn(size.0, size.1, |x, y| {
        Rgba([code(x, y), 255, code(y, x), 128].map(|v| u16::from(v) << 8))
    });
    let greya8 = ImageBuffer::from_fn(size.0, size.1, |x, y| LumaA([code(x, y), 128]));
    let folder = folder.path();
    let cases: [(PathBuf, f32, f32); 3] = [
        (save(folder, "8.png", rgba8, ImageFormat::Png), 255.0, 1.0),
        (
            save(folder, "16.png", rgba16, ImageFormat::Png),
            65535.0,
            256.0,
        ),
        (
            save(folder, "grey.png", greya8, ImageFormat::Png),
            255.0,
            1.0,
        ),
    ];
    for (file, full, step) in &cases {
        for transfer in [Transfer::Linear, Transfer::Srgb] {
            let read = crate::photographs::load_colour(file, Some(transfer)).unwrap();
            for (k, plane) in read.planes.iter().enumerate() {
                for (i, &found) in plane.iter().enumerate() {
                    let (x, y) = ((i % WIDTH) as u32, (i / WIDTH) as u32);
                    let own = [code(x, y), 255, code(y, x)][k];
                    let light = transfer.to_linear(f32::from(own) * step / full);
                    let expected = light * 128.0 * step / full;
                    assert!(
                        (found - expected).abs() < 1e-6,
                        "{k} {x} {y}: {found} {expected}"
                    );
                }
            }
            let said = read
                .warnings
                .iter()
                .filter(|said| said.contains("transparent"));
            assert_eq!(said.count(), 1);
        }
    }
    assert_eq!(cases.len(), 3);
}

#[test]
fn saturated_pixels_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let red = ImageBuffer::from_fn(20, 10, |x, y| {
        Rgb([if x < 3 && y < 2 { 255_u8 } else { 200 }, 100, 100])
    });
    let file = save(folder.path(), "red.png", red, ImageFormat::Png);
    let count = |channel| photo::load(&file, &of(channel)).unwrap().clipped();
    // Red is saturated in 6 pixels, green in none.
    assert_eq!(
        [
            count(Channel::Luminance),
            count(Channel::Red),
            count(Channel::Green)
        ],
        [6, 6, 0]
    );
    let mut sensor = plane(1.0);
    sensor[..5].fill(1.0);
    let file = folder.path().join("clipped.exr");
    write_exr(
        &file,
        vec![("Y", FlatSamples::F32(sensor))],
        Encoding::SMALL_LOSSLESS,
        Vec2(0, 0),
    );
    assert_eq!(photo::load(&file, &Decode::default()).unwrap().clipped(), 5);
}

#[test]
fn damaged_files_are_errors_or_finite_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let exr = folder.path().join("a.exr");
    write_exr(
        &exr,
        vec![("Y", FlatSamples::F32(plane(1.0)))],
        Encoding::SMALL_LOSSLESS,
        Vec2(0, 0),
    );
    let grey = ImageBuffer::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
        Luma([((x * 7 + y * 11) % 200) as u8])
    });
    let files = [
        exr,
        save(folder.path(), "a.png", grey.clone(), ImageFormat::Png),
        save(folder.path(), "a.tif", grey.clone(), ImageFormat::Tiff),
        save(folder.path(), "a.jpg", grey, ImageFormat::Jpeg),
    ];
    let (mut cases, mut refused) = (0, 0);
    for file in files {
        let whole = std::fs::read(&file).unwrap();
        let mut check = |bytes: &[u8]| {
            std::fs::write(&file, bytes).unwrap();
            match photo::load(&file, &Decode::default()) {
                Ok(photo) => assert!(photo.luminance.iter().all(|v| v.is_finite())),
                Err(error) => {
                    refused += 1;
                    assert!(
                        error.to_string().starts_with(&file.display().to_string()),
                        "{error}"
                    );
                }
            }
            cases += 1;
        };
        for length in (0..whole.len()).step_by(1 + whole.len() / 120) {
            check(&whole[..length]);
        }
        for at in (0..whole.len()).step_by(1 + whole.len() / 240) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x41;
            check(&bytes);
        }
    }
    println!("{cases} damaged files, {refused} refused");
    assert!(cases > 1000 && refused > cases / 3, "{cases} {refused}");
}
