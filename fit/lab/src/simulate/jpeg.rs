//! Photographs as a camera saves them in 8 bits: sRGB-coded and packed as JPEG.
//!
//! The curve of sRGB stands here again on purpose: a campaign then tests the curve of the reader.

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageFormat};

/// Returns the JPEG of a grey photograph, row-major, full scale 1. Values are sRGB-coded (IEC
/// 61966-2-1) and rounded to 8 bits.
///
/// # Errors
/// Returns the encoder's message if a side is above 65,535 pixels.
pub(crate) fn packed(
    pixels: &[f32],
    [width, height]: [usize; 2],
    quality: u8,
) -> Result<Vec<u8>, image::ImageError> {
    let coded: Vec<u8> = pixels
        .iter()
        .map(|&v| (255.0 * coded(v)).round() as u8)
        .collect();
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, quality).encode(
        &coded,
        width as u32,
        height as u32,
        ExtendedColorType::L8,
    )?;
    Ok(bytes)
}

/// Returns the photograph of a JPEG of [`packed`] in linear light.
///
/// # Errors
/// Returns the decoder's message if the bytes are no JPEG.
pub(crate) fn unpacked(bytes: &[u8]) -> Result<Vec<f32>, image::ImageError> {
    let picture = image::load_from_memory_with_format(bytes, ImageFormat::Jpeg)?;
    let light: Vec<f32> = (0..=u8::MAX)
        .map(|code| linear(f32::from(code) / 255.0))
        .collect();
    let codes = picture.into_luma8().into_raw();
    Ok(codes
        .into_iter()
        .map(|code| light[usize::from(code)])
        .collect())
}

fn coded(light: f32) -> f32 {
    let light = light.clamp(0.0, 1.0);
    if light < 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

fn linear(code: f32) -> f32 {
    if code < 0.040_45 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}
