//! Suspects: mistakes that would explain a fit that does not describe its photographs.
//!
//! Each suspect is tried: the scene is made as it would be without the mistake, the candidate is
//! fitted again, and the sums of squares are compared. All suspects are fitted to the MTFs, which
//! is fast. The best few are fitted by the loss of the estimate. A suspect is named if the sum of
//! squares falls by at least half of its excess, by more than chance allows, and if no other one
//! explains the photographs far better. Other kernels and lobes are tried first. If one of them
//! leaves no misfit, no mistake is searched for.

mod alternatives;
mod light;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::DVector;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tables::Table;

use crate::estimate::fitted::Estimate;
use crate::estimate::goodness::{Goodness, Verdict};
use crate::estimate::layout::Choice;
use crate::estimate::layout::Layout;
use crate::estimate::loss::{Kind, Loss};
use crate::estimate::optimum::{Optimum, optimum, refined_to, rough_from};
use crate::estimate::perturbed::{Conditions, OtherIndex};
use crate::estimate::progress::{Cancelled, Progress, Step};
use crate::estimate::scene::{Scene, Source};
use crate::estimate::select::Ranked;
use crate::estimate::start::Start;
use edges::numerics::Stop;
use edges::photographs::Campaign;

/// Fall of the sum of squares below which a suspect is not named.
///
/// Noise reaches it in one of 10^5 fits, and some hundred suspects are tried.
const SURE: f64 = 20.0;

/// Share of the excess of the sum of squares that a suspect has to explain.
const EXPLAINED: f64 = 0.5;

/// Number of suspects that are fitted by the loss of the estimate.
const BEST: usize = 4;

/// Tolerance of these fits. Their sums of squares are then right to about its square.
const ROUGH: f64 = 1e-3;

/// Mistake that would explain a misfit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Suspect {
    /// The mistake, as a sentence.
    pub what: String,
    /// Photographs that it concerns; empty if it concerns all.
    pub captures: Vec<String>,
    /// Sum of squares of the fit without the mistake. If the mistake is an exposure, the sum of
    /// squares is that of the differences of light.
    pub chi2_if_so: f64,
    /// Degrees of freedom of that sum of squares.
    #[serde(default)]
    pub degrees_of_freedom_if_so: usize,
}

impl Suspect {
    /// Returns whether noise explains what is left without the mistake.
    pub fn leaves_noise(&self) -> bool {
        self.chi2_if_so - self.degrees_of_freedom_if_so as f64 <= self.noise()
    }

    /// Returns three standard deviations of the sum of squares, where only noise is left.
    ///
    /// A sum of n squares has the standard deviation sqrt(2 n). Noise goes beyond three of them in
    /// 2 of 1000 fits.
    fn noise(&self) -> f64 {
        3.0 * (2.0 * self.degrees_of_freedom_if_so as f64).sqrt()
    }
}

/// Table that is tried if the first one does not fit.
#[derive(Debug, Clone)]
pub struct OtherTable {
    /// Name of the table for messages.
    pub name: String,
    /// The table.
    pub table: Arc<Table>,
}

impl OtherTable {
    /// Reads a table, whose name is then its path.
    ///
    /// # Errors
    /// Fails if the file cannot be read as a table.
    pub fn read(path: &Path) -> Result<OtherTable, tables::Error> {
        Ok(OtherTable {
            name: path.display().to_string(),
            table: Arc::new(tables::read(path)?),
        })
    }
}

/// Inputs of the search.
pub(crate) struct Search<'a> {
    pub campaign: &'a Campaign,
    pub photo: &'a Source<'a>,
    pub table: &'a Table,
    pub others: &'a [OtherTable],
    /// Scene in closed form.
    pub scene: &'a Scene,
    pub kind: Kind,
    pub fit: &'a Estimate,
    /// Candidates that were compared.
    pub tried: &'a [Ranked],
    pub goodness: &'a Goodness,
    pub progress: &'a Progress<'a>,
}

/// Photographs as they would have been taken without a mistake.
struct Otherwise<'a> {
    what: String,
    captures: Vec<String>,
    table: &'a Table,
    /// Refractive index in place of the table's.
    index: Option<OtherIndex>,
    /// Conditions under which each photograph was taken.
    conditions: Vec<Conditions>,
}

/// One alternative to the campaign as the manifest states it.
struct Alternative {
    what: String,
    captures: Vec<String>,
    scene: Scene,
    choices: Vec<Choice>,
    /// Number of sums of squares that chance explains, such as by one more parameter.
    cost: f64,
}

/// Suspect that explains a misfit.
struct Named {
    suspect: Suspect,
    /// Sum of squares that it leaves, less its degrees of freedom, plus the cost of the
    /// alternative.
    left: f64,
}

/// Fit of an alternative to the MTFs.
struct Outcome {
    choice: Choice,
    /// Sum of squares, less its degrees of freedom.
    excess: f64,
    /// Parameters of the fit.
    at: DVector<f64>,
}

impl Search<'_> {
    /// Returns the mistakes that would explain the misfit, the best first. If the fit is good, they
    /// would explain why mu differs between the incidences, which is looked at if `mu_was_open`.
    ///
    /// # Errors
    /// Returns [`Cancelled`] if the flag of the progress is set.
    pub(crate) fn suspects(&self, mu_was_open: bool) -> Result<Vec<Suspect>, Cancelled> {
        if self.goodness.verdict == Verdict::Good {
            let differs = mu_was_open.then(|| self.of_differing_mu());
            return Ok(differs.unwrap_or_default());
        }
        if self.goodness.reduced > 0 {
            // The camera is the mistake.
            return Ok(Vec::new());
        }
        let found = self.of_blur()?;
        if !found.is_empty() {
            // What is left of a wrong blur moves the levels of light too.
            return Ok(found);
        }
        let mut light: Vec<Named> = self.exposure().into_iter().collect();
        if self.goodness.scale <= 1.0 {
            light.extend(self.of_light());
        }
        Ok(comparable(light))
    }

    /// Returns the mistakes that would explain the misfit of the blur.
    fn of_blur(&self) -> Result<Vec<Suspect>, Cancelled> {
        // A baseline seldom has the shape of the blur, so the least misfit is no sign of a mistake.
        if self.goodness.scale <= 1.0 || self.fit.choice.kernel.is_baseline() {
            return Ok(Vec::new());
        }
        let now = self
            .at_least(self.scene, &[self.fit.choice])
            .map_or(0.0, |of| of.excess);
        let blurs = self.not_tried();
        let mut named = self.named(now, &blurs, 0)?;
        if !named.iter().any(|own| own.left <= own.suspect.noise()) {
            named.extend(self.named(now, &self.alternatives(), blurs.len())?);
        }
        Ok(comparable(named))
    }

    /// Returns those of the alternatives that explain the misfit of the blur. The MTFs have the
    /// excess `now` with the mistake. `before` alternatives were tried before.
    fn named(
        &self,
        now: f64,
        alternatives: &[Alternative],
        before: usize,
    ) -> Result<Vec<Named>, Cancelled> {
        let (done, of) = (AtomicUsize::new(before), before + alternatives.len());
        let tried = alternatives.par_iter().map(|own| {
            let found = self.at_least(&own.scene, &own.choices);
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            self.progress.done(Step::Suspects { done, of })?;
            Ok(found.map(|found| (found.excess + own.cost, own, found.choice)))
        });
        let tried = tried.collect::<Result<Vec<_>, Cancelled>>()?;
        let enough = |left: f64| now - left > SURE.max(EXPLAINED * now);
        let mut rough: Vec<(f64, &Alternative, Choice)> = tried.into_iter().flatten().collect();
        rough.retain(|&(left, ..)| enough(left));
        rough.sort_by(|a, b| a.0.total_cmp(&b.0));
        rough.truncate(BEST);
        let by_mtf = self.kind != Kind::Edge;
        let excess = self.goodness.chi2 - self.goodness.degrees_of_freedom as f64;
        let named = rough.into_par_iter().filter_map(|(_, own, choice)| {
            let fit = self.by_the_loss(&own.scene, choice, by_mtf)?;
            let left = freed(&fit, &own.scene) + own.cost;
            let enough = excess - left > SURE.max(EXPLAINED * excess);
            enough.then(|| Named {
                suspect: Suspect {
                    what: own.what.clone(),
                    captures: own.captures.clone(),
                    chi2_if_so: fit.solution.sum_of_squares(),
                    degrees_of_freedom_if_so: freedom(&fit, &own.scene),
                },
                left,
            })
        });
        Ok(named.collect())
    }

    /// Fits the MTFs of a scene by each of these candidates, from the estimate, and returns the
    /// best. Returns `None` if no light returns in a photograph, or if the fits fail.
    fn at_least(&self, scene: &Scene, choices: &[Choice]) -> Option<Outcome> {
        if !scene.is_lit() {
            return None;
        }
        let fits = choices.iter().filter_map(|&choice| {
            let fit = rough_from(scene, choice, vec![self.start(scene, choice)]);
            (fit.solution.stop != Stop::Failed).then(|| Outcome {
                choice,
                excess: freed(&fit, scene),
                at: fit.solution.parameters,
            })
        });
        fits.filter(|fit| fit.excess.is_finite())
            .min_by(|a, b| a.excess.total_cmp(&b.excess))
    }

    /// Returns the estimate as the start of a candidate, with its mean spread.
    fn start(&self, scene: &Scene, choice: Choice) -> Start {
        let fit = self.fit;
        let spread = if fit.spread.is_empty() {
            4.0
        } else {
            fit.spread.iter().map(|v| v.value).sum::<f64>() / fit.spread.len() as f64
        };
        let from = fit.choice.kernel.distance_scale(scene.mean_distance_mm());
        let to = choice.kernel.distance_scale(scene.mean_distance_mm());
        let count = Layout::new(choice, scene.groups.len()).spreads.max(1);
        Start {
            c_mm: fit.c_mm.map_or(0.2, |c| c.value),
            spread: vec![spread * to / from; count],
        }
    }

    /// Fits an alternative by the loss of the estimate.
    fn by_the_loss(&self, scene: &Scene, choice: Choice, by_mtf: bool) -> Option<Optimum> {
        let near = optimum(scene, choice);
        if by_mtf {
            return Some(near);
        }
        let loss = Loss::new(Kind::Edge, scene, (choice, &near.solution.parameters));
        let fit = refined_to(ROUGH, scene, &loss, near);
        (fit.solution.stop != Stop::Failed && fit.solution.sum_of_squares().is_finite())
            .then_some(fit)
    }
}

/// Returns the suspects that explain about as much as the best one, the best first.
fn comparable(mut named: Vec<Named>) -> Vec<Suspect> {
    named.sort_by(|a, b| a.left.total_cmp(&b.left));
    let least = named.first().map_or(0.0, |best| best.left);
    named.retain(|own| own.left - least <= SURE.max(least));
    named.into_iter().map(|own| own.suspect).collect()
}

/// Returns the sum of squares of a fit less its degrees of freedom.
fn freed(fit: &Optimum, scene: &Scene) -> f64 {
    fit.solution.sum_of_squares() - freedom(fit, scene) as f64
}

/// Returns the degrees of freedom of a fit. The observations are less the parameters of the lens
/// already.
fn freedom(fit: &Optimum, scene: &Scene) -> usize {
    let layout = Layout::new(fit.choice, scene.groups.len());
    fit.observations.saturating_sub(layout.parameters())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum of 800 squares has the standard deviation 40, and noise stays within three of them.
    #[test]
    fn noise_leaves_three_standard_deviations() {
        for (left, noise) in [(700.0, true), (919.9, true), (920.1, false)] {
            let suspect = Suspect {
                what: String::new(),
                captures: Vec::new(),
                chi2_if_so: left,
                degrees_of_freedom_if_so: 800,
            };
            assert_eq!(suspect.leaves_noise(), noise, "{left}");
        }
    }
}
