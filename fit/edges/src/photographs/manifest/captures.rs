//! The manifest of a campaign, captures.toml: the photographs, and how each one was taken.
//!
//! Lengths are in mm. Angles are stored in degrees, as in the manifest; methods whose names end in
//! `_rad` return radians. In a photograph x runs along columns to the right and y along rows
//! downward; angles in it run from +x towards +y. Every key is checked, so every number that is
//! returned is finite and in range, and every image exists.

use std::path::{Path, PathBuf};

use crate::document::{self, Document, FileLine, Table};
use crate::photographs::edge::fault::Accepted;
use crate::photographs::manifest::keys::{Tables, of_document};
use crate::photographs::manifest::roi::Roi;
use crate::photographs::manifest::setup::{Setup, setup};
use crate::photographs::photo;
use crate::photographs::photo::channel::{Channel, Decode};
use crate::photographs::photo::in_memory::InMemory;
use crate::photographs::photo::plane::{Photo, as_shown};

/// A reason why a manifest, or one of its photographs, cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A fault of the manifest: its text, one of its keys, or what a key names.
    #[error(transparent)]
    Document(#[from] document::Error),
    /// A photograph that cannot be used.
    #[error(transparent)]
    Photo(#[from] photo::error::Error),
}

/// Converts a unit vector of a photograph to the mid-air image, (tangential, sagittal).
///
/// `along` is the component along the tangential axis, `clockwise` that along the axis 90 degrees
/// clockwise from it, from right towards down. Seen in the mirror this is the sagittal axis; looked
/// at straight the sagittal axis points the other way.
pub fn in_image([along, clockwise]: [f64; 2], seen_in_mirror: bool) -> [f64; 2] {
    [
        along,
        if seen_in_mirror {
            clockwise
        } else {
            -clockwise
        },
    ]
}

/// One photograph and how to read it.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Path of the image file, relative paths resolved against the manifest's folder. The file
    /// existed when the manifest was read.
    pub image: PathBuf,
    /// Exposure relative to the reference, > 0.
    pub exposure: f64,
    /// Relative error of the exposure by rounded shutter times, if it was computed from Exif data:
    /// its ratio to that by thirds or halves of a stop, less 1. `None` if the manifest gives it.
    pub rounding: Option<f64>,
    /// Region that holds the edge. With `None` the whole picture is used, or an edge is searched in
    /// it.
    pub roi: Option<Roi>,
    /// Faults of the edge that become warnings (the key `accept`).
    pub accepted: Vec<Accepted>,
    /// Transfer and channel of the image file.
    pub decode: Decode,
    /// Line of the manifest that names the image.
    pub place: FileLine,
}

impl Shot {
    /// Creates a photograph that is in no manifest, for callers that hand out photographs
    /// themselves. The caller recognises it by its name, which stands in `image`.
    pub fn named(name: impl Into<PathBuf>, exposure: f64) -> Shot {
        let name = name.into();
        Shot {
            place: FileLine {
                file: name.clone(),
                line: 0,
            },
            image: name,
            exposure,
            rounding: None,
            roi: None,
            accepted: Vec::new(),
            decode: Decode::default(),
        }
    }

    /// Reads the photograph and checks that the region lies in it.
    ///
    /// # Errors
    /// Returns an error if the image file cannot be used, and if the region reaches beyond the
    /// picture.
    pub fn load(&self) -> Result<Photo, Error> {
        self.checked(photo::load(&self.image, &self.decode)?)
    }

    /// Returns the photograph of this shot, which lies in memory.
    ///
    /// # Errors
    /// Returns the errors of [`Shot::load`].
    pub fn held(&self, picture: &InMemory) -> Result<Photo, Error> {
        self.checked(picture.photo(&self.decode)?)
    }

    /// Checks that the region lies in the photograph.
    fn checked(&self, photo: Photo) -> Result<Photo, Error> {
        match self.roi {
            Some(roi) if !roi.fits(photo.width, photo.height) => {
                let image = self.image.display();
                let (width, height) = (photo.width, photo.height);
                let turned = as_shown(photo.is_turned());
                let why = format!(
                    "{roi} reaches beyond {image}, which is {width} x {height} pixels{turned}; \
                    correct `roi`"
                );
                Err(self.place.clone().error(why).into())
            }
            _ => Ok(photo),
        }
    }
}

/// One photograph of the mid-air edge, and how it was taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// The photograph itself.
    pub shot: Shot,
    /// Floating distance, mm, > 0.
    pub floating_distance_mm: f64,
    /// Optical path from the sheet to the image along the principal ray, mm, > 0. It is `None`
    /// where it equals the floating distance; see [`Capture::range_mm`].
    pub path_mm: Option<f64>,
    /// Incidence in the air, degrees from the sheet's normal, 0 <= theta < 90.
    pub incidence_deg: f64,
    /// Azimuth about the sheet's normal, degrees; `None` for a table that is a mean over azimuths.
    pub azimuth_deg: Option<f64>,
    /// Direction of the tangential axis (in the plane of incidence) in the photograph, degrees from
    /// +x towards +y.
    pub tangential_axis_deg: f64,
}

impl Capture {
    /// Returns R of the model, mm: `path_mm` if it is given, else the floating distance.
    pub fn range_mm(&self) -> f64 {
        self.path_mm.unwrap_or(self.floating_distance_mm)
    }

    /// Returns the incidence, radians.
    pub fn incidence_rad(&self) -> f64 {
        self.incidence_deg.to_radians()
    }

    /// Returns the azimuth, radians.
    pub fn azimuth_rad(&self) -> Option<f64> {
        self.azimuth_deg.map(f64::to_radians)
    }

    /// Returns the direction of the tangential axis in the photograph, radians from +x towards +y.
    pub fn tangential_axis_rad(&self) -> f64 {
        self.tangential_axis_deg.to_radians()
    }
}

/// A campaign whose manifest has been checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    /// Path of the manifest.
    pub file: PathBuf,
    /// Properties that all captures share.
    pub setup: Setup,
    /// Photographs of the source edge itself, without sheet and half mirror: none, or one for each
    /// direction of the edge in which the lens is measured.
    pub references: Vec<Shot>,
    /// Captures in the order of the manifest; never empty.
    pub captures: Vec<Capture>,
    /// Warnings about what was assumed, one sentence each.
    pub warnings: Vec<String>,
}

impl Campaign {
    /// Returns a copy of the campaign that uses one channel of every photograph.
    pub fn in_channel(&self, channel: &Channel) -> Campaign {
        let mut campaign = self.clone();
        let captures = campaign
            .captures
            .iter_mut()
            .map(|capture| &mut capture.shot);
        for shot in campaign.references.iter_mut().chain(captures) {
            shot.decode.channel = channel.clone();
        }
        if let Some(lamp) = &campaign.setup.lamp {
            campaign.setup.spectrum = lamp.through(channel);
        }
        campaign
    }
}

/// Content hash that the table of a campaign must have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExpectedTable {
    /// The hash: 64 hex digits, lower-case.
    pub hash: String,
    /// Line of the manifest that states it.
    pub place: FileLine,
}

/// A manifest that has been checked: its campaign, and the table that the campaign asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Manifest {
    /// Campaign of the manifest.
    pub campaign: Campaign,
    /// Table that the campaign must be fitted with; `None` if any table will do.
    pub expected_table: Option<ExpectedTable>,
}

/// Reads and checks a manifest. Photographs are only looked for here; [`Shot::load`] decodes them.
///
/// The key `expect_table` is checked to be a hash. The programs compare it with their table; a
/// caller of this function chooses the table in code.
///
/// If the manifest does not give `exposure`, it is 1 for the first reference. For a capture, and for
/// a further reference, it is then the ratio of the camera's settings (Exif) to those of the first
/// reference, because mu is a ratio of the two photographs. Without a reference it has no effect and is 1.
///
/// # Errors
/// Returns an `Error` that names the line of the first fault: a file that cannot be read, text that
/// is not TOML, a key that is unknown, missing or out of range, an image that does not exist, an
/// exposure that neither the manifest nor the camera gives, or a manifest without captures.
pub fn load(file: &Path) -> Result<Campaign, Error> {
    Ok(read(file)?.campaign)
}

/// Reads and checks a manifest as [`load`] does, and keeps the table that it asks for.
///
/// # Errors
/// Returns the errors of [`load`].
pub fn read(file: &Path) -> Result<Manifest, Error> {
    of_document(&Document::read(file)?, file, &Path::is_file)
}

/// Checks a manifest that lies in memory. Its photographs are those for which `is_held` is true.
///
/// # Errors
/// Returns the errors of [`load`].
pub fn held(text: String, name: &Path, is_held: &dyn Fn(&Path) -> bool) -> Result<Manifest, Error> {
    of_document(&Document::new(name, text), name, is_held)
}

/// Reads the table `[setup]` of a manifest, or of a file that has only this table.
///
/// `pixel_pitch_mm` is 1 if the file does not give it. The warnings say what was assumed, as those
/// of a campaign do.
///
/// # Errors
/// Returns the errors of [`load`] about this table.
pub fn setup_of(file: &Path) -> Result<(Setup, Vec<String>), Error> {
    let document = Document::read(file)?;
    let Tables { setup: table, .. } = document.parse()?;
    let Table(table) = table.into_inner();
    let mut warnings = Vec::new();
    let setup = setup(&table, &document, file, &mut warnings)?;
    Ok((setup, warnings))
}
