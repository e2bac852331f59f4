//! A picture that another program hands over in memory.

use std::path::PathBuf;

use crate::photographs::photo::raster::plane;
use crate::photographs::photo::{
    Alpha, Curve, Curves, Decode, Decoded, Error, GIVEN, Photo, Picture, Samples, Stored, Transfer,
    check_finite,
};

/// Picture in memory: one plane, or three (red, green and blue).
#[derive(Debug, Clone, PartialEq)]
pub struct InMemory {
    /// Name for messages.
    pub name: PathBuf,
    /// Number of columns, above 0.
    pub width: usize,
    /// Number of rows, above 0.
    pub height: usize,
    /// Values, each plane row-major from the top left, `width * height` of them. They are linear
    /// light unless a `transfer` is named.
    pub planes: Vec<Vec<f32>>,
    /// True if the values were integers, divided by the largest integer of their type. A value of 1
    /// is then saturated.
    pub of_integers: bool,
}

impl InMemory {
    /// Returns one plane of linear light, as from a file.
    ///
    /// # Errors
    /// Returns an error if the picture lacks the channel, or if a value is not finite.
    pub fn photo(&self, options: &Decode) -> Result<Photo, Error> {
        self.check_finite()?;
        let pixels = 0..self.width * self.height;
        let samples = pixels.flat_map(|i| self.planes.iter().map(move |plane| plane[i]));
        let decoded = Decoded {
            stored: Stored {
                size: [self.width, self.height],
                samples: Samples::Floats(samples.collect(), self.of_integers),
                channels: self.planes.len(),
                has_colour: self.planes.len() == 3,
                alpha: Alpha::None,
            },
            orientation: None,
            stated: Ok(None),
            warnings: Vec::new(),
        };
        let curves = match options.transfer {
            Some(given) => Curves::one(Curve::Named(given), GIVEN),
            None => Curves::one(Curve::Named(Transfer::Linear), "memory"),
        };
        let photo = plane(decoded, &curves, &options.channel);
        let mut photo = photo.map_err(|fault| fault.of(&self.name))?;
        let largest = photo.luminance.iter().copied().fold(0.0, f32::max);
        photo.clip_level = (self.of_integers || largest == 1.0).then_some(1.0);
        Ok(photo)
    }

    fn check_finite(&self) -> Result<(), Error> {
        let mut planes = self.planes.iter();
        let checked = planes.try_for_each(|plane| check_finite(self.width, plane));
        checked.map_err(|fault| fault.of(&self.name))
    }

    /// Returns the picture in colour, as from a file.
    ///
    /// # Errors
    /// Returns an error if a value is not finite.
    pub fn into_picture(self, transfer: Option<Transfer>) -> Result<Picture, Error> {
        self.check_finite()?;
        let transfer = transfer.unwrap_or(Transfer::Linear);
        let mut planes = self.planes;
        if transfer != Transfer::Linear {
            let values = planes.iter_mut().flatten();
            values.for_each(|value| *value = transfer.to_linear(*value));
        }
        Ok(Picture {
            width: self.width,
            height: self.height,
            planes,
            transfer,
            warnings: Vec::new(),
        })
    }
}
