//! The estimate: one candidate model fitted to all photographs of a scene.
//!
//! Sugawara and Koizumi minimise the squared difference of the MTFs of photographs and renders over
//! a and c, then take mu from the luminance ratio. So does the loss `mse`, with two deviations: the
//! render is replaced by its closed form, and the solver is Levenberg-Marquardt. The loss `mtf`
//! weighs the differences by their noise covariance as well, which the estimator knows. The loss
//! `edge` puts the likelihood of the pixels in place of the MTF (see `likelihood`).

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::compare::Weights;
use crate::estimate::choice::{Choice, Value};
use crate::estimate::compared::{Compared, assemble, compare};
use crate::estimate::covariance::{Covariances, Linear};
use crate::estimate::joint::Used;
use crate::estimate::layout::Layout;
use crate::estimate::loss::Loss;
use crate::estimate::optimum::Optimum;
use crate::estimate::scene::Scene;
use crate::model::Camera;
use crate::names::{ParameterId, ParameterKind};
use crate::numerics::Solution;
use crate::samples::Sampling;

/// A fitted candidate.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// The candidate.
    pub choice: Choice,
    /// Corner size, mm; `None` under `lobe`. Of a baseline the roughness of its front.
    pub c_mm: Option<Value>,
    /// a (1/mm), A = a R under `angular`, or the roughness of a baseline: one, or one per incidence
    /// group; empty under `shift`.
    pub spread: Vec<Value>,
    /// Reflectance: one, or one per incidence group; `None` without a reference photograph.
    pub mu: Option<Vec<Value>>,
    /// What the covariance's rows are: c, the spreads, mu.
    pub parameters: Vec<ParameterId>,
    /// Covariance of all of them.
    pub covariance: DMatrix<f64>,
    /// Sum of squares of the residuals in units of their noise; under `mse` that of the MTFs, where
    /// their mean squared difference is least.
    pub chi2: f64,
    /// Independent residuals.
    pub residuals: usize,
    /// The camera: of the reference's fit, or refined with all pixels.
    pub camera: Camera,
    /// Where the solver ended.
    pub solution: Solution,
    /// MTF of the model at each shot's frequencies, through its estimator.
    pub modelled: Vec<Vec<f64>>,
    /// Mean squared MTF difference of each shot: the loss of the paper.
    pub losses: Vec<f64>,
    /// What the samples add to the errors, where the model was evaluated by samples.
    pub sampling: Option<SamplingError>,
}

/// The error that samples add.
#[derive(Debug, Clone, PartialEq)]
pub struct SamplingError {
    /// The samples.
    pub sampling: Sampling,
    /// Standard deviation of every parameter between independent randomisations, in the order of
    /// the names; the covariance and the standard errors hold it already.
    pub standard_error: Vec<f64>,
}

impl Estimate {
    /// Parameters of the blur.
    pub fn blur_parameters(&self) -> usize {
        usize::from(self.c_mm.is_some()) + self.spread.len()
    }

    /// Adds the scatter of the estimates by their samples, as [`Estimate::add_scatter`] does, and
    /// keeps what it is.
    pub fn add_sampling_error(&mut self, sampling: Sampling, scatter: &DMatrix<f64>) {
        self.sampling = Some(SamplingError {
            sampling,
            standard_error: self.add_scatter(scatter),
        });
    }

    /// Adds a covariance of the logarithms of all parameters, in the order of the names, to
    /// covariance and standard errors; gives the standard deviations that it alone makes.
    pub fn add_scatter(&mut self, scatter: &DMatrix<f64>) -> Vec<f64> {
        let values = self.c_mm.iter_mut().chain(&mut self.spread);
        let mut values: Vec<&mut Value> = values.chain(self.mu.iter_mut().flatten()).collect();
        let n = values.len();
        let own = DMatrix::from_fn(n, n, |i, j| {
            scatter[(i, j)] * values[i].value * values[j].value
        });
        self.covariance += &own;
        for (i, value) in values.iter_mut().enumerate() {
            value.standard_error = value.standard_error.hypot(own[(i, i)].sqrt());
        }
        (0..n).map(|i| own[(i, i)].sqrt()).collect()
    }

    /// Where it lies, for another loss or forward model to start from.
    pub fn optimum(&self) -> Optimum {
        Optimum {
            choice: self.choice,
            solution: self.solution.clone(),
            observations: self.residuals,
        }
    }

    /// Sum of squares per degree of freedom: 1 where the model describes the photographs.
    pub fn reduced_chi2(&self) -> f64 {
        let freedom = self.residuals.saturating_sub(self.blur_parameters()).max(1);
        self.chi2 / freedom as f64
    }
}

/// Everything that follows from the optimum: mu, covariance, losses.
pub(crate) fn estimate(scene: &Scene, loss: &Loss, optimum: Optimum) -> Estimate {
    let layout = &Layout::new(optimum.choice, scene.groups.len());
    let camera = match loss {
        Loss::Mtf(_) | Loss::Mse(_) => scene.camera,
        Loss::Edge(joint) => joint.camera(layout, &optimum.solution.parameters),
    };
    let parts = compared(scene, loss, layout, &optimum, &camera);
    let chi2 = match loss {
        Loss::Mse(_) => {
            let (residuals, _) = assemble(scene, layout, &parts, Weights::Noise);
            residuals.norm_squared()
        }
        _ => optimum.solution.sum_of_squares(),
    };
    let found = covariances(scene, loss, layout, &optimum, &parts, chi2);
    let Optimum {
        choice,
        solution,
        observations,
    } = optimum;
    let p = layout.parameters();
    let mut parameters: Vec<ParameterId> = Vec::new();
    if layout.c().is_some() {
        parameters.push(ParameterKind::size_of(choice.kernel).shared());
    }
    if layout.spreads > 0 {
        let kind = ParameterKind::spread_of(choice.kernel);
        parameters.extend(kind.each(&scene.groups, choice.per_angle_a));
    }
    let mut scale: Vec<f64> = solution
        .parameters
        .iter()
        .take(p)
        .map(|p| p.exp())
        .collect();
    let mut logarithms = found.blur;
    let mu = found.mu.map(|mu| {
        parameters.extend(ParameterKind::Mu.each(&scene.groups, choice.per_angle_mu));
        scale.extend(&mu.values);
        logarithms = mu.covariance;
        mu.values
    });
    let covariance = DMatrix::from_fn(parameters.len(), parameters.len(), |i, j| {
        logarithms[(i, j)] * scale[i] * scale[j]
    });
    // A parameter that the photographs do not depend on has no finite error.
    let value = |i: usize| {
        let variance = covariance[(i, i)];
        let standard_error = if variance.is_finite() {
            variance.max(0.0).sqrt()
        } else {
            f64::INFINITY
        };
        Value {
            value: scale[i],
            standard_error,
        }
    };
    Estimate {
        choice,
        c_mm: layout.c().map(value),
        spread: (p - layout.spreads..p).map(value).collect(),
        mu: mu.map(|mu| (p..p + mu.len()).map(value).collect()),
        chi2,
        residuals: observations,
        camera,
        losses: mean_squares(scene, &parts),
        modelled: parts.into_iter().map(|part| part.modelled).collect(),
        parameters,
        covariance,
        solution,
        sampling: None,
    }
}

/// Every photograph beside its model at the optimum, seen by the camera that the loss found.
fn compared(
    scene: &Scene,
    loss: &Loss,
    layout: &Layout,
    optimum: &Optimum,
    camera: &Camera,
) -> Vec<Compared> {
    let seen_by = match loss {
        Loss::Mtf(_) | Loss::Mse(_) => None,
        Loss::Edge(_) => Some(camera),
    };
    let shots = scene.shots.par_iter().map(|shot| {
        let blur = layout.blur(&optimum.solution.parameters, shot.group);
        compare(shot, seen_by, optimum.choice, blur)
    });
    shots.collect()
}

/// The covariances of the logarithms, raised where the model fits worse than the photographs'
/// noise.
fn covariances(
    scene: &Scene,
    loss: &Loss,
    layout: &Layout,
    optimum: &Optimum,
    parts: &[Compared],
    chi2: f64,
) -> Covariances {
    let solution = &optimum.solution;
    let p = layout.parameters();
    let freedom = optimum.observations.saturating_sub(p).max(1) as f64;
    let inflation = (chi2 / freedom).max(1.0);
    let of_mtfs = |weights| {
        let linear = Linear {
            scene,
            layout,
            solution,
            parts,
            weights,
            inflation,
        };
        linear.covariances()
    };
    match loss {
        Loss::Mtf(_) => of_mtfs(Weights::Noise),
        Loss::Mse(_) => of_mtfs(Weights::Even),
        Loss::Edge(joint) => {
            joint.information(layout, &solution.parameters, inflation, Used::ByTheEstimate)
        }
    }
}

/// Mean squared MTF difference of each photograph.
fn mean_squares(scene: &Scene, parts: &[Compared]) -> Vec<f64> {
    let mean = |(part, measured): (&Compared, &Vec<f64>)| {
        let pairs = part.modelled.iter().zip(measured).skip(1);
        let squares = pairs.map(|(m, d)| (m - d).powi(2));
        squares.sum::<f64>() / (part.modelled.len() - 1) as f64
    };
    let measured = scene.shots.iter().map(|shot| &shot.view.mtf.modulus);
    parts.iter().zip(measured).map(mean).collect()
}
