//! The choice of the terms: of all candidates the simplest one that no other clearly beats.
//!
//! The criterion is Bayes' (BIC). Its n is the number of independent numbers. For the MTFs these
//! are the differences after whitening with their noise covariance, so that neighbouring
//! frequencies, which share pixels, do not count twice. For `edge` they are two numbers for each
//! bin of pixels and not all pixels, because most pixels of a bin repeat one another. A further
//! term must lower the criterion by more than [`CLEAR`].
//!
//! If no candidate describes the photographs to their noise, all sums of squares are divided by the
//! least chi-square per degree of freedom (Burnham and Anderson, Model Selection, 2002, 2.5).
//! Otherwise an error that all candidates share would add terms.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use tables::Table;

use crate::error::{Conflict, Error};
use crate::estimate::progress::{Cancelled, Progress, Step};
use crate::estimate::scene::Scene;
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::further;
use crate::estimate::search::layout::Choice;
use crate::estimate::search::layout::Layout;
use crate::estimate::search::loss::{Kind, Loss};
use crate::estimate::search::optimum::{Optimum, refined, unrefined, widened};
use crate::estimate::search::tried::{Tried, approached, misfit, share_c, spare};
use crate::model::Further;
use crate::model::wave;
use crate::samples::has_samples;
use edges::names::Kernel;
use edges::names::LobeShape;

/// Fall of the criterion below which the simpler candidate is kept.
///
/// The criterion is -2 ln of a candidate's probability by these photographs. So a fall of 4 stands
/// for odds of e^2 = 7 to 1: the middle of what Kass and Raftery (J. Am. Stat. Assoc. 90, 773,
/// 1995) call positive evidence. This limit is a convention.
///
/// The convention has two costs. A parameter that the photographs do not need is kept if noise
/// lowers the sum of squares by more than ln n + 4: in 3 of 1000 campaigns of n = 100 numbers, and
/// in 1 of 1000 of n = 1000. A parameter that they need is left out if it lies within 2.9 (n = 100)
/// or 3.3 (n = 1000) standard deviations of having no effect.
pub const CLEAR: f64 = 4.0;

/// Ratio to the best first criterion above which a candidate is not refined. Its criterion in the
/// report is then accurate to a thousandth, or to some percent if it is far behind. This is a
/// convention that saves time. It loses a candidate that is so far behind by the MTFs and would win
/// by the pixels.
pub(super) const HOPELESS: f64 = 3.0;

/// Terms among which the photographs decide. Each combination is a candidate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidates {
    /// Kernels, in the order of preference among equals.
    pub kernels: Vec<Kernel>,
    /// Lobe shapes.
    pub shapes: Vec<LobeShape>,
    /// Lobe shapes that join them where no candidate describes the photographs, if one with them
    /// comes far nearer.
    pub spare_shapes: Vec<LobeShape>,
    /// `Some(true)` for one spread per incidence, `Some(false)` for one spread for all, `None` to
    /// try both.
    pub per_angle_a: Option<bool>,
    /// `Some(true)` for one mu per incidence, `Some(false)` for one mu for all, `None` to decide by
    /// the photographs.
    pub per_angle_mu: Option<bool>,
}

impl Candidates {
    /// Returns all terms of the proposed model with its first lobe shape alone.
    pub fn proposed() -> Candidates {
        Candidates {
            kernels: Kernel::ALL.to_vec(),
            shapes: vec![LobeShape::ALL[0]],
            spare_shapes: Vec::new(),
            per_angle_a: None,
            per_angle_mu: None,
        }
    }

    /// Returns the candidates that have samples.
    ///
    /// # Errors
    /// Returns `Conflict::PixelsBySamples` if `loss` is `edge`, and `Conflict::NoSamples` if no
    /// candidate has samples.
    pub fn with_samples(mut self, loss: Option<Kind>) -> Result<Candidates, Conflict> {
        if loss == Some(Kind::Edge) {
            return Err(Conflict::PixelsBySamples);
        }
        self.kernels.retain(|&kernel| has_samples(kernel));
        if self.kernels.is_empty() {
            return Err(Conflict::NoSamples);
        }
        Ok(self)
    }

    /// Returns the candidates that the photographs and the table allow, with warnings.
    ///
    /// `wave` needs wavelengths and polygons. It is scalar, so of cubes that reflect totally it is
    /// taken only if it is the only kernel. A warning says why it is left out if wavelengths are
    /// given. `saito-surface` needs a front face. It is left out without a warning.
    ///
    /// # Errors
    /// Returns [`Error::Wave`] if `wave` is the only kernel and cannot be computed, and
    /// [`Error::Hollow`] if `guo` is the only kernel and the cubes are hollow.
    pub fn possible(
        &self,
        scene: &Scene,
        table: &Table,
        manifest: &Path,
    ) -> Result<(Candidates, Vec<String>), Error> {
        let (mut candidates, mut warnings) = (self.clone(), Vec::new());
        let hollow = scene
            .shots
            .iter()
            .any(|shot| shot.direction.refractive_index <= 1.0);
        if hollow && candidates.kernels == [Kernel::Guo] {
            return Err(Error::Hollow(manifest.to_owned()));
        }
        if hollow {
            let front = |kernel: &Kernel| *kernel == Kernel::SaitoSurface;
            candidates.kernels.retain(|kernel| !front(kernel));
        }
        if candidates.kernels.contains(&Kernel::Wave)
            && let Err(fault) = scene.waves()
        {
            if candidates.kernels == [Kernel::Wave] {
                return Err(Error::Wave(manifest.to_owned(), fault));
            }
            candidates.kernels.retain(|&kernel| !kernel.has_waves());
            if fault != wave::Fault::NoWavelength {
                warnings.push(format!(
                    "the wave kernel is not among the candidates: {fault}"
                ));
            }
        }
        if candidates.kernels.contains(&Kernel::Wave)
            && candidates.kernels.len() > 1
            && wave::lacks_polarisation(table)
        {
            candidates.kernels.retain(|&kernel| !kernel.has_waves());
            warnings.push(
                "the wave kernel is not among the candidates: the cubes of the table reflect totally \
                (back tir), and it does not hold how they turn the polarisation of light; bake it \
                again with this version"
                    .into(),
            );
        }
        Ok((candidates, warnings))
    }
}

/// Chosen candidate, and the comparison of all candidates.
pub struct Selection<'a> {
    /// Loss that was minimised.
    pub loss: Loss<'a>,
    /// Candidate and parameters near the truth, from which the noise of the pixels was estimated.
    pub near: (Choice, DVector<f64>),
    /// Estimate of the chosen candidate.
    pub best: Estimate,
    /// All candidates, best criterion first.
    pub compared: Vec<Ranked>,
}

/// One row of the comparison.
#[derive(Debug, Clone)]
pub struct Ranked {
    /// The candidate.
    pub choice: Choice,
    /// Bayes' criterion.
    pub criterion: f64,
    /// Sum of squares of the residuals, in units of their noise.
    pub chi2: f64,
    /// Number of parameters of the blur.
    pub parameters: usize,
    /// Parameters of the blur at the optimum, in the order of [`Layout`].
    pub at: DVector<f64>,
}

impl Ranked {
    /// Returns whether this candidate is simpler than a choice with `parameters` parameters, or as
    /// simple and preferred. Such a candidate wins if neither is clearly better.
    pub fn precedes(&self, choice: Choice, parameters: usize) -> bool {
        let rank = |kernel| Kernel::ALL.iter().position(|&other| other == kernel);
        (self.parameters, rank(self.choice.kernel)) < (parameters, rank(choice.kernel))
    }
}

/// Fits all candidates and picks one.
///
/// The MTFs come first, whatever the loss. They find the neighbourhood of each candidate's optimum,
/// and the noise of the pixels is estimated from the best of these fits.
///
/// # Errors
/// Returns [`Error::NothingOpen`] if there is no candidate, and [`Error::Cancelled`] if the flag of
/// `progress` is set.
pub fn select<'a>(
    scene: &'a Scene,
    kind: Kind,
    open: &Candidates,
    progress: &Progress,
) -> Result<Selection<'a>, Error> {
    let choices = choices(scene, open);
    let (done, of) = (AtomicUsize::new(0), AtomicUsize::new(2 * choices.len()));
    let count = || {
        let done = 1 + done.fetch_add(1, Ordering::Relaxed);
        let of = of.load(Ordering::Relaxed);
        progress.done(Step::Candidates { done, of })
    };
    let coarsely = choices.into_par_iter().map(|choice| {
        let tried = Tried::new(scene, choice);
        count().map(|()| tried)
    });
    let mut tried: Vec<Tried> = coarsely.collect::<Result<_, Cancelled>>()?;
    let spare = spare(scene, open, misfit(tried.iter().map(Tried::best)));
    of.fetch_add(spare.len(), Ordering::Relaxed);
    tried.extend(spare);
    share_c(scene, &mut tried);
    let fits = approached(scene, &tried);
    let scale = misfit(&fits);
    let nearest = fits
        .iter()
        .min_by(|a, b| a.criterion(scale).total_cmp(&b.criterion(scale)))
        .ok_or(Error::NothingOpen)?;
    let least = nearest.criterion(scale);
    let nearest = further::nearer(scene, nearest);
    let near = (nearest.choice, nearest.solution.parameters);
    let loss = Loss::new(kind, scene, (near.0, &near.1));
    let finished = fits.into_par_iter().map(|fit| {
        let hopeful = fit.criterion(scale) <= HOPELESS * least + CLEAR;
        let finish = if hopeful { refined } else { unrefined };
        let fit = finish(scene, &loss, fit);
        count().map(|()| fit)
    });
    let mut fits: Vec<Optimum> = finished.collect::<Result<_, Cancelled>>()?;
    widen(scene, &loss, &mut fits);
    let scale = misfit(&fits);
    let compared = ranked(scene, &fits, scale);
    let least = compared.first().map_or(f64::NAN, |row| row.criterion);
    // The sort is stable, so equals keep their order of preference.
    fits.sort_by_key(|fit| fit.solution.parameters.len());
    let chosen = fits
        .iter()
        .position(|fit| fit.criterion(scale) <= least + CLEAR)
        .unwrap_or(0);
    let chosen = fits.swap_remove(chosen);
    let best = with_mu(scene, &loss, open, chosen);
    progress.done(Step::Chosen)?;
    Ok(Selection {
        loss,
        near,
        best,
        compared,
    })
}

/// Returns the estimate of a candidate, with one mu for all incidences unless the photographs need
/// more.
pub(super) fn with_mu(scene: &Scene, loss: &Loss, open: &Candidates, chosen: Optimum) -> Estimate {
    let shared_mu = Optimum {
        choice: Choice {
            per_angle_mu: false,
            ..chosen.choice
        },
        ..chosen.clone()
    };
    let best = estimate(scene, loss, chosen);
    if open.per_angle_mu.is_none() && best.choice.per_angle_mu && !needs_own_mu(scene, &best) {
        return estimate(scene, loss, shared_mu);
    }
    best
}

/// Returns the rows of all candidates, best criterion first.
fn ranked(scene: &Scene, fits: &[Optimum], scale: f64) -> Vec<Ranked> {
    let row = |fit: &Optimum| {
        let parameters = Layout::of(fit.choice, scene).parameters();
        Ranked {
            choice: fit.choice,
            criterion: fit.criterion(scale),
            chi2: fit.solution.sum_of_squares(),
            parameters,
            at: fit.solution.parameters.rows(0, parameters).into_owned(),
        }
    };
    let mut rows: Vec<Ranked> = fits.iter().map(row).collect();
    rows.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    rows
}

/// Fits a candidate with one spread per incidence again if the same one with one spread for all is
/// better: it holds the other, so its search has ended too early.
fn widen(scene: &Scene, loss: &Loss, fits: &mut [Optimum]) {
    for i in 0..fits.len() {
        let wide = &fits[i];
        let narrow = Choice {
            per_angle_a: false,
            ..wide.choice
        };
        let within = fits.iter().find(|fit| fit.choice == narrow);
        let Some(within) = within.filter(|_| wide.choice.per_angle_a) else {
            continue;
        };
        if within.solution.sum_of_squares() < wide.solution.sum_of_squares() {
            fits[i] = widened(scene, loss, within);
        }
    }
}

pub(super) fn choices(scene: &Scene, open: &Candidates) -> Vec<Choice> {
    let several = scene.groups.len() > 1;
    let sharings = match open.per_angle_a {
        Some(per_angle) => vec![per_angle],
        None if several => vec![false, true],
        None => vec![false],
    };
    let mut choices = Vec::new();
    for &kernel in &open.kernels {
        // Without a lobe there is one candidate, because shape and sharing have no effect.
        let shapes = if kernel.has_lobe() {
            &open.shapes[..]
        } else {
            &open.shapes[..open.shapes.len().min(1)]
        };
        let sharings = if kernel.has_lobe() {
            &sharings[..]
        } else {
            &sharings[..1]
        };
        for &shape in shapes {
            for &per_angle_a in sharings {
                choices.push(Choice {
                    kernel,
                    shape,
                    per_angle_a,
                    per_angle_mu: open.per_angle_mu.unwrap_or(several),
                    further: Further::NONE,
                });
            }
        }
    }
    choices
}

/// Returns whether the mu of the incidences differ by more than their errors, by the criterion of
/// [`own_mu_limit`].
pub fn needs_own_mu(scene: &Scene, fit: &Estimate) -> bool {
    let Some(mu) = fit.mu.as_ref().filter(|mu| mu.len() > 1) else {
        return false;
    };
    let first = fit.parameters.len() - mu.len();
    let values: Vec<f64> = mu.iter().map(|mu| mu.value).collect();
    let covariance = DMatrix::from_fn(mu.len(), mu.len(), |i, j| {
        fit.covariance[(first + i, first + j)] / (values[i] * values[j])
    });
    let limit = own_mu_limit(mu.len(), scene.shots.len());
    // A misfit of the photographs scatters mu too.
    let misfit = fit.reduced_chi2().max(1.0);
    scatter_of_mu(&values, &covariance).is_none_or(|squares| squares > misfit * limit)
}

/// Returns the sum of squares of the differences of ln mu between the incidences, in units of their
/// noise, or `None` if the covariance is singular. `covariance` is that of ln mu.
pub fn scatter_of_mu(mu: &[f64], covariance: &DMatrix<f64>) -> Option<f64> {
    let rest = mu.len() - 1;
    // In differences to the first value the errors that all share (reference, lens) cancel.
    let difference = DVector::from_fn(rest, |i, _| (mu[i + 1] / mu[0]).ln());
    let covariance = DMatrix::from_fn(rest, rest, |i, j| {
        let of = |i, j| covariance[(i, j)];
        of(i + 1, j + 1) - of(i + 1, 0) - of(0, j + 1) + of(0, 0)
    });
    let factor = covariance.cholesky()?;
    Some(difference.dot(&factor.solve(&difference)))
}

/// Returns the sum of squares above which each of `groups` incidences has its own mu:
/// ln(photographs) for each further parameter, plus [`CLEAR`].
pub fn own_mu_limit(groups: usize, photographs: usize) -> f64 {
    (groups - 1) as f64 * (photographs as f64).ln() + CLEAR
}
