//! The estimate: one candidate model fitted to all photographs of a scene.
//!
//! Sugawara and Koizumi minimise the squared difference of the MTFs of photographs and renders over a and c, then take
//! mu from the luminance ratio. So does this, with three deviations: the render is replaced by its closed form; the
//! differences are weighted by their noise covariance, which the estimator knows; and the solver is Levenberg-Marquardt.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::covariance::Noise;
use crate::kernel::{Blur, Kernel};
use crate::layout::Layout;
use crate::lobe::Shape;
use crate::scene::{Aerial, Scene};
use crate::solve::{CONVERGED, Solution, least_squares};
use crate::start;
use crate::view::{Curve, Model};

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
    /// Corner size, mm; `None` under `lobe`.
    pub c_mm: Option<Value>,
    /// a (1/mm), or A = a R under `angular`: one, or one per incidence group; empty under `shift`.
    pub spread: Vec<Value>,
    /// Reflectance: one, or one per incidence group; `None` without a reference photograph.
    pub mu: Option<Vec<Value>>,
    /// Names of the covariance's rows: c_mm, a or A (`_at_` incidence), mu likewise.
    pub names: Vec<String>,
    /// Covariance of all of them.
    pub covariance: DMatrix<f64>,
    /// Sum of squares of the whitened MTF differences.
    pub chi2: f64,
    /// Whitened MTF differences.
    pub residuals: usize,
    /// Where the solver ended.
    pub solution: Solution,
    /// MTF of the model at each shot's frequencies, through its estimator.
    pub modelled: Vec<Vec<f64>>,
    /// Mean squared MTF difference of each shot: the loss of the paper.
    pub losses: Vec<f64>,
}

impl Estimate {
    /// Parameters of the blur.
    pub fn blur_parameters(&self) -> usize {
        self.solution.parameters.len()
    }
}

/// One photograph's model with derivatives.
pub struct Compared {
    /// The model on the photograph's bins.
    pub curve: Curve,
    /// Its MTF through the photograph's estimator.
    pub modelled: Vec<f64>,
    /// Whitened differences to the measured MTF.
    pub residuals: DVector<f64>,
    /// Their derivatives by ln spread and ln c, those that the kernel has.
    pub derivatives: Vec<DVector<f64>>,
}

/// The model of one photograph under a candidate.
pub fn model<'a>(shot: &'a Aerial, choice: Choice) -> Model<'a> {
    Model {
        kernel: choice.kernel,
        shape: choice.shape,
        shift: shot.shift.as_ref(),
        r_mm: shot.r_mm,
        normal: shot.view.normal(),
    }
}

fn compare(shot: &Aerial, choice: Choice, blur: Blur) -> Compared {
    let curve = shot.view.curve(&model(shot, choice), blur);
    let by: Vec<Vec<f64>> = curve
        .by_ln_spread
        .iter()
        .chain(&curve.by_ln_c)
        .cloned()
        .collect();
    let (modelled, derivatives) = shot.view.predict(&curve.bins, &by);
    let difference: Vec<f64> = modelled
        .iter()
        .zip(&shot.view.mtf.modulus)
        .map(|(m, d)| m - d)
        .collect();
    Compared {
        residuals: shot.view.whiten(&difference),
        derivatives: derivatives.iter().map(|d| shot.view.whiten(d)).collect(),
        curve,
        modelled,
    }
}

/// The optimum of one candidate.
#[derive(Debug, Clone)]
pub struct Optimum {
    /// The candidate.
    pub choice: Choice,
    /// Where the solver ended.
    pub solution: Solution,
}

impl Optimum {
    /// Bayes' criterion on the whitened MTF differences: chi^2 + k ln n.
    pub fn criterion(&self) -> f64 {
        let n = self.solution.residuals.len() as f64;
        self.solution.sum_of_squares() + self.solution.parameters.len() as f64 * n.ln()
    }
}

/// Fits one candidate to a scene.
pub fn optimum(scene: &Scene, choice: Choice) -> Optimum {
    refined(scene, rough(scene, choice))
}

/// The optimum of a candidate to a thousandth: enough to tell a hopeless one.
pub fn rough(scene: &Scene, choice: Choice) -> Optimum {
    const ROUGH: f64 = 1e-3;
    let layout = Layout::new(choice, scene.groups.len());
    let solution = start::points(scene, choice)
        .into_iter()
        .map(|start| {
            let spread = |g: usize| start.spread[if choice.per_angle_a { g } else { 0 }].ln();
            let c = choice.kernel.has_shift().then(|| start.c_mm.ln());
            let point = c.into_iter().chain((0..layout.spreads).map(spread));
            let point = DVector::from_iterator(layout.parameters(), point);
            least_squares(point, ROUGH, |at| residuals(scene, &layout, at))
        })
        .min_by(|a, b| a.sum_of_squares().total_cmp(&b.sum_of_squares()))
        .expect("there is always a starting point");
    Optimum { choice, solution }
}

/// The same optimum to convergence.
pub fn refined(scene: &Scene, rough: Optimum) -> Optimum {
    let layout = Layout::new(rough.choice, scene.groups.len());
    let from = rough.solution.parameters.clone();
    let mut solution = least_squares(from, CONVERGED, |at| residuals(scene, &layout, at));
    solution.iterations += rough.solution.iterations;
    Optimum {
        choice: rough.choice,
        solution,
    }
}

/// The least sum of squares with parameter `fixed` held at `value`, and where it lies: a point of the profile likelihood.
pub fn sum_of_squares_with(
    scene: &Scene,
    choice: Choice,
    from: &DVector<f64>,
    fixed: usize,
    value: f64,
) -> (f64, DVector<f64>) {
    let layout = Layout::new(choice, scene.groups.len());
    let with = |free: &DVector<f64>| free.clone().insert_row(fixed, value);
    let evaluate = |free: &DVector<f64>| {
        let (residuals, jacobian) = residuals(scene, &layout, &with(free));
        (residuals, jacobian.remove_column(fixed))
    };
    let free = from.clone().remove_row(fixed);
    if free.is_empty() {
        return (evaluate(&free).0.norm_squared(), with(&free));
    }
    let solution = least_squares(free, CONVERGED, evaluate);
    (solution.sum_of_squares(), with(&solution.parameters))
}

/// Whitened residuals and their derivatives at the given logarithms of c and the spreads.
pub fn residuals_at(
    scene: &Scene,
    choice: Choice,
    parameters: &DVector<f64>,
) -> (DVector<f64>, DMatrix<f64>) {
    residuals(scene, &Layout::new(choice, scene.groups.len()), parameters)
}

fn residuals(
    scene: &Scene,
    layout: &Layout,
    parameters: &DVector<f64>,
) -> (DVector<f64>, DMatrix<f64>) {
    let parts: Vec<Compared> = scene
        .shots
        .par_iter()
        .map(|shot| compare(shot, layout.choice, layout.blur(parameters, shot.group)))
        .collect();
    assemble(scene, layout, &parts)
}

fn assemble(scene: &Scene, layout: &Layout, parts: &[Compared]) -> (DVector<f64>, DMatrix<f64>) {
    let rows = parts.iter().map(|p| p.residuals.len()).sum();
    let (mut residuals, mut jacobian) = (
        DVector::zeros(rows),
        DMatrix::zeros(rows, layout.parameters()),
    );
    let mut row = 0;
    for (shot, part) in scene.shots.iter().zip(parts) {
        let n = part.residuals.len();
        residuals.rows_mut(row, n).copy_from(&part.residuals);
        for (column, derivative) in layout
            .columns(shot.group)
            .into_iter()
            .zip(&part.derivatives)
        {
            jacobian
                .view_mut((row, column), (n, 1))
                .copy_from(derivative);
        }
        row += n;
    }
    (residuals, jacobian)
}

/// Everything that follows from the optimum: mu, covariance, losses.
pub fn estimate(scene: &Scene, optimum: Optimum) -> Estimate {
    let Optimum { choice, solution } = optimum;
    let layout = &Layout::new(choice, scene.groups.len());
    let parts: Vec<Compared> = scene
        .shots
        .par_iter()
        .map(|shot| compare(shot, choice, layout.blur(&solution.parameters, shot.group)))
        .collect();
    let noise = Noise::new(scene, layout, &solution, &parts);
    let mut q = noise.blur;
    let mut names: Vec<String> = Vec::new();
    let mut scale: Vec<f64> = Vec::new();
    if layout.c().is_some() {
        names.push("c_mm".into());
    }
    let spread_name = if choice.kernel == Kernel::Angular {
        "a_times_r"
    } else {
        "a_per_mm"
    };
    names.extend(scene.names(spread_name, layout.spreads, choice.per_angle_a));
    scale.extend(solution.parameters.iter().map(|p| p.exp()));
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
    let p = layout.parameters();
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
        chi2: solution.sum_of_squares(),
        residuals: solution.residuals.len(),
        modelled: parts.into_iter().map(|part| part.modelled).collect(),
        names,
        covariance,
        solution,
        losses,
    }
}
