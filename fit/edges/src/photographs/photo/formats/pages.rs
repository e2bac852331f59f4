//! TIFF: its directories, and which of its pages is the picture (TIFF 6.0).

use std::collections::HashSet;
use std::io;
use std::io::{BufReader, Read, Seek, SeekFrom};

use crate::photographs::photo::Fault;
use crate::photographs::photo::formats::tiff::damaged;

/// Largest number of pages that are followed, of pages within a page, and of entries of each.
const MOST_PAGES: usize = 4096;
const MOST_WITHIN: usize = 16;
const MOST_ENTRIES: u64 = 1024;

/// The tags that are used, by their numbers.
pub(crate) mod tag {
    pub(crate) const NEW_SUBFILE_TYPE: u16 = 254;
    pub(crate) const SUBFILE_TYPE: u16 = 255;
    pub(crate) const WIDTH: u16 = 256;
    pub(crate) const LENGTH: u16 = 257;
    pub(crate) const BITS: u16 = 258;
    pub(crate) const COMPRESSION: u16 = 259;
    pub(crate) const PHOTOMETRIC: u16 = 262;
    pub(crate) const FILL_ORDER: u16 = 266;
    pub(crate) const DESCRIPTION: u16 = 270;
    pub(crate) const STRIP_OFFSETS: u16 = 273;
    pub(crate) const ORIENTATION: u16 = 274;
    pub(crate) const SAMPLES: u16 = 277;
    pub(crate) const ROWS_PER_STRIP: u16 = 278;
    pub(crate) const STRIP_LENGTHS: u16 = 279;
    pub(crate) const PLANAR: u16 = 284;
    pub(crate) const PREDICTOR: u16 = 317;
    pub(crate) const COLOUR_MAP: u16 = 320;
    pub(crate) const TILE_WIDTH: u16 = 322;
    pub(crate) const TILE_LENGTH: u16 = 323;
    pub(crate) const TILE_OFFSETS: u16 = 324;
    pub(crate) const TILE_LENGTHS: u16 = 325;
    pub(crate) const SUB_DIRECTORIES: u16 = 330;
    pub(crate) const EXTRA_SAMPLES: u16 = 338;
    pub(crate) const SAMPLE_FORMAT: u16 = 339;
    pub(crate) const JPEG_TABLES: u16 = 347;
    pub(crate) const YCBCR_SUBSAMPLING: u16 = 530;
    pub(crate) const ICC_PROFILE: u16 = 34675;
    pub(crate) const DNG_VERSION: u16 = 50706;
}

/// Values of `PhotometricInterpretation` for a mosaic of colours, and for raw data without one
/// (TIFF/EP, DNG).
const RAW: [u64; 2] = [32803, 34892];

/// A TIFF whose directories can be read.
pub(crate) struct Tiff<R> {
    pub(crate) file: R,
    pub(crate) length: u64,
    is_big: bool,
    pub(crate) is_little: bool,
}

/// One entry of a directory: its tag, type, number of values, and the place of the first of them.
#[derive(Clone, Copy)]
struct Entry {
    tag: u16,
    kind: u64,
    count: u64,
    at: u64,
}

/// A directory: the description of one page.
pub(crate) struct Directory {
    entries: Vec<Entry>,
    /// Place of the next directory; 0 behind the last.
    next: u64,
}

impl<R: Read + Seek> Tiff<R> {
    /// Reads the header, and returns the place of the first directory.
    pub(super) fn open(mut file: R) -> io::Result<(Tiff<R>, u64)> {
        let length = file.seek(SeekFrom::End(0))?;
        let mut tiff = Tiff {
            file,
            length,
            is_big: false,
            is_little: true,
        };
        let mut order = [0; 2];
        tiff.file.rewind()?;
        tiff.file.read_exact(&mut order)?;
        tiff.is_little = &order == b"II";
        let version = tiff.number(2, 2)?;
        if !matches!((&order, version), (b"II" | b"MM", 42 | 43)) {
            return Err(io::ErrorKind::InvalidData.into());
        }
        tiff.is_big = version == 43;
        let first = if tiff.is_big {
            tiff.number(8, 8)?
        } else {
            tiff.number(4, 4)?
        };
        Ok((tiff, first))
    }

    /// Reads a whole number of `size` bytes.
    fn number(&mut self, at: u64, size: usize) -> io::Result<u64> {
        let mut bytes = [0; 8];
        self.file.seek(SeekFrom::Start(at))?;
        self.file.read_exact(&mut bytes[..size])?;
        Ok(whole(&bytes[..size], self.is_little))
    }

    fn directory(&mut self, at: u64) -> io::Result<Directory> {
        let (size, wide) = if self.is_big { (8, 8) } else { (2, 4) };
        let count = self.number(at, size)?.min(MOST_ENTRIES);
        let stride = 4 + 2 * wide;
        let mut bytes = vec![0; count as usize * stride];
        self.file.read_exact(&mut bytes)?;
        let first = at.saturating_add(size as u64);
        let entries = bytes.chunks_exact(stride).zip(0_u64..);
        let entries = entries.map(|(bytes, i)| {
            let read = |from: usize, size: usize| whole(&bytes[from..from + size], self.is_little);
            let (kind, count) = (read(2, 2), read(4, wide));
            let inline = count.saturating_mul(width(kind) as u64) <= wide as u64;
            Entry {
                tag: read(0, 2) as u16,
                kind,
                count,
                at: if inline {
                    first + i * stride as u64 + 4 + wide as u64
                } else {
                    read(4 + wide, wide)
                },
            }
        });
        let entries: Vec<Entry> = entries.collect();
        // A file may end behind its last entry.
        let next = self.number(first.saturating_add(bytes.len() as u64), wide);
        Ok(Directory {
            entries,
            next: next.unwrap_or(0),
        })
    }

    /// Reads the directories of all pages in their order. Those behind a damaged one are left out.
    fn pages(&mut self, first: u64) -> Vec<Directory> {
        let (mut pages, mut seen, mut at) = (Vec::new(), HashSet::new(), first);
        while at != 0 && pages.len() < MOST_PAGES && seen.insert(at) {
            let Ok(page) = self.directory(at) else { break };
            at = page.next;
            pages.push(page);
        }
        pages
    }

    /// Reads the directories within a page.
    fn within(&mut self, page: &Directory) -> Vec<Directory> {
        let places = self.values(page, tag::SUB_DIRECTORIES).unwrap_or_default();
        let places = places.into_iter().take(MOST_WITHIN);
        places.filter_map(|at| self.directory(at).ok()).collect()
    }

    /// Reads the bytes of an entry; none if the page has no such entry.
    pub(crate) fn bytes(&mut self, page: &Directory, tag: u16) -> Result<Vec<u8>, Fault> {
        let Some(entry) = page.entries.iter().find(|entry| entry.tag == tag) else {
            return Ok(Vec::new());
        };
        let size = entry.count.saturating_mul(width(entry.kind) as u64);
        let read = |file: &mut R| {
            let mut bytes = vec![0; size as usize];
            file.seek(SeekFrom::Start(entry.at))?;
            file.read_exact(&mut bytes).map(|()| bytes)
        };
        // More would take memory that the file does not account for.
        let read = (size <= self.length).then(|| read(&mut self.file));
        match read {
            Some(Ok(bytes)) => Ok(bytes),
            _ => damaged(format!("the values of its tag {tag} lie behind its end")),
        }
    }

    /// Reads the whole numbers of an entry; none if the page has no such entry.
    pub(crate) fn values(&mut self, page: &Directory, tag: u16) -> Result<Vec<u64>, Fault> {
        let bytes = self.bytes(page, tag)?;
        let Some(entry) = page.entries.iter().find(|entry| entry.tag == tag) else {
            return Ok(Vec::new());
        };
        if !matches!(entry.kind, 1 | 3 | 4 | 7 | 13 | 16 | 18) {
            return damaged(format!("its tag {tag} holds no whole numbers"));
        }
        let values = bytes.chunks_exact(width(entry.kind));
        Ok(values.map(|value| whole(value, self.is_little)).collect())
    }

    /// Reads the first number of an entry.
    pub(crate) fn value(&mut self, page: &Directory, tag: u16) -> Result<Option<u64>, Fault> {
        Ok(self.values(page, tag)?.first().copied())
    }

    /// Returns whether a page is a smaller copy of another page, or its mask.
    fn is_copy(&mut self, page: &Directory) -> bool {
        let mut value = |tag| self.value(page, tag).ok().flatten();
        match value(tag::NEW_SUBFILE_TYPE) {
            Some(bits) => bits & 0b101 != 0,
            None => value(tag::SUBFILE_TYPE) == Some(2),
        }
    }

    pub(crate) fn size(&mut self, page: &Directory) -> [Option<u64>; 2] {
        [tag::WIDTH, tag::LENGTH].map(|tag| self.value(page, tag).ok().flatten())
    }
}

/// Returns the number of bytes of a value of a type.
fn width(kind: u64) -> usize {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16..=18 => 8,
        _ => 1,
    }
}

/// Returns the number of these bytes.
pub(crate) fn whole(bytes: &[u8], is_little: bool) -> u64 {
    let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
    if is_little {
        bytes.iter().rev().fold(0, add)
    } else {
        bytes.iter().fold(0, add)
    }
}

/// Returns whether a TIFF is camera raw whatever its name: a DNG, or a file with a page of sensor
/// data. Its first page is then often a thumbnail.
pub(crate) fn is_raw(file: impl Read + Seek) -> bool {
    let Ok((mut tiff, first)) = Tiff::open(BufReader::new(file)) else {
        return false;
    };
    let pages = tiff.pages(first);
    pages.iter().any(|page| {
        let parts = tiff.within(page);
        [page].into_iter().chain(&parts).any(|page| {
            let photometric = tiff.value(page, tag::PHOTOMETRIC).ok().flatten();
            page.entries.iter().any(|e| e.tag == tag::DNG_VERSION)
                || photometric.is_some_and(|it| RAW.contains(&it))
        })
    })
}

impl<R: Read + Seek> Tiff<R> {
    /// Finds the page that is the picture. Returns warnings about pages that are not read.
    pub(crate) fn picture(&mut self, first: u64) -> Result<(Directory, Vec<String>), Fault> {
        let mut pages = self.pages(first);
        let count = pages.len();
        let full: Vec<usize> = (0..count).filter(|&i| !self.is_copy(&pages[i])).collect();
        let Some(&chosen) = full.first() else {
            // All pages are smaller copies: the picture may lie within one of them.
            let mut within: Vec<Directory> = Vec::new();
            for page in &pages {
                within.extend(self.within(page));
            }
            let large = within.iter().position(|page| !self.is_copy(page));
            let text = "its first page is a smaller copy; the picture within it was read";
            return match (large, pages.is_empty()) {
                (Some(index), _) => Ok((within.swap_remove(index), vec![text.into()])),
                (None, true) => damaged("it has no pages"),
                (None, false) => {
                    let text = "all pages say that they are smaller copies of a picture that is \
                        not there; the first one was read";
                    Ok((pages.swap_remove(0), vec![text.into()]))
                }
            };
        };
        let mut warnings = Vec::new();
        if chosen > 0 {
            warnings.push(format!(
                "page {} of the file was read: the pages before it are smaller copies",
                chosen + 1
            ));
        }
        let own = self.size(&pages[chosen]);
        let others = full.len() - 1;
        // ImageJ writes large stacks behind one directory.
        let text = self
            .bytes(&pages[chosen], tag::DESCRIPTION)
            .unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let named = text.strip_prefix("ImageJ=").and_then(|text| {
            let counts = text.lines().find_map(|line| line.strip_prefix("images="));
            counts?.trim().parse::<usize>().ok()
        });
        let others = others.max(named.unwrap_or(1).saturating_sub(1));
        if others > 0 {
            let larger = full.iter().find(|&&i| {
                let other = self.size(&pages[i]);
                (0..2).all(|side| other[side] > own[side])
            });
            let larger = larger.map_or(String::new(), |i| format!(" (page {} is larger)", i + 1));
            warnings.push(format!(
                "the file holds {others} more pages, which were left out{larger}; save each page \
                as a file to use it"
            ));
        }
        Ok((pages.swap_remove(chosen), warnings))
    }
}
