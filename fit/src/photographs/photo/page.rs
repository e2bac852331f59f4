//! TIFF: the samples of the page that is the picture (TIFF 6.0).
//!
//! The crate `tiff` unpacks strips and tiles. It reads no palettes, no packed samples of 9 to 15
//! bits and no picture behind a directory that it cannot name, and it panics on planes in tiles. So
//! it is given each plane as a grey picture: by a directory that is written here and stands before
//! the file. What the samples mean is decided here.

use std::fs::File;
use std::io::{BufReader, Read, Result as IoResult, Seek, SeekFrom};
use std::path::Path;

use image::metadata::Orientation;
use tiff::decoder::{Decoder, DecodingResult, Limits};

use crate::photographs::photo::error::Error;
use crate::photographs::photo::format::Format;
use crate::photographs::photo::icc;
use crate::photographs::photo::limits::{MAX_BYTES, check_packed, check_size};
use crate::photographs::photo::pages::{Directory, Tiff, tag, width};
use crate::photographs::photo::samples::{Alpha, Samples, Stored};
use crate::photographs::photo::strips;

/// Values of `PhotometricInterpretation`.
mod colours {
    pub(super) const WHITE_IS_ZERO: u64 = 0;
    pub(super) const BLACK_IS_ZERO: u64 = 1;
    pub(super) const RGB: u64 = 2;
    pub(super) const PALETTE: u64 = 3;
    pub(super) const CMYK: u64 = 5;
    pub(super) const YCBCR: u64 = 6;
}

/// Compression by JPEGs.
const JPEG: u64 = 7;

/// The kinds of compression that the decoder unpacks: none, LZW, JPEG, Deflate (two numbers) and
/// PackBits.
const UNPACKED: [u64; 6] = [1, 5, JPEG, 8, 32946, 32773];

/// A reason why a page cannot be read.
enum Fault {
    /// The file is damaged, in words.
    Damaged(String),
    /// The page is of a kind that is not read, in words.
    Unread(String),
}

impl Fault {
    fn of(self, path: &Path) -> Error {
        let (file, format) = (path.to_owned(), Format::Tiff);
        match self {
            Fault::Damaged(reason) => Error::Damaged {
                file,
                format,
                reason,
            },
            Fault::Unread(what) => Error::Unread { file, format, what },
        }
    }
}

impl From<String> for Fault {
    fn from(reason: String) -> Fault {
        Fault::Damaged(reason)
    }
}

fn damaged<T>(reason: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Damaged(reason.into()))
}

fn unread<T>(what: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Unread(what.into()))
}

/// The picture of a TIFF.
pub(crate) struct Opened {
    /// Its samples.
    pub(crate) stored: Stored,
    pub(crate) orientation: Orientation,
    /// Its ICC profile, if it has one, or why that cannot be used.
    pub(crate) profile: Result<Option<Vec<u8>>, String>,
    pub(crate) warnings: Vec<String>,
}

/// Reads the picture of a TIFF: its first page that is neither a smaller copy nor a mask.
pub(crate) fn read(path: &Path, file: BufReader<File>) -> Result<Opened, Error> {
    let fault = |fault: Fault| fault.of(path);
    let broken = |reason: String| fault(Fault::Damaged(reason));
    let (mut tiff, first) = Tiff::open(file).map_err(|error| broken(error.to_string()))?;
    let (directory, mut warnings) = tiff.picture(first).map_err(broken)?;
    let page = Page::new(&mut tiff, &directory).map_err(fault)?;
    check_size(path, page.width, page.height)?;
    if page.photometric == colours::CMYK {
        return Err(Error::Cmyk {
            file: path.to_owned(),
        });
    }
    page.check().map_err(fault)?;
    check_packed(path, [page.width, page.height], page.memory())?;
    let profile = tiff.bytes(&directory, tag::ICC_PROFILE);
    let cut_short = |reason| Error::CutShort {
        file: path.to_owned(),
        reason,
    };
    warnings.extend(page.doubts());
    if page.compression == JPEG {
        let tables = (!page.tables.is_empty()).then_some(&page.tables[..]);
        let whole = strips::check(&mut tiff.file, tables, &page.offsets, &page.lengths);
        warnings.extend(whole.map_err(cut_short)?.warning);
    }
    Ok(Opened {
        stored: page.stored(&mut tiff).map_err(fault)?,
        orientation: page.orientation,
        profile: match profile {
            Ok(bytes) => Ok((!bytes.is_empty()).then_some(bytes)),
            Err(_) => Err(icc::DAMAGED.to_owned()),
        },
        warnings,
    })
}

/// The description of one page.
struct Page {
    width: u64,
    height: u64,
    /// Bits of a sample.
    bits: u64,
    /// Kind of the samples: 1 whole numbers, 2 signed ones, 3 floats.
    format: u64,
    photometric: u64,
    compression: u64,
    predictor: u64,
    /// Number of samples of a pixel, and what those beyond the colours are.
    samples: u64,
    extra: Vec<u64>,
    is_planar: bool,
    fill_order: u64,
    subsampling: Vec<u64>,
    orientation: Orientation,
    /// Width and length of a tile, or the rows of a strip.
    tile: Option<[u64; 2]>,
    rows_per_strip: u64,
    offsets: Vec<u64>,
    lengths: Vec<u64>,
    tables: Vec<u8>,
    palette: Vec<u64>,
}

impl Page {
    fn new<R: Read + Seek>(tiff: &mut Tiff<R>, page: &Directory) -> Result<Page, Fault> {
        let [Some(width), Some(height)] = tiff.size(page) else {
            return damaged("it states no size");
        };
        let Some(photometric) = tiff.value(page, tag::PHOTOMETRIC)? else {
            return damaged("it does not state what its samples mean");
        };
        let all_alike = |values: Vec<u64>, what: &str| match values.first() {
            Some(first) if values.iter().any(|v| v != first) => {
                unread(format!("samples of unlike {what}"))
            }
            first => Ok(first.copied().unwrap_or(1)),
        };
        let tile = [tag::TILE_WIDTH, tag::TILE_LENGTH].map(|tag| tiff.value(page, tag));
        let [wide, long] = tile;
        let tile = wide?.zip(long?).map(|(wide, long)| [wide, long]);
        let (offsets, lengths) = match tile {
            Some(_) => (tag::TILE_OFFSETS, tag::TILE_LENGTHS),
            None => (tag::STRIP_OFFSETS, tag::STRIP_LENGTHS),
        };
        let or_one = |value: Option<u64>| value.unwrap_or(1);
        let orientation = tiff.value(page, tag::ORIENTATION)?;
        let orientation = orientation.and_then(|it| Orientation::from_exif(it.min(255) as u8));
        Ok(Page {
            width,
            height,
            bits: all_alike(tiff.values(page, tag::BITS)?, "bits")?,
            format: all_alike(tiff.values(page, tag::SAMPLE_FORMAT)?, "kinds")?,
            photometric,
            compression: or_one(tiff.value(page, tag::COMPRESSION)?),
            predictor: or_one(tiff.value(page, tag::PREDICTOR)?),
            samples: or_one(tiff.value(page, tag::SAMPLES)?),
            extra: tiff.values(page, tag::EXTRA_SAMPLES)?,
            is_planar: tiff.value(page, tag::PLANAR)? == Some(2),
            fill_order: or_one(tiff.value(page, tag::FILL_ORDER)?),
            subsampling: tiff.values(page, tag::YCBCR_SUBSAMPLING)?,
            orientation: orientation.unwrap_or(Orientation::NoTransforms),
            tile,
            rows_per_strip: tiff
                .value(page, tag::ROWS_PER_STRIP)?
                .unwrap_or(height)
                .clamp(1, height.max(1)),
            offsets: tiff.values(page, offsets)?,
            lengths: tiff.values(page, lengths)?,
            tables: tiff.bytes(page, tag::JPEG_TABLES)?,
            palette: tiff.values(page, tag::COLOUR_MAP)?,
        })
    }

    /// Returns whether samples end within a byte.
    fn is_odd(&self) -> bool {
        !self.bits.is_multiple_of(8)
    }

    /// Returns the number of samples that are colours.
    fn colours(&self) -> u64 {
        match self.photometric {
            colours::RGB | colours::YCBCR => 3,
            _ => 1,
        }
    }

    /// Refuses what is not read.
    fn check(&self) -> Result<(), Fault> {
        if !UNPACKED.contains(&self.compression) {
            let name = match self.compression {
                2..=4 => "fax",
                6 => "JPEG of an old kind",
                33003 | 33005 | 34712 => "JPEG 2000",
                34887 => "LERC",
                34925 => "LZMA",
                34927 | 50001 => "WebP",
                50000 => "ZSTD",
                50002 => "JPEG XL",
                other => return unread(format!("data of compression {other}")),
            };
            return unread(format!("data packed by {name}"));
        }
        let colours = match self.photometric {
            colours::WHITE_IS_ZERO | colours::BLACK_IS_ZERO => "grey",
            colours::RGB => "RGB",
            colours::PALETTE => "a palette",
            colours::YCBCR => "YCbCr",
            4 => return unread("a mask"),
            8..=10 => return unread("colours in L*a*b*"),
            32844 | 32845 => return unread("colours in LogLuv"),
            other => return unread(format!("colours of the kind {other}")),
        };
        let kind = match self.format {
            1 => "",
            2 => "signed ",
            3 => "floats of ",
            other => return unread(format!("samples of the kind {other}")),
        };
        let bits = self.bits;
        let odd = self.is_odd();
        let fits = match self.format {
            1 => matches!(bits, 1 | 2 | 4 | 8..=16 | 32 | 64),
            2 => matches!(bits, 8 | 16 | 32 | 64),
            _ => matches!(bits, 16 | 32 | 64),
        };
        let plain = self.photometric == colours::BLACK_IS_ZERO
            || self.photometric == colours::WHITE_IS_ZERO && self.format != 2;
        let coloured = match self.photometric {
            colours::PALETTE => self.format == 1 && bits <= 8,
            colours::YCBCR => self.format == 1 && bits == 8,
            colours::RGB => true,
            _ => plain,
        };
        // Samples of less than a byte are unpacked for one sample a pixel, without a predictor.
        let packed = odd && (self.samples > 1 || self.predictor != 1 || self.compression == JPEG);
        if !fits || !coloured || packed {
            return unread(format!("{colours} in samples of {kind}{bits} bits"));
        }
        let subsampled = self.photometric == colours::YCBCR
            && self.compression != JPEG
            && self.subsampling != [1, 1];
        if subsampled {
            return unread("YCbCr with fewer colours than pixels");
        }
        if self.fill_order != 1 {
            return unread("bytes whose bits are reversed (FillOrder 2)");
        }
        if odd && self.tile.is_some_and(|[wide, _]| wide % 8 != 0) {
            return unread("tiles whose rows end within a byte");
        }
        self.check_parts()
    }

    /// Refuses a directory that contradicts itself.
    fn check_parts(&self) -> Result<(), Fault> {
        /// Largest side of a tile beyond the picture, pixels: rows of a tile take memory.
        const MOST_WIDE: u64 = 1 << 16;
        let colours = self.colours();
        if self.samples < colours || self.samples > u16::MAX.into() {
            let samples = self.samples;
            return damaged(format!("it states {samples} samples for {colours} colours"));
        }
        let planes = if self.is_planar { self.samples } else { 1 };
        let parts = match self.tile {
            Some([0, _] | [_, 0]) => return damaged("its tiles have no size"),
            Some(tile) if tile.iter().any(|&side| side > MOST_WIDE.max(self.width)) => {
                return damaged("its tiles are far larger than the picture");
            }
            Some([wide, long]) => self
                .width
                .div_ceil(wide)
                .saturating_mul(self.height.div_ceil(long)),
            None => self.height.div_ceil(self.rows_per_strip),
        };
        let parts = parts.saturating_mul(planes);
        if self.offsets.len() as u64 != parts || self.lengths.len() as u64 != parts {
            return damaged(format!(
                "it states {} places and {} lengths for {parts} parts",
                self.offsets.len(),
                self.lengths.len()
            ));
        }
        if self.photometric == colours::PALETTE && self.palette.len() != 3 << self.bits {
            return damaged("its palette has a wrong number of colours");
        }
        Ok(())
    }

    /// Returns the memory that a pixel takes, bytes.
    fn memory(&self) -> u64 {
        let unpacked = match (self.format, self.bits) {
            (1, 0..=8) => 1,
            (1, 9..=16) => 2,
            (3, 32) => 4,
            (_, bits) => bits / 8 + 4,
        };
        let colours = if self.photometric == colours::PALETTE {
            3
        } else {
            0
        };
        self.samples * unpacked + colours
    }

    /// Returns warnings about a palette that may stand for grey values, and about samples that are
    /// not used.
    fn doubts(&self) -> Vec<String> {
        let is_coloured = self.photometric == colours::PALETTE && !self.is_grey();
        let palette = is_coloured.then(|| {
            "its colours come from a palette: if they only show values of light in false colours, \
            save the picture as grey"
                .into()
        });
        let unused = self.samples - self.used();
        let unused = (unused > 0).then(|| {
            format!(
                "each pixel has {} samples, and the file says of {} that they are colours: the \
                {unused} behind them were ignored; save colours as RGB",
                self.samples,
                self.colours()
            )
        });
        palette.into_iter().chain(unused).collect()
    }

    /// Returns whether the palette holds greys only.
    fn is_grey(&self) -> bool {
        let each = self.palette.len() / 3;
        (0..each).all(|i| {
            let [red, green, blue] = [0, 1, 2].map(|k| self.palette[k * each + i] >> 8);
            red == green && green == blue
        })
    }

    fn alpha(&self) -> Alpha {
        let colours = self.colours();
        match self.extra.first() {
            _ if self.samples <= colours => Alpha::None,
            Some(1) => Alpha::Premultiplied,
            Some(2) => Alpha::Straight,
            // A fourth sample of RGB that the file does not explain is transparency by custom.
            None if colours == 3 && self.samples == 4 => Alpha::Straight,
            _ => Alpha::None,
        }
    }

    /// Returns the number of samples that are used.
    fn used(&self) -> u64 {
        self.colours() + u64::from(self.alpha() != Alpha::None)
    }

    /// Unpacks the samples, and turns those of palettes and YCbCr into grey or RGB.
    fn stored<R: Read + Seek>(&self, tiff: &mut Tiff<R>) -> Result<Stored, Fault> {
        let (samples, channels) = if self.is_planar && self.samples > 1 {
            let (each, used) = (self.offsets.len() / self.samples as usize, self.used());
            let planes: Result<Vec<Samples>, Fault> = (0..used as usize)
                .map(|plane| self.unpacked(tiff, plane * each..(plane + 1) * each, 1))
                .collect();
            (Samples::interleaved(planes?), used)
        } else {
            let all = 0..self.offsets.len();
            (self.unpacked(tiff, all, self.samples)?, self.samples)
        };
        let mut stored = Stored {
            size: [self.width as usize, self.height as usize],
            samples,
            channels: channels as usize,
            has_colour: self.colours() == 3,
            alpha: self.alpha(),
        };
        match (self.photometric, &mut stored.samples) {
            (colours::WHITE_IS_ZERO, samples) => samples.invert(channels as usize),
            (colours::YCBCR, Samples::Bytes(bytes)) => {
                bytes
                    .chunks_exact_mut(stored.channels)
                    .for_each(rgb_of_ycbcr);
            }
            (colours::PALETTE, Samples::Bytes(codes)) => {
                // Codes of fewer bits were spread over a byte.
                let last = (1 << self.bits) - 1;
                let each = self.palette.len() / 3;
                let channels = if self.is_grey() { 1 } else { 3 };
                let pixels = codes.chunks_exact(stored.channels);
                let coloured = pixels.flat_map(|pixel| {
                    let index = usize::from(pixel[0]) * last / 255;
                    (0..channels).map(move |k| (self.palette[k * each + index] >> 8) as u8)
                });
                stored.samples = Samples::Bytes(coloured.collect());
                stored.channels = channels;
                stored.has_colour = channels == 3;
                stored.alpha = Alpha::None;
            }
            _ => {}
        }
        Ok(stored)
    }

    /// Unpacks strips or tiles of `samples` samples a pixel.
    fn unpacked<R: Read + Seek>(
        &self,
        tiff: &mut Tiff<R>,
        parts: std::ops::Range<usize>,
        samples: u64,
    ) -> Result<Samples, Fault> {
        let head = head(self.entries(parts, samples), tiff.is_little);
        let failed = |error: tiff::TiffError| Fault::Damaged(error.to_string());
        let mut limits = Limits::default();
        limits.decoding_buffer_size = MAX_BYTES as usize;
        limits.intermediate_buffer_size = MAX_BYTES as usize;
        let behind = Behind {
            head,
            file: &mut tiff.file,
            at: 0,
        };
        let decoder = Decoder::new(behind).map_err(failed)?;
        let found = decoder.with_limits(limits).read_image().map_err(failed)?;
        fn shares<T>(whole: Vec<T>, share: impl Fn(T) -> f64) -> Samples {
            Samples::Floats(whole.into_iter().map(|v| share(v) as f32).collect(), true)
        }
        fn floats<T>(values: Vec<T>, value: impl Fn(T) -> f32) -> Samples {
            Samples::Floats(values.into_iter().map(value).collect(), false)
        }
        Ok(match found {
            DecodingResult::U8(bytes) if self.bits == 8 => Samples::Bytes(bytes),
            DecodingResult::U8(bytes) => self.spread(&bytes),
            DecodingResult::U16(words) => Samples::Words(words),
            DecodingResult::U32(v) => shares(v, |v| f64::from(v) / f64::from(u32::MAX)),
            DecodingResult::U64(v) => shares(v, |v| v as f64 / u64::MAX as f64),
            DecodingResult::I8(v) => shares(v, |v| f64::from(v) / f64::from(i8::MAX)),
            DecodingResult::I16(v) => shares(v, |v| f64::from(v) / f64::from(i16::MAX)),
            DecodingResult::I32(v) => shares(v, |v| f64::from(v) / f64::from(i32::MAX)),
            DecodingResult::I64(v) => shares(v, |v| v as f64 / i64::MAX as f64),
            DecodingResult::F16(v) => floats(v, |v| v.to_f32()),
            DecodingResult::F32(v) => Samples::Floats(v, false),
            DecodingResult::F64(v) => floats(v, |v| v as f32),
        })
    }

    /// Spreads packed samples over bytes, or over words if they have more than 8 bits. A row begins
    /// with a byte, and the highest bit of a byte is the first.
    fn spread(&self, bytes: &[u8]) -> Samples {
        let (bits, last) = (self.bits as usize, (1_u64 << self.bits) - 1);
        let row_bytes = (self.width as usize * bits).div_ceil(8);
        let full = if bits > 8 { u64::from(u16::MAX) } else { 255 };
        let codes = bytes.chunks_exact(row_bytes).flat_map(|row| {
            (0..self.width as usize).map(move |x| {
                let (first, end) = (x * bits / 8, ((x + 1) * bits).div_ceil(8));
                let held = row[first..end]
                    .iter()
                    .fold(0_u64, |sum, b| sum << 8 | u64::from(*b));
                let code = held >> (8 * end - (x + 1) * bits) & last;
                (code * full + last / 2) / last
            })
        });
        if bits > 8 {
            Samples::Words(codes.map(|code| code as u16).collect())
        } else {
            Samples::Bytes(codes.map(|code| code as u8).collect())
        }
    }

    /// Returns the entries of a grey picture of these strips or tiles. Places are those in the file.
    fn entries(&self, parts: std::ops::Range<usize>, samples: u64) -> Vec<(u16, Vec<u64>)> {
        // Packed samples are unpacked here: the decoder sees their bytes.
        let is_odd = self.is_odd();
        let across = |pixels: u64| match is_odd {
            true => (pixels * self.bits).div_ceil(8),
            false => pixels,
        };
        let (bits, format) = if is_odd {
            (8, 1)
        } else {
            (self.bits, self.format)
        };
        let mut entries = vec![
            (tag::WIDTH, vec![across(self.width)]),
            (tag::LENGTH, vec![self.height]),
            (tag::BITS, vec![bits]),
            (tag::COMPRESSION, vec![self.compression]),
            (tag::PHOTOMETRIC, vec![colours::BLACK_IS_ZERO]),
            (tag::SAMPLES, vec![samples]),
            (tag::PREDICTOR, vec![self.predictor]),
            (tag::SAMPLE_FORMAT, vec![format]),
        ];
        let places = match self.tile {
            Some([wide, long]) => {
                entries.push((tag::TILE_WIDTH, vec![across(wide)]));
                entries.push((tag::TILE_LENGTH, vec![long]));
                [tag::TILE_OFFSETS, tag::TILE_LENGTHS]
            }
            None => {
                entries.push((tag::ROWS_PER_STRIP, vec![self.rows_per_strip]));
                [tag::STRIP_OFFSETS, tag::STRIP_LENGTHS]
            }
        };
        let lists = [&self.offsets, &self.lengths];
        entries.extend((places.into_iter()).zip(lists.map(|list| list[parts.clone()].to_vec())));
        if self.compression == JPEG && !self.tables.is_empty() {
            let tables = self.tables.iter().map(|&byte| byte.into());
            entries.push((tag::JPEG_TABLES, tables.collect()));
        }
        entries
    }
}

/// Writes a directory as a BigTIFF behind whose bytes the file stands that `entries` belong to.
fn head(entries: Vec<(u16, Vec<u64>)>, is_little: bool) -> Vec<u8> {
    /// Types of values: bytes and numbers of 8 bytes.
    const BYTES: u64 = 7;
    const NUMBERS: u64 = 16;
    let kind = |tag| {
        if tag == tag::JPEG_TABLES {
            BYTES
        } else {
            NUMBERS
        }
    };
    let bytes = |value: u64, size: usize| {
        let mut bytes = value.to_le_bytes()[..size].to_vec();
        if !is_little {
            bytes.reverse();
        }
        bytes
    };
    // Behind the signature and the directory stand the lists of more than 8 bytes.
    let start = 16 + 8 + 20 * entries.len() + 8;
    let sizes = entries
        .iter()
        .map(|(tag, list)| width(kind(*tag)) * list.len());
    let length = start + sizes.filter(|&size| size > 8).sum::<usize>();
    let mut head = if is_little {
        b"II".to_vec()
    } else {
        b"MM".to_vec()
    };
    for (value, size) in [(43, 2), (8, 2), (0, 2), (16, 8), (entries.len() as u64, 8)] {
        head.extend(bytes(value, size));
    }
    let mut behind = Vec::new();
    for (tag, values) in entries {
        let is_place = matches!(tag, tag::STRIP_OFFSETS | tag::TILE_OFFSETS);
        let add = if is_place { length as u64 } else { 0 };
        let size = width(kind(tag));
        head.extend([bytes(tag.into(), 2), bytes(kind(tag), 2)].concat());
        head.extend(bytes(values.len() as u64, 8));
        let values = values.into_iter().map(|value| value.saturating_add(add));
        let mut list: Vec<u8> = values.flat_map(|value| bytes(value, size)).collect();
        if list.len() > 8 {
            head.extend(bytes((start + behind.len()) as u64, 8));
            behind.append(&mut list);
        } else {
            list.resize(8, 0);
            head.append(&mut list);
        }
    }
    head.extend(bytes(0, 8));
    head.append(&mut behind);
    head
}

/// Replaces luma and colour differences by red, green and blue (JFIF 1.02).
fn rgb_of_ycbcr(pixel: &mut [u8]) {
    let [y, blue, red] = [0, 1, 2].map(|k| f32::from(pixel[k]));
    let (blue, red) = (blue - 128.0, red - 128.0);
    let light = [
        y + 1.402 * red,
        y - 0.344_136 * blue - 0.714_136 * red,
        y + 1.772 * blue,
    ];
    for (sample, light) in pixel.iter_mut().zip(light) {
        *sample = light.round().clamp(0.0, 255.0) as u8;
    }
}

/// A file behind some bytes of its own.
struct Behind<'a, R> {
    head: Vec<u8>,
    file: &'a mut R,
    at: u64,
}

impl<R: Read + Seek> Read for Behind<'_, R> {
    fn read(&mut self, into: &mut [u8]) -> IoResult<usize> {
        let count = match self.head.get(self.at as usize..) {
            Some(mut rest) if !rest.is_empty() => rest.read(into)?,
            _ => self.file.read(into)?,
        };
        self.at += count as u64;
        // The file goes on where the head ends.
        if self.at == self.head.len() as u64 && count > 0 {
            self.file.rewind()?;
        }
        Ok(count)
    }
}

impl<R: Read + Seek> Seek for Behind<'_, R> {
    fn seek(&mut self, to: SeekFrom) -> IoResult<u64> {
        let head = self.head.len() as u64;
        self.at = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::Current(by) => self.at.saturating_add_signed(by),
            SeekFrom::End(by) => {
                (self.file.seek(SeekFrom::End(0))? + head).saturating_add_signed(by)
            }
        };
        self.file
            .seek(SeekFrom::Start(self.at.saturating_sub(head)))?;
        Ok(self.at)
    }
}
