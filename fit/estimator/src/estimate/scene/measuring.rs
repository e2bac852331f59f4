//! The measurement of the photographs of a campaign: their edges, their pixels, and their directions
//! in the table.

use std::sync::Arc;

use tables::{Direction, Table};

use crate::compare::Pixels;
use crate::compare::View;
use crate::error::Error;
use crate::estimate::remarks;
use crate::estimate::scene::direction::{Along, ProjectedDirection};
use crate::estimate::scene::optics::Optics;
use crate::estimate::scene::reference::{self, Reference};
use crate::estimate::scene::{Aerial, Place, Source};
use crate::model::Camera;
use edges::photographs::edge::line::EdgeLine;
use edges::photographs::manifest::captures;
use edges::photographs::measure;
use edges::photographs::photo::taken::Taken;
use edges::photographs::{Campaign, Capture};
use edges::photographs::{Measurement, Profile};

/// Beginning of the warning about a missing reference. It is given once: the manifest may have
/// caused it already.
const NO_REFERENCE: &str = "no [reference]";

/// Returns the name of a file without its folder.
pub(super) fn name(path: &std::path::Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// Measures the references, if the campaign has any; otherwise assumes a lens and adds a warning.
///
/// # Errors
/// Fails if the photograph cannot be read or has no usable edge.
pub(super) fn source_edge(
    campaign: &Campaign,
    photo: &Source,
    warnings: &mut Vec<String>,
) -> Result<(Option<Reference>, Optics), Error> {
    let pitch_mm = campaign.setup.pixel_pitch_mm;
    if campaign.references.is_empty() {
        if !warnings.iter().any(|said| said.contains(NO_REFERENCE)) {
            warnings.push(format!(
                "{NO_REFERENCE} photograph: the blur of the lens is assumed, and mu cannot be \
                found; photograph the source edge too"
            ));
        }
        return Ok((None, Optics::assumed(pitch_mm)));
    }
    let pixel = Camera {
        pitch_mm,
        lenses: Vec::new(),
    };
    let (mut sources, mut transfer) = (Vec::new(), None);
    for shot in &campaign.references {
        let source = sorted(shot, photo)?;
        let name = name(&shot.image);
        let notes = source.warnings.into_iter();
        warnings.extend(notes.map(|note| format!("{name}: {note}")));
        match &transfer {
            None => transfer = Some(source.transfer),
            Some(first_read) => {
                let read = std::iter::once((name.as_str(), &source.transfer));
                warnings.extend(remarks::of_transfers(first_read, read));
            }
        }
        let view = View::new(source.line, source.profile, pitch_mm, 0.0, &pixel);
        sources.push((view, source.pixels, shot.exposure));
    }
    let (reference, optics) = reference::measure(sources);
    let names = campaign.references.iter().map(|shot| name(&shot.image));
    warnings.extend(remarks::of_steps(&reference, &names.collect::<Vec<_>>()));
    let reference = Reference {
        transfer: transfer.unwrap_or_default(),
        ..reference
    };
    Ok((Some(reference), optics))
}

/// A photograph whose edge is found and whose pixels are sorted.
struct Sorted {
    line: EdgeLine,
    profile: Profile,
    pixels: Pixels,
    transfer: Taken,
    reduced_noise: Option<f64>,
    warnings: Vec<String>,
}

/// Decodes a photograph, finds its edge and sorts its pixels.
///
/// # Errors
/// Returns [`Error::Captures`] if the photograph cannot be read, and [`Error::Edge`] if it has no
/// usable edge.
fn sorted(shot: &captures::Shot, photo: &Source) -> Result<Sorted, Error> {
    let photo = photo(shot)?;
    let fault = |fault| Error::Edge(shot.image.clone(), fault);
    let Measurement {
        as_lit,
        line,
        profile,
        reduced_noise,
        warnings,
        ..
    } = measure::edge(&photo, shot.roi, &shot.accepted).map_err(fault)?;
    Ok(Sorted {
        pixels: Pixels::new(&as_lit, &line),
        line,
        profile,
        transfer: photo.transfer,
        reduced_noise,
        warnings,
    })
}

/// Inputs that the measurement of each photograph of a campaign needs.
pub(super) struct Measuring<'a> {
    pub campaign: &'a Campaign,
    pub table: &'a Table,
    pub photo: &'a Source<'a>,
}

/// A photograph of a campaign and its direction in the table.
pub(super) struct Found {
    sorted: Sorted,
    direction: Direction,
}

impl Measuring<'_> {
    /// Finds the edge of one photograph. Returns `None` if the table says that no light returns.
    ///
    /// # Errors
    /// Fails if the table neither holds nor brackets the direction, or if the photograph cannot be
    /// read or has no usable edge.
    pub(super) fn found(&self, capture: &Capture) -> Result<Option<Found>, Error> {
        let direction = self
            .table
            .direction(capture.incidence_deg, capture.azimuth_deg)
            .map_err(|source| Error::Direction {
                manifest: self.campaign.file.clone(),
                image: name(&capture.shot.image),
                source: Box::new(source),
            })?;
        if direction.retroreflected <= 0.0 {
            return Ok(None);
        }
        let sorted = sorted(&capture.shot, self.photo)?;
        Ok(Some(Found { sorted, direction }))
    }

    /// Makes a photograph ready for comparison with models, as `camera` sees them.
    pub(super) fn aerial(&self, capture: &Capture, found: Found, camera: &Camera) -> Aerial {
        let Found { sorted, direction } = found;
        let Sorted {
            line,
            profile,
            pixels,
            transfer,
            reduced_noise,
            mut warnings,
        } = sorted;
        let setup = &self.campaign.setup;
        let axis_rad = capture.tangential_axis_rad();
        let view = View::new(line, profile, setup.pixel_pitch_mm, axis_rad, camera);
        warnings.extend(self.between(capture, &direction));
        let along = Along {
            incidence_rad: capture.incidence_rad(),
            normal: captures::in_image(view.normal(), setup.is_in_mirror()),
            spectrum: setup.spectrum.as_ref(),
        };
        let index = self.table.provenance.refractive_index;
        Aerial {
            image: name(&capture.shot.image),
            incidence_deg: capture.incidence_deg,
            r_mm: capture.range_mm(),
            floating_distance_mm: capture.floating_distance_mm,
            place: Place::default(),
            exposure: capture.shot.exposure,
            rounding: capture.shot.rounding,
            transfer,
            reduced_noise,
            view: Arc::new(view),
            pixels: Arc::new(pixels),
            warnings,
            direction: ProjectedDirection::new(&direction, capture.azimuth_deg, index, along),
            seen_in_mirror: setup.is_in_mirror(),
            ghost: setup.stray.ghost,
            axis_turn_rad: 0.0,
            sampled: None,
        }
    }

    /// Returns a warning if the table interpolates this direction without a stated tolerance.
    fn between(&self, capture: &Capture, direction: &Direction) -> Option<String> {
        // The tolerance is that of polygons. Without polygons the bins of directions are mixed.
        let tolerance = self.table.provenance.direction_tolerance;
        let within = tolerance.is_some() && direction.paths.is_some();
        (direction.interpolated && !within).then(|| {
            format!(
                "incidence {} deg is interpolated between directions of the table, which costs \
                accuracy (`bake trace` says how much); bake it",
                capture.incidence_deg
            )
        })
    }
}
