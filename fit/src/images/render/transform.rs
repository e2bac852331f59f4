//! Convolution of a large picture by real Fourier transforms: rows, then columns with the product,
//! then rows again.
//!
//! In f32: rounding leaves about 1e-7 of the picture's root mean square. Rows and blocks of columns
//! are worked on in parallel, each by itself, so that the bytes do not depend on the number of
//! threads.

use std::sync::Arc;

use num_complex::Complex32;
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

use crate::images::render::psf::Psf;
use crate::numerics::{smooth, smooth_even};

/// Columns that are transformed together: a cache line of the rows that they are gathered from.
const BLOCK: usize = 16;

/// The transforms for pictures of one size and blurs up to one reach.
pub(crate) struct Convolver {
    /// Columns and rows of the picture.
    picture: [usize; 2],
    /// Columns and rows of a period, wide enough that nothing that is seen comes round.
    period: [usize; 2],
    forward: Arc<dyn RealToComplex<f32>>,
    backward: Arc<dyn ComplexToReal<f32>>,
    down: Arc<dyn Fft<f32>>,
    up: Arc<dyn Fft<f32>>,
}

/// The spectrum of a picture or of weights: blocks of columns, each column whole.
pub(crate) struct Spectrum {
    blocks: Vec<Vec<Complex32>>,
}

impl Convolver {
    /// For pictures of `size` (columns, rows) and weights of `reach`.
    pub(crate) fn new(size: [usize; 2], reach: [usize; 2]) -> Convolver {
        // What is sent past one end comes round to the other, where only `reach` is needed dark.
        let period = [smooth_even(size[0] + reach[0]), smooth(size[1] + reach[1])];
        let mut real = RealFftPlanner::new();
        let mut complex = FftPlanner::new();
        Convolver {
            picture: size,
            period,
            forward: real.plan_fft_forward(period[0]),
            backward: real.plan_fft_inverse(period[0]),
            down: complex.plan_fft_forward(period[1]),
            up: complex.plan_fft_inverse(period[1]),
        }
    }

    /// The transform of weights, scaled so that a spectrum times it is ready for
    /// [`Convolver::blur`].
    pub(crate) fn weights(&self, psf: &Psf) -> Spectrum {
        let [width, height] = self.period;
        let [reach_x, reach_y] = psf.reach;
        let scale = 1.0 / (width * height) as f32;
        let columns = 2 * reach_x + 1;
        // Weights are laid around the first pixel; a kernel wider than the period adds up where it
        // comes round.
        let rows = (0..psf.weights.len() / columns).into_par_iter().map(|i| {
            let mut line = vec![0.0; width];
            for (j, weight) in psf.weights[i * columns..][..columns].iter().enumerate() {
                line[(j + width * columns - reach_x) % width] += weight * scale;
            }
            ((i + height * columns - reach_y) % height, self.row(line))
        });
        let mut lines: Vec<Option<Vec<Complex32>>> = vec![None; height];
        for (row, line) in rows.collect::<Vec<_>>() {
            match &mut lines[row] {
                Some(sum) => sum
                    .iter_mut()
                    .zip(line)
                    .for_each(|(sum, part)| *sum += part),
                empty => *empty = Some(line),
            }
        }
        self.columns(&lines)
    }

    /// The picture's plane blurred, `picture` in size: black outside.
    pub(crate) fn blur(&self, plane: &[f32], weights: &Spectrum) -> Vec<f32> {
        self.blurred(self.spectrum(plane).times(weights))
    }

    /// The transform of a plane.
    pub(crate) fn spectrum(&self, plane: &[f32]) -> Spectrum {
        let lines: Vec<Option<Vec<Complex32>>> = plane
            .par_chunks_exact(self.picture[0])
            .map(|row| {
                let mut line = row.to_vec();
                line.resize(self.period[0], 0.0);
                Some(self.row(line))
            })
            .collect();
        self.columns(&lines)
    }

    /// The plane of a spectrum.
    pub(crate) fn blurred(&self, mut spectrum: Spectrum) -> Vec<f32> {
        let [width, pixels_down] = self.picture;
        let height = self.period[1];
        let blocks = spectrum.blocks.par_iter_mut();
        blocks.for_each(|block| self.up.process(block));
        let mut blurred = vec![0.0; width * pixels_down];
        let rows = blurred.par_chunks_exact_mut(width).enumerate();
        rows.for_each_init(
            || (vec![0.0; self.period[0]], self.backward.make_scratch_vec()),
            |(line, scratch), (row, out)| {
                let columns = spectrum.blocks.iter();
                let columns = columns.flat_map(|block| block.chunks_exact(height));
                let mut half: Vec<Complex32> = columns.map(|column| column[row]).collect();
                // Real but for rounding, as are the sums that they stand for.
                let last = half.len() - 1;
                half[0].im = 0.0;
                half[last].im = 0.0;
                self.backward
                    .process_with_scratch(&mut half, line, scratch)
                    .expect("the lengths are the planner's, and both ends are real");
                out.copy_from_slice(&line[..width]);
            },
        );
        blurred
    }

    fn row(&self, mut line: Vec<f32>) -> Vec<Complex32> {
        let mut half = self.forward.make_output_vec();
        self.forward
            .process(&mut line, &mut half)
            .expect("the lengths are the planner's");
        half
    }

    /// Transforms columns; rows that are missing are black.
    fn columns(&self, lines: &[Option<Vec<Complex32>>]) -> Spectrum {
        let height = self.period[1];
        let count = self.period[0] / 2 + 1;
        let block = |first: usize| {
            let columns = BLOCK.min(count - first);
            let mut block = vec![Complex32::ZERO; columns * height];
            for (row, line) in lines.iter().enumerate() {
                if let Some(line) = line {
                    for (column, value) in line[first..first + columns].iter().enumerate() {
                        block[column * height + row] = *value;
                    }
                }
            }
            self.down.process(&mut block);
            block
        };
        let firsts: Vec<usize> = (0..count).step_by(BLOCK).collect();
        Spectrum {
            blocks: firsts.into_par_iter().map(block).collect(),
        }
    }
}

impl Spectrum {
    /// The product of two of one size.
    pub(crate) fn times(&self, other: &Spectrum) -> Spectrum {
        let blocks = self.blocks.par_iter().zip(&other.blocks);
        let product = |(block, other): (&Vec<Complex32>, &Vec<Complex32>)| {
            block.iter().zip(other).map(|(a, b)| a * b).collect()
        };
        Spectrum {
            blocks: blocks.map(product).collect(),
        }
    }
}
