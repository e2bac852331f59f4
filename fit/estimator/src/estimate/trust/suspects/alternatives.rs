//! The alternatives to a campaign as its manifest states it.

use rayon::prelude::*;

use crate::estimate::progress::Progress;
use crate::estimate::scene::perturbed::{Conditions, OtherIndex};
use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::search::hints::edge_by_edge;
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::score::possible;
use crate::estimate::search::select::CLEAR;
use crate::estimate::trust::suspects::{Alternative, Otherwise, SURE, Search};
use crate::model::wave;
use edges::names::{Kernel, LobeShape, Spectrum};
use edges::photographs::photo::transfer::Transfer;

/// Step of the azimuths that are tried, degrees.
const AZIMUTH_STEP_DEG: f64 = 10.0;

/// Wavelengths that are tried if none is known, nm: blue, green and red.
const WAVELENGTHS_NM: [f64; 3] = [450.0, 550.0, 650.0];

/// Refractive indices that are tried: air, acrylic, crown glass and polycarbonate.
const INDICES: [f64; 4] = [1.0, 1.49, 1.517, 1.586];

impl Search<'_> {
    /// Returns the mistakes of the manifest that are tried, each as photographs under other
    /// conditions.
    pub(super) fn stated(&self) -> Vec<Otherwise<'_>> {
        let mut stated = Vec::new();
        self.exchanged(&mut stated);
        self.turned(&mut stated);
        self.of_another_sheet(&mut stated);
        self.at_other_distances(&mut stated);
        stated
    }

    /// Adds the photographs under other conditions, if that changes any.
    fn add<'s>(
        &'s self,
        all: &mut Vec<Otherwise<'s>>,
        what: String,
        conditions: &dyn Fn(&Aerial) -> Conditions,
        index: Option<OtherIndex>,
    ) {
        let shots = &self.scene.shots;
        let before: Vec<Conditions> = shots.iter().map(Aerial::conditions).collect();
        let after: Vec<Conditions> = shots.iter().map(conditions).collect();
        let pairs = before.iter().zip(&after).zip(shots);
        let changed: Vec<String> = pairs
            .filter(|((before, after), _)| before != after)
            .map(|(_, shot)| shot.image.clone())
            .collect();
        if changed.is_empty() && index.is_none() {
            return;
        }
        let captures = if changed.len() < shots.len() {
            changed
        } else {
            Vec::new()
        };
        all.push(Otherwise {
            what,
            captures,
            table: self.table,
            index,
            conditions: after,
        });
    }

    /// Adds the photographs with one of them under other conditions, if that changes it.
    fn add_one<'s>(
        &'s self,
        all: &mut Vec<Otherwise<'s>>,
        what: String,
        image: &str,
        place: &dyn Fn(&mut Conditions),
    ) {
        let conditions = |shot: &Aerial| {
            let mut conditions = shot.conditions();
            if shot.image == image {
                place(&mut conditions);
            }
            conditions
        };
        self.add(all, what, &conditions, None);
    }

    /// Returns the number of the photograph with the largest misfit; `None` if that is the
    /// reference.
    fn worst(&self) -> Option<usize> {
        let worst = &self.goodness.worst.as_ref()?.image;
        let mut shots = self.scene.shots.iter();
        shots.position(|shot| shot.image == *worst)
    }

    /// Returns the number of the photograph whose light is farthest from what the others tell.
    pub(super) fn unlike(&self) -> Option<usize> {
        let scatter = self.fit.scatter.as_ref()?;
        let each = scatter.each.iter().enumerate();
        let farthest = each.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        Some(farthest.0)
    }

    /// Returns pairs of photographs that may have been exchanged: the worst one with each other
    /// one, and the worst few among themselves. A wrong photograph spoils the fit of others at its
    /// incidence, so the worst one need not be a wrong one.
    fn pairs(&self) -> Vec<[usize; 2]> {
        const FEW: usize = 5;
        let order = &self.goodness.worst_first;
        let pairs = (0..order.len().min(FEW)).flat_map(|i| {
            let last = if i == 0 { order.len() } else { FEW };
            let others = order.iter().take(last).skip(i + 1);
            others.map(move |&other| [order[i], other])
        });
        pairs.collect()
    }

    pub(super) fn alternative(
        &self,
        what: String,
        captures: Vec<String>,
        scene: Scene,
    ) -> Alternative {
        Alternative {
            what,
            captures,
            scene,
            choices: self.fuller(),
            cost: 0.0,
            is_blur: false,
        }
    }

    /// Returns the chosen candidate, and the one with both terms if the chosen one lacks one: the
    /// mistake may have hidden the other.
    pub(super) fn fuller(&self) -> Vec<Choice> {
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

    /// Adds exchanged incidences: of two angles, and of two photographs. Where
    /// all photographs have one incidence, those of the table take its place.
    pub(super) fn exchanged<'s>(&'s self, all: &mut Vec<Otherwise<'s>>) {
        let scene = self.scene;
        if let [own] = scene.groups[..] {
            let axis = self.table.axes.incidence_deg.iter();
            for &deg in axis.filter(|&&deg| deg != own) {
                let conditions = |shot: &Aerial| Conditions {
                    incidence_deg: deg,
                    ..shot.conditions()
                };
                self.add(
                    all,
                    format!("the incidence is {deg}, not {own} deg"),
                    &conditions,
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
                let conditions = |shot: &Aerial| Conditions {
                    incidence_deg: swapped(shot.incidence_deg, [a, b]),
                    ..shot.conditions()
                };
                let what = format!("the incidences {a} and {b} deg are exchanged");
                self.add(all, what, &conditions, None);
            }
        }
        for pair in self.pairs() {
            self.exchange(all, pair);
        }
        // The blur may fit at a wrong incidence, where the light does not.
        let mut doubtful: Vec<usize> = self.worst().into_iter().chain(self.unlike()).collect();
        doubtful.dedup();
        for Aerial { image, .. } in doubtful.into_iter().map(|i| &scene.shots[i]) {
            for &deg in &scene.groups {
                let what = format!("the incidence of {image} is {deg} deg");
                self.add_one(all, what, image, &|conditions| {
                    conditions.incidence_deg = deg;
                });
            }
        }
    }

    /// Adds two photographs with exchanged incidences, and with exchanged distances if these
    /// matter.
    fn exchange<'s>(&'s self, all: &mut Vec<Otherwise<'s>>, pair: [usize; 2]) {
        let [one, other] = pair.map(|number| &self.scene.shots[number]);
        let mut add = |what: &str, take: fn(&mut Conditions, Conditions)| {
            let conditions = |shot: &Aerial| {
                let mut conditions = shot.conditions();
                match &shot.image {
                    image if *image == one.image => take(&mut conditions, other.conditions()),
                    image if *image == other.image => take(&mut conditions, one.conditions()),
                    _ => {}
                }
                conditions
            };
            let [first, second] = [one, other].map(|shot| {
                let (deg, mm) = (shot.incidence_deg, shot.r_mm);
                format!("{} ({deg} deg, {mm} mm)", shot.image)
            });
            let what = format!("{what} {first} and {second} are exchanged");
            self.add(all, what, &conditions, None);
        };
        let deg_differ = one.incidence_deg != other.incidence_deg;
        if deg_differ {
            add("the incidences of", |own, other| {
                own.incidence_deg = other.incidence_deg;
            });
        }
        if one.r_mm != other.r_mm && self.uses_distances() {
            add("the floating distances of", |own, other| {
                own.r_mm = other.r_mm;
            });
            if deg_differ {
                add("the photographs", |own, other| {
                    own.incidence_deg = other.incidence_deg;
                    own.azimuth_deg = other.azimuth_deg;
                    own.r_mm = other.r_mm;
                });
            }
        }
    }

    /// Returns whether the blur of the fit depends on the distances.
    fn uses_distances(&self) -> bool {
        let Choice {
            kernel, further, ..
        } = self.fit.choice;
        matches!(kernel, Kernel::Angular | Kernel::Wave)
            || further.angular_spread
            || further.common_errors
    }

    /// Adds turned axes, other azimuths, and the other view of the sheet.
    pub(super) fn turned<'s>(&'s self, all: &mut Vec<Otherwise<'s>>) {
        let axis = |shot: &Aerial| Conditions {
            axis_turn_rad: shot.conditions().axis_turn_rad + std::f64::consts::FRAC_PI_2,
            ..shot.conditions()
        };
        self.add(
            all,
            "the tangential axis is off by 90 deg".into(),
            &axis,
            None,
        );
        let view = |shot: &Aerial| Conditions {
            seen_in_mirror: !shot.seen_in_mirror,
            ..shot.conditions()
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
            let conditions = |shot: &Aerial| Conditions {
                azimuth_deg: shot.direction.azimuth_deg.map(|deg| deg + by),
                ..shot.conditions()
            };
            let signed = if by > 0.5 * period { by - period } else { by };
            self.add(
                all,
                format!("the azimuth is off by {signed} deg"),
                &conditions,
                None,
            );
        }
    }

    /// Adds other tables, and other refractive indices.
    pub(super) fn of_another_sheet<'s>(&'s self, all: &mut Vec<Otherwise<'s>>) {
        let conditions: Vec<Conditions> = self.scene.shots.iter().map(Aerial::conditions).collect();
        for other in self.others {
            all.push(Otherwise {
                what: format!("the table of the sheet is {}", other.name),
                captures: Vec::new(),
                table: &other.table,
                index: None,
                conditions: conditions.clone(),
            });
        }
        let own = self.table.provenance.refractive_index;
        for index in INDICES
            .into_iter()
            .filter(|&index| (index - own).abs() > 0.01)
        {
            if let Some(other) = OtherIndex::of(self.table, index) {
                let what = format!("the refractive index is {index}, not {own}");
                self.add(all, what, &Aerial::conditions, Some(other));
            }
        }
    }

    /// Adds distances in another unit: of all photographs, and of single ones.
    fn at_other_distances<'s>(&'s self, all: &mut Vec<Otherwise<'s>>) {
        if !self.uses_distances() {
            return;
        }
        for (factor, unit) in [(10.0, "cm"), (0.1, "tenths of a mm")] {
            let conditions = |shot: &Aerial| Conditions {
                r_mm: factor * shot.r_mm,
                ..shot.conditions()
            };
            let what = format!("the floating distances are in {unit}, not in mm");
            self.add(all, what, &conditions, None);
            for Aerial { image, .. } in &self.scene.shots {
                let what = format!("the floating distance of {image} is in {unit}");
                self.add_one(all, what, image, &|conditions| conditions.r_mm *= factor);
            }
        }
    }

    /// Adds the other transfer: sRGB for linear values, or the reverse.
    pub(super) fn decoded_otherwise(&self, all: &mut Vec<Alternative>) {
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
        for shot in campaign.references.iter_mut().chain(shots) {
            shot.decode.transfer = Some(to);
        }
        let Ok(scene) = Scene::reported(&campaign, self.table, self.photo, &Progress::SILENT)
        else {
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
    pub(super) fn alone(&self, all: &mut Vec<Alternative>) {
        let shots = &self.scene.shots;
        let Some(i) = self.worst().filter(|_| shots.len() > 1) else {
            return;
        };
        let image = shots[i].image.clone();
        let own = self.goodness.degrees_of_freedom as f64 / shots.len() as f64;
        all.push(Alternative {
            // A photograph explains its own misfit whatever its cause, and chance moves its sum of
            // squares by this deviation. So a suspect that says why comes first.
            cost: SURE + (2.0 * own).sqrt(),
            ..self.alternative(
                format!("{image} alone does not agree with the others"),
                vec![image],
                self.scene.without(i),
            )
        });
    }

    /// Returns the kernels and lobes that were not among the candidates, and the waves if only
    /// their wavelength is missing.
    pub(super) fn not_tried(&self) -> Vec<Alternative> {
        let kernels = [Kernel::Eq1, Kernel::Angular, Kernel::Shift, Kernel::Lobe];
        let pairs = LobeShape::COMPARED.into_iter();
        let mut pairs: Vec<_> = pairs
            .flat_map(|shape| kernels.map(|kernel| (kernel, shape)))
            .collect();
        pairs.retain(|&(kernel, shape)| {
            let same =
                |own: Choice| own.kernel == kernel && (own.shape == shape || !kernel.has_lobe());
            !self.tried.iter().any(|row| same(row.choice))
        });
        let of_rays = pairs
            .into_iter()
            .map(|(kernel, shape)| self.of_blur_by(kernel, shape));
        let of_rays = of_rays.chain(self.of_waves());
        of_rays.chain(self.of_common_errors()).collect()
    }

    /// Returns dihedral errors that all cubes share, if the table says which cubes return the light.
    fn of_common_errors(&self) -> Option<Alternative> {
        let mut choice = self.fit.choice;
        choice.further.common_errors = possible(self.scene, choice.kernel).common_errors;
        if choice == self.fit.choice {
            return None;
        }
        let fit = self.at_least_anew(self.scene, &[choice])?.fit;
        let errors = Layout::of(choice, self.scene).common_errors();
        let errors: Vec<f64> = errors.map(|k| fit.solution.parameters[k]).collect();
        let what = format!(
            "the dihedral angles of all cubes are off by {}",
            edge_by_edge(&errors)
        );
        Some(Alternative {
            choices: vec![choice],
            cost: CLEAR,
            is_blur: true,
            ..self.alternative(what, Vec::new(), self.scene.clone())
        })
    }

    /// Returns the waves of the wavelength that fits best, if no wavelength is known and the table
    /// has waves.
    fn of_waves(&self) -> Option<Alternative> {
        if self.scene.spectrum.is_some() || wave::lacks_polarisation(self.table) {
            return None;
        }
        let choice = Choice {
            kernel: Kernel::Wave,
            per_angle_a: false,
            ..self.fit.choice
        };
        let conditions: Vec<Conditions> = self.scene.shots.iter().map(Aerial::conditions).collect();
        let of = |nm: f64| {
            let lit = Scene {
                spectrum: Some(Spectrum::monochromatic(nm).ok()?),
                ..self.scene.clone()
            };
            let scene = lit.perturbed(self.table, None, &conditions).ok()?;
            scene.waves().ok()?;
            let excess = self.at_least(&scene, &[choice])?.excess;
            Some((excess, nm, scene))
        };
        let all: Vec<_> = WAVELENGTHS_NM.into_par_iter().filter_map(of).collect();
        let (_, nm, scene) = all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let what = format!(
            "light spreads as waves do (kernel wave), which needs the wavelength: give \
            --wavelength-nm; of those tried, {nm} nm fits best"
        );
        Some(Alternative {
            choices: vec![choice],
            cost: CLEAR,
            is_blur: true,
            ..self.alternative(what, Vec::new(), scene)
        })
    }

    fn of_blur_by(&self, kernel: Kernel, shape: LobeShape) -> Alternative {
        let shaped = if kernel.has_lobe() {
            format!(" --lobe {}", shape.name())
        } else {
            String::new()
        };
        let what = format!("the blur is that of --kernel {}{shaped}", kernel.name());
        Alternative {
            choices: vec![Choice {
                kernel,
                shape,
                ..self.fit.choice
            }],
            cost: CLEAR,
            is_blur: true,
            ..self.alternative(what, Vec::new(), self.scene.clone())
        }
    }
}
