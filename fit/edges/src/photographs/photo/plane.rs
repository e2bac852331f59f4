//! A photograph in memory.

use crate::photographs::photo::Taken;

/// A photograph: one plane of linear light.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Linear light, row-major from the top left, `width * height` values. For integer formats 1 is
    /// full scale; EXR values are as stored. All values are finite, except in camera raw, where NaN
    /// marks pixels that saw another colour.
    pub luminance: Vec<f32>,
    /// Value from which a pixel counts as saturated; `None` if there is no limit. It is 1 for
    /// integer formats; a colour pixel is set to it if one of the channels used is saturated. For
    /// any EXR it is 1 if the largest value is exactly 1, as in a clipped, normalised image of a
    /// sensor. For other half-float EXR, read as linear, it is 65504.
    pub clip_level: Option<f32>,
    /// True if the light of a pixel is one value of the file. A pixel at `clip_level` then tells
    /// that its noise was cut off there. The light of several channels has no such limit.
    pub clips_alone: bool,
    /// Relation between stored values and light that was taken.
    pub transfer: Taken,
    /// Warnings about what was assumed or repaired, one sentence each.
    pub warnings: Vec<String>,
}

impl Photo {
    /// Returns the value at column `x`, row `y`, or `None` outside the picture.
    pub fn at(&self, x: usize, y: usize) -> Option<f32> {
        if x < self.width {
            self.luminance.get(y * self.width + x).copied()
        } else {
            None
        }
    }

    /// Returns whether the picture was turned upright when it was read.
    pub fn is_turned(&self) -> bool {
        self.warnings.iter().any(|warning| warning == TURNED)
    }

    /// Returns the number of pixels at or above [`Photo::clip_level`]; 0 if there is no such level.
    pub fn clipped(&self) -> usize {
        self.clip_level.map_or(0, |level| {
            self.luminance
                .iter()
                .filter(|&&value| value >= level)
                .count()
        })
    }
}

/// Warning about a picture that was turned upright.
pub(crate) const TURNED: &str =
    "turned upright as its Exif orientation asks; x, y and `roi` refer to the upright picture";

/// Returns words for a message that gives the size of a picture.
pub fn as_shown(turned: bool) -> &'static str {
    if turned {
        " as shown, turned by its Exif orientation"
    } else {
        ""
    }
}
