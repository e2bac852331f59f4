//! A scene ready to be fitted: all photographs measured, each with its direction of the table.
//!
//! Nothing rewrites a scene. One that is turned, or evaluated by samples, is another scene, which
//! shares the photographs.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use tables::{Direction, Table};

use crate::compare::Pixels;
use crate::compare::View;
use crate::estimate::facing::{Along, Facing, Returned};
use crate::estimate::reference;
use crate::estimate::reference::Reference;
use crate::estimate::remarks;
use crate::estimate::watch::{Cancelled, Step, Watch};
use crate::model::Camera;
use crate::model::wave;
use crate::names::Kernel;
use crate::names::Spectrum;
use crate::photographs::Measurement;
use crate::photographs::captures;
use crate::photographs::edge;
use crate::photographs::measure;
use crate::photographs::photo::plane::Photo;
use crate::photographs::{Campaign, Capture};
use crate::samples::Sampled;

/// Why a scene cannot be fitted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The manifest or a photograph.
    #[error(transparent)]
    Captures(#[from] captures::error::Error),
    /// The table has no such direction.
    #[error("{}: capture \"{image}\": {source}", manifest.display())]
    Direction {
        /// The manifest.
        manifest: PathBuf,
        /// The capture's image.
        image: String,
        /// What the table says. Boxed: every result of the crate would grow with it.
        source: Box<tables::Error>,
    },
    /// No edge in a photograph.
    #[error("{}: {fault}", image.display())]
    Edge {
        /// The photograph.
        image: PathBuf,
        /// What is wrong with it.
        fault: edge::fault::Fault,
    },
    /// It was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Nothing to fit.
    #[error("{}: no capture is left: nothing is retroreflected at any incidence of it; \
             photograph smaller incidence angles, or check azimuth_deg", manifest.display())]
    NothingLeft {
        /// The manifest.
        manifest: PathBuf,
    },
}

/// Where photographs come from.
pub(crate) type Source<'a> =
    dyn Fn(&captures::Shot) -> Result<Photo, captures::error::Error> + Sync + 'a;

/// One photograph of the mid-air edge, and what the table makes of it.
#[derive(Clone)]
pub struct Aerial {
    /// File name as the manifest gives it.
    pub image: String,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Floating distance (optical path), mm.
    pub r_mm: f64,
    /// Index into [`Scene::groups`].
    pub group: usize,
    /// Relative exposure.
    pub exposure: f64,
    /// The photograph, measured once and shared by every scene that shows it.
    pub view: Arc<View>,
    /// Its pixels, shared likewise.
    pub pixels: Arc<Pixels>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Its direction of the table.
    pub facing: Facing,
    /// Its samples, where its model is evaluated by them.
    pub sampled: Option<Sampled>,
}

impl Aerial {
    /// The share of the light that returns before mu, as a kernel has it.
    pub fn returned(&self, kernel: Kernel) -> Returned {
        self.facing.returned_as(kernel)
    }

    /// The same photograph, faced otherwise, in closed form.
    fn faced(&self, facing: Facing) -> Aerial {
        Aerial {
            image: self.image.clone(),
            incidence_deg: self.incidence_deg,
            r_mm: self.r_mm,
            group: self.group,
            exposure: self.exposure,
            view: Arc::clone(&self.view),
            pixels: Arc::clone(&self.pixels),
            warnings: self.warnings.clone(),
            facing,
            sampled: None,
        }
    }
}

/// The photographs of a campaign, measured.
#[derive(Clone)]
pub struct Scene {
    /// Photographs, in the order of the manifest; those without retroreflection are left out.
    pub shots: Vec<Aerial>,
    /// Distinct incidence angles, degrees, ascending.
    pub groups: Vec<f64>,
    /// The source edge.
    pub reference: Option<Arc<Reference>>,
    /// The camera: pixel box, and the reference's lens.
    pub camera: Camera,
    /// Transmittance times reflectance of the half mirror.
    pub half_mirror: f64,
    /// Wavelengths of the source, where the campaign names them.
    pub spectrum: Option<Spectrum>,
    /// What the user should know about the campaign.
    pub warnings: Vec<String>,
}

/// What a campaign without a reference is told, once: the manifest may have said it already.
const NO_REFERENCE: &str = "no [reference]";

impl Scene {
    /// Reads and measures all photographs of a campaign, in parallel.
    ///
    /// # Errors
    /// A photograph that cannot be read or holds no edge; a direction that the table neither has
    /// nor brackets; no capture with any retroreflection.
    pub fn load(campaign: &Campaign, table: &Table) -> Result<Scene, Error> {
        Scene::of(campaign, table, &captures::Shot::load)
    }

    /// Measures photographs that `photo` hands out, wherever it has them from.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn of(campaign: &Campaign, table: &Table, photo: &Source) -> Result<Scene, Error> {
        Scene::watched(campaign, table, photo, &Watch::NOBODY)
    }

    /// Measures photographs and says which are done.
    ///
    /// # Errors
    /// As [`Scene::load`]; [`Error::Cancelled`].
    pub fn watched(
        campaign: &Campaign,
        table: &Table,
        photo: &Source,
        watch: &Watch,
    ) -> Result<Scene, Error> {
        let setup = &campaign.setup;
        let mut warnings = campaign.warnings.clone();
        warnings.extend(remarks::of_table(table, campaign));
        let reference = source_edge(campaign, photo, &mut warnings)?;
        let camera = reference.as_ref().map_or_else(
            || Camera {
                pitch_mm: setup.pixel_pitch_mm,
                lens: None,
            },
            |r| r.camera,
        );
        let measuring = Measuring {
            campaign,
            table,
            photo,
            camera,
        };
        let (done, of) = (AtomicUsize::new(0), campaign.captures.len());
        let read: Vec<Option<Aerial>> = campaign
            .captures
            .par_iter()
            .map(|capture| {
                let aerial = measuring.aerial(capture)?;
                let done = 1 + done.fetch_add(1, Ordering::Relaxed);
                watch.done(Step::Photographs { done, of })?;
                Ok(aerial)
            })
            .collect::<Result<_, Error>>()?;
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
            return Err(Error::NothingLeft {
                manifest: campaign.file.clone(),
            });
        }
        let groups = group(&mut shots);
        Ok(Scene {
            shots,
            groups,
            reference: reference.map(Arc::new),
            camera,
            half_mirror: setup.half_mirror_transmittance * setup.half_mirror_reflectance,
            spectrum: setup.spectrum.clone(),
            warnings,
        })
    }

    /// The same photographs with other ones in place of each.
    fn with(&self, shots: Vec<Aerial>) -> Scene {
        Scene {
            shots,
            groups: self.groups.clone(),
            reference: self.reference.clone(),
            spectrum: self.spectrum.clone(),
            warnings: self.warnings.clone(),
            ..*self
        }
    }

    /// The same photographs at other azimuths, degrees, in closed form. Nothing is measured again.
    ///
    /// # Errors
    /// A direction that the table neither has nor brackets.
    pub fn turned(&self, table: &Table, azimuths_deg: &[f64]) -> Result<Scene, tables::Error> {
        let turned = |(shot, &azimuth_deg): (&Aerial, &f64)| {
            let direction = table.direction(shot.incidence_deg, Some(azimuth_deg))?;
            Ok(shot.faced(if direction.eta > 0.0 {
                Facing::new(
                    &direction,
                    Some(azimuth_deg),
                    shot.facing.refractive_index,
                    Along {
                        incidence_rad: shot.incidence_deg.to_radians(),
                        normal: shot.view.normal(),
                        spectrum: self.spectrum.as_ref(),
                    },
                )
            } else {
                shot.facing.dark(&direction, azimuth_deg)
            }))
        };
        let shots = self.shots.iter().zip(azimuths_deg).map(turned);
        Ok(self.with(shots.collect::<Result<_, tables::Error>>()?))
    }

    /// The same photographs, each model evaluated by samples.
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

    /// Whether light returns in every photograph.
    pub fn is_lit(&self) -> bool {
        self.shots.iter().all(|shot| shot.facing.returned.eta > 0.0)
    }

    /// The azimuths of all photographs, degrees; 0 where one needs none.
    pub fn azimuths_deg(&self) -> Vec<f64> {
        let own = |shot: &Aerial| shot.facing.azimuth_deg.unwrap_or(0.0);
        self.shots.iter().map(own).collect()
    }

    /// Whether every photograph has waves.
    ///
    /// # Errors
    /// What the first of the others lacks.
    pub fn waves(&self) -> Result<(), wave::Fault> {
        let wave = |shot: &Aerial| shot.facing.wave.as_ref().map(|_| ()).map_err(Clone::clone);
        self.shots.iter().try_for_each(wave)
    }

    /// mu of one photograph from the step of its edge under a kernel; NaN without a reference.
    pub fn reflectance(&self, shot: &Aerial, kernel: Kernel, step: f64) -> f64 {
        self.reference.as_ref().map_or(f64::NAN, |r| {
            step / shot.exposure / (r.step * shot.returned(kernel).eta * self.half_mirror)
        })
    }

    /// Mean floating distance, mm.
    pub fn mean_distance_mm(&self) -> f64 {
        self.shots.iter().map(|s| s.r_mm).sum::<f64>() / self.shots.len() as f64
    }
}

/// The file's name without its folder.
fn name(path: &std::path::Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// Distinct incidence angles, ascending; every photograph is told which one is its own.
fn group(shots: &mut [Aerial]) -> Vec<f64> {
    let mut groups: Vec<f64> = shots.iter().map(|s| s.incidence_deg).collect();
    groups.sort_by(f64::total_cmp);
    groups.dedup();
    for shot in shots {
        let own = groups.iter().position(|&g| g == shot.incidence_deg);
        shot.group = own.unwrap_or(0);
    }
    groups
}

/// Measures the reference, where there is one.
fn source_edge(
    campaign: &Campaign,
    photo: &Source,
    warnings: &mut Vec<String>,
) -> Result<Option<Reference>, Error> {
    let Some(shot) = &campaign.reference else {
        if !warnings.iter().any(|said| said.contains(NO_REFERENCE)) {
            warnings.push(format!(
                "{NO_REFERENCE} photograph: the camera is taken for its pixel box alone, and mu \
                cannot be found"
            ));
        }
        return Ok(None);
    };
    let pitch_mm = campaign.setup.pixel_pitch_mm;
    let pixel = Camera {
        pitch_mm,
        lens: None,
    };
    let (view, pixels, notes) = measure(shot, photo, pitch_mm, 0.0, &pixel)?;
    let name = name(&shot.image);
    warnings.extend(notes.into_iter().map(|note| format!("{name}: {note}")));
    Ok(Some(reference::measure(&view, pixels, shot.exposure)))
}

/// Decodes a photograph, finds its edge and sorts its pixels.
fn measure(
    shot: &captures::Shot,
    photo: &Source,
    pitch_mm: f64,
    tangential_rad: f64,
    camera: &Camera,
) -> Result<(View, Pixels, Vec<String>), Error> {
    let photo = photo(shot)?;
    let fault = |fault| Error::Edge {
        image: shot.image.clone(),
        fault,
    };
    let Measurement {
        window,
        line,
        profile,
        warnings,
        ..
    } = measure::edge(&photo, shot.roi, &shot.accepted).map_err(fault)?;
    let pixels = Pixels::new(&window, &line);
    Ok((
        View::new(line, profile, pitch_mm, tangential_rad, camera),
        pixels,
        warnings,
    ))
}

/// What every photograph of a campaign is measured with.
struct Measuring<'a> {
    campaign: &'a Campaign,
    table: &'a Table,
    photo: &'a Source<'a>,
    camera: Camera,
}

impl Measuring<'_> {
    /// One photograph; `None` where the table says that nothing returns.
    fn aerial(&self, capture: &Capture) -> Result<Option<Aerial>, Error> {
        let image = name(&capture.shot.image);
        let direction = self
            .table
            .direction(capture.incidence_deg, capture.azimuth_deg)
            .map_err(|source| Error::Direction {
                manifest: self.campaign.file.clone(),
                image: image.clone(),
                source: Box::new(source),
            })?;
        if direction.eta <= 0.0 {
            return Ok(None);
        }
        let setup = &self.campaign.setup;
        let (view, pixels, mut warnings) = measure(
            &capture.shot,
            self.photo,
            setup.pixel_pitch_mm,
            capture.tangential_axis_rad(),
            &self.camera,
        )?;
        warnings.extend(self.between(capture, &direction));
        let along = Along {
            incidence_rad: capture.incidence_rad(),
            normal: view.normal(),
            spectrum: setup.spectrum.as_ref(),
        };
        let index = self.table.provenance.refractive_index;
        Ok(Some(Aerial {
            image,
            incidence_deg: capture.incidence_deg,
            r_mm: capture.range_mm(),
            group: 0,
            exposure: capture.shot.exposure,
            view: Arc::new(view),
            pixels: Arc::new(pixels),
            warnings,
            facing: Facing::new(&direction, capture.azimuth_deg, index, along),
            sampled: None,
        }))
    }

    /// What to say of a direction that the table does not hold.
    fn between(&self, capture: &Capture, direction: &Direction) -> Option<String> {
        // The tolerance is one of polygons; where they do not tell, bins are mixed.
        let tolerance = self.table.provenance.direction_tolerance;
        let within = tolerance.is_some() && direction.paths.is_some();
        (direction.interpolated && !within).then(|| {
            format!(
                "incidence {} deg is interpolated between directions of the table; bake it for \
                full accuracy",
                capture.incidence_deg
            )
        })
    }
}
