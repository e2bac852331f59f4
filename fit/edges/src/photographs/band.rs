//! The part of a large picture that is measured: a band about its edge.
//!
//! Pixels far from the edge say no more than how bright its two sides are, and pixels of the band
//! say that too. The time of every step grows with the number of pixels and with the length of the
//! profile.

use crate::photographs::edge;
use crate::photographs::edge::shape;
use crate::photographs::manifest::roi::Roi;
use crate::photographs::photo::plane::Photo;
use crate::photographs::pixels::defects;
use crate::photographs::profile::Profile;
use crate::photographs::window::Window;

/// Number of pixels from which only a band is measured.
const LARGE: usize = 4_000_000;

/// Approximate number of blocks of the averaged picture in which the edge is searched.
const BLOCKS: f64 = 250_000.0;

/// Distance from the edge to either border of the band, in lengths of the edge's rise from 10 to
/// 90 %, and the least such distance, pixels.
///
/// Photographs of 320 x 256 pixels, on which the estimate was studied, have some ten rises too.
const RISES: f64 = 10.0;
const LEAST_PX: f64 = 400.0;

/// Largest part of a region that a band is worth.
const WORTH: f64 = 0.75;

/// Returns the band about the only edge of a large region: all of the edge, and as much beside it
/// as its blur needs. Returns `None` if the region is small, if the band is about as large, or if
/// no single edge is found.
pub(crate) fn about_the_edge(photo: &Photo, region: Roi) -> Option<Roi> {
    let Roi {
        x,
        y,
        width,
        height,
    } = region;
    if width.checked_mul(height)? < LARGE {
        return None;
    }
    let side = ((width * height) as f64 / BLOCKS).sqrt().ceil() as usize;
    if side > width.min(height) {
        return None;
    }
    let mut blocks = Window::of(photo, Some([x, y, width, height]))?.reduced(side);
    defects::exclude_gross(&mut blocks);
    let (line, _) = edge::straight(&blocks).ok()?;
    let rise = shape::rise_px(&Profile::new(&blocks, &line)?)?;
    let side = side as f64;
    // An averaged edge rises over a block too.
    let beside_px = (RISES * (rise + 1.0) * side).max(LEAST_PX);
    let (sin, cos) = line.normal_rad.sin_cos();
    let offset_px = line.offset_px * side;
    // Places of the edge at both ends of the region, from its middle, across columns or rows.
    let span = |size: usize, length: usize, [across, along]: [f64; 2]| {
        let end = 0.5 * length as f64 * (along / across).abs();
        let middle = 0.5 * size as f64 + offset_px / across;
        let reach = end + beside_px / across.abs();
        let first = (middle - reach).floor().max(0.0) as usize;
        let last = ((middle + reach).ceil().max(0.0) as usize).min(size);
        (first, last.saturating_sub(first))
    };
    let band = if cos.abs() >= sin.abs() {
        let (first, width) = span(width, height, [cos, sin]);
        Roi {
            x: x + first,
            width,
            ..region
        }
    } else {
        let (first, height) = span(height, width, [sin, cos]);
        Roi {
            y: y + first,
            height,
            ..region
        }
    };
    let share = (band.width * band.height) as f64 / (width * height) as f64;
    (share > 0.0 && share < WORTH).then_some(band)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photographs::photo::taken::Taken;

    /// Returns a picture of an edge whose normal has this direction, `offset_px` from the middle,
    /// that rises over about `rise_px`.
    fn picture([width, height]: [usize; 2], deg: f64, offset_px: f64, rise_px: f64) -> Photo {
        let (sin, cos) = deg.to_radians().sin_cos();
        let at = |i: usize| {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let (x, y) = (x - 0.5 * width as f64, y - 0.5 * height as f64);
            let s = (x * cos + y * sin - offset_px) / rise_px;
            (0.5 + 0.4 * (2.2 * s).tanh()) as f32
        };
        Photo {
            width,
            height,
            luminance: (0..width * height).map(at).collect(),
            clip_level: None,
            clips_alone: true,
            transfer: Taken::default(),
            warnings: Vec::new(),
        }
    }

    /// The band holds every place within ten rises of the edge, and little else. It ends at the
    /// border of the picture. Small pictures have none.
    #[test]
    fn a_band_holds_the_edge_and_what_is_beside_it() {
        let mut cases = 0;
        for (deg, offset_px, rise_px) in [
            (5.0, 0.0, 30.0),
            (184.0, -700.0, 60.0),
            (95.0, 300.0, 20.0),
            (-87.0, -200.0, 45.0),
        ] {
            let size = [3000, 2000];
            let photo = picture(size, deg, offset_px, rise_px);
            let whole = Roi {
                x: 0,
                y: 0,
                width: size[0],
                height: size[1],
            };
            let band = about_the_edge(&photo, whole).expect("a band");
            let (sin, cos) = deg.to_radians().sin_cos();
            let beside_px = (RISES * rise_px).max(LEAST_PX);
            let mut farthest: f64 = 0.0;
            for y in (0..size[1]).step_by(50) {
                for x in (0..size[0]).step_by(50) {
                    let (u, v) = (x as f64 - 1500.0, y as f64 - 1000.0);
                    let distance_px = (u * cos + v * sin - offset_px).abs();
                    let is_held = (band.x..band.x + band.width).contains(&x)
                        && (band.y..band.y + band.height).contains(&y);
                    assert!(is_held || distance_px > beside_px, "{deg} {x} {y}");
                    if is_held {
                        farthest = farthest.max(distance_px);
                    }
                }
            }
            // At the ends of the edge the band is wider by the tilt, at most 9 degrees here, and
            // by the blocks.
            let tilted = size[0].max(size[1]) as f64 * 9_f64.to_radians().tan();
            assert!(farthest < 1.6 * beside_px + tilted, "{deg}: {farthest}");
            cases += 1;
        }
        assert_eq!(cases, 4);
        let small = picture([300, 200], 5.0, 0.0, 20.0);
        let whole = Roi {
            x: 0,
            y: 0,
            width: 300,
            height: 200,
        };
        assert_eq!(about_the_edge(&small, whole), None);
    }
}
