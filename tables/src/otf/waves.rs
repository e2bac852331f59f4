//! Sums of a histogram times plane waves, for a block of frequencies at a time.
//!
//! A wave over bins is a product of a wave along u and a wave along v. So a frequency costs one
//! multiplication for each bin and no trigonometry.

use std::f64::consts::TAU;

use ndarray::Array2;
use num_complex::Complex64;

/// Number of frequencies in one pass over the bins.
pub(crate) const LANES: usize = 16;

/// Number of bins in one pass over the frequencies.
pub(crate) const STEP: usize = 4;

/// One number for each frequency of a block.
pub(crate) type Lanes = [f64; LANES];

/// Waves exp(-2 pi i kappa w x) at every bin centre x for a block of frequencies, as cosines and
/// sines.
pub(crate) struct Waves {
    re: Vec<Lanes>,
    im: Vec<Lanes>,
}

impl Waves {
    /// Makes room for the waves at this number of bins.
    pub(crate) fn new(bins: usize) -> Waves {
        Waves {
            re: vec![[0.0; LANES]; bins],
            im: vec![[0.0; LANES]; bins],
        }
    }

    /// Computes the waves by the recurrence exp(i(x + h)) = exp(ix) exp(ih).
    ///
    /// It is restarted every 16 bins, so its error stays below 16 x 2e-16.
    pub(crate) fn fill(&mut self, kappa: &[f64], w: f64, centres: &[f64], width: f64) {
        for (lane, &kappa) in kappa.iter().enumerate() {
            let step = Complex64::cis(-TAU * kappa * w * width);
            let mut wave = Complex64::ONE;
            for (i, x) in centres.iter().enumerate() {
                wave = if i % 16 == 0 {
                    Complex64::cis(-TAU * kappa * w * x)
                } else {
                    wave * step
                };
                (self.re[i][lane], self.im[i][lane]) = (wave.re, wave.im);
            }
        }
    }
}

/// Rows of a histogram without the zeros at their ends; shifts fill a third of the range or less.
pub(crate) struct Rows {
    rows: Vec<HistogramRow>,
}

/// One row of a histogram, without the zeros at its ends.
struct HistogramRow {
    /// Index along v.
    v: usize,
    /// First index along u, a multiple of `STEP`.
    first: usize,
    /// Probabilities, four at a time, with zeros added at the ends.
    plain: Vec<[f64; STEP]>,
    /// Probabilities x u.
    by_u: Vec<[f64; STEP]>,
}

impl Rows {
    /// Takes the rows that have light.
    pub(crate) fn new(probability: &Array2<f64>, centres: &[f64]) -> Rows {
        let mut rows = Vec::new();
        for (v, row) in probability.rows().into_iter().enumerate() {
            let first = row.iter().position(|&p| p != 0.0);
            let last = row.iter().rposition(|&p| p != 0.0);
            if let (Some(first), Some(last)) = (first, last) {
                let first = first / STEP * STEP;
                let padded = |weight: &dyn Fn(usize) -> f64| {
                    let four = |start: usize| {
                        std::array::from_fn(|i| {
                            if start + i <= last {
                                weight(start + i)
                            } else {
                                0.0
                            }
                        })
                    };
                    (first..=last).step_by(STEP).map(four).collect()
                };
                rows.push(HistogramRow {
                    v,
                    first,
                    plain: padded(&|u| row[u]),
                    by_u: padded(&|u| row[u] * centres[u]),
                });
            }
        }
        Rows { rows }
    }

    /// Returns the sums over bins of P x wave, P u x wave and P v x wave, as real and imaginary
    /// parts.
    ///
    /// The last two are needed for the slope.
    pub(crate) fn sums<const SLOPE: bool>(
        &self,
        along_u: &Waves,
        along_v: &Waves,
        centres: &[f64],
    ) -> [(Lanes, Lanes); 3] {
        let mut sums = [([0.0; LANES], [0.0; LANES]); 3];
        for row in &self.rows {
            let (cos, sin) = (&along_v.re[row.v], &along_v.im[row.v]);
            let product = |re: &Lanes, im: &Lanes, lane: usize| {
                (
                    re[lane] * cos[lane] - im[lane] * sin[lane],
                    re[lane] * sin[lane] + im[lane] * cos[lane],
                )
            };
            let [plain, by_u, by_v] = &mut sums;
            let (re, im) = (
                transform(&row.plain, &along_u.re[row.first..]),
                transform(&row.plain, &along_u.im[row.first..]),
            );
            for lane in 0..LANES {
                let (a, b) = product(&re, &im, lane);
                plain.0[lane] += a;
                plain.1[lane] += b;
                by_v.0[lane] += centres[row.v] * a;
                by_v.1[lane] += centres[row.v] * b;
            }
            if SLOPE {
                let (re, im) = (
                    transform(&row.by_u, &along_u.re[row.first..]),
                    transform(&row.by_u, &along_u.im[row.first..]),
                );
                for lane in 0..LANES {
                    let (a, b) = product(&re, &im, lane);
                    by_u.0[lane] += a;
                    by_u.1[lane] += b;
                }
            }
        }
        sums
    }
}

/// Returns the sum of weight x wave, lane by lane.
///
/// It takes four weights a pass, which the compiler turns into vector code. One weight a pass, with
/// the sums in registers, stays scalar and is 2 times slower.
fn transform(weights: &[[f64; STEP]], waves: &[Lanes]) -> Lanes {
    let mut sum = [0.0; LANES];
    for ([a, b, c, d], [wa, wb, wc, wd]) in weights.iter().zip(waves.as_chunks::<STEP>().0) {
        for lane in 0..LANES {
            sum[lane] += (a * wa[lane] + b * wb[lane]) + (c * wc[lane] + d * wd[lane]);
        }
    }
    sum
}
