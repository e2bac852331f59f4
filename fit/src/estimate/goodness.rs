//! How well a fit describes its photographs.
//!
//! Four tests ask whether noise alone explains what the fit leaves: the sum of squares of all
//! differences, that of sums over neighbours across the edge (or over neighbouring frequencies),
//! that of changes along the edge, and the sum of squares of each photograph. The misfit is
//! significant if one of the four probabilities is below [`SIGNIFICANT`].
//!
//! A significant misfit raises all standard errors. The factor, [`Goodness::scale`], is the larger
//! of two numbers. One is the root of chi-square per degree of freedom. The other compares the
//! standard errors with those of a jackknife: the scatter of the estimates that leave one
//! photograph out each (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, chapter 11).
//! A single photograph is left out by halves, along its edge.
//!
//! A fifth test asks whether the photographs agree on mu. Their exposures decide this, and the blur
//! does not depend on exposures. So this misfit raises the standard errors of mu alone.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::compare::Remainder;
use crate::estimate::fitted::Estimate;
use crate::estimate::layout::Layout;
use crate::estimate::loss::Loss;
use crate::estimate::scene::Scene;
use crate::names::ParameterKind;
use crate::numerics::Evaluation;
use crate::numerics::chance;

/// Probability below which noise does not explain a misfit.
///
/// Four tests are made, so noise alone is called a misfit in at most 4 campaigns of 1,000.
const SIGNIFICANT: f64 = 1e-3;

/// Change of a parameter, in standard errors, from which a misfit matters.
const MATTERS: f64 = 0.5;

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
    /// The misfit is so large that the standard errors are raised by 2 or more.
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
    pub(crate) fn scales(&self) -> [f64; 2] {
        [self.scale, self.scale_of_mu]
    }

    /// Returns whether the photographs disagree on mu.
    pub(crate) fn is_light_off(&self) -> bool {
        self.chances.light < SIGNIFICANT
    }
}

/// Name of the reference among the photographs.
pub(crate) const REFERENCE: &str = "the reference";

/// Judges a fit. `loss` is the loss that gave it, and `fit` has standard errors by the noise alone.
pub(crate) fn of(scene: &Scene, loss: &Loss, fit: &Estimate) -> Goodness {
    let layout = Layout::new(fit.choice, scene.groups.len());
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
                image: shot.map_or(REFERENCE.to_owned(), |shot| shot.image.clone()),
                reduced_chi2: remainders[worst].reduced(),
            }
        }),
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
    goodness.scale_of_mu = goodness.scale;
    if let Some(scatter) = fit.scatter.as_ref().filter(|_| goodness.is_light_off()) {
        let own = (scatter.squares() / scatter.freedom.max(1) as f64).sqrt();
        goodness.scale_of_mu = goodness.scale.max(own);
        goodness.verdict = goodness.verdict.max(Verdict::Strained);
    }
    goodness
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

/// Changes of the blur's parameters, as logarithms, if one photograph is left out: to first order,
/// by one Gauss-Newton step each.
struct LeftOut {
    each: Vec<DVector<f64>>,
    /// Changes without one half of the photograph, if there is one photograph.
    halves: Vec<DVector<f64>>,
}

impl LeftOut {
    /// Computes the changes for all photographs, the reference too if the loss counts it. A change
    /// is infinite if the other photographs do not determine the parameters.
    fn all(scene: &Scene, loss: &Loss, layout: &Layout, fit: &Estimate) -> LeftOut {
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
    fn moved(&self, i: usize, fit: &Estimate) -> Option<f64> {
        let changes = self.each.get(i)?;
        let blur = fit.values().take(fit.blur_parameters()).zip(changes);
        let moved = blur.map(|(value, change)| change.abs() * value.value / value.standard_error);
        // A change that is no number counts as large.
        Some(moved.fold(0.0, |most, moved| if moved <= most { most } else { moved }))
    }

    /// Returns the ratio of the standard errors of the jackknife to those of the noise: the largest
    /// over the kinds of parameters of the blur, each the root of the mean square over its angles.
    fn scale(&self, scene: &Scene, fit: &Estimate) -> f64 {
        let mut kinds: Vec<(ParameterKind, f64, f64)> = Vec::new();
        let blur = fit.parameters.iter().zip(fit.values());
        for (k, (id, value)) in blur.enumerate().take(fit.blur_parameters()) {
            let at_angle = |i: usize| {
                let shot = scene.shots.get(i);
                let apart = shot.zip(id.incidence_deg);
                apart.is_none_or(|(shot, deg)| shot.incidence_deg == deg)
            };
            let photographs = (0..self.each.len().min(scene.shots.len()))
                .filter(|&i| at_angle(i))
                .map(|i| &self.each[i]);
            let own: Vec<f64> = photographs
                .chain(&self.halves)
                .map(|change| change[k])
                .filter(|change| change.is_finite())
                .collect();
            let ratio = variance(&own) * (value.value / value.standard_error).powi(2);
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
fn variance(without: &[f64]) -> f64 {
    let n = without.len() as f64;
    let mean = without.iter().sum::<f64>() / n;
    let squares: f64 = without.iter().map(|v| (v - mean).powi(2)).sum();
    squares * (n - 1.0) / n
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Pixels;
    use crate::estimate::choice::{Choice, Value};
    use crate::estimate::fitted::estimate;
    use crate::estimate::loss::Kind;
    use crate::estimate::optimum::{optimum, refined};
    use crate::names::{Kernel, LobeShape};
    use crate::tests::planted::{SHARED, camera, fitted, params, scene, table, truth};
    use rayon::prelude::*;

    /// Two halves of one photograph scatter by the noise: half of their distance is a standard
    /// error. The mean square of its ratio to the stated error is chi-square over its number, with
    /// a standard deviation of sqrt(2/160) = 0.11; the limits are 4 of these. c and a of one
    /// photograph go together, so each has its own mean.
    #[test]
    #[ignore = "20 processor-seconds: `make test-full` runs it"]
    fn halves_of_a_photograph_scatter_by_its_noise() {
        const DRAWS: u64 = 160;
        let sheet = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.33, 0.5);
        let table = table(&sheet, &[20.0], 20.0);
        let ratios = (0..DRAWS).into_par_iter().map(|seed| {
            let shots = params(seed, sheet.clone(), &[20.0], &[200.0], camera(2e4));
            let scene = scene(&shots, &table);
            let fit = fitted(&scene, SHARED, Kind::Edge);
            let at = fit.solution.parameters.rows(0, 2).into_owned();
            let loss = Loss::new(Kind::Edge, &scene, (SHARED, &at));
            let layout = Layout::new(SHARED, 1);
            let LeftOut { each, halves } = LeftOut::all(&scene, &loss, &layout, &fit);
            assert_eq!((each.len(), halves.len()), (2, 2));
            let off = |k: usize, value: &Value| {
                0.5 * (halves[0][k] - halves[1][k]) * value.value / value.standard_error
            };
            let of = fit.values().take(2).enumerate();
            of.map(|(k, value)| off(k, value)).collect::<Vec<f64>>()
        });
        let ratios: Vec<Vec<f64>> = ratios.collect();
        let allowed = 4.0 * (2.0 / DRAWS as f64).sqrt();
        for k in 0..2 {
            let mean = ratios.iter().map(|r| r[k] * r[k]).sum::<f64>() / DRAWS as f64;
            println!("mean square of parameter {k}: {mean:.3}");
            assert!((mean - 1.0).abs() < allowed, "{k}: {mean}");
        }
    }

    /// The probabilities are those of the photographs' own sums, by the closed forms of a sum of
    /// squares and of the least of n numbers, 1 - (1 - p)^n. All are taken from the same sums, so
    /// rounding alone differs.
    #[test]
    fn chances_are_those_of_the_photographs_sums() {
        let angles = [5.0, 30.0];
        let sheet = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.33, 0.5);
        let table = table(&sheet, &angles, 20.0);
        let shots = params(7, sheet, &angles, &[150.0, 250.0], camera(2e4));
        let scene = scene(&shots, &table);
        let mut cases = 0;
        for kind in [Kind::Mtf, Kind::Edge] {
            let near = optimum(&scene, SHARED);
            let loss = Loss::new(kind, &scene, (SHARED, &near.solution.parameters));
            let fit = estimate(&scene, &loss, refined(&scene, &loss, near));
            let found = of(&scene, &loss, &fit);
            let layout = Layout::new(SHARED, scene.groups.len());
            let own = loss.remainders(&layout, &fit.solution.parameters);
            let photographs = if kind == Kind::Edge { 5 } else { 4 };
            assert_eq!(own.len(), photographs);
            let chances = own
                .iter()
                .map(|own| chance::of_squares(own.squares, own.freedom));
            let least = chances.fold(1.0, f64::min);
            let squares = |all: &dyn Fn(&Remainder) -> Vec<f64>| {
                let all: Vec<f64> = own.iter().flat_map(all).collect();
                chance::of_squares(all.iter().map(|v| v * v).sum(), all.len())
            };
            let scatter = fit.scatter.as_ref().expect("there is a reference");
            let expected = [
                chance::of_squares(fit.chi2, fit.residuals - 2),
                squares(&|own| own.across.clone()),
                squares(&|own| own.along.clone()),
                1.0 - (1.0 - least).powi(photographs as i32),
                chance::of_squares(scatter.squares(), 3),
            ];
            let Chances {
                chi2,
                across,
                along,
                photograph,
                light,
            } = found.chances;
            println!("{:?}, least {least}", found.chances);
            for (found, expected) in [chi2, across, along, photograph, light]
                .into_iter()
                .zip(expected)
            {
                assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
                cases += 1;
            }
            // All squares are those of the photographs.
            let sum: f64 = own.iter().map(|own| own.squares).sum();
            assert!(
                (sum / found.chi2 - 1.0).abs() < 1e-9,
                "{sum} {}",
                found.chi2
            );
            // Each bin of pixels has a mean, and a slope if its pixels are spread along the edge.
            // Place, turn, plateaus and two terms of the light are each photograph's own, and the
            // blur of the lens is common.
            let reference = scene.reference.as_ref().expect("there is one");
            let pixels = scene.shots.iter().map(|shot| &*shot.pixels);
            let numbers = |pixels: &Pixels| -> usize {
                let bins = pixels.bins.iter();
                bins.map(|bin| 1 + usize::from(bin.spread > 0.0)).sum()
            };
            let all: usize = pixels.chain([&reference.pixels]).map(numbers).sum();
            let mtfs = scene
                .shots
                .iter()
                .map(|shot| shot.view.mtf.modulus.len() - 1);
            let (numbers, lens) = match kind {
                Kind::Edge => (all - 6 * photographs, scene.optics.lens.len()),
                _ => (mtfs.sum(), 0),
            };
            assert_eq!(own.iter().map(|own| own.freedom).sum::<usize>(), numbers);
            assert_eq!(found.degrees_of_freedom, numbers - lens - 2);
        }
        assert_eq!(cases, 10);
    }

    /// A misfit raises the errors by the root of chi-square per degree of freedom, or by the
    /// jackknife if that is larger. Photographs of pairs of cubes with a table of single ones
    /// differ from one another. Photographs that are alike, fitted without their lobe, do not.
    #[test]
    fn a_misfit_raises_by_the_root_of_chi_square_or_by_the_jackknife() {
        let sheet = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.33, 0.5);
        let mut single = sheet.clone();
        single.pair = false;
        let shift = Choice {
            kernel: Kernel::Shift,
            ..SHARED
        };
        let mut larger = Vec::new();
        for (own, angles, distances, choice) in [
            (&single, &[5.0, 30.0][..], &[150.0, 250.0][..], SHARED),
            (&sheet, &[20.0], &[200.0; 4], shift),
        ] {
            let table = table(own, angles, 20.0);
            let shots = params(7, sheet.clone(), angles, distances, camera(1e6));
            let scene = scene(&shots, &table);
            let loss = Loss::Mtf(&scene);
            let fit = estimate(&scene, &loss, optimum(&scene, choice));
            let found = of(&scene, &loss, &fit);
            let layout = Layout::new(choice, scene.groups.len());
            let jackknife = LeftOut::all(&scene, &loss, &layout, &fit).scale(&scene, &fit);
            let freedom = fit.residuals - layout.parameters();
            let by_chi2 = (fit.chi2 / freedom as f64).sqrt();
            println!("{} of {by_chi2} and {jackknife}", found.scale);
            assert!((found.scale / by_chi2.max(jackknife) - 1.0).abs() < 1e-12);
            assert_eq!(found.verdict, Verdict::Poor);
            larger.push(by_chi2 > jackknife);
        }
        assert_eq!(larger, [false, true]);
    }

    /// A photograph that is left out changes the parameters as a fit to the others does. The change
    /// is the first step of Gauss and Newton, which errs by the change times how much the
    /// information of the others moves with it: a few percent for changes of about a standard
    /// error, in photographs whose errors are some percent. A tenth is allowed.
    ///
    /// The jackknife of these changes is the factor on the errors: for c over all photographs, for
    /// the a of each incidence over its own, of which the root mean square counts.
    #[test]
    fn photographs_left_out_move_the_estimate_as_fits_without_them() {
        let angles = [5.0, 30.0];
        let mut cases = 0;
        for (kernel, per_angle_a) in [(Kernel::Eq1, false), (Kernel::Lobe, true)] {
            let sheet = truth(kernel, LobeShape::Radial, 3.4, 0.33, 0.5);
            let table = table(&sheet, &angles, 20.0);
            let shots = params(7, sheet, &angles, &[150.0, 200.0, 250.0], camera(2e4));
            let scene = scene(&shots, &table);
            let choice = Choice {
                kernel,
                per_angle_a,
                ..SHARED
            };
            let first = usize::from(kernel.has_c());
            let fit = fitted(&scene, choice, Kind::Mtf);
            let at = &fit.solution.parameters;
            let loss = Loss::Mtf(&scene);
            let layout = Layout::new(choice, scene.groups.len());
            let left_out = LeftOut::all(&scene, &loss, &layout, &fit);
            let errors: Vec<f64> = fit
                .values()
                .take(at.len())
                .map(|value| value.standard_error / value.value)
                .collect();
            // Changes by fits, in standard errors.
            let mut all = vec![Vec::new(); at.len()];
            for (i, change) in left_out.each.iter().enumerate() {
                let other = fitted(&scene.without(i), choice, Kind::Mtf);
                let mut most = 0.0_f64;
                for k in 0..at.len() {
                    let expected = (other.solution.parameters[k] - at[k]) / errors[k];
                    let found = change[k] / errors[k];
                    println!("{i} {k}: {found:+.3} {expected:+.3}");
                    assert!(
                        (found - expected).abs() < 0.1 * expected.abs() + 0.02,
                        "{i} {k}"
                    );
                    most = most.max(expected.abs());
                    if k < first || !per_angle_a || scene.shots[i].group == k - first {
                        all[k].push(expected);
                    }
                    cases += 1;
                }
                let moved = left_out.moved(i, &fit).expect("it is one of them");
                assert!((moved - most).abs() < 0.1 * most + 0.02, "{moved} {most}");
            }
            let squares: Vec<f64> = all
                .iter()
                .map(|own| {
                    let n = own.len() as f64;
                    let mean = own.iter().sum::<f64>() / n;
                    own.iter().map(|v| (v - mean).powi(2)).sum::<f64>() * (n - 1.0) / n
                })
                .collect();
            let (of_c, of_a) = squares.split_at(first);
            let of_a = of_a.iter().sum::<f64>() / of_a.len() as f64;
            let expected = of_c.iter().fold(of_a, |most, &own| most.max(own)).sqrt();
            let scale = left_out.scale(&scene, &fit);
            println!("jackknife {scale:.3} {expected:.3}");
            assert!((scale / expected - 1.0).abs() < 0.1, "{scale} {expected}");
        }
        assert_eq!(cases, 6 * (2 + 2));
    }

    /// The jackknife of a mean is its standard error: that of 1, 2, 6 is sqrt(7/3). Without one
    /// each the means are 4, 3.5 and 1.5.
    #[test]
    fn jackknife_of_a_mean_is_its_variance() {
        assert!((variance(&[4.0, 3.5, 1.5]) - 7.0 / 3.0).abs() < 1e-14);
    }
}
