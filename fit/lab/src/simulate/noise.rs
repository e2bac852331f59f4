//! Noise as a function of (seed, photograph, pixel). The order of work and the number of threads
//! have no effect on it.

use std::f64::consts::TAU;

/// The random numbers of one pixel of one photograph.
#[derive(Debug, Clone)]
pub(crate) struct PixelNoise {
    key: u64,
    counter: u64,
}

/// Mixes 64 bits by the finaliser of SplitMix64 (Steele, Lea, Flood 2014). It is a bijection; every
/// output bit depends on all input bits.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Increment of SplitMix64: 2^64 over the golden ratio, odd.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

impl PixelNoise {
    /// Creates the random numbers of `pixel` in `photograph` under `seed`.
    pub(crate) fn new(seed: u64, photograph: u64, pixel: u64) -> PixelNoise {
        let seeded = mix(seed.wrapping_add(GOLDEN));
        let photographed = mix(seeded ^ photograph.wrapping_add(1).wrapping_mul(GOLDEN));
        PixelNoise {
            key: mix(photographed ^ pixel.wrapping_add(1).wrapping_mul(GOLDEN)),
            counter: 0,
        }
    }

    /// Returns a uniform number in (0, 1). It never returns 0 or 1.
    pub(crate) fn uniform(&mut self) -> f64 {
        self.counter += 1;
        let bits = mix(self.key.wrapping_add(self.counter.wrapping_mul(GOLDEN)));
        ((bits >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    /// Returns a normal number of mean 0 and variance 1 (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }

    /// Returns a Poisson number of mean `mean` >= 0. Means below 30 use products of uniform
    /// numbers, others use Hormann's transformed rejection (PTRS, 1993). Both are exact.
    pub(crate) fn poisson(&mut self, mean: f64) -> f64 {
        if mean < 30.0 {
            let limit = (-mean).exp();
            let (mut count, mut product) = (0.0, self.uniform());
            while product > limit {
                product *= self.uniform();
                count += 1.0;
            }
            return count;
        }
        let b = 0.931 + 2.53 * mean.sqrt();
        let a = -0.059 + 0.024_83 * b;
        let inverse_alpha = 1.1239 + 1.1328 / (b - 3.4);
        let v_r = 0.9277 - 3.6224 / (b - 2.0);
        loop {
            let u = self.uniform() - 0.5;
            let v = self.uniform();
            let us = 0.5 - u.abs();
            let k = ((2.0 * a / us + b) * u + mean + 0.43).floor();
            if us >= 0.07 && v <= v_r {
                return k;
            }
            if k < 0.0 || (us < 0.013 && v > us) {
                continue;
            }
            let accept = (v * inverse_alpha / (a / (us * us) + b)).ln();
            if accept <= k * mean.ln() - mean - ln_factorial(k) {
                return k;
            }
        }
    }
}

/// Returns ln k! for whole k >= 0: exact products below 16, Stirling's series from there on (error
/// below 1e-13).
fn ln_factorial(k: f64) -> f64 {
    if k < 16.0 {
        return (2..=k as u32).map(|n| f64::from(n).ln()).sum();
    }
    let inverse = 1.0 / k;
    let square = inverse * inverse;
    let series =
        inverse * (1.0 / 12.0 - square * (1.0 / 360.0 - square * (1.0 / 1260.0 - square / 1680.0)));
    (k + 0.5) * k.ln() - k + 0.5 * TAU.ln() + series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_meet_the_distributions() {
        // The mean of n draws scatters by sigma/sqrt(n), the variance by about sigma^2 sqrt((2 +
        // kurtosis excess)/n). A limit of 5 of these leaves a chance of 1e-6 per check.
        let n = 200_000_u32;
        for mean in [0.3, 7.0, 29.9, 30.1, 400.0, 36_000.0] {
            let draws: Vec<f64> = (0..n)
                .map(|pixel| PixelNoise::new(7, 3, pixel.into()).poisson(mean))
                .collect();
            let count = f64::from(n);
            let found = draws.iter().sum::<f64>() / count;
            let variance = draws.iter().map(|k| (k - found).powi(2)).sum::<f64>() / count;
            assert!(
                (found - mean).abs() < 5.0 * (mean / count).sqrt(),
                "{mean}: mean {found}"
            );
            let scatter = mean * ((2.0 + 1.0 / mean) / count).sqrt();
            assert!(
                (variance - mean).abs() < 5.0 * scatter,
                "{mean}: variance {variance}"
            );
        }
        let draws: Vec<f64> = (0..n)
            .map(|pixel| PixelNoise::new(7, 4, pixel.into()).normal())
            .collect();
        let variance = draws.iter().map(|x| x * x).sum::<f64>() / f64::from(n);
        assert!(
            (variance - 1.0).abs() < 5.0 * (2.0 / f64::from(n)).sqrt(),
            "normal: variance {variance}"
        );
    }

    #[test]
    fn factorials() {
        assert!((ln_factorial(16.0) - 20_922_789_888_000_f64.ln()).abs() < 1e-12);
        assert!((ln_factorial(15.0) - 1_307_674_368_000_f64.ln()).abs() < 1e-12);
    }
}
