//! How alike two pictures look: PSNR, SSIM, FLIP and, with weights that the user brings, LPIPS.
//!
//! All are of what a display shows: linear light, clipped to 0..1, as sRGB values. PSNR and SSIM
//! are worked on in f32; FLIP and LPIPS are defined on 8-bit pictures and get them rounded.

pub(crate) mod error;
pub(crate) mod lpips;

use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::transfer::Transfer;

/// The luminance constants of SSIM for a range of 1 (Wang et al. 2004, Sec. III-B).
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// SSIM's Gaussian window: sigma 1.5, 11 x 11 pixels (Wang et al. 2004, Sec. III-C).
const SIGMA: f64 = 1.5;
const RADIUS: usize = 5;

/// Smallest picture that SSIM has a window for.
pub(crate) const SMALLEST: usize = 2 * RADIUS + 1;

/// Red, green and blue as a display is sent them, 0..1.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    width: usize,
    height: usize,
    planes: [Vec<f32>; 3],
}

impl Shown {
    /// A picture on a display, its light times `exposure`; grey is shown as red, green and blue
    /// alike.
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

    /// Columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Rounded to 8 bits, red, green and blue of a pixel side by side.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        (0..self.width * self.height)
            .flat_map(|i| self.planes.each_ref().map(|p| (p[i] * 255.0).round() as u8))
            .collect()
    }
}

/// Peak signal-to-noise ratio, dB, over all three colours; `None` where the pictures are equal.
/// Both have one size.
pub(crate) fn psnr(a: &Shown, b: &Shown) -> Option<f64> {
    let pairs = a.planes.iter().flatten().zip(b.planes.iter().flatten());
    let squares = pairs.map(|(a, b)| f64::from(a - b).powi(2));
    let count = 3 * a.width * a.height;
    let mean = squares.sum::<f64>() / count as f64;
    (mean > 0.0).then(|| -10.0 * mean.log10())
}

/// Structural similarity (Wang et al. 2004), mean over the colours and over all places whose window
/// lies inside: what scikit-image calls `gaussian_weights=True, sigma=1.5,
/// use_sample_covariance=False`. Both pictures have one size, at least [`SMALLEST`] on both sides.
pub(crate) fn ssim(a: &Shown, b: &Shown) -> f64 {
    let size = a.size();
    let planes = a.planes.iter().zip(&b.planes);
    planes.map(|(a, b)| ssim_of(a, b, size)).sum::<f64>() / 3.0
}

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

/// Weighted means of all windows that lie inside.
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

/// FLIP (Andersson et al. 2020) for a viewer who sees `pixels_per_degree`: the mean over the
/// picture, 0 for equal ones. NVIDIA's own code, on 8 bits. Both have one size.
pub(crate) fn flip(reference: &Shown, test: &Shown, pixels_per_degree: f32) -> f64 {
    let image = |shown: &Shown| {
        let [width, height] = shown.size().map(|n| n as u32);
        nv_flip::FlipImageRgb8::with_data(width, height, &shown.bytes())
    };
    let map = nv_flip::flip(image(reference), image(test), pixels_per_degree).to_vec();
    map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
}
