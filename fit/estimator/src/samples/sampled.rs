//! The model of one photograph by samples: the loop that Sugawara and Koizumi published (SIGGRAPH
//! Asia 2025 Posters).
//!
//! Each pixel p of the photograph gathers the source's edge at the places to which shift and lobe
//! carry its light:
//!
//! ```text
//! I(p) = mean over s of E(d_p - c n.S_s - n.L_s / a - R n.D_s)
//! ```
//!
//! d_p is the pixel's distance from the edge, S_s a ray shift (foreshortened, edge lengths), L_s an
//! offset by the lobe of a = 1, D_s the deviation that the ray has with its shift, and E the edge
//! as the camera sees it ([`Texture`]). Derivatives are pathwise: dI/d ln c = -c mean E' n.S and
//! dI/d ln a = mean E' n.L / a.
//!
//! n.S and n.L do not depend on a and c, so they are computed once ([`Tile`]). An evaluation then
//! costs two products, a look-up and three sums for each sample. The numbers stay the same in every
//! iteration, so the minimised function is smooth.
//!
//! The pixels are taken bin by bin of the profile. Each pixel takes the next points of one
//! sequence. After [`EVEN_POINTS`] (or [`INDEPENDENT_POINTS`]) the points begin again. So the
//! pixels of a bin, and those of neighbouring bins, form one net together. With 256 Sobol points
//! for each pixel the transform of the line spread has 1/50 to 1/25 of the variance of independent
//! points. If every bin had the same net, the variance would be 20 times larger, because the pixels
//! lie differently in each bin. One net for all pixels of a photograph would not reduce it.

pub(crate) mod texture;

use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::model::Blur;
use crate::model::Camera;
use crate::model::Lobe;
use crate::model::{Curve, Model};
use crate::samples::sampled::texture::{CELLS_PER_PX, Texture};
use crate::samples::sequence::{Points, Sequence};
use crate::samples::shift::{Departure, ShiftSampler};
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::photographs::Raster;
use edges::photographs::edge::line::EdgeLine;
use edges::photographs::{BIN_PX, Profile};

/// Largest number of evenly spread points of a photograph: 2 MB, which fits the second cache of a
/// core.
pub(crate) const EVEN_POINTS: usize = 1 << 18;

/// Largest number of independent points: 16 MB. With so many, two bins that share points lie far
/// apart.
pub(crate) const INDEPENDENT_POINTS: usize = 1 << 21;

/// Settings of the samples of a photograph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sampling {
    /// Samples per pixel, >= 1.
    pub samples: usize,
    /// Seed of all samples.
    pub seed: u64,
    /// Spreading of the samples.
    pub sequence: Sequence,
}

/// Places along the edge normal where light from one point of the source meets the image: `samples`
/// places for each of some pixels.
#[derive(Debug)]
pub struct Tile {
    sampling: Sampling,
    /// n.S: shift, foreshortened, edge lengths; 0 for the kernel `lobe`.
    shift: Vec<f32>,
    /// n.L: offset by a lobe of a = 1; 0 for the kernel `shift`.
    lobe: Vec<f32>,
    /// n.D: tangent of the angle off the exact way back; empty if no light deviates.
    deviation: Vec<f32>,
}

impl Tile {
    /// Draws samples for `pixels` pixels, or for fewer pixels whose samples are used again, from
    /// the randomisation `stream` of the sampling.
    ///
    /// The kernel `lobe` does not use `shift` with its incidence (rad). The kernel `shift` does not
    /// use `shape`.
    pub fn new(
        sampling: Sampling,
        stream: u64,
        pixels: usize,
        shift: Option<(&ShiftSampler, f64)>,
        shape: Option<LobeShape>,
        normal: [f64; 2],
    ) -> Tile {
        let most = match sampling.sequence {
            Sequence::Sobol => EVEN_POINTS,
            Sequence::Independent => INDEPENDENT_POINTS,
        };
        let patterns = pixels.min(most / sampling.samples).max(1);
        let points = Points::new(sampling.sequence, sampling.seed, stream);
        let pair = |index: usize| {
            let [u, v, s, t] = points.at(index as u32);
            let (along, off) = shift.map_or((0.0, 0.0), |(sampler, incidence)| {
                let Departure { shift, deviation } = sampler.at([u, v]);
                let dot = |x: f64, y: f64| normal[0] * x + normal[1] * y;
                let along = dot(incidence.cos() * shift[0], shift[1]);
                (along, dot(deviation[0], deviation[1]))
            });
            let spread = shape.map_or(0.0, |lobe| {
                let [x, y] = lobe.offset([s, t]);
                normal[0] * x + normal[1] * y
            });
            ((along as f32, spread as f32), off as f32)
        };
        let deviates = shift.is_some_and(|(sampler, _)| sampler.deviates());
        let ((shift, lobe), deviation): ((Vec<f32>, Vec<f32>), Vec<f32>) = (0..patterns
            * sampling.samples)
            .into_par_iter()
            .map(pair)
            .unzip();
        Tile {
            sampling,
            shift,
            lobe,
            deviation: if deviates { deviation } else { Vec::new() },
        }
    }

    /// Returns the shifts, lobe offsets and deviations (if any) of pattern `index`. An index beyond
    /// the last pattern starts again at the first.
    fn pattern(&self, index: usize) -> [&[f32]; 3] {
        let size = self.sampling.samples;
        let first = index % (self.shift.len() / size) * size;
        let of = |all: &'_ [f32]| -> std::ops::Range<usize> {
            if all.is_empty() {
                0..0
            } else {
                first..first + size
            }
        };
        [&self.shift, &self.lobe, &self.deviation].map(|all| &all[of(all)])
    }
}

/// Photograph that is ready for rendering: its pixels by bin, its samples, its source.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// Distances of the pixels from the edge, px, sorted by bin.
    distances_px: Arc<[f32]>,
    /// Index of the first pixel of each bin, with the number of pixels at the end.
    first: Arc<[usize]>,
    tile: Arc<Tile>,
    texture: Arc<Texture>,
    normal_rad: f64,
}

impl Sampled {
    /// Sorts the pixels of `raster` into the bins of `profile` about `line`. `tile` draws the
    /// samples for a number of pixels.
    pub fn new(
        raster: &Raster,
        profile: &Profile,
        line: &EdgeLine,
        camera: &Camera,
        tile: impl FnOnce(usize) -> Tile,
    ) -> Sampled {
        let reach = profile.reach as f64;
        let ruler = line.ruler();
        let mut bins = vec![Vec::new(); profile.len()];
        for [x, y] in raster.positions() {
            let (d, _) = ruler.place(x, y);
            let bin = (d / BIN_PX).round() + reach;
            if (0.0..=2.0 * reach).contains(&bin) {
                bins[bin as usize].push(d as f32);
            }
        }
        let mut first = vec![0];
        for bin in &bins {
            first.push(first[first.len() - 1] + bin.len());
        }
        let pixels = first[bins.len()];
        Sampled {
            distances_px: bins.concat().into(),
            first: first.into(),
            tile: Arc::new(tile(pixels)),
            texture: Arc::new(Texture::new(camera, line.normal_rad)),
            normal_rad: line.normal_rad,
        }
    }

    /// Returns the photograph with the same samples, seen through another camera.
    pub fn through(&self, camera: &Camera) -> Sampled {
        Sampled {
            texture: Arc::new(Texture::new(camera, self.normal_rad)),
            ..self.clone()
        }
    }

    /// Returns the number of samples in one evaluation.
    pub fn samples(&self) -> usize {
        self.distances_px.len() * self.tile.sampling.samples
    }

    /// Renders the edge profile on the photograph's bins, with its derivatives. `model` must have
    /// the kernel and the lobe for which the samples were drawn.
    pub fn curve(&self, model: &Model, blur: Blur, pitch_mm: f64, profile: &Profile) -> Curve {
        let kernel = model.kernel;
        let cells_per_mm = CELLS_PER_PX / pitch_mm;
        let of_shift = if kernel.has_c() { blur.c_mm } else { 0.0 };
        let of_lobe = if kernel.has_lobe() {
            kernel.distance_scale(model.r_mm) / blur.spread
        } else {
            0.0
        };
        let scale = [of_shift, of_lobe, model.r_mm].map(|scale| scale * cells_per_mm);
        let sums: Vec<[f64; 3]> = (0..profile.len())
            .into_par_iter()
            .with_min_len(16)
            .map(|bin| self.bin(bin, scale.map(|s| s as f32)))
            .collect();
        let part = |index: usize, factor: f64| {
            let mut bins: Vec<f64> = sums.iter().map(|sum| factor * sum[index]).collect();
            profile.bridge(&mut bins);
            bins
        };
        // No samples are drawn for further blurs.
        let by_spread = kernel.has_lobe().then(|| part(2, scale[1]));
        let by_c = kernel.has_c().then(|| part(1, -scale[0]));
        Curve {
            bins: part(0, 1.0),
            derivatives: by_spread.into_iter().chain(by_c).collect(),
        }
    }

    /// Averages E, E' n.S and E' n.L over the pixels of a bin, with E' per cell of the texture.
    /// They are 0 in an empty bin.
    fn bin(&self, bin: usize, scale: [f32; 3]) -> [f64; 3] {
        let pixels = self.first[bin]..self.first[bin + 1];
        let count = pixels.len() * self.tile.sampling.samples;
        let mut total = [0.0; 3];
        for pixel in pixels {
            let offsets = self.tile.pattern(pixel);
            let sums = self.texture.sums(self.distances_px[pixel], scale, offsets);
            for (total, sum) in total.iter_mut().zip(sums) {
                *total += f64::from(sum);
            }
        }
        total.map(|sum| sum / count.max(1) as f64)
    }
}

/// Returns whether samples can be drawn for a kernel. Waves interfere, so `wave` has no samples.
/// For the baselines none are drawn.
pub fn has_samples(kernel: Kernel) -> bool {
    !kernel.has_waves() && !kernel.is_baseline()
}
