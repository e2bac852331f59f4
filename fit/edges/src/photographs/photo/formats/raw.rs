//! Reading of camera raw (feature `raw`) by rawler: the pixels of one colour, each at its own
//! place.
//!
//! A colour sensor sees red and blue in every fourth pixel and green in every second. To fill in
//! the missing ones (demosaicing), or to average blocks of pixels, is a filter, and the edge
//! profile would show it. So neither is done. Pixels of other colours are excluded, as hot pixels
//! are, and the edge is measured from the remaining pixels at their own places. The MTF is then
//! that of one pixel at the sensor's own pitch. Fewer pixels increase the noise, by a factor of
//! sqrt 2 in green and of 2 in red and blue, but cause no bias.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use rawler::decoders::RawDecodeParams;
use rawler::formats::tiff::Rational;
use rawler::imgop::{Dim2, Point, Rect};
use rawler::rawimage::{BlackLevel, RawPhotometricInterpretation, WhiteLevel};
use rawler::rawsource::RawSource;
use rawler::{CFA, Orientation, RawImage, RawImageData};

use crate::photographs::photo::error::one_line;
use crate::photographs::photo::{
    Channel, Decode, Fault, Photo, Settings, TURNED, Taken, check_size, upright,
};

/// The colours of a filter, in the order of rawler's indices.
const COLOURS: [Channel; 3] = Channel::PRIMARIES;

/// Reads the pixels of one colour: linear light, 0 at the black level and 1 at the white level of
/// the file. Noise below the black level stays below 0.
///
/// Luminance of a colour sensor means its green pixels, with a warning; luminance of a sensor
/// without colours means all pixels.
///
/// # Errors
/// Returns [`Fault::Raw`] if rawler cannot decode the file, [`Fault::NoChannel`] if the sensor does
/// not see the colour, and [`Fault::Size`] if the file claims more pixels than
/// [`crate::photographs::photo::limits::MAX_PIXELS`].
pub fn read(path: &Path, options: &Decode) -> Result<Photo, Fault> {
    let fault = |reason: String| {
        Fault::Raw(format!(
            "cannot be decoded as camera raw ({}); convert it to DNG, or",
            one_line(&reason)
        ))
    };
    // `decode_file` catches panics of the decoder.
    let raw = rawler::decode_file(path).map_err(|error| fault(error.to_string()))?;
    check_size(raw.width as u64, raw.height as u64)?;
    let samples = match &raw.data {
        RawImageData::Integer(samples) => samples.len(),
        RawImageData::Float(samples) => samples.len(),
    };
    if samples != raw.width * raw.height * raw.cpp {
        return Err(fault("it ends before its last pixel".into()));
    }
    let mut warnings = Vec::new();
    let seen = seen(&raw);
    let channel = match &options.channel {
        Channel::Luminance if seen.is_empty() => None,
        wanted => {
            let green = *wanted == Channel::Luminance;
            if green {
                warnings.push(
                    "camera raw has no luminance: its green pixels were used; set `channel` to \
                    choose a colour"
                        .into(),
                );
            }
            let wanted = if green { &Channel::Green } else { wanted };
            let found = seen.iter().copied().find(|&i| COLOURS[i] == *wanted);
            Some(found.ok_or_else(|| {
                let held = match seen.is_empty() {
                    true => vec![Channel::Luminance.to_string()],
                    false => seen.iter().map(|&i| COLOURS[i].to_string()).collect(),
                };
                Fault::NoChannel(wanted.clone(), held)
            })?)
        }
    };
    let (light, size) = plane(&raw, channel)
        .ok_or_else(|| fault("its black level is not below its white level".into()))?;
    let (luminance, [width, height]) = upright(light, size, side(raw.orientation));
    if raw.orientation != Orientation::Normal {
        warnings.push(TURNED.into());
    }
    Ok(Photo {
        width,
        height,
        luminance,
        clip_level: Some(1.0),
        clips_alone: true,
        transfer: Taken::linear("camera raw"),
        warnings,
    })
}

/// Reads the settings of the camera from a camera raw file.
///
/// # Errors
/// Returns what is missing, in words, or the decoder's message if the file cannot be read.
pub(crate) fn settings(path: &Path) -> Result<Settings, String> {
    let read = || {
        let source = RawSource::new(path).map_err(|error| error.to_string())?;
        let decoder = rawler::get_decoder(&source).map_err(|error| error.to_string())?;
        let metadata = decoder.raw_metadata(&source, &RawDecodeParams::default());
        metadata.map_err(|error| error.to_string())
    };
    let exif = catch_unwind(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err("its settings cannot be read".into()))?
        .exif;
    let number =
        |value: Option<Rational>| value.map(|value| f64::from(value.n) / f64::from(value.d));
    // Exif 2.3 stores an ISO of 65535 or more in another field, and 65535 in this one.
    let short = exif.iso_speed_ratings.filter(|&iso| iso < u16::MAX);
    let iso = short
        .map(f64::from)
        .or(exif.recommended_exposure_index.map(f64::from))
        .or(exif.iso_speed.map(f64::from));
    Settings::new([number(exif.exposure_time), number(exif.fnumber), iso])
}

/// Returns the indices of the colours that the sensor distinguishes; none for a sensor without
/// colours.
fn seen(raw: &RawImage) -> Vec<usize> {
    match &raw.photometric {
        RawPhotometricInterpretation::Cfa(mosaic) => {
            let cfa = &mosaic.cfa;
            let places = (0..cfa.height).flat_map(|row| (0..cfa.width).map(move |c| (row, c)));
            let mut seen: Vec<usize> = places.map(|(row, c)| cfa.color_at(row, c)).collect();
            seen.sort_unstable();
            seen.dedup();
            seen.retain(|&colour| colour < COLOURS.len());
            seen
        }
        _ if raw.cpp == COLOURS.len() => (0..COLOURS.len()).collect(),
        _ => Vec::new(),
    }
}

/// Returns the lit part of the sensor in light, and its size; NaN marks pixels of another colour. Returns `None`
/// if the white level of a pixel is not above its black level.
fn plane(raw: &RawImage, channel: Option<usize>) -> Option<(Vec<f32>, [usize; 2])> {
    let whole = Rect::new(Point::zero(), Dim2::new(raw.width, raw.height));
    let Rect { p, d } = raw.crop_area.or(raw.active_area).unwrap_or(whole);
    let lit = p.x + d.w <= raw.width && p.y + d.h <= raw.height && d.w > 0 && d.h > 0;
    let Rect { p, d } = if lit { Rect { p, d } } else { whole };
    let mosaic: Option<&CFA> = match &raw.photometric {
        RawPhotometricInterpretation::Cfa(mosaic) => Some(&mosaic.cfa),
        _ => None,
    };
    let samples = raw.data.as_f32();
    let sample = channel.filter(|_| mosaic.is_none()).unwrap_or(0);
    let mut light = Vec::with_capacity(d.w * d.h);
    for row in p.y..p.y + d.h {
        for column in p.x..p.x + d.w {
            let other = |cfa: &CFA| channel != Some(cfa.color_at(row, column));
            if mosaic.is_some_and(other) {
                light.push(f32::NAN);
                continue;
            }
            let black = black(&raw.blacklevel, row, column, sample);
            let white = white(&raw.whitelevel, raw.cpp, row, column, sample);
            if white <= black {
                return None;
            }
            let value = samples[(row * raw.width + column) * raw.cpp + sample];
            let share = ((value - black) / (white - black)).min(1.0);
            // A file of floats may hold values that are not finite.
            light.push(if share.is_finite() { share } else { f32::NAN });
        }
    }
    Some((light, [d.w, d.h]))
}

/// Returns the black level at a pixel. The levels of a file are a pattern that repeats.
fn black(level: &BlackLevel, row: usize, column: usize, sample: usize) -> f32 {
    let (row, column) = (row % level.height.max(1), column % level.width.max(1));
    let index = (row * level.width + column) * level.cpp + sample;
    let level = level.levels.get(index).or(level.levels.first());
    level.map_or(0.0, Rational::as_f32)
}

/// Returns the white level at a pixel. A file has one level for all, one for every sample of a
/// pixel, or one for every place of a mosaic of 2 x 2.
fn white(level: &WhiteLevel, cpp: usize, row: usize, column: usize, sample: usize) -> f32 {
    let index = match level.0.len() {
        4 if cpp == 1 => 2 * (row % 2) + column % 2,
        _ => sample,
    };
    let level = level.0.get(index).or(level.0.first());
    level.map_or(1.0, |&level| level as f32)
}

/// Returns the number of the side that is up, as files write it.
fn side(orientation: Orientation) -> u64 {
    let known = (1..=8).find(|&number| Orientation::from_u16(number) == orientation);
    known.unwrap_or(1).into()
}
