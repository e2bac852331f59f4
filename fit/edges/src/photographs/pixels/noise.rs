//! Estimate of a camera's pixel noise from the scatter of the pixels.

use crate::numerics::clip::Cut;

/// Noise of a pixel: its variance is read + gain x light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelNoise {
    /// Variance without light.
    pub read: f64,
    /// Increase of the variance per light.
    pub gain: f64,
}

impl PixelNoise {
    /// Returns the variance at a level of light.
    pub fn variance(&self, light: f64) -> f64 {
        self.read + self.gain * light.max(0.0)
    }

    /// Estimates the noise for which the scatter of the bins is most likely. An item of `scatter`
    /// is (degrees of freedom, light, variance) of one bin.
    ///
    /// The method is Fisher scoring on the sum of freedom x (ln v + scatter / v), with v = read +
    /// gain x light; `read` is at least `floor` and `gain` at least 0. With limits in `cut`, the
    /// noise is taken as cut off there.
    pub fn most_likely(scatter: &[[f64; 3]], cut: Cut, floor: f64) -> PixelNoise {
        const ROUNDS: usize = 25;
        let freedom: f64 = scatter.iter().map(|s| s[0]).sum();
        let average = scatter.iter().map(|s| s[0] * s[2]).sum::<f64>() / freedom.max(1.0);
        let mut noise = PixelNoise {
            read: average.max(floor),
            gain: 0.0,
        };
        for _ in 0..ROUNDS {
            let (mut w, mut x, mut xx, mut v, mut vx) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for &[freedom, light, variance] in scatter {
                let now = noise.variance(light).max(floor);
                let weight = freedom / (now * now);
                // The variance that clipping removed is put back, by the ratio that the present
                // noise gives.
                let whole = if cut.is_any() {
                    variance * now / cut.clipped(light, now.sqrt()).2.max(1e-3 * now)
                } else {
                    variance
                };
                let light = light.max(0.0);
                w += weight;
                x += weight * light;
                xx += weight * light * light;
                v += weight * whole;
                vx += weight * light * whole;
            }
            let determinant = w * xx - x * x;
            let gain = if determinant > 1e-12 * w * xx {
                (w * vx - x * v) / determinant
            } else {
                0.0
            };
            let read = (v - gain * x) / w;
            noise = if gain < 0.0 {
                PixelNoise {
                    read: v / w,
                    gain: 0.0,
                }
            } else if read < 0.0 {
                PixelNoise {
                    read: 0.0,
                    gain: vx / xx,
                }
            } else {
                PixelNoise { read, gain }
            };
            noise.read = noise.read.max(floor);
        }
        noise
    }
}
