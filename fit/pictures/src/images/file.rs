//! Pictures as files: EXR with linear light; PNG, TIFF and JPEG for programs that show pictures.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use png::{
    BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, ScaledFloat,
    SrgbRenderingIntent,
};
use rayon::prelude::*;

use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;

/// Quality of a JPEG: its blocks are not seen beside the picture itself.
const JPEG_QUALITY: u8 = 95;

/// The format in which a picture is written. Files of integers clip values above 1 or below 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Writing {
    /// EXR with linear 32-bit floats, not compressed.
    Exr,
    /// PNG: 8 bits in sRGB, or 16 bits of linear light if the picture's transfer is linear.
    Png,
    /// TIFF with the samples of the PNG, not compressed.
    Tiff,
    /// JPEG in sRGB.
    Jpeg,
}

impl Writing {
    /// Returns the format that the extension of a file stands for, or `None` for another extension.
    pub fn of(path: &Path) -> Option<Writing> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "exr" => Some(Writing::Exr),
            "png" => Some(Writing::Png),
            "tif" | "tiff" => Some(Writing::Tiff),
            "jpg" | "jpeg" => Some(Writing::Jpeg),
            _ => None,
        }
    }

    /// Returns the bytes of a picture's file.
    ///
    /// # Errors
    /// Returns the encoder's message if the picture has no pixels, or if it is too large for the
    /// format.
    pub fn bytes(self, picture: Picture) -> Result<Vec<u8>, String> {
        match self {
            Writing::Exr => exr(picture),
            Writing::Png => png(&picture).map_err(|error| error.to_string()),
            Writing::Tiff => tiff(&picture),
            Writing::Jpeg => jpeg(&picture),
        }
    }
}

/// Encodes a picture as EXR without compression. Compression would take longer than all other steps
/// and save a tenth of the size.
fn exr(picture: Picture) -> Result<Vec<u8>, String> {
    let names: &[&str] = if picture.planes.len() == 3 {
        &["R", "G", "B"]
    } else {
        &["Y"]
    };
    // Room for the samples, the header of each line, and the header of the file.
    let line = picture.planes.len() * 4 * picture.width + 16;
    let size = line * picture.height + 4096;
    let channels = names.iter().zip(picture.planes);
    let channels = channels
        .map(|(name, plane)| AnyChannel::new(*name, FlatSamples::F32(plane)))
        .collect();
    let layer = Layer::new(
        Vec2(picture.width, picture.height),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(channels),
    );
    let mut bytes = Cursor::new(Vec::with_capacity(size));
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Returns the bits of a sample in files of integers. Linear light in 8 bits would show steps in the
/// dark.
fn bits(picture: &Picture) -> usize {
    match picture.transfer {
        Transfer::Linear => 16,
        Transfer::Srgb => 8,
    }
}

/// Returns the samples of all pixels in a transfer, the highest byte first.
fn samples(picture: &Picture, transfer: Transfer, bits: usize) -> Vec<u8> {
    let size = bits / 8;
    let full = ((1_u32 << bits) - 1) as f32;
    let each = size * picture.planes.len();
    let mut samples = vec![0; each * picture.width * picture.height];
    let pixels = samples.par_chunks_exact_mut(each.max(1)).enumerate();
    pixels.for_each(|(index, pixel)| {
        for (plane, sample) in picture.planes.iter().zip(pixel.chunks_exact_mut(size)) {
            let stored = transfer.to_stored(plane[index]).clamp(0.0, 1.0);
            let code = (stored * full).round() as u16;
            sample.copy_from_slice(&code.to_be_bytes()[2 - size..]);
        }
    });
    samples
}

/// Encodes a picture as PNG. The file says which transfer it has: sRGB by the chunk of this name,
/// linear light by a gAMA chunk of 1.
fn png(picture: &Picture) -> Result<Vec<u8>, EncodingError> {
    let bits = bits(picture);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, picture.width as u32, picture.height as u32);
    encoder.set_color(match picture.planes.len() {
        3 => ColorType::Rgb,
        _ => ColorType::Grayscale,
    });
    encoder.set_depth(match bits {
        8 => BitDepth::Eight,
        _ => BitDepth::Sixteen,
    });
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    match picture.transfer {
        Transfer::Linear => encoder.set_source_gamma(ScaledFloat::new(1.0)),
        Transfer::Srgb => encoder.set_source_srgb(SrgbRenderingIntent::Perceptual),
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&samples(picture, picture.transfer, bits))?;
    writer.finish()?;
    Ok(bytes)
}

/// Encodes a picture as TIFF of one strip (TIFF 6.0, sections 2 to 6). By custom, as `fit` reads it
/// too, 8 bits are sRGB and 16 bits are linear.
fn tiff(picture: &Picture) -> Result<Vec<u8>, String> {
    const HEADER: u32 = 8;
    const ENTRIES: u32 = 10;
    let bits = bits(picture);
    let data = samples(picture, picture.transfer, bits);
    let channels = picture.planes.len() as u32;
    let size = u32::try_from(data.len()).map_err(|_| "a TIFF ends at 4 GB".to_owned())?;
    // The directory comes first, then the bits of three channels, which do not fit into an entry.
    let directory_end = HEADER + 2 + 12 * ENTRIES + 4;
    let start = directory_end + 2 * channels;
    let (short, long) = (3, 4);
    let one = |value: usize| (1, (value as u32) << 16);
    let bits_entry = match channels {
        1 => one(bits),
        _ => (channels, directory_end),
    };
    let entries: [(u16, u16, (u32, u32)); ENTRIES as usize] = [
        (256, long, (1, picture.width as u32)),
        (257, long, (1, picture.height as u32)),
        (258, short, bits_entry),
        (259, short, one(1)),
        (262, short, one(if channels == 3 { 2 } else { 1 })),
        (273, long, (1, start)),
        (277, short, one(channels as usize)),
        (278, long, (1, picture.height as u32)),
        (279, long, (1, size)),
        (284, short, one(1)),
    ];
    let mut bytes = Vec::with_capacity(start as usize + data.len());
    bytes.extend(b"MM\0*");
    bytes.extend(HEADER.to_be_bytes());
    bytes.extend((ENTRIES as u16).to_be_bytes());
    for (tag, kind, (count, value)) in entries {
        bytes.extend(tag.to_be_bytes());
        bytes.extend(kind.to_be_bytes());
        bytes.extend(count.to_be_bytes());
        bytes.extend(value.to_be_bytes());
    }
    bytes.extend([0; 4]);
    for _ in 0..channels {
        bytes.extend((bits as u16).to_be_bytes());
    }
    bytes.extend(data);
    Ok(bytes)
}

/// Encodes a picture as JPEG.
fn jpeg(picture: &Picture) -> Result<Vec<u8>, String> {
    let side = |pixels: usize| {
        u16::try_from(pixels).map_err(|_| "a JPEG has at most 65535 pixels a side".to_owned())
    };
    let [width, height] = [side(picture.width)?, side(picture.height)?].map(u32::from);
    let kind = match picture.planes.len() {
        3 => ExtendedColorType::Rgb8,
        _ => ExtendedColorType::L8,
    };
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
        .encode(&samples(picture, Transfer::Srgb, 8), width, height, kind)
        .map_err(|error| error.to_string())?;
    Ok(bytes)
}
