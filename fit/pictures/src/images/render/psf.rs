//! Weights of the blur between pixels: the light that one square pixel sends to every other pixel.
//!
//! A pixel is a square of even light, and a pixel of the image is the mean over its square. The
//! weight between two pixels at the distance d is therefore the point spread averaged over both
//! squares. Its transform is the OTF times sinc^2 along both axes, summed over the frequencies that
//! look alike on whole pixels:
//!
//! `K(d) = sum over k of exp(2 pi i k.d) sum over m of sinc^2(k + m) OTF(k + m)`, with frequencies
//! in cycles per pixel.
//!
//! A camera (see [`Camera`]) averages over the square of its own pixel in place of the second one, and
//! its lens multiplies the OTF.
//!
//! If the point spread is nowhere negative, no weight is negative and no weight rings. Without
//! blur, K is one pixel. The weights sum to OTF(0) = 1.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;
use transforms::Real;

use crate::error::Error;
use crate::images::progress::{Pieces, RenderProgress, SILENT};
use crate::images::render::camera::Camera;
use crate::images::spot::{Sheet, Viewpoint};
use edges::numerics::sinc;
use edges::numerics::smooth_odd;

/// Greatest error of the transfer, at any frequency, that cutting off the sum over m may cause.
const TOLERANCE: f64 = 1e-4;

/// Largest width of the sum over m, cycles per pixel: the sum ends there even if its error is
/// larger.
const WIDEST: usize = 32;

/// Largest size of a blur, pixels: a wider one needs half a gigabyte.
pub const LARGEST: usize = 8191;

/// Weights of the blur between pixels, and the brightness at one place.
#[derive(Debug, Clone)]
pub struct Psf {
    /// Columns and rows that the blur reaches on either side.
    pub reach: [usize; 2],
    /// Weights in row-major order, rows from -reach\[1\] to reach\[1\], columns from -reach\[0\] to
    /// reach\[0\].
    ///
    /// They sum to 1, or to 0 if nothing returns.
    pub weights: Vec<f32>,
    /// Luminance of the mid-air image divided by that of the source; `None` without mu.
    pub energy: Option<f64>,
    /// Bound of the error of the transfer that cutting off the sum over m causes.
    pub error: f64,
    /// True if the place lies between the directions of the table.
    pub interpolated: bool,
}

impl Psf {
    /// Computes the weights at one place.
    ///
    /// `pixels_from_mm` converts (tangential, sagittal) mm across the viewing ray to (columns,
    /// rows).
    ///
    /// # Errors
    /// Returns [`Error::Sheet`] if the sheet has no blur at this place, and [`Error::Wide`] if the
    /// blur is wider than [`LARGEST`] pixels.
    pub(crate) fn new(
        sheet: &dyn Sheet,
        place: &Viewpoint,
        pixels_from_mm: [[f64; 2]; 2],
    ) -> Result<Psf, Error> {
        Psf::seen(sheet, place, pixels_from_mm, None, SILENT)
    }

    /// Computes the weights at one place behind a camera, whose lengths are in pixels.
    ///
    /// # Errors
    /// Returns the errors of [`Psf::new`].
    pub(crate) fn seen(
        sheet: &dyn Sheet,
        place: &Viewpoint,
        pixels_from_mm: [[f64; 2]; 2],
        camera: Option<&Camera>,
        progress: RenderProgress<'_>,
    ) -> Result<Psf, Error> {
        let [[a, b], [c, d]] = pixels_from_mm;
        // A pixel of the image averages over its square, or over that of the camera's pixel.
        let width = camera.map_or(1.0, Camera::width);
        let square = |f: f64| camera.map_or_else(|| sinc(PI * f), |own| own.square(f));
        let lens = |x: f64, y: f64| camera.map_or(1.0, |own| own.lens(x, y));
        let beyond = camera.map_or(0.0, Camera::reach);
        let mut half = 1;
        loop {
            // The highest frequency is at the corner of the square |f| <= half / 2 per pixel,
            // including its rim.
            let finest = 0.5 * (half as f64 + 1.0) * (a.abs() + c.abs()).max(b.abs() + d.abs());
            let spot = sheet.spot(place, finest)?;
            let energy = spot.energy();
            if energy == Some(0.0) {
                return Ok(Psf {
                    reach: [0; 2],
                    weights: vec![0.0],
                    energy,
                    error: 0.0,
                    interpolated: spot.interpolated(),
                });
            }
            // One more pixel for the width of the squares, and one for the rounding.
            let reach = [a.hypot(b), c.hypot(d)];
            let reach = reach.map(|by| (spot.reach_mm() * by + beyond) as usize + 2);
            let wide = |size: usize| Error::Wide {
                incidence_deg: place.incidence_deg,
                r_mm: place.r_mm,
                size,
            };
            let widest = reach[0].max(reach[1]).saturating_mul(2).saturating_add(1);
            if widest > LARGEST {
                return Err(wide(widest));
            }
            let size = reach.map(|reach| smooth_odd(2 * reach + 1));
            if size.iter().any(|&size| size > LARGEST) {
                return Err(wide(size[0].max(size[1])));
            }
            let otf = |x: f64, y: f64| spot.otf([a * x + c * y, b * x + d * y]) * lens(x, y);
            let squares = |f: f64| sinc(PI * f) * square(f);
            let error = cut_off(&otf, &squares, size, half) / width;
            if error > TOLERANCE && half < WIDEST {
                half *= 2;
                continue;
            }
            return Ok(Psf {
                reach: size.map(|size| size / 2),
                weights: weights(&otf, &squares, size, half, progress),
                energy,
                error,
                interpolated: spot.interpolated(),
            });
        }
    }
}

/// Returns a bound of the part of the sum over m that lies beyond |f| = half/2 along either axis.
///
/// The bound assumes that the OTF is not larger beyond this rim than on it. For each axis it is the
/// greatest OTF on the rim, times twice the sum of 1/(pi (half/2 + m))^2 over m >= 0, with sinc^2
/// at its greatest. The square of a camera's pixel, of a width in pixels, divides it by this width.
fn cut_off(
    otf: &(impl Fn(f64, f64) -> Complex64 + Sync),
    squares: &(impl Fn(f64) -> f64 + Sync),
    size: [usize; 2],
    half: usize,
) -> f64 {
    let rim = 0.5 * half as f64;
    let tail = 2.0 / (PI * PI) * (1.0 / rim + 0.5 / (rim * rim) + 1.0 / (6.0 * rim.powi(3)));
    let largest = |axis: usize| {
        let count = size[1 - axis].min(128) as i64;
        (-count..=count)
            .map(|i| {
                let along = 0.5 * i as f64 / count as f64;
                let weight = squares(along).abs();
                // Points a little beyond the rim too: on the rim itself the OTF may pass through 0.
                let beside = [0.0, 0.13, 0.29, 0.41].map(|more| {
                    let [x, y] = if axis == 0 {
                        [rim + more, along]
                    } else {
                        [along, rim + more]
                    };
                    otf(x, y).norm()
                });
                weight * beside.into_iter().fold(0.0, f64::max)
            })
            .fold(0.0, f64::max)
    };
    tail * (largest(0) + largest(1))
}

/// Computes the weights on a period of `size` pixels; both sizes must be odd.
fn weights(
    otf: &(impl Fn(f64, f64) -> Complex64 + Sync),
    squares: &(impl Fn(f64) -> f64 + Sync),
    size: [usize; 2],
    half: usize,
    progress: RenderProgress<'_>,
) -> Vec<f32> {
    let [width, height] = size;
    let columns = width / 2 + 1;
    let spread = half as i64 / 2 + 1;
    // Frequencies that look alike on whole pixels, each with the OTF of both squares.
    let alike = |k: usize, size: usize| -> Vec<(f64, f64)> {
        let k = k as f64 / size as f64;
        (-spread..=spread)
            .map(|m| k + m as f64)
            .filter(|f| f.abs() <= 0.5 * half as f64)
            .map(|f| (f, squares(f)))
            .filter(|&(_, weight)| weight.abs() > 1e-12)
            .collect()
    };
    let across: Vec<_> = (0..columns).map(|k| alike(k, width)).collect();
    let pieces = Pieces::new(progress, "rows", height);
    let mut rows: Vec<Vec<Complex64>> = (0..height)
        .into_par_iter()
        .map(|row| {
            let down = alike(row, height);
            let at = |columns: &Vec<(f64, f64)>| {
                let mut sum = Complex64::ZERO;
                for &(y, by_y) in &down {
                    for &(x, by_x) in columns {
                        sum += otf(x, y) * (by_x * by_y);
                    }
                }
                sum
            };
            let own = across.iter().map(at).collect();
            pieces.one();
            own
        })
        .collect();
    // Inverse transform: columns, then rows.
    let inverse = f64::complex_inverse(height);
    for column in 0..columns {
        let mut line: Vec<Complex64> = rows.iter().map(|row| row[column]).collect();
        inverse.process(&mut line);
        for (row, value) in rows.iter_mut().zip(line) {
            row[column] = value;
        }
    }
    let inverse = f64::inverse(width);
    let scale = 1.0 / (width * height) as f64;
    let mut weights = vec![0.0; width * height];
    for (row, mut half) in rows.into_iter().enumerate() {
        // The first value is real, except for rounding.
        half[0].im = 0.0;
        let mut line = vec![0.0; width];
        inverse
            .process(&mut half, &mut line)
            .expect("the lengths are the planner's, and the first value is real");
        let row = (row + height / 2) % height;
        for (column, value) in line.iter().enumerate() {
            let column = (column + width / 2) % width;
            weights[row * width + column] = (value * scale) as f32;
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spot without a blur has the OTF 1 beyond every rim. The bound of what is cut off is then,
    /// for each axis, twice the sum of 1/(pi (rim + m))^2 over m >= 0. Its closed form has the
    /// first terms of Euler and Maclaurin. The next term makes it too large by at most
    /// 1/(30 rim^5), which is 2 % of the sum at a rim of 1.
    #[test]
    fn what_is_cut_off_is_bounded_by_the_sum_beyond_the_rim() {
        for half in [2, 4, 8] {
            let rim = 0.5 * half as f64;
            let terms = (0..1_000_000).map(|m| (PI * (rim + f64::from(m))).powi(-2));
            // Beyond the last term the sum is an integral.
            let sum = terms.sum::<f64>() + 1.0 / (PI * PI * (rim + 1e6 - 0.5));
            let squares = |f: f64| sinc(PI * f).powi(2);
            let found = cut_off(&|_, _| Complex64::ONE, &squares, [5, 5], half);
            let ratio = found / (4.0 * sum);
            assert!((1.0 - 1e-9..1.02).contains(&ratio), "{half}: {ratio}");
        }
    }
}
