//! Suspects: mistakes that would explain a fit that does not describe its photographs.
//!
//! Each suspect is tried to first order by the MTFs (`trial`), which takes a small part of a fit.
//! The likeliest are fitted: the scene is made as it would be without the mistake, and the candidate
//! is fitted again, first to the MTFs. The best few are fitted by the loss of the estimate, and the
//! sums of squares are compared. A suspect is named if the sum of squares falls by at least half of
//! its excess, by more than chance allows, and if no other one explains the photographs far better.
//! Other kernels and lobes come first. If one of them leaves no misfit, no mistake is searched for.
//! A good fit with a further blur is searched from the fit without it: a mistake may look like a blur.
//!
//! The search may have a limit of time. Its order does not depend on the time, so a search that
//! comes to its end is always the same one. [`Diagnosis`] says whether it did.

mod alternatives;
mod distance;
mod light;
mod trial;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tables::Table;

use crate::estimate::progress::{Cancelled, Progress, Step};
use crate::estimate::scene::perturbed::{Conditions, OtherIndex};
use crate::estimate::scene::{Aerial, Scene, Source};
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::loss::{Kind, Loss};
use crate::estimate::search::optimum::{Optimum, ROUGH, refined, refined_to, rough, rough_from};
use crate::estimate::search::select::Ranked;
use crate::estimate::search::start::Start;
use crate::estimate::trust::goodness;
use crate::estimate::trust::goodness::{Goodness, Verdict};
use crate::estimate::trust::suspects::trial::Trials;
use edges::numerics::Stop;
use edges::photographs::Campaign;

/// Fall of the sum of squares below which a suspect is not named.
///
/// Noise reaches it in one of 10^5 fits, and some hundred suspects are tried.
const SURE: f64 = 20.0;

/// Share of the excess of the sum of squares that a suspect has to explain.
const EXPLAINED: f64 = 0.5;

/// Number of suspects that are fitted to the MTFs, after the trials to first order.
const LIKELIEST: usize = 16;

/// Number of suspects that are fitted by the loss of the estimate.
const BEST: usize = 4;

/// Tolerance of these fits. Sums of squares that are equal then agree to far less than noise moves
/// them.
const FINE: f64 = 1e-6;

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
    /// Verdict on the fit without the mistake; null in older results.
    #[serde(default)]
    pub verdict_if_so: Option<Verdict>,
    /// What the mistake would explain.
    #[serde(default)]
    pub explains: Explains,
}

/// What a suspect would explain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Explains {
    /// A misfit.
    #[default]
    Misfit,
    /// Why mu differs between the incidences of a good fit.
    DifferingMu,
    /// What a good fit takes for a further blur.
    FurtherBlur,
}

impl Suspect {
    /// Returns whether noise explains what is left without the mistake.
    pub fn leaves_noise(&self) -> bool {
        self.verdict_if_so == Some(Verdict::Good)
    }
}

/// How far the search for suspects went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// True if the search came to its end, or if a good fit needed none; false if its time was over
    /// before.
    pub complete: bool,
    /// Number of suspects that were tried.
    pub tried: usize,
    /// Number of suspects that were to be tried, as far as the search went.
    pub of: usize,
}

impl Diagnosis {
    /// Diagnosis of a fit that needs no search.
    pub(crate) const NOT_NEEDED: Diagnosis = Diagnosis {
        complete: true,
        tried: 0,
        of: 0,
    };

    /// Diagnosis before a search, or without one.
    pub(crate) const NOT_MADE: Diagnosis = Diagnosis {
        complete: false,
        ..Diagnosis::NOT_NEEDED
    };
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
#[derive(Clone, Copy)]
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
    /// Fit without the further blurs, if `fit` has some.
    pub unblurred: Option<&'a (Estimate, Goodness)>,
    pub progress: &'a Progress<'a>,
    /// Time at which the search ends; `None` if it has no limit.
    pub until: Option<Instant>,
}

/// Count of a search.
#[derive(Default)]
struct Tally {
    done: AtomicUsize,
    of: AtomicUsize,
    /// True if the time was over before the end.
    cut: AtomicBool,
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
    /// True for another blur: the estimate may be far from it, so it is fitted from the starting points
    /// of a first fit too.
    is_blur: bool,
}

/// Suspect that explains a misfit.
struct Named {
    suspect: Suspect,
    /// Sum of squares that it leaves, less its degrees of freedom, plus the cost of the
    /// alternative.
    left: f64,
    /// Place among the suspects, which decides between equals: some mistakes cannot be told apart.
    order: usize,
}

/// Fit of an alternative to the MTFs.
struct Outcome {
    /// Sum of squares, less its degrees of freedom.
    excess: f64,
    fit: Optimum,
}

impl Tally {
    fn into_diagnosis(self) -> Diagnosis {
        Diagnosis {
            complete: !self.cut.into_inner(),
            tried: self.done.into_inner(),
            of: self.of.into_inner(),
        }
    }
}

impl Search<'_> {
    /// Returns the mistakes that would explain the misfit, the best first. If the fit is good, they
    /// would explain its further blur as well, or else why mu differs between the incidences, which
    /// is looked at if `mu_was_open`.
    ///
    /// # Errors
    /// Returns [`Cancelled`] if the flag of the progress is set.
    pub(crate) fn suspects(
        &self,
        mu_was_open: bool,
    ) -> Result<(Vec<Suspect>, Diagnosis), Cancelled> {
        if self.goodness.verdict == Verdict::Good {
            let (mut found, diagnosis) = self.instead_of_further_blurs()?;
            if found.is_empty() && mu_was_open {
                found = self.of_differing_mu();
            }
            return Ok((found, diagnosis));
        }
        if self.goodness.reduced > 0 {
            // The camera is the mistake.
            return Ok((Vec::new(), Diagnosis::NOT_NEEDED));
        }
        let tally = Tally::default();
        // A baseline seldom has the shape of the blur, so the least misfit is no sign of a mistake.
        let mut found = if self.goodness.scale > 1.0 && !self.fit.choice.kernel.is_baseline() {
            self.of_blur(&self.not_tried(), [0.0; 2], &tally)?
        } else {
            Vec::new()
        };
        // What is left of a wrong blur moves the levels of light too.
        if found.is_empty() && !self.is_over(&tally) {
            let mut light: Vec<Named> = self.exposure().into_iter().collect();
            if self.goodness.scale <= 1.0 {
                light.extend(self.of_light(&tally)?);
            }
            found = comparable(light);
        }
        Ok((found, tally.into_diagnosis()))
    }

    /// Returns the mistakes that explain the photographs as well as the further blurs of a good fit.
    ///
    /// A mistake may look like a blur: a turned axis, or the table of another cell.
    fn instead_of_further_blurs(&self) -> Result<(Vec<Suspect>, Diagnosis), Cancelled> {
        let Some((fit, goodness)) = self.unblurred else {
            return Ok((Vec::new(), Diagnosis::NOT_NEEDED));
        };
        let tally = Tally::default();
        let unblurred = Search {
            fit,
            goodness,
            ..*self
        };
        // What noise and model leave, however many photographs there are.
        let own = self.excess();
        let by_mtfs = refined_to(
            ROUGH,
            self.scene,
            &Loss::Mtf(self.scene),
            self.fit.optimum(),
        );
        let floor = [freed(&by_mtfs, self.scene), own];
        let mut found = unblurred.of_blur(&[], floor, &tally)?;
        found.retain(|other| {
            let left = other.chi2_if_so - other.degrees_of_freedom_if_so as f64;
            other.leaves_noise() && left - own <= SURE
        });
        for other in &mut found {
            other.explains = Explains::FurtherBlur;
        }
        Ok((found, tally.into_diagnosis()))
    }

    /// Returns whether the time is over, and notes it.
    fn is_over(&self, tally: &Tally) -> bool {
        let over = self.until.is_some_and(|until| Instant::now() >= until);
        tally.cut.fetch_or(over, Ordering::Relaxed);
        over
    }

    /// Counts `suspects` as tried.
    fn done(&self, tally: &Tally, suspects: usize) -> Result<(), Cancelled> {
        for _ in 0..suspects {
            let done = 1 + tally.done.fetch_add(1, Ordering::Relaxed);
            let of = tally.of.load(Ordering::Relaxed);
            self.progress.done(Step::Suspects { done, of })?;
        }
        Ok(())
    }

    /// Returns the excess of the sum of squares over its degrees of freedom.
    fn excess(&self) -> f64 {
        self.goodness.chi2 - self.goodness.degrees_of_freedom as f64
    }

    /// Returns the mistakes that would explain the misfit of the blur. If one of these `blurs` leaves
    /// none, no mistake is looked for. `floor` is the excess without a misfit, by the MTFs and by the
    /// loss.
    fn of_blur(
        &self,
        blurs: &[Alternative],
        floor: [f64; 2],
        tally: &Tally,
    ) -> Result<Vec<Suspect>, Cancelled> {
        let Some(now) = self.at_least(self.scene, &[self.fit.choice]) else {
            return Ok(Vec::new());
        };
        tally.of.fetch_add(blurs.len(), Ordering::Relaxed);
        let mut named = self.named((now.excess, floor), blurs, tally)?;
        if !named.iter().any(|own| own.suspect.leaves_noise()) {
            let likeliest = self.likeliest(&now, tally)?;
            named.extend(self.named((now.excess, floor), &likeliest, tally)?);
        }
        Ok(comparable(named))
    }

    /// Returns the mistakes of the manifest that a step by the MTFs finds likeliest, and those that
    /// have no such step. `now` is the fit with the mistake. The others count as tried.
    fn likeliest(&self, now: &Outcome, tally: &Tally) -> Result<Vec<Alternative>, Cancelled> {
        let stated = self.stated();
        tally.of.fetch_add(stated.len(), Ordering::Relaxed);
        let others = self
            .fuller()
            .into_iter()
            .filter(|&own| own != now.fit.choice);
        let others = others.filter_map(|choice| self.at_least(self.scene, &[choice]));
        let others: Vec<Outcome> = others.collect();
        let bases = std::iter::once(now).chain(&others);
        let trials: Vec<Trials> = bases
            .map(|base| Trials::new(self.scene, &base.fit))
            .collect();
        let told = |own: &Otherwise| {
            let told = trials.iter().filter_map(|trials| trials.excess(own));
            told.min_by(f64::total_cmp)
        };
        let mut all = self.first(&stated, tally, told)?;
        let fitted = all.len();
        if !self.is_over(tally) {
            self.decoded_otherwise(&mut all);
            self.other_origin(&mut all);
            self.alone(&mut all);
        }
        tally.of.fetch_add(all.len() - fitted, Ordering::Relaxed);
        Ok(all)
    }

    /// Returns those of the mistakes of which `told`, which returns what a mistake leaves, promises
    /// most. The others count as tried.
    fn first(
        &self,
        stated: &[Otherwise],
        tally: &Tally,
        told: impl Fn(&Otherwise) -> Option<f64> + Sync,
    ) -> Result<Vec<Alternative>, Cancelled> {
        let left = |(i, own): (usize, &Otherwise)| {
            (!self.is_over(tally))
                .then(|| Some((told(own)?, i)))
                .flatten()
        };
        let mut order: Vec<(f64, usize)> = stated.par_iter().enumerate().filter_map(left).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        order.truncate(LIKELIEST);
        order.sort_by_key(|&(_, i)| i);
        if !tally.cut.load(Ordering::Relaxed) {
            self.done(tally, stated.len() - order.len())?;
        }
        let made = order.into_iter().filter_map(|(_, i)| {
            let own = &stated[i];
            let scene = self.made(own)?;
            Some(self.alternative(own.what.clone(), own.captures.clone(), scene))
        });
        Ok(made.collect())
    }

    /// Returns the scene as it would be otherwise, or `None` if the table lacks a direction.
    fn made(&self, otherwise: &Otherwise) -> Option<Scene> {
        let is_own = otherwise.index.is_none() && std::ptr::eq(otherwise.table, self.table);
        let pairs = self.scene.shots.iter().zip(&otherwise.conditions);
        let one = |(shot, conditions): (&Aerial, &Conditions)| {
            if is_own && shot.conditions() == *conditions {
                return Some(shot.clone());
            }
            let moved = self
                .scene
                .moved(shot, otherwise.table, otherwise.index, conditions);
            moved.ok()
        };
        let shots = pairs.map(one).collect::<Option<_>>()?;
        Some(self.scene.with(shots))
    }

    /// Returns those of the alternatives that explain the misfit of the blur. The MTFs have the
    /// excess `now` with the mistake. `floor` is the excess without a misfit, by the MTFs and by the
    /// loss.
    fn named(
        &self,
        (now, floor): (f64, [f64; 2]),
        alternatives: &[Alternative],
        tally: &Tally,
    ) -> Result<Vec<Named>, Cancelled> {
        let tried = alternatives.par_iter().enumerate().map(|(order, own)| {
            if self.is_over(tally) {
                return Ok(None);
            }
            let found = if own.is_blur {
                self.at_least_anew(&own.scene, &own.choices)
            } else {
                self.at_least(&own.scene, &own.choices)
            };
            self.done(tally, 1)?;
            Ok(found.map(|found| (found.excess + own.cost, (order, own), found)))
        });
        let tried = tried.collect::<Result<Vec<_>, Cancelled>>()?;
        let enough =
            |now: f64, left: f64, floor: f64| now - left > SURE.max(EXPLAINED * (now - floor));
        let mut rough: Vec<(f64, (usize, &Alternative), Outcome)> =
            tried.into_iter().flatten().collect();
        rough.retain(|&(left, ..)| enough(now, left, floor[0]));
        rough.sort_by(|a, b| a.0.total_cmp(&b.0));
        rough.truncate(BEST);
        let excess = self.excess();
        let named = rough.into_par_iter().filter_map(|(_, (order, own), near)| {
            if self.is_over(tally) {
                return None;
            }
            let scene = &own.scene;
            let (loss, fit) = self.by_the_loss(scene, near)?;
            let left = freed(&fit, scene) + own.cost;
            enough(excess, left, floor[1]).then(|| {
                let fit = estimate(scene, &loss, fit);
                Named {
                    suspect: Suspect {
                        what: own.what.clone(),
                        captures: own.captures.clone(),
                        chi2_if_so: fit.chi2,
                        degrees_of_freedom_if_so: fit.degrees_of_freedom(),
                        verdict_if_so: Some(goodness::of(scene, &loss, &fit).verdict),
                        explains: Explains::Misfit,
                    },
                    left,
                    order,
                }
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
        let fits = choices.iter().map(|&choice| {
            let start = self.start(scene, choice);
            rough_from(ROUGH, scene, choice, vec![start])
        });
        least(scene, fits)
    }

    /// Does the same from the starting points of each candidate too.
    fn at_least_anew(&self, scene: &Scene, choices: &[Choice]) -> Option<Outcome> {
        if !scene.is_lit() {
            return None;
        }
        let anew = least(scene, choices.iter().map(|&choice| rough(scene, choice)));
        let found = self.at_least(scene, choices).into_iter().chain(anew);
        found.min_by(|a, b| a.excess.total_cmp(&b.excess))
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
        let count = Layout::of(choice, scene).spreads.max(1);
        Start {
            c_mm: fit.c_mm.map_or(0.2, |c| c.value),
            spread: vec![spread * to / from; count],
        }
    }

    /// Fits an alternative by the loss of the estimate, from a fit to the MTFs.
    fn by_the_loss<'s>(&self, scene: &'s Scene, near: Outcome) -> Option<(Loss<'s>, Optimum)> {
        let fit = near.fit;
        let (loss, fit) = if self.kind == Kind::Edge {
            let at = (fit.choice, &fit.solution.parameters);
            let loss = Loss::new(Kind::Edge, scene, at);
            let fit = refined_to(FINE, scene, &loss, fit);
            (loss, fit)
        } else {
            (Loss::Mtf(scene), refined(scene, &Loss::Mtf(scene), fit))
        };
        (fit.solution.stop != Stop::Failed && fit.solution.sum_of_squares().is_finite())
            .then_some((loss, fit))
    }
}

/// Returns the suspects that explain about as much as the best one, the best first.
fn comparable(mut named: Vec<Named>) -> Vec<Suspect> {
    named.sort_by(|a, b| {
        let whole = |own: &Named| own.left.round();
        whole(a).total_cmp(&whole(b)).then(a.order.cmp(&b.order))
    });
    let least = named.first().map_or(0.0, |best| best.left);
    named.retain(|own| own.left - least <= SURE.max(least));
    named.into_iter().map(|own| own.suspect).collect()
}

/// Returns the fit that leaves least, or `None` if all failed.
fn least(scene: &Scene, fits: impl Iterator<Item = Optimum>) -> Option<Outcome> {
    let fits = fits.filter(|fit| fit.solution.stop != Stop::Failed);
    let fits = fits.map(|fit| Outcome {
        excess: freed(&fit, scene),
        fit,
    });
    fits.filter(|fit| fit.excess.is_finite())
        .min_by(|a, b| a.excess.total_cmp(&b.excess))
}

/// Returns the sum of squares of a fit less its degrees of freedom.
fn freed(fit: &Optimum, scene: &Scene) -> f64 {
    fit.solution.sum_of_squares() - freedom(fit, scene) as f64
}

/// Returns the degrees of freedom of a fit. The observations are less the parameters of the lens
/// already.
fn freedom(fit: &Optimum, scene: &Scene) -> usize {
    let layout = Layout::of(fit.choice, scene);
    fit.observations.saturating_sub(layout.parameters())
}
