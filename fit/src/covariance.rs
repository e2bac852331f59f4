//! Noise carried through the estimate: covariances of the logarithms of c, spreads and mu.

use nalgebra::{DMatrix, DVector};

use crate::estimate::{Compared, model};
use crate::layout::Layout;
use crate::reflectance::Contrast;
use crate::scene::{Aerial, Scene};
use crate::solve::Solution;

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
    /// plateaus plus its dependence on the blur for mu. `inflation` is chi^2 per degree of freedom where a model fits worse
    /// than its noise, else 1: the blur's covariance is raised by it.
    pub fn new(
        scene: &Scene,
        layout: &Layout,
        solution: &Solution,
        parts: &[Compared],
        inflation: f64,
    ) -> Noise {
        let p = layout.parameters();
        let normal = solution.jacobian.transpose() * &solution.jacobian;
        let inverse = normal
            .clone()
            .try_inverse()
            .filter(|i| i.iter().all(|v| v.is_finite()))
            .unwrap_or_else(|| DMatrix::from_diagonal_element(p, p, f64::INFINITY));

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
                    response.column_mut(j).scale_mut((v * inflation).sqrt());
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
