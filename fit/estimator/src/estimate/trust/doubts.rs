//! Doubts about what the estimate takes on trust: the effect of a small error of each number.
//!
//! An effect is a step of Gauss and Newton. The chosen candidate, at its optimum, is compared with
//! the photographs in the scene as it would be if the number were another (see `perturbed`), and mu
//! follows at the end of the step. The photographs keep the noise of the estimate. The step misses
//! the optimum of the other scene by a part of the effect that is about as large as the effect
//! itself, a few percent of it. Another cell has large effects, and is fitted to the end.
//! Effects that follow by arithmetic alone need no step:
//!
//! - mu is proportional to the exposure of the reference, and inversely proportional to those of
//!   the photographs and to the half mirror. Exif data hold rounded exposures: then the step is the
//!   error by rounding, if that is above 1 %.
//! - The distance R enters the model only as A / R, as lambda R, and as R times a deviation.
//! - With the pitch p all lengths in the image are multiplied by s = p'/p, and R and the wavelength
//!   are not. Measured in units of s mm nothing changes but R and the wavelength lambda, which
//!   become R / s and lambda / s. So c is that of a fit at R / s, times s, and a is divided by s.
//!   A = a R keeps its value at R / s. The waves depend on lambda R alone: their fit is at R / s^2.
//! - If values v fall short of the light, which is v (1 + k v / E), a step between the plateaus B and
//!   D is larger by k (B + D) / E of itself, and mu by this less that of the reference. E is the
//!   brightest plateau of all. What the curve does to c and a is not computed.

use crate::compare::Pixels;
use crate::estimate::scene::perturbed::{Conditions, OtherIndex, sends_straight_back};
use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::search::bound::Bounds;
use crate::estimate::search::fitted::{Estimate, estimate};
use crate::estimate::search::layout::Layout;
use crate::estimate::search::loss::{Kind, Loss};
use crate::estimate::search::optimum::{Optimum, optimum, refined};
use crate::estimate::search::score::Score;
use crate::estimate::trust::suspects::OtherTable;
use crate::estimate::trust::unverified::{Effect, Unverified, UnverifiedInput};
use crate::model::Further;
use edges::names::{Kernel, ParameterKind};
use edges::numerics::{Solution, Stop};
use edges::photographs::Campaign;
use tables::Table;

/// Step of a number that is a scale: 1 %.
const STEP: f64 = 1.01;

/// Text of [`STEP`].
const ONE_PERCENT: &str = "1 %";

/// Step of the blur of the mid-air photographs that the reference does not have: standard deviation,
/// pixels. Another focus by a tenth of a millimetre in the camera causes as much.
const OWN_BLUR_PX: f64 = 0.3;

/// Step of the dihedral angles, mrad: 4 arcseconds.
const DIHEDRAL_MRAD: f64 = 0.02;

/// Estimate whose inputs are doubted.
pub struct Doubted<'a> {
    /// Scene of the estimate, in closed form.
    pub scene: &'a Scene,
    /// Campaign of the scene.
    pub campaign: &'a Campaign,
    /// Table of the estimate.
    pub table: &'a Table,
    /// Tables of other cells.
    pub others: &'a [OtherTable],
    /// Loss that was minimised, in the scene.
    pub loss: &'a Loss<'a>,
    /// The estimate.
    pub best: &'a Estimate,
    /// Parameters that the photographs only bound.
    pub bounds: &'a Bounds,
    /// True if the azimuth was estimated.
    pub azimuth_found: bool,
    /// Whether the estimate is so far from the photographs that no effect is computed.
    pub is_far: bool,
}

/// Changes of the coordinates of all parameters, see [`Estimate::coordinates`].
type Changes = Vec<f64>;

/// How the change of the estimate in a perturbed scene is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Solve {
    /// One step of Gauss and Newton.
    Step,
    /// A fit to the end.
    Fit,
}

impl Doubted<'_> {
    /// Returns all that is taken on trust, with the effect of each step.
    pub fn unverified(&self) -> Vec<Unverified> {
        // Samples give another optimum than the closed form, in which the effects are computed.
        let base = match self.best.sampling {
            _ if self.is_far => None,
            Some(_) => self.found(self.scene, Solve::Fit),
            None => Some(self.best.coordinates()),
        };
        let doubts = Doubts {
            doubted: self,
            base: base.as_deref(),
        };
        let (mut all, angles) = rayon::join(|| doubts.scales(), || doubts.angles());
        all.extend(angles);
        // An own blur that was fitted is not taken on trust, nor is a lens without a reference.
        if self.scene.reference.is_some() && self.best.own_blur_px.is_empty() {
            let step = format!("{OWN_BLUR_PX} px of further blur");
            let blur_mm = OWN_BLUR_PX * self.scene.optics.camera.pitch_mm;
            let changes = doubts.blurred(Further::OWN_BLUR, &[blur_mm.powi(2)]);
            all.push(doubts.entry(UnverifiedInput::Lens, None, &step, changes));
        }
        all.extend(doubts.dihedral_angles());
        if let Some(changes) = doubts.curved() {
            all.push(doubts.entry(UnverifiedInput::Linearity, None, ONE_PERCENT, Some(changes)));
        }
        all.extend(doubts.cells());
        all
    }

    /// Returns the coordinates of all parameters in another scene, or `None` if a photograph has no
    /// light there or the candidate fails.
    fn found(&self, scene: &Scene, solve: Solve) -> Option<Vec<f64>> {
        if !scene.is_lit() || scene.groups.len() != self.scene.groups.len() {
            return None;
        }
        let (loss, found) = match solve {
            Solve::Step => {
                let loss = self.loss.in_scene(scene);
                let found = self.stepped(scene, &loss, self.best.optimum(), &[])?;
                (loss, found)
            }
            // Noise and light are found as the estimate in the other scene would find them.
            Solve::Fit => {
                let near = optimum(scene, self.best.choice);
                let at = (near.choice, &near.solution.parameters);
                let loss = Loss::new(self.loss.kind(), scene, at);
                let found = refined(scene, &loss, near);
                (loss, found)
            }
        };
        let is_found = found.solution.stop != Stop::Failed;
        is_found.then(|| estimate(scene, &loss, found).coordinates())
    }

    /// Makes one step of Gauss and Newton. Parameters that are only bounded stay, and so does that of
    /// the columns `fixed`. Returns `None` if a parameter would change by more than a factor of e,
    /// where the step has no meaning.
    fn stepped(
        &self,
        scene: &Scene,
        loss: &Loss,
        from: Optimum,
        fixed: &[usize],
    ) -> Option<Optimum> {
        let layout = Layout::of(from.choice, scene);
        let start = from.solution.parameters;
        let (residuals, jacobian) = loss.evaluate(&layout, &start);
        let mut free = jacobian.clone();
        for (i, id) in self
            .best
            .parameters
            .iter()
            .enumerate()
            .take(layout.parameters())
        {
            if self.bounds.contains_key(id) {
                free.column_mut(i).fill(0.0);
            }
        }
        for &fixed in fixed {
            free.column_mut(fixed).fill(0.0);
        }
        let normal = free.tr_mul(&free);
        if normal.iter().any(|entry| !entry.is_finite()) {
            return None;
        }
        let normal = normal.svd(true, true);
        let least = f64::EPSILON * normal.singular_values.max();
        let step = normal.solve(&free.tr_mul(&residuals), least).ok()?;
        let mut logarithms = step.iter().take(layout.logarithms());
        logarithms.all(|by| by.abs() < 1.0).then(|| Optimum {
            choice: from.choice,
            solution: Solution {
                parameters: start - step,
                residuals,
                jacobian,
                iterations: 1,
                stop: Stop::IterationLimit,
            },
            observations: loss.observations(),
        })
    }
}

/// Doubts about the inputs of an estimate.
struct Doubts<'a> {
    doubted: &'a Doubted<'a>,
    /// Coordinates of the parameters in the scene as it stands.
    base: Option<&'a [f64]>,
}

impl Doubts<'_> {
    /// Doubts the numbers that are scales: lengths, light, and the refractive index.
    fn scales(&self) -> Vec<Unverified> {
        let Doubted { scene, table, .. } = *self.doubted;
        let own = scene.optics.camera.pitch_mm;
        let r_mm = equal(scene.shots.iter().map(|shot| Some(shot.r_mm)));
        let farther = self.farther(STEP);
        let entry = |what, value, changes| self.entry(what, value, ONE_PERCENT, changes);
        let mut all = vec![
            entry(
                UnverifiedInput::PixelPitchMm,
                Some(own),
                self.wider_pixels(),
            ),
            entry(UnverifiedInput::FloatingDistanceMm, r_mm, farther.clone()),
            entry(
                UnverifiedInput::HalfMirror,
                Some(scene.half_mirror),
                Some(self.of_mu(1.0 / STEP)),
            ),
        ];
        if let Some(reference) = &scene.reference {
            let exposure = Some(reference.exposure);
            all.push(entry(
                UnverifiedInput::ReferenceExposure,
                exposure,
                Some(self.of_mu(STEP)),
            ));
            let ratios = scene
                .shots
                .iter()
                .map(|shot| shot.exposure / reference.exposure);
            let value = equal(ratios.map(Some));
            // A stated exposure that is too large by rounding is truly smaller.
            let rounded = scene.shots.iter().filter_map(|shot| shot.rounding);
            let by = rounded.map(|rounding| (1.0 + rounding).recip());
            let most = by.max_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs()));
            let (step, by) = match most {
                Some(by) if by.ln().abs() > STEP.ln() => {
                    (format!("{:.1} %", 100.0 * (by - 1.0)), by)
                }
                _ => (ONE_PERCENT.to_owned(), STEP),
            };
            let changes = Some(self.of_mu(by.recip()));
            all.push(self.entry(UnverifiedInput::Exposure, value, &step, changes));
        }
        if self.doubted.best.choice.kernel.has_waves() {
            // Waves depend on the product of wavelength and distance alone.
            let lines = scene.spectrum.iter().flat_map(|spectrum| spectrum.lines());
            let value = equal(lines.map(|line| Some(line.wavelength_nm)));
            all.push(entry(UnverifiedInput::WavelengthNm, value, farther));
        }
        let index = table.provenance.refractive_index;
        let denser = OtherIndex::of(table, STEP * index);
        let denser = denser.and_then(|other| self.perturbed(Some(other), |_| ()));
        all.push(entry(UnverifiedInput::RefractiveIndex, Some(index), denser));
        all
    }

    /// Doubts the angles.
    fn angles(&self) -> Vec<Unverified> {
        let scene = self.doubted.scene;
        let mut all = Vec::new();
        let steeper = |by: f64| {
            // The light of the incidence -x comes from the other side, at x.
            let place = move |conditions: &mut Conditions| {
                conditions.incidence_deg = (conditions.incidence_deg + by).abs();
            };
            self.perturbed(None, place)
        };
        let value = equal(scene.shots.iter().map(|shot| Some(shot.incidence_deg)));
        all.push(self.either_way(UnverifiedInput::IncidenceDeg, value, steeper));
        let azimuths = || scene.shots.iter().map(|shot| shot.direction.azimuth_deg);
        // A mean over all azimuths has none, and one that was estimated is not taken on trust.
        if azimuths().any(|own| own.is_some()) && !self.doubted.azimuth_found {
            let turned = |by: f64| {
                let place = move |conditions: &mut Conditions| {
                    conditions.azimuth_deg = conditions.azimuth_deg.map(|own| own + by);
                };
                self.perturbed(None, place)
            };
            all.push(self.either_way(UnverifiedInput::AzimuthDeg, equal(azimuths()), turned));
        }
        let turned = |by: f64| {
            let place =
                move |conditions: &mut Conditions| conditions.axis_turn_rad += by.to_radians();
            self.perturbed(None, place)
        };
        let captures = self.doubted.campaign.captures.iter();
        let value = equal(captures.map(|capture| Some(capture.tangential_axis_deg)));
        all.push(self.either_way(UnverifiedInput::TangentialAxisDeg, value, turned));
        all
    }

    /// Doubts the cell: each other table stands in place of the table.
    fn cells(&self) -> Vec<Unverified> {
        let Doubted { scene, others, .. } = *self.doubted;
        if others.is_empty() {
            return vec![self.entry(UnverifiedInput::Cell, None, "another cell", None)];
        }
        let own: Vec<Conditions> = scene.shots.iter().map(Aerial::conditions).collect();
        let one = |other: &OtherTable| {
            let perturbed = scene.perturbed(&other.table, None, &own).ok();
            let changes = perturbed.and_then(|scene| self.changes(&scene, Solve::Fit));
            let step = format!("table {}", other.name);
            self.entry(UnverifiedInput::Cell, None, &step, changes)
        };
        others.iter().map(one).collect()
    }

    /// Makes an entry for a step of one degree, or, where the table has no such direction, of one
    /// degree the other way.
    fn either_way(
        &self,
        what: UnverifiedInput,
        value: Option<f64>,
        changes: impl Fn(f64) -> Option<Changes>,
    ) -> Unverified {
        let ways = [(1.0, "1 deg"), (-1.0, "-1 deg")];
        let mut found = ways.iter().map(|&(by, step)| (step, changes(by)));
        let effect = found.find(|(_, changes)| changes.is_some());
        let (step, changes) = effect.unwrap_or(("1 deg", None));
        self.entry(what, value, step, changes)
    }

    /// Returns the changes if all photographs had been taken otherwise.
    fn perturbed(
        &self,
        index: Option<OtherIndex>,
        by: impl Fn(&mut Conditions),
    ) -> Option<Changes> {
        let Doubted { scene, table, .. } = *self.doubted;
        let other = |shot: &Aerial| {
            let mut conditions = shot.conditions();
            by(&mut conditions);
            conditions
        };
        let conditions: Vec<Conditions> = scene.shots.iter().map(other).collect();
        self.changes(
            &scene.perturbed(table, index, &conditions).ok()?,
            Solve::Step,
        )
    }

    /// Returns the changes in another scene.
    fn changes(&self, scene: &Scene, solve: Solve) -> Option<Changes> {
        let (base, found) = (self.base?, self.doubted.found(scene, solve)?);
        Some(
            found
                .iter()
                .zip(base)
                .map(|(found, own)| found - own)
                .collect(),
        )
    }

    /// Returns the changes if the photographs had one further blur with these parameters: the variance of
    /// an own blur, mm^2, or of an angular spread, mrad^2, or three dihedral errors, mrad.
    fn blurred(&self, further: Further, by: &[f64]) -> Option<Changes> {
        let Doubted {
            scene, loss, best, ..
        } = *self.doubted;
        let base = self.base?;
        let mut from = best.optimum();
        from.choice.further = from.choice.further.and(further);
        let layout = Layout::of(from.choice, scene);
        let columns = layout.columns_of(further);
        for (&column, &value) in columns.iter().zip(by) {
            from.solution.parameters = from.solution.parameters.insert_row(column, value);
        }
        let stepped = self.doubted.stepped(scene, loss, from, &columns)?;
        let mut found = estimate(scene, loss, stepped).coordinates();
        for &column in columns.iter().rev() {
            found.remove(column);
        }
        let pairs = found.iter().zip(base);
        Some(pairs.map(|(found, own)| found - own).collect())
    }

    /// Doubts the dihedral angles, unless the estimate has a spread or errors of them. The facets of a
    /// baseline spread the light as dihedral errors do.
    ///
    /// Equal errors of all cubes move c by most. The step is the usual one, or two standard errors if
    /// the photographs tell more. Independent errors e are a spread of 2 m e, see
    /// `crate::model::further`.
    fn dihedral_angles(&self) -> Option<Unverified> {
        let Doubted {
            scene,
            loss,
            best,
            table,
            ..
        } = *self.doubted;
        let choice = best.choice;
        let own = choice.further;
        if choice.kernel.is_baseline() || own.angular_spread || own.common_errors {
            return None;
        }
        let at = (choice, &best.solution.parameters);
        let score = Score::new(scene, loss, at, Further::COMMON_ERRORS);
        let told = score.and_then(|score| score.equal_errors());
        let (step, changes) = match told.filter(|_| loss.kind() != Kind::Mse) {
            Some(error) => {
                let step = DIHEDRAL_MRAD.min(2.0 * error);
                let changes = self.blurred(Further::COMMON_ERRORS, &[step; 3]);
                let digits = if step < 1e-3 { 6 } else { 3 };
                (format!("{step:.digits$} mrad in all cubes"), changes)
            }
            None => {
                let spread_mrad = 2.0 * table.provenance.refractive_index * DIHEDRAL_MRAD;
                let changes = self.blurred(Further::ANGULAR_SPREAD, &[spread_mrad.powi(2)]);
                (format!("{DIHEDRAL_MRAD} mrad"), changes)
            }
        };
        Some(self.entry(UnverifiedInput::DihedralAngles, None, &step, changes))
    }

    /// Returns the changes if the light were more than its values by a step at the brightest plateau,
    /// and by a share that falls with the light; `None` without mu.
    fn curved(&self) -> Option<Changes> {
        let Doubted { scene, best, .. } = *self.doubted;
        let reference = &scene.reference.as_ref()?.photographs;
        let groups = best.mu.as_ref()?.len();
        let levels = |pixels: &Pixels| pixels.plateaus();
        let shots: Vec<[f64; 2]> = scene
            .shots
            .iter()
            .map(|shot| levels(&shot.pixels))
            .collect();
        let sources: Vec<[f64; 2]> = reference.iter().map(|own| levels(&own.pixels)).collect();
        let brightest = shots.iter().chain(&sources).map(|[_, bright]| *bright);
        let brightest = brightest.fold(f64::MIN_POSITIVE, f64::max);
        let mean = |all: &mut dyn Iterator<Item = &[f64; 2]>| {
            let sums = all.fold([0.0; 2], |[sum, n], [dark, bright]| {
                [sum + dark + bright, n + 1.0]
            });
            (STEP - 1.0) * sums[0] / sums[1] / brightest
        };
        let source = mean(&mut sources.iter());
        let mut changes = vec![f64::NAN; best.parameters.len()];
        let own = changes.iter_mut().skip(best.blur_parameters());
        for (group, change) in own.enumerate() {
            let numbered = scene.shots.iter().zip(&shots);
            let of_group = numbered.filter(|(shot, _)| groups == 1 || shot.place.group == group);
            *change = mean(&mut of_group.map(|(_, levels)| levels)) - source;
        }
        Some(changes)
    }

    /// Returns the changes if all floating distances were `by` times as long.
    fn farther(&self, by: f64) -> Option<Changes> {
        let Doubted { table, best, .. } = *self.doubted;
        let kernel = best.choice.kernel;
        let mut changes = self.none();
        match kernel {
            _ if kernel.has_waves() || kernel.is_baseline() || !sends_straight_back(table) => {
                self.perturbed(None, |conditions| conditions.r_mm *= by)
            }
            Kernel::Angular => {
                self.spreads(&mut changes)
                    .iter_mut()
                    .for_each(|a| *a += by.ln());
                Some(changes)
            }
            _ => Some(changes),
        }
    }

    /// Returns the changes if the pixels were wider by a step.
    fn wider_pixels(&self) -> Option<Changes> {
        let kernel = self.doubted.best.choice.kernel;
        let mut changes = self.farther(match kernel {
            Kernel::Wave => STEP.powi(-2),
            _ => STEP.recip(),
        })?;
        if kernel.has_c() {
            changes[0] += STEP.ln();
        }
        if kernel.has_lobe() && ParameterKind::spread_of(kernel) == ParameterKind::APerMm {
            self.spreads(&mut changes)
                .iter_mut()
                .for_each(|a| *a -= STEP.ln());
        }
        Some(changes)
    }

    /// Returns the changes if all mu were `by` times as large.
    fn of_mu(&self, by: f64) -> Changes {
        let mut changes = self.none();
        let blur = self.doubted.best.blur_parameters();
        changes.iter_mut().skip(blur).for_each(|mu| *mu += by.ln());
        changes
    }

    /// Returns no changes.
    fn none(&self) -> Changes {
        vec![0.0; self.doubted.best.parameters.len()]
    }

    /// Returns the part of the changes that belongs to the spreads.
    fn spreads<'c>(&self, changes: &'c mut Changes) -> &'c mut [f64] {
        let best = self.doubted.best;
        let end = best.kernel_parameters();
        &mut changes[end - best.spread.len()..end]
    }

    /// Makes an entry from changes of the logarithms.
    fn entry(
        &self,
        what: UnverifiedInput,
        value: Option<f64>,
        step: &str,
        changes: Option<Changes>,
    ) -> Unverified {
        let Doubted { best, bounds, .. } = *self.doubted;
        let largest = |kinds: &[ParameterKind]| {
            let pairs = best.parameters.iter().zip(changes.as_ref()?);
            let known =
                pairs.filter(|(id, _)| kinds.contains(&id.kind) && !bounds.contains_key(id));
            let shares = known.map(|(_, change)| change.exp_m1());
            let shares = shares.filter(|share| share.is_finite());
            shares.max_by(|a, b| a.abs().total_cmp(&b.abs()))
        };
        Unverified {
            what,
            value,
            step: step.to_owned(),
            effect: Effect {
                c_mm: largest(&[ParameterKind::CornerSize]),
                a_per_mm: largest(&[ParameterKind::APerMm, ParameterKind::ATimesR]),
                mu: largest(&[ParameterKind::Mu]),
            },
        }
    }
}

/// Returns the value that all have, or `None` if they differ or there is none.
fn equal(mut values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let first = values.next()??;
    values.all(|other| other == Some(first)).then_some(first)
}
