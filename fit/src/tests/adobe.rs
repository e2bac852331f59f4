//! Tests of the colour space that cameras name in Exif data, in files that are made byte by byte.

use std::path::Path;

use crate::photographs::photo;
use crate::photographs::photo::channel::{Channel, Decode};
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::transfer::Transfer;
use crate::tests::exposure::Order;

/// Value of all pixels.
const CODE: u8 = 160;

/// The curve of sRGB at [`CODE`] (IEC 61966-2-1).
fn srgb() -> f64 {
    ((f64::from(CODE) / 255.0 + 0.055) / 1.055).powf(2.4)
}

/// The curve of Adobe RGB (1998) at [`CODE`].
fn adobe() -> f64 {
    (f64::from(CODE) / 255.0).powf(563.0 / 256.0)
}

/// Exif data with a `ColorSpace` and an interoperability index. Those without a value are left out.
fn exif(space: Option<u16>, index: Option<&[u8; 4]>, big: bool) -> Vec<u8> {
    let order = Order { big };
    // An entry has tag, type, count and 4 bytes of a value.
    let entry = |tag: u16, kind: u16, count: u32, value: [u8; 4]| {
        [
            &order.word(tag)[..],
            &order.word(kind),
            &order.long(count),
            &value,
        ]
        .concat()
    };
    let directory = |entries: &[Vec<u8>]| {
        let count = order.word(entries.len() as u16);
        [&count[..], &entries.concat(), &order.long(0)].concat()
    };
    let length = |entries: usize| 2 + 12 * entries as u32 + 4;
    let mut bytes = if big { b"MM\0*" } else { b"II*\0" }.to_vec();
    bytes.extend(order.long(8));
    bytes.extend(directory(&[entry(0x8769, 4, 1, order.long(8 + length(1)))]));
    let mut entries = Vec::new();
    if let Some(space) = space {
        let [high, low] = order.word(space);
        entries.push(entry(0xa001, 3, 1, [high, low, 0, 0]));
    }
    if index.is_some() {
        let count = entries.len() + 1;
        let behind = 8 + length(1) + length(count);
        entries.push(entry(0xa005, 4, 1, order.long(behind)));
    }
    bytes.extend(directory(&entries));
    if let Some(index) = index {
        bytes.extend(directory(&[entry(1, 2, 4, *index)]));
    }
    bytes
}

/// A grey ICC profile (ICC.1:2010, 7) whose curve has the exponent 1.8.
fn profile() -> Vec<u8> {
    let mut bytes = vec![0_u8; 128];
    bytes[8..12].copy_from_slice(&[4, 0x30, 0, 0]);
    bytes[12..24].copy_from_slice(b"mntrGRAYXYZ ");
    bytes[24..30].copy_from_slice(&[7, 228, 0, 1, 0, 1]);
    bytes[36..40].copy_from_slice(b"acsp");
    for (i, part) in [0.9642_f64, 1.0, 0.8249].into_iter().enumerate() {
        let fixed = (part * 65536.0).round() as u32;
        bytes[68 + 4 * i..72 + 4 * i].copy_from_slice(&fixed.to_be_bytes());
    }
    bytes.extend(1_u32.to_be_bytes());
    bytes.extend(b"kTRC");
    bytes.extend(144_u32.to_be_bytes());
    bytes.extend(14_u32.to_be_bytes());
    bytes.extend(b"curv\0\0\0\0\0\0\0\x01\x01\xcd\0\0");
    let length = bytes.len() as u32;
    bytes[..4].copy_from_slice(&length.to_be_bytes());
    bytes
}

/// A JPEG of one grey with Exif data in its first segment.
fn jpeg(exif: &[u8], profile: Option<Vec<u8>>) -> Vec<u8> {
    use image::ImageEncoder;
    let mut plain = Vec::new();
    let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut plain, 100);
    if let Some(profile) = profile {
        encoder
            .set_icc_profile(profile)
            .expect("JPEG holds profiles");
    }
    encoder
        .encode(&[CODE; 16 * 16], 16, 16, image::ExtendedColorType::L8)
        .expect("memory takes it");
    let length = (exif.len() as u16 + 8).to_be_bytes();
    let head = [&[0xff, 0xe1], &length[..], b"Exif\0\0"].concat();
    [&plain[..2], &head, exif, &plain[2..]].concat()
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
            let data = exif(space, index, big);
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

            let photo = read(folder.path(), &jpeg(&data, Some(profile())), None);
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
    let data = exif(Some(0xffff), Some(b"R03\0"), true);
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
