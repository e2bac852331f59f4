//! A scene ready to be fitted: all photographs measured, each with its direction of the table.

use std::path::PathBuf;

use rayon::prelude::*;
use tables::Table;
use tables::options::Element;

use crate::compare::pixels::Pixels;
use crate::compare::view::View;
use crate::estimate::reference;
use crate::estimate::reference::Reference;
use crate::model::baseline;
use crate::model::camera::Camera;
use crate::model::kernel::Kernel;
use crate::model::wave;
use crate::photographs::captures;
use crate::photographs::captures::{Campaign, Capture, Spectrum};
use crate::photographs::edge;
use crate::photographs::measure;
use crate::photographs::measure::Measurement;
use crate::photographs::photo::Photo;
use tables::ShiftLine;
use tables::WaveLine;

/// Why a scene cannot be fitted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The manifest or a photograph.
    #[error(transparent)]
    Captures(#[from] captures::Error),
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
        fault: edge::Fault,
    },
    /// Nothing to fit.
    #[error("{}: no capture is left: nothing is retroreflected at any incidence of it; \
             photograph smaller incidence angles, or check azimuth_deg", manifest.display())]
    NothingLeft {
        /// The manifest.
        manifest: PathBuf,
    },
}

/// Where photographs come from.
pub type Source<'a> = dyn Fn(&captures::Shot) -> Result<Photo, captures::Error> + Sync + 'a;

/// One photograph of the mid-air edge.
pub struct Aerial {
    /// File name as the manifest gives it.
    pub image: String,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; `None` where a table of the mean over azimuths needs none.
    pub azimuth_deg: Option<f64>,
    /// Floating distance (optical path), mm.
    pub r_mm: f64,
    /// Index into [`Scene::groups`].
    pub group: usize,
    /// Relative exposure.
    pub exposure: f64,
    /// Retroreflected fraction at this direction, > 0; see [`Scene::returning_as`].
    pub eta: f64,
    /// Its standard error from the table's rays.
    pub eta_standard_error: f64,
    /// Of the sheet's front face; 1 for hollow cubes.
    pub refractive_index: f64,
    /// Shift along the edge normal.
    pub shift: Option<ShiftLine>,
    /// Waves along the edge normal, where the campaign names wavelengths and the table allows.
    pub wave: Result<WaveLine, wave::Fault>,
    /// The photograph, measured.
    pub view: View,
    /// Its pixels.
    pub pixels: Pixels,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl Aerial {
    /// Standard error of eta over eta.
    pub fn eta_relative_error(&self) -> f64 {
        self.eta_standard_error / self.eta
    }
}

/// The photographs of a campaign, measured.
pub struct Scene {
    /// Photographs, in the order of the manifest; those without retroreflection are left out.
    pub shots: Vec<Aerial>,
    /// Distinct incidence angles, degrees, ascending.
    pub groups: Vec<f64>,
    /// The source edge.
    pub reference: Option<Reference>,
    /// The camera: pixel box, and the reference's lens.
    pub camera: Camera,
    /// Transmittance times reflectance of the half mirror.
    pub half_mirror: f64,
    /// Wavelengths of the source, where the campaign names them.
    pub spectrum: Option<Spectrum>,
    /// What the user should know about the campaign.
    pub warnings: Vec<String>,
}

/// How far the table's light goes from straight back, rad, if it says so and that is seen.
fn deviates(table: &Table) -> Option<f64> {
    let of_beams = || {
        let exact = table.exact.as_ref().filter(|exact| exact.deviates())?;
        Some(exact.largest_deviation_rad())
    };
    let of_rays = table.deviations.as_ref().map(|found| {
        let spreads = (0..found.entries.len()).map(|direction| found.spread(direction));
        spreads.map(|spread| spread.largest_rad).fold(0.0, f64::max)
    });
    of_rays.or_else(of_beams)
}

impl Scene {
    /// Reads and measures all photographs of a campaign, in parallel.
    ///
    /// # Errors
    /// A photograph that cannot be read or holds no edge; a direction that the table neither has nor brackets; no capture
    /// with any retroreflection.
    pub fn load(campaign: &Campaign, table: &Table) -> Result<Scene, Error> {
        Scene::of(campaign, table, &captures::Shot::load)
    }

    /// Measures photographs that `photo` hands out, wherever it has them from.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn of(campaign: &Campaign, table: &Table, photo: &Source) -> Result<Scene, Error> {
        let pitch_mm = campaign.setup.pixel_pitch_mm;
        let mut warnings = campaign.warnings.clone();
        let pixel = Camera {
            pitch_mm,
            lens: None,
        };
        if table.axes.is_mean() && campaign.captures.iter().any(|c| c.azimuth_deg.is_some()) {
            warnings.push(
                "the table is a mean over azimuths: azimuth_deg of the captures has no effect; bake the azimuths to use it".into(),
            );
        }
        let losses = table.provenance.losses_text();
        if losses != "none" {
            warnings.push(format!(
                "the table holds the losses of the surfaces ({losses}): mu carries what is left, not them"
            ));
        }
        if let (Some(baked), Some(source)) =
            (table.provenance.wavelength_nm, &campaign.setup.spectrum)
            && source
                .lines()
                .iter()
                .all(|line| (line.wavelength_nm - baked).abs() > 1.0)
        {
            warnings.push(format!(
                "the table is baked for {baked} nm, which is none of the source's wavelengths; bake one for them"
            ));
        }
        if table.provenance.element() == Element::Plate {
            warnings.push(
                "the table is of a micro-mirror array plate: c is the pitch of its mirrors, floating distances count from its \
                 middle plane, and half_mirror_transmittance and _reflectance are 1 where there is no half mirror"
                    .into(),
            );
        }
        if table.provenance.has_glass() {
            warnings.push(
                "the table is of bodies of glass, whose light returns in a cone as wide as its angular tolerance: c is the pitch, \
                 and a is what blur the recorded directions leave over, not a cube's aperture"
                    .into(),
            );
        }
        if let Some(largest) = deviates(table) {
            let held = match table.exact {
                Some(_) => " where the table gives polygons",
                None => "",
            };
            warnings.push(format!(
                "the table's cubes send light up to {:.3} mrad from straight back: the model has it{held}",
                1e3 * largest
            ));
        }
        let reference = match &campaign.reference {
            None => {
                warnings.push(
                    "no [reference] photograph: the camera is taken for its pixel box alone, and mu cannot be found".into(),
                );
                None
            }
            Some(shot) => {
                let (mut view, pixels, notes) = measure(shot, photo, pitch_mm, 0.0, &pixel)?;
                warnings.extend(
                    notes
                        .into_iter()
                        .map(|note| format!("{}: {note}", name(&shot.image))),
                );
                Some(reference::measure(&mut view, pixels, shot.exposure))
            }
        };
        let camera = reference.as_ref().map_or(pixel, |r| r.camera);
        let read: Vec<Option<Aerial>> = campaign
            .captures
            .par_iter()
            .map(|capture| aerial(campaign, capture, table, photo, &camera))
            .collect::<Result<_, _>>()?;
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
        let mut groups: Vec<f64> = shots.iter().map(|s| s.incidence_deg).collect();
        groups.sort_by(f64::total_cmp);
        groups.dedup();
        for shot in &mut shots {
            shot.group = groups
                .iter()
                .position(|&g| g == shot.incidence_deg)
                .unwrap_or(0);
        }
        let setup = &campaign.setup;
        let half_mirror = setup.half_mirror_transmittance * setup.half_mirror_reflectance;
        Ok(Scene {
            shots,
            groups,
            reference,
            camera,
            half_mirror,
            spectrum: setup.spectrum.clone(),
            warnings,
        })
    }

    /// Looks up the direction of every photograph again, at other azimuths, degrees; says whether light returns in all.
    ///
    /// # Errors
    /// A direction that the table neither has nor brackets.
    pub fn turn(&mut self, table: &Table, azimuths_deg: &[f64]) -> Result<bool, tables::Error> {
        let mut returns = true;
        for (shot, &azimuth_deg) in self.shots.iter_mut().zip(azimuths_deg) {
            let direction = table.direction(shot.incidence_deg, Some(azimuth_deg))?;
            shot.azimuth_deg = Some(azimuth_deg);
            (shot.eta, shot.eta_standard_error) = (direction.eta, direction.standard_error);
            if direction.eta <= 0.0 {
                returns = false;
                continue;
            }
            let (incidence, normal) = (shot.incidence_deg.to_radians(), shot.view.normal());
            shot.shift = ShiftLine::new(&direction, incidence, normal);
            shot.wave = wave::line(&direction, incidence, normal, self.spectrum.as_ref());
        }
        Ok(returns)
    }

    /// Replaces the retroreflected fraction of every photograph by what a kernel makes of it, so that mu is that of its model.
    pub fn returning_as(&mut self, kernel: Kernel) {
        for shot in &mut self.shots {
            let (incidence, index) = (shot.incidence_deg.to_radians(), shot.refractive_index);
            let returned = |eta| baseline::returned(kernel, eta, incidence, index);
            shot.eta_standard_error =
                returned(shot.eta + shot.eta_standard_error) - returned(shot.eta);
            shot.eta = returned(shot.eta);
        }
    }

    /// Whether every photograph has waves.
    ///
    /// # Errors
    /// What the first of the others lacks.
    pub fn waves(&self) -> Result<(), wave::Fault> {
        self.shots
            .iter()
            .try_for_each(|shot| shot.wave.as_ref().map(|_| ()).map_err(Clone::clone))
    }

    /// Names of one parameter's entries: `name`, or `name_at_<incidence>` for every group.
    pub fn names(&self, name: &str, count: usize, per_angle: bool) -> Vec<String> {
        if per_angle {
            self.groups
                .iter()
                .take(count)
                .map(|g| format!("{name}_at_{g}"))
                .collect()
        } else {
            vec![name.to_owned(); count]
        }
    }

    /// mu of one photograph from the step of its edge; NaN without a reference.
    pub fn reflectance(&self, shot: &Aerial, step: f64) -> f64 {
        self.reference.as_ref().map_or(f64::NAN, |r| {
            step / shot.exposure / (r.step * shot.eta * self.half_mirror)
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

fn aerial(
    campaign: &Campaign,
    capture: &Capture,
    table: &Table,
    photo: &Source,
    camera: &Camera,
) -> Result<Option<Aerial>, Error> {
    let image = name(&capture.shot.image);
    let direction = table
        .direction(capture.incidence_deg, capture.azimuth_deg)
        .map_err(|source| Error::Direction {
            manifest: campaign.file.clone(),
            image: image.clone(),
            source: Box::new(source),
        })?;
    if direction.eta <= 0.0 {
        return Ok(None);
    }
    let (view, pixels, mut warnings) = measure(
        &capture.shot,
        photo,
        campaign.setup.pixel_pitch_mm,
        capture.tangential_axis_rad(),
        camera,
    )?;
    // The tolerance is one of polygons; where they do not tell, bins are mixed.
    let within = table.provenance.direction_tolerance.is_some() && direction.paths.is_some();
    if direction.interpolated && !within {
        warnings.push(format!(
            "incidence {} deg is interpolated between directions of the table; bake it for full accuracy",
            capture.incidence_deg
        ));
    }
    let normal = view.normal();
    let spectrum = campaign.setup.spectrum.as_ref();
    Ok(Some(Aerial {
        image,
        incidence_deg: capture.incidence_deg,
        azimuth_deg: capture.azimuth_deg,
        r_mm: capture.range_mm(),
        group: 0,
        exposure: capture.shot.exposure,
        eta: direction.eta,
        eta_standard_error: direction.standard_error,
        refractive_index: table.provenance.refractive_index,
        shift: ShiftLine::new(&direction, capture.incidence_rad(), normal),
        wave: wave::line(&direction, capture.incidence_rad(), normal, spectrum),
        view,
        pixels,
        warnings,
    }))
}
