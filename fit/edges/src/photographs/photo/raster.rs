//! Reading of PNG, TIFF and JPEG photographs.

use std::fs::File;
use std::io::{BufReader, Read};

use rayon::prelude::*;

use crate::photographs::photo::formats::{jpeg, png, tiff};
use crate::photographs::photo::limits::MAX_BYTES;
use crate::photographs::photo::{
    Alpha, Channel, Curve, Curves, Decode, Fault, Format, GIVEN, Photo, Picture, REC709, Samples,
    Stored, TURNED, Transfer, upright,
};

/// A decoded picture, and all that its file says of it.
pub(crate) struct Decoded {
    pub(crate) stored: Stored,
    /// Number of the side that is up, from 1 to 8.
    pub(crate) orientation: Option<u64>,
    /// The curves that the file states, or why they cannot be followed.
    pub(crate) stated: Result<Option<Curves>, Fault>,
    pub(crate) warnings: Vec<String>,
}

/// Reads the plane that `options` ask for.
pub(super) fn read(
    reader: BufReader<File>,
    format: Format,
    options: &Decode,
) -> Result<Photo, Fault> {
    let (decoded, curves) = decode(reader, format, options.transfer)?;
    plane(decoded, &curves, &options.channel)
}

/// Reads red, green and blue, or grey if there is no colour. `transfer` has the meaning of
/// [`Decode::transfer`].
pub(crate) fn read_colour(
    reader: BufReader<File>,
    format: Format,
    transfer: Option<Transfer>,
) -> Result<Picture, Fault> {
    let (decoded, curves) = decode(reader, format, transfer)?;
    let (stored, mut warnings) = (decoded.stored, decoded.warnings);
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
    let orientation = decoded.orientation.unwrap_or(1);
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

/// Decodes the whole picture, and returns it with its curves. `transfer` has the meaning of
/// [`Decode::transfer`].
fn decode(
    reader: BufReader<File>,
    format: Format,
    transfer: Option<Transfer>,
) -> Result<(Decoded, Curves), Fault> {
    let mut decoded = match format {
        Format::Tiff => tiff::read(reader)?,
        Format::Jpeg => jpeg::read(&bytes_of(reader)?)?,
        _ => png::read(&bytes_of(reader)?)?,
    };
    let curves = match transfer {
        Some(given) => Curves::one(Curve::Named(given), GIVEN),
        None => std::mem::replace(&mut decoded.stated, Ok(None))?
            .unwrap_or_else(|| of_format(&decoded.stored.samples)),
    };
    decoded.warnings.extend(curves.doubt.clone());
    if decoded.orientation.is_some_and(|it| (2..=8).contains(&it)) {
        decoded.warnings.push(TURNED.into());
    }
    Ok((decoded, curves))
}

/// Reads a file into memory. A JPEG of the largest photograph is shorter than its pixels.
fn bytes_of(reader: BufReader<File>) -> Result<Vec<u8>, Fault> {
    let mut bytes = Vec::new();
    reader.take(MAX_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
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

/// Computes the plane from the picture, and adds warnings about what was assumed.
pub(crate) fn plane(decoded: Decoded, curves: &Curves, channel: &Channel) -> Result<Photo, Fault> {
    let (stored, mut warnings) = (decoded.stored, decoded.warnings);
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
        let found = found.iter().map(ToString::to_string).collect();
        return Err(Fault::NoChannel(channel.clone(), found));
    }
    let luminance = light(&stored, weights, curves, true);
    let orientation = decoded.orientation.unwrap_or(1);
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
    // Light of every code: one table for all channels, or one for each of red, green and blue.
    let tables = |last: u16| -> Vec<Vec<f32>> {
        let share = |code: u16| f32::from(code) / f32::from(last);
        let light = |curve: &Curve| (0..=last).map(|code| curve.light(share(code))).collect();
        curves.each.iter().map(light).collect()
    };
    match &stored.samples {
        Samples::Bytes(samples) => {
            let tables = tables(u8::MAX.into());
            let light =
                |channel: usize, code: u8| tables[channel.min(tables.len() - 1)][usize::from(code)];
            let full = marks_full.then_some(u8::MAX);
            weigh(samples, channels, weights, full, light)
        }
        Samples::Words(samples) => {
            let tables = tables(u16::MAX);
            let light = |channel: usize, code: u16| {
                tables[channel.min(tables.len() - 1)][usize::from(code)]
            };
            let full = marks_full.then_some(u16::MAX);
            weigh(samples, channels, weights, full, light)
        }
        Samples::Floats(samples, is_whole) => {
            let light = |channel, value: f32| curves.of(channel).light(value);
            let full = (marks_full && *is_whole).then_some(1.0);
            weigh(samples, channels, weights, full, light)
        }
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
