//! The table [setup] of a manifest: mirror, light, and what the photographs of a campaign share.

use std::path::Path;

use serde::Deserialize;
use serde::de::{Deserializer, Error as _};
use toml::Spanned;

use crate::document::{self, Bounds, Document, Error};
use crate::document::{choice, choices, positive, spectrum, turn};
use crate::names::{ByAxis, Ghost, Haze, Polarisation, Retarder, Spectrum, State, Stray};
use crate::photographs::edge::fault::Accepted;
use crate::photographs::manifest::lamp::{Lamp, LampError};
use crate::photographs::manifest::roi::Roi;
use crate::photographs::photo::channel::Channel;
use crate::photographs::photo::transfer::Transfer;
use crate::readers;

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
    /// Lamp from which the spectrum follows, for each channel of the camera; `None` if the manifest
    /// gives wavelengths themselves, or nothing.
    pub lamp: Option<Lamp>,
    /// Polarisers, film and half mirror; `None` for unpolarised light that is collected whole.
    pub polarisation: Option<Polarisation>,
    /// Ghost, haze and front of the sheet.
    pub stray: Stray,
}

impl Setup {
    /// Returns whether the camera saw the sheet in the half mirror: false unless the manifest says
    /// so.
    pub fn is_in_mirror(&self) -> bool {
        self.seen_in_mirror.unwrap_or(false)
    }

    /// Returns what red, green and blue see of the lamp, if the camera tells them apart.
    pub fn colours(&self) -> Option<[Spectrum; 3]> {
        let lamp = self.lamp.as_ref().filter(|lamp| lamp.is_coloured())?;
        let [red, green, blue] = Channel::PRIMARIES.map(|channel| lamp.through(&channel));
        Some([red?, green?, blue?])
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SetupTable {
    #[serde(default, deserialize_with = "positive")]
    pub pixel_pitch_mm: Option<f64>,
    seen_in_mirror: Option<bool>,
    #[serde(default, deserialize_with = "by_axis")]
    half_mirror_transmittance: Option<ByAxis>,
    #[serde(default, deserialize_with = "by_axis")]
    half_mirror_reflectance: Option<ByAxis>,
    #[serde(default)]
    polarisation: State,
    #[serde(default)]
    analyser: State,
    #[serde(default)]
    retarder: Option<Retarder>,
    #[serde(default, deserialize_with = "spectrum")]
    wavelength_nm: Option<Spectrum>,
    spectrum: Option<Spanned<String>>,
    camera_response: Option<Spanned<String>>,
    #[serde(default, deserialize_with = "ghost")]
    ghost: Option<Ghost>,
    #[serde(default, deserialize_with = "haze")]
    haze: Option<Haze>,
    #[serde(default, deserialize_with = "index")]
    front_index: Option<f64>,
    pub expect_table: Option<Spanned<Hash>>,
    // What the tables of photographs may override.
    #[serde(default, deserialize_with = "positive")]
    pub path_mm: Option<f64>,
    #[serde(default, deserialize_with = "turn")]
    pub tangential_axis_deg: Option<f64>,
    #[serde(default, deserialize_with = "roi")]
    pub roi: Option<Roi>,
    #[serde(default, deserialize_with = "accept")]
    pub accept: Option<Vec<Accepted>>,
    #[serde(default, deserialize_with = "transfer")]
    pub transfer: Option<Transfer>,
    pub channel: Option<String>,
}

/// SHA-256 in hex, lower-case.
#[derive(Deserialize)]
#[serde(try_from = "String")]
pub(super) struct Hash(pub String);

impl TryFrom<String> for Hash {
    type Error = String;

    fn try_from(text: String) -> Result<Hash, String> {
        if text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return Ok(Hash(text.to_ascii_lowercase()));
        }
        Err(format!(
            "is \"{text}\", which is no content hash; write the 64 hex digits that `bake verify` \
            prints"
        ))
    }
}

pub(super) fn roi<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Roi>, D::Error> {
    let numbers = Vec::<toml::Value>::deserialize(value)?;
    let whole = |number: &toml::Value| usize::try_from(number.as_integer()?).ok();
    let numbers: Option<Vec<usize>> = numbers.iter().map(whole).collect();
    let wrong = "must be four whole numbers [x, y, width, height], none below 0, and width and height \
        above 0; change the value";
    let roi = numbers.and_then(|numbers| Roi::of(&numbers));
    roi.map(Some).ok_or_else(|| D::Error::custom(wrong))
}

pub(super) fn accept<'de, D: Deserializer<'de>>(
    value: D,
) -> Result<Option<Vec<Accepted>>, D::Error> {
    choices(value, &Accepted::NAMES, Accepted::from_name).map(Some)
}

pub(super) fn transfer<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Transfer>, D::Error> {
    choice(value, &Transfer::NAMES, Transfer::from_name).map(Some)
}

pub(super) fn setup(
    table: &SetupTable,
    document: &Document,
    file: &Path,
    warnings: &mut Vec<String>,
) -> Result<Setup, Error> {
    let transmittance = table.half_mirror_transmittance;
    let reflectance = table.half_mirror_reflectance;
    if transmittance.is_none() || reflectance.is_none() {
        warnings.push(format!(
            "{} does not give both half_mirror_transmittance and half_mirror_reflectance: what is \
            missing counts as 1, and mu includes it.",
            file.display()
        ));
    }
    let axes = |axes: ByAxis| [axes.s, axes.p];
    if let (Some(t), Some(r)) = (transmittance.map(axes), reflectance.map(axes))
        && let Some((t, r)) = t.into_iter().zip(r).find(|(t, r)| t + r > 1.0)
    {
        warnings.push(format!(
            "{}: half_mirror_transmittance {t} and half_mirror_reflectance {r} add up to more \
            than 1; measure them again",
            file.display()
        ));
    }
    let half_mirror = |given: Option<ByAxis>| given.unwrap_or(ByAxis::even(1.0));
    let polarisation = Polarisation {
        source: table.polarisation,
        analyser: table.analyser,
        retarder: table.retarder,
        half_mirror_transmittance: half_mirror(transmittance),
        half_mirror_reflectance: half_mirror(reflectance),
    };
    let lamp = lamp(table, document, file)?;
    let channel = table.channel.as_deref().map(Channel::from_name);
    let channel = channel.unwrap_or_default();
    let of_lamp = lamp.as_ref().and_then(|lamp| lamp.through(&channel));
    Ok(Setup {
        pixel_pitch_mm: table.pixel_pitch_mm.unwrap_or(1.0),
        seen_in_mirror: table.seen_in_mirror,
        half_mirror_transmittance: half_mirror(transmittance).mean(),
        half_mirror_reflectance: half_mirror(reflectance).mean(),
        spectrum: of_lamp.or_else(|| table.wavelength_nm.clone()),
        lamp,
        polarisation: (!polarisation.is_none()).then_some(polarisation),
        stray: Stray {
            ghost: table.ghost,
            haze: table.haze,
            front_index: table.front_index,
        },
    })
}

readers! {
    index = Bounds::new("a refractive index, at least 1 and at most 5", |x| {
        (1.0..=5.0).contains(&x)
    });
}

fn ghost<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Ghost>, D::Error> {
    let ghost: Ghost = document::table(value)?;
    Bounds::SHARE.checked::<D::Error>(ghost.share)?;
    Bounds::FINITE.checked::<D::Error>(ghost.tangential_mm)?;
    Bounds::FINITE.checked::<D::Error>(ghost.sagittal_mm)?;
    Ok(Some(ghost))
}

fn haze<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Haze>, D::Error> {
    let haze: Haze = document::table(value)?;
    Bounds::SHARE.checked::<D::Error>(haze.share)?;
    Bounds::INCIDENCE.checked::<D::Error>(haze.spread_deg)?;
    Ok(Some(haze))
}

/// Reads the lamp of a setup and the response of its camera.
fn lamp(table: &SetupTable, document: &Document, file: &Path) -> Result<Option<Lamp>, Error> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let at = |name: &Spanned<String>, what: String| document.place(name.span()).error(what);
    let Some(name) = &table.spectrum else {
        return match &table.camera_response {
            Some(name) => {
                let lacks = "`camera_response` needs a lamp; add `spectrum`, a file of nm and power or \
                    the name of an illuminant";
                Err(at(name, lacks.into()))
            }
            None => Ok(None),
        };
    };
    if table.wavelength_nm.is_some() {
        let both = "`spectrum` and `wavelength_nm` both name the light; leave one out";
        return Err(at(name, both.into()));
    }
    let refused = |name, error: LampError| at(name, error.to_string());
    let lamp = Lamp::read(name.as_ref(), folder).map_err(|error| refused(name, error))?;
    match &table.camera_response {
        None if lamp.through(&Channel::Luminance).is_none() => {
            let unseen = "the eye sees nothing of this lamp; add `camera_response`, or correct it";
            Err(at(name, unseen.into()))
        }
        None => Ok(Some(lamp)),
        Some(response) => {
            let seen = lamp.seen_by(&folder.join(response.as_ref()));
            seen.map(Some).map_err(|error| refused(response, error))
        }
    }
}

/// Reads a share of a half mirror: a number, or one for each polarisation.
fn by_axis<'de, D: Deserializer<'de>>(value: D) -> Result<Option<ByAxis>, D::Error> {
    let both = match toml::Value::deserialize(value)? {
        toml::Value::Table(table) => {
            // The text of the whole error ends in a line feed, which a message would show.
            let axes: ByAxis = toml::Value::Table(table)
                .try_into()
                .map_err(|error: toml::de::Error| D::Error::custom(error.message()))?;
            let share = |own| own == 0.0 || (Bounds::SHARE.holds)(own);
            if !(share(axes.s) && share(axes.p) && axes.mean() > 0.0) {
                let wrong = "must have s and p from 0 to 1, not both 0; change the value";
                return Err(D::Error::custom(wrong));
            }
            axes
        }
        toml::Value::Float(both) => ByAxis::even(Bounds::SHARE.checked(both)?),
        toml::Value::Integer(both) => ByAxis::even(Bounds::SHARE.checked(both as f64)?),
        other => {
            return Err(D::Error::custom(format!(
                "must be a number or {{ s = 0.6, p = 0.3 }}, not of type {}; change the value",
                other.type_str()
            )));
        }
    };
    Ok(Some(both))
}
