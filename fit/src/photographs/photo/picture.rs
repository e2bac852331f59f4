//! Pictures in colour: linear light in, EXR or 16-bit PNG out.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

use crate::photographs::photo::channel::REC709;
use crate::photographs::photo::transfer::Transfer;

/// One plane of linear light, or three: red, green and blue.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Columns, pixels.
    pub width: usize,
    /// Rows, pixels.
    pub height: usize,
    /// Linear light, each plane row-major from the top left, `width * height` finite values.
    /// Integer formats: 1 is full scale.
    pub planes: Vec<Vec<f32>>,
    /// How its file relates to light.
    pub transfer: Transfer,
    /// What was assumed or repaired, one sentence each, for the user.
    pub warnings: Vec<String>,
}

/// What a file of a picture is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Writing {
    /// Linear 32-bit floats.
    Exr,
    /// 16 bits; what is above 1 or below 0 is clipped.
    Png,
}

impl Writing {
    /// The format of a file's ending; `None` for another ending.
    pub fn of(path: &Path) -> Option<Writing> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "exr" => Some(Writing::Exr),
            "png" => Some(Writing::Png),
            _ => None,
        }
    }
}

impl Picture {
    /// Rec. 709 luminance of a pixel by its index.
    pub fn luminance(&self, index: usize) -> f32 {
        match &self.planes[..] {
            [red, green, blue] => {
                REC709[0] * red[index] + REC709[1] * green[index] + REC709[2] * blue[index]
            }
            planes => planes[0][index],
        }
    }

    /// Mean luminance over all pixels, summed in f64.
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

    /// Greatest luminance of a pixel.
    pub fn peak_luminance(&self) -> f64 {
        let pixels = 0..self.width * self.height;
        f64::from(pixels.map(|i| self.luminance(i)).fold(0.0, f32::max))
    }

    /// Adds light to every pixel, then multiplies all by the exposure.
    pub fn expose(&mut self, ambient: f64, exposure: f64) {
        let (ambient, exposure) = (ambient as f32, exposure as f32);
        let samples = self.planes.par_iter_mut().flatten();
        samples.for_each(|value| *value = (*value + ambient) * exposure);
    }

    /// Samples above 1, which a PNG clips.
    pub fn above_white(&self) -> usize {
        let above = |plane: &Vec<f32>| plane.iter().filter(|&&v| v > 1.0).count();
        self.planes.iter().map(above).sum()
    }

    /// The bytes of a file; a PNG is written in the picture's own transfer.
    ///
    /// # Errors
    /// What the encoder says: a picture without pixels, or one beyond the format's size.
    pub fn encode(self, writing: Writing) -> Result<Vec<u8>, String> {
        match writing {
            Writing::Exr => self.exr(),
            Writing::Png => self.png(),
        }
    }

    /// Not compressed: that would take longer than everything else, for a tenth of the size.
    fn exr(self) -> Result<Vec<u8>, String> {
        let names: &[&str] = if self.planes.len() == 3 {
            &["R", "G", "B"]
        } else {
            &["Y"]
        };
        // Samples, a line's own header, and room for the file's.
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

    fn png(&self) -> Result<Vec<u8>, String> {
        let count = self.planes.len();
        let mut samples = vec![0_u8; 2 * count * self.width * self.height];
        let pixels = samples.par_chunks_exact_mut(2 * count).enumerate();
        pixels.for_each(|(index, pixel)| {
            for (plane, sample) in self.planes.iter().zip(pixel.chunks_exact_mut(2)) {
                let stored = self.transfer.to_stored(plane[index]).clamp(0.0, 1.0);
                // The encoder takes samples in the machine's own order.
                sample.copy_from_slice(&((stored * 65535.0).round() as u16).to_ne_bytes());
            }
        });
        let colour = if count == 3 {
            ExtendedColorType::Rgb16
        } else {
            ExtendedColorType::L16
        };
        let mut bytes = Vec::new();
        image::codecs::png::PngEncoder::new(&mut bytes)
            .write_image(&samples, self.width as u32, self.height as u32, colour)
            .map_err(|error| error.to_string())?;
        Ok(bytes)
    }
}
