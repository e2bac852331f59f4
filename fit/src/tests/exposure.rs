//! Tests of a manifest without `exposure`: shutter, f-number and ISO come from Exif, in files that
//! are made byte by byte.

use std::path::Path;

use crate::photographs::Campaign;
use crate::photographs::captures;
use crate::photographs::photo;
use crate::photographs::photo::channel::Decode;

/// The settings that a camera writes into a photograph.
#[derive(Clone, Copy)]
struct Shot {
    seconds: [u32; 2],
    f_number: [u32; 2],
    iso: u16,
}

/// Order of the bytes of a number.
#[derive(Clone, Copy)]
pub(crate) struct Order {
    /// True if the highest byte comes first.
    pub big: bool,
}

impl Order {
    /// Returns the bytes of a short number.
    pub(crate) fn word(self, v: u16) -> [u8; 2] {
        if self.big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    }

    /// Returns the bytes of a long number.
    pub(crate) fn long(self, v: u32) -> [u8; 4] {
        if self.big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    }
}

/// An entry of an Exif directory: tag, type, and the value or its offset.
type Entry = (u16, u16, u32);

fn directory(entries: &[Entry], order: Order) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend(order.word(entries.len() as u16));
    for &(tag, kind, value) in entries {
        bytes.extend(order.word(tag));
        bytes.extend(order.word(kind));
        bytes.extend(order.long(1));
        match kind {
            3 => {
                bytes.extend(order.word(value as u16));
                bytes.extend(order.word(0));
            }
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
    let mut bytes = if big {
        b"MM\0*".to_vec()
    } else {
        b"II*\0".to_vec()
    };
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

/// A JPEG with the Exif data of `tiff` in its APP1 segment.
fn jpeg(tiff: &[u8]) -> Vec<u8> {
    let mut plain = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_pixel(8, 8, image::Luma([90]))
        .write_to(&mut plain, image::ImageFormat::Jpeg)
        .unwrap();
    let plain = plain.into_inner();
    let mut bytes = plain[..2].to_vec();
    bytes.extend([0xff, 0xe1]);
    bytes.extend(((tiff.len() + 8) as u16).to_be_bytes());
    bytes.extend(b"Exif\0\0");
    bytes.extend(tiff);
    bytes.extend(&plain[2..]);
    bytes
}

fn campaign(
    folder: &Path,
    reference: (&str, Vec<u8>),
    capture: (&str, Vec<u8>),
    keys: &str,
) -> Result<Campaign, captures::error::Error> {
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
    for big in [false, true] {
        for names in [["a.jpg", "b.jpg"], ["a.tif", "b.tif"], ["a.tif", "b.jpg"]] {
            let file = |name: &'static str, shot| {
                let exif = tiff(shot, big, None);
                let bytes = if name.ends_with("jpg") {
                    jpeg(&exif)
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
            }
            for name in names {
                let read = photo::load(&folder.path().join(name), &Decode::default());
                assert!(read.is_ok(), "{name}: {read:?}");
            }
        }
    }
}

/// The error names the missing setting and the file.
#[test]
fn a_missing_setting_is_named() {
    let folder = tempfile::tempdir().unwrap();
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
    }
    let mut plain = jpeg(&tiff(AERIAL, false, None));
    plain.drain(2..plain.windows(2).position(|w| w == [0xff, 0xdb]).unwrap());
    let source = ("a.tif", tiff(SOURCE, false, None));
    let error = campaign(folder.path(), source, ("b.jpg", plain), "")
        .unwrap_err()
        .to_string();
    assert!(error.contains("b.jpg has no Exif data"), "{error}");
}
