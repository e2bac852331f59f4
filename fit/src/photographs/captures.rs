//! The manifest of a campaign, captures.toml: the photographs, and how each one was taken.
//!
//! Lengths are in mm. Angles are stored in degrees, as in the manifest; methods whose names end in
//! `_rad` return radians. In a photograph x runs along columns to the right and y along rows
//! downward; angles in it run from +x towards +y. Every key is checked here, so every number that
//! is returned is finite and in range, and every image exists.

pub(crate) mod error;
pub(crate) mod expected;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::document::Bounds;
use crate::document::FileLine;
use crate::document::error as document;
use crate::document::{Document, Section};
use crate::names::Spectrum;
use crate::photographs::captures::error::Error;
use crate::photographs::captures::expected::ExpectedTable;
use crate::photographs::edge::accepted::Accepted;
use crate::photographs::photo;
use crate::photographs::photo::channel::{Channel, Decode};
use crate::photographs::photo::exif::Settings;
use crate::photographs::photo::held::Held;
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::transfer::Transfer;
use crate::photographs::roi::Roi;

/// Keys of `[setup]` that every capture may override.
const SHARED: [&str; 6] = [
    "path_mm",
    "roi",
    "tangential_axis_deg",
    "transfer",
    "channel",
    "accept",
];
/// Keys of `[setup]` alone.
const SETUP: [&str; 6] = [
    "pixel_pitch_mm",
    "seen_in_mirror",
    "half_mirror_transmittance",
    "half_mirror_reflectance",
    "wavelength_nm",
    expected::KEY,
];
/// Keys of a photograph, with or without the sheet.
const SHOT: [&str; 6] = ["image", "exposure", "roi", "transfer", "channel", "accept"];
/// Keys of a photograph of the mid-air edge alone.
const CAPTURE: [&str; 5] = [
    "floating_distance_mm",
    "incidence_deg",
    "azimuth_deg",
    "path_mm",
    "tangential_axis_deg",
];

/// Properties that all captures of a campaign have in common.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Side of one pixel in the plane of the mid-air image, mm, > 0.
    pub pixel_pitch_mm: f64,
    /// True if the camera sees the sheet in the half mirror, false if it looks at it straight.
    /// `None` stands for false where the manifest does not say.
    ///
    /// Looked at straight, the sagittal axis is 90 degrees counter-clockwise from the tangential
    /// axis in the photograph; in the mirror it is 90 degrees clockwise from it.
    pub seen_in_mirror: Option<bool>,
    /// Transmittance of the half mirror, in (0, 1]. If the manifest does not give it, it is 1 and a
    /// warning says so.
    pub half_mirror_transmittance: f64,
    /// Reflectance of the half mirror, in (0, 1]. If the manifest does not give it, it is 1 and a
    /// warning says so.
    pub half_mirror_reflectance: f64,
    /// Wavelengths of the source, for the kernel `wave`.
    pub spectrum: Option<Spectrum>,
}

impl Setup {
    /// Returns whether the camera saw the sheet in the half mirror: false unless the manifest says
    /// so.
    pub fn is_in_mirror(&self) -> bool {
        self.seen_in_mirror.unwrap_or(false)
    }
}

/// Converts a unit vector of a photograph to the mid-air image, (tangential, sagittal).
///
/// `along` is the component along the tangential axis, `clockwise` that along the axis 90 degrees
/// clockwise from it, from right towards down. Seen in the mirror this is the sagittal axis; looked
/// at straight the sagittal axis points the other way.
pub(crate) fn in_image([along, clockwise]: [f64; 2], seen_in_mirror: bool) -> [f64; 2] {
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
            roi: None,
            accepted: Vec::new(),
            decode: Decode::default(),
        }
    }

    /// Reads the photograph and checks that the region lies in it.
    ///
    /// # Errors
    /// Returns `Error::Photo` if the image file cannot be used, and `Error::RoiOutside` if the
    /// region reaches beyond the picture.
    pub fn load(&self) -> Result<Photo, Error> {
        self.checked(photo::load(&self.image, &self.decode)?)
    }

    /// Returns the photograph of this shot, which lies in memory.
    ///
    /// # Errors
    /// Returns the errors of [`Shot::load`].
    pub(crate) fn held(&self, picture: &Held) -> Result<Photo, Error> {
        self.checked(picture.photo(&self.decode)?)
    }

    /// Checks that the region lies in the photograph.
    fn checked(&self, photo: Photo) -> Result<Photo, Error> {
        match self.roi {
            Some(roi) if !roi.fits(photo.width, photo.height) => Err(Error::RoiOutside {
                place: self.place.clone(),
                roi,
                image: self.image.clone(),
                width: photo.width,
                height: photo.height,
                turned: photo.is_turned(),
            }),
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
    /// Photograph of the source edge itself, without sheet and half mirror.
    pub reference: Option<Shot>,
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
        for shot in campaign.reference.iter_mut().chain(captures) {
            shot.decode.channel = channel.clone();
        }
        campaign
    }
}

/// A manifest that has been checked: its campaign, and the table that the campaign asks for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Manifest {
    /// Campaign of the manifest.
    pub(crate) campaign: Campaign,
    /// Table that the campaign must be fitted with; `None` if any table will do.
    pub(crate) expected_table: Option<ExpectedTable>,
}

/// Reads and checks a manifest. Photographs are only looked for here; [`Shot::load`] decodes them.
///
/// The key `expect_table` is checked to be a hash. The programs compare it with their table; a
/// caller of this function chooses the table in code.
///
/// If the manifest does not give `exposure`, it is 1 for the reference. For a capture it is then
/// the ratio of the camera's settings (Exif) to those of the reference, because mu is a ratio of
/// the two photographs. Without a reference it has no effect and is 1.
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
pub(crate) fn read(file: &Path) -> Result<Manifest, Error> {
    of_document(&Document::read(file)?, file, &Path::is_file)
}

/// Checks a manifest that lies in memory. Its photographs are those for which `is_held` is true.
///
/// # Errors
/// Returns the errors of [`load`].
pub(crate) fn held(
    text: String,
    name: &Path,
    is_held: &dyn Fn(&Path) -> bool,
) -> Result<Manifest, Error> {
    of_document(&Document::new(name, text), name, is_held)
}

/// Checks a manifest. Its photographs are there if `is_there` says so.
fn of_document(
    document: &Document,
    file: &Path,
    is_there: &dyn Fn(&Path) -> bool,
) -> Result<Manifest, Error> {
    let table = document.parse()?;
    let root = Section::root(document, &table, &["setup", "reference", "capture"])?;
    let known: Vec<_> = SETUP.iter().chain(&SHARED).copied().collect();
    let setup_keys = root.required("setup", root.section("setup", &known)?)?;
    let mut warnings = Vec::new();
    let setup = read_setup(&setup_keys, file, &mut warnings)?;
    let expected_table = expected::read(&setup_keys)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let shared = Shared {
        keys: &setup_keys,
        folder,
        is_there,
    };

    let reference = match root.section("reference", &SHOT)? {
        Some(keys) => {
            let exposure = keys.number("exposure", Bounds::POSITIVE)?.unwrap_or(1.0);
            Some(shared.shot(&keys, exposure)?)
        }
        None => {
            warnings.push(format!(
                "{} has no [reference]: the blur of the lens is assumed, and mu cannot be found; \
                photograph the source edge too.",
                file.display()
            ));
            None
        }
    };
    let known: Vec<_> = SHOT.iter().chain(&CAPTURE).copied().collect();
    let mut captures: Vec<Capture> = Vec::new();
    let mut source = None;
    for keys in root.sections("capture", &known)? {
        let given = keys.number("exposure", Bounds::POSITIVE)?;
        let mut capture = shared.capture(&keys, given.unwrap_or(1.0))?;
        if let (None, Some(reference)) = (given, &reference) {
            let (exposure, warning) =
                exposure_by_camera(&keys, reference, &mut source, &capture.shot)?;
            capture.shot.exposure = exposure;
            warnings.push(warning);
        }
        captures.push(capture);
    }
    if captures.is_empty() {
        return Err(Error::NoCaptures {
            file: file.to_owned(),
        });
    }
    let mut images = HashSet::new();
    for capture in &captures {
        if let Some(path) = capture
            .path_mm
            .filter(|&path| path < capture.floating_distance_mm)
        {
            warnings.push(format!(
                "{}: path_mm {path} is shorter than floating_distance_mm {}, but the path includes \
                that distance; check both (the fit takes path_mm as R).",
                capture.shot.place, capture.floating_distance_mm
            ));
        }
        if !images.insert(&capture.shot.image) {
            warnings.push(format!(
                "{}: image {} is already used by an earlier capture, so it counts twice; remove \
                one of the two.",
                capture.shot.place,
                capture.shot.image.display()
            ));
        }
    }
    Ok(Manifest {
        campaign: Campaign {
            file: file.to_owned(),
            setup,
            reference,
            captures,
            warnings,
        },
        expected_table,
    })
}

/// Returns the exposure of a capture relative to its reference, from the settings of the camera,
/// and a warning about its accuracy. `source` keeps the settings of the reference.
fn exposure_by_camera(
    keys: &Section<'_>,
    reference: &Shot,
    source: &mut Option<Settings>,
    shot: &Shot,
) -> Result<(f64, String), Error> {
    let settings = |image: &Path| {
        Settings::of(image).map_err(|lack| Error::NoExposure {
            place: keys.place().clone(),
            image: image.to_owned(),
            lack,
        })
    };
    let own = settings(&shot.image)?;
    let source = match source {
        Some(source) => source,
        None => source.insert(settings(&reference.image)?),
    };
    let exposure = reference.exposure * own.exposure() / source.exposure();
    let warning = format!(
        "{}: `exposure` is missing; {exposure:.5} was computed from the camera's Exif data ({own}; \
        reference {source}). Cameras round such settings, often by some percent, and the error of \
        mu is as large; give `exposure` if you know it better",
        shot.place
    );
    Ok((exposure, warning))
}

fn read_setup(keys: &Section<'_>, file: &Path, warnings: &mut Vec<String>) -> Result<Setup, Error> {
    let pixel_pitch_mm = keys.required(
        "pixel_pitch_mm",
        keys.number("pixel_pitch_mm", Bounds::POSITIVE)?,
    )?;
    let transmittance = keys.number("half_mirror_transmittance", Bounds::SHARE)?;
    let reflectance = keys.number("half_mirror_reflectance", Bounds::SHARE)?;
    if transmittance.is_none() || reflectance.is_none() {
        warnings.push(format!(
            "{} does not give both half_mirror_transmittance and half_mirror_reflectance: what is \
            missing counts as 1, and mu includes it.",
            file.display()
        ));
    }
    if let (Some(t), Some(r)) = (transmittance, reflectance)
        && t + r > 1.0
    {
        warnings.push(format!(
            "{}: half_mirror_transmittance {t} and half_mirror_reflectance {r} add up to more \
            than 1; measure them again",
            file.display()
        ));
    }
    Ok(Setup {
        pixel_pitch_mm,
        seen_in_mirror: keys.flag("seen_in_mirror")?,
        half_mirror_transmittance: transmittance.unwrap_or(1.0),
        half_mirror_reflectance: reflectance.unwrap_or(1.0),
        spectrum: keys.spectrum()?,
    })
}

/// Keys of `[setup]` from which a photograph takes what its own table does not give.
struct Shared<'k, 'd> {
    keys: &'k Section<'d>,
    folder: &'k Path,
    is_there: &'k dyn Fn(&Path) -> bool,
}

impl Shared<'_, '_> {
    fn shot(&self, keys: &Section<'_>, exposure: f64) -> Result<Shot, Error> {
        let image = self
            .folder
            .join(keys.required("image", keys.text("image")?)?);
        let place = keys.place_of("image");
        if !(self.is_there)(&image) {
            return Err(Error::ImageMissing { place, image });
        }
        let roi = read_roi(keys)?.or(read_roi(self.keys)?);
        let accepted = read_accepted(keys)?.or(read_accepted(self.keys)?);
        let transfer = read_transfer(keys)?.or(read_transfer(self.keys)?);
        let channel = keys
            .text("channel")?
            .or(self.keys.text("channel")?)
            .map(Channel::from_name)
            .unwrap_or_default();
        Ok(Shot {
            image,
            exposure,
            roi,
            accepted: accepted.unwrap_or_default(),
            decode: Decode { transfer, channel },
            place,
        })
    }

    fn capture(&self, keys: &Section<'_>, exposure: f64) -> Result<Capture, Error> {
        let number = |key, bounds| keys.number(key, bounds);
        let own_or_shared = |key, bounds| {
            Ok::<_, Error>(keys.number(key, bounds)?.or(self.keys.number(key, bounds)?))
        };
        let distance = number("floating_distance_mm", Bounds::POSITIVE)?;
        let incidence = number("incidence_deg", Bounds::INCIDENCE)?;
        Ok(Capture {
            floating_distance_mm: keys.required("floating_distance_mm", distance)?,
            incidence_deg: keys.required("incidence_deg", incidence)?,
            azimuth_deg: number("azimuth_deg", Bounds::TURN)?,
            path_mm: own_or_shared("path_mm", Bounds::POSITIVE)?,
            tangential_axis_deg: own_or_shared("tangential_axis_deg", Bounds::TURN)?.unwrap_or(0.0),
            shot: self.shot(keys, exposure)?,
        })
    }
}

fn read_accepted(keys: &Section<'_>) -> Result<Option<Vec<Accepted>>, document::Error> {
    keys.choices("accept", &Accepted::NAMES, Accepted::from_name)
}

fn read_transfer(keys: &Section<'_>) -> Result<Option<Transfer>, document::Error> {
    keys.choice("transfer", &Transfer::NAMES, Transfer::from_name)
}

fn read_roi(keys: &Section<'_>) -> Result<Option<Roi>, Error> {
    let Some([x, y, width, height]) =
        keys.whole_array::<4>("roi", "four whole numbers [x, y, width, height]")?
    else {
        return Ok(None);
    };
    for (side, name) in [(width, "width of roi"), (height, "height of roi")] {
        if side == 0 {
            let must_be = Bounds::POSITIVE.words;
            let place = keys.place_of("roi");
            return Err(Error::Document(document::Error::OutOfRange {
                place,
                key: name.to_owned(),
                value: 0.0,
                must_be,
            }));
        }
    }
    Ok(Some(Roi {
        x,
        y,
        width,
        height,
    }))
}
