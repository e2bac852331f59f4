//! Reading of PNG, TIFF and JPEG photographs.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use image::metadata::Orientation;
use image::{
    ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageFormat, ImageReader, Limits,
};

use rayon::prelude::*;

use crate::document::open;
use crate::photographs::photo::channel::{Channel, Decode, REC709};
use crate::photographs::photo::curve::Curve;
use crate::photographs::photo::error::Error;
use crate::photographs::photo::format::Format;
use crate::photographs::photo::icc;
use crate::photographs::photo::jpeg;
use crate::photographs::photo::jpeg::Whole;
use crate::photographs::photo::limits::{HEADER_BYTES, MAX_PIXELS, check_packed, check_size};
use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::plane::{Photo, TURNED};
use crate::photographs::photo::statement;
use crate::photographs::photo::strips;
use crate::photographs::photo::taken::{Curves, GIVEN};
use crate::photographs::photo::transfer::Transfer;

/// Memory that a decoder may allocate, bytes: that of the largest picture as four 16-bit channels.
const MAX_BYTES: u64 = MAX_PIXELS * 8;

/// A decoded picture, upright, and all that its file says of it.
struct Decoded {
    picture: DynamicImage,
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
        picture,
        curves,
        mut warnings,
    } = decode(path, reader, format, transfer)?;
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let colour = picture.color();
    // The number of stored channels includes alpha; the number of used ones does not.
    let stored = usize::from(colour.channel_count());
    let used = if colour.has_color() { 3 } else { 1 };
    let mut planes = match &picture {
        DynamicImage::ImageLuma8(p) => split8(p, stored, used, &curves),
        DynamicImage::ImageLumaA8(p) => split8(p, stored, used, &curves),
        DynamicImage::ImageRgb8(p) => split8(p, stored, used, &curves),
        DynamicImage::ImageRgba8(p) => split8(p, stored, used, &curves),
        DynamicImage::ImageLuma16(p) => split16(p, stored, used, &curves),
        DynamicImage::ImageLumaA16(p) => split16(p, stored, used, &curves),
        DynamicImage::ImageRgb16(p) => split16(p, stored, used, &curves),
        DynamicImage::ImageRgba16(p) => split16(p, stored, used, &curves),
        other => split(&other.to_rgb32f(), 3, 3, |channel, value: f32| {
            curves.of(channel).light(value)
        }),
    };
    if colour.has_alpha() && darkened(&mut planes, &picture) {
        warnings.push("transparent parts give no light: they count as black".into());
    }
    if colour.has_color() && curves.from == DEFAULT_OF_16_BITS {
        warnings.push(
            "the file does not say what its 16 bits mean: they were taken as linear light; if the \
            colours are pale, give --transfer srgb"
                .into(),
        );
    }
    Ok(Picture {
        width,
        height,
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
fn darkened(planes: &mut [Vec<f32>], picture: &DynamicImage) -> bool {
    let alpha: Vec<f32> = picture
        .to_rgba32f()
        .pixels()
        .map(|pixel| pixel.0[3])
        .collect();
    for (light, alpha) in planes
        .iter_mut()
        .flat_map(|plane| plane.iter_mut().zip(&alpha))
    {
        *light *= alpha;
    }
    alpha.iter().any(|&alpha| alpha < 1.0)
}

/// Returns the number of bits of a channel.
fn bits(colour: ColorType) -> u16 {
    colour.bits_per_pixel() / u16::from(colour.channel_count())
}

fn split8(samples: &[u8], stored: usize, used: usize, curves: &Curves) -> Vec<Vec<f32>> {
    let light = light8(curves);
    split(samples, stored, used, |channel, code| {
        light.of(channel)[usize::from(code)]
    })
}

fn split16(samples: &[u16], stored: usize, used: usize, curves: &Curves) -> Vec<Vec<f32>> {
    let light = light16(curves);
    split(samples, stored, used, |channel, code| {
        light.of(channel)[usize::from(code)]
    })
}

/// Returns one plane for each of the first `used` of `stored` channels.
fn split<S: Copy + Sync>(
    samples: &[S],
    stored: usize,
    used: usize,
    light: impl Fn(usize, S) -> f32 + Sync,
) -> Vec<Vec<f32>> {
    let plane = |channel| {
        let pixels = samples.chunks_exact(stored);
        pixels.map(|pixel| light(channel, pixel[channel])).collect()
    };
    (0..used).into_par_iter().map(plane).collect()
}

/// Decodes the whole picture and turns it upright. `transfer` has the meaning of
/// [`Decode::transfer`].
fn decode(
    path: &Path,
    reader: BufReader<File>,
    format: Format,
    transfer: Option<Transfer>,
) -> Result<Decoded, Error> {
    let broken = |source| Error::Raster {
        file: path.to_owned(),
        format,
        source,
    };
    let reader = sized(path, reader, format)?;
    let mut reader = ImageReader::with_format(
        reader,
        match format {
            Format::Tiff => ImageFormat::Tiff,
            Format::Jpeg => ImageFormat::Jpeg,
            Format::Png | Format::Exr | Format::Raw => ImageFormat::Png,
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
    if matches!(
        decoder.original_color_type(),
        ExtendedColorType::Cmyk8 | ExtendedColorType::Cmyk16
    ) {
        return Err(Error::Cmyk {
            file: path.to_owned(),
        });
    }
    let orientation = decoder.orientation().map_err(broken)?;
    let whole = whole(path, format)?;
    let mut warnings: Vec<String> = whole.warning.into_iter().collect();
    let curves = match transfer {
        Some(given) => Curves::one(Curve::Named(given), GIVEN),
        None => {
            let colour = decoder.color_type();
            let profile = || match decoder.icc_profile() {
                Ok(None) if !whole.has_profile => Ok(None),
                Ok(Some(bytes)) => Ok(Some(bytes)),
                _ => Err(icc::DAMAGED.to_owned()),
            };
            let named = statement::curves(path, format, colour.has_color(), profile)?;
            named.unwrap_or_else(|| of_format(bits(colour)))
        }
    };
    warnings.extend(curves.doubt.clone());
    let mut picture = DynamicImage::from_decoder(decoder).map_err(broken)?;
    if orientation != Orientation::NoTransforms {
        picture.apply_orientation(orientation);
        warnings.push(TURNED.into());
    }
    Ok(Decoded {
        picture,
        curves,
        warnings,
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
fn of_format(bits: u16) -> Curves {
    match bits {
        8 => Curves::one(Curve::Named(Transfer::Srgb), "default of 8 bits"),
        16 => Curves::one(Curve::Named(Transfer::Linear), DEFAULT_OF_16_BITS),
        _ => Curves::one(Curve::Named(Transfer::Linear), "default of floats"),
    }
}

/// Reads a file into memory. A JPEG of the largest photograph is shorter than its pixels.
fn bytes_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.take(MAX_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Refuses a JPEG, or a TIFF of JPEGs, that is not whole.
fn whole(path: &Path, format: Format) -> Result<Whole, Error> {
    let io = |source| Error::Io {
        file: path.to_owned(),
        source,
    };
    let checked = match format {
        Format::Jpeg => jpeg::check(&bytes_of(path).map_err(io)?),
        Format::Tiff => strips::check(BufReader::new(open(path).map_err(io)?)),
        Format::Png | Format::Exr | Format::Raw => return Ok(Whole::default()),
    };
    checked.map_err(|reason| Error::CutShort {
        file: path.to_owned(),
        reason,
    })
}

/// Computes the plane from the picture, and adds warnings about what was assumed.
fn plane(path: &Path, decoded: Decoded, channel: &Channel) -> Result<Photo, Error> {
    let Decoded {
        picture,
        curves,
        mut warnings,
    } = decoded;
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let colour = picture.color();
    let transfer = curves.taken();
    if bits(colour) == 8 {
        let from = if curves.are_linear() {
            String::new()
        } else {
            format!(", linearised from {},", transfer.name)
        };
        warnings.push(format!(
            "8-bit values{from} limit the accuracy; prefer linear 16-bit or EXR"
        ));
    }
    if colour.has_alpha() {
        warnings.push("the alpha channel was ignored".into());
    }
    let (weights, found): (&[f32], &[&str]) = match (colour.has_color(), channel) {
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
    let channels = usize::from(colour.channel_count());
    let mut clip_level = Some(1.0);
    let luminance = match picture {
        DynamicImage::ImageLuma8(pixels) => bytes(&pixels, channels, weights, &curves),
        DynamicImage::ImageLumaA8(pixels) => bytes(&pixels, channels, weights, &curves),
        DynamicImage::ImageRgb8(pixels) => bytes(&pixels, channels, weights, &curves),
        DynamicImage::ImageRgba8(pixels) => bytes(&pixels, channels, weights, &curves),
        DynamicImage::ImageLuma16(pixels) => words(&pixels, channels, weights, &curves),
        DynamicImage::ImageLumaA16(pixels) => words(&pixels, channels, weights, &curves),
        DynamicImage::ImageRgb16(pixels) => words(&pixels, channels, weights, &curves),
        DynamicImage::ImageRgba16(pixels) => words(&pixels, channels, weights, &curves),
        // All other pictures hold floats, which have no full scale.
        other => {
            clip_level = None;
            let pixels = other.into_rgb32f();
            let light = |channel, value: f32| curves.of(channel).light(value);
            weigh(&pixels, 3, weights, None, light)
        }
    };
    Ok(Photo {
        width,
        height,
        luminance,
        clip_level,
        clips_alone: weights.iter().filter(|&&weight| weight != 0.0).count() == 1,
        transfer,
        warnings,
    })
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

/// Returns the light of every 8-bit code.
fn light8(curves: &Curves) -> Tables {
    Tables::new(curves, u8::MAX.into())
}

/// Returns the light of every 16-bit code.
fn light16(curves: &Curves) -> Tables {
    Tables::new(curves, u16::MAX)
}

fn bytes(samples: &[u8], channels: usize, weights: &[f32], curves: &Curves) -> Vec<f32> {
    let light = light8(curves);
    weigh(
        samples,
        channels,
        weights,
        Some(u8::MAX),
        |channel, code| light.of(channel)[usize::from(code)],
    )
}

fn words(samples: &[u16], channels: usize, weights: &[f32], curves: &Curves) -> Vec<f32> {
    let light = light16(curves);
    weigh(
        samples,
        channels,
        weights,
        Some(u16::MAX),
        |channel, code| light.of(channel)[usize::from(code)],
    )
}

/// Returns the weighted sum of the channels of each pixel. If one of the channels used is
/// saturated, the sum is unknown: the pixel is set to full scale, so that [`Photo::clipped`] counts
/// it.
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
