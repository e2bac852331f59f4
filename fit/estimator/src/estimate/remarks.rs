//! Warnings about the table and the references with which a campaign is fitted.

use tables::Table;
use tables::options::Element;

use crate::compare::View;
use crate::estimate::scene::reference::Reference;
use crate::model::{Camera, ExitBins};
use edges::photographs::Campaign;
use edges::photographs::photo::taken::Taken;

/// Returns the largest angle of the table's light off the exact way back, rad, or `None` if the
/// table records none or it is too small to see.
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

/// Returns the warnings about a table for the estimates of a campaign, one sentence each.
pub(crate) fn of_table(table: &Table, campaign: &Campaign) -> Vec<String> {
    let mut warnings = Vec::new();
    let spectrum = &campaign.setup.spectrum;
    if table.axes.is_mean() && campaign.captures.iter().any(|c| c.azimuth_deg.is_some()) {
        warnings.push(
            "the table is a mean over azimuths: azimuth_deg of the captures has no effect; bake \
            the azimuths to use it"
                .into(),
        );
    }
    let losses = table.provenance.losses_text();
    if losses != "none" {
        warnings.push(format!(
            "the table holds the losses of the surfaces ({losses}): mu contains only the other \
            losses"
        ));
    }
    if let (Some(baked), Some(source)) = (table.provenance.wavelength_nm, spectrum)
        && !source.holds(baked)
    {
        warnings.push(format!(
            "the table is baked for {baked} nm, which is not a wavelength of the source; bake a \
            table for the source's wavelength"
        ));
    }
    if table.provenance.element() == Element::Plate {
        warnings.push(
            "the table is of a micro-mirror array plate: c is the pitch of its mirrors, floating \
            distances are measured from its middle plane, and half_mirror_transmittance and \
            half_mirror_reflectance must be 1 if there is no half mirror"
                .into(),
        );
    }
    if table.provenance.has_glass() {
        warnings.push(
            "the table is of bodies of glass, which return light in a cone as wide as the table's \
            angular tolerance: c is the pitch of the bodies, and a describes the blur that the \
            recorded directions do not explain, not the aperture of a cube"
                .into(),
        );
    }
    if let Some(largest) = deviates(table) {
        let held = match table.exact {
            Some(_) => " where the table gives polygons",
            None => "",
        };
        warnings.push(format!(
            "the table's cubes send light up to {:.3} mrad off the exact way back: the model \
            includes this deviation{held}",
            1e3 * largest
        ));
    }
    warnings
}

/// Returns a warning if the table's bins of exit directions are too coarse for the photograph that
/// needs the finest.
///
/// The MTF is that of the photograph itself, as if it were the same at lesser distances: so the
/// distance from which on the bins are too coarse is rather too great.
///
/// `shots` holds the name, the distance R in mm and the measured edge of each photograph.
pub(crate) fn of_bins<'s>(
    table: &Table,
    shots: impl Iterator<Item = (&'s str, f64, &'s View)>,
) -> Option<String> {
    let bins = ExitBins::of(table)?;
    let mtf = |view: &View, frequency: f64| view.mtf_at(frequency).map_or(0.0, |[mtf, _]| mtf);
    let lost = |(_, r_mm, view): &(&str, f64, &View)| bins.lost(*r_mm, |f| mtf(view, f));
    let (image, r_mm, view) = shots.max_by(|a, b| lost(a).total_cmp(&lost(b)))?;
    let said = bins.too_coarse(r_mm, |_, frequency| mtf(view, frequency))?;
    Some(format!("{image}: {said}"))
}

/// Returns a warning if the reference and a capture were not read with the same relation between
/// stored values and light. `captures` holds the name and the relation of each.
pub(crate) fn of_transfers<'a>(
    reference: &Taken,
    mut captures: impl Iterator<Item = (&'a str, &'a Taken)>,
) -> Option<String> {
    let (image, other) = captures.find(|(_, taken)| taken.name != reference.name)?;
    Some(format!(
        "the reference was read as {reference}, but {image} as {other}: mu compares the two; set \
        `transfer` if this is wrong"
    ))
}

/// Returns a warning if references of several directions show the lens, and a capture lies far from
/// all of them. `captures` holds the name and the measured edge of each.
///
/// Between two perpendicular references the lens is known but for a cross term, which is at its
/// largest 45 degrees from both.
pub(crate) fn of_directions<'a>(
    reference: &Reference,
    camera: &Camera,
    captures: impl Iterator<Item = (&'a str, &'a View)>,
) -> Option<String> {
    // This limit is a convention.
    const FAR_DEG: f64 = 30.0;
    if camera.lenses.len() < 2 {
        return None;
    }
    let off = |view: &View| reference.nearest(view.line.normal_rad).1.to_degrees();
    let farthest = captures.map(|(image, view)| (image, off(view)));
    let (image, off) = farthest.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (off > FAR_DEG).then(|| {
        format!(
            "{image}: its edge is turned by {off:.0} deg against the nearest [[reference]], and the \
            lens is interpolated between the references; photograph the source edge in this \
            direction too"
        )
    })
}

/// Returns a warning for each further reference whose edge is brighter or darker per exposure than
/// the mean of all by more than noise explains. `names` are those of the references.
pub(crate) fn of_steps(reference: &Reference, names: &[String]) -> Vec<String> {
    // Noise exceeds 4 deviations once in 16,000. Exposures are not known to better than the share.
    const SURE: f64 = 4.0;
    const SHARE: f64 = 0.005;
    let all = reference.photographs.iter().zip(names);
    let off = all.map(|(own, name)| (own.step / reference.step, own.step_relative_error, name));
    let off = off.filter(|(ratio, error, _)| ratio.ln().abs() > SHARE.max(SURE * error));
    off.map(|(ratio, _, name)| {
        format!(
            "{name}: its edge has {ratio:.4} of the mean light of all references per exposure, \
            and mu is relative to this mean; check the exposures, and that the source is steady"
        )
    })
    .collect()
}
