//! TIFF: what the samples of the page that is the picture mean (TIFF 6.0).

use std::fs::File;
use std::io::{BufReader, Read, Seek};

use crate::photographs::photo::formats::pages::{Directory, Tiff, tag};
use crate::photographs::photo::formats::parts::{JPEG, UNPACKED};
use crate::photographs::photo::{
    Alpha, Decoded, Fault, Format, Samples, Stored, check_packed, check_size, curve,
};

/// Values of `PhotometricInterpretation`.
mod colours {
    pub(super) const WHITE_IS_ZERO: u64 = 0;
    pub(super) const BLACK_IS_ZERO: u64 = 1;
    pub(super) const RGB: u64 = 2;
    pub(super) const PALETTE: u64 = 3;
    pub(super) const CMYK: u64 = 5;
    pub(super) const YCBCR: u64 = 6;
}

pub(crate) fn damaged<T>(reason: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Damaged(Format::Tiff, reason.into()))
}

fn unread<T>(what: impl Into<String>) -> Result<T, Fault> {
    Err(Fault::Unread(Format::Tiff, what.into()))
}

/// Reads the picture of a TIFF: its first page that is neither a smaller copy nor a mask.
pub(in crate::photographs::photo) fn read(file: BufReader<File>) -> Result<Decoded, Fault> {
    let (mut tiff, first) = Tiff::open(file).or_else(|error| damaged(error.to_string()))?;
    let (directory, mut warnings) = tiff.picture(first)?;
    let page = Page::new(&mut tiff, &directory)?;
    check_size(page.width, page.height)?;
    if page.photometric == colours::CMYK {
        return Err(Fault::Cmyk);
    }
    page.check()?;
    page.check_parts(tiff.length)?;
    warnings.extend(page.doubts());
    let stored = page.stored(&mut tiff)?;
    let stated = match tiff.bytes(&directory, tag::ICC_PROFILE) {
        Ok(profile) if profile.is_empty() => Ok(None),
        Ok(profile) => curve::curves(&profile, curve::PROFILE, stored.has_colour).map(Some),
        Err(_) => Err(curve::DAMAGED.to_owned()),
    };
    Ok(Decoded {
        stored,
        orientation: tiff.value(&directory, tag::ORIENTATION)?,
        stated: stated.map_err(|reason| Fault::Tone(curve::PROFILE, reason)),
        warnings,
    })
}

/// The description of one page.
pub(super) struct Page {
    pub(crate) width: u64,
    pub(crate) height: u64,
    /// Bits of a sample.
    pub(crate) bits: u64,
    /// Kind of the samples: 1 whole numbers, 2 signed ones, 3 floats.
    pub(crate) format: u64,
    photometric: u64,
    pub(crate) compression: u64,
    pub(crate) predictor: u64,
    /// Number of samples of a pixel, and what those beyond the colours are.
    pub(crate) samples: u64,
    extra: Vec<u64>,
    pub(crate) is_planar: bool,
    fill_order: u64,
    subsampling: Vec<u64>,
    /// Width and length of a tile or strip.
    pub(crate) part: [u64; 2],
    pub(crate) offsets: Vec<u64>,
    pub(crate) lengths: Vec<u64>,
    pub(crate) tables: Vec<u8>,
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
        let rows = tiff.value(page, tag::ROWS_PER_STRIP)?.unwrap_or(height);
        let (part, offsets, lengths) = match wide?.zip(long?) {
            Some((wide, long)) => ([wide, long], tag::TILE_OFFSETS, tag::TILE_LENGTHS),
            None => {
                let rows = rows.clamp(1, height.max(1));
                ([width, rows], tag::STRIP_OFFSETS, tag::STRIP_LENGTHS)
            }
        };
        let or_one = |value: Option<u64>| value.unwrap_or(1);
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
            part,
            offsets: tiff.values(page, offsets)?,
            lengths: tiff.values(page, lengths)?,
            tables: tiff.bytes(page, tag::JPEG_TABLES)?,
            palette: tiff.values(page, tag::COLOUR_MAP)?,
        })
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
        let bits = self.bits;
        let (kind, fits) = match self.format {
            1 => ("", matches!(bits, 1 | 2 | 4 | 8..=16 | 32 | 64)),
            2 => ("signed ", matches!(bits, 8 | 16 | 32 | 64)),
            3 => ("floats of ", matches!(bits, 16 | 32 | 64)),
            other => return unread(format!("samples of the kind {other}")),
        };
        let coloured = match self.photometric {
            colours::PALETTE => self.format == 1 && bits <= 8,
            colours::YCBCR => self.format == 1 && bits == 8,
            // White has a code only where there is a largest one.
            colours::WHITE_IS_ZERO => self.format != 2,
            _ => true,
        };
        let packed = self.compression == JPEG && (self.format, bits) != (1, 8);
        if !fits || !coloured || packed {
            return unread(format!("{colours} in samples of {kind}{bits} bits"));
        }
        let is_ycbcr = self.photometric == colours::YCBCR && self.compression != JPEG;
        if is_ycbcr && self.subsampling != [1, 1] {
            return unread("YCbCr with fewer colours than pixels");
        }
        match (self.predictor, self.format) {
            (1 | 2, _) | (3, 3) => {}
            (other, _) => return unread(format!("{kind}samples with predictor {other}")),
        }
        match self.fill_order {
            1 => Ok(()),
            _ => unread("bytes whose bits are reversed (FillOrder 2)"),
        }
    }

    /// Refuses a directory that contradicts itself, or a file of `length` bytes.
    fn check_parts(&self, length: u64) -> Result<(), Fault> {
        let colours = self.colours();
        if self.samples < colours || self.samples > u16::MAX.into() {
            let samples = self.samples;
            return damaged(format!("it states {samples} samples for {colours} colours"));
        }
        let [wide, long] = self.part;
        if wide == 0 || long == 0 {
            return damaged("its tiles have no size");
        }
        // Tiles may be larger than the picture, and take memory.
        let size = [self.width.max(wide), self.height.max(long)];
        check_packed(size, self.memory(), length)?;
        let planes = if self.is_planar { self.samples } else { 1 };
        let each = self.width.div_ceil(wide) * self.height.div_ceil(long);
        let parts = each.saturating_mul(planes);
        if self.offsets.len() as u64 != parts || self.lengths.len() as u64 != parts {
            return damaged(format!(
                "it states {} places and {} lengths for {parts} parts",
                self.offsets.len(),
                self.lengths.len()
            ));
        }
        // More would take memory and time that the file does not account for.
        let claimed = self
            .lengths
            .iter()
            .fold(0, |sum: u64, &l| sum.saturating_add(l));
        if self.compression == JPEG && claimed > length {
            return Err(Fault::CutShort(
                "its strips claim more bytes than it has".into(),
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
        let is_palette = self.photometric == colours::PALETTE;
        self.samples * unpacked + if is_palette { 3 } else { 0 }
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
            _ if self.photometric == colours::PALETTE => Alpha::None,
            Some(1) => Alpha::Premultiplied,
            Some(2) => Alpha::Straight,
            // A fourth sample of RGB that the file does not explain is transparency by custom.
            None if colours == 3 && self.samples == 4 => Alpha::Straight,
            _ => Alpha::None,
        }
    }

    /// Returns the number of samples of a pixel that are used: the colours, then alpha.
    pub(crate) fn used(&self) -> u64 {
        self.colours() + u64::from(self.alpha() != Alpha::None)
    }

    /// Unpacks the samples, and turns those of palettes and YCbCr into grey or RGB.
    fn stored<R: Read + Seek>(&self, tiff: &mut Tiff<R>) -> Result<Stored, Fault> {
        let mut stored = Stored {
            size: [self.width as usize, self.height as usize],
            samples: self.unpacked(tiff, self.photometric != colours::PALETTE)?,
            channels: self.used() as usize,
            has_colour: self.colours() == 3,
            alpha: self.alpha(),
        };
        match (self.photometric, &mut stored.samples) {
            (colours::WHITE_IS_ZERO, samples) => samples.invert(stored.channels),
            (colours::YCBCR, Samples::Bytes(bytes)) => {
                bytes
                    .chunks_exact_mut(stored.channels)
                    .for_each(rgb_of_ycbcr);
            }
            (colours::PALETTE, Samples::Bytes(codes)) => {
                let each = self.palette.len() / 3;
                stored.channels = if self.is_grey() { 1 } else { 3 };
                stored.has_colour = stored.channels == 3;
                let coloured = codes.iter().flat_map(|&code| {
                    let places = (0..stored.channels).map(move |k| k * each + usize::from(code));
                    places.map(|place| (self.palette[place] >> 8) as u8)
                });
                stored.samples = Samples::Bytes(coloured.collect());
            }
            _ => {}
        }
        Ok(stored)
    }
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
