//! A scene, ready for fitting: all photographs of a campaign, measured, each with its direction of
//! the table.
//!
//! Nothing rewrites a scene. Placing it otherwise, or evaluating it by samples, makes another scene
//! that shares the photographs.

pub mod direction;
pub(crate) mod empirical;
mod measuring;
pub(crate) mod optics;
pub(crate) mod perturbed;
pub(crate) mod reference;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use tables::Table;

use crate::compare::Pixels;
use crate::compare::View;
use crate::error::Error;
use crate::estimate::progress::{Progress, Step};
use crate::estimate::remarks;
use crate::estimate::scene::direction::{ProjectedDirection, Returned};
use crate::estimate::scene::measuring::{Found, Measuring, name, source_edge};
use crate::estimate::scene::optics::Optics;
use crate::estimate::scene::reference::Reference;
use crate::model::wave;
use crate::samples::Sampled;
use edges::names::Kernel;
use edges::names::{Ghost, Spectrum};
use edges::photographs::Campaign;
use edges::photographs::manifest::captures;
use edges::photographs::photo::plane::Photo;
use edges::photographs::photo::taken::Taken;

/// Function that supplies the photograph of a shot.
pub type Source<'a> = dyn Fn(&captures::Shot) -> Result<Photo, captures::Error> + Sync + 'a;

/// Place of a photograph in its scene: what it shares with which others.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Place {
    /// Index into [`Scene::groups`].
    pub group: usize,
    /// Index into [`Scene::distances_mm`].
    pub distance: usize,
}

/// One photograph of the mid-air edge, with its direction of the table.
#[derive(Clone)]
pub struct Aerial {
    /// File name as in the manifest.
    pub image: String,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Floating distance (optical path R), mm.
    pub r_mm: f64,
    /// Floating distance as the manifest states it, mm, by which photographs share a focus.
    pub floating_distance_mm: f64,
    /// Incidence and distance among those of the scene.
    pub place: Place,
    /// Exposure relative to that of the reference.
    pub exposure: f64,
    /// Relative error of the exposure by rounded shutter times, see [`captures::Shot::rounding`].
    pub rounding: Option<f64>,
    /// Relation between stored values and light that was taken for the photograph.
    pub transfer: Taken,
    /// Number of times, as a variance, that the noise on the edge exceeds that beside it, if the
    /// camera reduced the latter.
    pub reduced_noise: Option<f64>,
    /// Measured edge, shared by all scenes of this photograph.
    pub view: Arc<View>,
    /// Pixels of the photograph, shared by all its scenes.
    pub pixels: Arc<Pixels>,
    /// Warnings about the photograph, one sentence each.
    pub warnings: Vec<String>,
    /// Direction of the table for this photograph.
    pub direction: ProjectedDirection,
    /// True if the camera saw the sheet in the half mirror.
    pub seen_in_mirror: bool,
    /// Second image of a thick half mirror.
    pub ghost: Option<Ghost>,
    /// Angle by which the tangential axis lies further than the manifest says, from +x towards +y,
    /// radians; 0 except in a scene of [`Scene::perturbed`].
    pub axis_turn_rad: f64,
    /// Samples of the photograph, if its model is evaluated by samples.
    pub sampled: Option<Sampled>,
}

impl Aerial {
    /// Returns the edge normal in the mid-air image, (tangential, sagittal).
    pub fn normal(&self) -> [f64; 2] {
        let (sin, cos) = self.axis_turn_rad.sin_cos();
        let [along, clockwise] = self.view.normal();
        let turned = [along * cos + clockwise * sin, clockwise * cos - along * sin];
        captures::in_image(turned, self.seen_in_mirror)
    }

    /// Returns the share of the light that returns before mu, as a kernel counts it.
    pub fn returned(&self, kernel: Kernel) -> Returned {
        self.direction.returned_as(kernel)
    }
}

/// Measured photographs of a campaign.
#[derive(Clone)]
pub struct Scene {
    /// Photographs in the order of the manifest, without those that return no light.
    pub shots: Vec<Aerial>,
    /// Different incidences, degrees, ascending.
    pub groups: Vec<f64>,
    /// Different floating distances, mm, ascending.
    pub distances_mm: Vec<f64>,
    /// Measured references: the photographs of the source edge.
    pub reference: Option<Arc<Reference>>,
    /// Camera: box of a pixel, and the lens. Without a reference the lens is assumed.
    pub optics: Optics,
    /// Transmittance times reflectance of the half mirror.
    pub half_mirror: f64,
    /// Wavelengths of the source, if the campaign names them.
    pub spectrum: Option<Spectrum>,
    /// Warnings about the campaign, one sentence each.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Reads and measures all photographs of a campaign, in parallel.
    ///
    /// # Errors
    /// Returns [`Error::Captures`] if a photograph cannot be read, [`Error::Edge`] if it has no
    /// usable edge, [`Error::Direction`] if the table neither holds nor brackets its direction, and
    /// [`Error::NothingLeft`] if no capture returns light.
    pub fn load(campaign: &Campaign, table: &Table) -> Result<Scene, Error> {
        Scene::of(campaign, table, &captures::Shot::load)
    }

    /// Measures the photographs of a campaign that `photo` supplies, in parallel.
    ///
    /// # Errors
    /// Returns [`Error::Captures`] if `photo` fails, [`Error::Edge`] if a photograph has no usable
    /// edge, [`Error::Direction`] if the table neither holds nor brackets its direction, and
    /// [`Error::NothingLeft`] if no capture returns light.
    pub fn of(campaign: &Campaign, table: &Table, photo: &Source) -> Result<Scene, Error> {
        Scene::reported(campaign, table, photo, &Progress::SILENT)
    }

    /// Measures the photographs of a campaign and reports each one to `progress`.
    ///
    /// # Errors
    /// Returns [`Error::Captures`] if `photo` fails, [`Error::Edge`] if a photograph has no usable
    /// edge, [`Error::Direction`] if the table neither holds nor brackets its direction,
    /// [`Error::NothingLeft`] if no capture returns light, [`Error::Sharper`] if a capture is
    /// sharper than the reference, and [`Error::Cancelled`] if the flag of `progress` is set.
    pub fn reported(
        campaign: &Campaign,
        table: &Table,
        photo: &Source,
        progress: &Progress,
    ) -> Result<Scene, Error> {
        let setup = &campaign.setup;
        let mut warnings = campaign.warnings.clone();
        warnings.extend(remarks::of_table(table, campaign));
        let measuring = Measuring {
            campaign,
            table,
            photo,
        };
        let (done, of) = (AtomicUsize::new(0), campaign.captures.len());
        let found = || {
            let captures = campaign.captures.par_iter();
            let all = captures.map(|capture| {
                let found = measuring.found(capture)?;
                let done = 1 + done.fetch_add(1, Ordering::Relaxed);
                progress.done(Step::Photographs { done, of })?;
                Ok(found)
            });
            all.collect::<Result<Vec<Option<Found>>, Error>>()
        };
        // The edges are found without the camera that the reference shows.
        let (source, found) = rayon::join(|| source_edge(campaign, photo, &mut warnings), found);
        let (reference, optics) = source?;
        let captures = campaign.captures.par_iter().zip(found?);
        let read: Vec<Option<Aerial>> = captures
            .map(|(capture, found)| Some(measuring.aerial(capture, found?, &optics.camera)))
            .collect();
        for (capture, _) in campaign
            .captures
            .iter()
            .zip(&read)
            .filter(|(_, shot)| shot.is_none())
        {
            warnings.push(format!(
                "{}: left out: the table says that nothing is retroreflected at incidence {} deg",
                name(&capture.shot.image),
                capture.incidence_deg
            ));
        }
        let mut shots: Vec<Aerial> = read.into_iter().flatten().collect();
        if shots.is_empty() {
            return Err(Error::NothingLeft(campaign.file.clone()));
        }
        warnings.extend(remarks::of_bins(
            table,
            shots
                .iter()
                .map(|shot| (&*shot.image, shot.r_mm, &*shot.view)),
        ));
        let (groups, distances_mm) = placed(&mut shots);
        if let Some(reference) = &reference {
            let sharper = shots
                .iter()
                .find(|shot| reference.is_blunter_than(&shot.view));
            if let Some(shot) = sharper {
                return Err(Error::Sharper {
                    manifest: campaign.file.clone(),
                    image: shot.image.clone(),
                });
            }
            let directions = shots.iter().map(|shot| (&*shot.image, &*shot.view));
            warnings.extend(remarks::of_directions(
                reference,
                &optics.camera,
                directions,
            ));
            let read = shots.iter().map(|shot| (&*shot.image, &shot.transfer));
            warnings.extend(remarks::of_transfers(&reference.transfer, read));
        }
        Ok(Scene {
            shots,
            groups,
            distances_mm,
            reference: reference.map(Arc::new),
            optics,
            half_mirror: setup.half_mirror_transmittance * setup.half_mirror_reflectance,
            spectrum: setup.spectrum.clone(),
            warnings,
        })
    }

    /// Returns the scene with these photographs instead of its own.
    pub(super) fn with(&self, mut shots: Vec<Aerial>) -> Scene {
        let (groups, distances_mm) = placed(&mut shots);
        Scene {
            shots,
            groups,
            distances_mm,
            reference: self.reference.clone(),
            optics: self.optics.clone(),
            half_mirror: self.half_mirror,
            spectrum: self.spectrum.clone(),
            warnings: self.warnings.clone(),
        }
    }

    /// Returns the scene without one of its photographs. It must have another one.
    pub fn without(&self, left_out: usize) -> Scene {
        let mut shots = self.shots.clone();
        shots.remove(left_out);
        self.with(shots)
    }

    /// Returns the scene with samples, by which the model of each photograph is evaluated.
    pub fn sampled(&self, samples: Vec<Sampled>) -> Scene {
        let shots = self
            .shots
            .iter()
            .zip(samples)
            .map(|(shot, sampled)| Aerial {
                sampled: Some(sampled),
                ..shot.clone()
            });
        self.with(shots.collect())
    }

    /// Returns the scene without samples, so that its model is evaluated in closed form.
    pub(super) fn in_closed_form(&self) -> Scene {
        let shots = self.shots.iter().map(|shot| Aerial {
            sampled: None,
            ..shot.clone()
        });
        self.with(shots.collect())
    }

    /// Returns whether light returns in every photograph.
    pub fn is_lit(&self) -> bool {
        self.shots
            .iter()
            .all(|shot| shot.direction.returned.retroreflected > 0.0)
    }

    /// Returns the azimuths of all photographs, degrees; 0 for a photograph that needs none.
    pub fn azimuths_deg(&self) -> Vec<f64> {
        let own = |shot: &Aerial| shot.direction.azimuth_deg.unwrap_or(0.0);
        self.shots.iter().map(own).collect()
    }

    /// Checks that the wave kernel can be computed for every photograph.
    ///
    /// # Errors
    /// Returns the [`wave::Fault`] of the first photograph without waves.
    pub fn waves(&self) -> Result<(), wave::Fault> {
        let wave = |shot: &Aerial| {
            shot.direction
                .wave
                .as_ref()
                .map(|_| ())
                .map_err(Clone::clone)
        };
        self.shots.iter().try_for_each(wave)
    }

    /// Computes mu of one photograph from the step of its edge under a kernel. The result is NaN
    /// without a reference.
    pub fn reflectance(&self, shot: &Aerial, kernel: Kernel, step: f64) -> f64 {
        self.reference.as_ref().map_or(f64::NAN, |r| {
            step / shot.exposure
                / (r.step * shot.returned(kernel).retroreflected * self.half_mirror)
        })
    }

    /// Returns the largest angle between the edge of a photograph and that of the nearest reference,
    /// degrees, or `None` without a reference.
    pub fn farthest_from_reference_deg(&self) -> Option<f64> {
        let reference = self.reference.as_ref()?;
        let all = self.shots.iter();
        let off = all.map(|shot| reference.nearest(shot.view.line.normal_rad).1);
        Some(off.fold(0.0, f64::max).to_degrees())
    }

    /// Returns whether there are several photographs at each floating distance.
    pub fn repeats_distances(&self) -> bool {
        let at = |distance: usize| {
            let shots = self.shots.iter();
            shots.filter(move |shot| shot.place.distance == distance)
        };
        (0..self.distances_mm.len()).all(|distance| at(distance).count() > 1)
    }

    /// Returns the mean floating distance, mm.
    pub fn mean_distance_mm(&self) -> f64 {
        self.shots.iter().map(|s| s.r_mm).sum::<f64>() / self.shots.len() as f64
    }
}

/// Sets the place of each photograph. Returns the different incidences (degrees) and floating distances
/// (mm), both ascending.
fn placed(shots: &mut [Aerial]) -> (Vec<f64>, Vec<f64>) {
    let different = |of: fn(&Aerial) -> f64, shots: &[Aerial]| {
        let mut all: Vec<f64> = shots.iter().map(of).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let groups = different(|shot| shot.incidence_deg, shots);
    let distances_mm = different(|shot| shot.floating_distance_mm, shots);
    for shot in shots {
        let index = |all: &[f64], own: f64| all.iter().position(|&other| other == own);
        shot.place = Place {
            group: index(&groups, shot.incidence_deg).unwrap_or(0),
            distance: index(&distances_mm, shot.floating_distance_mm).unwrap_or(0),
        };
    }
    (groups, distances_mm)
}
