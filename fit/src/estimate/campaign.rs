//! A whole estimate: from a campaign's photographs to c, a and mu with their errors, bounds and
//! warnings.

use nalgebra::DVector;
use tables::Table;

use crate::compare::Weights;
use crate::estimate::azimuth;
use crate::estimate::azimuth::Azimuth;
use crate::estimate::bound::{Bounds, absent, bounds};
use crate::estimate::choice::{Choice, Value};
use crate::estimate::error::{Conflict, Error};
use crate::estimate::fitted::{Estimate, estimate};
use crate::estimate::forward::Renders;
use crate::estimate::loss::{Kind, Loss};
use crate::estimate::optimum::refined;
use crate::estimate::scene::{Scene, Source};
use crate::estimate::select::{Candidates, Ranked, Selection, select};
use crate::estimate::verdict;
use crate::estimate::watch::Watch;
use crate::names::Spectrum;
use crate::numerics::Stop;
use crate::photographs::Campaign;
use crate::photographs::photo::channel::Channel;
use crate::samples::Sampling;

/// What is asked of a campaign.
#[derive(Debug, Clone)]
pub struct Options {
    /// The terms that are open.
    pub candidates: Candidates,
    /// What is minimised; `None`: `edge`, or `mtf` by samples.
    pub loss: Option<Kind>,
    /// Evaluates the model by samples, as published, instead of in closed form.
    pub samples: Option<Sampling>,
    /// Finds the sheet's azimuth too: one angle, added to those of all captures (0 where they have
    /// none).
    pub fit_azimuth: bool,
    /// Wavelengths of the source, in place of the campaign's.
    pub spectrum: Option<Spectrum>,
    /// The channel of all photographs, in place of the campaign's.
    pub channel: Option<Channel>,
}

impl Options {
    /// The options of `fit estimate` where none is given, for some candidates.
    pub fn new(candidates: Candidates) -> Options {
        Options {
            candidates,
            loss: None,
            samples: None,
            fit_azimuth: false,
            spectrum: None,
            channel: None,
        }
    }

    /// The campaign as the options have it.
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

    /// The candidates that these options allow.
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

    /// What is minimised.
    fn kind(&self) -> Kind {
        let default = match self.samples {
            Some(_) => Kind::Mtf,
            None => Kind::Edge,
        };
        self.loss.unwrap_or(default)
    }
}

/// What a campaign says of its sheet.
pub struct Estimated {
    /// The campaign as it was fitted.
    pub campaign: Campaign,
    /// Its photographs, measured, as the estimate saw them.
    pub scene: Scene,
    /// The estimate.
    pub best: Estimate,
    /// Every candidate, best criterion first.
    pub compared: Vec<Ranked>,
    /// What was minimised.
    pub kind: Kind,
    /// One-sided bounds of what the photographs cannot pin down.
    pub bounds: Bounds,
    /// The azimuth, where it was asked for.
    pub azimuth: Option<Azimuth>,
    /// What the user should know of the campaign as a whole.
    pub warnings: Vec<String>,
    /// The candidate and its parameters about which the pixels' noise was taken.
    near: (Choice, DVector<f64>),
}

impl Estimated {
    /// The loss, to be evaluated elsewhere: as for profiles of the likelihood.
    pub fn loss(&self) -> Loss<'_> {
        Loss::new(self.kind, &self.scene, (self.near.0, &self.near.1))
    }
}

/// Estimates a sheet from a campaign: measures its photographs, finds the azimuth if asked, chooses
/// the terms, bounds what the photographs do not tell, and fits. `photo` hands out the photographs:
/// from their files (`Shot::load`), or from memory.
///
/// # Errors
/// [`Error`]: photographs or table, options that exclude each other, a fit that failed, or the watch's flag.
pub fn campaign(
    campaign: &Campaign,
    photo: &Source,
    table: &Table,
    options: &Options,
    watch: &Watch,
) -> Result<Estimated, Error> {
    let candidates = options.checked()?;
    let campaign = options.applied(campaign);
    let mut scene = Scene::watched(&campaign, table, photo, watch)?;
    let mut azimuth = None;
    if options.fit_azimuth {
        let choice = azimuth::flexible(&scene);
        let (found, turned) = azimuth::find(&scene, table, choice, watch)?;
        (azimuth, scene) = (Some(found), turned);
    }
    let (candidates, left_out) = candidates.possible(&scene, &campaign.file)?;
    let fitted = fitted(&scene, table, &candidates, options, watch)?;
    let Fitted {
        mut best,
        compared,
        bounds,
        mut near,
        sampled,
    } = fitted;
    let kind = options.kind();
    if let Some(found) = &azimuth {
        best.add_scatter(&azimuth::scatter(&scene, table, found, kind, best.choice)?);
        near = (best.choice, best.solution.parameters.clone());
    }
    if !is_finite(&best) {
        return Err(Error::NoFit {
            manifest: campaign.file.clone(),
        });
    }
    let scene = sampled.unwrap_or(scene);
    let mut warnings = scene.warnings.clone();
    warnings.extend(left_out);
    warnings.extend(verdict::of_estimate(&scene, &best, &compared));
    warnings.extend(azimuth.iter().flat_map(verdict::of_azimuth));
    Ok(Estimated {
        campaign,
        scene,
        best,
        compared,
        kind,
        bounds,
        azimuth,
        warnings,
        near,
    })
}

/// What comes of a scene.
struct Fitted {
    best: Estimate,
    compared: Vec<Ranked>,
    bounds: Bounds,
    near: (Choice, DVector<f64>),
    /// The scene with the samples of the estimate, where it is by samples.
    sampled: Option<Scene>,
}

/// Chooses the terms, bounds what is not told, and fits by the loss and the forward model that were
/// asked for.
fn fitted(
    scene: &Scene,
    table: &Table,
    candidates: &Candidates,
    options: &Options,
    watch: &Watch,
) -> Result<Fitted, Error> {
    let kind = options.kind();
    // Terms, and what the photographs only bound, are decided in closed form and in units of the
    // noise.
    let telling = if kind == Kind::Mse { Kind::Mtf } else { kind };
    let selection = select(scene, telling, candidates, watch)?;
    let mut bounds = bounds(scene, &selection.loss, &selection.best);
    bounds.extend(absent(scene, &selection));
    let Selection {
        best,
        compared,
        near,
        ..
    } = selection;
    let (best, sampled) = if let Some(sampling) = options.samples {
        let renders = Renders {
            scene,
            table,
            weights: match kind {
                Kind::Mse => Weights::Even,
                Kind::Mtf | Kind::Edge => Weights::Noise,
            },
            sampling,
        };
        let (best, sampled) = renders.estimate(best.choice, watch)?;
        (best, Some(sampled))
    } else if kind == Kind::Mse {
        let loss = Loss::Mse(scene);
        let best = refined(scene, &loss, best.optimum());
        (estimate(scene, &loss, best), None)
    } else {
        (best, None)
    };
    Ok(Fitted {
        best,
        compared,
        bounds,
        near,
        sampled,
    })
}

/// Whether a fit has come to numbers.
fn is_finite(best: &Estimate) -> bool {
    let finite = |value: &Value| value.value.is_finite();
    let blur = best.c_mm.iter().chain(&best.spread);
    let mut all = blur.chain(best.mu.iter().flatten());
    best.solution.stop != Stop::Failed && best.chi2.is_finite() && all.all(finite)
}
