//! Reading of JPEG photographs.

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::photographs::photo::formats::scans::Scans;
use crate::photographs::photo::{
    Alpha, Decoded, Fault, Format, Samples, Stored, check_packed, check_size, curve, exif,
};

/// Reads a JPEG that is whole, its profile, and what its Exif data say.
pub(in crate::photographs::photo) fn read(bytes: &[u8]) -> Result<Decoded, Fault> {
    let broken = |error: String| Fault::Damaged(Format::Jpeg, error);
    let mut decoder = decoder(bytes).map_err(broken)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    check_size(width as u64, height as u64)?;
    let (space, channels) = match decoder.input_colorspace() {
        Some(ColorSpace::CMYK | ColorSpace::YCCK) => return Err(Fault::Cmyk),
        Some(ColorSpace::Luma) => (ColorSpace::Luma, 1),
        _ => (ColorSpace::RGB, 3),
    };
    let size = [width as u64, height as u64];
    check_packed(size, channels as u64, bytes.len() as u64)?;
    let Scans {
        left, has_profile, ..
    } = Scans::of(bytes).map_err(Fault::CutShort)?;
    decoder.set_options(decoder.options().jpeg_set_out_colorspace(space));
    let pixels = decoder
        .decode()
        .map_err(|error| broken(error.to_string()))?;
    let exif = exif::read(std::io::Cursor::new(bytes));
    let stated = match decoder.icc_profile() {
        None if has_profile => Err(curve::DAMAGED.to_owned()),
        None => Ok(exif.as_ref().and_then(exif::curves)),
        Some(profile) => curve::curves(&profile, curve::PROFILE, channels == 3).map(Some),
    };
    let left = (left > 0).then(|| {
        format!(
            "{left} bytes of its data lie behind the last pixels; if the picture looks damaged, \
            copy it again"
        )
    });
    Ok(Decoded {
        stored: Stored {
            size: [width, height],
            samples: Samples::Bytes(pixels),
            channels,
            has_colour: channels == 3,
            alpha: Alpha::None,
        },
        orientation: exif.as_ref().and_then(exif::orientation),
        stated: stated.map_err(|reason| Fault::Tone(curve::PROFILE, reason)),
        warnings: left.into_iter().collect(),
    })
}

/// Unpacks a part of a TIFF that is a JPEG of this width and at most this height, and leaves its
/// colours as they are stored.
///
/// # Errors
/// Returns the reason, in words, if it is not whole or cannot be unpacked.
pub(crate) fn unpacked(bytes: &[u8], [width, most]: [usize; 2]) -> Result<Vec<u8>, String> {
    let mut decoder = decoder(bytes)?;
    let size = decoder.dimensions().unwrap_or_default();
    if size.0 != width || size.1 > most {
        return Err(format!("it has {} x {} pixels", size.0, size.1));
    }
    Scans::of(bytes)?;
    let space = decoder.input_colorspace().unwrap_or(ColorSpace::YCbCr);
    decoder.set_options(decoder.options().jpeg_set_out_colorspace(space));
    decoder.decode().map_err(|error| error.to_string())
}

/// Reads the headers.
fn decoder(bytes: &[u8]) -> Result<JpegDecoder<ZCursor<&[u8]>>, String> {
    let options = DecoderOptions::default();
    let options = options.set_max_width(usize::MAX).set_max_height(usize::MAX);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder
        .decode_headers()
        .map_err(|error| error.to_string())?;
    Ok(decoder)
}
