//! The estimate: one candidate model fitted to all photographs of a scene.
//!
//! Sugawara and Koizumi minimise the squared difference of the MTFs of photographs and renders over a and c, then take
//! mu from the luminance ratio. So does the loss `mse`, with two deviations: the render is replaced by its closed form, and
//! the solver is Levenberg-Marquardt. The loss `mtf` weighs the differences by their noise covariance as well, which the estimator knows. The
//! loss `edge` puts the likelihood of the pixels in place of the MTF (see `likelihood`).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::compare::view::{Curve, Model, View, Weights};
use crate::estimate::covariance::Noise;
use crate::estimate::joint::Used;
use crate::estimate::layout::Layout;
use crate::estimate::loss::Loss;
use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::start;
use crate::model::baseline::Baseline;
use crate::model::camera::Camera;
use crate::model::kernel::{Blur, Kernel};
use crate::model::lobe::Shape;
use crate::numerics::solve::{CONVERGED, Solution, least_squares};
use crate::samples::sampled::Sampling;

/// What a candidate lets vary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// Terms of the blur.
    pub kernel: Kernel,
    /// Shape of the lobe.
    pub shape: Shape,
    /// One spread per incidence angle, or one for all.
    pub per_angle_a: bool,
    /// One mu per incidence angle, or one for all.
    pub per_angle_mu: bool,
}

/// A number and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// The estimate.
    pub value: f64,
    /// One standard deviation: pixel noise carried through the estimator, the camera and the plateaus.
    pub standard_error: f64,
}

/// A fitted candidate.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// The candidate.
    pub choice: Choice,
    /// Corner size, mm; `None` under `lobe`. Of a baseline the roughness of its front.
    pub c_mm: Option<Value>,
    /// a (1/mm), A = a R under `angular`, or the roughness of a baseline: one, or one per incidence group; empty under `shift`.
    pub spread: Vec<Value>,
    /// Reflectance: one, or one per incidence group; `None` without a reference photograph.
    pub mu: Option<Vec<Value>>,
    /// Names of the covariance's rows: c_mm, a or A (`_at_` incidence), mu likewise.
    pub names: Vec<String>,
    /// Covariance of all of them.
    pub covariance: DMatrix<f64>,
    /// Sum of squares of the residuals in units of their noise; under `mse` that of the MTFs, where their mean squared difference is
    /// least.
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
    /// Standard deviation of every parameter between independent randomisations, in the order of the names; the covariance
    /// and the standard errors hold it already.
    pub standard_error: Vec<f64>,
}

impl Estimate {
    /// Parameters of the blur.
    pub fn blur_parameters(&self) -> usize {
        usize::from(self.c_mm.is_some()) + self.spread.len()
    }

    /// Adds the scatter of the estimates by their samples, as [`Estimate::add_scatter`] does, and keeps what it is.
    pub fn add_sampling_error(&mut self, sampling: Sampling, scatter: &DMatrix<f64>) {
        self.sampling = Some(SamplingError {
            sampling,
            standard_error: self.add_scatter(scatter),
        });
    }

    /// Adds a covariance of the logarithms of all parameters, in the order of the names, to covariance and standard errors;
    /// gives the standard deviations that it alone makes.
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

/// One photograph's model with derivatives.
pub struct Compared {
    /// The model on the photograph's bins.
    pub curve: Curve,
    /// Its MTF through the photograph's estimator.
    pub modelled: Vec<f64>,
    /// Its differences to the measured MTF, not weighed.
    pub difference: Vec<f64>,
    /// Their derivatives by ln spread and ln c, those that the kernel has.
    pub derivatives: Vec<Vec<f64>>,
}

/// The model of one photograph under a candidate.
pub fn model<'a>(shot: &'a Aerial, choice: Choice) -> Model<'a> {
    Model {
        kernel: choice.kernel,
        shape: choice.shape,
        shift: shot.shift.as_ref(),
        wave: shot.wave.as_ref().ok(),
        baseline: Baseline::new(
            choice.kernel,
            shot.incidence_deg.to_radians(),
            shot.refractive_index,
            shot.view.normal(),
        ),
        r_mm: shot.r_mm,
        normal: shot.view.normal(),
    }
}

/// Compares a photograph's MTF, seen through `view`, with that of a model.
pub fn compare(shot: &Aerial, view: &View, choice: Choice, blur: Blur) -> Compared {
    let curve = view.curve(&model(shot, choice), blur);
    let by: Vec<Vec<f64>> = curve
        .by_ln_spread
        .iter()
        .chain(&curve.by_ln_c)
        .cloned()
        .collect();
    let (modelled, derivatives) = view.predict(&curve.bins, &by);
    let difference: Vec<f64> = modelled
        .iter()
        .zip(&view.mtf.modulus)
        .map(|(m, d)| m - d)
        .collect();
    Compared {
        difference,
        derivatives,
        curve,
        modelled,
    }
}

/// The optimum of one candidate.
#[derive(Debug, Clone)]
pub struct Optimum {
    /// The candidate.
    pub choice: Choice,
    /// Where the solver ended; its parameters are ln c, ln spread, and under `edge` the lens.
    pub solution: Solution,
    /// How many independent numbers were compared.
    pub observations: usize,
}

impl Optimum {
    /// Bayes' criterion: chi^2 / `misfit` + k ln n, n the independent numbers compared (see [`Loss::observations`]).
    pub fn criterion(&self, misfit: f64) -> f64 {
        let n = self.observations as f64;
        self.solution.sum_of_squares() / misfit + self.solution.parameters.len() as f64 * n.ln()
    }

    /// Sum of squares per degree of freedom.
    pub fn reduced_chi2(&self) -> f64 {
        let parameters = self.solution.parameters.len();
        let freedom = self.observations.saturating_sub(parameters).max(1);
        self.solution.sum_of_squares() / freedom as f64
    }
}

/// Fits one candidate to the MTFs of a scene.
pub fn optimum(scene: &Scene, choice: Choice) -> Optimum {
    let start = rough(scene, choice);
    refined(scene, &Loss::Mtf(scene), start)
}

/// The optimum of a candidate on the MTFs to a thousandth: enough to tell a hopeless one.
pub fn rough(scene: &Scene, choice: Choice) -> Optimum {
    rough_from(scene, choice, start::points(scene, choice))
}

/// The same from given starting points, of which there is at least one.
pub fn rough_from(scene: &Scene, choice: Choice, starts: Vec<start::Start>) -> Optimum {
    const ROUGH: f64 = 1e-3;
    let loss = Loss::Mtf(scene);
    let layout = Layout::new(choice, scene.groups.len());
    let solution = starts
        .into_iter()
        .map(|start| {
            let spread = |g: usize| start.spread[if choice.per_angle_a { g } else { 0 }].ln();
            let c = choice.kernel.has_c().then(|| start.c_mm.ln());
            let point = c.into_iter().chain((0..layout.spreads).map(spread));
            let point = DVector::from_iterator(layout.parameters(), point);
            least_squares(point, ROUGH, |at| loss.evaluate(&layout, at))
        })
        .min_by(|a, b| a.sum_of_squares().total_cmp(&b.sum_of_squares()))
        .expect("there is always a starting point");
    Optimum {
        choice,
        solution,
        observations: loss.observations(),
    }
}

/// The optimum of a candidate under any loss, to convergence, from one on the MTFs.
pub fn refined(scene: &Scene, loss: &Loss, from: Optimum) -> Optimum {
    refined_to(CONVERGED, scene, loss, from)
}

/// The same until parameters and sum of squares change by less than `tolerance` of themselves.
pub fn refined_to(tolerance: f64, scene: &Scene, loss: &Loss, from: Optimum) -> Optimum {
    let layout = Layout::new(from.choice, scene.groups.len());
    let start = loss.start(&from.solution.parameters);
    let mut solution = least_squares(start, tolerance, |at| loss.evaluate(&layout, at));
    solution.iterations += from.solution.iterations;
    Optimum {
        choice: from.choice,
        solution,
        observations: loss.observations(),
    }
}

/// A candidate under any loss where its parameters stand: an upper limit of its sum of squares.
pub fn unrefined(scene: &Scene, loss: &Loss, from: Optimum) -> Optimum {
    let layout = Layout::new(from.choice, scene.groups.len());
    let parameters = loss.start(&from.solution.parameters);
    let (residuals, jacobian) = loss.evaluate(&layout, &parameters);
    Optimum {
        solution: Solution {
            parameters,
            residuals,
            jacobian,
            ..from.solution
        },
        observations: loss.observations(),
        ..from
    }
}

/// The least sum of squares with parameter `fixed` held at `value`, and where it lies: a point of the profile likelihood.
pub fn sum_of_squares_with(
    scene: &Scene,
    loss: &Loss,
    choice: Choice,
    from: &DVector<f64>,
    fixed: usize,
    value: f64,
) -> (f64, DVector<f64>) {
    let layout = Layout::new(choice, scene.groups.len());
    let with = |free: &DVector<f64>| free.clone().insert_row(fixed, value);
    let evaluate = |free: &DVector<f64>| {
        let (residuals, jacobian) = loss.evaluate(&layout, &with(free));
        (residuals, jacobian.remove_column(fixed))
    };
    let free = from.clone().remove_row(fixed);
    if free.is_empty() {
        return (evaluate(&free).0.norm_squared(), with(&free));
    }
    let solution = least_squares(free, CONVERGED, evaluate);
    (solution.sum_of_squares(), with(&solution.parameters))
}

/// Whitened MTF differences and their derivatives at the given logarithms of c and the spreads.
pub fn residuals_at(
    scene: &Scene,
    choice: Choice,
    parameters: &DVector<f64>,
) -> (DVector<f64>, DMatrix<f64>) {
    let layout = Layout::new(choice, scene.groups.len());
    Loss::Mtf(scene).evaluate(&layout, parameters)
}

/// Stacks the differences of all photographs and their derivatives, weighed.
pub fn assemble(
    scene: &Scene,
    layout: &Layout,
    parts: &[Compared],
    weights: Weights,
) -> (DVector<f64>, DMatrix<f64>) {
    let rows = parts.iter().map(|p| p.difference.len() - 1).sum();
    let (mut residuals, mut jacobian) = (
        DVector::zeros(rows),
        DMatrix::zeros(rows, layout.parameters()),
    );
    let mut row = 0;
    for (shot, part) in scene.shots.iter().zip(parts) {
        let weighed = |values: &[f64]| shot.view.weigh(weights, values);
        let n = part.difference.len() - 1;
        residuals
            .rows_mut(row, n)
            .copy_from(&weighed(&part.difference));
        for (column, derivative) in layout
            .columns(shot.group)
            .into_iter()
            .zip(&part.derivatives)
        {
            jacobian
                .view_mut((row, column), (n, 1))
                .copy_from(&weighed(derivative));
        }
        row += n;
    }
    (residuals, jacobian)
}

/// Everything that follows from the optimum: mu, covariance, losses.
pub fn estimate(scene: &Scene, loss: &Loss, optimum: Optimum) -> Estimate {
    let Optimum {
        choice,
        solution,
        observations,
    } = optimum;
    let layout = &Layout::new(choice, scene.groups.len());
    let camera = match loss {
        Loss::Mtf(_) | Loss::Mse(_) => scene.camera,
        Loss::Edge(joint) => joint.camera(layout, &solution.parameters),
    };
    let parts: Vec<Compared> = scene
        .shots
        .par_iter()
        .map(|shot| {
            let blur = layout.blur(&solution.parameters, shot.group);
            match loss {
                Loss::Mtf(_) | Loss::Mse(_) => compare(shot, &shot.view, choice, blur),
                Loss::Edge(_) => compare(shot, &shot.view.through(&camera), choice, blur),
            }
        })
        .collect();
    let p = layout.parameters();
    let freedom = observations.saturating_sub(p).max(1) as f64;
    let chi2 = match loss {
        Loss::Mse(_) => {
            let (residuals, _) = assemble(scene, layout, &parts, Weights::Noise);
            residuals.norm_squared()
        }
        _ => solution.sum_of_squares(),
    };
    let inflation = (chi2 / freedom).max(1.0);
    let of_mtfs = |weights| Noise::new(scene, layout, &solution, &parts, weights, inflation);
    let noise = match loss {
        Loss::Mtf(_) => of_mtfs(Weights::Noise),
        Loss::Mse(_) => of_mtfs(Weights::Even),
        Loss::Edge(joint) => {
            joint.information(layout, &solution.parameters, inflation, Used::ByTheEstimate)
        }
    };
    let mut q = noise.blur;
    let mut names: Vec<String> = Vec::new();
    let mut scale: Vec<f64> = Vec::new();
    if layout.c().is_some() {
        names.push(choice.kernel.c_name().into());
    }
    let spread_name = choice.kernel.spread_name();
    names.extend(scene.names(spread_name, layout.spreads, choice.per_angle_a));
    scale.extend(solution.parameters.iter().take(p).map(|p| p.exp()));
    let mu = noise.mu.map(|mu| {
        names.extend(scene.names("mu", mu.values.len(), choice.per_angle_mu));
        scale.extend(&mu.values);
        q = mu.covariance;
        mu.values
    });
    let covariance = DMatrix::from_fn(names.len(), names.len(), |i, j| {
        q[(i, j)] * scale[i] * scale[j]
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
    let losses = parts
        .iter()
        .zip(&scene.shots)
        .map(|(part, shot)| {
            let squares = part
                .modelled
                .iter()
                .zip(&shot.view.mtf.modulus)
                .skip(1)
                .map(|(m, d)| (m - d).powi(2));
            squares.sum::<f64>() / (part.modelled.len() - 1) as f64
        })
        .collect();
    Estimate {
        choice,
        c_mm: layout.c().map(value),
        spread: (p - layout.spreads..p).map(value).collect(),
        mu: mu.map(|mu| (p..p + mu.len()).map(value).collect()),
        chi2,
        residuals: observations,
        camera,
        modelled: parts.into_iter().map(|part| part.modelled).collect(),
        names,
        covariance,
        solution,
        losses,
        sampling: None,
    }
}
