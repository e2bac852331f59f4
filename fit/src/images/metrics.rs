//! Measures of how alike two pictures look: PSNR, SSIM, FLIP, and LPIPS with weights from the user.
//!
//! All measures compare what a display shows: linear light, clipped to 0..1 and encoded as sRGB.
//! PSNR and SSIM work on f32 values. FLIP and LPIPS are defined on 8-bit pictures, so the values
//! are rounded to 8 bits for them.

pub(crate) mod error;
pub(crate) mod lpips;

use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::transfer::Transfer;

/// Constant of the luminance term of SSIM for values in 0..1 (Wang et al. 2004, Sec. III-B).
const C1: f64 = 0.01 * 0.01;
/// Constant of the contrast term of SSIM for values in 0..1 (Wang et al. 2004, Sec. III-B).
const C2: f64 = 0.03 * 0.03;

/// Standard deviation of SSIM's Gaussian window, pixels (Wang et al. 2004, Sec. III-C).
const SIGMA: f64 = 1.5;
/// Radius of SSIM's window, pixels: the window has 11 x 11 pixels (Wang et al. 2004, Sec. III-C).
const RADIUS: usize = 5;

/// Smallest side of a picture that SSIM can compare, pixels: one window.
pub(crate) const SMALLEST: usize = 2 * RADIUS + 1;

/// Red, green and blue values that a display is sent for a picture, 0..1.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    width: usize,
    height: usize,
    planes: [Vec<f32>; 3],
}

impl Shown {
    /// Converts a picture to the values that a display is sent.
    ///
    /// The light of the picture is multiplied by `exposure`. Red, green and blue of a grey picture
    /// are equal.
    pub(crate) fn new(picture: &Picture, exposure: f64) -> Shown {
        let exposure = exposure as f32;
        let plane = |index: usize| -> Vec<f32> {
            let plane = picture.planes.get(index).unwrap_or(&picture.planes[0]);
            let light = plane.iter().map(|light| (light * exposure).clamp(0.0, 1.0));
            light.map(|light| Transfer::Srgb.to_stored(light)).collect()
        };
        Shown {
            width: picture.width,
            height: picture.height,
            planes: [0, 1, 2].map(plane),
        }
    }

    /// Returns the numbers of columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Returns the values rounded to 8 bits: red, green and blue of the first pixel, then of the
    /// next.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        (0..self.width * self.height)
            .flat_map(|i| self.planes.each_ref().map(|p| (p[i] * 255.0).round() as u8))
            .collect()
    }
}

/// Returns the peak signal-to-noise ratio over all three colours, dB, or `None` if the pictures are
/// equal.
///
/// Both pictures must have the same size.
pub(crate) fn psnr(a: &Shown, b: &Shown) -> Option<f64> {
    let pairs = a.planes.iter().flatten().zip(b.planes.iter().flatten());
    let squares = pairs.map(|(a, b)| f64::from(a - b).powi(2));
    let count = 3 * a.width * a.height;
    let mean = squares.sum::<f64>() / count as f64;
    (mean > 0.0).then(|| -10.0 * mean.log10())
}

/// Returns the structural similarity (Wang et al. 2004): 1 for equal pictures.
///
/// It is the mean over the colours and over all windows that lie inside the picture. scikit-image
/// computes the same number with `gaussian_weights=True, sigma=1.5, use_sample_covariance=False`.
/// Both pictures must have the same size, at least [`SMALLEST`] pixels on both sides.
pub(crate) fn ssim(a: &Shown, b: &Shown) -> f64 {
    let size = a.size();
    let planes = a.planes.iter().zip(&b.planes);
    planes.map(|(a, b)| ssim_of(a, b, size)).sum::<f64>() / 3.0
}

/// Returns the mean structural similarity of one colour.
fn ssim_of(a: &[f32], b: &[f32], [width, height]: [usize; 2]) -> f64 {
    let mean = |of: fn(f64, f64) -> f64| {
        let values = a.iter().zip(b).map(|(&a, &b)| of(a.into(), b.into()));
        windowed(&values.collect::<Vec<f64>>(), [width, height])
    };
    let (ma, mb) = (mean(|a, _| a), mean(|_, b| b));
    let (aa, bb, ab) = (mean(|a, _| a * a), mean(|_, b| b * b), mean(|a, b| a * b));
    let count = ma.len();
    let index = |i: usize| {
        let (va, vb) = (aa[i] - ma[i] * ma[i], bb[i] - mb[i] * mb[i]);
        let covariance = ab[i] - ma[i] * mb[i];
        (2.0 * ma[i] * mb[i] + C1) * (2.0 * covariance + C2)
            / ((ma[i] * ma[i] + mb[i] * mb[i] + C1) * (va + vb + C2))
    };
    (0..count).map(index).sum::<f64>() / count as f64
}

/// Returns the weighted means of all windows that lie inside the picture, row by row.
fn windowed(values: &[f64], [width, height]: [usize; 2]) -> Vec<f64> {
    let gauss = |i: usize| (-0.5 * ((i as f64 - RADIUS as f64) / SIGMA).powi(2)).exp();
    let mut weights: Vec<f64> = (0..SMALLEST).map(gauss).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    let inner = width - 2 * RADIUS;
    let across: Vec<f64> = values
        .chunks_exact(width)
        .flat_map(|row| {
            let window = |window: &[f64]| window.iter().zip(&weights).map(|(v, w)| v * w).sum();
            row.windows(SMALLEST).map(window).collect::<Vec<f64>>()
        })
        .collect();
    let down = |row: usize| {
        let mut sums = vec![0.0; inner];
        for (i, weight) in weights.iter().enumerate() {
            for (sum, value) in sums.iter_mut().zip(&across[(row + i) * inner..]) {
                *sum += weight * value;
            }
        }
        sums
    };
    (0..height - 2 * RADIUS).flat_map(down).collect()
}

/// Computes FLIP (Andersson et al. 2020), the mean over the picture: 0 for equal pictures.
///
/// The viewer sees `pixels_per_degree` pixels in one degree. NVIDIA's own code computes it from
/// 8-bit values. Both pictures must have the same size.
pub(crate) fn flip(reference: &Shown, test: &Shown, pixels_per_degree: f32) -> f64 {
    let image = |shown: &Shown| {
        let [width, height] = shown.size().map(|n| n as u32);
        nv_flip::FlipImageRgb8::with_data(width, height, &shown.bytes())
    };
    let map = nv_flip::flip(image(reference), image(test), pixels_per_degree).to_vec();
    map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
}
