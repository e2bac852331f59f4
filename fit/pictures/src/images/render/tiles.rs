//! Rendering of a picture whose blur changes from pixel to pixel, by tiles.
//!
//! A pixel of the image gathers the source with its own weights E K (energy times blur). The
//! weights are computed at the corners of a grid of tiles. In a tile, the image is the bilinear
//! mixture of the four images that are blurred by the weights of its corners, so the shares of all
//! corners sum to 1 everywhere.
//!
//! Tiles are halved until the mixture is close to the exact weights in the middle of every tile,
//! where it is farthest from the corners. The difference is the sum of all absolute differences of
//! the weights. The difference times the brightest source pixel is a bound of the error there.

use rayon::prelude::*;

use crate::error::Error;
use crate::images::progress::{Pieces, RenderProgress};
use crate::images::render::psf::Psf;
use crate::images::render::transform::Convolver;

/// Greatest count of tiles along an axis.
const MOST: usize = 64;

/// Grid of tiles with the weights of the blur at their corners.
pub struct Tiles {
    /// Corners along both axes, in pixels from the middle of the first pixel of the picture.
    ///
    /// The first corner is at -0.5, the left or upper side of the picture. The last is at the other
    /// side.
    places: [Vec<f64>; 2],
    /// Weights at the corners in row-major order, multiplied by the energy.
    corners: Vec<Psf>,
    /// Greatest difference in the middle of a tile, divided by the greatest energy.
    pub error: f64,
}

impl Tiles {
    /// Computes the weights at the corners of as many tiles as the tolerance needs, at most
    /// [`MOST`] along an axis.
    ///
    /// `size` is the picture in columns and rows. `at` returns the weights at a place, in columns
    /// and rows from the middle of the first pixel. `tolerance` is relative to the greatest energy.
    ///
    /// # Errors
    /// Returns the first error of `at`.
    pub(crate) fn new(
        size: [usize; 2],
        tolerance: f64,
        progress: RenderProgress<'_>,
        at: impl Fn([f64; 2]) -> Result<Psf, Error> + Sync,
    ) -> Result<Tiles, Error> {
        let mut counts = [1, 1];
        loop {
            let places = [0, 1].map(|axis| {
                let step = size[axis] as f64 / counts[axis] as f64;
                let place = |i: usize| i as f64 * step - 0.5;
                (0..=counts[axis]).map(place).collect::<Vec<f64>>()
            });
            let [columns, rows] = counts;
            let count = (columns + 1) * (rows + 1);
            let blurs = Pieces::new(
                progress,
                "blurs of corners and middles",
                count + columns * rows,
            );
            let scaled = |place: [f64; 2]| -> Result<Psf, Error> {
                let mut psf = at(place)?;
                blurs.one();
                let energy = psf.energy.unwrap_or(1.0) as f32;
                psf.weights.iter_mut().for_each(|weight| *weight *= energy);
                Ok(psf)
            };
            let corner =
                |i: usize| scaled([places[0][i % (columns + 1)], places[1][i / (columns + 1)]]);
            let corners: Vec<Psf> = (0..count)
                .into_par_iter()
                .map(corner)
                .collect::<Result<_, Error>>()?;
            let mut tiles = Tiles {
                places,
                corners,
                error: 0.0,
            };
            let greatest = |most: f64, psf: &Psf| most.max(psf.energy.unwrap_or(1.0));
            let energy = tiles.corners.iter().fold(0.0, greatest);
            let middle = |i: usize| -> Result<f64, Error> {
                let tile = [i % columns, i / columns];
                let middle = [0, 1].map(|axis| {
                    0.5 * (tiles.places[axis][tile[axis]] + tiles.places[axis][tile[axis] + 1])
                });
                Ok(difference(&scaled(middle)?, tiles.around(tile)))
            };
            let middles = (0..columns * rows).into_par_iter().map(middle);
            let worst = middles.collect::<Result<Vec<f64>, Error>>()?;
            let worst = worst.into_iter().fold(0.0, f64::max);
            tiles.error = if energy > 0.0 { worst / energy } else { worst };
            if tiles.error <= tolerance || counts.iter().all(|&count| count >= MOST) {
                return Ok(tiles);
            }
            // Tiles remain about square.
            let wide = size[0] * rows > size[1] * columns * 3 / 2;
            let high = size[1] * columns > size[0] * rows * 3 / 2;
            counts = [
                if high { columns } else { 2 * columns },
                if wide { rows } else { 2 * rows },
            ]
            .map(|count| count.min(MOST));
        }
    }

    /// Returns the counts of tiles along both axes.
    pub fn counts(&self) -> [usize; 2] {
        self.places.each_ref().map(|places| places.len() - 1)
    }

    /// Returns columns and rows of all corners, from the middle of the first pixel of the picture.
    pub fn corner_places(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let [columns, rows] = &self.places;
        rows.iter()
            .flat_map(|&y| columns.iter().map(move |&x| [x, y]))
    }

    /// Returns the weights at all corners, row by row.
    pub fn corners(&self) -> &[Psf] {
        &self.corners
    }

    /// Returns the weights at the four corners of a tile.
    fn around(&self, [column, row]: [usize; 2]) -> [&Psf; 4] {
        let columns = self.places[0].len();
        let first = row * columns + column;
        [first, first + 1, first + columns, first + columns + 1].map(|i| &self.corners[i])
    }

    /// Renders the image of colour planes that all have `width` columns and `height` rows.
    pub(crate) fn render(
        &self,
        planes: &[Vec<f32>],
        [width, height]: [usize; 2],
        progress: RenderProgress<'_>,
    ) -> Vec<Vec<f32>> {
        let mut images = vec![vec![0.0; width * height]; planes.len()];
        let [columns, rows] = self.counts();
        let pieces = Pieces::new(progress, "tiles", columns * rows);
        // Each tile is made independently. The tiles are then copied into the image in order.
        for row in 0..rows {
            let tiles = (0..columns).into_par_iter();
            let made: Vec<_> = tiles
                .map(|column| {
                    let made = self.tile(planes, [width, height], [column, row]);
                    pieces.one();
                    made
                })
                .collect();
            for (from, size, parts) in made {
                for (image, part) in images.iter_mut().zip(parts) {
                    for (y, line) in part.chunks_exact(size[0]).enumerate() {
                        image[(from[1] + y) * width + from[0]..][..size[0]].copy_from_slice(line);
                    }
                }
            }
        }
        images
    }

    /// Renders one tile. Returns its first pixel, its size and its planes.
    fn tile(
        &self,
        planes: &[Vec<f32>],
        picture: [usize; 2],
        tile: [usize; 2],
    ) -> ([usize; 2], [usize; 2], Vec<Vec<f32>>) {
        // A pixel belongs to the tile that contains its middle.
        let pixel = |axis: usize, i: usize| {
            (self.places[axis][i].ceil().max(0.0) as usize).min(picture[axis])
        };
        let from = [0, 1].map(|axis| pixel(axis, tile[axis]));
        let size = [0, 1].map(|axis| pixel(axis, tile[axis] + 1) - from[axis]);
        if size.contains(&0) {
            return (from, [1, 0], vec![Vec::new(); planes.len()]);
        }
        let corners = self.around(tile);
        let reach = [0, 1].map(|axis| corners.iter().map(|psf| psf.reach[axis]).max().unwrap_or(0));
        let margin = [0, 1].map(|axis| reach[axis].min(picture[axis]));
        let crop = [0, 1].map(|axis| size[axis] + 2 * margin[axis]);
        // The crop has its own margin. Light that wraps around may spoil this margin only.
        let convolver = Convolver::new(crop, [0, 1].map(|axis| reach[axis] - margin[axis]));
        let weights = corners.map(|psf| convolver.weights(psf));
        let part = |axis: usize, i: usize| {
            let places = &self.places[axis];
            let (low, high) = (places[tile[axis]], places[tile[axis] + 1]);
            ((from[axis] + i) as f64 - low) / (high - low)
        };
        let made = planes.iter().map(|plane| {
            let spectrum = convolver.spectrum(&cut(plane, picture, from, margin, crop));
            let mut sum = vec![0.0_f32; size[0] * size[1]];
            for (corner, weights) in weights.iter().enumerate() {
                let blurred = convolver.blurred(spectrum.times(weights));
                for (y, line) in sum.chunks_exact_mut(size[0]).enumerate() {
                    let blurred = &blurred[(y + margin[1]) * crop[0] + margin[0]..];
                    let down = part(1, y);
                    let down = if corner < 2 { 1.0 - down } else { down };
                    for (x, (sum, value)) in line.iter_mut().zip(blurred).enumerate() {
                        let across = part(0, x);
                        let across = if corner % 2 == 0 {
                            1.0 - across
                        } else {
                            across
                        };
                        *sum += (across * down) as f32 * value;
                    }
                }
            }
            sum
        });
        (from, size, made.collect())
    }
}

/// Cuts a part with a margin from a plane; beyond the picture the part is black.
fn cut(
    plane: &[f32],
    [width, height]: [usize; 2],
    from: [usize; 2],
    margin: [usize; 2],
    crop: [usize; 2],
) -> Vec<f32> {
    let mut part = vec![0.0; crop[0] * crop[1]];
    let left = margin[0].saturating_sub(from[0]);
    let first = (from[0] + left) - margin[0];
    for (y, line) in part.chunks_exact_mut(crop[0]).enumerate() {
        let Some(row) = (from[1] + y)
            .checked_sub(margin[1])
            .filter(|&row| row < height)
        else {
            continue;
        };
        let count = (crop[0] - left).min(width - first);
        line[left..][..count].copy_from_slice(&plane[row * width + first..][..count]);
    }
    part
}

/// Returns the sum of the absolute differences between weights and the mean of four others.
fn difference(own: &Psf, others: [&Psf; 4]) -> f64 {
    let all = [own, others[0], others[1], others[2], others[3]];
    let reach = [0, 1].map(|axis| all.iter().map(|psf| psf.reach[axis]).max().unwrap_or(0));
    let columns = 2 * reach[0] + 1;
    let mut sums = vec![0.0_f64; columns * (2 * reach[1] + 1)];
    for (psf, share) in all.iter().zip([1.0, -0.25, -0.25, -0.25, -0.25]) {
        let own = 2 * psf.reach[0] + 1;
        let offset = (reach[1] - psf.reach[1]) * columns + reach[0] - psf.reach[0];
        for (y, line) in psf.weights.chunks_exact(own).enumerate() {
            for (sum, weight) in sums[offset + y * columns..].iter_mut().zip(line) {
                *sum += share * f64::from(*weight);
            }
        }
    }
    sums.iter().map(|sum| sum.abs()).sum()
}
