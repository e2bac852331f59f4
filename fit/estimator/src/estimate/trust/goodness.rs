//! How well a fit describes its photographs.
//!
//! Four tests ask whether noise alone explains what the fit leaves: the sum of squares of all
//! differences, that of sums over neighbours across the edge (or over neighbouring frequencies),
//! that of changes along the edge, and the sum of squares of each photograph. The misfit is
//! significant if one of the four probabilities is below `SIGNIFICANT`.
//!
//! A significant misfit raises all standard errors. The factor, [`Goodness::scale`], is the larger
//! of two numbers. One is the root of chi-square per degree of freedom. The other compares the
//! standard errors with those of a jackknife: the scatter of the estimates that leave one
//! photograph out each (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, chapter 11).
//! A single photograph is left out by halves, along its edge.
//!
//! A camera that reduces noise changes the edge at no misfit. Where photographs show it, the fit is
//! poor whatever its chi-square.
//!
//! A fifth test asks whether the lens describes the references. All photographs share the lens, so
//! its misfit is no scatter between them, which a jackknife would show. It raises the standard
//! errors by the root of chi-square of the sums over neighbours, and the verdict is never `good`.
//!
//! A sixth test asks whether the photographs agree on mu. Their exposures decide this, and the blur
//! does not depend on exposures. So this misfit raises the standard errors of mu alone.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::compare::Remainder;
use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::search::fitted::Estimate;
use crate::estimate::search::layout::Layout;
use crate::estimate::search::loss::Loss;
use edges::names::ParameterKind;
use edges::numerics::Evaluation;
use edges::numerics::chance;

/// Probability below which noise does not explain a misfit.
///
/// Six tests are made, so noise alone is called a misfit in at most 6 campaigns of 1,000.
const SIGNIFICANT: f64 = 1e-3;

/// Change of a parameter, in standard errors, from which a misfit matters.
const MATTERS: f64 = 0.5;

/// Chi-square per degree of freedom of the reference's MTF above which the lens model does not
/// describe it.
///
/// Chi-square per degree of freedom is 1 + the mean square of the misfit in units of the noise. So
/// from 2 on the misfit is as large as the noise. This limit is a convention. Noise alone exceeds
/// it in 5 of 1000 fits with 20 degrees of freedom.
pub(crate) const POOR_LENS: f64 = 2.0;

/// Factor on the standard errors from which a fit is poor. The misfit is then larger than the noise
/// by sqrt 3. This limit is a convention.
const POOR: f64 = 2.0;

/// Quality of a fit in one word: whether it describes its photographs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Noise explains the misfit, or one photograph does that does not matter.
    Good,
    /// The misfit is significant. The standard errors are raised by less than 2.
    Strained,
    /// The misfit is so large that the standard errors are raised by 2 or more, or the camera
    /// changed the edges.
    Poor,
}

impl Verdict {
    /// Returns the verdict on a significant misfit that raises the standard errors by `scale`.
    fn of(scale: f64) -> Verdict {
        if scale < POOR {
            Verdict::Strained
        } else {
            Verdict::Poor
        }
    }

    /// Returns the name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Verdict::Good => "good",
            Verdict::Strained => "strained",
            Verdict::Poor => "poor",
        }
    }
}

/// Probabilities that noise alone explains what a fit leaves. Small ones speak of a misfit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Chances {
    /// Of the sum of squares of all differences.
    pub chi2: f64,
    /// Of the sums over neighbours across the edge, or over neighbouring frequencies.
    pub across: f64,
    /// Of the changes along the edge; 1 by MTFs, which do not tell.
    pub along: f64,
    /// Of the photograph with the largest misfit among all.
    pub photograph: f64,
    /// Of the differences between the light of the photographs and that which mu gives; 1 without
    /// mu.
    pub light: f64,
}

impl Chances {
    /// Returns the least of those that tell of the blur.
    fn least(self) -> f64 {
        let all = [self.chi2, self.across, self.along, self.photograph];
        all.into_iter().fold(1.0, f64::min)
    }

    /// Returns whether the differences have a structure that noise does not explain.
    fn are_structured(self) -> bool {
        self.across.min(self.along) < SIGNIFICANT
    }
}

/// Quality of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Goodness {
    /// Sum of squares of the differences, in units of their noise.
    pub chi2: f64,
    /// Number of independent differences less that of the fitted parameters.
    pub degrees_of_freedom: usize,
    /// Probabilities that noise alone explains the misfit.
    pub chances: Chances,
    /// Factor on all standard errors: 1 if the misfit is not significant.
    pub scale: f64,
    /// Factor on the standard errors of mu: at least `scale`, and more if the photographs disagree
    /// on mu.
    pub scale_of_mu: f64,
    /// The quality in one word.
    pub verdict: Verdict,
    /// Photograph with the largest misfit.
    pub worst: Option<Worst>,
    /// Number of photographs whose noise the camera reduced beside the edge, or smoothed more widely
    /// than the edge of the reference, and of references that it sharpened until they were cut off
    /// at 0 beside the edge.
    pub reduced: usize,
    /// Numbers of the photographs, the one with the largest misfit first.
    pub(crate) worst_first: Vec<usize>,
}

/// Photograph with the largest misfit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// Name of the file.
    pub image: String,
    /// Chi-square per degree of freedom of this photograph.
    pub reduced_chi2: f64,
}

impl Goodness {
    /// Returns chi-square per degree of freedom.
    pub fn reduced_chi2(&self) -> f64 {
        self.chi2 / self.degrees_of_freedom as f64
    }

    /// Returns the factors on the standard errors of the blur and of mu.
    pub fn scales(&self) -> [f64; 2] {
        [self.scale, self.scale_of_mu]
    }

    /// Returns whether the photographs disagree on mu.
    pub(crate) fn is_light_off(&self) -> bool {
        self.chances.light < SIGNIFICANT
    }
}

/// Name of the reference among the photographs.
pub(crate) const REFERENCE: &str = "the reference";

/// Returns the name of reference `i`: its number tells it apart from others.
fn reference_name(i: usize, scene: &Scene) -> String {
    let count = scene
        .reference
        .as_ref()
        .map_or(1, |own| own.photographs.len());
    match count {
        1 => REFERENCE.to_owned(),
        _ => format!("{REFERENCE} {}", i + 1),
    }
}

/// Judges a fit. `loss` is the loss that gave it, and `fit` has standard errors by the noise alone.
pub fn of(scene: &Scene, loss: &Loss, fit: &Estimate) -> Goodness {
    let layout = Layout::of(fit.choice, scene);
    let remainders = loss.remainders(&layout, &fit.solution.parameters);
    let degrees_of_freedom = fit.degrees_of_freedom();
    let own: Vec<f64> = remainders
        .iter()
        .map(|own| chance::of_squares(own.squares, own.freedom))
        .collect();
    let mut worst_first: Vec<usize> = (0..own.len()).collect();
    worst_first.sort_by(|&a, &b| {
        let by_reduced = || remainders[b].reduced().total_cmp(&remainders[a].reduced());
        own[a].total_cmp(&own[b]).then_with(by_reduced)
    });
    let worst = worst_first.first().copied();
    // The reference comes after the photographs, and is none of them.
    worst_first.retain(|&i| i < scene.shots.len());
    let least = worst.map_or(1.0, |worst| own[worst]);
    let chances = Chances {
        chi2: chance::of_squares(fit.chi2, degrees_of_freedom),
        across: of_sums(&remainders, |own| &own.across),
        along: of_sums(&remainders, |own| &own.along),
        photograph: chance::of_least(least, own.len()),
        light: fit
            .scatter
            .as_ref()
            .map_or(1.0, |own| chance::of_squares(own.squares(), own.freedom)),
    };
    let mut goodness = Goodness {
        chi2: fit.chi2,
        degrees_of_freedom,
        chances,
        scale: 1.0,
        scale_of_mu: 1.0,
        verdict: Verdict::Good,
        worst: worst.map(|worst| {
            let shot = scene.shots.get(worst);
            Worst {
                image: shot.map_or_else(
                    || reference_name(worst - scene.shots.len(), scene),
                    |shot| shot.image.clone(),
                ),
                reduced_chi2: remainders[worst].reduced(),
            }
        }),
        reduced: changed(scene),
        worst_first,
    };
    let misfit = || {
        let left_out = LeftOut::all(scene, loss, &layout, fit);
        let moved = worst.and_then(|worst| left_out.moved(worst, fit));
        let is_small = moved.is_some_and(|moved| moved < MATTERS);
        let by_chi2 = goodness.reduced_chi2().sqrt();
        let scale = || by_chi2.max(left_out.scale(scene, fit)).max(1.0);
        (chances.are_structured() || !is_small).then(scale)
    };
    // A misfit of one photograph that does not matter raises nothing.
    if chances.least() < SIGNIFICANT
        && let Some(scale) = misfit()
    {
        goodness.scale = scale;
        goodness.verdict = Verdict::of(scale);
    }
    if let Some(scale) = misfit_of_lens(scene, &remainders) {
        goodness.scale = goodness.scale.max(scale);
        goodness.verdict = goodness.verdict.max(Verdict::of(goodness.scale));
    }
    // A camera that reduces noise moves the blur at no misfit. The weights of the pixels follow the
    // noise beside the edge, and so do the standard errors.
    if goodness.reduced > 0 {
        let reduced = scene.shots.iter().filter_map(|shot| shot.reduced_noise);
        let most = reduced.fold(1.0, f64::max);
        goodness.scale = goodness.scale.max(POOR).max(most.sqrt());
        goodness.verdict = Verdict::Poor;
    }
    goodness.scale_of_mu = goodness.scale;
    if let Some(scatter) = fit.scatter.as_ref().filter(|_| goodness.is_light_off()) {
        let own = (scatter.squares() / scatter.freedom.max(1) as f64).sqrt();
        goodness.scale_of_mu = goodness.scale.max(own);
        goodness.verdict = goodness.verdict.max(Verdict::Strained);
    }
    goodness
}

/// Returns the number of photographs whose edges the camera changed by more than a blur.
fn changed(scene: &Scene) -> usize {
    let shots = scene.shots.iter();
    let shots = shots.filter(|shot| shot.reduced_noise.is_some() || is_smoothed(scene, shot));
    let references = scene.reference.iter().flat_map(|own| &own.photographs);
    shots.count()
        + references
            .filter(|own| own.pixels.undershoots_zero())
            .count()
}

/// Number of times that the noise has to be smoothed more widely than the edge of the reference, to
/// be sure that the camera smooths edges less than noise. Widths of noise are known to some percent.
const WIDER: f64 = 1.5;

/// Returns whether the noise of a photograph is smoothed more widely than the edge of the reference.
///
/// A filter F that treats all pixels alike makes noise count 1 / (integral of |F|^2 over both
/// frequencies) times, which is the product of its widths 1 / (integral of |F|^2) along both axes.
/// It widens edges too: behind a lens, whose OTF is at most 1, the width of the whole is no smaller.
/// So a reference that is sharper than its filter would allow shows one that spares high edges. It
/// may still blur low ones, as those of mid-air images.
fn is_smoothed(scene: &Scene, shot: &Aerial) -> bool {
    const STEP_PER_PX: f64 = 0.01;
    const LAST_PER_PX: f64 = 3.0;
    let own_px = shot.pixels.excess.sqrt();
    if scene.reference.is_none() || own_px <= WIDER {
        return false;
    }
    let camera = &scene.optics.camera;
    let along = camera.along(shot.pixels.line.normal_rad);
    let count = (LAST_PER_PX / STEP_PER_PX) as usize;
    let squares = (0..count).map(|k| {
        let per_px = (k as f64 + 0.5) * STEP_PER_PX;
        along.otf(per_px / camera.pitch_mm).powi(2)
    });
    let edge_px = (2.0 * STEP_PER_PX * squares.sum::<f64>()).recip();
    own_px > WIDER * edge_px
}

/// Returns the factor on the standard errors by a significant misfit of the lens. By the MTFs the
/// covariance of the lens has the factor already.
fn misfit_of_lens(scene: &Scene, remainders: &[Remainder]) -> Option<f64> {
    let references = remainders.get(scene.shots.len()..).unwrap_or(&[]);
    if references.is_empty() {
        let reference = scene.reference.as_ref()?;
        return (reference.reduced_chi2 > POOR_LENS).then_some(1.0);
    }
    let sums = || references.iter().flat_map(|own| &own.across);
    let reduced = sums().map(|sum| sum * sum).sum::<f64>() / sums().count().max(1) as f64;
    let chance = of_sums(references, |own| &own.across);
    (chance < SIGNIFICANT).then(|| reduced.sqrt())
}

/// Returns the probability of the sums that `of` names, over all photographs.
fn of_sums(remainders: &[Remainder], of: fn(&Remainder) -> &Vec<f64>) -> f64 {
    let sums = remainders.iter().flat_map(of);
    let (mut squares, mut freedom) = (0.0, 0);
    for sum in sums {
        squares += sum * sum;
        freedom += 1;
    }
    chance::of_squares(squares, freedom)
}

/// Changes of the solver's parameters if one photograph is left out: to first order, by one
/// Gauss-Newton step each.
pub struct LeftOut {
    /// Changes without each photograph in turn.
    pub each: Vec<DVector<f64>>,
    /// Changes without one half of the photograph, if there is one photograph.
    pub halves: Vec<DVector<f64>>,
}

impl LeftOut {
    /// Computes the changes for all photographs, the reference too if the loss counts it. A change
    /// is infinite if the other photographs do not determine the parameters.
    pub fn all(scene: &Scene, loss: &Loss, layout: &Layout, fit: &Estimate) -> LeftOut {
        let at = &fit.solution.parameters;
        let (_, jacobian) = loss.evaluate(layout, at);
        let normal = jacobian.tr_mul(&jacobian);
        // Returns normal matrix and gradient of a part.
        let sums = |(residuals, jacobian): &Evaluation| {
            (jacobian.tr_mul(jacobian), jacobian.tr_mul(residuals))
        };
        let change = |others: DMatrix<f64>, pull: DVector<f64>| {
            let step = others.cholesky().map(|others| others.solve(&pull));
            step.unwrap_or_else(|| DVector::from_element(at.len(), f64::INFINITY))
        };
        let parts = loss.parts(layout, at);
        // At the optimum the gradients of all photographs add up to 0.
        let each = parts.iter().map(|part| {
            let (own, pull) = sums(part);
            change(&normal - own, pull)
        });
        let single = (scene.shots.len() == 1).then(|| loss.halves(layout, at, 0));
        let halves = single.flatten().into_iter().flatten().map(|half| {
            let (own, pull) = sums(&parts[0]);
            let (kept, kept_pull) = sums(&half);
            change(&normal - own + kept, pull - kept_pull)
        });
        LeftOut {
            halves: halves.collect(),
            each: each.collect(),
        }
    }

    /// Returns the largest change of a parameter, in standard errors, without photograph `i`.
    pub fn moved(&self, i: usize, fit: &Estimate) -> Option<f64> {
        let changes = self.each.get(i)?;
        let values = fit.values().zip(&fit.slopes).take(fit.blur_parameters());
        let moved = values
            .zip(changes)
            .map(|((value, slope), change)| change.abs() * slope / value.standard_error);
        // A change that is no number counts as large.
        Some(moved.fold(0.0, |most, moved| if moved <= most { most } else { moved }))
    }

    /// Returns the ratio of the standard errors of the jackknife to those of the noise: the largest
    /// over the kinds of parameters of the blur, each the root of the mean square over its angles.
    pub fn scale(&self, scene: &Scene, fit: &Estimate) -> f64 {
        let mut kinds: Vec<(ParameterKind, f64, f64)> = Vec::new();
        let values = fit.values().zip(&fit.slopes);
        let blur = fit.parameters.iter().zip(values);
        for (k, (id, (value, slope))) in blur.enumerate().take(fit.blur_parameters()) {
            let at_angle = |i: usize| {
                let shot = scene.shots.get(i);
                let apart = shot.zip(id.at);
                apart.is_none_or(|(shot, at)| match id.kind {
                    ParameterKind::OwnBlur => shot.floating_distance_mm == at,
                    _ => shot.incidence_deg == at,
                })
            };
            let photographs = (0..self.each.len().min(scene.shots.len()))
                .filter(|&i| at_angle(i))
                .map(|i| &self.each[i]);
            let own: Vec<f64> = photographs
                .chain(&self.halves)
                .map(|change| change[k])
                .filter(|change| change.is_finite())
                .collect();
            let ratio = variance(&own) * (slope / value.standard_error).powi(2);
            if own.len() < 2 || !ratio.is_finite() {
                continue;
            }
            match kinds.iter_mut().find(|(kind, ..)| *kind == id.kind) {
                Some((_, sum, count)) => (*sum, *count) = (*sum + ratio, *count + 1.0),
                None => kinds.push((id.kind, ratio, 1.0)),
            }
        }
        let all = kinds.iter().map(|(_, sum, count)| (sum / count).sqrt());
        all.fold(0.0, f64::max)
    }
}

/// Returns the jackknife's variance of a number from its values without one of the data each.
pub fn variance(without: &[f64]) -> f64 {
    let n = without.len() as f64;
    let mean = without.iter().sum::<f64>() / n;
    let squares: f64 = without.iter().map(|v| (v - mean).powi(2)).sum();
    squares * (n - 1.0) / n
}
