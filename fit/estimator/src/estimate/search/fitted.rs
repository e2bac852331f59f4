//! The estimate: one candidate model fitted to all photographs of a scene.
//!
//! Sugawara and Koizumi minimise the squared difference of the MTFs of photographs and renders over
//! a and c, then take mu from the luminance ratio. The loss `mse` does so too, with two
//! differences: the closed form replaces the render, and the solver is Levenberg-Marquardt. The
//! loss `mtf` also weights the differences by their noise covariance, which the estimator knows.
//! The loss `edge` replaces the MTF by the likelihood of the pixels (see `likelihood`).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::compare::Weights;
use crate::estimate::scene::{Place, Scene};
use crate::estimate::search::compared::{Compared, assemble, compare};
use crate::estimate::search::covariance::{Covariances, Linear, Scatter};
use crate::estimate::search::joint::Used;
use crate::estimate::search::layout::Layout;
use crate::estimate::search::layout::{Choice, Value};
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::Optimum;
use crate::model::Camera;
use crate::model::OwnBlur;
use crate::samples::Sampling;
use edges::names::{ParameterId, ParameterKind};
use edges::numerics::Solution;

/// Fitted candidate with the errors of its parameters.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// Candidate that was fitted.
    pub choice: Choice,
    /// Corner size, mm, or the roughness of a baseline's front; `None` if the kernel has neither.
    pub c_mm: Option<Value>,
    /// Spread: a (1/mm), A = a R for `angular`, or the roughness of a baseline. It has one value,
    /// or one per incidence, and is empty for `shift` and `wave`.
    pub spread: Vec<Value>,
    /// Blur of the mid-air photographs that the reference does not have: the standard deviation of a
    /// Gaussian, pixels, negative if the reference is less sharp. It has one value, or one per
    /// floating distance, and is empty if the candidate has no such blur.
    pub own_blur_px: Vec<Value>,
    /// Standard deviation of the direction of the returned light across the plane of incidence,
    /// mrad; `None` if the candidate has no such spread.
    pub angular_spread_mrad: Option<Value>,
    /// Errors of the dihedral angles at the edges 1, 2 and 3 of all cubes, mrad; `None` if the
    /// candidate has no such errors.
    pub dihedral_errors_mrad: Option<[Value; 3]>,
    /// Reflectance mu, one value or one per incidence; `None` without a reference photograph.
    pub mu: Option<Vec<Value>>,
    /// Differences between the light of the photographs and that which mu gives; `None` like mu.
    pub scatter: Option<Scatter>,
    /// Parameters in the order of the covariance's rows: c, the spreads, own blurs, angular spread,
    /// dihedral errors, mu.
    pub parameters: Vec<ParameterId>,
    /// Derivatives of the values by the coordinates in which the problem is about linear: the
    /// solver's parameters, and ln mu.
    pub slopes: Vec<f64>,
    /// Covariance of all parameters.
    pub covariance: DMatrix<f64>,
    /// Sum of squares of the residuals in units of their noise. For `mse` it is that of the MTFs at
    /// the minimum of the mean squared difference.
    pub chi2: f64,
    /// Number of independent residuals.
    pub residuals: usize,
    /// Camera from the reference's fit; for `edge` refined with all pixels.
    pub camera: Camera,
    /// Result of the solver.
    pub solution: Solution,
    /// MTF of the model at the frequencies of each photograph, through the photograph's estimator.
    pub modelled: Vec<Vec<f64>>,
    /// Mean squared MTF difference of each photograph, the loss of the paper.
    pub losses: Vec<f64>,
    /// Sampling error, if the model was evaluated by samples.
    pub sampling: Option<SamplingError>,
}

/// Error that the samples add to an estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct SamplingError {
    /// Settings of the samples.
    pub sampling: Sampling,
    /// Standard deviation of each parameter between independent randomisations, in the order of
    /// `parameters`. Covariance and standard errors include it already.
    pub standard_error: Vec<f64>,
}

impl Estimate {
    /// Returns the number of parameters of the blur.
    pub fn blur_parameters(&self) -> usize {
        self.kernel_parameters() + self.choice.further.count(self.own_blur_px.len())
    }

    /// Returns the number of parameters of the kernel: c and the spreads.
    pub fn kernel_parameters(&self) -> usize {
        usize::from(self.c_mm.is_some()) + self.spread.len()
    }

    /// Returns the own blur of a photograph, or `None` if it has none.
    pub fn own_blur_at(&self, place: Place) -> Option<Value> {
        let own = self.choice.further.own_blur.of(place.distance)?;
        self.own_blur_px.get(own).copied()
    }

    /// Returns all values in the order of `parameters`.
    pub fn values(&self) -> impl Iterator<Item = &Value> {
        let kernel = self.c_mm.iter().chain(&self.spread);
        let further = self.own_blur_px.iter().chain(&self.angular_spread_mrad);
        let further = further.chain(self.dihedral_errors_mrad.iter().flatten());
        kernel.chain(further).chain(self.mu.iter().flatten())
    }

    /// Returns the coordinates in which the problem is about linear, in the order of `parameters`:
    /// the logarithms of c, the spreads and mu, and the variances of further blurs, and the
    /// dihedral errors.
    pub fn coordinates(&self) -> Vec<f64> {
        let further = self.kernel_parameters()..self.blur_parameters();
        let values = self.values().enumerate();
        values
            .map(|(i, value)| {
                if further.contains(&i) {
                    self.solution.parameters[i]
                } else {
                    value.value.ln()
                }
            })
            .collect()
    }

    /// Adds the scatter of the estimates by their samples to the errors, and records it.
    /// [`Estimate::add_scatter`] explains `scatter`.
    pub fn add_sampling_error(&mut self, sampling: Sampling, scatter: &DMatrix<f64>) {
        self.sampling = Some(SamplingError {
            sampling,
            standard_error: self.add_scatter(scatter),
        });
    }

    /// Adds a covariance of the [`coordinates`](Estimate::coordinates), in the order of
    /// `parameters`, to covariance and standard errors. Returns the standard deviations that it
    /// alone causes.
    pub fn add_scatter(&mut self, scatter: &DMatrix<f64>) -> Vec<f64> {
        let slopes = &self.slopes;
        let n = slopes.len();
        let own = DMatrix::from_fn(n, n, |i, j| scatter[(i, j)] * slopes[i] * slopes[j]);
        self.covariance += &own;
        for (i, value) in self.values_mut().enumerate() {
            value.standard_error = value.standard_error.hypot(own[(i, i)].sqrt());
        }
        (0..n).map(|i| own[(i, i)].sqrt()).collect()
    }

    /// Returns all values in the order of `parameters`.
    fn values_mut(&mut self) -> impl Iterator<Item = &mut Value> {
        let kernel = self.c_mm.iter_mut().chain(&mut self.spread);
        let own = self.own_blur_px.iter_mut();
        let further = own.chain(&mut self.angular_spread_mrad);
        let further = further.chain(self.dihedral_errors_mrad.iter_mut().flatten());
        kernel.chain(further).chain(self.mu.iter_mut().flatten())
    }

    /// Multiplies the standard errors of the blur by the first number and those of mu by the
    /// second, and the covariance accordingly.
    pub fn raise(&mut self, [of_blur, of_mu]: [f64; 2]) {
        let blur = self.blur_parameters();
        let by = |i: usize| if i < blur { of_blur } else { of_mu };
        let n = self.parameters.len();
        self.covariance = DMatrix::from_fn(n, n, |i, j| self.covariance[(i, j)] * by(i) * by(j));
        for (i, value) in self.values_mut().enumerate() {
            value.standard_error *= by(i);
        }
    }

    /// Returns the number of degrees of freedom of the sum of squares, at least 1.
    pub fn degrees_of_freedom(&self) -> usize {
        self.residuals.saturating_sub(self.blur_parameters()).max(1)
    }

    /// Returns the optimum of this estimate, as a start for another loss or forward model.
    pub fn optimum(&self) -> Optimum {
        Optimum {
            choice: self.choice,
            solution: self.solution.clone(),
            observations: self.residuals,
        }
    }

    /// Returns the sum of squares per degree of freedom. It is about 1 if the model describes the
    /// photographs.
    pub fn reduced_chi2(&self) -> f64 {
        self.chi2 / self.degrees_of_freedom() as f64
    }
}

/// Computes everything that follows from an optimum: mu, covariance, losses.
pub fn estimate(scene: &Scene, loss: &Loss, optimum: Optimum) -> Estimate {
    let layout = &Layout::of(optimum.choice, scene);
    let camera = match loss {
        Loss::Mtf(_) | Loss::Mse(_) => scene.optics.camera.clone(),
        Loss::Edge(joint) => joint.camera(layout, &optimum.solution.parameters),
    };
    let parts = compared(scene, loss, layout, &optimum, &camera);
    let chi2 = match loss {
        Loss::Mse(_) => {
            let (residuals, _) = assemble(&scene.shots, layout, &parts, Weights::Noise);
            residuals.norm_squared()
        }
        _ => optimum.solution.sum_of_squares(),
    };
    let found = covariances(scene, loss, layout, &optimum, &parts);
    let Optimum {
        choice,
        solution,
        observations,
    } = optimum;
    let p = layout.parameters();
    let kernel = layout.logarithms();
    let Named {
        mut parameters,
        mut values,
        mut slopes,
    } = Named::of(scene, layout, &solution.parameters);
    let mut coordinates = found.blur;
    let mut scatter = None;
    let mu = found.mu.map(|mu| {
        parameters.extend(ParameterKind::Mu.each(&scene.groups, choice.per_angle_mu));
        values.extend(&mu.values);
        slopes.extend(&mu.values);
        coordinates = mu.covariance;
        scatter = Some(mu.scatter);
        mu.values
    });
    let covariance = DMatrix::from_fn(parameters.len(), parameters.len(), |i, j| {
        coordinates[(i, j)] * slopes[i] * slopes[j]
    });
    // A parameter on which the photographs do not depend has an infinite error.
    let value = |i: usize| {
        let variance = covariance[(i, i)];
        let standard_error = if variance.is_finite() {
            variance.max(0.0).sqrt()
        } else {
            f64::INFINITY
        };
        Value {
            value: values[i],
            standard_error,
        }
    };
    Estimate {
        choice,
        c_mm: layout.c().map(value),
        spread: (kernel - layout.spreads..kernel).map(value).collect(),
        own_blur_px: layout.own_blurs().map(value).collect(),
        angular_spread_mrad: layout.angular_spread().map(value),
        dihedral_errors_mrad: match layout.common_errors() {
            errors if errors.is_empty() => None,
            errors => Some([0, 1, 2].map(|k| value(errors.start + k))),
        },
        mu: mu.map(|mu| (p..p + mu.len()).map(value).collect()),
        scatter,
        chi2,
        residuals: observations,
        camera,
        losses: mean_squares(scene, &parts),
        modelled: parts.into_iter().map(|part| part.modelled).collect(),
        parameters,
        slopes,
        covariance,
        solution,
        sampling: None,
    }
}

/// Parameters of the blur with their values.
struct Named {
    parameters: Vec<ParameterId>,
    values: Vec<f64>,
    /// Derivatives of the values by the solver's parameters.
    slopes: Vec<f64>,
}

impl Named {
    /// Takes the values from the solver's parameters.
    fn of(scene: &Scene, layout: &Layout, at: &DVector<f64>) -> Named {
        let choice = layout.choice;
        let mut parameters: Vec<ParameterId> = Vec::new();
        if layout.c().is_some() {
            parameters.push(ParameterKind::size_of(choice.kernel).shared());
        }
        if layout.spreads > 0 {
            let kind = ParameterKind::spread_of(choice.kernel);
            parameters.extend(kind.each(&scene.groups, choice.per_angle_a));
        }
        let logarithms = at.iter().take(layout.logarithms());
        let mut values: Vec<f64> = logarithms.map(|p| p.exp()).collect();
        let mut slopes = values.clone();
        let pitch_mm = scene.optics.camera.pitch_mm;
        let blurs = own_blurs(scene, layout.choice);
        let blurs = layout.own_blurs().zip(blurs);
        let blurs = blurs.map(|(column, id)| (column, id, pitch_mm));
        let spread = layout.angular_spread();
        let spread = spread.map(|column| (column, ParameterKind::AngularSpread.shared(), 1.0));
        for (column, id, unit) in blurs.chain(spread) {
            parameters.push(id);
            let [value, slope] = deviation(at[column], unit);
            values.push(value);
            slopes.push(slope);
        }
        for (column, kind) in layout.common_errors().zip(ParameterKind::DIHEDRAL_ERRORS) {
            parameters.push(kind.shared());
            values.push(at[column]);
            slopes.push(1.0);
        }
        Named {
            parameters,
            values,
            slopes,
        }
    }
}

/// Returns the names of the own blurs of a candidate that has some.
pub(crate) fn own_blurs(scene: &Scene, choice: Choice) -> Vec<ParameterId> {
    let is_apart = choice.further.own_blur == OwnBlur::PerDistance;
    ParameterKind::OwnBlur.each(&scene.distances_mm, is_apart)
}

/// Returns the standard deviation of a variance, in a unit, with the sign of the variance, and its
/// derivative by the variance.
fn deviation(variance: f64, unit: f64) -> [f64; 2] {
    let deviation = variance.abs().sqrt();
    // A variance of 0 has no derivative. No candidate keeps a blur that is near 0.
    let slope = 0.5 / deviation.max(f64::MIN_POSITIVE);
    [deviation.copysign(variance) / unit, slope / unit]
}

/// Compares each photograph with its model at the optimum, seen by the camera that the loss found.
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
        let blur = layout.blur(&optimum.solution.parameters, shot.place);
        compare(shot, seen_by, optimum.choice, blur)
    });
    shots.collect()
}

/// Returns the covariances of the logarithms that the noise of the photographs causes.
fn covariances(
    scene: &Scene,
    loss: &Loss,
    layout: &Layout,
    optimum: &Optimum,
    parts: &[Compared],
) -> Covariances {
    let solution = &optimum.solution;
    let of_mtfs = |weights| {
        let linear = Linear {
            scene,
            layout,
            solution,
            parts,
            weights,
        };
        linear.covariances()
    };
    match loss {
        Loss::Mtf(_) => of_mtfs(Weights::Noise),
        Loss::Mse(_) => of_mtfs(Weights::Even),
        Loss::Edge(joint) => joint.information(layout, &solution.parameters, Used::ByTheEstimate),
    }
}

/// Returns the mean squared MTF difference of each photograph.
fn mean_squares(scene: &Scene, parts: &[Compared]) -> Vec<f64> {
    let mean = |(part, measured): (&Compared, &Vec<f64>)| {
        let pairs = part.modelled.iter().zip(measured).skip(1);
        let squares = pairs.map(|(m, d)| (m - d).powi(2));
        squares.sum::<f64>() / (part.modelled.len() - 1) as f64
    };
    let measured = scene.shots.iter().map(|shot| &shot.view.mtf.modulus);
    parts.iter().zip(measured).map(mean).collect()
}
