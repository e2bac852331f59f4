//! The colour space that a camera names in the Exif data of a JPEG (Exif 2.32, section 4.6.5).
//!
//! Cameras name Adobe RGB in two parts (DCF 2.0, the "optional file"): the tag `ColorSpace` is
//! "uncalibrated", and the interoperability index is "R03". Many of them add no ICC profile.

use exif::{Exif, In, Tag, Value};

use crate::photographs::photo::curve::Curve;
use crate::photographs::photo::taken::Curves;
use crate::photographs::photo::transfer::Transfer;

/// Value of `ColorSpace` for sRGB.
const SRGB: u32 = 1;

/// Value of `ColorSpace` for any other space.
const UNCALIBRATED: u32 = 0xffff;

/// Exponent of the curve of Adobe RGB (Adobe RGB (1998) Color Image Encoding, section 4.3.4.2).
const ADOBE_RGB: f64 = 563.0 / 256.0;

/// Returns the curve of the colour space that Exif data name. Returns `None` for sRGB, which is the
/// default, and if they name none.
///
/// A space that is not sRGB and has no name is read as sRGB, with a doubt.
pub(crate) fn curves(exif: &Exif) -> Option<Curves> {
    let space = exif.get_field(Tag::ColorSpace, In::PRIMARY)?;
    let space = space.value.get_uint(0).filter(|&space| space != SRGB)?;
    let index = exif.get_field(Tag::InteroperabilityIndex, In::PRIMARY);
    let is_optional = index.is_some_and(|field| match &field.value {
        Value::Ascii(texts) => texts.first().is_some_and(|text| text == b"R03"),
        _ => false,
    });
    if space == UNCALIBRATED && is_optional {
        return Some(Curves::one(Curve::Power(ADOBE_RGB), "Exif: Adobe RGB"));
    }
    let mut curves = Curves::one(Curve::Named(Transfer::Srgb), "default of 8 bits");
    curves.doubt = Some(
        "its Exif data say that its colours are not sRGB, but not which curve they have, so that \
        of sRGB was taken; convert the photograph to sRGB or to linear light, or set `transfer`"
            .into(),
    );
    Some(curves)
}
