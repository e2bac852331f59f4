//! Light that goes astray, added to an image: ghost, haze, and the sheet's own front.

use edges::names::Stray;
use edges::photographs::photo::picture::Picture;

use crate::images::render::bilinear;
use crate::images::render::view::fresnel;

/// Place of an image, for the light that goes astray.
pub(crate) struct Around {
    /// Distance R, mm.
    pub r_mm: f64,
    /// Side of a pixel, mm.
    pub pitch_mm: f64,
    /// Matrix that converts (tangential, sagittal) mm to (columns, rows).
    pub axes: [[f64; 2]; 2],
    /// Light that a front at normal incidence sends back besides, relative to the source: the half
    /// mirror's share. `None` where the front sends it elsewhere.
    pub front: Option<f64>,
}

/// Adds the light that goes astray to an image, whose total light stays but for that of the front.
///
/// What lies outside of the picture is black, so haze of light that leaves the picture is lost.
pub(crate) fn add(image: &mut Picture, source: &Picture, stray: &Stray, around: &Around) {
    let size = [image.width, image.height];
    for (plane, own) in image.planes.iter_mut().zip(&source.planes) {
        if let Some(ghost) = stray.ghost {
            let by = around
                .axes
                .map(|[along, across]| ghost.tangential_mm * along + ghost.sagittal_mm * across);
            let share = ghost.share as f32;
            let at = |k: usize| {
                let place = [k % size[0], k / size[0]].map(|n| n as f64);
                let second = bilinear(plane, size, [place[0] - by[0], place[1] - by[1]]);
                (plane[k] + share * second) / (1.0 + share)
            };
            *plane = (0..plane.len()).map(at).collect();
        }
        if let Some(haze) = stray.haze {
            let sigma = haze.spread_mm(around.r_mm) / around.pitch_mm;
            let wide = blurred(plane, size, sigma);
            let share = haze.share as f32;
            for (value, wide) in plane.iter_mut().zip(wide) {
                *value += share * (wide - *value);
            }
        }
        if let (Some(index), Some(half_mirror)) = (stray.front_index, around.front) {
            let share = (half_mirror * fresnel(index, 0.0)) as f32;
            for (value, own) in plane.iter_mut().zip(own) {
                *value += share * own;
            }
        }
    }
}

/// Blurs a plane by a normal distribution, pixels, with black around it.
///
/// Three means of an odd number of pixels, one after the other, have its variance to within half a
/// pixel of width, and its shape to 3 % of the peak: haze is no more normal than that.
fn blurred(plane: &[f32], [width, height]: [usize; 2], sigma: f64) -> Vec<f32> {
    // A mean over n pixels has the variance (n^2 - 1)/12.
    let half = ((0.5 * ((4.0 * sigma * sigma + 1.0).sqrt() - 1.0)).round()) as usize;
    let mut now: Vec<f64> = plane.iter().map(|&own| f64::from(own)).collect();
    // Light that one mean carries out of the picture would come back by the next.
    let mean = |line: &[f64]| -> Vec<f64> {
        let mut line: Vec<f64> = [vec![0.0; 3 * half], line.to_vec(), vec![0.0; 3 * half]].concat();
        for _ in 0..3 {
            let mut sums = vec![0.0];
            sums.extend(line.iter().scan(0.0, |sum, own| {
                *sum += own;
                Some(*sum)
            }));
            let last = line.len();
            let within = |k: usize| sums[(k + half + 1).min(last)] - sums[k.saturating_sub(half)];
            line = (0..last)
                .map(|k| within(k) / (2 * half + 1) as f64)
                .collect();
        }
        line[3 * half..line.len() - 3 * half].to_vec()
    };
    if half == 0 {
        return plane.to_vec();
    }
    now = now.chunks_exact(width).flat_map(mean).collect();
    for column in 0..width {
        let line: Vec<f64> = (0..height).map(|row| now[row * width + column]).collect();
        for (row, value) in mean(&line).into_iter().enumerate() {
            now[row * width + column] = value;
        }
    }
    now.into_iter().map(|own| own as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point of light becomes a spot of the stated variance, and keeps its light. Half a pixel of
    /// the width of each of three means is 3 x (n/6)/2 of the variance: 6 % at 10 pixels.
    #[test]
    fn haze_is_as_wide_as_stated() {
        let size = [201, 151];
        for sigma in [4.0, 10.0, 17.0] {
            let mut plane = vec![0.0; size[0] * size[1]];
            plane[75 * size[0] + 100] = 1.0;
            let wide = blurred(&plane, size, sigma);
            let total: f32 = wide.iter().sum();
            let variance: f64 = wide
                .iter()
                .enumerate()
                .map(|(k, own)| f64::from(*own) * ((k % size[0]) as f64 - 100.0).powi(2))
                .sum();
            assert!((total - 1.0).abs() < 1e-4, "{sigma}: {total}");
            let off = variance.sqrt() / sigma - 1.0;
            assert!(off.abs() < 0.5 / sigma, "{sigma}: {off}");
        }
        println!("3 widths");
    }
}
