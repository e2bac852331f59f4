//! Starting values: a grid search on the OTF itself, without the estimator.

use std::f64::consts::LN_10;

use crate::estimate::{Choice, model};
use crate::kernel::Blur;
use crate::scene::Scene;

/// A starting point.
#[derive(Debug, Clone)]
pub struct Start {
    /// Corner size, mm.
    pub c_mm: f64,
    /// Spread of every incidence group, or of all.
    pub spread: Vec<f64>,
}

/// Steps of the grids of c and of a over two decades each.
const STEPS: usize = 20;

/// Place `i` of a grid that begins at `first`.
fn decades(first: f64, i: usize) -> f64 {
    first * (2.0 * LN_10 * i as f64 / (STEPS - 1) as f64).exp()
}

/// The best starting points, one for each third of the range of c: the MTF's first minimum can stem from either term, and
/// where c is small the model does not depend on it, so that no path leads back from there.
///
/// c from 0.01 to 1 mm, a from 0.3 to 30 /mm; roughnesses that blur as much (their gains lie about 3). The comparison leaves out what the estimator adds (its taper and window), a
/// few percent, which the solver then accounts for.
pub fn points(scene: &Scene, choice: Choice) -> Vec<Start> {
    let size = if choice.kernel.is_baseline() {
        1.0 / scene.mean_distance_mm()
    } else {
        1.0
    };
    let lengths: Vec<f64> = if choice.kernel.has_c() {
        (0..STEPS).map(|i| decades(0.01, i) * size).collect()
    } else {
        vec![1.0]
    };
    let mut found: Vec<(f64, Start)> = lengths
        .iter()
        .map(|&c_mm| at(scene, choice, c_mm))
        .collect();
    // c is tried from below, within and above what most photographs can tell.
    let bands = if choice.kernel.has_c() { 3 } else { 1 };
    let size = found.len().div_ceil(bands);
    let best = |band: &mut [(f64, Start)]| {
        band.sort_by(|a, b| a.0.total_cmp(&b.0));
        band[0].1.clone()
    };
    found.chunks_mut(size).map(best).collect()
}

/// The best point at one c, and the sum of its squared differences.
pub fn at(scene: &Scene, choice: Choice, c_mm: f64) -> (f64, Start) {
    let groups = if choice.per_angle_a {
        scene.groups.len()
    } else {
        1
    };
    let distance = scene.mean_distance_mm();
    let scale = if choice.kernel.is_baseline() {
        0.03 / distance
    } else {
        choice.kernel.distance_scale(distance)
    };
    let spreads: Vec<f64> = if choice.kernel.has_lobe() {
        (0..STEPS).map(|i| decades(0.3, i) * scale).collect()
    } else {
        vec![1.0]
    };
    // cost[group][spread]
    let mut cost = vec![vec![0.0; spreads.len()]; groups];
    for shot in &scene.shots {
        let view = &shot.view;
        let model = model(shot, choice);
        let group = if choice.per_angle_a { shot.group } else { 0 };
        let frequencies = &view.estimator.frequencies_per_mm;
        let step = frequencies.len().div_ceil(24);
        for k in (1..frequencies.len()).step_by(step) {
            let f = frequencies[k];
            let camera = scene.camera.otf(f, view.line.normal_rad);
            for (cost, &spread) in cost[group].iter_mut().zip(&spreads) {
                let otf = model.otf(Blur { spread, c_mm }, f)[0].norm() * camera;
                *cost += (otf - view.mtf.modulus[k]).powi(2);
            }
        }
    }
    let best = cost.iter().map(|row| {
        row.iter()
            .copied()
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or((0, 0.0), |best| best)
    });
    let (indices, costs): (Vec<usize>, Vec<f64>) = best.unzip();
    (
        costs.iter().sum(),
        Start {
            c_mm,
            spread: indices.into_iter().map(|i| spreads[i]).collect(),
        },
    )
}
