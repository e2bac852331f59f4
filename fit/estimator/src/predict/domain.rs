//! Remarks on a prediction: what its result warns of, and where it leaves the photographs.

use tables::{Symmetry, Table};

use crate::error::Error;
use crate::model::ExitBins;
use crate::predict::curve::Line;
use crate::predict::sheet::Fitted;
use crate::result::{Domain, Parameter, ResultFile};
use edges::names::Kernel;

/// Returns a remark about a lobe that is taken to another distance than those of the photographs.
fn one_lobe([near, far]: [f64; 2]) -> String {
    let seen = if near == far {
        "; photographs at two distances tell which of them holds".to_owned()
    } else {
        format!(". Photographs from {near} to {far} mm chose eq1; beyond them nothing was measured")
    };
    format!(
        "the kernel eq1 takes the blur by diffraction as the same at every distance; the kernels \
        angular and wave let it grow{seen}"
    )
}

/// Incidence, azimuth and distance at which a point of the mid-air image is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// Incidence on the sheet, degrees from the sheet's normal.
    pub incidence_deg: f64,
    /// Azimuth about the sheet's normal, degrees; `None` if the table is a mean over azimuths.
    pub azimuth_deg: Option<f64>,
    /// Distance R: optical path from the sheet to the image, mm.
    pub r_mm: f64,
}

/// Distance below which a mid-air image is not seen apart from its sheet, mm.
pub const NEAR_MM: f64 = 10.0;

/// Returns a remark if an image floats so near to its sheet that its distance may be in m or cm.
fn near(r_mm: f64) -> Option<String> {
    (r_mm < NEAR_MM)
        .then(|| format!("the image floats {r_mm} mm from the sheet; distances are in mm"))
}

/// Relative difference up to which two numbers count as one: they went through text.
const SAME: f64 = 1e-6;

/// Keys of the quantities of a domain, with the words and the unit of each.
const QUANTITIES: [(&str, &str, &str); 3] = [
    ("floating_distance_mm", "distance", "mm"),
    ("incidence_deg", "incidence", "deg"),
    ("azimuth_deg", "azimuth", "deg"),
];

/// Value of a quantity outside of the photographs, and their range.
#[derive(Clone, Copy)]
struct Left {
    value: f64,
    range: [f64; 2],
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

/// Returns, in the order of [`QUANTITIES`], the value of each quantity in which a place lies
/// outside of the photographs, with the range of the photographs.
fn left(domain: &Domain, symmetry: Symmetry, place: &Viewpoint) -> [Option<Left>; 3] {
    let plain = |value: f64, range| (!holds(range, value)).then_some(Left { value, range });
    let azimuths = place.azimuth_deg.zip(domain.azimuth_deg);
    let azimuth = azimuths.filter(|&(value, range)| !holds_azimuth(range, value, symmetry));
    [
        plain(place.r_mm, domain.floating_distance_mm),
        plain(place.incidence_deg, domain.incidence_deg),
        azimuth.map(|(value, range)| Left { value, range }),
    ]
}

/// Returns the keys of the quantities in which a place lies outside of the photographs.
pub(crate) fn outside(domain: &Domain, symmetry: Symmetry, place: &Viewpoint) -> Vec<&'static str> {
    let found = left(domain, symmetry, place).into_iter().zip(QUANTITIES);
    let keys = found.filter_map(|(left, (key, ..))| left.map(|_| key));
    keys.collect()
}

/// Returns remarks on predictions at some places, one sentence each: what must be known of waves,
/// that the result has warnings, the quantities in which the places lie outside of the photographs,
/// and what an older result does not say.
///
/// # Errors
/// Returns an error if the table lacks the first place, or if the result lacks a parameter there.
pub fn remarks(
    result: &ResultFile,
    table: &Table,
    places: &[Viewpoint],
) -> Result<Vec<String>, Error> {
    let [mut remarks, own] = Fitted { result, table }.warnings_apart();
    // `fit estimate` printed the warnings of photographs; every prediction would print them again.
    match own.len() {
        _ if result.is_by_hand() => remarks.extend(own),
        0 => {}
        1 => remarks.push("the result has a warning (its key warnings)".into()),
        count => remarks.push(format!(
            "the result has {count} warnings (its key warnings)"
        )),
    }
    if let (true, Some(baked), Some(source)) = (
        result.is_by_hand(),
        table.provenance.wavelength_nm,
        &result.wavelength_nm,
    ) && !source.holds(baked)
    {
        remarks.push(format!(
            "the table is baked for {baked} nm, which is not among the wavelengths given; bake a \
            table for them"
        ));
    }
    remarks.extend(beyond_numbers(result, places));
    let nearest = places.iter().map(|place| place.r_mm);
    remarks.extend(near(nearest.fold(f64::INFINITY, f64::min)));
    match &result.domain {
        None if result.is_by_hand() => {}
        None => remarks.push(
            "the result has no key domain (an older fit wrote it), so it is unknown whether this \
            lies outside of its photographs; fit again"
                .into(),
        ),
        Some(domain) => {
            remarks.extend(beyond(domain, table, places));
            let range = domain.floating_distance_mm;
            if result.kernel == Kernel::Eq1 && places.iter().any(|p| !holds(range, p.r_mm)) {
                remarks.push(one_lobe(range));
            }
        }
    }
    remarks.extend(too_coarse(&Fitted::new(result, table)?, places)?);
    if result.seen_in_mirror.is_none()
        && let Some(place) = places.first()
    {
        remarks.extend(unstated(&Fitted::new(result, table)?, place)?);
    }
    Ok(remarks)
}

/// Returns a remark if the table's bins of exit directions are too coarse for the farthest place.
///
/// # Errors
/// Returns an error if the table lacks the place, or if the result lacks a parameter there.
fn too_coarse(sheet: &Fitted<'_>, places: &[Viewpoint]) -> Result<Option<String>, Error> {
    let farthest = places.iter().max_by(|a, b| a.r_mm.total_cmp(&b.r_mm));
    let (Some(bins), Some(place)) = (ExitBins::of(sheet.table), farthest) else {
        return Ok(None);
    };
    let direction = (sheet.table).direction(place.incidence_deg, place.azimuth_deg)?;
    let mut lines = Vec::new();
    for axis in [[1.0, 0.0], [0.0, 1.0]] {
        lines.extend(Line::new(sheet, &direction, place.incidence_deg, axis)?);
    }
    let along = |r_mm: f64, frequency: f64| {
        let all = lines.iter().map(|line| line.at(r_mm).mtf(frequency));
        all.fold(0.0, f64::max)
    };
    Ok(bins.too_coarse(place.r_mm, along))
}

/// Share of returned light above which the own tables of nominal sheets err by less than 1 %
/// between their directions. A test bakes many directions between them.
const LIT: f64 = 0.01;

/// Relative error of a luminance from which on a remark names it.
const LOUD: f64 = 0.05;

/// Returns a remark on places between the directions of the table, unless the luminance is known
/// well there. Each is given by its incidence, degrees, and the share of light that returns.
pub fn between(sheet: &Fitted<'_>, places: impl IntoIterator<Item = (f64, f64)>) -> Option<String> {
    let Fitted { result, table } = sheet;
    let own = result.is_nominal() && result.table.content_hash == table.content_hash();
    let tolerance = table.provenance.direction_tolerance.filter(|_| !own);
    let is_bad = |&(_, share): &(f64, f64)| match tolerance {
        // A total variation of t allows an error of 2 t of the share.
        Some(tolerance) => 2.0 * tolerance > LOUD * share,
        None => !own || share < LIT,
    };
    let bad: Vec<(f64, f64)> = places.into_iter().filter(is_bad).collect();
    let least = bad
        .iter()
        .map(|&(_, share)| share)
        .reduce(f64::min)?
        .max(0.0);
    let mut at: Vec<f64> = bad.iter().map(|&(at, _)| at).collect();
    at.sort_by(f64::total_cmp);
    at.dedup();
    let at: Vec<String> = at.iter().map(f64::to_string).collect();
    let said = match tolerance {
        Some(tolerance) => format!(
            ", which allows an error of {tolerance} of all light (total variation), and only \
            {least:.4} returns: the luminance may err by {:.0} %",
            (200.0 * tolerance / least).min(100.0)
        ),
        None if own => format!(
            ", and only {least:.4} of the light returns: the luminance may err by more than 1 %"
        ),
        None => ", which costs accuracy (`bake trace` says how much)".to_owned(),
    };
    Some(format!(
        "the prediction at incidence {} deg is interpolated between directions of the table{said}; \
        bake these directions",
        at.join(", ")
    ))
}

/// Returns a remark if numbers that no photograph gave are taken beyond their incidences.
fn beyond_numbers(result: &ResultFile, places: &[Viewpoint]) -> Option<String> {
    let Some(Parameter::PerAngle { per_angle }) = result.spread() else {
        return None;
    };
    let known = || per_angle.iter().map(|own| own.incidence_deg);
    let range = [
        known().fold(f64::INFINITY, f64::min),
        known().fold(f64::NEG_INFINITY, f64::max),
    ];
    let all = places.iter().map(|place| place.incidence_deg);
    let outside: Vec<f64> = all.filter(|&own| !holds(range, own)).collect();
    (result.is_by_hand() && !outside.is_empty()).then(|| {
        format!(
            "incidence {} deg lies outside of those of the sheet's numbers ({} deg): the nearest \
            of them are taken",
            words(outside),
            words(range.to_vec())
        )
    })
}

/// Returns a remark for each quantity in which places lie outside of the photographs.
fn beyond(domain: &Domain, table: &Table, places: &[Viewpoint]) -> Vec<String> {
    let symmetry = table.provenance.symmetry;
    let mut found: [Vec<Left>; 3] = Default::default();
    for place in places {
        for (found, left) in found.iter_mut().zip(left(domain, symmetry, place)) {
            found.extend(left);
        }
    }
    let remark = |(found, (_, name, unit)): (Vec<Left>, (_, &str, &str))| {
        let range = found.first()?.range;
        Some(format!(
            "{name} {} {unit} lies outside of the photographs ({} {unit}): nothing was measured \
            there, and the intervals do not hold this error; photograph there too",
            words(found.iter().map(|left| left.value).collect()),
            words(range.to_vec())
        ))
    };
    let remarks = found.into_iter().zip(QUANTITIES).filter_map(remark);
    remarks.collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A range of azimuths goes the short way round, so it may begin below 0 or end above 360. An
    /// azimuth lies in it if a whole number of turns brings it there, and so does its image in a
    /// cell that repeats itself.
    #[test]
    fn azimuths_lie_in_ranges_across_0() {
        let sixfold = Symmetry {
            rotations: 6,
            mirror_deg: None,
        };
        let cases = [
            ([350.0, 370.0], 5.0, [true, true]),
            ([350.0, 370.0], 355.0, [true, true]),
            ([350.0, 370.0], -5.0, [true, true]),
            ([350.0, 370.0], 365.0, [true, true]),
            ([350.0, 370.0], 10.0, [true, true]),
            ([350.0, 370.0], 11.0, [false, false]),
            ([350.0, 370.0], 349.0, [false, false]),
            ([350.0, 370.0], 65.0, [false, true]),
            ([-20.0, 10.0], 345.0, [true, true]),
            ([-20.0, 10.0], 20.0, [false, false]),
            ([-20.0, 10.0], 100.0, [false, true]),
            ([20.0, 40.0], 380.0, [true, true]),
            ([20.0, 40.0], 0.0, [false, false]),
        ];
        for (range, azimuth_deg, held) in cases {
            let found = [Symmetry::NONE, sixfold]
                .map(|symmetry| holds_azimuth(range, azimuth_deg, symmetry));
            assert_eq!(found, held, "{azimuth_deg} in {range:?}");
        }
        assert_eq!(cases.len(), 13);
    }
}
