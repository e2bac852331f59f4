//! The light source of the published loop: a straight edge as the camera sees it, stored as a
//! texture of the distance from the edge.

use num_complex::Complex64;

use crate::model::Camera;
use crate::model::Grid;
use edges::numerics::sinc;
use edges::photographs::BIN_PX;

/// Number of cells of the texture in a pixel.
pub(crate) const CELLS_PER_PX: f64 = 32.0;

/// Number of cells: 256 pixels on either side of the edge, where the worst lens is within 2e-4 of
/// its plateaus. It is a power of two, so that a mask keeps each index inside.
const CELLS: usize = 1 << 14;

/// Distance of the last cell on either side of the edge, cells.
const LAST: f32 = (CELLS / 2 - 2) as f32;

/// Number 1.5 x 2^23. A number up to 2^21 added to it becomes an integer in the low bits.
const TO_INTEGER: f32 = 12_582_912.0;

/// Number of samples processed together: first all places, then all look-ups, then all sums. So the
/// compiler vectorises the first and the last by four (1.5 times as fast as one by one).
const BLOCK: usize = 64;

/// Edge profile E and its slope per cell, on straight lines between the ends of the cells.
///
/// The values at the ends of the cells are those of a sharpened edge: it is divided by the
/// transform of the straight lines, so that the lines add no blur. What they leave is a ripple of
/// h^2 E'' / 12 with mean 0: 5e-5 for a lens of half a pixel.
#[derive(Debug)]
pub(crate) struct Texture {
    /// Value in the middle of each cell, and slope. Cell k is centred k + 1/2 cells from the edge.
    /// Cells with negative k stand at the end.
    cells: Box<[[f32; 2]; CELLS]>,
}

impl Texture {
    /// Computes the edge that `camera` sees across a normal at `normal_rad` in the photograph.
    pub(crate) fn new(camera: &Camera, normal_rad: f64) -> Texture {
        let finer = CELLS_PER_PX * BIN_PX;
        let pitch_mm = camera.pitch_mm / finer;
        // The grid is twice as long as the texture, so that its periodic images stay outside.
        let grid = Grid::new((2 * CELLS - 2) / 3, pitch_mm);
        let cell_mm = BIN_PX * pitch_mm;
        let camera = camera.along(normal_rad);
        let otf: Vec<Complex64> = grid
            .frequencies_per_mm()
            .map(|f| {
                // One factor undoes the average of the grid over a cell, two undo the straight
                // lines.
                let smoothing = sinc(std::f64::consts::PI * f * cell_mm).powi(3);
                Complex64::from(camera.otf(f) / smoothing)
            })
            .collect();
        let even = grid.even(&otf, 0.0);
        let half = (CELLS / 2) as i64;
        let mut cells = vec![[0.0; 2]; CELLS];
        for k in -half..half {
            let [low, high] = [k, k + 1].map(|at| even.around(at)[0]);
            let slope = if k.abs() < half - 2 { high - low } else { 0.0 };
            let cell = k.rem_euclid(CELLS as i64) as usize;
            cells[cell] = [(0.5 * (low + high)) as f32, slope as f32];
        }
        Texture {
            cells: cells
                .into_boxed_slice()
                .try_into()
                .expect("as many cells as were filled"),
        }
    }

    /// Sums E, E' x and E' y over the samples of a pixel `distance_px` from the edge.
    ///
    /// E is taken at `distance - scale[0] x - scale[1] y - scale[2] z`, with the scales in cells,
    /// and E' per cell. If `offsets` has no z, each z is 0.
    pub(crate) fn sums(&self, distance_px: f32, scale: [f32; 3], offsets: [&[f32]; 3]) -> [f32; 3] {
        match offsets[2] {
            [] => self.sums_of::<false>(distance_px, scale, offsets),
            _ => self.sums_of::<true>(distance_px, scale, offsets),
        }
    }

    fn sums_of<const OFF: bool>(
        &self,
        distance_px: f32,
        scale: [f32; 3],
        [xs, ys, zs]: [&[f32]; 3],
    ) -> [f32; 3] {
        // Cell k is centred at k + 1/2.
        let from = distance_px * CELLS_PER_PX as f32 - 0.5;
        let mut lanes = [[0.0; 4]; 3];
        let (blocks_x, rest_x) = xs.as_chunks::<BLOCK>();
        let (blocks_y, rest_y) = ys.as_chunks::<BLOCK>();
        let (blocks_z, rest_z) = zs.as_chunks::<BLOCK>();
        for (k, (x, y)) in blocks_x.iter().zip(blocks_y).enumerate() {
            let (mut index, mut part) = ([0; BLOCK], [0.0; BLOCK]);
            for i in 0..BLOCK {
                let off = if OFF { scale[2] * blocks_z[k][i] } else { 0.0 };
                (index[i], part[i]) = place(from - scale[0] * x[i] - scale[1] * y[i] - off);
            }
            let (mut value, mut slope) = ([0.0; BLOCK], [0.0; BLOCK]);
            for i in 0..BLOCK {
                [value[i], slope[i]] = self.cells[index[i]];
            }
            for i in 0..BLOCK {
                lanes[0][i % 4] += value[i] + slope[i] * part[i];
                lanes[1][i % 4] += slope[i] * x[i];
                lanes[2][i % 4] += slope[i] * y[i];
            }
        }
        for (k, (x, y)) in rest_x.iter().zip(rest_y).enumerate() {
            let off = if OFF { scale[2] * rest_z[k] } else { 0.0 };
            let (index, part) = place(from - scale[0] * x - scale[1] * y - off);
            let [value, slope] = self.cells[index];
            lanes[0][0] += value + slope * part;
            lanes[1][0] += slope * x;
            lanes[2][0] += slope * y;
        }
        lanes.map(|lanes| lanes.iter().sum())
    }
}

/// Returns the cell of a place, which is given in cells from the middle of cell 0, and the distance
/// of the place from that cell's middle.
#[inline(always)]
fn place(at: f32) -> (usize, f32) {
    let at = if at < LAST { at } else { LAST };
    let at = if at > -LAST { at } else { -LAST };
    let shifted = at + TO_INTEGER;
    let index = shifted.to_bits() as usize & (CELLS - 1);
    (index, at - (shifted - TO_INTEGER))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Lens;

    fn camera() -> Camera {
        Camera {
            pitch_mm: 0.05,
            lenses: vec![Lens::new(0.12, 2.0)],
        }
    }

    /// Compares with the known edge of the pixel's box across a normal at 0 and a Gaussian lens.
    /// With sigma = blur / (sqrt 2 pi) it is a difference of integrals of the normal distribution.
    ///
    /// Tolerance: lines over h = 1/32 of a pixel leave h^2 E'' / 12 at their corners, and half of
    /// that between them. E'', the difference of two normal densities a pixel apart, stays below
    /// 0.64 /px^2 here, which gives 5.2e-5. Values in f32 add 6e-8.
    #[test]
    fn the_edge_of_a_gaussian_lens_is_known() {
        let texture = Texture::new(&camera(), 0.0);
        let sigma = 0.12 / (2.0_f64.sqrt() * std::f64::consts::PI * 0.05);
        // Integral of the normal distribution function.
        let ramp = |x: f64| {
            let z = x / sigma;
            let density = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
            sigma * (z * 0.5 * libm::erfc(-z / 2.0_f64.sqrt()) + density)
        };
        let (mut cases, mut worst) = (0, 0.0_f64);
        for i in -4000..4000 {
            let d = f64::from(i) * 0.01;
            let [value, ..] = texture.sums(d as f32, [0.0; 3], [&[0.0], &[0.0], &[]]);
            let exact = ramp(d + 0.5) - ramp(d - 0.5);
            worst = worst.max((f64::from(value) - exact).abs());
            cases += 1;
        }
        println!("{cases} distances, largest difference {worst:.1e}");
        assert!(worst < 5.3e-5, "{worst}");
        assert_eq!(cases, 8000);
    }

    /// Compares blocks with single samples. Both have the same arithmetic, so their sums differ by
    /// the order alone: 1000 roundings of 6e-8.
    #[test]
    fn blocks_are_samples_one_by_one() {
        let texture = Texture::new(&camera(), 0.1);
        let xs: Vec<f32> = (0..1000).map(|i| (i as f32 * 0.37).sin()).collect();
        let ys: Vec<f32> = (0..1000).map(|i| (i as f32 * 0.11).cos()).collect();
        let zs: Vec<f32> = (0..1000).map(|i| (i as f32 * 0.07).sin()).collect();
        for distance in [-300.0, -40.0, -1.3, 0.0, 0.4, 2.0, 7.0, 300.0] {
            let scale = [90.0, 40.0, 25.0];
            let all = texture.sums(distance, scale, [&xs, &ys, &zs]);
            let mut one_by_one = [0.0_f64; 3];
            for i in 0..1000 {
                let one = texture.sums(distance, scale, [&xs[i..=i], &ys[i..=i], &zs[i..=i]]);
                (0..3).for_each(|k| one_by_one[k] += f64::from(one[k]));
            }
            for (all, one) in all.iter().zip(one_by_one) {
                assert!((f64::from(*all) - one).abs() < 1000.0 * 6e-8 * one.abs().max(1.0));
            }
        }
    }
}
