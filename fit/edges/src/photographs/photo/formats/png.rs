//! Reading of PNG photographs, and of the transfer that they name: by the chunks cICP, iCCP, sRGB
//! and gAMA, in this order (Portable Network Graphics, third edition, section 4.3).

use std::io::Cursor;

use png::{BitDepth, CodingIndependentCodePoints, DecodeOptions, Decoder, Info, Transformations};

use crate::photographs::photo::limits::HEADER_BYTES;
use crate::photographs::photo::{
    Alpha, Curve, Curves, Decoded, Fault, Format, Samples, Stored, Transfer, check_packed,
    check_size, curve, exif,
};

/// Reads a PNG. Palettes become colours, and samples of less than a byte are spread over one.
pub(in crate::photographs::photo) fn read(bytes: &[u8]) -> Result<Decoded, Fault> {
    let broken = |error: png::DecodingError| Fault::Damaged(Format::Png, error.to_string());
    let mut options = DecodeOptions::default();
    // The checksum of the pixels, which the decoder passes over unless it is told.
    options.set_ignore_adler32(false);
    options.set_ignore_text_chunk(true);
    let mut decoder = Decoder::new_with_options(Cursor::new(bytes), options);
    // A profile may inflate a thousandfold. The pixels have a limit of their own.
    decoder.set_limits(png::Limits {
        bytes: HEADER_BYTES as usize,
    });
    decoder.set_transformations(Transformations::EXPAND);
    // The decoder makes room for rows when it reads on.
    let (width, height) = decoder.read_header_info().map_err(broken)?.size();
    check_size(width.into(), height.into())?;
    let mut reader = decoder.read_info().map_err(broken)?;
    let (colour, depth) = reader.output_color_type();
    let is_wide = depth == BitDepth::Sixteen;
    let pixel = colour.samples() as u64 * if is_wide { 2 } else { 1 };
    check_packed([width.into(), height.into()], pixel, bytes.len() as u64)?;
    let length = reader.output_buffer_size().unwrap_or(0);
    let samples = if is_wide {
        let mut words = vec![0_u16; length / 2];
        let into = bytemuck::cast_slice_mut(&mut words);
        reader.next_frame(into).map_err(broken)?;
        words.iter_mut().for_each(|word| *word = word.to_be());
        Samples::Words(words)
    } else {
        let mut bytes = vec![0; length];
        reader.next_frame(&mut bytes).map_err(broken)?;
        Samples::Bytes(bytes)
    };
    let channels = colour.samples();
    let has_colour = channels > 2;
    let exif = exif::read(Cursor::new(bytes));
    Ok(Decoded {
        stored: Stored {
            size: [width as usize, height as usize],
            samples,
            channels,
            has_colour,
            alpha: match channels % 2 {
                0 => Alpha::Straight,
                _ => Alpha::None,
            },
        },
        orientation: exif.as_ref().and_then(exif::orientation),
        stated: stated(bytes, reader.info(), has_colour),
        warnings: Vec::new(),
    })
}

/// Returns the curves that the strongest chunk names, or `None` if no chunk names any. `colour` says
/// whether the picture has colours.
fn stated(bytes: &[u8], info: &Info, colour: bool) -> Result<Option<Curves>, Fault> {
    let present = kinds(bytes);
    for name in ["cICP", "iCCP", "sRGB", "gAMA"] {
        if !present.contains(&name.as_bytes()) {
            continue;
        }
        // A chunk that the decoder left out is damaged.
        let found = match name {
            "cICP" => info.coding_independent_code_points.map(code_points),
            "iCCP" => (info.icc_profile.as_ref())
                .map(|profile| curve::curves(profile, "iCCP profile", colour).map(Some)),
            "sRGB" => (info.srgb).map(|_| {
                Ok(Some(Curves::one(
                    Curve::Named(Transfer::Srgb),
                    "sRGB chunk",
                )))
            }),
            // The stored value is the light to this power, in units of 1e-5.
            _ => (info.gama_chunk)
                .map(|gamma| Curve::Power(1e5 / f64::from(gamma.into_scaled())))
                .map(|curve| Ok(Some(Curves::one(curve, "gAMA chunk")))),
        };
        let found = found.unwrap_or_else(|| Err(curve::DAMAGED.to_owned()));
        if let Some(curves) = found.map_err(|reason| Fault::Tone(name, reason))? {
            return Ok(Some(curves));
        }
    }
    Ok(None)
}

/// Returns the kinds of the chunks that stand before the pixels.
fn kinds(png: &[u8]) -> Vec<&[u8]> {
    let (mut kinds, mut rest) = (Vec::new(), png.get(8..).unwrap_or_default());
    while let Some((&[a, b, c, d], behind)) = rest.split_first_chunk::<4>() {
        let kind = behind.get(..4).unwrap_or_default();
        if kind == b"IDAT" {
            break;
        }
        kinds.push(kind);
        // Behind the data stands a checksum.
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        rest = behind.get(length + 8..).unwrap_or_default();
    }
    kinds
}

/// Returns the curve of the transfer characteristics of ITU-T H.273, table 3, or `None` if they are
/// unspecified.
fn code_points(points: CodingIndependentCodePoints) -> Result<Option<Curves>, String> {
    if !points.is_video_full_range_image {
        return Err("it says that the range of the values is narrow, as in video".into());
    }
    let curve = match points.transfer_function {
        2 => return Ok(None),
        1 | 6 | 14 | 15 => Curve::Bt709,
        4 => Curve::Power(2.2),
        5 => Curve::Power(2.8),
        8 => Curve::Named(Transfer::Linear),
        13 => Curve::Named(Transfer::Srgb),
        16 => return Err("it names the curve PQ of SMPTE ST 2084".into()),
        18 => return Err("it names the curve HLG of ARIB STD-B67".into()),
        other => {
            return Err(format!(
                "it names transfer characteristics {other} of H.273"
            ));
        }
    };
    Ok(Some(Curves::one(curve, "cICP chunk")))
}
