//! Pictures in colour: linear light in memory, EXR or 16-bit PNG as files.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use png::{
    BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, ScaledFloat,
    SrgbRenderingIntent,
};
use rayon::prelude::*;

use crate::photographs::photo::{REC709, Transfer};

/// A picture of one plane of linear light, or of three: red, green and blue.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Linear light, each plane row-major from the top left, `width * height` finite values. For
    /// integer formats 1 is full scale.
    pub planes: Vec<Vec<f32>>,
    /// Relation between light and the values of a PNG that is written. For a picture that was read
    /// it is linear if the file is linear, else sRGB.
    pub transfer: Transfer,
    /// Warnings about what was assumed or repaired, one sentence each.
    pub warnings: Vec<String>,
}

/// The format in which a picture is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Writing {
    /// EXR with linear 32-bit floats, not compressed.
    Exr,
    /// PNG with 16 bits. Values above 1 or below 0 are clipped.
    Png,
}

impl Writing {
    /// Returns the format that the extension of a file stands for, or `None` for another extension.
    pub fn of(path: &Path) -> Option<Writing> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "exr" => Some(Writing::Exr),
            "png" => Some(Writing::Png),
            _ => None,
        }
    }
}

impl Picture {
    /// Returns the Rec. 709 luminance of the pixel with this index.
    pub fn luminance(&self, index: usize) -> f32 {
        match &self.planes[..] {
            [red, green, blue] => {
                REC709[0] * red[index] + REC709[1] * green[index] + REC709[2] * blue[index]
            }
            planes => planes[0][index],
        }
    }

    /// Returns the mean luminance over all pixels, summed in f64.
    pub fn mean_luminance(&self) -> f64 {
        let mean = |plane: &Vec<f32>| {
            plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64
        };
        match &self.planes[..] {
            [_, _, _] => (self.planes.iter().zip(REC709))
                .map(|(plane, weight)| f64::from(weight) * mean(plane))
                .sum(),
            planes => mean(&planes[0]),
        }
    }

    /// Returns the greatest luminance of all pixels, at least 0.
    pub fn peak_luminance(&self) -> f64 {
        let pixels = 0..self.width * self.height;
        f64::from(pixels.map(|i| self.luminance(i)).fold(0.0, f32::max))
    }

    /// Returns the largest value of all planes, or 0 if none is above it.
    pub fn peak(&self) -> f64 {
        let values = self.planes.iter().flatten();
        f64::from(values.copied().fold(0.0, f32::max))
    }

    /// Adds ambient light to every pixel, then multiplies all pixels by the exposure.
    pub fn expose(&mut self, ambient: f64, exposure: f64) {
        let (ambient, exposure) = (ambient as f32, exposure as f32);
        let samples = self.planes.par_iter_mut().flatten();
        samples.for_each(|value| *value = (*value + ambient) * exposure);
    }

    /// Returns the picture with each square of `factor` by `factor` pixels made one, their mean.
    ///
    /// It is dark beyond the right and the lower rim, as the mid-air image is.
    pub fn reduced(&self, factor: usize) -> Picture {
        let [width, height] = [self.width, self.height].map(|side| side.div_ceil(factor));
        let share = 1.0 / (factor * factor) as f64;
        let plane = |own: &Vec<f32>| {
            let mut sums = vec![0.0_f64; width * height];
            for (row, line) in own.chunks_exact(self.width).enumerate() {
                let into = &mut sums[row / factor * width..][..width];
                for (sum, pixels) in into.iter_mut().zip(line.chunks(factor)) {
                    *sum += pixels.iter().map(|&value| f64::from(value)).sum::<f64>();
                }
            }
            sums.into_iter().map(|sum| (sum * share) as f32).collect()
        };
        Picture {
            width,
            height,
            planes: self.planes.iter().map(plane).collect(),
            transfer: self.transfer,
            warnings: self.warnings.clone(),
        }
    }

    /// Returns a picture with `left` on the left of this one, and a dark gap between them.
    ///
    /// If one of them is grey and the other one in colour, both are in colour. The lower one is
    /// filled up with darkness.
    pub fn beside(&self, left: &Picture) -> Picture {
        let gap = (left.width / 32).max(1);
        let width = left.width + gap + self.width;
        let height = left.height.max(self.height);
        let plane = |number: usize| {
            let mut plane = vec![0.0; width * height];
            for (picture, column) in [(left, 0), (self, left.width + gap)] {
                let own = &picture.planes[number.min(picture.planes.len() - 1)];
                for (row, line) in own.chunks_exact(picture.width).enumerate() {
                    let start = row * width + column;
                    plane[start..start + line.len()].copy_from_slice(line);
                }
            }
            plane
        };
        let count = left.planes.len().max(self.planes.len());
        Picture {
            width,
            height,
            planes: (0..count).map(plane).collect(),
            transfer: self.transfer,
            warnings: self.warnings.clone(),
        }
    }

    /// Counts the samples above 1, which a PNG clips.
    pub fn above_white(&self) -> usize {
        let above = |plane: &Vec<f32>| plane.iter().filter(|&&v| v > 1.0).count();
        self.planes.iter().map(above).sum()
    }

    /// Returns the bytes of the picture's file. A PNG is written in the picture's own transfer.
    ///
    /// # Errors
    /// Returns the encoder's message if the picture has no pixels, or if it is too large for the
    /// format.
    pub fn encode(self, writing: Writing) -> Result<Vec<u8>, String> {
        match writing {
            Writing::Exr => self.exr(),
            Writing::Png => self.png(),
        }
    }

    /// Encodes the picture as EXR without compression. Compression would take longer than all other
    /// steps and save a tenth of the size.
    fn exr(self) -> Result<Vec<u8>, String> {
        let names: &[&str] = if self.planes.len() == 3 {
            &["R", "G", "B"]
        } else {
            &["Y"]
        };
        // Room for the samples, the header of each line, and the header of the file.
        let size = self.planes.len() * 4 * self.width * self.height + 16 * self.height + 4096;
        let channels = names.iter().zip(self.planes);
        let channels = channels
            .map(|(name, plane)| AnyChannel::new(*name, FlatSamples::F32(plane)))
            .collect();
        let layer = Layer::new(
            Vec2(self.width, self.height),
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

    /// Encodes the picture as PNG. The file says which transfer it has: sRGB by the chunk of this
    /// name, linear light by a gAMA chunk of 1.
    fn png(&self) -> Result<Vec<u8>, String> {
        let count = self.planes.len();
        let mut samples = vec![0_u8; 2 * count * self.width * self.height];
        let pixels = samples.par_chunks_exact_mut(2 * count).enumerate();
        pixels.for_each(|(index, pixel)| {
            for (plane, sample) in self.planes.iter().zip(pixel.chunks_exact_mut(2)) {
                let stored = self.transfer.to_stored(plane[index]).clamp(0.0, 1.0);
                sample.copy_from_slice(&((stored * 65535.0).round() as u16).to_be_bytes());
            }
        });
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(if count == 3 {
            ColorType::Rgb
        } else {
            ColorType::Grayscale
        });
        encoder.set_depth(BitDepth::Sixteen);
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Adaptive);
        match self.transfer {
            Transfer::Linear => encoder.set_source_gamma(ScaledFloat::new(1.0)),
            Transfer::Srgb => encoder.set_source_srgb(SrgbRenderingIntent::Perceptual),
        }
        let text = |error: EncodingError| error.to_string();
        let mut writer = encoder.write_header().map_err(text)?;
        writer.write_image_data(&samples).map_err(text)?;
        writer.finish().map_err(text)?;
        Ok(bytes)
    }
}
