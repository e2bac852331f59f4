//! Reading of PNG, TIFF and JPEG photographs.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::metadata::Orientation;
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageFormat, ImageReader, Limits};

use rayon::prelude::*;

use crate::photographs::photo::channel::{Channel, Decode, REC709};
use crate::photographs::photo::error::Error;
use crate::photographs::photo::format::Format;
use crate::photographs::photo::limits::{MAX_PIXELS, check_packed, check_size};
use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::plane::{Photo, TURNED};
use crate::photographs::photo::transfer::Transfer;

/// Memory that a decoder may allocate, bytes: that of the largest picture as four 16-bit channels.
const MAX_BYTES: u64 = MAX_PIXELS * 8;

/// Reads the plane that `options` ask for.
pub(crate) fn read(
    path: &Path,
    reader: BufReader<File>,
    format: Format,
    options: &Decode,
) -> Result<Photo, Error> {
    let (picture, warnings) = decode(path, reader, format)?;
    plane(path, picture, options, warnings)
}

/// Reads red, green and blue, or grey if there is no colour. `transfer` has the meaning of
/// [`Decode::transfer`].
pub(crate) fn read_colour(
    path: &Path,
    reader: BufReader<File>,
    format: Format,
    transfer: Option<Transfer>,
) -> Result<Picture, Error> {
    let (picture, warnings) = decode(path, reader, format)?;
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let colour = picture.color();
    let transfer = transfer.unwrap_or_else(|| default_transfer(&picture));
    // The number of stored channels includes alpha; the number of used ones does not.
    let stored = usize::from(colour.channel_count());
    let used = if colour.has_color() { 3 } else { 1 };
    let planes = match &picture {
        DynamicImage::ImageLuma8(p) => split8(p, stored, used, transfer),
        DynamicImage::ImageLumaA8(p) => split8(p, stored, used, transfer),
        DynamicImage::ImageRgb8(p) => split8(p, stored, used, transfer),
        DynamicImage::ImageRgba8(p) => split8(p, stored, used, transfer),
        DynamicImage::ImageLuma16(p) => split16(p, stored, used, transfer),
        DynamicImage::ImageLumaA16(p) => split16(p, stored, used, transfer),
        DynamicImage::ImageRgb16(p) => split16(p, stored, used, transfer),
        DynamicImage::ImageRgba16(p) => split16(p, stored, used, transfer),
        other => split(&other.to_rgb32f(), 3, 3, |value: f32| {
            transfer.to_linear(value)
        }),
    };
    Ok(Picture {
        width,
        height,
        planes,
        transfer,
        warnings,
    })
}

fn default_transfer(picture: &DynamicImage) -> Transfer {
    let colour = picture.color();
    if colour.bits_per_pixel() / u16::from(colour.channel_count()) == 8 {
        Transfer::Srgb
    } else {
        Transfer::Linear
    }
}

fn split8(samples: &[u8], stored: usize, used: usize, transfer: Transfer) -> Vec<Vec<f32>> {
    let light = light8(transfer);
    split(samples, stored, used, |code| light[usize::from(code)])
}

fn split16(samples: &[u16], stored: usize, used: usize, transfer: Transfer) -> Vec<Vec<f32>> {
    let light = light16(transfer);
    split(samples, stored, used, |code| light[usize::from(code)])
}

/// Returns one plane for each of the first `used` of `stored` channels.
fn split<S: Copy + Sync>(
    samples: &[S],
    stored: usize,
    used: usize,
    light: impl Fn(S) -> f32 + Sync,
) -> Vec<Vec<f32>> {
    let plane = |channel| {
        let pixels = samples.chunks_exact(stored);
        pixels.map(|pixel| light(pixel[channel])).collect()
    };
    (0..used).into_par_iter().map(plane).collect()
}

/// Decodes the whole picture, turns it upright and returns it with warnings.
fn decode(
    path: &Path,
    reader: BufReader<File>,
    format: Format,
) -> Result<(DynamicImage, Vec<String>), Error> {
    let broken = |source| Error::Raster {
        file: path.to_owned(),
        format,
        source,
    };
    let mut reader = ImageReader::with_format(
        reader,
        match format {
            Format::Tiff => ImageFormat::Tiff,
            Format::Jpeg => ImageFormat::Jpeg,
            Format::Png | Format::Exr | Format::Raw => ImageFormat::Png,
        },
    );
    // A decoder with limits would refuse a large picture before it tells the size. So the header is
    // read without limits, which allocates nothing of the size of the picture. The limits are set
    // before the pixels are read.
    reader.no_limits();
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
    let mut picture = DynamicImage::from_decoder(decoder).map_err(broken)?;
    let mut warnings = Vec::new();
    if orientation != Orientation::NoTransforms {
        picture.apply_orientation(orientation);
        warnings.push(TURNED.into());
    }
    Ok((picture, warnings))
}

/// Computes the plane from the picture, and adds warnings about what was assumed.
fn plane(
    path: &Path,
    picture: DynamicImage,
    options: &Decode,
    mut warnings: Vec<String>,
) -> Result<Photo, Error> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let colour = picture.color();
    let bits = colour.bits_per_pixel() / u16::from(colour.channel_count());
    let transfer = options
        .transfer
        .unwrap_or_else(|| default_transfer(&picture));
    if bits == 8 {
        warnings.push(match transfer {
            Transfer::Srgb => {
                "8-bit values, linearised from sRGB, limit the accuracy; prefer linear 16-bit or \
                EXR"
                .into()
            }
            Transfer::Linear => {
                "8-bit values limit the accuracy; prefer linear 16-bit or EXR".into()
            }
        });
    }
    if colour.has_alpha() {
        warnings.push("the alpha channel was ignored".into());
    }
    let (weights, found): (&[f32], &[&str]) = match (colour.has_color(), &options.channel) {
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
            wanted: options.channel.clone(),
            found: found.iter().map(ToString::to_string).collect(),
        });
    }
    let channels = usize::from(colour.channel_count());
    let luminance = match picture {
        DynamicImage::ImageLuma8(pixels) => bytes(&pixels, channels, weights, transfer),
        DynamicImage::ImageLumaA8(pixels) => bytes(&pixels, channels, weights, transfer),
        DynamicImage::ImageRgb8(pixels) => bytes(&pixels, channels, weights, transfer),
        DynamicImage::ImageRgba8(pixels) => bytes(&pixels, channels, weights, transfer),
        DynamicImage::ImageLuma16(pixels) => words(&pixels, channels, weights, transfer),
        DynamicImage::ImageLumaA16(pixels) => words(&pixels, channels, weights, transfer),
        DynamicImage::ImageRgb16(pixels) => words(&pixels, channels, weights, transfer),
        DynamicImage::ImageRgba16(pixels) => words(&pixels, channels, weights, transfer),
        // All other pictures hold floats, which have no full scale.
        other => {
            let pixels = other.into_rgb32f();
            let luminance = weigh(&pixels, 3, weights, None, |value: f32| {
                transfer.to_linear(value)
            });
            return Ok(Photo {
                width,
                height,
                luminance,
                clip_level: None,
                warnings,
            });
        }
    };
    Ok(Photo {
        width,
        height,
        luminance,
        clip_level: Some(1.0),
        warnings,
    })
}

/// Returns the light of every 8-bit code.
fn light8(transfer: Transfer) -> Vec<f32> {
    (0..=u8::MAX)
        .map(|code| transfer.to_linear(f32::from(code) / 255.0))
        .collect()
}

/// Returns the light of every 16-bit code.
fn light16(transfer: Transfer) -> Vec<f32> {
    (0..=u16::MAX)
        .map(|code| transfer.to_linear(f32::from(code) / 65535.0))
        .collect()
}

fn bytes(samples: &[u8], channels: usize, weights: &[f32], transfer: Transfer) -> Vec<f32> {
    let light = light8(transfer);
    weigh(samples, channels, weights, Some(u8::MAX), |code| {
        light[usize::from(code)]
    })
}

fn words(samples: &[u16], channels: usize, weights: &[f32], transfer: Transfer) -> Vec<f32> {
    let light = light16(transfer);
    weigh(samples, channels, weights, Some(u16::MAX), |code| {
        light[usize::from(code)]
    })
}

/// Returns the weighted sum of the channels of each pixel. If one of the channels used is
/// saturated, the sum is unknown: the pixel is set to full scale, so that [`Photo::clipped`] counts
/// it.
fn weigh<S: Copy + PartialEq>(
    samples: &[S],
    channels: usize,
    weights: &[f32],
    full: Option<S>,
    light: impl Fn(S) -> f32,
) -> Vec<f32> {
    let pixel = |pixel: &[S]| {
        let used = pixel
            .iter()
            .zip(weights)
            .filter(|&(_, &weight)| weight != 0.0);
        if used.clone().any(|(&sample, _)| full == Some(sample)) {
            1.0
        } else {
            used.map(|(&sample, &weight)| weight * light(sample)).sum()
        }
    };
    samples.chunks_exact(channels).map(pixel).collect()
}
