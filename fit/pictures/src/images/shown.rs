//! Pictures as a page holds them: few pixels, 8 bits in sRGB.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::imageops::{self, FilterType as Resampling};
use image::{Rgb, Rgb32FImage, RgbImage};

use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;

/// Returns a picture whose longer side has at most `side` pixels; the same where it has fewer.
pub fn at_most(picture: &Picture, side: usize) -> Picture {
    let longer = picture.width.max(picture.height);
    if longer <= side {
        return picture.clone();
    }
    let scale = side as f64 / longer as f64;
    let shown = |pixels: usize| ((pixels as f64 * scale).round() as u32).max(1);
    let light = Rgb32FImage::from_fn(picture.width as u32, picture.height as u32, |x, y| {
        let at = y as usize * picture.width + x as usize;
        Rgb([0, 1, 2].map(|k| plane(picture, k)[at]))
    });
    let [width, height] = [picture.width, picture.height].map(shown);
    let light = imageops::resize(&light, width, height, Resampling::Triangle);
    let count = picture.planes.len();
    let plane = |k: usize| light.pixels().map(|pixel| pixel.0[k]).collect();
    Picture {
        width: width as usize,
        height: height as usize,
        planes: (0..count).map(plane).collect(),
        transfer: picture.transfer,
        warnings: picture.warnings.clone(),
    }
}

/// Encodes a picture as PNG of three colours with 8 bits in sRGB. Light above 1 is clipped.
pub fn png(picture: &Picture) -> Vec<u8> {
    let code = |light: f32| (255.0 * Transfer::Srgb.to_stored(light).clamp(0.0, 1.0)).round() as u8;
    let pixels = RgbImage::from_fn(picture.width as u32, picture.height as u32, |x, y| {
        let at = y as usize * picture.width + x as usize;
        Rgb([0, 1, 2].map(|k| code(plane(picture, k)[at])))
    });
    let mut bytes = Vec::new();
    let encoder =
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    pixels
        .write_with_encoder(encoder)
        .expect("memory takes every byte of a picture that has pixels");
    bytes
}

/// Returns the plane of a colour; that of a grey picture is its only one.
fn plane(picture: &Picture, colour: usize) -> &[f32] {
    &picture.planes[colour.min(picture.planes.len() - 1)]
}
