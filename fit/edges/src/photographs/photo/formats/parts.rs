//! TIFF: the samples of the strips or tiles of a page (TIFF 6.0; JPEG by Technical Note 2 of 1995,
//! floats by Technical Note 3 of 2005).

use std::io::{Cursor, Read, Seek, SeekFrom};

use exr::prelude::f16;
use flate2::read::ZlibDecoder;
use weezl::decode::Configuration;
use weezl::{BitOrder, LzwStatus};

use crate::photographs::photo::formats::jpeg;
use crate::photographs::photo::formats::pages::{Tiff, whole};
use crate::photographs::photo::formats::tiff::{Page, damaged};
use crate::photographs::photo::{Fault, Samples};

const NONE: u64 = 1;
const LZW: u64 = 5;
pub(crate) const JPEG: u64 = 7;
const DEFLATE: [u64; 2] = [8, 32946];
const PACK_BITS: u64 = 32773;

/// The kinds of compression that are unpacked.
pub(crate) const UNPACKED: [u64; 6] = [NONE, LZW, JPEG, DEFLATE[0], DEFLATE[1], PACK_BITS];

impl Page {
    /// Unpacks the samples of a pixel that are used. If `spread`, whole numbers of at most 16 bits
    /// are spread over bytes or words.
    pub(crate) fn unpacked<R: Read + Seek>(
        &self,
        tiff: &mut Tiff<R>,
        spread: bool,
    ) -> Result<Samples, Fault> {
        let used = self.used() as usize;
        let [width, height] = [self.width, self.height].map(|side| side as usize);
        let [wide, long] = self.part.map(|side| side as usize);
        let count = width * height * used;
        let mut samples = match (self.format, self.bits) {
            (1, ..=8) => Samples::Bytes(vec![0; count]),
            (1, ..=16) => Samples::Words(vec![0; count]),
            (format, _) => Samples::Floats(vec![0.0; count], format != 3),
        };
        let (planes, stored) = match self.is_planar {
            true => (used, 1),
            false => (1, self.samples as usize),
        };
        let across = width.div_ceil(wide);
        let each = across * height.div_ceil(long);
        let mut row = vec![0; (wide * stored * self.bits as usize).div_ceil(8)];
        let mut is_little = tiff.is_little;
        for part in 0..planes * each {
            let (plane, place) = (part / each, part % each);
            let (left, top) = (place % across * wide, place / across * long);
            let rows = long.min(height - top);
            let mut data = self.part(tiff, part, rows * row.len())?;
            for y in top..top + rows {
                if data.read_exact(&mut row).is_err() {
                    let count = self.offsets.len();
                    return damaged(format!("part {} of {count} ends too early", part + 1));
                }
                if self.predictor == 3 {
                    row = gathered(&row, stored, self.bits as usize / 8);
                    is_little = false;
                }
                let end = (left + wide).min(width);
                let into = (y * width + left) * used + plane..(y * width + end) * used;
                let row = Row {
                    page: self,
                    bytes: &row,
                    stored,
                    is_little,
                };
                match &mut samples {
                    Samples::Bytes(all) => {
                        row.put(&mut all[into], used, |code| {
                            self.over(code, spread, 255) as u8
                        });
                    }
                    Samples::Words(all) => {
                        row.put(&mut all[into], used, |code| {
                            self.over(code, spread, 65535) as u16
                        });
                    }
                    Samples::Floats(all, _) => {
                        row.put(&mut all[into], used, |code| self.number(code));
                    }
                }
            }
        }
        Ok(samples)
    }

    /// Spreads a code from 0 to the largest one over the numbers from 0 to `full`.
    fn over(&self, code: u64, spread: bool, full: u64) -> u64 {
        let last = self.mask();
        if spread && last != full {
            (code * full + last / 2) / last
        } else {
            code
        }
    }

    /// Returns the number that a code stands for; whole ones as a share of the largest.
    fn number(&self, code: u64) -> f32 {
        let unused = 64 - self.bits;
        match (self.format, self.bits) {
            (1, _) => (code as f64 / self.mask() as f64) as f32,
            (2, _) => {
                let signed = (code << unused) as i64 >> unused;
                (signed as f64 / (self.mask() >> 1) as f64) as f32
            }
            (_, 16) => f16::from_bits(code as u16).to_f32(),
            (_, 32) => f32::from_bits(code as u32),
            _ => f64::from_bits(code) as f32,
        }
    }

    /// Returns the largest code.
    fn mask(&self) -> u64 {
        u64::MAX >> (64 - self.bits)
    }

    /// Returns the unpacked bytes of a part, of which `most` are used.
    fn part<'a, R: Read + Seek>(
        &self,
        tiff: &'a mut Tiff<R>,
        part: usize,
        most: usize,
    ) -> Result<Box<dyn Read + 'a>, Fault> {
        let file = &mut tiff.file;
        let sought = file.seek(SeekFrom::Start(self.offsets[part]));
        sought.or_else(|error| damaged(error.to_string()))?;
        let length = self.lengths[part];
        // Some files state wrong lengths for what needs none.
        match self.compression {
            NONE => return Ok(Box::new(file)),
            LZW | JPEG | PACK_BITS => {}
            _ => return Ok(Box::new(ZlibDecoder::new(file))),
        }
        // Many parts may claim the same bytes. Neither LZW nor PackBits takes more than this.
        let needed = match self.compression {
            JPEG => length,
            _ => length.min(2 * most as u64 + 1024),
        };
        let mut packed = Vec::new();
        file.take(needed).read_to_end(&mut packed)?;
        let size = self.part.map(|side| side as usize);
        let count = self.offsets.len();
        let here = |reason| Fault::CutShort(format!("in part {} of {count}: {reason}", part + 1));
        let bytes = match self.compression {
            LZW => of_lzw(&packed, most),
            PACK_BITS => of_pack_bits(&packed, most),
            _ if (packed.len() as u64) < length => {
                return Err(here("its bytes are missing".into()));
            }
            _ if self.tables.is_empty() => jpeg::unpacked(&packed, size).map_err(here)?,
            _ => {
                // The tables of all parts stand apart. The end of the tables and the start of the
                // part, markers of two bytes, would end the picture.
                let head = &self.tables[..self.tables.len().saturating_sub(2)];
                let whole = [head, packed.get(2..).unwrap_or_default()].concat();
                jpeg::unpacked(&whole, size).map_err(here)?
            }
        };
        Ok(Box::new(Cursor::new(bytes)))
    }
}

/// A row of a part.
struct Row<'a> {
    page: &'a Page,
    bytes: &'a [u8],
    /// Number of samples of a pixel.
    stored: usize,
    is_little: bool,
}

impl Row<'_> {
    /// Puts the values of samples into pixels of `used` samples.
    fn put<T>(&self, into: &mut [T], used: usize, value: impl Fn(u64) -> T) {
        let (bits, mask) = (self.page.bits as usize, self.page.mask());
        // With this predictor, a row holds the differences of neighbours.
        let adds = self.page.predictor == 2;
        let mut before = vec![0_u64; self.stored];
        for (x, pixel) in into.chunks_mut(used).enumerate() {
            for (k, before) in before.iter_mut().enumerate() {
                // The highest bit of a byte is the first.
                let from = (x * self.stored + k) * bits;
                let end = (from + bits).div_ceil(8);
                let bytes = &self.bytes[from / 8..end];
                let held = whole(bytes, self.is_little && bits.is_multiple_of(8));
                let code = held >> (8 * end - from - bits) & mask;
                *before = if adds {
                    before.wrapping_add(code) & mask
                } else {
                    code
                };
                if let Some(sample) = pixel.get_mut(k) {
                    *sample = value(*before);
                }
            }
        }
    }
}

/// Puts the bytes of a row of floats together, the highest first. A packed row holds the highest
/// bytes of all samples, then those below them, and of each byte the difference to that of the pixel
/// before it.
fn gathered(row: &[u8], stored: usize, size: usize) -> Vec<u8> {
    let mut bytes = row.to_vec();
    for i in stored..bytes.len() {
        bytes[i] = bytes[i].wrapping_add(bytes[i - stored]);
    }
    let count = bytes.len() / size;
    (0..bytes.len())
        .map(|i| bytes[i % size * count + i / size])
        .collect()
}

/// Unpacks LZW up to `most` bytes.
fn of_lzw(packed: &[u8], most: usize) -> Vec<u8> {
    let mut bytes = vec![0; most];
    let configuration = Configuration::with_tiff_size_switch(BitOrder::Msb, 8);
    let mut decoder = configuration.with_yield_on_full_buffer(true).build();
    let (mut read, mut written) = (0, 0);
    loop {
        let result = decoder.decode_bytes(&packed[read..], &mut bytes[written..]);
        (read, written) = (read + result.consumed_in, written + result.consumed_out);
        if written == most || !matches!(result.status, Ok(LzwStatus::Ok)) {
            bytes.truncate(written);
            return bytes;
        }
    }
}

/// Unpacks PackBits, until there are `most` bytes.
fn of_pack_bits(mut packed: &[u8], most: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while let [head, rest @ ..] = packed
        && bytes.len() < most
    {
        let taken = match head {
            0..=127 => (usize::from(*head) + 1).min(rest.len()),
            128 => 0,
            _ => 1.min(rest.len()),
        };
        let times = if *head > 128 {
            257 - usize::from(*head)
        } else {
            1
        };
        bytes.extend(rest[..taken].repeat(times));
        packed = &rest[taken..];
    }
    bytes
}
