//! A picture that another program hands over in memory.

use std::path::PathBuf;

use crate::photographs::photo::channel::{Channel, Decode, REC709};
use crate::photographs::photo::check_finite;
use crate::photographs::photo::curve::Curve;
use crate::photographs::photo::error::Error;
use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::taken::{Curves, GIVEN, Taken};
use crate::photographs::photo::transfer::Transfer;

/// Picture in memory: one plane, or three (red, green and blue).
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
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

impl Held {
    /// Returns one plane of linear light, as from a file.
    ///
    /// # Errors
    /// Returns an error if the picture lacks the channel, or if a value is not finite.
    pub fn photo(&self, options: &Decode) -> Result<Photo, Error> {
        let weights: &[f32] = match (&self.planes[..], &options.channel) {
            ([_], Channel::Luminance) => &[1.0],
            ([_, _, _], Channel::Luminance) => &REC709,
            ([_, _, _], Channel::Red) => &[1.0, 0.0, 0.0],
            ([_, _, _], Channel::Green) => &[0.0, 1.0, 0.0],
            ([_, _, _], Channel::Blue) => &[0.0, 0.0, 1.0],
            (planes, wanted) => {
                let colours: &[&str] = &["luminance", "red", "green", "blue"];
                let found = if planes.len() == 3 {
                    colours
                } else {
                    &colours[..1]
                };
                return Err(Error::NoChannel {
                    file: self.name.clone(),
                    wanted: wanted.clone(),
                    found: found.iter().map(ToString::to_string).collect(),
                });
            }
        };
        for plane in &self.planes {
            check_finite(&self.name, self.width, plane)?;
        }
        let transfer = options.transfer.unwrap_or(Transfer::Linear);
        let used: Vec<(f32, &Vec<f32>)> = (weights.iter().copied())
            .zip(&self.planes)
            .filter(|(weight, _)| *weight != 0.0)
            .collect();
        let pixel = |index: usize| {
            // As in a file: if one of the channels used is saturated, the sum is unknown.
            if self.of_integers && used.iter().any(|(_, plane)| plane[index] == 1.0) {
                return 1.0;
            }
            let light = used
                .iter()
                .map(|(weight, plane)| weight * transfer.to_linear(plane[index]));
            light.sum()
        };
        let luminance: Vec<f32> = (0..self.width * self.height).map(pixel).collect();
        let largest = luminance.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        Ok(Photo {
            width: self.width,
            height: self.height,
            luminance,
            clip_level: (self.of_integers || largest == 1.0).then_some(1.0),
            clips_alone: used.len() == 1,
            transfer: match options.transfer {
                Some(given) => Curves::one(Curve::Named(given), GIVEN).taken(),
                None => Taken::default(),
            },
            warnings: Vec::new(),
        })
    }

    /// Returns the picture in colour, as from a file.
    ///
    /// # Errors
    /// Returns an error if a value is not finite.
    pub fn into_picture(self, transfer: Option<Transfer>) -> Result<Picture, Error> {
        for plane in &self.planes {
            check_finite(&self.name, self.width, plane)?;
        }
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
