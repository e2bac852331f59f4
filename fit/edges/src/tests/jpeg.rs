//! Tests that a JPEG that is not whole is refused, however it was written.
//!
//! The four files in tests/jpeg hold the same coefficients: sequential, progressive, and both with
//! restart markers. libjpeg wrote them.

use std::path::{Path, PathBuf};

use crate::photographs::photo::channel::Decode;
use crate::photographs::photo::plane::Photo;
use crate::photographs::{Roi, Shot, photo};

const FILES: [&str; 4] = [
    "sequential",
    "progressive",
    "restarts",
    "progressive_restarts",
];

/// Number of places at which each file is cut.
const CUTS: usize = 80;

fn kept(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/jpeg");
    std::fs::read(folder.join(name).with_extension("jpg")).expect("it is in the repository")
}

/// A folder for one file at a time.
struct Bench(tempfile::TempDir);

impl Bench {
    fn new() -> Bench {
        Bench(tempfile::tempdir().expect("a temporary folder"))
    }

    fn file(&self) -> PathBuf {
        self.0.path().join("photo.jpg")
    }

    fn read(&self, bytes: &[u8]) -> Result<Photo, String> {
        std::fs::write(self.file(), bytes).expect("the folder takes files");
        photo::load(&self.file(), &Decode::default()).map_err(|error| error.to_string())
    }

    /// Refuses the bytes, or fails.
    fn refused(&self, bytes: &[u8], what: &str) {
        let error = self.read(bytes).expect_err(what);
        assert!(
            error.starts_with(&self.file().display().to_string()),
            "{error}"
        );
        assert!(error.contains("again") && !error.contains('\n'), "{error}");
    }
}

#[test]
fn whole_files_are_read_alike_with_anything_behind_their_end() {
    let bench = Bench::new();
    let sequential = bench.read(&kept(FILES[0])).expect("it is whole");
    assert_eq!((sequential.width, sequential.height), (83, 61));
    for name in FILES {
        let whole = kept(name);
        let behind = [&whole[..], b"a preview", &whole].concat();
        // Fill bytes may stand before any marker.
        let end = whole.len() - 2;
        let filled = [&whole[..end], &[0xff; 5], &whole[end..]].concat();
        for bytes in [whole, behind, filled] {
            let photo = bench.read(&bytes).expect(name);
            assert_eq!(photo.luminance, sequential.luminance, "{name}");
            assert_eq!(photo.warnings.len(), 1, "{:?}", photo.warnings);
        }
    }
}

/// A file that ends early is refused, also if the marker of the end, or the rest of a thumbnail's
/// file, was put behind the cut.
#[test]
fn files_that_are_cut_short_are_refused() {
    let bench = Bench::new();
    let mut count = 0;
    for name in FILES {
        let whole = kept(name);
        for cut in 0..CUTS {
            // The first three bytes tell that it is a JPEG.
            let length = 3 + (whole.len() - 3) * cut / CUTS;
            let rest = &whole[..length];
            bench.refused(rest, &format!("{name} cut to {length} bytes"));
            let ended = [rest, &[0xff, 0xd9]].concat();
            bench.refused(&ended, &format!("{name} cut to {length} bytes and ended"));
            count += 2;
        }
        for lost in 1..3 {
            bench.refused(&whole[..whole.len() - lost], "the end itself is cut");
            count += 1;
        }
    }
    assert_eq!(count, 4 * (2 * CUTS + 2));
}

/// The end of a thumbnail inside the header is not taken for the end of the picture.
#[test]
fn a_thumbnail_does_not_end_the_picture() {
    let bench = Bench::new();
    let mut count = 0;
    for name in FILES {
        let thumbnail = [b"Exif\0\0", &kept(FILES[0])[..]].concat();
        let length = (thumbnail.len() as u16 + 2).to_be_bytes();
        let whole = kept(name);
        let mut bytes = whole[..2].to_vec();
        bytes.extend([0xff, 0xe1]);
        bytes.extend(length);
        bytes.extend(&thumbnail);
        bytes.extend(&whole[2..]);
        assert!(bench.read(&bytes).is_ok(), "{name}");
        for cut in 1..CUTS {
            bench.refused(&bytes[..bytes.len() * cut / CUTS], name);
            count += 1;
        }
    }
    assert_eq!(count, 4 * (CUTS - 1));
}

/// A piece that is missing in the middle leaves fewer blocks, which is noticed nearly always: of
/// these pieces of a twentieth in all sequential files, and in 9 of 10 progressive ones, where a
/// code may stand for a run of many blocks.
#[test]
fn missing_pieces_are_noticed() {
    let bench = Bench::new();
    let mut noticed = Vec::new();
    for name in FILES {
        let whole = kept(name);
        let scan = whole.windows(2).position(|pair| pair == [0xff, 0xda]);
        let first = scan.expect("it has a scan") + 14;
        let piece = whole.len() / 20;
        let mut found = 0;
        for k in 0..CUTS {
            let from = first + (whole.len() - first - piece - 2) * k / CUTS;
            let rest = [&whole[..from], &whole[from + piece..]].concat();
            let told = match bench.read(&rest) {
                Err(_) => true,
                Ok(photo) => photo
                    .warnings
                    .iter()
                    .any(|w| w.contains("behind the last pixels")),
            };
            found += usize::from(told);
        }
        noticed.push(found);
    }
    println!("{noticed:?} of {CUTS}");
    assert!(
        noticed[0] >= CUTS - 1 && noticed[2] >= CUTS - 1,
        "{noticed:?}"
    );
    assert!(
        noticed[1] > CUTS * 8 / 10 && noticed[3] > CUTS * 8 / 10,
        "{noticed:?}"
    );
}

/// Data behind the last block are warned of.
#[test]
fn data_behind_the_last_block_are_warned_of() {
    let bench = Bench::new();
    for name in FILES {
        let whole = kept(name);
        let end = whole.len() - 2;
        let more = [&whole[..end], b"more", &whole[end..]].concat();
        let photo = bench.read(&more).expect("all blocks are there");
        let said = "4 bytes of its data lie behind the last pixels";
        assert!(photo.warnings[0].contains(said), "{:?}", photo.warnings);
    }
}

/// A region counts in the picture as shown: the stored picture has 83 x 61 pixels, and its Exif
/// orientation 6 turns it to 61 x 83.
#[test]
fn a_region_counts_in_the_picture_as_shown() {
    let bench = Bench::new();
    let whole = kept(FILES[0]);
    // One entry: tag 274 (Orientation), type SHORT, one value.
    let mut exif = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0".to_vec();
    exif.extend([0; 4]);
    let mut bytes = whole[..2].to_vec();
    bytes.extend([0xff, 0xe1]);
    bytes.extend((exif.len() as u16 + 2).to_be_bytes());
    bytes.extend(&exif);
    bytes.extend(&whole[2..]);
    let (turned, stored) = (bench.read(&bytes).expect("it is whole"), bench.read(&whole));
    let stored = stored.expect("it is whole");
    assert_eq!((turned.width, turned.height), (61, 83));
    // Orientation 6: the first row of the file is the right side of the picture.
    for (x, y) in [(0, 0), (17, 5), (82, 60)] {
        assert_eq!(turned.at(60 - y, x), stored.at(x, y), "{x} {y}");
    }
    let said = |bytes: &[u8], width, height| {
        bench.read(bytes).expect("it is whole");
        let mut shot = Shot::named(bench.file(), 1.0);
        shot.roi = Some(Roi {
            x: 0,
            y: 0,
            width,
            height,
        });
        shot.load().err().map(|error| error.to_string())
    };
    assert_eq!(said(&bytes, 61, 83), None);
    let error = said(&bytes, 83, 61).expect("it reaches beyond");
    let words = "which is 61 x 83 pixels as shown, turned by its Exif orientation; correct `roi`";
    assert!(error.contains(words), "{error}");
    let error = said(&whole, 61, 83).expect("it reaches beyond");
    assert!(
        error.contains("which is 83 x 61 pixels; correct `roi`"),
        "{error}"
    );
}
