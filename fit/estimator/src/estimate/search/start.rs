//! Starting values: a grid search on the OTF itself, without the estimator.

use std::f64::consts::LN_10;

use rayon::prelude::*;

use crate::estimate::scene::Scene;
use crate::estimate::search::compared::model;
use crate::estimate::search::layout::Choice;

/// Starting point of a fit.
#[derive(Debug, Clone)]
pub struct Start {
    /// Corner size, mm.
    pub c_mm: f64,
    /// Spread of each incidence, or one for all.
    pub spread: Vec<f64>,
}

/// Number of steps of the grids of c and of a, over two decades each.
const STEPS: usize = 20;

/// Returns value `i` of a grid that begins at `first`.
fn decades(first: f64, i: usize) -> f64 {
    first * (2.0 * LN_10 * i as f64 / (STEPS - 1) as f64).exp()
}

/// Finds the best starting points, one for each third of the range of c.
///
/// Several points are needed, because the MTF's first minimum can stem from either term. If c is
/// small, the model does not depend on it, and no path leads back from there.
///
/// c goes from 0.01 to 1 mm and a from 0.3 to 30 /mm. Roughnesses cover the range that blurs as
/// much (their gains are about 3). The search ignores the taper and the window of the estimator.
/// Their effect is a few percent, and the solver includes it later.
pub(crate) fn points(scene: &Scene, choice: Choice) -> Vec<Start> {
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
    let search = Search::new(scene, choice);
    let mut found: Vec<(f64, Start)> = lengths
        .into_par_iter()
        .map(|c_mm| search.at(c_mm, [0.0; 3]))
        .collect();
    // The three bands of c lie below, within and above the range that most photographs can tell.
    let bands = if choice.kernel.has_c() { 3 } else { 1 };
    let size = found.len().div_ceil(bands);
    let best = |band: &mut [(f64, Start)]| {
        band.sort_by(|a, b| a.0.total_cmp(&b.0));
        band[0].1.clone()
    };
    found.chunks_mut(size).map(best).collect()
}

/// Finds the best starting point for one c, mm.
pub(crate) fn at(scene: &Scene, choice: Choice, c_mm: f64) -> Start {
    Search::new(scene, choice).at(c_mm, [0.0; 3]).1
}

/// Finds the best starting point for each of some dihedral errors, mrad. Returns them with their errors,
/// the best first.
pub(super) fn bent(
    scene: &Scene,
    choice: Choice,
    errors_mrad: Vec<[f64; 3]>,
) -> Vec<(Start, [f64; 3])> {
    let search = Search::new(scene, choice);
    let best = |errors: [f64; 3]| {
        let all = (0..STEPS).map(|i| search.at(decades(0.01, i), errors));
        let best = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((best, errors))
    };
    let mut found: Vec<((f64, Start), [f64; 3])> =
        errors_mrad.into_par_iter().filter_map(best).collect();
    found.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
    let found = found.into_iter();
    found.map(|((_, start), errors)| (start, errors)).collect()
}

/// MTFs of a scene at a few frequencies, with the part of the model that does not depend on c.
struct Search<'a> {
    scene: &'a Scene,
    choice: Choice,
    spreads: Vec<f64>,
    /// Samples of each photograph.
    samples: Vec<Vec<Sample>>,
}

struct Sample {
    frequency: f64,
    measured: f64,
    /// Modulus of lobe and camera for each spread.
    lobe: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(scene: &'a Scene, choice: Choice) -> Search<'a> {
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
        let shots = scene.shots.par_iter().map(|shot| {
            let (view, model) = (&shot.view, model(shot, choice));
            let camera = scene.optics.camera.along(view.line.normal_rad);
            let frequencies = &view.estimator.frequencies_per_mm;
            let step = frequencies.len().div_ceil(24);
            let sample = |k: usize| {
                let frequency = frequencies[k];
                let camera = camera.otf(frequency);
                let lobe = |&spread: &f64| (model.lobe_otf(spread, frequency)[0] * camera).abs();
                Sample {
                    frequency,
                    measured: view.mtf.modulus[k],
                    lobe: spreads.iter().map(lobe).collect(),
                }
            };
            (1..frequencies.len()).step_by(step).map(sample).collect()
        });
        Search {
            scene,
            choice,
            samples: shots.collect(),
            spreads,
        }
    }

    /// Finds the best starting point for one c and some dihedral errors. Returns it after the sum of
    /// its squared differences.
    fn at(&self, c_mm: f64, errors_mrad: [f64; 3]) -> (f64, Start) {
        let own = self.choice.per_angle_a;
        let groups = if own { self.scene.groups.len() } else { 1 };
        // cost[group][spread]
        let mut cost = vec![vec![0.0; self.spreads.len()]; groups];
        for (shot, samples) in self.scene.shots.iter().zip(&self.samples) {
            let model = model(shot, self.choice);
            let cost = &mut cost[if own { shot.place.group } else { 0 }];
            for sample in samples {
                let sheet = model.sheet(c_mm, errors_mrad, sample.frequency)[0].norm();
                for (cost, lobe) in cost.iter_mut().zip(&sample.lobe) {
                    *cost += (sheet * lobe - sample.measured).powi(2);
                }
            }
        }
        let best = cost.iter().map(|row| {
            let all = row.iter().copied().enumerate();
            all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
        });
        let (indices, costs): (Vec<usize>, Vec<f64>) = best.unzip();
        let spread = indices.into_iter().map(|i| self.spreads[i]).collect();
        (costs.iter().sum(), Start { c_mm, spread })
    }
}
