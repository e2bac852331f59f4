//! Remarks on a prediction: what its result warns of, and where it leaves the photographs.

use tables::{Symmetry, Table};

use crate::predict::curve::Line;
use crate::predict::error::Error;
use crate::predict::sheet::Fitted;
use crate::result::{Domain, ResultFile};

/// Incidence, azimuth and distance at which a point of the mid-air image is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Viewpoint {
    /// Incidence on the sheet, degrees from the sheet's normal.
    pub incidence_deg: f64,
    /// Azimuth about the sheet's normal, degrees; `None` if the table is a mean over azimuths.
    pub azimuth_deg: Option<f64>,
    /// Distance R: optical path from the sheet to the image, mm.
    pub r_mm: f64,
}

/// Relative difference up to which two numbers count as one: they went through text.
const SAME: f64 = 1e-6;

/// Keys of the quantities of a domain, with the words and the unit of each.
const QUANTITIES: [(&str, &str, &str); 3] = [
    ("floating_distance_mm", "distance", "mm"),
    ("incidence_deg", "incidence", "deg"),
    ("azimuth_deg", "azimuth", "deg"),
];

/// Returns the value of each quantity at a place, and its range over the photographs. A quantity
/// without a range is not compared.
fn compared(domain: &Domain, place: &Viewpoint) -> [(Option<f64>, Option<[f64; 2]>); 3] {
    [
        (Some(place.r_mm), Some(domain.floating_distance_mm)),
        (Some(place.incidence_deg), Some(domain.incidence_deg)),
        (place.azimuth_deg, domain.azimuth_deg),
    ]
}

/// Returns whether a value lies in a range.
fn holds([least, most]: [f64; 2], value: f64) -> bool {
    let near = SAME * least.abs().max(most.abs());
    value >= least - near && value <= most + near
}

/// Returns whether an azimuth, or one that the cell cannot tell from it, lies in a range.
fn holds_azimuth(range: [f64; 2], azimuth_deg: f64, symmetry: Symmetry) -> bool {
    let mut images = symmetry.images(azimuth_deg);
    images.any(|(image, _)| {
        [-360.0, 0.0, 360.0]
            .iter()
            .any(|turn| holds(range, image + turn))
    })
}

/// Returns the keys of the quantities in which a place lies outside of the photographs.
pub(crate) fn outside(domain: &Domain, symmetry: Symmetry, place: &Viewpoint) -> Vec<&'static str> {
    let pairs = compared(domain, place)
        .into_iter()
        .zip(QUANTITIES)
        .enumerate();
    let left = pairs.filter(|(which, ((value, range), _))| match (value, range) {
        (Some(value), Some(range)) if *which == 2 => !holds_azimuth(*range, *value, symmetry),
        (Some(value), Some(range)) => !holds(*range, *value),
        _ => false,
    });
    left.map(|(_, (_, (key, ..)))| key).collect()
}

/// Returns remarks on predictions at some places, one sentence each: the warnings of the result,
/// the quantities in which the places lie outside of the photographs, and what an older result does
/// not say.
///
/// # Errors
/// Returns an error if the table lacks the first place, or if the result lacks a parameter there.
pub(crate) fn remarks(
    result: &ResultFile,
    table: &Table,
    places: &[Viewpoint],
) -> Result<Vec<String>, Error> {
    let own = result.warnings.iter();
    let mut remarks: Vec<String> = own.map(|w| format!("the result warns: {w}")).collect();
    match &result.domain {
        None => remarks.push(
            "the result has no key domain (an older fit wrote it), so it is unknown whether this \
            lies outside of its photographs; fit again"
                .into(),
        ),
        Some(domain) => remarks.extend(beyond(domain, table, places)),
    }
    if result.seen_in_mirror.is_none()
        && let Some(place) = places.first()
    {
        remarks.extend(unstated(&Fitted::new(result, table)?, place)?);
    }
    Ok(remarks)
}

/// Returns a remark for each quantity in which places lie outside of the photographs.
fn beyond(domain: &Domain, table: &Table, places: &[Viewpoint]) -> Vec<String> {
    let symmetry = table.provenance.symmetry;
    let mut remarks = Vec::new();
    for (which, (key, name, unit)) in QUANTITIES.into_iter().enumerate() {
        let left = places
            .iter()
            .filter(|at| outside(domain, symmetry, at).contains(&key));
        let values: Vec<f64> = left
            .filter_map(|at| compared(domain, at)[which].0)
            .collect();
        let (Some(range), false) = (compared(domain, &places[0])[which].1, values.is_empty())
        else {
            continue;
        };
        remarks.push(format!(
            "{name} {} {unit} lies outside of the photographs ({} {unit}): nothing was measured \
            there, and the intervals do not hold this error; photograph there too",
            words(values),
            words(range.to_vec())
        ));
    }
    remarks
}

/// Returns the least and the greatest value in words, to two decimals.
fn words(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let shown = |v: f64| (100.0 * v).round() / 100.0;
    match (values.first(), values.last()) {
        (Some(&first), Some(&last)) if shown(first) == shown(last) => shown(first).to_string(),
        (Some(&first), Some(&last)) => format!("{} to {}", shown(first), shown(last)),
        _ => String::new(),
    }
}

/// Returns a remark if the result does not say which way its camera saw the sheet, and if oblique
/// contrast at this place depends on it.
///
/// # Errors
/// Returns an error if the table lacks the place, or if the result lacks a parameter there.
fn unstated(sheet: &Fitted<'_>, place: &Viewpoint) -> Result<Option<String>, Error> {
    let direction = sheet
        .table
        .direction(place.incidence_deg, place.azimuth_deg)?;
    let half = 0.5_f64.sqrt();
    let mtf50 = |sagittal: f64| -> Result<Option<f64>, Error> {
        let line = Line::new(sheet, &direction, place.incidence_deg, [half, sagittal])?;
        let found = line.and_then(|line| line.at(place.r_mm).falls_to(0.5));
        Ok(found.map(|found| found.value))
    };
    let (Some(towards), Some(away)) = (mtf50(half)?, mtf50(-half)?) else {
        return Ok(None);
    };
    Ok(((towards / away - 1.0).abs() > 1e-3).then(|| {
        format!(
            "the result has no key seen_in_mirror (an older fit wrote it, as if the key were \
            true), which decides here: contrast at 45 degrees between the axes has MTF50 \
            {towards:.4} /mm if it is true and {away:.4} /mm if it is false; fit again with the \
            key in the manifest"
        )
    }))
}
