//! Noise carried through the estimate: covariances of the logarithms of c, the spreads and mu.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::compare::Contrast;
use crate::compare::Weights;
use crate::estimate::scene::reference::Reference;
use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::search::compared::{Compared, compare, curve};
use crate::estimate::search::layout::Layout;
use crate::model::Camera;
use edges::numerics::Solution;

/// Covariances of the logarithms of the parameters.
pub struct Covariances {
    /// Covariance of ln c, ln spread and the variances of further blurs.
    pub blur: DMatrix<f64>,
    /// Reflectances with their covariance; `None` without a reference photograph.
    pub mu: Option<Mu>,
}

/// Reflectances, with their covariance and that of the blur.
pub struct Mu {
    /// Values of mu, one per incidence or one for all.
    pub values: Vec<f64>,
    /// Covariance of ln c, ln spread and ln mu together.
    pub covariance: DMatrix<f64>,
    /// Differences between the light of the photographs and that which mu gives.
    pub scatter: Scatter,
}

/// Differences between the light of each photograph and that which mu gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// Difference of each photograph in units of its noise; positive if it has more light.
    pub each: Vec<f64>,
    /// Number of independent differences: photographs less values of mu.
    pub freedom: usize,
}

impl Scatter {
    /// Returns the sum of squares.
    pub fn squares(&self) -> f64 {
        self.each.iter().map(|v| v * v).sum()
    }
}

/// Optimum on the MTFs, about which each estimate is linear in the bins of each photograph.
pub(crate) struct Linear<'a> {
    /// Photographs of the estimate.
    pub scene: &'a Scene,
    /// Order of the parameters.
    pub layout: &'a Layout,
    /// Result of the solver at the optimum.
    pub solution: &'a Solution,
    /// Photographs compared with their models at the optimum.
    pub parts: &'a [Compared],
    /// Weights of the loss.
    pub weights: Weights,
}

/// Responses of the blur's parameters to their sources of error.
struct Followed {
    /// Response to the noise of each photograph's bins, scaled to unit variance (parameters x
    /// bins).
    bins: Vec<DMatrix<f64>>,
    /// Response to each parameter of the lens.
    lens: Vec<DVector<f64>>,
    /// Derivatives of ln(step) of each photograph by each parameter of the lens, without those
    /// that the blur causes.
    steps: Vec<Vec<f64>>,
}

impl Linear<'_> {
    /// Carries the noise of all bins, of the lens and of the reference's step through the estimate.
    ///
    /// For the blur, d(ln p) = -H^-1 J^T dr. For mu it is the fit of the plateaus plus its
    /// dependence on the blur. The noise of the bins is carried through the weights of the loss (a
    /// sandwich), so the errors hold even if these weights are not the best.
    pub(crate) fn covariances(&self) -> Covariances {
        let p = self.layout.parameters();
        let answers = self.answers();
        let (lens, steps) = self.by_lens(&answers).into_iter().unzip();
        let by = Followed {
            bins: self.by_bins(&answers),
            lens,
            steps,
        };
        let mut blur = DMatrix::zeros(p, p);
        for response in &by.bins {
            blur += response * response.transpose();
        }
        if !by.lens.is_empty() && p > 0 {
            blur += self.carried(&by.lens);
        }
        let mu = self
            .scene
            .reference
            .as_deref()
            .map(|reference| self.mu(&by, reference));
        Covariances { blur, mu }
    }

    /// Returns H^-1 J^T of each photograph over its weighted frequencies.
    fn answers(&self) -> Vec<DMatrix<f64>> {
        let p = self.layout.parameters();
        let normal = self.solution.jacobian.transpose() * &self.solution.jacobian;
        let inverse = normal
            .try_inverse()
            .filter(|i| i.iter().all(|v| v.is_finite()))
            .unwrap_or_else(|| DMatrix::from_diagonal_element(p, p, f64::INFINITY));
        let shots = self.scene.shots.iter().zip(self.parts);
        let answer = |(shot, part): (&Aerial, &Compared)| {
            let mut jt = DMatrix::zeros(p, part.difference.len() - 1);
            let columns = self.layout.columns(shot.place).into_iter();
            for (column, derivative) in columns.zip(&part.derivatives) {
                jt.row_mut(column)
                    .copy_from(&shot.view.weigh(self.weights, derivative).transpose());
            }
            // The residual is model - data, so the parameters follow the data with a plus sign.
            &inverse * jt
        };
        shots.map(answer).collect()
    }

    /// Returns the response of the blur to the noise of the profile.
    fn by_bins(&self, answers: &[DMatrix<f64>]) -> Vec<DMatrix<f64>> {
        let shots = self.scene.shots.par_iter().zip(answers);
        let responses = shots.map(|(shot, answer)| {
            let response = answer * shot.view.response(self.weights);
            shot.view.profile.response(response)
        });
        responses.collect()
    }

    /// Returns the response of the blur to each parameter of the lens, and the derivatives of
    /// ln(step) of each photograph by this parameter at the same blur.
    fn by_lens(&self, answers: &[DMatrix<f64>]) -> Vec<(DVector<f64>, Vec<f64>)> {
        let follow = |(camera, step): (Camera, f64)| {
            let slope = |new: &[f64], old: &[f64]| -> Vec<f64> {
                let pairs = new.iter().zip(old);
                pairs.map(|(a, b)| (a - b) / step).collect()
            };
            let changes: Vec<(DVector<f64>, f64)> = self
                .scene
                .shots
                .par_iter()
                .zip(self.parts)
                .zip(answers)
                .map(|((shot, part), answer)| {
                    let blur = self.layout.blur(&self.solution.parameters, shot.place);
                    let curve = curve(shot, Some(&camera), self.layout.choice, blur);
                    let (modelled, _) = shot.view.predict(&curve.bins, &[]);
                    let change = slope(&modelled, &part.modelled);
                    let contrast = Contrast::fit(&shot.view.profile, &part.curve.bins);
                    (
                        answer * shot.view.weigh(self.weights, &change),
                        contrast.relative_change(&slope(&curve.bins, &part.curve.bins)),
                    )
                })
                .collect();
            // The sum is taken one by one, so that its rounding does not depend on the threads.
            let none = DVector::zeros(self.layout.parameters());
            let blur = changes.iter().fold(none, |sum, (change, _)| sum - change);
            (
                blur,
                changes.into_iter().map(|(_, of_step)| of_step).collect(),
            )
        };
        let neighbours = self.scene.optics.neighbours().into_iter();
        neighbours.map(follow).collect()
    }

    /// Carries the covariance of the lens to the parameters that respond to it.
    fn carried(&self, by_lens: &[DVector<f64>]) -> DMatrix<f64> {
        let n = by_lens.first().map_or(0, DVector::len);
        let mut sum = DMatrix::zeros(n, n);
        for (i, a) in by_lens.iter().enumerate() {
            for (j, b) in by_lens.iter().enumerate() {
                sum += a * b.transpose() * self.scene.optics.covariance[(i, j)];
            }
        }
        sum
    }

    /// Computes mu of each incidence (or one for all), and the covariance of all parameters.
    fn mu(&self, by: &Followed, reference: &Reference) -> Mu {
        let (scene, layout) = (self.scene, self.layout);
        let p = layout.parameters();
        let contrasts = contrasts(scene, self.parts);
        let (values, shares) = reflectances(scene, layout, &contrasts);
        let scatter = scatter(scene, layout, &contrasts, &values);
        let groups = values.len();
        // Derivatives of ln mu by ln blur.
        let mut by_blur = DMatrix::zeros(groups, p);
        // Photographs of one incidence share a direction of the table, and with it the error of its
        // eta.
        let mut eta_error = DMatrix::<f64>::zeros(groups, scene.groups.len());
        for (i, (shot, part)) in scene.shots.iter().zip(self.parts).enumerate() {
            let (g, share) = (layout.mu_group(shot.place.group), shares[i]);
            let changes = part.curve.derivatives.iter();
            for (column, change) in layout.columns(shot.place).into_iter().zip(changes) {
                by_blur[(g, column)] += share * contrasts[i].relative_change(change);
            }
            let returned = shot.returned(layout.choice.kernel);
            eta_error[(g, shot.place.group)] += share * returned.relative_error();
        }
        let n = p + groups;
        let mut covariance = DMatrix::zeros(n, n);
        for (i, (shot, response)) in scene.shots.iter().zip(&by.bins).enumerate() {
            let mut full = DMatrix::zeros(n, response.ncols());
            full.rows_mut(0, p).copy_from(response);
            full.rows_mut(p, groups).copy_from(&(&by_blur * response));
            let (g, share) = (layout.mu_group(shot.place.group), shares[i]);
            let Contrast { step, by_bin } = &contrasts[i];
            let by_bin = by_bin.iter().map(|by| share * by / step);
            let by_bin = DMatrix::from_iterator(1, shot.view.profile.len(), by_bin);
            let mut own = full.row_mut(p + g);
            own += shot.view.profile.response(by_bin);
            covariance += &full * full.transpose();
        }
        // A lens moves mu by the blur, by the steps at the same blur, and by the reference's step.
        let with_mu = |(k, blur): (usize, &DVector<f64>)| {
            let mut mu = (&by_blur * blur).add_scalar(-reference.step_by_lens[k]);
            for (i, shot) in scene.shots.iter().enumerate() {
                mu[layout.mu_group(shot.place.group)] += shares[i] * by.steps[k][i];
            }
            DVector::from_iterator(n, blur.iter().chain(mu.iter()).copied())
        };
        let lens: Vec<DVector<f64>> = by.lens.iter().enumerate().map(with_mu).collect();
        if !lens.is_empty() {
            covariance += self.carried(&lens);
        }
        let mut shared: DMatrix<f64> = &eta_error * eta_error.transpose();
        shared.add_scalar_mut(reference.step_relative_error.powi(2));
        let mut corner = covariance.view_mut((p, p), (groups, groups));
        corner += shared;
        Mu {
            values,
            covariance,
            scatter,
        }
    }
}

/// Fits the plateaus of each photograph under its model.
pub(crate) fn contrasts(scene: &Scene, parts: &[Compared]) -> Vec<Contrast> {
    let shots = scene.shots.iter().zip(parts);
    shots
        .map(|(shot, part)| Contrast::fit(&shot.view.profile, &part.curve.bins))
        .collect()
}

/// Returns the differences of the light of all photographs from that which `mu` gives.
fn scatter(scene: &Scene, layout: &Layout, contrasts: &[Contrast], mu: &[f64]) -> Scatter {
    let kernel = layout.choice.kernel;
    let each = scene.shots.iter().zip(contrasts).map(|(shot, contrast)| {
        let own = scene.reflectance(shot, kernel, contrast.step);
        let relative = contrast.variance(&shot.view.profile).sqrt() / contrast.step;
        let noise = relative.hypot(shot.returned(kernel).relative_error());
        (own / mu[layout.mu_group(shot.place.group)]).ln() / noise.max(1e-8)
    });
    Scatter {
        each: each.collect(),
        freedom: scene.shots.len().saturating_sub(mu.len()),
    }
}

/// Fits the plateaus of each photograph under a candidate's model, by the MTFs.
pub(crate) fn contrasts_at(scene: &Scene, layout: &Layout, at: &DVector<f64>) -> Vec<Contrast> {
    let shots = scene.shots.par_iter();
    let parts: Vec<Compared> = shots
        .map(|shot| compare(shot, None, layout.choice, layout.blur(at, shot.place)))
        .collect();
    contrasts(scene, &parts)
}

/// Returns the differences of the light of all photographs from that which the best mu gives.
pub(crate) fn scatter_of(scene: &Scene, layout: &Layout, contrasts: &[Contrast]) -> Scatter {
    let (mu, _) = reflectances(scene, layout, contrasts);
    scatter(scene, layout, contrasts, &mu)
}

/// Computes mu of each incidence, or one for all, as means over the photographs with the weights of
/// their own noise. Also returns the derivative of ln mu by the ln(step) of each photograph. Both
/// are NaN without a reference.
pub(crate) fn reflectances(
    scene: &Scene,
    layout: &Layout,
    contrasts: &[Contrast],
) -> (Vec<f64>, Vec<f64>) {
    let groups = if layout.choice.per_angle_mu {
        scene.groups.len()
    } else {
        1
    };
    let (mut sums, mut values) = (vec![0.0; groups], vec![0.0; groups]);
    let weighed: Vec<(usize, f64, f64)> = scene
        .shots
        .iter()
        .zip(contrasts)
        .map(|(shot, contrast)| {
            let relative = contrast.variance(&shot.view.profile) / contrast.step.powi(2);
            let kernel = layout.choice.kernel;
            let by_rays = shot.returned(kernel).relative_error();
            let weight = 1.0 / (relative + by_rays.powi(2)).max(1e-16);
            let ratio = scene.reflectance(shot, kernel, contrast.step);
            (layout.mu_group(shot.place.group), weight, ratio)
        })
        .collect();
    for &(group, weight, ratio) in &weighed {
        sums[group] += weight;
        values[group] += weight * ratio;
    }
    for (value, sum) in values.iter_mut().zip(&sums) {
        *value /= sum;
    }
    let share = |&(g, weight, ratio): &(usize, f64, f64)| weight / sums[g] * ratio / values[g];
    let shares = weighed.iter().map(share).collect();
    (values, shares)
}
