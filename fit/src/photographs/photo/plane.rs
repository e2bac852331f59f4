//! A photograph in memory.

/// One plane of linear light.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// Columns, pixels.
    pub width: usize,
    /// Rows, pixels.
    pub height: usize,
    /// Linear light, row-major from the top left, `width * height` values. Integer formats: 1 is
    /// full scale. EXR: as stored. Finite, but for camera raw: NaN where the sensor saw another
    /// colour.
    pub luminance: Vec<f32>,
    /// Value from which a pixel counts as saturated: 1 for integer formats (a colour pixel with any
    /// saturated contributing channel is set to it), 65504 for half-float EXR. Other EXR has no
    /// limit of its own: 1 where the largest value is exactly 1, which a clipped, normalised sensor
    /// image has; else `None`.
    pub clip_level: Option<f32>,
    /// What was assumed or repaired, one sentence each, for the user.
    pub warnings: Vec<String>,
}

impl Photo {
    /// Value at column `x`, row `y`; `None` outside.
    pub fn at(&self, x: usize, y: usize) -> Option<f32> {
        if x < self.width {
            self.luminance.get(y * self.width + x).copied()
        } else {
            None
        }
    }

    /// Number of pixels at or above [`Photo::clip_level`]; 0 where the format has none.
    pub fn clipped(&self) -> usize {
        self.clip_level.map_or(0, |level| {
            self.luminance
                .iter()
                .filter(|&&value| value >= level)
                .count()
        })
    }
}

/// Said of a picture that was turned.
pub(crate) const TURNED: &str =
    "turned upright as its Exif orientation asks; x, y and `roi` refer to the upright picture";
