//! Reading of PNG, TIFF and JPEG photographs.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use flate2::read::ZlibDecoder;
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use rayon::prelude::*;

use crate::document::open;
use crate::photographs::photo::channel::{Channel, Decode, REC709};
use crate::photographs::photo::curve::Curve;
use crate::photographs::photo::error::Error;
use crate::photographs::photo::format::Format;
use crate::photographs::photo::icc;
use crate::photographs::photo::jpeg;
use crate::photographs::photo::jpeg::Whole;
use crate::photographs::photo::limits::{HEADER_BYTES, MAX_BYTES, check_packed, check_size};
use crate::photographs::photo::page;
use crate::photographs::photo::page::Opened;
use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::plane::{Photo, TURNED};
use crate::photographs::photo::samples::{Alpha, Samples, Stored, upright};
use crate::photographs::photo::statement;
use crate::photographs::photo::taken::{Curves, GIVEN};
use crate::photographs::photo::transfer::Transfer;

/// A decoded picture, and all that its file says of it.
struct Decoded {
    stored: Stored,
    orientation: Orientation,
    curves: Curves,
    warnings: Vec<String>,
}

/// Reads the plane that `options` ask for.
pub(crate) fn read(
    path: &Path,
    reader: BufReader<File>,
    format: Format,
    options: &Decode,
) -> Result<Photo, Error> {
    let decoded = decode(path, reader, format, options.transfer)?;
    plane(path, decoded, &options.channel)
}

/// Reads red, green and blue, or grey if there is no colour. `transfer` has the meaning of
/// [`Decode::transfer`].
pub(crate) fn read_colour(
    path: &Path,
    reader: BufReader<File>,
    format: Format,
    transfer: Option<Transfer>,
) -> Result<Picture, Error> {
    let Decoded {
        stored,
        orientation,
        curves,
        mut warnings,
    } = decode(path, reader, format, transfer)?;
    let mut planes: Vec<Vec<f32>> = (0..stored.colours())
        .into_par_iter()
        .map(|channel| {
            let mut weights = [0.0; 3];
            weights[channel] = 1.0;
            light(&stored, &weights[..=channel], &curves, false)
        })
        .collect();
    match stored.alpha {
        Alpha::Straight if darkened(&mut planes, &stored.alphas()) => {
            warnings.push("transparent parts give no light: they count as black".into());
        }
        Alpha::Premultiplied if stored.alphas().iter().any(|&alpha| alpha < 1.0) => {
            warnings.push(
                "transparent parts give the light that is stored: the file says that it was \
                multiplied by its alpha"
                    .into(),
            );
        }
        _ => {}
    }
    if stored.has_colour && curves.from == DEFAULT_OF_16_BITS {
        warnings.push(
            "the file does not say what its 16 bits mean: they were taken as linear light; if the \
            colours are pale, give --transfer srgb"
                .into(),
        );
    }
    let mut size = stored.size;
    for plane in &mut planes {
        (*plane, size) = upright(std::mem::take(plane), stored.size, orientation);
    }
    Ok(Picture {
        width: size[0],
        height: size[1],
        planes,
        transfer: if curves.are_linear() {
            Transfer::Linear
        } else {
            Transfer::Srgb
        },
        warnings,
    })
}

/// Multiplies light by the alpha of its pixel, and returns whether any pixel is transparent.
fn darkened(planes: &mut [Vec<f32>], alphas: &[f32]) -> bool {
    for (light, alpha) in planes
        .iter_mut()
        .flat_map(|plane| plane.iter_mut().zip(alphas))
    {
        *light *= alpha;
    }
    alphas.iter().any(|&alpha| alpha < 1.0)
}

/// Decodes the whole picture. `transfer` has the meaning of [`Decode::transfer`].
fn decode(
    path: &Path,
    reader: BufReader<File>,
    format: Format,
    transfer: Option<Transfer>,
) -> Result<Decoded, Error> {
    let Opened {
        stored,
        orientation,
        profile,
        mut warnings,
    } = match format {
        Format::Tiff => page::read(path, reader)?,
        _ => unpacked(path, reader, format)?,
    };
    let curves = match transfer {
        Some(given) => Curves::one(Curve::Named(given), GIVEN),
        None => statement::curves(path, format, stored.has_colour, || profile)?
            .unwrap_or_else(|| of_format(&stored.samples)),
    };
    warnings.extend(curves.doubt.clone());
    if orientation != Orientation::NoTransforms {
        warnings.push(TURNED.into());
    }
    Ok(Decoded {
        stored,
        orientation,
        curves,
        warnings,
    })
}

/// Decodes a PNG or JPEG.
fn unpacked(path: &Path, reader: BufReader<File>, format: Format) -> Result<Opened, Error> {
    let broken = |error: ImageError| Error::Damaged {
        file: path.to_owned(),
        format,
        reason: error.to_string(),
    };
    let reader = sized(path, reader, format)?;
    let mut reader = ImageReader::with_format(
        reader,
        match format {
            Format::Jpeg => ImageFormat::Jpeg,
            _ => ImageFormat::Png,
        },
    );
    // These limits bound what stands before the pixels: a profile may inflate a thousandfold. The
    // pixels have a limit of their own.
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(HEADER_BYTES);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    check_size(path, width.into(), height.into())?;
    let bytes = decoder.color_type().bytes_per_pixel();
    check_packed(path, [width.into(), height.into()], bytes.into())?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_BYTES);
    decoder.set_limits(limits).map_err(broken)?;
    let orientation = decoder.orientation().map_err(broken)?;
    let whole = whole(path, format, decoder.total_bytes())?;
    if whole.is_cmyk {
        return Err(Error::Cmyk {
            file: path.to_owned(),
        });
    }
    let profile = match decoder.icc_profile() {
        Ok(None) if !whole.has_profile => Ok(None),
        Ok(Some(bytes)) => Ok(Some(bytes)),
        _ => Err(icc::DAMAGED.to_owned()),
    };
    let picture = DynamicImage::from_decoder(decoder).map_err(broken)?;
    Ok(Opened {
        stored: picture.into(),
        orientation,
        profile,
        warnings: whole.warning.into_iter().collect(),
    })
}

/// Checks the size that the header of a PNG claims, before a decoder makes room for its rows.
fn sized(
    path: &Path,
    mut reader: BufReader<File>,
    format: Format,
) -> Result<BufReader<File>, Error> {
    // A signature of 8 bytes, length and name of the first chunk, then width and height.
    let mut head = [0; 24];
    if format == Format::Png && reader.read_exact(&mut head).is_ok() {
        let word =
            |at: usize| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        check_size(path, word(16).into(), word(20).into())?;
    }
    reader.rewind().map_err(|source| Error::Io {
        file: path.to_owned(),
        source,
    })?;
    Ok(reader)
}

/// Origin of the curve of 16 bits that the file says nothing of.
const DEFAULT_OF_16_BITS: &str = "default of 16 bits";

/// Returns the curve of a format whose file says nothing of it.
fn of_format(samples: &Samples) -> Curves {
    let linear = |from: &str| Curves::one(Curve::Named(Transfer::Linear), from);
    match samples {
        Samples::Bytes(_) => Curves::one(Curve::Named(Transfer::Srgb), "default of 8 bits"),
        Samples::Words(_) => linear(DEFAULT_OF_16_BITS),
        Samples::Floats(_, false) => linear("default of floats"),
        Samples::Floats(_, true) => linear("default of 32-bit and signed numbers"),
    }
}

/// Reads a file into memory. A JPEG of the largest photograph is shorter than its pixels.
fn bytes_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.take(MAX_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Refuses a JPEG that is not whole, and a PNG whose pixels do not agree with their Adler-32, which
/// the decoder of the crate image passes over. `pixels` is the length of the picture, bytes.
fn whole(path: &Path, format: Format, pixels: u64) -> Result<Whole, Error> {
    let io = |source| Error::Io {
        file: path.to_owned(),
        source,
    };
    let checked = match format {
        Format::Jpeg => jpeg::check(&bytes_of(path).map_err(io)?),
        Format::Png if agrees(&bytes_of(path).map_err(io)?, pixels) => Ok(Whole::default()),
        Format::Png => Err("its packed pixels do not agree with their checksum".into()),
        _ => return Ok(Whole::default()),
    };
    checked.map_err(|reason| Error::CutShort {
        file: path.to_owned(),
        reason,
    })
}

/// Returns whether the packed pixels of a PNG, `pixels` bytes as they are shown, unpack to their
/// checksum.
fn agrees(png: &[u8], pixels: u64) -> bool {
    let (mut packed, mut rest) = (Vec::new(), png.get(8..).unwrap_or_default());
    while let Some((&[a, b, c, d, ref kind @ ..], behind)) = rest.split_first_chunk::<8>() {
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        let data = behind.get(..length).unwrap_or(behind);
        if kind == b"IDAT" {
            packed.extend_from_slice(data);
        }
        rest = behind.get(length + 4..).unwrap_or_default();
    }
    // A row begins with its filter, and interlaced pictures have more rows.
    let most = 2 * pixels + (1 << 20);
    let mut unpacked = ZlibDecoder::new(&packed[..]).take(most);
    std::io::copy(&mut unpacked, &mut std::io::sink()).is_ok()
}

/// Computes the plane from the picture, and adds warnings about what was assumed.
fn plane(path: &Path, decoded: Decoded, channel: &Channel) -> Result<Photo, Error> {
    let Decoded {
        stored,
        orientation,
        curves,
        mut warnings,
    } = decoded;
    let transfer = curves.taken();
    if matches!(stored.samples, Samples::Bytes(_)) {
        let from = if curves.are_linear() {
            String::new()
        } else {
            format!(", linearised from {},", transfer.name)
        };
        warnings.push(format!(
            "8-bit values{from} limit the accuracy; prefer linear 16-bit or EXR"
        ));
    }
    if stored.alpha != Alpha::None {
        warnings.push("the alpha channel was ignored".into());
    }
    let (weights, found): (&[f32], &[&str]) = match (stored.has_colour, channel) {
        (false, Channel::Luminance) => (&[1.0], &[]),
        (true, Channel::Luminance) => (&REC709, &[]),
        (true, Channel::Red) => (&[1.0, 0.0, 0.0], &[]),
        (true, Channel::Green) => (&[0.0, 1.0, 0.0], &[]),
        (true, Channel::Blue) => (&[0.0, 0.0, 1.0], &[]),
        (true, Channel::Named(_)) => (&[], &["luminance", "red", "green", "blue"]),
        (false, _) => (&[], &["luminance"]),
    };
    if weights.is_empty() {
        return Err(Error::NoChannel {
            file: path.to_owned(),
            wanted: channel.clone(),
            found: found.iter().map(ToString::to_string).collect(),
        });
    }
    let luminance = light(&stored, weights, &curves, true);
    let (luminance, [width, height]) = upright(luminance, stored.size, orientation);
    Ok(Photo {
        width,
        height,
        luminance,
        // Floats have no full scale.
        clip_level: (!matches!(stored.samples, Samples::Floats(_, false))).then_some(1.0),
        clips_alone: weights.iter().filter(|&&weight| weight != 0.0).count() == 1,
        transfer,
        warnings,
    })
}

/// Returns the weighted sum of the light of the channels of each pixel. If `marks_full`, the sum is
/// unknown if one of the channels used is saturated: the pixel is set to full scale, so that
/// [`Photo::clipped`] counts it.
fn light(stored: &Stored, weights: &[f32], curves: &Curves, marks_full: bool) -> Vec<f32> {
    let channels = stored.channels;
    match &stored.samples {
        Samples::Bytes(samples) => {
            let light = Tables::new(curves, u8::MAX.into());
            let light = |channel, code| light.of(channel)[usize::from(code)];
            weigh(
                samples,
                channels,
                weights,
                marks_full.then_some(u8::MAX),
                light,
            )
        }
        Samples::Words(samples) => {
            let light = Tables::new(curves, u16::MAX);
            let light = |channel, code| light.of(channel)[usize::from(code)];
            weigh(
                samples,
                channels,
                weights,
                marks_full.then_some(u16::MAX),
                light,
            )
        }
        Samples::Floats(samples, is_whole) => {
            let light = |channel, value: f32| curves.of(channel).light(value);
            let full = (marks_full && *is_whole).then_some(1.0);
            weigh(samples, channels, weights, full, light)
        }
    }
}

/// Light of every code: one table for all channels, or one for each of red, green and blue.
struct Tables(Vec<Vec<f32>>);

impl Tables {
    /// Makes the tables for codes from 0 to `last`.
    fn new(curves: &Curves, last: u16) -> Tables {
        let light = |curve: &Curve| {
            let stored = (0..=last).map(|code| f32::from(code) / f32::from(last));
            stored.map(|stored| curve.light(stored)).collect()
        };
        Tables(curves.each.iter().map(light).collect())
    }

    fn of(&self, channel: usize) -> &[f32] {
        &self.0[channel.min(self.0.len() - 1)]
    }
}

/// Returns the weighted sum of the channels of each pixel, or 1 if one of those used is `full`.
fn weigh<S: Copy + PartialEq>(
    samples: &[S],
    channels: usize,
    weights: &[f32],
    full: Option<S>,
    light: impl Fn(usize, S) -> f32,
) -> Vec<f32> {
    let pixel = |pixel: &[S]| {
        let samples = pixel.iter().zip(weights).enumerate();
        let used = samples.filter(|&(_, (_, &weight))| weight != 0.0);
        if used.clone().any(|(_, (&sample, _))| full == Some(sample)) {
            1.0
        } else {
            used.map(|(channel, (&sample, &weight))| weight * light(channel, sample))
                .sum()
        }
    };
    samples.chunks_exact(channels).map(pixel).collect()
}
