//! A straight edge in a window: its direction and place.

use crate::photographs::window::Pixel;

/// A straight edge in a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeLine {
    /// Direction of the normal, which points from dark to bright, from +x (right) towards +y
    /// (down); radians, in (-pi, pi].
    pub normal_rad: f64,
    /// Signed distance of the edge from the window's centre along the normal, pixels.
    pub offset_px: f64,
    /// Standard error of `normal_rad` by pixel noise, radians.
    pub normal_standard_error_rad: f64,
}

impl EdgeLine {
    /// Returns whether the edge is tilted by 1 to 44 degrees from rows and columns.
    pub fn is_slanted(&self) -> bool {
        let tilt = self.normal_rad.to_degrees().rem_euclid(90.0);
        (1.0..=44.0).contains(&tilt.min(90.0 - tilt))
    }

    /// Returns the place of a pixel relative to the edge: the distance from it, positive on the
    /// bright side, and the place along it; both in pixels.
    pub fn place(&self, pixel: &Pixel) -> (f64, f64) {
        let (sin, cos) = self.normal_rad.sin_cos();
        (
            pixel.x * cos + pixel.y * sin - self.offset_px,
            pixel.y * cos - pixel.x * sin,
        )
    }
}
