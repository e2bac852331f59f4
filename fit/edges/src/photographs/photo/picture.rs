//! Pictures in colour: linear light in memory.

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
    /// Relation between light and the values of a file of integers that is written. For a picture that was read
    /// it is linear if the file is linear, else sRGB.
    pub transfer: Transfer,
    /// Warnings about what was assumed or repaired, one sentence each.
    pub warnings: Vec<String>,
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

    /// Counts the samples above 1, which files of integers clip.
    pub fn above_white(&self) -> usize {
        let above = |plane: &Vec<f32>| plane.iter().filter(|&&v| v > 1.0).count();
        self.planes.iter().map(above).sum()
    }
}
