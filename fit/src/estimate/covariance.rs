//! Noise carried through the estimate: covariances of the logarithms of c, spreads and mu.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::compare::reflectance::Contrast;
use crate::compare::view::Weights;
use crate::estimate::compared::{Compared, curve};
use crate::estimate::layout::Layout;
use crate::estimate::reference::Reference;
use crate::estimate::scene::Scene;
use crate::numerics::solve::Solution;

/// Covariances of logarithms.
pub struct Noise {
    /// Of ln c and ln spread.
    pub blur: DMatrix<f64>,
    /// Reflectances; `None` without a reference photograph.
    pub mu: Option<Mu>,
}

/// Reflectances and what they share with the blur.
pub struct Mu {
    /// mu of every incidence group, or of all.
    pub values: Vec<f64>,
    /// Of ln c, ln spread and ln mu together.
    pub covariance: DMatrix<f64>,
}

impl Noise {
    /// Carries the noise of every bin, of the lens and of the reference's step through the estimate.
    ///
    /// Every estimate on the MTFs is linearised in the bins of every photograph: d(ln p) = -H^-1 J^T dr for the blur, the fit of the
    /// plateaus plus its dependence on the blur for mu. `weights` are those of the loss: the bins' noise is carried through them, so that
    /// the errors hold whether or not they are the best (a sandwich). `inflation` is chi^2 per degree of freedom where a model fits worse
    /// than its noise, else 1: the blur's covariance is raised by it.
    pub fn new(
        scene: &Scene,
        layout: &Layout,
        solution: &Solution,
        parts: &[Compared],
        weights: Weights,
        inflation: f64,
    ) -> Noise {
        let p = layout.parameters();
        let normal = solution.jacobian.transpose() * &solution.jacobian;
        let inverse = normal
            .clone()
            .try_inverse()
            .filter(|i| i.iter().all(|v| v.is_finite()))
            .unwrap_or_else(|| DMatrix::from_diagonal_element(p, p, f64::INFINITY));

        // -H^-1 J^T of each shot, over its weighed frequencies.
        let answers: Vec<DMatrix<f64>> = scene
            .shots
            .iter()
            .zip(parts)
            .map(|(shot, part)| {
                let mut jt = DMatrix::zeros(p, part.difference.len() - 1);
                for (column, derivative) in layout
                    .columns(shot.group)
                    .into_iter()
                    .zip(&part.derivatives)
                {
                    jt.row_mut(column)
                        .copy_from(&shot.view.weigh(weights, derivative).transpose());
                }
                // Residual = model - data: the parameters follow the data with a plus sign.
                &inverse * jt
            })
            .collect();
        // Blur by bin noise (p x bins), scaled to unit variance of the noise, misfit included.
        let by_bins: Vec<DMatrix<f64>> = scene
            .shots
            .par_iter()
            .zip(&answers)
            .map(|(shot, answer)| {
                let mut response = answer * shot.view.response(weights);
                for (j, v) in shot.view.profile.variance.iter().enumerate() {
                    response.column_mut(j).scale_mut((v * inflation).sqrt());
                }
                response
            })
            .collect();
        // Blur by lens parameters.
        let neighbours = scene.reference.as_deref().map(Reference::neighbours);
        let by_lens: Vec<DVector<f64>> = neighbours
            .into_iter()
            .flatten()
            .map(|(camera, step)| {
                let changes: Vec<DVector<f64>> = scene
                    .shots
                    .par_iter()
                    .zip(parts)
                    .zip(&answers)
                    .map(|((shot, part), answer)| {
                        let blur = layout.blur(&solution.parameters, shot.group);
                        let curve = curve(shot, Some(&camera), layout.choice, blur);
                        let (modelled, _) = shot.view.predict(&curve.bins, &[]);
                        let pairs = modelled.iter().zip(&part.modelled);
                        let change: Vec<f64> = pairs.map(|(a, b)| (a - b) / step).collect();
                        answer * shot.view.weigh(weights, &change)
                    })
                    .collect();
                // One after the other, so that the rounding is the same whatever the threads.
                changes
                    .iter()
                    .fold(DVector::zeros(p), |sum, change| sum - change)
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

/// The plateaus of every photograph under its model.
pub fn contrasts(scene: &Scene, parts: &[Compared]) -> Vec<Contrast> {
    let shots = scene.shots.iter().zip(parts);
    shots
        .map(|(shot, part)| Contrast::fit(&shot.view.profile, &part.curve.bins))
        .collect()
}

/// mu of every incidence group (or one): means over its photographs with the weights of their own noise; and by how much of
/// itself it follows the ln(step) of each photograph. NaN without a reference.
pub fn reflectances(
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
            (layout.mu_group(shot.group), weight, ratio)
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
    let contrasts = contrasts(scene, parts);
    let (values, shares) = reflectances(scene, layout, &contrasts);
    let groups = values.len();
    // ln mu by ln blur.
    let mut by_blur = DMatrix::zeros(groups, p);
    // Shots of one incidence share one direction of the table, and with it the error of its eta.
    let mut eta_error = DMatrix::<f64>::zeros(groups, scene.groups.len());
    for (i, (shot, part)) in scene.shots.iter().zip(parts).enumerate() {
        let (g, share) = (layout.mu_group(shot.group), shares[i]);
        let changes = part.curve.by_ln_spread.iter().chain(&part.curve.by_ln_c);
        for (column, change) in layout.columns(shot.group).into_iter().zip(changes) {
            by_blur[(g, column)] += share * contrasts[i].relative_change(change);
        }
        eta_error[(g, shot.group)] += share * shot.returned(layout.choice.kernel).relative_error();
    }
    let n = p + groups;
    let mut covariance = DMatrix::zeros(n, n);
    for (i, (shot, response)) in scene.shots.iter().zip(by_bins).enumerate() {
        let mut full = DMatrix::zeros(n, response.ncols());
        full.rows_mut(0, p).copy_from(response);
        full.rows_mut(p, groups).copy_from(&(&by_blur * response));
        let (g, share) = (layout.mu_group(shot.group), shares[i]);
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
