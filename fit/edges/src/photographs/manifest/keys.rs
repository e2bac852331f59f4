//! The keys of a manifest as they are written, and the campaign that follows from them.

use std::collections::HashSet;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use crate::document::{self, Document, FileLine, Table};
use crate::document::{incidence, positive, tables, turn};
use crate::photographs::edge::fault::Accepted;
use crate::photographs::manifest::captures::{
    Campaign, Capture, Error, ExpectedTable, Manifest, Shot,
};
use crate::photographs::manifest::roi::Roi;
use crate::photographs::manifest::setup::{SetupTable, accept, roi, setup, transfer};
use crate::photographs::photo::channel::{Channel, Decode};
use crate::photographs::photo::exif::Settings;
use crate::photographs::photo::transfer::Transfer;

/// A manifest as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Tables {
    pub setup: Spanned<Table<SetupTable>>,
    #[serde(default, deserialize_with = "tables")]
    reference: Vec<ShotTable>,
    #[serde(default)]
    capture: Vec<Spanned<Table<CaptureTable>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShotTable {
    image: Spanned<String>,
    #[serde(default, deserialize_with = "positive")]
    exposure: Option<f64>,
    #[serde(default, deserialize_with = "roi")]
    roi: Option<Roi>,
    #[serde(default, deserialize_with = "accept")]
    accept: Option<Vec<Accepted>>,
    #[serde(default, deserialize_with = "transfer")]
    transfer: Option<Transfer>,
    channel: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaptureTable {
    #[serde(deserialize_with = "positive")]
    floating_distance_mm: f64,
    #[serde(deserialize_with = "incidence")]
    incidence_deg: f64,
    #[serde(default, deserialize_with = "turn")]
    azimuth_deg: Option<f64>,
    #[serde(default, deserialize_with = "positive")]
    path_mm: Option<f64>,
    #[serde(default, deserialize_with = "turn")]
    tangential_axis_deg: Option<f64>,
    // The keys of a `ShotTable`.
    image: Spanned<String>,
    #[serde(default, deserialize_with = "positive")]
    exposure: Option<f64>,
    #[serde(default, deserialize_with = "roi")]
    roi: Option<Roi>,
    #[serde(default, deserialize_with = "accept")]
    accept: Option<Vec<Accepted>>,
    #[serde(default, deserialize_with = "transfer")]
    transfer: Option<Transfer>,
    channel: Option<String>,
}

/// Checks a manifest. Its photographs are there if `is_there` says so.
pub(super) fn of_document(
    document: &Document,
    file: &Path,
    is_there: &dyn Fn(&Path) -> bool,
) -> Result<Manifest, Error> {
    let Tables {
        setup: shared,
        reference,
        capture,
    } = document.parse()?;
    let span = shared.span();
    let Table(shared) = shared.into_inner();
    if shared.pixel_pitch_mm.is_none() {
        return Err(document.missing(span, "pixel_pitch_mm", "[setup]").into());
    }
    let mut warnings = Vec::new();
    let setup = setup(&shared, document, file, &mut warnings)?;
    let shot = |table| shot(table, &shared, document, is_there);
    let mut source = None;
    let all = reference
        .into_iter()
        .map(|table| (table.exposure, shot(table)));
    let references = exposed(all, &mut source, &mut warnings)?;
    if references.is_empty() {
        warnings.push(format!(
            "{} has no [reference]: the blur of the lens is assumed, and mu cannot be found; \
            photograph the source edge too.",
            file.display()
        ));
    }
    let mut captures: Vec<Capture> = Vec::new();
    for table in capture {
        let place = document.place(table.span());
        let Table(table) = table.into_inner();
        let given = table.exposure;
        let mut capture = Capture {
            floating_distance_mm: table.floating_distance_mm,
            path_mm: table.path_mm.or(shared.path_mm),
            incidence_deg: table.incidence_deg,
            azimuth_deg: table.azimuth_deg,
            tangential_axis_deg: (table.tangential_axis_deg)
                .or(shared.tangential_axis_deg)
                .unwrap_or(0.0),
            shot: shot(ShotTable {
                image: table.image,
                exposure: given,
                roi: table.roi,
                accept: table.accept,
                transfer: table.transfer,
                channel: table.channel,
            })?,
        };
        if let (None, Some(reference)) = (given, references.first()) {
            let warning = expose_by_camera(
                &place,
                "[[capture]]",
                reference,
                &mut source,
                &mut capture.shot,
            )?;
            warnings.push(warning);
        }
        captures.push(capture);
    }
    if captures.is_empty() {
        let none = "has no [[capture]]; add one for each photograph of the mid-air image";
        return Err(document.error(none).into());
    }
    doubt(&references, &captures, &mut warnings);
    Ok(Manifest {
        campaign: Campaign {
            file: file.to_owned(),
            setup,
            references,
            captures,
            warnings,
        },
        expected_table: shared.expect_table.map(|hash| ExpectedTable {
            place: document.place(hash.span()),
            hash: hash.into_inner().0,
        }),
    })
}

/// Returns the photograph of a table, with what the setup gives for all.
fn shot(
    table: ShotTable,
    shared: &SetupTable,
    document: &Document,
    is_there: &dyn Fn(&Path) -> bool,
) -> Result<Shot, document::Error> {
    let place = document.place(table.image.span());
    let folder = place.file.parent().unwrap_or(Path::new(""));
    let image = folder.join(table.image.into_inner());
    if !is_there(&image) {
        let image = image.display();
        let why = format!(
            "image {image} does not exist; paths are relative to the folder of the manifest"
        );
        return Err(place.error(why));
    }
    let channel = table.channel.as_ref().or(shared.channel.as_ref());
    Ok(Shot {
        image,
        exposure: table.exposure.unwrap_or(1.0),
        rounding: None,
        roi: table.roi.or(shared.roi),
        accepted: table.accept.or(shared.accept.clone()).unwrap_or_default(),
        decode: Decode {
            transfer: table.transfer.or(shared.transfer),
            channel: channel.map_or_else(Channel::default, |name| Channel::from_name(name)),
        },
        place,
    })
}

/// Warns of captures that contradict themselves, and of photographs that are there twice.
fn doubt(references: &[Shot], captures: &[Capture], warnings: &mut Vec<String>) {
    for capture in captures {
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
    }
    doubled("reference", references.iter(), warnings);
    let shots = captures.iter().map(|capture| &capture.shot);
    doubled("capture", shots, warnings);
}

/// Warns of photographs of a `table` that are there twice: their noise would count as independent.
fn doubled<'a>(table: &str, shots: impl Iterator<Item = &'a Shot>, warnings: &mut Vec<String>) {
    let mut images = HashSet::new();
    for shot in shots {
        if !images.insert(&shot.image) {
            warnings.push(format!(
                "{}: image {} is already used by an earlier {table}, so it counts twice; remove \
                one of the two.",
                shot.place,
                shot.image.display()
            ));
        }
    }
}

/// Returns the references of a manifest with their exposures. Each comes with the exposure that the manifest states for
/// it. Exposures that are not stated follow from the camera's settings, relative to the first.
fn exposed(
    all: impl Iterator<Item = (Option<f64>, Result<Shot, document::Error>)>,
    source: &mut Option<Settings>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Shot>, Error> {
    let mut references: Vec<Shot> = Vec::new();
    for (given, shot) in all {
        let mut shot = shot?;
        if let (None, Some(first)) = (given, references.first()) {
            let place = shot.place.clone();
            let warning = expose_by_camera(&place, "[[reference]]", first, source, &mut shot)?;
            warnings.push(warning);
        }
        references.push(shot);
    }
    Ok(references)
}

/// Sets the exposure of a photograph of `table` relative to the first reference, by the settings of
/// the camera, and returns a warning about its accuracy. `source` keeps the settings of the
/// reference.
fn expose_by_camera(
    place: &FileLine,
    table: &str,
    reference: &Shot,
    source: &mut Option<Settings>,
    shot: &mut Shot,
) -> Result<String, Error> {
    let settings = |image: &Path| {
        Settings::of(image).map_err(|lack| {
            place.clone().error(format!(
                "`exposure` is missing from {table}, and {} has {lack}; add `exposure`",
                image.display()
            ))
        })
    };
    let own = settings(&shot.image)?;
    let source = match source {
        Some(source) => source,
        None => source.insert(settings(&reference.image)?),
    };
    let exposure = reference.exposure * own.exposure() / source.exposure();
    let rounded = |settings: &Settings| settings.seconds / settings.seconds_in_stops();
    shot.exposure = exposure;
    shot.rounding = Some(rounded(&own) / rounded(source) - 1.0);
    Ok(format!(
        "{}: `exposure` is missing; {exposure:.5} was computed from the camera's Exif data ({own}; \
        reference {source}). Cameras round such settings, often by some percent, and the error of \
        mu is as large; give `exposure` if you know it better",
        shot.place
    ))
}
