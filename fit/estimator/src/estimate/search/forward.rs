//! The estimate by samples: the published loop instead of the closed form.
//!
//! As published, an edge is rendered for each photograph with a number of samples per pixel. Its
//! MTF is measured as that of the photograph was. The squared differences of the MTFs are minimised
//! over a and c by their pathwise derivatives. mu then follows from the ratio of the light.
//!
//! There are four differences from the published loop. The solver is Levenberg-Marquardt. The
//! samples are evenly spread, unless independent ones are asked for. The differences are weighted
//! by their noise, unless plain ones are asked for (`mse`). The terms of the model and the starting
//! point are found in closed form.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tables::Table;

use crate::compare::Weights;
use crate::error::Error;
use crate::estimate::progress::{Progress, Step};
use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::search::compared::{Compared, compare};
use crate::estimate::search::covariance::{contrasts, reflectances};
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::layout::Choice;
use crate::estimate::search::layout::Layout;
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::{Optimum, refined_to, rough};
use crate::samples::ShiftSampler;
use crate::samples::{Sampled, Sampling, Tile};

/// Forward models.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Forward {
    /// Closed form in the frequency domain
    #[default]
    Spectral,
    /// A render by samples: the published loop
    Render,
}

/// Relative change of the parameters or of the sum of squares below which the iteration ends. The
/// sums of a render are accurate to a few 1e-7.
const CONVERGED: f64 = 1e-6;

/// Number of independent randomisations whose scatter gives the sampling error. The error is known
/// to 1/sqrt(2 x 7) = 27 % of itself.
pub const RANDOMISATIONS: u64 = 8;

/// Inputs that all estimates by samples of one scene share.
#[derive(Clone, Copy)]
pub struct Renders<'a> {
    /// Photographs, in closed form.
    pub scene: &'a Scene,
    /// Table with which the scene was measured.
    pub table: &'a Table,
    /// Weights of the differences of the MTFs.
    pub weights: Weights,
    /// Number and spreading of the samples.
    pub sampling: Sampling,
}

impl Renders<'_> {
    /// Draws samples of each photograph for the terms of `choice`. Returns the scene whose models
    /// are evaluated by them. Different randomisations are independent.
    ///
    /// # Errors
    /// Fails if the table lacks the direction of a photograph. This cannot happen with the table
    /// with which the scene was measured.
    pub fn drawn(&self, choice: Choice, randomisation: u64) -> Result<Scene, tables::Error> {
        let count = self.scene.shots.len() as u64;
        let shots = self.scene.shots.par_iter().enumerate();
        let samples = shots
            .map(|(index, shot)| self.samples(shot, choice, randomisation * count + index as u64));
        Ok(self.scene.sampled(samples.collect::<Result<_, _>>()?))
    }

    /// Draws the samples of one photograph.
    ///
    /// # Errors
    /// Fails if the table lacks the direction of the photograph.
    fn samples(
        &self,
        shot: &Aerial,
        choice: Choice,
        stream: u64,
    ) -> Result<Sampled, tables::Error> {
        let kernel = choice.kernel;
        let sampler = if kernel.has_c() {
            let azimuth_deg = shot.direction.azimuth_deg;
            ShiftSampler::new(&self.table.direction(shot.incidence_deg, azimuth_deg)?)
        } else {
            None
        };
        let shift = sampler
            .as_ref()
            .map(|sampler| (sampler, shot.incidence_deg.to_radians()));
        let shape = kernel.has_lobe().then_some(choice.shape);
        let view = &shot.view;
        let normal = shot.normal();
        let tile = |pixels| Tile::new(self.sampling, stream, pixels, shift, shape, normal);
        Ok(Sampled::new(
            &shot.pixels.raster,
            &view.profile,
            &view.line,
            &self.scene.optics.camera,
            tile,
        ))
    }

    /// Estimates one candidate by one randomisation of the samples, from a start. Returns the
    /// estimate and the scene with these samples. The standard errors do not include the sampling
    /// error.
    ///
    /// # Errors
    /// Fails if the table lacks the direction of a photograph.
    pub fn by_one_randomisation(
        &self,
        start: Optimum,
        randomisation: u64,
    ) -> Result<(Estimate, Scene), tables::Error> {
        let drawn = self.drawn(start.choice, randomisation)?;
        let loss = Loss::of_mtfs(&drawn, self.weights);
        let best = refined_to(CONVERGED, &drawn, &loss, start);
        Ok((estimate(&drawn, &loss, best), drawn))
    }

    /// Estimates one candidate by samples. Returns the estimate and the scene with the samples.
    ///
    /// The standard errors include the sampling error. It is the scatter of [`RANDOMISATIONS`]
    /// further estimates, each one Gauss-Newton step from the first. Their differences are so small
    /// that the problem is linear across them.
    ///
    /// # Errors
    /// Returns [`Error::Table`] if the table lacks the direction of a photograph, and
    /// [`Error::Cancelled`] if the flag of `progress` is set.
    pub fn estimate(
        &self,
        choice: Choice,
        progress: &Progress,
    ) -> Result<(Estimate, Scene), Error> {
        let start = rough(self.scene, choice);
        // The first samples are drawn again at the end, because two drawings at a time would take
        // twice the memory.
        let mut best = self.by_one_randomisation(start, 0)?.0;
        let layout = Layout::of(choice, self.scene);
        let mut estimates = Vec::new();
        for randomisation in 1..=RANDOMISATIONS {
            let drawn = self.drawn(choice, randomisation)?;
            estimates.push(neighbour(&drawn, self.weights, &layout, &best));
            progress.done(Step::Randomisations {
                done: estimates.len(),
                of: RANDOMISATIONS as usize,
            })?;
        }
        best.add_sampling_error(self.sampling, &scatter(&estimates));
        Ok((best, self.drawn(choice, 0)?))
    }
}

/// Returns the number of samples in one evaluation of all photographs.
pub fn samples(scene: &Scene) -> usize {
    let sampled = scene.shots.iter().filter_map(|shot| shot.sampled.as_ref());
    sampled.map(Sampled::samples).sum()
}

/// Returns ln(c, spreads, mu) by the samples of `scene`, one Gauss-Newton step from an estimate by
/// other samples.
fn neighbour(scene: &Scene, weights: Weights, layout: &Layout, best: &Estimate) -> DVector<f64> {
    let at = &best.solution.parameters;
    let (residuals, jacobian) = Loss::of_mtfs(scene, weights).evaluate(layout, at);
    let step = (jacobian.tr_mul(&jacobian))
        .cholesky()
        .map_or(DVector::zeros(at.len()), |normal| {
            normal.solve(&jacobian.tr_mul(&residuals))
        });
    let at = at - step;
    let Some(_) = &best.mu else { return at };
    let parts: Vec<Compared> = scene
        .shots
        .par_iter()
        .map(|shot| {
            let blur = layout.blur(&at, shot.place);
            compare(shot, None, layout.choice, blur)
        })
        .collect();
    let (mu, _) = reflectances(scene, layout, &contrasts(scene, &parts));
    let all = at.iter().copied().chain(mu.iter().map(|mu| mu.ln()));
    DVector::from_iterator(at.len() + mu.len(), all)
}

/// Returns the covariance of a vector, estimated from several ones.
fn scatter(vectors: &[DVector<f64>]) -> DMatrix<f64> {
    let n = vectors.len() as f64;
    let mean = vectors.iter().sum::<DVector<f64>>() / n;
    let mut sum = DMatrix::zeros(mean.len(), mean.len());
    for vector in vectors {
        let off = vector - &mean;
        sum += &off * off.transpose();
    }
    sum / (n - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the covariance of three vectors by hand. Their mean is (3, 1), and they are off by
    /// (-2, -1), (-1, 1) and (3, 0). All numbers are exact.
    #[test]
    fn scatter_of_three_vectors_by_hand() {
        let vectors = [[1.0, 0.0], [2.0, 2.0], [6.0, 1.0]];
        let found = scatter(&vectors.map(|vector| DVector::from_row_slice(&vector)));
        assert_eq!(found, DMatrix::from_row_slice(2, 2, &[7.0, 0.5, 0.5, 1.0]));
    }
}
