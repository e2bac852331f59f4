//! A whole estimate: c, a and mu of a campaign, with their errors, bounds and warnings.

use std::borrow::Cow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::DVector;
use tables::Table;

use crate::compare::Weights;
use crate::error::{Conflict, Error};
use crate::estimate::progress::Progress;
use crate::estimate::scene::{Scene, Source};
use crate::estimate::search::azimuth::Azimuth;
use crate::estimate::search::bound::{Bounds, absent, bounds};
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::forward::Renders;
use crate::estimate::search::layout::{Choice, Value};
use crate::estimate::search::loss::{Kind, Loss};
use crate::estimate::search::optimum::refined;
use crate::estimate::search::select::{Candidates, Ranked, Selection, select};
use crate::estimate::search::{azimuth, cubes, further, hints};
use crate::estimate::trust::doubts::Doubted;
use crate::estimate::trust::goodness::{Goodness, Verdict};
use crate::estimate::trust::suspects::{Diagnosis, OtherTable, Search, Suspect};
use crate::estimate::trust::unverified::Unverified;
use crate::estimate::trust::{goodness, mirror, verdict};
use crate::model::{Further, polarised, wave};
use crate::samples::Sampling;
use edges::names::{Kernel, Spectrum};
use edges::numerics::Stop;
use edges::photographs::Campaign;
use edges::photographs::photo::channel::Channel;

/// Options of an estimate.
#[derive(Debug, Clone)]
pub struct Options {
    /// Candidates for the terms of the model.
    pub candidates: Candidates,
    /// Loss that is minimised. `None` stands for `edge`, or for `mtf` if the model is evaluated by
    /// samples.
    pub loss: Option<Kind>,
    /// Samples by which the model is evaluated, as published. `None` stands for the closed form.
    pub samples: Option<Sampling>,
    /// True to estimate the azimuth of the sheet too: one angle that is added to the azimuths of
    /// all captures (0 for captures without one).
    pub fit_azimuth: bool,
    /// Wavelengths of the source, instead of the campaign's.
    pub spectrum: Option<Spectrum>,
    /// Channel of all photographs, instead of the campaign's.
    pub channel: Option<Channel>,
    /// Tables that are tried if the first one does not fit.
    pub others: Vec<OtherTable>,
    /// Time that the search for suspects may take; `None` for no limit, 0 for no search.
    pub diagnose: Option<Duration>,
}

impl Options {
    /// Returns the options that `fit estimate` has by default, with these candidates.
    pub fn new(candidates: Candidates) -> Options {
        Options {
            candidates,
            loss: None,
            samples: None,
            fit_azimuth: false,
            spectrum: None,
            channel: None,
            others: Vec::new(),
            diagnose: None,
        }
    }

    /// Applies the options to a campaign: its channel, its spectrum, and azimuths where they are
    /// needed.
    fn applied(&self, campaign: &Campaign) -> Campaign {
        let mut campaign = match &self.channel {
            Some(channel) => campaign.in_channel(channel),
            None => campaign.clone(),
        };
        if let Some(spectrum) = &self.spectrum {
            campaign.setup.spectrum = Some(spectrum.clone());
        }
        if self.fit_azimuth {
            for capture in &mut campaign.captures {
                capture.azimuth_deg.get_or_insert(0.0);
            }
        }
        campaign
    }

    /// Checks that the options fit together, and returns the candidates that they allow.
    ///
    /// # Errors
    /// Returns [`Conflict::AzimuthOfAnother`] if the azimuth is wanted with samples or with a
    /// baseline, [`Conflict::PixelsBySamples`] if samples are wanted with the loss `edge`, and
    /// [`Conflict::NoSamples`] if no candidate has samples.
    fn checked(&self) -> Result<Candidates, Conflict> {
        let candidates = self.candidates.clone();
        let of_another = candidates.kernels.iter().any(|kernel| kernel.is_baseline());
        if self.fit_azimuth && (self.samples.is_some() || of_another) {
            return Err(Conflict::AzimuthOfAnother);
        }
        match self.samples {
            Some(_) => candidates.with_samples(self.loss),
            None => Ok(candidates),
        }
    }

    /// Returns the loss that is minimised.
    fn kind(&self) -> Kind {
        let default = match self.samples {
            Some(_) => Kind::Mtf,
            None => Kind::Edge,
        };
        self.loss.unwrap_or(default)
    }
}

/// Result of an estimate.
pub struct Estimated {
    /// Campaign as it was fitted, with the options applied.
    pub campaign: Campaign,
    /// Measured photographs of the campaign, as the estimate saw them.
    pub scene: Scene,
    /// Estimate of the chosen candidate.
    pub best: Estimate,
    /// All candidates, best criterion first.
    pub compared: Vec<Ranked>,
    /// Loss that was minimised.
    pub kind: Kind,
    /// One-sided bounds of the parameters that the photographs cannot determine.
    pub bounds: Bounds,
    /// Quality of the fit: whether the estimate describes the photographs.
    pub goodness: Goodness,
    /// Mistakes that would explain why it does not, the best first.
    pub suspects: Vec<Suspect>,
    /// How far the search for suspects went.
    pub diagnosis: Diagnosis,
    /// Azimuth of the sheet, if it was estimated.
    pub azimuth: Option<Azimuth>,
    /// Azimuth after which the cell of the table repeats itself, degrees.
    pub azimuth_period_deg: f64,
    /// Inputs that no photograph can check, with the effects of small errors of them.
    pub trusted: Vec<Unverified>,
    /// Warnings about the campaign as a whole, one sentence each.
    pub warnings: Vec<String>,
    /// Candidate and parameters from which the noise of the pixels was estimated.
    near: (Choice, DVector<f64>),
    /// Warnings that do not depend on the suspects.
    remarks: Vec<String>,
    /// True if the photographs decided whether mu differs between the incidences.
    mu_was_open: bool,
    /// Estimate without the further blurs, if the best one has some.
    unblurred: Option<(Estimate, Goodness)>,
}

impl Estimated {
    /// Returns whether [`Estimated::diagnose`] would search for suspects, which takes time.
    pub fn needs_diagnosis(&self, options: &Options) -> bool {
        let is_open = self.goodness.verdict != Verdict::Good || self.unblurred.is_some();
        is_open && options.diagnose != Some(Duration::ZERO)
    }

    /// Searches for the mistakes that would explain the misfit, and says them in the warnings. All
    /// arguments are those of the estimate.
    ///
    /// # Errors
    /// Returns [`Error::Cancelled`] if the flag of `progress` is set. The estimate is as before.
    pub fn diagnose(
        &mut self,
        photo: &Source,
        table: &Table,
        options: &Options,
        progress: &Progress,
    ) -> Result<(), Error> {
        if options.diagnose == Some(Duration::ZERO) {
            return Ok(());
        }
        let table = &*campaign_table(&self.campaign, table)?;
        let mut others = options.others.clone();
        for other in &mut others {
            if let Cow::Owned(seen) = campaign_table(&self.campaign, &other.table)? {
                other.table = Arc::new(seen);
            }
        }
        let closed = self
            .best
            .sampling
            .as_ref()
            .map(|_| self.scene.in_closed_form());
        let search = Search {
            campaign: &self.campaign,
            photo,
            table,
            others: &others,
            scene: closed.as_ref().unwrap_or(&self.scene),
            kind: self.kind,
            fit: &self.best,
            tried: &self.compared,
            goodness: &self.goodness,
            unblurred: self.unblurred.as_ref(),
            progress,
            // A time that no clock can tell is no limit.
            until: options
                .diagnose
                .and_then(|time| Instant::now().checked_add(time)),
        };
        (self.suspects, self.diagnosis) = search.suspects(self.mu_was_open)?;
        self.warn();
        Ok(())
    }

    /// Makes the warnings.
    fn warn(&mut self) {
        self.warnings.clone_from(&self.remarks);
        self.warnings.extend(verdict::of_estimate(
            &self.scene,
            &self.best,
            &self.compared,
            &self.goodness,
            (&self.suspects, self.diagnosis),
        ));
        let azimuth = self.azimuth.iter();
        self.warnings.extend(azimuth.flat_map(verdict::of_azimuth));
    }

    /// Returns the loss, for evaluation at other parameters, such as for a profile of the
    /// likelihood.
    pub fn loss(&self) -> Loss<'_> {
        Loss::new(self.kind, &self.scene, (self.near.0, &self.near.1))
    }
}

/// Estimates a sheet from the photographs of a campaign.
///
/// It measures the photographs, finds the azimuth if `options` ask for it, chooses the terms, fits
/// them, bounds the parameters that the photographs cannot determine, and, if the fit is not good,
/// searches for the reason. `photo` supplies the photographs, from their files (`Shot::load`) or
/// from memory.
///
/// # Errors
/// Returns [`Error::Captures`], [`Error::Edge`] or [`Error::Sharper`] if a photograph cannot be
/// read or measured, [`Error::Direction`] or [`Error::NothingLeft`] if the table lacks its direction
/// or returns no light, [`Error::Table`] if the table lacks an azimuth that is tried,
/// [`Error::OneAzimuth`] if an azimuth is wanted and the table has only one, [`Error::Conflict`] if
/// options exclude each other, [`Error::Wave`] or [`Error::Hollow`] if the only kernel named cannot
/// be used with the table or the campaign, [`Error::NothingOpen`] if there is no candidate,
/// [`Error::NoFit`] if the fit fails, and [`Error::Cancelled`] if the flag of `progress` is set.
pub fn campaign(
    campaign: &Campaign,
    photo: &Source,
    table: &Table,
    options: &Options,
    progress: &Progress,
) -> Result<Estimated, Error> {
    let mut estimated = undiagnosed(campaign, photo, table, options, progress)?;
    estimated.diagnose(photo, table, options, progress)?;
    Ok(estimated)
}

/// Returns the table as the light of a campaign sees it.
fn campaign_table<'a>(campaign: &Campaign, table: &'a Table) -> Result<Cow<'a, Table>, Error> {
    let setup = &campaign.setup;
    let light = setup.polarisation.as_ref();
    Ok(polarised::seen(table, light, setup.is_in_mirror())?)
}

/// Does what [`campaign`] does but for the search for suspects, which [`Estimated::diagnose`] makes.
///
/// # Errors
/// Returns the errors of [`campaign`].
pub fn undiagnosed(
    campaign: &Campaign,
    photo: &Source,
    table: &Table,
    options: &Options,
    progress: &Progress,
) -> Result<Estimated, Error> {
    let candidates = options.checked()?;
    let campaign = options.applied(campaign);
    let table = &*campaign_table(&campaign, table)?;
    let mut scene = Scene::reported(&campaign, table, photo, progress)?;
    let mut azimuth = None;
    if options.fit_azimuth {
        let choice = azimuth::flexible(&scene);
        let (found, turned) = azimuth::find(&scene, table, choice, progress)?;
        (azimuth, scene) = (Some(found), turned);
    }
    let (candidates, left_out) = candidates.possible(&scene, table, &campaign.file)?;
    let SceneFit {
        mut best,
        compared,
        bounds,
        goodness,
        mut near,
        hints,
        loss,
        sampled,
        unblurred,
    } = fitted(&scene, table, &candidates, options, progress)?;
    let kind = options.kind();
    if let Some(found) = &azimuth {
        best.add_scatter(&azimuth::scatter(&scene, table, found, kind, best.choice)?);
        near = (best.choice, best.solution.parameters.clone());
    }
    if !is_finite(&best) {
        return Err(Error::NoFit(campaign.file.clone()));
    }
    let mut warnings = of_scene(&scene, table, &best);
    if campaign.setup.seen_in_mirror.is_none() {
        warnings.extend(match &azimuth {
            None => mirror::unstated(&scene, table, kind, &best)?,
            Some(_) => mirror::unstated_azimuth(&scene, table, &best)?,
        });
    }
    let doubted = Doubted {
        scene: &scene,
        campaign: &campaign,
        table,
        others: &options.others,
        loss: &loss,
        best: &best,
        bounds: &bounds,
        azimuth_found: azimuth.is_some(),
        is_far: goodness.scale > UNBOUNDED,
    };
    let trusted = doubted.unverified();
    warnings.extend(left_out);
    warnings.extend(hints);
    let diagnosis = if goodness.verdict == Verdict::Good && unblurred.is_none() {
        Diagnosis::NOT_NEEDED
    } else {
        Diagnosis::NOT_MADE
    };
    let mut estimated = Estimated {
        campaign,
        scene: sampled.unwrap_or(scene),
        best,
        compared,
        kind,
        bounds,
        goodness,
        suspects: Vec::new(),
        diagnosis,
        azimuth,
        azimuth_period_deg: 360.0 / f64::from(table.provenance.symmetry.rotations.max(1)),
        trusted,
        warnings: Vec::new(),
        near,
        remarks: warnings,
        mu_was_open: candidates.per_angle_mu.is_none(),
        unblurred,
    };
    estimated.warn();
    Ok(estimated)
}

/// Result of the fits of one scene.
struct SceneFit<'a> {
    best: Estimate,
    compared: Vec<Ranked>,
    bounds: Bounds,
    goodness: Goodness,
    near: (Choice, DVector<f64>),
    /// Further blurs that the photographs hint at, in sentences.
    hints: Vec<String>,
    /// Loss that was minimised, in closed form.
    loss: Loss<'a>,
    /// Scene with the samples of the estimate, if the model was evaluated by samples.
    sampled: Option<Scene>,
    /// Estimate without the further blurs, if the best one has some.
    unblurred: Option<(Estimate, Goodness)>,
}

/// Factor on the standard errors above which no bound is computed, and no effect of what is taken on
/// trust: the likelihood of a model that
/// is so far from the photographs says nothing of where a number lies. This is a convention.
const UNBOUNDED: f64 = 10.0;

/// Chooses the terms, bounds undetermined parameters, and fits by the loss and the forward model of
/// the options.
fn fitted<'a>(
    scene: &'a Scene,
    table: &Table,
    candidates: &Candidates,
    options: &Options,
    progress: &Progress,
) -> Result<SceneFit<'a>, Error> {
    let kind = options.kind();
    // Terms and bounds are found in closed form and in units of the noise.
    let telling = if kind == Kind::Mse { Kind::Mtf } else { kind };
    let mut selection = select(scene, telling, candidates, progress)?;
    // The published loop has no further blurs.
    let plain = (selection.best.clone(), selection.compared.clone());
    if options.samples.is_none() {
        selection = further::added(scene, candidates, selection);
    }
    let mut telling = goodness::of(scene, &selection.loss, &selection.best);
    let mut unblurred = None;
    if selection.best.choice.further != Further::NONE {
        let own = goodness::of(scene, &selection.loss, &plain.0);
        // A blur that leaves a poor fit explains nothing. It would only hide the mistake that is
        // searched for.
        if telling.verdict == Verdict::Poor {
            (selection.best, selection.compared) = plain;
            telling = own;
        } else {
            unblurred = Some((plain.0, own));
        }
    }
    let unit = telling.scale.powi(2);
    let mut found = Bounds::new();
    let mut hints = Vec::new();
    if telling.scale <= UNBOUNDED {
        found = bounds(scene, &selection.loss, &selection.best, unit);
        found.extend(absent(scene, &selection, unit));
        if kind == Kind::Edge {
            let (loss, best) = (&selection.loss, &selection.best);
            let (bound, hinted) = hints::hidden(scene, loss, best, unit);
            found.extend(bound);
            hints.extend(hinted);
            let found = (best, &selection.compared[..]);
            hints.extend(cubes::alternative(scene, loss, found, unit));
        }
    }
    let Selection {
        mut loss,
        best,
        compared,
        near,
    } = selection;
    let (mut best, goodness, sampled) = if let Some(sampling) = options.samples {
        let renders = Renders {
            scene,
            table,
            weights: match kind {
                Kind::Mse => Weights::Even,
                Kind::Mtf | Kind::Edge => Weights::Noise,
            },
            sampling,
        };
        let (best, sampled) = renders.estimate(best.choice, progress)?;
        loss = Loss::of_mtfs(scene, renders.weights);
        let by_samples = Loss::of_mtfs(&sampled, renders.weights);
        let goodness = goodness::of(&sampled, &by_samples, &best);
        (best, goodness, Some(sampled))
    } else if kind == Kind::Mse {
        loss = Loss::Mse(scene);
        let best = estimate(scene, &loss, refined(scene, &loss, best.optimum()));
        let goodness = goodness::of(scene, &loss, &best);
        (best, goodness, None)
    } else {
        (best, telling, None)
    };
    best.raise(goodness.scales());
    for hint in &hints {
        best.add_scatter(&hint.scatter);
    }
    Ok(SceneFit {
        best,
        compared,
        bounds: found,
        goodness,
        near,
        hints: hints.into_iter().filter_map(|hint| hint.said).collect(),
        loss,
        sampled,
        unblurred,
    })
}

/// Returns the warnings of a scene, after what must be known of its waves if the fit has them.
fn of_scene(scene: &Scene, table: &Table, best: &Estimate) -> Vec<String> {
    let mut warnings = match (best.choice.kernel, &scene.spectrum, best.c_mm) {
        (Kernel::Wave, Some(spectrum), Some(c)) => wave::remarks(table, spectrum, c.value),
        _ => Vec::new(),
    };
    warnings.extend(scene.warnings.iter().cloned());
    warnings
}

/// Returns whether all numbers of a fit are finite.
fn is_finite(best: &Estimate) -> bool {
    let finite = |value: &Value| value.value.is_finite();
    best.solution.stop != Stop::Failed && best.chi2.is_finite() && best.values().all(finite)
}
