//! The transfer that a PNG names: its chunks cICP, iCCP, sRGB and gAMA, in this order
//! (Portable Network Graphics, third edition, section 4.3).

use std::io::{BufRead, Seek, SeekFrom};

use crate::photographs::photo::curve::Curve;
use crate::photographs::photo::icc;
use crate::photographs::photo::limits::HEADER_BYTES;
use crate::photographs::photo::taken::Curves;
use crate::photographs::photo::transfer::Transfer;

/// A chunk that cannot be followed, and why.
pub(crate) type Unfollowed = (&'static str, String);

/// Names of the chunks that name a transfer, the strongest first.
const NAMES: [&str; 4] = ["cICP", "iCCP", "sRGB", "gAMA"];

/// Returns the curves that the chunks of a PNG name, or `None` if they name none. The reader is at
/// the start of the file and is left somewhere in it. `colour` says whether the picture has
/// colours.
///
/// # Errors
/// Returns the chunk and a reason, in words, if the strongest chunk is damaged or names a transfer
/// that is not read.
pub(crate) fn curves(
    reader: &mut (impl BufRead + Seek),
    colour: bool,
) -> Result<Option<Curves>, Unfollowed> {
    let present = present(reader);
    if present.is_empty() || reader.rewind().is_err() {
        return Ok(None);
    }
    let limits = png::Limits {
        bytes: HEADER_BYTES as usize,
    };
    let mut decoder = png::Decoder::new_with_limits(reader, limits);
    decoder.set_ignore_text_chunk(true);
    // A header that cannot be read is refused when the pixels are.
    let Ok(reader) = decoder.read_info() else {
        return Ok(None);
    };
    let info = reader.info();
    for name in present {
        let damaged = || (name, "it is damaged".to_owned());
        let found = match name {
            "cICP" => {
                let points = info.coding_independent_code_points.ok_or_else(damaged)?;
                code_points(points).map_err(|reason| (name, reason))?
            }
            "iCCP" => {
                let profile = info.icc_profile.as_ref().ok_or_else(damaged)?;
                let read = icc::curves(profile, "iCCP profile", colour);
                Some(read.map_err(|reason| (name, reason))?)
            }
            "sRGB" => {
                info.srgb.ok_or_else(damaged)?;
                Some(Curves::one(Curve::Named(Transfer::Srgb), "sRGB chunk"))
            }
            _ => {
                let stored = info.gama_chunk.ok_or_else(damaged)?.into_scaled();
                // The stored value is the light to this power, in units of 1e-5.
                let exponent = 1e5 / f64::from(stored);
                Some(Curves::one(Curve::Power(exponent), "gAMA chunk"))
            }
        };
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}

/// Returns the curve of the transfer characteristics of ITU-T H.273, table 3, or `None` if they are
/// unspecified.
fn code_points(points: png::CodingIndependentCodePoints) -> Result<Option<Curves>, String> {
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

/// Returns the names among [`NAMES`] that stand before the pixels, in the order of [`NAMES`]. The
/// reader is at the start of the file.
fn present(reader: &mut (impl BufRead + Seek)) -> Vec<&'static str> {
    /// Length of the signature, bytes.
    const SIGNATURE: u64 = 8;
    /// Length of the checksum behind the data of a chunk, bytes.
    const CHECKSUM: i64 = 4;
    let mut found = [false; NAMES.len()];
    let mut at = reader.seek(SeekFrom::Start(SIGNATURE)).is_ok();
    while at {
        let mut head = [0_u8; 8];
        if reader.read_exact(&mut head).is_err() {
            break;
        }
        let [l0, l1, l2, l3, kind @ ..] = head;
        if &kind == b"IDAT" {
            break;
        }
        for (name, found) in NAMES.iter().zip(&mut found) {
            *found |= name.as_bytes() == kind;
        }
        let length = i64::from(u32::from_be_bytes([l0, l1, l2, l3]));
        at = reader.seek_relative(length + CHECKSUM).is_ok();
    }
    let named = NAMES.into_iter().zip(found);
    named
        .filter_map(|(name, found)| found.then_some(name))
        .collect()
}
