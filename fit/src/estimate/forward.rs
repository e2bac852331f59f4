//! The estimate by samples: the published loop in place of the closed form.
//!
//! As published: an edge is rendered for every photograph with so many samples per pixel, its MTF is taken as the
//! photograph's was, the squared differences of the MTFs are minimised over a and c by their pathwise derivatives, and mu
//! follows from the ratio of the light. Deviations: the solver is Levenberg-Marquardt, the samples are evenly spread unless
//! independent ones are asked for, and the differences are weighed by their noise unless the plain ones are (`mse`). Which terms the model has, and where the search begins, is found in closed form.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tables::Table;

use crate::compare::view::Weights;
use crate::estimate::covariance::{contrasts, reflectances};
use crate::estimate::estimate::{
    Choice, Compared, Estimate, Optimum, compare, estimate, refined_to, rough,
};
use crate::estimate::layout::Layout;
use crate::estimate::loss::Loss;
use crate::estimate::scene::Scene;
use crate::samples::sample::ShiftSampler;
use crate::samples::sampled::{Sampled, Sampling, Tile};

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

/// Change of the parameters, and of the sum of squares relative to itself, below which the iteration ends: the sums of a render
/// are good to a few 1e-7.
const CONVERGED: f64 = 1e-6;

/// Independent randomisations from whose scatter the sampling error is taken: known to 1/sqrt(2 x 7) = 27 % of itself.
pub const RANDOMISATIONS: u64 = 8;

/// Draws the samples of every photograph for the terms of `choice`; another randomisation is independent. The model of the
/// scene's views is evaluated by them from then on.
///
/// # Errors
/// As [`Table::direction`]; not for the table that the scene was loaded with.
pub fn draw(
    scene: &mut Scene,
    table: &Table,
    choice: Choice,
    sampling: Sampling,
    randomisation: u64,
) -> Result<(), tables::Error> {
    let (camera, count) = (scene.camera, scene.shots.len() as u64);
    let kernel = choice.kernel;
    let shots = scene.shots.par_iter_mut().enumerate();
    shots.try_for_each(|(index, shot)| {
        let sampler = if kernel.has_c() {
            ShiftSampler::new(&table.direction(shot.incidence_deg, shot.azimuth_deg)?)
        } else {
            None
        };
        let shift = sampler
            .as_ref()
            .map(|sampler| (sampler, shot.incidence_deg.to_radians()));
        let shape = kernel.has_lobe().then_some(choice.shape);
        let stream = randomisation * count + index as u64;
        let normal = shot.view.normal();
        let tile = |pixels| Tile::new(sampling, stream, pixels, shift, shape, normal);
        let view = &shot.view;
        let sampled = Sampled::new(
            &shot.pixels.raster,
            &view.profile,
            &view.line,
            &camera,
            tile,
        );
        shot.view.set_sampled(Some(sampled));
        Ok(())
    })
}

/// Back to the closed form.
pub fn clear(scene: &mut Scene) {
    for shot in &mut scene.shots {
        shot.view.set_sampled(None);
    }
}

/// Samples of one evaluation of all photographs.
pub fn samples(scene: &Scene) -> usize {
    let sampled = scene.shots.iter().filter_map(|shot| shot.view.sampled());
    sampled.map(Sampled::samples).sum()
}

/// The estimate of one candidate, MTF differences weighed so, by one randomisation of the samples from a start, their own error not in its standard
/// errors. The scene keeps the samples.
///
/// # Errors
/// As [`draw`].
pub fn by_one_randomisation(
    scene: &mut Scene,
    table: &Table,
    weights: Weights,
    start: Optimum,
    sampling: Sampling,
    randomisation: u64,
) -> Result<Estimate, tables::Error> {
    draw(scene, table, start.choice, sampling, randomisation)?;
    let loss = Loss::of_mtfs(scene, weights);
    let best = refined_to(CONVERGED, scene, &loss, start);
    Ok(estimate(scene, &loss, best))
}

/// The estimate of one candidate by samples. Standard errors hold the sampling error: the scatter of
/// [`RANDOMISATIONS`] further estimates, each one Gauss-Newton step from the first (their differences are so small that the
/// problem is linear across them).
///
/// # Errors
/// As [`draw`].
pub fn by_samples(
    scene: &mut Scene,
    table: &Table,
    weights: Weights,
    choice: Choice,
    sampling: Sampling,
) -> Result<Estimate, tables::Error> {
    clear(scene);
    let start = rough(scene, choice);
    let mut best = by_one_randomisation(scene, table, weights, start, sampling, 0)?;
    let layout = Layout::new(choice, scene.groups.len());
    let mut estimates = Vec::new();
    for randomisation in 1..=RANDOMISATIONS {
        draw(scene, table, choice, sampling, randomisation)?;
        estimates.push(neighbour(scene, weights, &layout, &best));
    }
    draw(scene, table, choice, sampling, 0)?;
    best.add_sampling_error(sampling, &scatter(&estimates));
    Ok(best)
}

/// ln(c, spreads, mu) of the samples that the scene holds now, one step from an estimate by others.
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
            let blur = layout.blur(&at, shot.group);
            compare(shot, &shot.view, layout.choice, blur)
        })
        .collect();
    let (mu, _) = reflectances(scene, layout, &contrasts(scene, &parts));
    let all = at.iter().copied().chain(mu.iter().map(|mu| mu.ln()));
    DVector::from_iterator(at.len() + mu.len(), all)
}

/// Covariance of one of some vectors.
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
