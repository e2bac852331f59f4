//! The estimate: one candidate model fitted to all photographs of a scene.
//!
//! Sugawara and Koizumi minimise the squared difference of the MTFs of photographs and renders over a and c, then take
//! mu from the luminance ratio. So does this, with three deviations: the render is replaced by its closed form; the
//! differences are weighted by their noise covariance, which the estimator knows; and the solver is Levenberg-Marquardt.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::kernel::{Blur, Kernel};
use crate::lobe::Shape;
use crate::reflectance::Contrast;
use crate::scene::{Aerial, Scene};
use crate::solve::{Solution, least_squares};
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

/// Where the parameters of a candidate stand: [ln c] [ln spread ...].
struct Layout {
    choice: Choice,
    spreads: usize,
}

impl Layout {
    fn new(choice: Choice, groups: usize) -> Layout {
        let spreads = match (choice.kernel.has_lobe(), choice.per_angle_a) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => groups,
        };
        Layout { choice, spreads }
    }

    fn c(&self) -> Option<usize> {
        self.choice.kernel.has_shift().then_some(0)
    }

    fn spread(&self, group: usize) -> Option<usize> {
        let first = usize::from(self.choice.kernel.has_shift());
        (self.spreads > 0).then(|| first + if self.choice.per_angle_a { group } else { 0 })
    }

    fn parameters(&self) -> usize {
        usize::from(self.choice.kernel.has_shift()) + self.spreads
    }

    fn blur(&self, parameters: &DVector<f64>, group: usize) -> Blur {
        // Beyond e^+-14 of 1 mm or 1/mm nothing changes any more; the clamp keeps a runaway step finite.
        let at = |i: Option<usize>| i.map_or(1.0, |i| parameters[i].clamp(-14.0, 14.0).exp());
        Blur {
            spread: at(self.spread(group)),
            c_mm: at(self.c()),
        }
    }

    /// Columns of the parameters that one shot depends on, in the order of its derivatives (spread, c).
    fn columns(&self, group: usize) -> Vec<usize> {
        self.spread(group).into_iter().chain(self.c()).collect()
    }
}

/// One shot's model with derivatives.
struct Compared {
    curve: Curve,
    modelled: Vec<f64>,
    residuals: DVector<f64>,
    derivatives: Vec<DVector<f64>>,
}

fn model<'a>(shot: &'a Aerial, choice: Choice) -> Model<'a> {
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
    let layout = Layout::new(choice, scene.groups.len());
    let evaluate = |parameters: &DVector<f64>| residuals(scene, &layout, parameters);
    let solution = start::points(scene, choice)
        .into_iter()
        .map(|start| {
            let spreads = (0..layout.spreads)
                .map(|g| start.spread[if choice.per_angle_a { g } else { 0 }].ln());
            let c = choice.kernel.has_shift().then(|| start.c_mm.ln());
            least_squares(
                DVector::from_iterator(layout.parameters(), c.into_iter().chain(spreads)),
                evaluate,
            )
        })
        .min_by(|a, b| a.sum_of_squares().total_cmp(&b.sum_of_squares()))
        .expect("there is always a starting point");
    Optimum { choice, solution }
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
    let solution = least_squares(free, evaluate);
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
    let value = |i: usize| Value {
        value: scale[i],
        standard_error: covariance[(i, i)].max(0.0).sqrt(),
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

/// Covariances of logarithms.
struct Noise {
    /// Of ln c and ln spread.
    blur: DMatrix<f64>,
    mu: Option<Mu>,
}

struct Mu {
    values: Vec<f64>,
    /// Of ln c, ln spread and ln mu together.
    covariance: DMatrix<f64>,
}

impl Noise {
    /// Carries the noise of every bin, of the lens and of the reference's step through the estimate.
    ///
    /// Every estimate is linearised in the bins of every photograph: d(ln p) = -H^-1 J^T dr for the blur, the fit of the
    /// plateaus plus its dependence on the blur for mu. A model that fits worse than its noise has its blur covariance
    /// raised by chi^2 per degree of freedom.
    fn new(scene: &Scene, layout: &Layout, solution: &Solution, parts: &[Compared]) -> Noise {
        let p = layout.parameters();
        let normal = solution.jacobian.transpose() * &solution.jacobian;
        let inverse = normal
            .clone()
            .try_inverse()
            .filter(|i| i.iter().all(|v| v.is_finite()))
            .unwrap_or_else(|| DMatrix::from_diagonal_element(p, p, f64::INFINITY));
        let freedom = solution.residuals.len().saturating_sub(p).max(1) as f64;
        let inflation = (solution.sum_of_squares() / freedom).max(1.0).sqrt();

        // -H^-1 J^T of each shot, over its whitened frequencies.
        let answers: Vec<DMatrix<f64>> = scene
            .shots
            .iter()
            .zip(parts)
            .map(|(shot, part)| {
                let mut jt = DMatrix::zeros(p, part.residuals.len());
                for (column, derivative) in layout
                    .columns(shot.group)
                    .into_iter()
                    .zip(&part.derivatives)
                {
                    jt.row_mut(column).copy_from(&derivative.transpose());
                }
                // Residual = model - data: the parameters follow the data with a plus sign.
                &inverse * jt
            })
            .collect();
        // Blur by bin noise (p x bins), scaled to unit variance of the noise, misfit included.
        let by_bins: Vec<DMatrix<f64>> = scene
            .shots
            .iter()
            .zip(&answers)
            .map(|(shot, answer)| {
                let mut response = answer * shot.view.whitened_response();
                for (j, v) in shot.view.profile.variance.iter().enumerate() {
                    response.column_mut(j).scale_mut(v.sqrt() * inflation);
                }
                response
            })
            .collect();
        // Blur by lens parameters.
        let lens = scene.lens_steps();
        let by_lens: Vec<DVector<f64>> = lens
            .iter()
            .map(|step| {
                let mut sum = DVector::zeros(p);
                for ((shot, part), (answer, other)) in scene
                    .shots
                    .iter()
                    .zip(parts)
                    .zip(answers.iter().zip(&step.views))
                {
                    let blur = layout.blur(&solution.parameters, shot.group);
                    let curve = other.curve(&model(shot, layout.choice), blur);
                    let (modelled, _) = other.predict(&curve.bins, &[]);
                    let change: Vec<f64> = modelled
                        .iter()
                        .zip(&part.modelled)
                        .map(|(a, b)| (a - b) / step.size)
                        .collect();
                    sum -= answer * other.whiten(&change);
                }
                sum
            })
            .collect();
        let lens_covariance = scene.reference.as_ref().map(|r| r.lens_covariance);
        let carried = |by_lens: &[DVector<f64>]| {
            let n = by_lens.first().map_or(0, DVector::len);
            let mut sum = DMatrix::zeros(n, n);
            if let Some(covariance) = lens_covariance {
                for (i, a) in by_lens.iter().enumerate() {
                    for (j, b) in by_lens.iter().enumerate() {
                        sum += a * b.transpose() * covariance[(i, j)];
                    }
                }
            }
            sum
        };
        let mut blur = DMatrix::zeros(p, p);
        for response in &by_bins {
            blur += response * response.transpose();
        }
        if !by_lens.is_empty() && p > 0 {
            blur += carried(&by_lens);
        }
        let mu = scene.reference.as_ref().map(|reference| {
            mu(
                scene,
                layout,
                parts,
                &by_bins,
                &by_lens,
                &carried,
                reference.step_relative_error,
            )
        });
        Noise { blur, mu }
    }
}

/// mu of every incidence group (or one), and the covariance of everything.
fn mu(
    scene: &Scene,
    layout: &Layout,
    parts: &[Compared],
    by_bins: &[DMatrix<f64>],
    by_lens: &[DVector<f64>],
    carried: &dyn Fn(&[DVector<f64>]) -> DMatrix<f64>,
    step_relative_error: f64,
) -> Mu {
    let p = layout.parameters();
    let groups = if layout.choice.per_angle_mu {
        scene.groups.len()
    } else {
        1
    };
    let group_of = |shot: &Aerial| {
        if layout.choice.per_angle_mu {
            shot.group
        } else {
            0
        }
    };
    let contrasts: Vec<Contrast> = scene
        .shots
        .iter()
        .zip(parts)
        .map(|(shot, part)| Contrast::fit(&shot.view.profile, &part.curve.bins))
        .collect();
    // Shots of a group are averaged with the weights of their own noise.
    let ratio = |i: usize| scene.reflectance(&scene.shots[i], contrasts[i].step);
    let weight = |i: usize| {
        let relative =
            contrasts[i].variance(&scene.shots[i].view.profile) / contrasts[i].step.powi(2);
        1.0 / (relative + scene.shots[i].eta_relative_error().powi(2)).max(1e-16)
    };
    let mut sums = vec![0.0; groups];
    let mut values = vec![0.0; groups];
    for (i, shot) in scene.shots.iter().enumerate() {
        sums[group_of(shot)] += weight(i);
        values[group_of(shot)] += weight(i) * ratio(i);
    }
    for (value, sum) in values.iter_mut().zip(&sums) {
        *value /= sum;
    }
    // ln mu by ln blur.
    let mut by_blur = DMatrix::zeros(groups, p);
    // Shots of one incidence share one direction of the table, and with it the error of its eta.
    let mut eta_error = DMatrix::<f64>::zeros(groups, scene.groups.len());
    for (i, (shot, part)) in scene.shots.iter().zip(parts).enumerate() {
        let g = group_of(shot);
        let share = weight(i) / sums[g] * ratio(i) / values[g];
        let changes = part.curve.by_ln_spread.iter().chain(&part.curve.by_ln_c);
        for (column, change) in layout.columns(shot.group).into_iter().zip(changes) {
            by_blur[(g, column)] += share * contrasts[i].relative_change(change);
        }
        eta_error[(g, shot.group)] += share * shot.eta_relative_error();
    }
    let n = p + groups;
    let mut covariance = DMatrix::zeros(n, n);
    for (i, (shot, response)) in scene.shots.iter().zip(by_bins).enumerate() {
        let mut full = DMatrix::zeros(n, response.ncols());
        full.rows_mut(0, p).copy_from(response);
        full.rows_mut(p, groups).copy_from(&(&by_blur * response));
        let g = group_of(shot);
        let share = weight(i) / sums[g] * ratio(i) / values[g];
        for (j, v) in shot.view.profile.variance.iter().enumerate() {
            full[(p + g, j)] += share * contrasts[i].by_bin[j] / contrasts[i].step * v.sqrt();
        }
        covariance += &full * full.transpose();
    }
    let lens: Vec<DVector<f64>> = by_lens
        .iter()
        .map(|blur| {
            let mu = &by_blur * blur;
            DVector::from_iterator(n, blur.iter().chain(mu.iter()).copied())
        })
        .collect();
    if !lens.is_empty() {
        covariance += carried(&lens);
    }
    let mut shared: DMatrix<f64> = &eta_error * eta_error.transpose();
    shared.add_scalar_mut(step_relative_error.powi(2));
    let mut corner = covariance.view_mut((p, p), (groups, groups));
    corner += shared;
    Mu { values, covariance }
}
