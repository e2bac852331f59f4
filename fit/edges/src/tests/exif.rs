//! Tests of what a camera writes into the Exif data of a file: shutter, f-number and ISO in place of
//! the key `exposure`, and the colour space. The files are made byte by byte.

use std::path::Path;

use image::ImageEncoder;

use crate::photographs::Campaign;
use crate::photographs::manifest::captures;
use crate::photographs::photo;
use crate::photographs::photo::channel::{Channel, Decode};
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::transfer::Transfer;
use crate::tests::transfers::{profile, sampled};

/// The settings that a camera writes into a photograph.
#[derive(Clone, Copy)]
struct Shot {
    seconds: [u32; 2],
    f_number: [u32; 2],
    iso: u16,
}

/// Order of the bytes of a number.
#[derive(Clone, Copy)]
struct Order {
    /// True if the highest byte comes first.
    big: bool,
}

impl Order {
    /// Returns the bytes of a short number.
    fn word(self, v: u16) -> [u8; 2] {
        if self.big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    }

    /// Returns the bytes of a long number.
    fn long(self, v: u32) -> [u8; 4] {
        if self.big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    }
}

/// An entry of an Exif directory: tag, type, and the value or its offset. Four letters are a value.
type Entry = (u16, u16, u32);

fn directory(entries: &[Entry], order: Order) -> Vec<u8> {
    let mut bytes = order.word(entries.len() as u16).to_vec();
    for &(tag, kind, value) in entries {
        bytes.extend([order.word(tag), order.word(kind)].concat());
        bytes.extend(order.long(if kind == 2 { 4 } else { 1 }));
        match kind {
            2 => bytes.extend(value.to_be_bytes()),
            3 => bytes.extend([order.word(value as u16), [0; 2]].concat()),
            _ => bytes.extend(order.long(value)),
        }
    }
    bytes.extend(order.long(0));
    bytes
}

/// A TIFF structure of one 2 x 2 picture of 8-bit grey with an Exif directory. The tag `without` is
/// left out.
fn tiff(shot: Shot, big: bool, without: Option<u16>) -> Vec<u8> {
    let order = Order { big };
    let mut bytes = if big { b"MM\0*" } else { b"II*\0" }.to_vec();
    // Header 8, two rationals 16, pixels 4, then the directories: 11 entries are 2 + 132 + 4 bytes.
    bytes.extend(order.long(28));
    for number in [shot.seconds, shot.f_number].as_flattened() {
        bytes.extend(order.long(*number));
    }
    bytes.extend([10, 20, 30, 40]);
    let main: [Entry; 10] = [
        (256, 3, 2),
        (257, 3, 2),
        (258, 3, 8),
        (259, 3, 1),
        (262, 3, 1),
        (273, 4, 24),
        (277, 3, 1),
        (278, 3, 2),
        (279, 4, 4),
        (0x8769, 4, 28 + 2 + 120 + 4),
    ];
    bytes.extend(directory(&main, order));
    let exif: Vec<Entry> = [
        (0x829a, 5, 8),
        (0x829d, 5, 16),
        (0x8827, 3, u32::from(shot.iso)),
    ]
    .into_iter()
    .filter(|(tag, ..)| Some(*tag) != without)
    .collect();
    bytes.extend(directory(&exif, order));
    bytes
}

/// Value of all pixels of a JPEG.
const CODE: u8 = 160;

/// A JPEG of one grey with Exif data in its first segment.
fn jpeg(exif: &[u8], profile: Option<Vec<u8>>) -> Vec<u8> {
    let mut plain = Vec::new();
    let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut plain, 100);
    if let Some(profile) = profile {
        let held = encoder.set_icc_profile(profile);
        held.expect("JPEG holds profiles");
    }
    encoder
        .encode(&[CODE; 16 * 16], 16, 16, image::ExtendedColorType::L8)
        .expect("memory takes it");
    let length = (exif.len() as u16 + 8).to_be_bytes();
    let head = [&[0xff, 0xe1], &length[..], b"Exif\0\0"].concat();
    [&plain[..2], &head, exif, &plain[2..]].concat()
}

fn campaign(
    folder: &Path,
    reference: (&str, Vec<u8>),
    capture: (&str, Vec<u8>),
    keys: &str,
) -> Result<Campaign, captures::Error> {
    for (name, bytes) in [&reference, &capture] {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
    let manifest = folder.join("captures.toml");
    let text = format!(
        "[setup]\npixel_pitch_mm = 0.05\nhalf_mirror_transmittance = 0.5\nhalf_mirror_reflectance \
        = 0.5\n\
         [reference]\nimage = \"{}\"\n{keys}\n[[capture]]\nimage = \"{}\"\nfloating_distance_mm = \
         150\nincidence_deg = 0\n",
        reference.0, capture.0
    );
    std::fs::write(&manifest, text).unwrap();
    captures::load(&manifest)
}

const SOURCE: Shot = Shot {
    seconds: [1, 60],
    f_number: [56, 10],
    iso: 100,
};
const AERIAL: Shot = Shot {
    seconds: [5, 10],
    f_number: [4, 1],
    iso: 400,
};

/// The exposure is (0.5 s x 400 / 4^2) / (1/60 s x 100 / 5.6^2) = 12.5 / 0.053146 = 235.2, in every
/// combination of containers and byte orders.
#[test]
fn relative_exposure_is_seconds_times_iso_over_the_squared_f_number() {
    let folder = tempfile::tempdir().unwrap();
    let mut cases = 0;
    for big in [false, true] {
        for names in [["a.jpg", "b.jpg"], ["a.tif", "b.tif"], ["a.tif", "b.jpg"]] {
            let file = |name: &'static str, shot| {
                let exif = tiff(shot, big, None);
                let bytes = if name.ends_with("jpg") {
                    jpeg(&exif, None)
                } else {
                    exif
                };
                (name, bytes)
            };
            let [a, b] = [file(names[0], SOURCE), file(names[1], AERIAL)];
            for (keys, factor) in [("", 1.0), ("exposure = 2.0", 2.0)] {
                let campaign = campaign(folder.path(), a.clone(), b.clone(), keys).unwrap();
                let found = campaign.captures[0].shot.exposure;
                let known = factor * 0.5 * 400.0 / 16.0 / (100.0 / 60.0 / 31.36);
                assert!(
                    (found / known - 1.0).abs() < 1e-12,
                    "{names:?}: {found} {known}"
                );
                assert!((known / factor - 235.2).abs() < 1e-9);
                let warning = campaign.warnings.join("\n");
                assert!(
                    warning.contains("Exif") && warning.contains("ISO 400"),
                    "{warning}"
                );
                cases += 1;
            }
            for name in names {
                let read = photo::load(&folder.path().join(name), &Decode::default());
                assert!(read.is_ok(), "{name}: {read:?}");
            }
        }
    }
    assert_eq!(cases, 12);
}

/// The error names the missing setting and the file.
#[test]
fn a_missing_setting_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut cases = 0;
    for (tag, name) in [
        (0x829a, "no ExposureTime"),
        (0x829d, "no FNumber"),
        (0x8827, "no PhotographicSensitivity (ISO)"),
    ] {
        let source = ("a.tif", tiff(SOURCE, false, None));
        let aerial = ("b.tif", tiff(AERIAL, false, Some(tag)));
        let error = campaign(folder.path(), source, aerial, "")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("b.tif") && error.contains(name) && error.ends_with("add `exposure`"),
            "{error}"
        );
        cases += 1;
    }
    let mut plain = jpeg(&tiff(AERIAL, false, None), None);
    plain.drain(2..plain.windows(2).position(|w| w == [0xff, 0xdb]).unwrap());
    let source = ("a.tif", tiff(SOURCE, false, None));
    let error = campaign(folder.path(), source, ("b.jpg", plain), "")
        .unwrap_err()
        .to_string();
    assert!(error.contains("b.jpg has no Exif data"), "{error}");
    assert_eq!(cases, 3);
}

/// The curve of sRGB at [`CODE`] (IEC 61966-2-1).
fn srgb() -> f64 {
    ((f64::from(CODE) / 255.0 + 0.055) / 1.055).powf(2.4)
}

/// The curve of Adobe RGB (1998) at [`CODE`].
fn adobe() -> f64 {
    (f64::from(CODE) / 255.0).powf(563.0 / 256.0)
}

/// Exif data with a `ColorSpace` and an interoperability index. Those without a value are left out.
fn colours(space: Option<u16>, index: Option<&[u8; 4]>, big: bool) -> Vec<u8> {
    let order = Order { big };
    let length = |entries: usize| 2 + 12 * entries as u32 + 4;
    let mut bytes = if big { b"MM\0*" } else { b"II*\0" }.to_vec();
    bytes.extend(order.long(8));
    bytes.extend(directory(&[(0x8769, 4, 8 + length(1))], order));
    let mut entries: Vec<Entry> = Vec::new();
    entries.extend(space.map(|space| (0xa001, 3, space.into())));
    if index.is_some() {
        let behind = 8 + length(1) + length(entries.len() + 1);
        entries.push((0xa005, 4, behind));
    }
    bytes.extend(directory(&entries, order));
    if let Some(index) = index {
        let text = u32::from_be_bytes(*index);
        bytes.extend(directory(&[(1, 2, text)], order));
    }
    bytes
}

fn read(folder: &Path, bytes: &[u8], transfer: Option<Transfer>) -> Photo {
    let file = folder.join("photo.jpg");
    std::fs::write(&file, bytes).expect("the folder takes files");
    let options = Decode {
        transfer,
        channel: Channel::Luminance,
    };
    photo::load(&file, &options).expect("it is a JPEG")
}

/// Two parts name Adobe RGB together: uncalibrated colours, and the index R03. A profile goes
/// before them, and the key `transfer` before all. Single precision rounds the stored value, three
/// steps of a curve whose exponent is at most 2.4, and the light: less than 8 x 2^-24 = 5e-7.
#[test]
fn exif_data_name_adobe_rgb() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let other = Some(0xffff);
    let gamma = "gamma 2.199 (Exif: Adobe RGB)";
    let default = "sRGB (default of 8 bits)";
    // The number of warnings has the one about 8 bits.
    let cases = [
        (other, Some(b"R03\0"), gamma, adobe(), 1),
        (other, Some(b"R98\0"), default, srgb(), 2),
        (other, None, default, srgb(), 2),
        (Some(2), Some(b"R98\0"), default, srgb(), 2),
        (Some(1), Some(b"R98\0"), default, srgb(), 1),
        (Some(1), Some(b"R03\0"), default, srgb(), 1),
        (None, Some(b"R03\0"), default, srgb(), 1),
    ];
    let mut count = 0;
    for (space, index, words, light, warnings) in cases {
        for big in [false, true] {
            let data = colours(space, index, big);
            let photo = read(folder.path(), &jpeg(&data, None), None);
            let what = format!("{space:?} {index:?}: {:?}", photo.warnings);
            assert_eq!(photo.transfer.to_string(), words, "{what}");
            assert_eq!(photo.warnings.len(), warnings, "{what}");
            let doubts = photo.warnings.iter().filter(|w| w.contains("Exif"));
            assert_eq!(doubts.count(), warnings - 1, "{what}");
            let found = photo.luminance.iter().map(|&found| f64::from(found));
            assert!(
                found.into_iter().all(|found| (found - light).abs() < 5e-7),
                "{what}"
            );
            count += 1;

            let photo = read(
                folder.path(),
                &jpeg(
                    &data,
                    Some(profile(b"GRAY", &[(b"kTRC", sampled(&[0x01cd]))])),
                ),
                None,
            );
            assert_eq!(photo.transfer.to_string(), "gamma 1.801 (ICC profile)");
            let given = Some(Transfer::Linear);
            let photo = read(folder.path(), &jpeg(&data, None), given);
            assert_eq!(photo.transfer.to_string(), "linear (given as `transfer`)");
            assert_eq!(photo.warnings.len(), 1, "{:?}", photo.warnings);
            count += 2;
        }
    }
    assert_eq!(count, 3 * 2 * 7);
    // The two curves are told apart: they differ by 1.5 % at this code.
    assert!(
        (adobe() / srgb() - 1.0).abs() > 0.01,
        "{} {}",
        adobe(),
        srgb()
    );
}

/// Exif data that end anywhere are read as far as they go, or passed over.
#[test]
fn damaged_exif_data_do_no_harm() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let data = colours(Some(0xffff), Some(b"R03\0"), true);
    let mut adobe = 0;
    for length in 0..=data.len() {
        let photo = read(folder.path(), &jpeg(&data[..length], None), None);
        let from = photo.transfer.from;
        assert!(
            ["Exif: Adobe RGB", "default of 8 bits"].contains(&&*from),
            "{from}"
        );
        adobe += usize::from(from == "Exif: Adobe RGB");
    }
    // The index needs all of its directory but the offset of the next one, which has 4 bytes.
    assert!((1..=5).contains(&adobe), "{adobe} of {}", data.len() + 1);
}
