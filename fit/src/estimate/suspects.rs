//! Suspects: mistakes that would explain a fit that does not describe its photographs.
//!
//! Each suspect is tried: the scene is made as it would be without the mistake, the candidate is
//! fitted again, and the sums of squares are compared. All suspects are fitted to the MTFs, which
//! is fast. The best few are fitted by the loss of the estimate. A suspect is named if the sum of
//! squares falls by at least half of its excess, and by more than chance allows.

use std::sync::Arc;

use nalgebra::DVector;
use rayon::prelude::*;
use tables::Table;

use crate::estimate::choice::Choice;
use crate::estimate::covariance::scatter_at;
use crate::estimate::fitted::Estimate;
use crate::estimate::goodness::Goodness;
use crate::estimate::layout::Layout;
use crate::estimate::loss::{Kind, Loss};
use crate::estimate::optimum::{Optimum, optimum, refined_to, rough_from};
use crate::estimate::placed::{OtherIndex, Placed};
use crate::estimate::scene::{Aerial, Scene, Source};
use crate::estimate::select::CLEAR;
use crate::estimate::start::Start;
use crate::estimate::watch::Watch;
use crate::names::{Kernel, LobeShape};
use crate::numerics::{Stop, chance};
use crate::photographs::Campaign;
use crate::photographs::photo::transfer::Transfer;

/// Fall of the sum of squares below which a suspect is not named.
///
/// Noise reaches it in one of 10^5 fits, and some hundred suspects are tried.
const SURE: f64 = 20.0;

/// Share of the excess of the sum of squares that a suspect has to explain.
const EXPLAINED: f64 = 0.5;

/// Probability above which the mu of several incidences agree.
const AGREE: f64 = 1e-3;

/// Number of suspects that are fitted by the loss of the estimate.
const BEST: usize = 4;

/// Tolerance of these fits. Their sums of squares are then right to about its square.
const ROUGH: f64 = 1e-3;

/// Step of the azimuths that are tried, degrees.
const AZIMUTH_STEP_DEG: f64 = 10.0;

/// Refractive indices that are tried: air, acrylic, crown glass and polycarbonate.
const INDICES: [f64; 4] = [1.0, 1.49, 1.517, 1.586];

/// Mistake that would explain a misfit.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// The mistake, as a sentence.
    pub what: String,
    /// Photographs that it concerns; empty if it concerns all.
    pub captures: Vec<String>,
    /// Sum of squares of the fit without the mistake. If the mistake is an exposure, the sum of
    /// squares is that of the differences of light.
    pub chi2_if_so: f64,
}

/// Table that is tried if the first one does not fit.
#[derive(Debug, Clone)]
pub struct OtherTable {
    /// Name of the table for messages.
    pub name: String,
    /// The table.
    pub table: Arc<Table>,
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
    pub tried: &'a [Choice],
    pub goodness: &'a Goodness,
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

/// Sum of squares of an alternative, less its degrees of freedom and its cost.
struct Outcome {
    alternative: usize,
    choice: Choice,
    excess: f64,
    squares: f64,
    /// Parameters of the fit.
    at: DVector<f64>,
}

impl Search<'_> {
    /// Returns the mistakes that would explain the misfit, the best first.
    pub(crate) fn suspects(&self) -> Vec<Suspect> {
        let mut found = self.of_blur();
        let mut light: Vec<Suspect> = self.exposure().into_iter().collect();
        if self.goodness.scale <= 1.0 {
            light.extend(self.of_light());
        }
        light.sort_by(|a, b| a.chi2_if_so.total_cmp(&b.chi2_if_so));
        found.extend(light);
        found
    }

    /// Returns the mistakes that would explain why the photographs disagree on mu, where the blur
    /// does not tell them.
    fn of_light(&self) -> Vec<Suspect> {
        let Some(now) = self
            .fit
            .scatter
            .as_ref()
            .filter(|_| self.goodness.is_light_off())
        else {
            return Vec::new();
        };
        let excess = now.squares() - now.freedom as f64;
        let left = |own: &Alternative| {
            let fit = self.at_least(&own.scene, &own.choices)?;
            let layout = Layout::new(fit.choice, own.scene.groups.len());
            let scatter = scatter_at(&own.scene, &layout, &fit.at);
            let fall = excess - (scatter.squares() - scatter.freedom as f64) - own.cost;
            (fall > SURE.max(EXPLAINED * excess)).then(|| Suspect {
                what: own.what.clone(),
                captures: own.captures.clone(),
                chi2_if_so: scatter.squares(),
            })
        };
        self.alternatives().par_iter().filter_map(left).collect()
    }

    /// Returns the mistakes that would explain the misfit of the blur.
    fn of_blur(&self) -> Vec<Suspect> {
        if self.goodness.scale <= 1.0 {
            return Vec::new();
        }
        let alternatives = self.alternatives();
        let now = self
            .at_least(self.scene, &[self.fit.choice])
            .map_or(0.0, |of| of.excess);
        let mut rough: Vec<Outcome> = alternatives
            .par_iter()
            .enumerate()
            .filter_map(|(i, own)| {
                let found = self.at_least(&own.scene, &own.choices)?;
                Some(Outcome {
                    alternative: i,
                    excess: found.excess + own.cost,
                    ..found
                })
            })
            .filter(|found| now - found.excess > SURE.max(EXPLAINED * now))
            .collect();
        rough.sort_by(|a, b| a.excess.total_cmp(&b.excess));
        rough.truncate(BEST);
        let by_mtf = self.kind != Kind::Edge;
        let excess = self.goodness.chi2 - self.goodness.degrees_of_freedom as f64;
        let mut named: Vec<(f64, Suspect)> = rough
            .into_par_iter()
            .filter_map(|found| {
                let own = &alternatives[found.alternative];
                let fit = self.by_the_loss(&own.scene, found.choice, by_mtf)?;
                let left = freed(&fit) + own.cost;
                let enough = excess - left > SURE.max(EXPLAINED * excess);
                enough.then(|| {
                    let suspect = Suspect {
                        what: own.what.clone(),
                        captures: own.captures.clone(),
                        chi2_if_so: fit.solution.sum_of_squares(),
                    };
                    (left, suspect)
                })
            })
            .collect();
        named.sort_by(|a, b| a.0.total_cmp(&b.0));
        named.into_iter().map(|(_, suspect)| suspect).collect()
    }

    /// Returns the mistakes without which one mu would do for all incidences, where the photographs
    /// asked for one each. A mu that falls with the incidence is no mistake. So a suspect is named
    /// only if it makes the mu of all incidences agree within their errors.
    ///
    /// Nothing is fitted: mu is inversely proportional to the retroreflected share of the table,
    /// and the rest of the fit hardly depends on it.
    pub(crate) fn of_differing_mu(&self) -> Vec<Suspect> {
        let Some(mu) = self.fit.mu.as_ref().filter(|mu| mu.len() > 1) else {
            return Vec::new();
        };
        let mut all = Vec::new();
        self.exchanged(&mut all);
        // Of two incidences one number tells, which one of many mistakes may explain by chance.
        if mu.len() > 2 {
            self.turned(&mut all);
            self.of_another_sheet(&mut all);
        }
        let kernel = self.fit.choice.kernel;
        let agrees = |own: &Alternative| {
            let shots = self.scene.shots.iter().zip(&own.scene.shots);
            let numbers = shots.map(|(shot, other)| {
                let share = |shot: &Aerial| shot.returned(kernel).retroreflected;
                let value = mu[shot.group];
                let ln = (value.value * share(shot) / share(other)).ln();
                (ln, value.standard_error / value.value)
            });
            // Photographs of one incidence share its mu, so they count once.
            let mut groups: Vec<(f64, f64)> = numbers.collect();
            groups.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
            groups.dedup_by(|a, b| (a.0 - b.0).abs() < 1e-12);
            let squares = scatter_about_mean(&groups);
            let chance = chance::of_squares(squares, groups.len().saturating_sub(1));
            (own.scene.is_lit() && groups.len() > 1 && chance > AGREE).then(|| Suspect {
                what: own.what.clone(),
                captures: own.captures.clone(),
                chi2_if_so: squares,
            })
        };
        let mut found: Vec<Suspect> = all.iter().filter_map(agrees).collect();
        found.sort_by(|a, b| a.chi2_if_so.total_cmp(&b.chi2_if_so));
        found
    }

    /// Fits the MTFs of a scene by each of these candidates, from the estimate, and returns the
    /// best. Returns `None` if no light returns in a photograph, or if the fits fail.
    fn at_least(&self, scene: &Scene, choices: &[Choice]) -> Option<Outcome> {
        if !scene.is_lit() {
            return None;
        }
        let fits = choices.iter().filter_map(|&choice| {
            let fit = rough_from(scene, choice, vec![self.start(scene, choice)?]);
            (fit.solution.stop != Stop::Failed).then(|| Outcome {
                alternative: 0,
                choice,
                excess: freed(&fit),
                squares: fit.solution.sum_of_squares(),
                at: fit.solution.parameters,
            })
        });
        fits.filter(|fit| fit.squares.is_finite())
            .min_by(|a, b| a.excess.total_cmp(&b.excess))
    }

    /// Returns the estimate as the start of a candidate, with its mean spread.
    fn start(&self, scene: &Scene, choice: Choice) -> Option<Start> {
        let fit = self.fit;
        let spread = if fit.spread.is_empty() {
            4.0
        } else {
            fit.spread.iter().map(|v| v.value).sum::<f64>() / fit.spread.len() as f64
        };
        let from = fit.choice.kernel.distance_scale(scene.mean_distance_mm());
        let to = choice.kernel.distance_scale(scene.mean_distance_mm());
        let count = Layout::new(choice, scene.groups.len()).spreads.max(1);
        Some(Start {
            c_mm: fit.c_mm.map_or(0.2, |c| c.value),
            spread: vec![spread * to / from; count],
        })
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

    /// Returns all alternatives.
    fn alternatives(&self) -> Vec<Alternative> {
        let mut all = Vec::new();
        self.exchanged(&mut all);
        self.turned(&mut all);
        self.of_another_sheet(&mut all);
        self.at_other_distances(&mut all);
        self.decoded_otherwise(&mut all);
        self.alone(&mut all);
        self.not_tried(&mut all);
        all
    }

    /// Adds the scene with its photographs placed otherwise, if the table has their directions.
    fn add(
        &self,
        all: &mut Vec<Alternative>,
        what: String,
        placed: &dyn Fn(&Aerial) -> Placed,
        index: Option<OtherIndex>,
    ) {
        let shots = &self.scene.shots;
        let before: Vec<Placed> = shots.iter().map(Aerial::placed).collect();
        let after: Vec<Placed> = shots.iter().map(placed).collect();
        let pairs = before.iter().zip(&after).zip(shots);
        let changed: Vec<String> = pairs
            .filter(|((before, after), _)| before != after)
            .map(|(_, shot)| shot.image.clone())
            .collect();
        if changed.is_empty() && index.is_none() {
            return;
        }
        if let Ok(scene) = self.scene.placed(self.table, index, &after) {
            let captures = if changed.len() < shots.len() {
                changed
            } else {
                Vec::new()
            };
            all.push(self.alternative(what, captures, scene));
        }
    }

    fn alternative(&self, what: String, captures: Vec<String>, scene: Scene) -> Alternative {
        Alternative {
            what,
            captures,
            scene,
            choices: self.fuller(),
            cost: 0.0,
        }
    }

    /// Returns the chosen candidate, and the one with both terms if the chosen one lacks one: the
    /// mistake may have hidden the other.
    fn fuller(&self) -> Vec<Choice> {
        let own = self.fit.choice;
        let both = Choice {
            kernel: Kernel::Eq1,
            ..own
        };
        if own.kernel == Kernel::Lobe || own.kernel == Kernel::Shift {
            vec![own, both]
        } else {
            vec![own]
        }
    }

    /// Adds exchanged incidences: of two angles, and of the worst photograph and another one. Where
    /// all photographs have one incidence, those of the table take its place.
    fn exchanged(&self, all: &mut Vec<Alternative>) {
        let scene = self.scene;
        if let [own] = scene.groups[..] {
            let axis = self.table.axes.incidence_deg.iter();
            for &deg in axis.filter(|&&deg| deg != own) {
                let placed = |shot: &Aerial| Placed {
                    incidence_deg: deg,
                    ..shot.placed()
                };
                self.add(
                    all,
                    format!("the incidence is {deg}, not {own} deg"),
                    &placed,
                    None,
                );
            }
        }
        let swapped = |deg: f64, [a, b]: [f64; 2]| match deg {
            _ if deg == a => b,
            _ if deg == b => a,
            _ => deg,
        };
        for (i, &a) in scene.groups.iter().enumerate() {
            for &b in &scene.groups[i + 1..] {
                let placed = |shot: &Aerial| Placed {
                    incidence_deg: swapped(shot.incidence_deg, [a, b]),
                    ..shot.placed()
                };
                let what = format!("the incidences {a} and {b} deg are exchanged");
                self.add(all, what, &placed, None);
            }
        }
        let worst = self.goodness.worst.as_ref().map(|(image, _)| image);
        let Some(worst) = scene.shots.iter().find(|shot| Some(&shot.image) == worst) else {
            return;
        };
        for other in &scene.shots {
            if other.incidence_deg == worst.incidence_deg {
                continue;
            }
            let placed = |shot: &Aerial| Placed {
                incidence_deg: match &shot.image {
                    image if *image == worst.image => other.incidence_deg,
                    image if *image == other.image => worst.incidence_deg,
                    _ => shot.incidence_deg,
                },
                ..shot.placed()
            };
            let what = format!(
                "the incidences of {} ({} deg) and {} ({} deg) are exchanged",
                worst.image, worst.incidence_deg, other.image, other.incidence_deg
            );
            self.add(all, what, &placed, None);
        }
        for &deg in &scene.groups {
            let placed = |shot: &Aerial| Placed {
                incidence_deg: if shot.image == worst.image {
                    deg
                } else {
                    shot.incidence_deg
                },
                ..shot.placed()
            };
            let what = format!("the incidence of {} is {deg} deg", worst.image);
            self.add(all, what, &placed, None);
        }
    }

    /// Adds turned axes, other azimuths, and the other view of the sheet.
    fn turned(&self, all: &mut Vec<Alternative>) {
        let axis = |shot: &Aerial| Placed {
            axis_turn_rad: shot.placed().axis_turn_rad + std::f64::consts::FRAC_PI_2,
            ..shot.placed()
        };
        self.add(
            all,
            "the tangential axis is off by 90 deg".into(),
            &axis,
            None,
        );
        let view = |shot: &Aerial| Placed {
            seen_in_mirror: !shot.seen_in_mirror,
            ..shot.placed()
        };
        let seen = self
            .scene
            .shots
            .first()
            .is_some_and(|shot| shot.seen_in_mirror);
        self.add(all, format!("seen_in_mirror is {}", !seen), &view, None);
        if self.table.axes.is_mean() {
            return;
        }
        let period = 360.0 / f64::from(self.table.provenance.symmetry.rotations);
        let steps = (period / AZIMUTH_STEP_DEG).round() as usize;
        for by in (1..steps).map(|step| step as f64 * AZIMUTH_STEP_DEG) {
            let placed = |shot: &Aerial| Placed {
                azimuth_deg: shot.facing.azimuth_deg.map(|deg| deg + by),
                ..shot.placed()
            };
            let signed = if by > 0.5 * period { by - period } else { by };
            self.add(
                all,
                format!("the azimuth is off by {signed} deg"),
                &placed,
                None,
            );
        }
    }

    /// Adds other tables, and other refractive indices.
    fn of_another_sheet(&self, all: &mut Vec<Alternative>) {
        let placed: Vec<Placed> = self.scene.shots.iter().map(Aerial::placed).collect();
        for other in self.others {
            if let Ok(scene) = self.scene.placed(&other.table, None, &placed) {
                let what = format!("the table of the sheet is {}", other.name);
                all.push(self.alternative(what, Vec::new(), scene));
            }
        }
        let own = self.table.provenance.refractive_index;
        for index in INDICES
            .into_iter()
            .filter(|&index| (index - own).abs() > 0.01)
        {
            if let Some(other) = OtherIndex::of(self.table, index) {
                let what = format!("the refractive index is {index}, not {own}");
                self.add(all, what, &Aerial::placed, Some(other));
            }
        }
    }

    /// Adds distances in another unit: of all photographs, and of single ones.
    fn at_other_distances(&self, all: &mut Vec<Alternative>) {
        if !matches!(self.fit.choice.kernel, Kernel::Angular | Kernel::Wave) {
            return;
        }
        for (factor, unit) in [(10.0, "cm"), (0.1, "tenths of a mm")] {
            let placed = |shot: &Aerial| Placed {
                r_mm: factor * shot.r_mm,
                ..shot.placed()
            };
            let what = format!("the floating distances are in {unit}, not in mm");
            self.add(all, what, &placed, None);
            for one in &self.scene.shots {
                let placed = |shot: &Aerial| Placed {
                    r_mm: if shot.image == one.image {
                        factor * shot.r_mm
                    } else {
                        shot.r_mm
                    },
                    ..shot.placed()
                };
                let what = format!("the floating distance of {} is in {unit}", one.image);
                self.add(all, what, &placed, None);
            }
        }
    }

    /// Adds the other transfer: sRGB for linear values, or the reverse.
    fn decoded_otherwise(&self, all: &mut Vec<Alternative>) {
        let Some(first) = self.scene.shots.first() else {
            return;
        };
        let is_linear = first.transfer.name == "linear";
        let (to, what) = if is_linear {
            (
                Transfer::Srgb,
                "the values of the photographs are sRGB, not linear",
            )
        } else {
            (
                Transfer::Linear,
                "the values of the photographs are linear, not sRGB",
            )
        };
        let mut campaign = self.campaign.clone();
        let shots = campaign
            .captures
            .iter_mut()
            .map(|capture| &mut capture.shot);
        for shot in campaign.reference.iter_mut().chain(shots) {
            shot.decode.transfer = Some(to);
        }
        let Ok(scene) = Scene::watched(&campaign, self.table, self.photo, &Watch::NOBODY) else {
            return;
        };
        let other = scene
            .shots
            .first()
            .is_some_and(|own| own.transfer.name != first.transfer.name);
        if other {
            all.push(self.alternative(format!("{what} (key transfer)"), Vec::new(), scene));
        }
    }

    /// Adds the scenes without the worst photograph.
    fn alone(&self, all: &mut Vec<Alternative>) {
        let worst = self.goodness.worst.as_ref().map(|(image, _)| image);
        let shots = &self.scene.shots;
        let Some(i) = shots.iter().position(|shot| Some(&shot.image) == worst) else {
            return;
        };
        if shots.len() < 2 {
            return;
        }
        let image = shots[i].image.clone();
        all.push(Alternative {
            // A photograph explains its own misfit whatever its cause. So a suspect that says why
            // comes first.
            cost: SURE,
            ..self.alternative(
                format!("{image} alone does not agree with the others"),
                vec![image],
                self.scene.without(i),
            )
        });
    }

    /// Adds kernels and lobes that were not among the candidates.
    fn not_tried(&self, all: &mut Vec<Alternative>) {
        if self.fit.choice.kernel.is_baseline() {
            return;
        }
        for shape in LobeShape::ALL {
            for kernel in [Kernel::Eq1, Kernel::Angular, Kernel::Shift, Kernel::Lobe] {
                let same = |own: &&Choice| {
                    own.kernel == kernel && (own.shape == shape || !kernel.has_lobe())
                };
                if self.tried.iter().any(|own| same(&own)) {
                    continue;
                }
                let shaped = if kernel.has_lobe() {
                    format!(" --lobe {}", shape.name())
                } else {
                    String::new()
                };
                all.push(Alternative {
                    choices: vec![Choice {
                        kernel,
                        shape,
                        ..self.fit.choice
                    }],
                    cost: CLEAR,
                    ..self.alternative(
                        format!("the blur is that of --kernel {}{shaped}", kernel.name()),
                        Vec::new(),
                        self.scene.clone(),
                    )
                });
            }
        }
    }

    /// Names the exposure that explains why the photographs disagree on mu. Of two photographs alone
    /// it cannot tell which.
    fn exposure(&self) -> Option<Suspect> {
        let scatter = self.fit.scatter.as_ref();
        let scatter = scatter.filter(|_| self.goodness.is_light_off())?;
        let all = scatter.squares();
        let each = scatter.each.iter().enumerate();
        let (i, &worst) = each.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let shots = &self.scene.shots;
        let own = self.fit.choice.per_angle_mu;
        let beside = |shot: &&Aerial| !own || shot.group == shots[i].group;
        let beside: Vec<String> = shots
            .iter()
            .filter(beside)
            .map(|s| s.image.clone())
            .collect();
        // Without one of n numbers the sum of squares about their mean falls by its square times
        // n / (n - 1).
        let n = beside.len() as f64;
        let left = (all - worst * worst * n / (n - 1.0).max(1.0)).max(0.0);
        let excess = all - scatter.freedom as f64;
        if all - left <= SURE.max(EXPLAINED * excess) {
            return None;
        }
        let image = shots[i].image.clone();
        let side = if worst > 0.0 { "small" } else { "large" };
        let (what, captures) = if let [a, b] = &beside[..] {
            (
                format!("the exposure of {a} or that of {b} is another"),
                beside,
            )
        } else {
            let what =
                format!("the exposure of {image} is stated too {side}, or its light changed");
            (what, vec![image])
        };
        Some(Suspect {
            what,
            captures,
            chi2_if_so: left,
        })
    }
}

/// Returns the sum of squares of numbers about their weighted mean, each in units of its error.
fn scatter_about_mean(numbers: &[(f64, f64)]) -> f64 {
    let weight = |error: f64| error.max(1e-9).powi(-2);
    let sum: f64 = numbers.iter().map(|&(_, error)| weight(error)).sum();
    let mean = numbers
        .iter()
        .map(|&(v, error)| v * weight(error))
        .sum::<f64>()
        / sum;
    let squares = numbers
        .iter()
        .map(|&(v, error)| (v - mean).powi(2) * weight(error));
    squares.sum()
}

/// Returns the sum of squares of a fit less its degrees of freedom.
fn freed(fit: &Optimum) -> f64 {
    let freedom = fit
        .observations
        .saturating_sub(fit.solution.parameters.len());
    fit.solution.sum_of_squares() - freedom as f64
}
