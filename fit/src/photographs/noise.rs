//! The noise of a camera's pixels, from their scatter.

use crate::numerics::clip;

/// Variance of a pixel's noise: read^2 + gain x light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelNoise {
    /// Variance without light.
    pub read: f64,
    /// Variance per light.
    pub gain: f64,
}

impl PixelNoise {
    /// Variance at a level of light.
    pub fn variance(&self, light: f64) -> f64 {
        self.read + self.gain * light.max(0.0)
    }

    /// The noise for which the scatter of the bins (degrees of freedom, light, variance) is most
    /// likely: scoring on sum of freedom x (ln v + scatter / v), v = read + gain x light, both at
    /// least 0.
    pub fn most_likely(scatter: &[[f64; 3]], cut_off: bool, floor: f64) -> PixelNoise {
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
                // What was cut off is put back in the proportion that the noise so far says.
                let whole = if cut_off {
                    variance * now / clip::clipped(light, now.sqrt()).2.max(1e-3 * now)
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
