//! One photograph's model by samples: the loop that Sugawara and Koizumi published (SIGGRAPH Asia
//! 2025 Posters).
//!
//! Every pixel p of the photograph gathers the source's edge at places to which shift and lobe
//! carry its light, I(p) = mean over s of E(d_p - c n.S_s - n.L_s / a - R n.D_s), with d_p the
//! pixel's distance from the edge, S_s a ray shift (foreshortened, edge lengths), L_s an offset by
//! the lobe of a = 1, D_s the deviation that the ray has with its shift, and E the edge as the
//! camera sees it ([`Texture`]). Derivatives are pathwise: dI/d ln c = -c mean E' n.S, dI/d ln a =
//! mean E' n.L / a.
//!
//! n.S and n.L do not depend on a and c, so they are worked out once ([`Tile`]); an evaluation is
//! two products, a look-up and three sums a sample. The numbers stay the same in every iteration,
//! so that what is minimised is smooth.
//!
//! The pixels are taken bin by bin of the profile, each has the next points of one sequence, and
//! after [`EVEN_POINTS`] (or [`INDEPENDENT_POINTS`]) they begin again. So the pixels of a bin, and
//! those of neighbouring bins, make up one net: with 256 Sobol points a pixel the transform of the
//! line spread has 1/50 to 1/25 of the variance that independent points leave. The same net for
//! every bin has 20 times more (its pixels lie differently in every bin), one for all of a
//! photograph no less.

pub(crate) mod texture;

use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::model::Blur;
use crate::model::Camera;
use crate::model::{Curve, Model};
use crate::names::Kernel;
use crate::names::LobeShape;
use crate::photographs::Raster;
use crate::photographs::edge::line::EdgeLine;
use crate::photographs::{BIN_PX, Profile};
use crate::samples::lobe::LobeSampler;
use crate::samples::sampled::texture::{CELLS_PER_PX, Texture};
use crate::samples::sequence::{Points, Sequence};
use crate::samples::shift::{Departure, ShiftSampler};

/// Most points of a photograph that are evenly spread: 2 MB, which a core's second cache holds.
pub(crate) const EVEN_POINTS: usize = 1 << 18;

/// Most independent points, so many that two bins of the same points lie far apart: 16 MB.
pub(crate) const INDEPENDENT_POINTS: usize = 1 << 21;

/// How a photograph is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sampling {
    /// Samples per pixel, >= 1.
    pub samples: usize,
    /// Seed of all of them.
    pub seed: u64,
    /// How they are spread.
    pub sequence: Sequence,
}

/// Where light that left one point of the source meets the image, along the edge normal: `samples`
/// for each of some pixels.
#[derive(Debug)]
pub struct Tile {
    sampling: Sampling,
    /// n.S: shift, foreshortened, edge lengths; 0 under `lobe`.
    shift: Vec<f32>,
    /// n.L: offset by a lobe of a = 1; 0 under `shift`.
    lobe: Vec<f32>,
    /// n.D: tangent of the angle from straight back; none where all light goes straight back.
    deviation: Vec<f32>,
}

impl Tile {
    /// Patterns for `pixels` pixels, or for fewer which are used again: randomisation `stream` of
    /// the sampling. `shift` and the incidence (rad) are not used under `lobe`, `shape` not under
    /// `shift`.
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
        let lobe = shape.map(LobeSampler::new);
        let pair = |index: usize| {
            let [u, v, s, t] = points.at(index as u32);
            let (along, off) = shift.map_or((0.0, 0.0), |(sampler, incidence)| {
                let Departure { shift, deviation } = sampler.at([u, v]);
                let dot = |x: f64, y: f64| normal[0] * x + normal[1] * y;
                let along = dot(incidence.cos() * shift[0], shift[1]);
                (along, dot(deviation[0], deviation[1]))
            });
            let spread = lobe.map_or(0.0, |sampler| {
                let [x, y] = sampler.at([s, t]);
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

    /// Shifts, lobe offsets and deviations, if any, of pattern `index`, which may lie beyond the
    /// last.
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

/// A photograph ready to be rendered: its pixels by bin, its samples, its source.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// Distances of the pixels from the edge, px, bin by bin.
    distances_px: Arc<[f32]>,
    /// Where each bin begins in them; one more than there are bins.
    first: Arc<[usize]>,
    tile: Arc<Tile>,
    texture: Arc<Texture>,
    normal_rad: f64,
}

impl Sampled {
    /// Sorts the pixels of `raster` into the bins of `profile` about `line`; `tile` makes the
    /// samples for so many pixels.
    pub fn new(
        raster: &Raster,
        profile: &Profile,
        line: &EdgeLine,
        camera: &Camera,
        tile: impl FnOnce(usize) -> Tile,
    ) -> Sampled {
        let reach = profile.reach as f64;
        let (sin, cos) = line.normal_rad.sin_cos();
        let mut bins = vec![Vec::new(); profile.len()];
        for [x, y] in raster.positions() {
            let d = x * cos + y * sin - line.offset_px;
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

    /// The same samples of a source that another camera looks at.
    pub fn through(&self, camera: &Camera) -> Sampled {
        Sampled {
            texture: Arc::new(Texture::new(camera, self.normal_rad)),
            ..self.clone()
        }
    }

    /// Samples of one evaluation.
    pub fn samples(&self) -> usize {
        self.distances_px.len() * self.tile.sampling.samples
    }

    /// The render's edge profile on the photograph's bins, with its derivatives. `model` must have
    /// the kernel and the lobe that the samples were drawn for.
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
        Curve {
            bins: part(0, 1.0),
            by_ln_spread: kernel.has_lobe().then(|| part(2, scale[1])),
            by_ln_c: kernel.has_c().then(|| part(1, -scale[0])),
        }
    }

    /// Means over a bin's pixels of E, E' n.S and E' n.L, E' per cell of the texture; 0 in an empty
    /// bin.
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

/// Whether a kernel has samples: waves interfere, and have none; of the baselines none are drawn.
pub(crate) fn has_samples(kernel: Kernel) -> bool {
    matches!(
        kernel,
        Kernel::Eq1 | Kernel::Angular | Kernel::Shift | Kernel::Lobe
    )
}
