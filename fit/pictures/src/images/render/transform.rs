//! Convolution of a large picture by real Fourier transforms.
//!
//! Rows are transformed first, then columns with the product, then rows again. All values are f32:
//! rounding errors are about 1e-7 of the root mean square of the picture. Rows and blocks of
//! columns are processed in parallel, each independently, so the result is the same for any number
//! of threads.

use std::sync::Arc;

use num_complex::Complex32;
use rayon::prelude::*;
use transforms::{ComplexToReal, Fft, Real, RealToComplex};

use crate::images::render::psf::Psf;
use edges::numerics::{smooth, smooth_even};

/// Count of columns that are transformed together: one cache line of each row.
const BLOCK: usize = 16;

/// Fourier transforms for pictures of one size and blurs up to one reach.
pub(crate) struct Convolver {
    /// Columns and rows of the picture.
    picture: [usize; 2],
    /// Columns and rows of the period of the transforms.
    ///
    /// The period is so wide that no light that wraps around is seen in the picture.
    period: [usize; 2],
    forward: Arc<dyn RealToComplex<f32>>,
    backward: Arc<dyn ComplexToReal<f32>>,
    down: Arc<dyn Fft<f32>>,
    up: Arc<dyn Fft<f32>>,
}

/// Spectrum of a picture or of weights, in blocks of whole columns.
pub(crate) struct Spectrum {
    blocks: Vec<Vec<Complex32>>,
}

impl Convolver {
    /// Prepares the transforms for pictures of `size` (columns, rows) and weights of `reach`.
    pub(crate) fn new(size: [usize; 2], reach: [usize; 2]) -> Convolver {
        // Light that leaves at one end wraps around to the other end, so `reach` dark pixels are
        // enough.
        let period = [smooth_even(size[0] + reach[0]), smooth(size[1] + reach[1])];
        Convolver {
            picture: size,
            period,
            forward: f32::forward(period[0]),
            backward: f32::inverse(period[0]),
            down: f32::complex_forward(period[1]),
            up: f32::complex_inverse(period[1]),
        }
    }

    /// Transforms the weights of a blur for [`Convolver::blur`].
    ///
    /// The spectrum is scaled, so that no later step has to normalise.
    pub(crate) fn weights(&self, psf: &Psf) -> Spectrum {
        let [width, height] = self.period;
        let [reach_x, reach_y] = psf.reach;
        let scale = 1.0 / (width * height) as f32;
        let columns = 2 * reach_x + 1;
        // The weights lie around the first pixel. Weights wider than the period wrap around and
        // add up.
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

    /// Blurs a plane of the picture; the area outside the picture is black.
    pub(crate) fn blur(&self, plane: &[f32], weights: &Spectrum) -> Vec<f32> {
        self.blurred(self.spectrum(plane).times(weights))
    }

    /// Transforms a plane to its spectrum.
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

    /// Transforms a spectrum back to a plane of the size of the picture.
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
                // Both ends are real, except for rounding.
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

    /// Transforms one row.
    fn row(&self, mut line: Vec<f32>) -> Vec<Complex32> {
        let mut half = self.forward.make_output_vec();
        self.forward
            .process(&mut line, &mut half)
            .expect("the lengths are the planner's");
        half
    }

    /// Transforms all columns; rows that are `None` are black.
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
    /// Multiplies two spectra of the same size.
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
