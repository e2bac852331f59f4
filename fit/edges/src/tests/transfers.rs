//! Tests of the relation between stored values and light: which part of a file names it, and what
//! the curves give. Chunks and profiles are written here byte by byte, after the standards.

use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageBuffer, ImageEncoder, Luma, Rgb};

use crate::photographs::photo;
use crate::photographs::photo::channel::{Channel, Decode};
use crate::photographs::photo::transfer::Transfer;
use crate::photographs::{Estimator, crossing, measure};
use crate::tests::photographs as edges;

/// A curve: light of a stored value.
type Light = fn(f64) -> f64;

fn linear(v: f64) -> f64 {
    v
}

/// IEC 61966-2-1.
fn srgb(v: f64) -> f64 {
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// The inverse of ITU-R BT.709-6, item 1.2.
fn bt709(v: f64) -> f64 {
    if v < 0.081 {
        v / 4.5
    } else {
        ((v + 0.099) / 1.099).powf(1.0 / 0.45)
    }
}

fn power22(v: f64) -> f64 {
    v.powf(2.2)
}

fn power28(v: f64) -> f64 {
    v.powf(2.8)
}

/// CRC of ISO 3309, as PNG has it.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            (sum >> 1) ^ (0xedb8_8320 * (sum & 1))
        })
    })
}

fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let named = [name, data].concat();
    let length = (data.len() as u32).to_be_bytes();
    [&length[..], &named, &crc(&named).to_be_bytes()].concat()
}

/// A chunk iCCP, compressed as one stored block (RFC 1950 and 1951).
fn iccp(profile: &[u8]) -> Vec<u8> {
    let (mut a, mut b) = (1_u32, 0_u32);
    for &byte in profile {
        a = (a + u32::from(byte)) % 65521;
        b = (b + a) % 65521;
    }
    let length = profile.len() as u16;
    let mut data = b"name\0\0\x78\x01\x01".to_vec();
    data.extend(length.to_le_bytes());
    data.extend((!length).to_le_bytes());
    data.extend(profile);
    data.extend((b << 16 | a).to_be_bytes());
    chunk(b"iCCP", &data)
}

fn gama(hundred_thousandths: u32) -> Vec<u8> {
    chunk(b"gAMA", &hundred_thousandths.to_be_bytes())
}

fn cicp(transfer: u8) -> Vec<u8> {
    chunk(b"cICP", &[1, transfer, 0, 1])
}

fn fixed(number: f64) -> [u8; 4] {
    ((number * 65536.0).round() as i32).to_be_bytes()
}

/// The type `parametricCurveType` (ICC.1:2010, 10.16).
fn parametric(kind: u8, numbers: &[f64]) -> Vec<u8> {
    let mut tag = b"para\0\0\0\0\0".to_vec();
    tag.extend([kind, 0, 0]);
    tag.extend(numbers.iter().copied().flat_map(fixed));
    tag
}

/// The type `curveType` (ICC.1:2010, 10.5).
pub(crate) fn sampled(codes: &[u16]) -> Vec<u8> {
    let mut tag = b"curv\0\0\0\0".to_vec();
    tag.extend((codes.len() as u32).to_be_bytes());
    tag.extend(codes.iter().flat_map(|code| code.to_be_bytes()));
    tag
}

/// A profile (ICC.1:2010, 7) for a space with these tags.
pub(crate) fn profile(space: &[u8; 4], tags: &[(&[u8; 4], Vec<u8>)]) -> Vec<u8> {
    let mut head = vec![0_u8; 128];
    head[8..12].copy_from_slice(&[4, 0x30, 0, 0]);
    head[12..16].copy_from_slice(b"mntr");
    head[16..20].copy_from_slice(space);
    head[20..24].copy_from_slice(b"XYZ ");
    head[24..30].copy_from_slice(&[7, 228, 0, 1, 0, 1]);
    head[36..40].copy_from_slice(b"acsp");
    for (i, part) in [0.9642, 1.0, 0.8249].into_iter().enumerate() {
        head[68 + 4 * i..72 + 4 * i].copy_from_slice(&fixed(part));
    }
    let mut table = (tags.len() as u32).to_be_bytes().to_vec();
    let mut body = Vec::new();
    for (name, tag) in tags {
        table.extend(name.iter());
        table.extend(((132 + 12 * tags.len() + body.len()) as u32).to_be_bytes());
        table.extend((tag.len() as u32).to_be_bytes());
        body.extend(tag);
        body.resize(body.len().next_multiple_of(4), 0);
    }
    let mut whole = [head, table, body].concat();
    let length = whole.len() as u32;
    whole[..4].copy_from_slice(&length.to_be_bytes());
    whole
}

fn of_colour(curves: [Vec<u8>; 3]) -> Vec<u8> {
    let [red, green, blue] = curves;
    profile(
        b"RGB ",
        &[(b"rTRC", red), (b"gTRC", green), (b"bTRC", blue)],
    )
}

/// The curve of sRGB as a parametric curve of type 3.
fn of_srgb() -> Vec<u8> {
    parametric(3, &[2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045])
}

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;

/// Stored value at a place: all values of 12 bits but full scale, from 0 upward.
fn stored(x: u32, y: u32) -> f64 {
    f64::from(y * WIDTH + x) / f64::from(WIDTH * HEIGHT)
}

fn word(v: f64) -> u16 {
    (v * 65535.0).round() as u16
}

fn byte(v: f64) -> u8 {
    (v * 255.0).round() as u8
}

/// The stored value as a number of `bits` has it.
fn rounded(v: f64, bits: u32) -> f64 {
    match bits {
        8 => f64::from(byte(v)) / 255.0,
        _ => f64::from(word(v)) / 65535.0,
    }
}

fn picture(bits: u32, colour: bool) -> DynamicImage {
    match (bits, colour) {
        (8, false) => ImageBuffer::from_fn(WIDTH, HEIGHT, |x, y| Luma([byte(stored(x, y))])).into(),
        (_, false) => ImageBuffer::from_fn(WIDTH, HEIGHT, |x, y| Luma([word(stored(x, y))])).into(),
        (8, true) => {
            ImageBuffer::from_fn(WIDTH, HEIGHT, |x, y| Rgb([byte(stored(x, y)); 3])).into()
        }
        (_, true) => {
            ImageBuffer::from_fn(WIDTH, HEIGHT, |x, y| Rgb([word(stored(x, y)); 3])).into()
        }
    }
}

/// Writes a PNG with these chunks behind its header.
fn png(folder: &Path, picture: &DynamicImage, chunks: &[Vec<u8>]) -> PathBuf {
    let mut bytes = Vec::new();
    picture
        .write_to(
            &mut std::io::Cursor::new(&mut bytes),
            image::ImageFormat::Png,
        )
        .expect("memory takes it");
    // The signature has 8 bytes, the header with its checksum 25.
    bytes.splice(33..33, chunks.concat());
    let file = folder.join("chunks.png");
    std::fs::write(&file, bytes).expect("the folder takes files");
    file
}

fn decode(transfer: Option<Transfer>) -> Decode {
    Decode {
        transfer,
        channel: Channel::Luminance,
    }
}

/// Compares all pixels with a curve, and the name and origin of the transfer with the words.
/// Single precision rounds the light, the stored value times the slope of the curve (at most 2.8),
/// and the three weights: 6 x 2^-24 in all, less than 4e-7. Beside it profiles hold numbers to
/// 2^-17, of which a curve has up to five; their effect is at most `rounding`.
fn assert_light(
    file: &Path,
    bits: u32,
    light: impl Fn(f64) -> f64,
    words: [&str; 2],
    rounding: f64,
) {
    let photo = photo::load(file, &decode(None)).expect("it is a picture");
    assert_eq!([&*photo.transfer.name, &*photo.transfer.from], words);
    let wanted = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| rounded(stored(x, y), bits)));
    for (found, stored) in photo.luminance.iter().zip(wanted) {
        // A saturated pixel is set to full scale.
        let wanted = if stored == 1.0 { 1.0 } else { light(stored) };
        let error = (f64::from(*found) - wanted).abs();
        assert!(error < 4e-7 + rounding, "{words:?}: {found}, not {wanted}");
    }
    assert_eq!(
        photo.warnings.len(),
        usize::from(bits == 8),
        "{:?}",
        photo.warnings
    );
    if bits == 8 {
        let linearised = photo.warnings[0].contains(&format!("linearised from {}", words[0]));
        assert_eq!(linearised, words[0] != "linear", "{:?}", photo.warnings);
    }
}

/// Each chunk names its curve, in the order cICP, iCCP, sRGB, gAMA, for grey and colour and for 8
/// and 16 bits. The key `transfer` goes before all of them.
#[test]
fn the_strongest_chunk_of_a_png_names_the_transfer() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let grey = iccp(&profile(b"GRAY", &[(b"kTRC", sampled(&[0x0240]))]));
    let three = iccp(&of_colour([of_srgb(), of_srgb(), of_srgb()]));
    let named = || chunk(b"sRGB", &[0]);
    let power225: Light = |v| v.powf(2.25);
    type Case = (Vec<Vec<u8>>, Light, [&'static str; 2]);
    let cases: [Case; 14] = [
        (vec![named()], srgb, ["sRGB", "sRGB chunk"]),
        (
            vec![gama(45455)],
            |v| v.powf(1e5 / 45455.0),
            ["gamma 2.2", "gAMA chunk"],
        ),
        (vec![gama(100_000)], linear, ["linear", "gAMA chunk"]),
        (
            vec![gama(55556)],
            |v| v.powf(1e5 / 55556.0),
            ["gamma 1.8", "gAMA chunk"],
        ),
        (vec![gama(100_000), named()], srgb, ["sRGB", "sRGB chunk"]),
        (vec![cicp(1)], bt709, ["BT.709", "cICP chunk"]),
        (vec![cicp(4)], power22, ["gamma 2.2", "cICP chunk"]),
        (vec![cicp(5)], power28, ["gamma 2.8", "cICP chunk"]),
        (vec![cicp(8), named()], linear, ["linear", "cICP chunk"]),
        (vec![cicp(13), gama(100_000)], srgb, ["sRGB", "cICP chunk"]),
        // Unspecified: the next chunk decides.
        (
            vec![cicp(2), gama(100_000)],
            linear,
            ["linear", "gAMA chunk"],
        ),
        (
            vec![cicp(8), grey.clone(), gama(45455)],
            linear,
            ["linear", "cICP chunk"],
        ),
        (
            vec![gama(100_000), grey, named()],
            power225,
            ["gamma 2.25", "iCCP profile"],
        ),
        (vec![gama(100_000), three], srgb, ["sRGB", "iCCP profile"]),
    ];
    let mut count = 0;
    for (chunks, light, words) in &cases {
        for bits in [8, 16] {
            for colour in [false, true] {
                let of_grey = words[0] == "gamma 2.25";
                if of_grey && colour {
                    continue;
                }
                let file = png(folder.path(), &picture(bits, colour), chunks);
                assert_light(&file, bits, light, *words, 2e-5);
                let given = photo::load(&file, &decode(Some(Transfer::Linear))).expect("as before");
                assert_eq!(given.transfer.to_string(), "linear (given as `transfer`)");
                let wanted = rounded(stored(40, 30), bits);
                assert!((f64::from(given.at(40, 30).unwrap()) - wanted).abs() < 4e-7);
                count += 1;
            }
        }
    }
    for (bits, name, from) in [
        (8, "sRGB", "default of 8 bits"),
        (16, "linear", "default of 16 bits"),
    ] {
        let file = png(folder.path(), &picture(bits, true), &[]);
        let light: Light = if bits == 8 { srgb } else { linear };
        assert_light(&file, bits, light, [name, from], 0.0);
        count += 1;
    }
    assert_eq!(count, 4 * 14 - 2 + 2);
}

/// All types of curves that a profile can hold, against the formulas of ICC.1:2010, in grey and in
/// colour, in PNG, TIFF and JPEG.
#[test]
fn profiles_give_the_light_of_their_curves() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let squares: Vec<u16> = (0..33_u32)
        .map(|i| (i * i * 64).min(65535) as u16)
        .collect();
    let cases: [(Vec<u8>, Light, &str); 9] = [
        (parametric(0, &[1.8]), |v| v.powf(1.8), "gamma 1.8"),
        (
            parametric(1, &[2.0, 1.25, -0.25]),
            |v| (1.25 * v - 0.25).max(0.0).powi(2),
            "tone curve",
        ),
        (
            parametric(2, &[2.0, 1.125, -0.25, 0.234_375]),
            |v| (1.125 * v - 0.25).max(0.0).powi(2) + 0.234_375,
            "tone curve",
        ),
        (of_srgb(), srgb, "sRGB"),
        (
            parametric(4, &[2.0, 0.875, 0.0, 0.25, 0.25, 0.234_375, 0.015_625]),
            |v| {
                if v < 0.25 {
                    0.25 * v + 0.015_625
                } else {
                    0.765_625 * v * v + 0.234_375
                }
            },
            "tone curve",
        ),
        (sampled(&[]), linear, "linear"),
        (
            sampled(&[0x01cd]),
            |v| v.powf(f64::from(0x01cd) / 256.0),
            "gamma 1.801",
        ),
        (sampled(&[0, 65535]), linear, "linear"),
        (
            // Between the samples, of which the last is 65535, the curve is straight.
            sampled(&squares),
            |v| {
                let square = |i: f64| (i * i * 64.0).min(65535.0) / 65535.0;
                let place = (32.0 * v).floor();
                let part = 32.0 * v - place;
                square(place) + part * (square(place + 1.0) - square(place))
            },
            "tone curve",
        ),
    ];
    let mut count = 0;
    for (tag, light, name) in &cases {
        let grey = profile(b"GRAY", &[(b"kTRC", tag.clone())]);
        let colour = of_colour([tag.clone(), tag.clone(), tag.clone()]);
        for bits in [8, 16] {
            for (of, profile) in [(false, &grey), (false, &colour), (true, &colour)] {
                let picture = picture(bits, of);
                let file = png(folder.path(), &picture, &[iccp(profile)]);
                assert_light(&file, bits, light, [*name, "iCCP profile"], 2e-5);
                let file = folder.path().join("profile.tif");
                let written = std::fs::File::create(&file).expect("the folder takes files");
                let mut encoder = image::codecs::tiff::TiffEncoder::new(written);
                encoder
                    .set_icc_profile(profile.clone())
                    .expect("TIFF holds profiles");
                picture
                    .write_with_encoder(encoder)
                    .expect("it can be written");
                assert_light(&file, bits, light, [*name, "ICC profile"], 2e-5);
                count += 2;
            }
        }
        // In a constant grey JPEG all pixels have one code.
        let mut bytes = Vec::new();
        let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100);
        encoder.set_icc_profile(grey).expect("JPEG holds profiles");
        encoder
            .encode(&[160; 64 * 48], WIDTH, HEIGHT, image::ExtendedColorType::L8)
            .expect("memory takes it");
        let file = folder.path().join("profile.jpg");
        std::fs::write(&file, bytes).expect("the folder takes files");
        let photo = photo::load(&file, &decode(None)).expect("it is a JPEG");
        assert_eq!(photo.transfer.to_string(), format!("{name} (ICC profile)"));
        let wanted = light(160.0 / 255.0);
        assert!(
            photo
                .luminance
                .iter()
                .all(|&v| (f64::from(v) - wanted).abs() < 2e-5),
            "{name}"
        );
        count += 1;
    }
    assert_eq!(count, 9 * 13);
}

/// Each channel has its own curve, in photographs and in pictures of three planes.
#[test]
fn curves_that_differ_belong_to_their_channels() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let curves = [parametric(0, &[1.5]), sampled(&[]), parametric(0, &[2.5])];
    let lights: [Light; 3] = [|v| v.powf(1.5), linear, |v| v.powf(2.5)];
    let mut count = 0;
    for bits in [8, 16] {
        let file = png(
            folder.path(),
            &picture(bits, true),
            &[iccp(&of_colour(curves.clone()))],
        );
        let colours = photo::load_colour(&file, None).expect("it is a picture");
        for (i, channel) in Channel::PRIMARIES.into_iter().enumerate() {
            let photo = photo::load(
                &file,
                &Decode {
                    transfer: None,
                    channel,
                },
            )
            .expect("as before");
            assert_eq!(photo.transfer.name, "tone curve");
            for (k, (a, b)) in photo.luminance.iter().zip(&colours.planes[i]).enumerate() {
                let v = rounded(f64::from(k as u32) / f64::from(WIDTH * HEIGHT), bits);
                assert!((f64::from(*a) - lights[i](v)).abs() < 2e-5, "{i} {k}");
                assert!((a - b).abs() < 1e-7);
            }
            count += 1;
        }
        let luminance = photo::load(&file, &decode(None)).expect("as before");
        let v = rounded(stored(40, 30), bits);
        let wanted = 0.2126 * v.powf(1.5) + 0.7152 * v + 0.0722 * v.powf(2.5);
        assert!((f64::from(luminance.at(40, 30).unwrap()) - wanted).abs() < 2e-5);
    }
    assert_eq!(count, 6);
}

/// A transfer that cannot be followed is refused in one sentence that names the file, the part and
/// the remedy. The remedy works.
#[test]
fn transfers_that_cannot_be_followed_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let good = iccp(&of_colour([of_srgb(), of_srgb(), of_srgb()]));
    let mut broken = good.clone();
    broken[60] ^= 1;
    let falls = sampled(&[65535, 0]);
    let cases = [
        (cicp(16), "cICP", "PQ"),
        (cicp(18), "cICP", "HLG"),
        (cicp(9), "cICP", "transfer characteristics 9 of H.273"),
        (chunk(b"cICP", &[1, 13, 0, 0]), "cICP", "narrow"),
        (chunk(b"gAMA", &[0; 4]), "gAMA", "damaged"),
        (chunk(b"sRGB", &[9]), "sRGB", "damaged"),
        (broken, "iCCP", "damaged"),
        (iccp(b"no profile"), "iCCP", "damaged"),
        (iccp(&profile(b"RGB ", &[])), "iCCP", "no tone curves"),
        (
            iccp(&profile(b"GRAY", &[(b"kTRC", sampled(&[]))])),
            "iCCP",
            "for grey",
        ),
        (
            iccp(&profile(b"CMYK", &[])),
            "iCCP",
            "neither for RGB nor for grey",
        ),
        (
            iccp(&of_colour([falls.clone(), falls.clone(), falls])),
            "iCCP",
            "does not rise",
        ),
    ];
    for (chunk, part, reason) in cases {
        let file = png(folder.path(), &picture(16, true), &[chunk]);
        let error = photo::load(&file, &decode(None))
            .expect_err(reason)
            .to_string();
        assert!(
            error.starts_with(&format!("{}: its {part} cannot", file.display())),
            "{error}"
        );
        assert!(
            error.contains(reason) && error.contains("set `transfer`"),
            "{error}"
        );
        assert!(
            photo::load(&file, &decode(Some(Transfer::Srgb))).is_ok(),
            "{reason}"
        );
    }
}

/// The profile of a JPEG or TIFF that is there in part is refused, and never passed over.
#[test]
fn half_a_profile_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let grey = profile(b"GRAY", &[(b"kTRC", sampled(&[]))]);
    let mut jpeg = Vec::new();
    let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 90);
    encoder
        .set_icc_profile(grey.clone())
        .expect("JPEG holds profiles");
    encoder
        .encode(&[160; 64 * 48], WIDTH, HEIGHT, image::ExtendedColorType::L8)
        .expect("memory takes it");
    let part = jpeg
        .windows(11)
        .position(|w| w == b"ICC_PROFILE")
        .expect("it is there");
    // The first of two parts, of which the second is missing.
    jpeg[part + 13] = 2;
    let mut tiff = std::io::Cursor::new(Vec::new());
    let mut encoder = image::codecs::tiff::TiffEncoder::new(&mut tiff);
    encoder.set_icc_profile(grey).expect("TIFF holds profiles");
    picture(8, false)
        .write_with_encoder(encoder)
        .expect("it can be written");
    let mut tiff = tiff.into_inner();
    // Tag 34675 of type BYTE; its count and the place of its values follow.
    let tag = tiff
        .windows(4)
        .position(|w| w == [0x73, 0x87, 1, 0])
        .expect("it is there");
    tiff[tag + 11] = 0x40;
    for (name, bytes) in [("part.jpg", jpeg), ("part.tif", tiff)] {
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).expect("the folder takes files");
        let error = photo::load(&file, &decode(None))
            .expect_err(name)
            .to_string();
        assert!(
            error.contains("its ICC profile cannot be followed (it is damaged)"),
            "{error}"
        );
        assert!(
            photo::load(&file, &decode(Some(Transfer::Srgb))).is_ok(),
            "{name}"
        );
    }
}

/// A profile with any one byte changed is refused or read, and never gives light that is not
/// finite.
#[test]
fn damaged_profiles_cause_no_panic() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let whole = of_colour([of_srgb(), sampled(&[0, 9000, 65535]), sampled(&[0x0200])]);
    let (mut read, mut refused) = (0, 0);
    for at in 0..whole.len() {
        for change in [0x01, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= change;
            let file = png(folder.path(), &picture(8, true), &[iccp(&bytes)]);
            match photo::load(&file, &decode(None)) {
                Ok(photo) => {
                    assert!(photo.luminance.iter().all(|v| v.is_finite()));
                    read += 1;
                }
                Err(_) => refused += 1,
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert_eq!(read + refused, 3 * whole.len());
    assert!(read > 100 && refused > 100, "{read} {refused}");
}

/// Frequency at which the MTF of a file is one half, cycles per pixel.
fn mtf50(file: &Path, transfer: Option<Transfer>) -> f64 {
    let photo = photo::load(file, &decode(transfer)).expect("it is a picture");
    let measured = measure::edge(&photo, None, &[]).expect("it holds an edge");
    let estimator = Estimator::new(&measured.profile, 1.0, 2048, 512);
    let mtf = estimator.measure(&measured.profile).modulus;
    crossing(&estimator.frequencies_per_mm, &mtf, 0.5).expect("it falls to one half")
}

/// One edge is stored as 16 bits under sRGB, as 16 bits linear, and as 8 bits linear. MTF50 agrees
/// with that of the light itself. By the default of another format it does not.
///
/// Rounding to 16 bits moves a pixel by at most half a step times the slope of the curve, 2.3. That
/// is 2.9e-5 of the edge's step of 0.6, with a standard deviation of 1.7e-5. A bin of a quarter of
/// a pixel holds 48 pixels or more: 2.5e-6. The MTF at f = 0.15 per pixel is the sum over 1,000
/// bins, each times 2 sin(pi f / 4) = 0.24: 1.9e-5. A Gaussian's MTF falls at one half by 0.69 of a
/// relative change of f. So MTF50 scatters by 2.7e-5, and 1e-4 is four standard deviations.
///
/// Rounding to 8 bits without noise is no scatter. There only the reading as linear light is
/// checked, which gives the same numbers whoever names it.
#[test]
fn the_mtf_of_an_edge_is_that_of_its_light() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (width, height) = (240, 200);
    let light = edges::photo(width, height, |x, y| {
        let (sin, cos) = 5_f64.to_radians().sin_cos();
        let s = (x - 120.3) * cos + (y - 99.1) * sin;
        0.1 + 0.6 * edges::rise(s, 1.2)
    });
    let stored = |transfer: Transfer, x: u32, y: u32| {
        let light = light.at(x as usize, y as usize).expect("inside");
        f64::from(transfer.to_stored(light))
    };
    let own = {
        let measured = measure::edge(&light, None, &[]).expect("it holds an edge");
        let estimator = Estimator::new(&measured.profile, 1.0, 2048, 512);
        let mtf = estimator.measure(&measured.profile).modulus;
        crossing(&estimator.frequencies_per_mm, &mtf, 0.5).expect("it falls to one half")
    };
    let (w, h) = (width as u32, height as u32);
    let coded: DynamicImage =
        ImageBuffer::from_fn(w, h, |x, y| Luma([word(stored(Transfer::Srgb, x, y))])).into();
    let plain: DynamicImage =
        ImageBuffer::from_fn(w, h, |x, y| Luma([word(stored(Transfer::Linear, x, y))])).into();
    let few: DynamicImage =
        ImageBuffer::from_fn(w, h, |x, y| Luma([byte(stored(Transfer::Linear, x, y))])).into();
    let grey = iccp(&profile(b"GRAY", &[(b"kTRC", of_srgb())]));
    let cases = [
        (&coded, vec![chunk(b"sRGB", &[0])], 1e-4, Transfer::Linear),
        (&coded, vec![grey], 1e-4, Transfer::Linear),
        (&plain, vec![], 1e-4, Transfer::Srgb),
        (&plain, vec![gama(100_000)], 1e-4, Transfer::Srgb),
    ];
    for (picture, chunks, most, wrong) in cases {
        let file = png(folder.path(), picture, &chunks);
        let found = mtf50(&file, None) / own - 1.0;
        let wrong = mtf50(&file, Some(wrong)) / own - 1.0;
        println!("MTF50 off by {found:.6}; by the other transfer {wrong:.4}");
        assert!(found.abs() < most, "{found}");
        assert!(wrong.abs() > 0.01, "{wrong}");
    }
    let file = png(folder.path(), &few, &[gama(100_000)]);
    let (named, given) = (mtf50(&file, None), mtf50(&file, Some(Transfer::Linear)));
    assert_eq!(named, given);
    let wrong = mtf50(&file, Some(Transfer::Srgb)) / named - 1.0;
    println!("8 bits, linear: by the other transfer {wrong:.4}");
    assert!(wrong > 0.1, "{wrong}");
}
