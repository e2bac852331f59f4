//! Tests that a TIFF whose strips are JPEGs is refused if one of them is not whole.

use std::path::Path;

use crate::photographs::photo;
use crate::photographs::photo::channel::Decode;
use crate::photographs::photo::plane::Photo;

const WIDTH: u16 = 48;
/// Rows of a strip.
const ROWS: u16 = 24;
const STRIPS: usize = 3;

/// A TIFF of grey strips.
struct Strips {
    /// Content of the tag `JPEGTables`.
    tables: Option<Vec<u8>>,
    /// The JPEG of each strip.
    each: Vec<Vec<u8>>,
}

impl Strips {
    /// Makes strips with an edge and some texture, so that the data of all rows differ.
    fn new() -> Strips {
        let strip = |index: usize| {
            let pixel = |place: u32| {
                let [x, y] = [place % u32::from(WIDTH), place / u32::from(WIDTH)];
                let texture = (x * 7 + y * 13 + index as u32 * 5) % 23;
                (if x < 20 + y / 6 { 60 } else { 170 }) + texture as u8
            };
            let pixels: Vec<u8> = (0..u32::from(WIDTH * ROWS)).map(pixel).collect();
            let mut bytes = Vec::new();
            image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 90)
                .encode(
                    &pixels,
                    WIDTH.into(),
                    ROWS.into(),
                    image::ExtendedColorType::L8,
                )
                .expect("memory takes it");
            bytes
        };
        Strips {
            tables: None,
            each: (0..STRIPS).map(strip).collect(),
        }
    }

    /// Moves the tables of quantisation and of Huffman codes, which all strips share, to the tag.
    fn with_tables(self) -> Strips {
        let mut tables = vec![0xff, 0xd8];
        let each = self.each.iter().enumerate().map(|(i, strip)| {
            let mut kept = strip[..2].to_vec();
            let mut at = 2;
            loop {
                let end = at + 2 + usize::from(u16::from_be_bytes([strip[at + 2], strip[at + 3]]));
                let segment = &strip[at..end];
                match segment[1] {
                    0xdb | 0xc4 if i == 0 => tables.extend(segment),
                    0xdb | 0xc4 => {}
                    _ => kept.extend(segment),
                }
                at = end;
                if segment[1] == 0xda {
                    break;
                }
            }
            kept.extend(&strip[at..]);
            kept
        });
        let each = each.collect();
        tables.extend([0xff, 0xd9]);
        Strips {
            tables: Some(tables),
            each,
        }
    }

    /// Writes the file. The strip `index` has `bytes` in place of its own.
    fn file(&self, index: usize, bytes: &[u8]) -> Vec<u8> {
        let mut file = b"II*\0\0\0\0\0".to_vec();
        let mut put = |part: &[u8]| {
            let at = file.len() as u32;
            file.extend(part);
            at
        };
        let each: Vec<&[u8]> = (0..STRIPS)
            .map(|i| if i == index { bytes } else { &self.each[i] })
            .collect();
        let starts: Vec<u32> = each.iter().map(|strip| put(strip)).collect();
        let lengths: Vec<u32> = each.iter().map(|strip| strip.len() as u32).collect();
        let list = |numbers: &[u32]| -> Vec<u8> {
            numbers
                .iter()
                .flat_map(|number| number.to_le_bytes())
                .collect()
        };
        let (starts, lengths) = (put(&list(&starts)), put(&list(&lengths)));
        let count = STRIPS as u32;
        let mut entries = vec![
            (256, 3, 1, u32::from(WIDTH)),
            (257, 3, 1, u32::from(ROWS) * count),
            (258, 3, 1, 8),
            (259, 3, 1, 7),
            (262, 3, 1, 1),
            (273, 4, count, starts),
            (277, 3, 1, 1),
            (278, 3, 1, u32::from(ROWS)),
            (279, 4, count, lengths),
        ];
        if let Some(tables) = &self.tables {
            entries.push((347, 7, tables.len() as u32, put(tables)));
        }
        let directory = file.len() as u32;
        file.extend((entries.len() as u16).to_le_bytes());
        for (tag, kind, count, value) in entries {
            file.extend(u16::to_le_bytes(tag));
            file.extend(u16::to_le_bytes(kind));
            file.extend(u32::to_le_bytes(count));
            file.extend(u32::to_le_bytes(value));
        }
        file.extend([0; 4]);
        file[4..8].copy_from_slice(&directory.to_le_bytes());
        file
    }
}

fn read(folder: &Path, bytes: &[u8]) -> Result<Photo, String> {
    let file = folder.join("photo.tif");
    std::fs::write(&file, bytes).expect("the folder takes files");
    photo::load(&file, &Decode::default()).map_err(|error| error.to_string())
}

/// The first and the last strip are cut at every fifth byte. The cut is left as it is, or the
/// marker of the end or zeros follow it.
#[test]
fn a_strip_that_is_cut_short_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut whole: Option<Vec<f32>> = None;
    let mut count = 0;
    for strips in [Strips::new(), Strips::new().with_tables()] {
        let file = strips.file(0, &strips.each[0]);
        let photo = read(folder.path(), &file).expect("it is whole");
        let size = (photo.width, photo.height);
        assert_eq!(size, (WIDTH.into(), STRIPS * usize::from(ROWS)));
        assert_eq!(photo.warnings.len(), 1, "{:?}", photo.warnings);
        assert_eq!(
            whole.get_or_insert(photo.luminance.clone()),
            &photo.luminance
        );
        for index in [0, STRIPS - 1] {
            let strip = &strips.each[index];
            // The marker of the end has 2 bytes, and the last byte of the data may be filling.
            for length in (0..strip.len() - 3).step_by(5) {
                let cut = &strip[..length];
                let ended = [cut, &[0xff, 0xd9]].concat();
                let filled = [cut, &vec![0; strip.len() - length]].concat();
                for bytes in [cut, &ended, &filled] {
                    let error = read(folder.path(), &strips.file(index, bytes)).err();
                    let error = error.unwrap_or_else(|| panic!("{index} cut to {length}"));
                    assert!(error.contains("again") && !error.contains('\n'), "{error}");
                    count += 1;
                }
            }
        }
    }
    assert!(count > 1000, "{count}");
}

/// Strips outside of the file, and strips that claim more than the file, are refused.
#[test]
fn strips_without_bytes_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let strips = Strips::new();
    let file = strips.file(0, &strips.each[0]);
    let directory = u32::from_le_bytes([file[4], file[5], file[6], file[7]]) as usize;
    let mut count = 0;
    // The entries of the offsets and of the lengths, counted from 0.
    for entry in [5, 8] {
        let value = directory + 2 + 12 * entry + 8;
        let list = u32::from_le_bytes(file[value..value + 4].try_into().expect("4 bytes"));
        for place in 0..STRIPS {
            let mut bytes = file.clone();
            let at = list as usize + 4 * place;
            bytes[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
            let error = read(folder.path(), &bytes).expect_err("it claims too much");
            assert!(error.contains("again"), "{error}");
            count += 1;
        }
    }
    assert_eq!(count, 6);
}
