//! Tilt of an edge against the pixel grid, and whether the pixels see enough of the edge by it.
//!
//! Pixels sample an edge once a pixel. Finer samples come from its tilt: along the edge, the pixels
//! of each next row lie at another distance from it, by the tangent of the tilt. They have stood at
//! all distances within a pixel once the edge has crossed one column of pixels. With less, some of
//! the bins of a quarter of a pixel stay empty in every pixel, and straight lines across them blur
//! the profile.

use crate::photographs::edge::fault::Fault;
use crate::photographs::edge::line::EdgeLine;
use crate::photographs::profile::{BIN_PX, Profile};
use crate::photographs::window::Window;

/// Least number of pixels that the edge has to cross.
const LEAST_CROSSED_PX: f64 = 1.0;

/// Tilt below which a warning is given, degrees: the least that ISO 12233 users aim at.
const LEAST_TILT_DEG: f64 = 2.0;

/// Rounding of a measured tilt before it is compared, degrees.
const ROUNDING_DEG: f64 = 0.005;

/// Spread of the pixels within their bins, as a share of that of evenly filled bins, below which
/// the pixels stand in lines. It is 0.37 to 0.43 at a tangent of 1/4, and 0.67 to 0.76 with a tilt
/// of 0.05 degrees beside it. At the next fractions (1/8, 3/4) it is 0.87 or more.
const LINED_UP: f64 = 0.75;

/// Largest relative error of an MTF50 by pixels that stand in lines, over the square of MTF50 in
/// cycles per pixel.
const BY_LINES: f64 = 0.25;

/// Tilt of an edge against the pixel grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slant {
    /// Angle between the edge and the nearer of rows and columns, 0 to 45 degrees.
    pub tilt_deg: f64,
    /// Number of columns that a steep edge crosses within the window, or of rows that a flat edge
    /// crosses, pixels.
    pub crossed_px: f64,
}

impl Slant {
    /// Measures the tilt of an edge in its window. A curve crosses pixels too.
    pub fn of(line: &EdgeLine, window: &Window) -> Slant {
        const PARTS: i32 = 64;
        let (sin, cos) = line.normal_rad.sin_cos();
        let steep = cos.abs() >= sin.abs();
        let along = if steep {
            0.5 * (window.height() as f64 - 1.0) / cos.abs()
        } else {
            0.5 * (window.width() as f64 - 1.0) / sin.abs()
        };
        let places = (-PARTS..=PARTS).map(|k| {
            let t = along * f64::from(k) / f64::from(PARTS);
            let across = line.offset_px + line.bend.map_or(0.0, |bend| bend.at(t).0);
            if steep {
                across * cos - t * sin
            } else {
                across * sin + t * cos
            }
        });
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = places.fold(ends, |(low, high), v| (low.min(v), high.max(v)));
        Slant {
            tilt_deg: line.tilt_deg(),
            crossed_px: high - low,
        }
    }

    /// Refuses an edge that is aligned with the pixel grid, and returns a warning about one that
    /// nearly is.
    pub fn check(self) -> Result<Option<String>, Fault> {
        let Slant {
            tilt_deg,
            crossed_px,
        } = self;
        if crossed_px < LEAST_CROSSED_PX {
            return Err(Fault::Aligned {
                tilt_deg,
                crossed_px,
            });
        }
        Ok((tilt_deg < LEAST_TILT_DEG - ROUNDING_DEG).then(|| {
            format!(
                "the edge is tilted by only {tilt_deg:.2} degrees from the pixel grid, so it \
                crosses {crossed_px:.1} pixels in the window and each bin is filled from few \
                places along the edge; tilt it by 2 to 10 degrees, best by 5 (ISO 12233)"
            )
        }))
    }
}

/// Returns a warning if the pixels stand in lines along the edge that are as far apart as the bins,
/// and if that can change MTF50 by more than its standard error. Both are in cycles per pixel.
///
/// The tangent of the tilt is then 1/4. Each bin holds one line, which stands at another place in
/// each next bin, until one bin holds two. Other simple fractions leave bins empty, of which
/// [`Profile::warnings`] warns, or put two lines and more in a bin, which has less effect.
pub fn lined_up(profile: &Profile, mtf50: f64, standard_error: f64) -> Option<String> {
    let even = BIN_PX / 12.0_f64.sqrt();
    if profile.empty_bins() > 0 || profile.spread_within_px() > LINED_UP * even {
        return None;
    }
    let error = BY_LINES * mtf50 * mtf50;
    (error * mtf50 > standard_error).then(|| {
        format!(
            "the pixels stand in lines as far apart as the bins, because the tangent of the \
            edge's tilt is 1/4 (14.04 degrees): MTF50 can be off by {:.1} %, more than its \
            standard error; tilt the edge by half a degree more or less",
            100.0 * error
        )
    })
}
