//! Starting values: a grid search on the OTF itself, without the estimator.

use std::f64::consts::LN_10;

use rayon::prelude::*;

use crate::estimate::choice::Choice;
use crate::estimate::compared::model;
use crate::estimate::scene::Scene;

/// A starting point.
#[derive(Debug, Clone)]
pub(crate) struct Start {
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

/// The best starting points, one for each third of the range of c: the MTF's first minimum can stem
/// from either term, and where c is small the model does not depend on it, so that no path leads
/// back from there.
///
/// c from 0.01 to 1 mm, a from 0.3 to 30 /mm; roughnesses that blur as much (their gains lie about
/// 3). The comparison leaves out what the estimator adds (its taper and window), a few percent,
/// which the solver then accounts for.
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
        .map(|c_mm| search.at(c_mm))
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

/// The best point at one c.
pub(crate) fn at(scene: &Scene, choice: Choice, c_mm: f64) -> Start {
    Search::new(scene, choice).at(c_mm).1
}

/// The MTFs of a scene at a few frequencies, with what of the model does not depend on c.
struct Search<'a> {
    scene: &'a Scene,
    choice: Choice,
    spreads: Vec<f64>,
    /// By photograph.
    samples: Vec<Vec<Sample>>,
}

struct Sample {
    frequency: f64,
    measured: f64,
    /// Modulus of lobe and camera at every spread.
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
            let frequencies = &view.estimator.frequencies_per_mm;
            let step = frequencies.len().div_ceil(24);
            let sample = |k: usize| {
                let frequency = frequencies[k];
                let camera = scene.camera.otf(frequency, view.line.normal_rad);
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

    /// The best point at one c, behind the sum of its squared differences.
    fn at(&self, c_mm: f64) -> (f64, Start) {
        let own = self.choice.per_angle_a;
        let groups = if own { self.scene.groups.len() } else { 1 };
        // cost[group][spread]
        let mut cost = vec![vec![0.0; self.spreads.len()]; groups];
        for (shot, samples) in self.scene.shots.iter().zip(&self.samples) {
            let model = model(shot, self.choice);
            let cost = &mut cost[if own { shot.group } else { 0 }];
            for sample in samples {
                let sheet = model.sheet_otf(c_mm, sample.frequency)[0].norm();
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
