//! Warnings about an estimate.

use crate::estimate::scene::Scene;
use crate::estimate::scene::reference::between;
use crate::estimate::search::azimuth::Azimuth;
use crate::estimate::search::fitted::{Estimate, own_blurs};
use crate::estimate::search::hints::edge_by_edge;
use crate::estimate::search::layout::Value;
use crate::estimate::search::select::{CLEAR, Ranked};
use crate::estimate::trust::goodness::{Goodness, POOR_LENS, Verdict};
use crate::estimate::trust::suspects::{Diagnosis, Explains, Suspect};
use crate::model::{Further, OwnBlur};
use edges::names::{Kernel, ParameterId};

/// Ratio of the farthest to the nearest distance from which on a slip in one of them is likely.
const FAR_APART: f64 = 5.0;

/// Number of suspects that a warning names.
const SAID: usize = 3;

/// Returns the warnings about an estimate: undetermined parameters, a model that does not describe
/// the photographs, and impossible values.
pub(crate) fn of_estimate(
    scene: &Scene,
    best: &Estimate,
    compared: &[Ranked],
    goodness: &Goodness,
    (suspects, diagnosis): (&[Suspect], Diagnosis),
) -> Vec<String> {
    let mut warnings = Vec::new();
    // Only photographs at several distances, or the user, can tell how a scales with distance.
    let tried = |kernel| compared.iter().any(|row| row.choice.kernel == kernel);
    let open = best.choice.kernel.has_lobe() && tried(Kernel::Eq1) && tried(Kernel::Angular);
    let one_distance = scene
        .shots
        .iter()
        .all(|shot| (shot.r_mm / scene.shots[0].r_mm - 1.0).abs() < 1e-6);
    if open && one_distance {
        warnings.push(
            "all photographs are at one floating distance, so it is unknown whether a (kernel eq1) \
            or a R (kernel angular) is constant, and predictions at other distances depend on \
            this; photograph at a second distance too, or choose with --kernel"
                .into(),
        );
    }
    warnings.extend(unused_distances(scene, best.choice.kernel));
    let baseline = best.choice.kernel.is_baseline();
    warnings.extend(misfit(goodness, (suspects, diagnosis), baseline));
    warnings.extend(own_blur(scene, best));
    warnings.extend(either_blur(best, compared));
    warnings.extend(common_errors(best));
    warnings.extend(unlike_diffraction(scene, best));
    warnings.extend(coarse(best));
    warnings.extend(not_told(best));
    if let Some(mu) = best.mu.iter().flatten().find(|mu| is_above_one(mu)) {
        warnings.push(format!(
            "mu {:.3} means more light than falls on the sheet: check the exposures, the half \
            mirror and the table's cell",
            mu.value
        ));
    }
    warnings.extend(unlike_a_lens(scene));
    warnings
}

/// Angle between edges from which on they count as edges of several directions: 30 degrees.
const ACROSS_RAD: f64 = std::f64::consts::FRAC_PI_6;

/// Returns a warning if the mid-air photographs have a blur that the reference does not have.
fn own_blur(scene: &Scene, best: &Estimate) -> Option<String> {
    let all = own_blurs(scene, best.choice).into_iter();
    let each = |(id, own): (ParameterId, &Value)| {
        let at = id.place().map_or(String::new(), |at| format!(" at {at}"));
        format!("{:+.2} +- {:.2} px{at}", own.value, own.standard_error)
    };
    let all: Vec<String> = all.zip(&best.own_blur_px).map(each).collect();
    if all.is_empty() {
        return None;
    }
    let normals = scene.shots.iter().map(|shot| shot.pixels.line.normal_rad);
    let first = normals.clone().next().unwrap_or(0.0);
    let remedy = if normals.clone().all(|own| between(own, first) < ACROSS_RAD) {
        ""
    } else {
        " The edges run in several directions, and the blur is taken as round: shake along one axis \
        is not. Fit the photographs of each direction as a campaign of their own, and compare c"
    };
    Some(format!(
        "the mid-air photographs have a blur that the reference does not have: {} (standard deviation \
        of a Gaussian; negative: the reference is less sharp): focus, or vibration. The estimate \
        allows for it. Focus all photographs on their edge, with one aperture, and take the \
        reference at the distance of the mid-air image.{remedy}",
        all.join(", ")
    ))
}

/// Returns a warning if the cubes have dihedral errors that all of them share.
fn common_errors(best: &Estimate) -> Option<String> {
    let errors = best.dihedral_errors_mrad?;
    let values = edge_by_edge(&errors.map(|own| own.value));
    let standard = errors.map(|own| format!("{:.3}", own.standard_error));
    Some(format!(
        "the dihedral angles of all cubes are off by {values}, with standard errors of {}. The estimate \
        allows for it; photographs of edges in one direction tell only a combination of the three",
        standard.join(", ")
    ))
}

/// Returns a warning if a blur of the camera and an angular spread of the sheet explain the
/// photographs about equally well.
fn either_blur(best: &Estimate, compared: &[Ranked]) -> Option<String> {
    let own = best.choice.further;
    if own.has_own_blur() == own.angular_spread || own.common_errors {
        return None;
    }
    let criterion = |further: Further| {
        let rows = compared.iter().filter(|row| row.choice.further == further);
        rows.map(|row| row.criterion).reduce(f64::min)
    };
    let other = Further {
        own_blur: if own.angular_spread {
            OwnBlur::Shared
        } else {
            OwnBlur::None
        },
        angular_spread: own.has_own_blur(),
        common_errors: false,
    };
    let (own, other) = (criterion(own)?, criterion(other)?);
    let [taken, beside] = if best.choice.further.has_own_blur() {
        ["a blur of the camera", "an angular spread of the sheet"]
    } else {
        ["an angular spread of the sheet", "a blur of the camera"]
    };
    (other - own < CLEAR).then(|| {
        format!(
            "{taken} is taken for the further blur of the mid-air photographs, and {beside} would explain the \
            photographs as well; predictions at other distances depend on which of them it is. \
            Photographs at two distances tell them apart"
        )
    })
}

/// Returns a warning if distances lie far apart and the kernel does not use them: then no misfit
/// tells of a slip in one of them, such as 15 for 150.
fn unused_distances(scene: &Scene, kernel: Kernel) -> Option<String> {
    let all = || scene.shots.iter().map(|shot| shot.r_mm);
    let nearest = all().fold(f64::INFINITY, f64::min);
    let farthest = all().fold(0.0, f64::max);
    (!kernel.uses_distance() && farthest >= FAR_APART * nearest).then(|| {
        format!(
            "the floating distances go from {nearest} to {farthest} mm, and the blur of kernel {} \
            does not depend on them: a slip in floating_distance_mm goes unnoticed; check that \
            each is in mm",
            kernel.name()
        )
    })
}

/// Returns a warning if light would have to have an impossible wavelength.
///
/// An aperture of width c spreads light of the wavelength lambda so that A = a R is about pi c /
/// lambda. (The published fits of Sugawara and Koizumi, a R = 735, give 0.34 um if their c of 0.08
/// mm is an edge, and 0.59 um if it is the depth of the cubes.)
/// Rough facets spread light more, so lambda may come out several times too large. Distances in
/// another unit than mm change it by a factor of 10 or more, and no misfit tells of them.
fn unlike_diffraction(scene: &Scene, best: &Estimate) -> Option<String> {
    const LEAST_UM: f64 = 0.1;
    const MOST_UM: f64 = 3.0;
    let kernel = best.choice.kernel;
    if !matches!(kernel, Kernel::Eq1 | Kernel::Angular) {
        return None;
    }
    // The first incidence is the smallest one, where facets are foreshortened least.
    let (c, spread) = (best.c_mm?, best.spread.first()?);
    let scale = if kernel == Kernel::Angular {
        1.0
    } else {
        scene.mean_distance_mm()
    };
    let a_times_r = spread.value * scale;
    let wavelength_um = 1e3 * std::f64::consts::PI * c.value / a_times_r;
    (!(LEAST_UM..=MOST_UM).contains(&wavelength_um)).then(|| {
        format!(
            "floating_distance_mm or pixel_pitch_mm may be in another unit than mm; check them: \
            diffraction at apertures of {:.3} mm would need light of {wavelength_um:.2} um to \
            give a R = {a_times_r:.0} (rough facets raise this number too)",
            c.value
        )
    })
}

/// Returns a warning about a significant misfit, with its suspects.
fn misfit(
    goodness: &Goodness,
    (suspects, diagnosis): (&[Suspect], Diagnosis),
    baseline: bool,
) -> Option<String> {
    let verdict = goodness.verdict.name();
    // Those that mend the fit come first, and are not named beside others.
    let mending = suspects.iter().filter(|own| own.leaves_noise());
    let mends = mending.clone().next().is_some();
    let said = |of: &mut dyn Iterator<Item = &Suspect>| {
        let said: Vec<&str> = of.take(SAID).map(|own| own.what.as_str()).collect();
        said.join("; or if ")
    };
    let said = if mends {
        said(&mut mending.into_iter())
    } else {
        said(&mut suspects.iter())
    };
    let (of_blur, of_mu) = (goodness.scale, goodness.scale_of_mu);
    if goodness.reduced > 0 {
        return Some(reduced_noise(goodness));
    }
    match goodness.verdict {
        Verdict::Good => beside_a_good_fit(suspects, &said),
        Verdict::Strained if of_blur <= 1.0 => {
            let remedy = if said.is_empty() {
                format!(
                    "{}Check the exposures, and that the lamp is steady",
                    cut_short(diagnosis)
                )
            } else if mends {
                format!("They would agree if {said}. Check also that the lamp is steady")
            } else {
                format!(
                    "They would agree better, but not well, if {said}. Check also that the lamp is \
                    steady"
                )
            };
            Some(format!(
                "the fit is {verdict}: the photographs disagree on mu by more than their noise. \
                The standard errors of mu are multiplied by {of_mu:.2}; those of c and a do not \
                depend on the brightness. {remedy}"
            ))
        }
        Verdict::Strained | Verdict::Poor => {
            let grave = if goodness.verdict == Verdict::Poor {
                "the model does not describe the photographs"
            } else {
                "noise does not explain all differences between photographs and model"
            };
            let worst = goodness.worst.as_ref().map_or(String::new(), |worst| {
                let (image, reduced) = (&worst.image, worst.reduced_chi2);
                format!("; {image} fits worst, with {reduced:.2}")
            });
            let remedy = if baseline && said.is_empty() {
                "Mistakes are searched for with the proposed model only: leave --model out to look \
                for one"
                    .to_owned()
            } else if said.is_empty() && !diagnosis.complete {
                format!(
                    "{}Check the manifest, the photographs and the table",
                    cut_short(diagnosis)
                )
            } else if said.is_empty() {
                "No single mistake that was tried explains it: check the manifest, the \
                photographs and the table"
                    .to_owned()
            } else if mends {
                format!("It would fit if {said}")
            } else {
                format!("It would fit better, but not well, if {said}")
            };
            Some(format!(
                "the fit is {verdict}: {grave} (chi-square {:.3} per degree of freedom{worst}). \
                The standard errors of the blur are multiplied by {of_blur:.2}, those of mu by \
                {of_mu:.2}. {remedy}",
                goodness.reduced_chi2(),
            ))
        }
    }
}

/// Returns a warning about what mistakes would explain in a good fit. `said` names them.
fn beside_a_good_fit(suspects: &[Suspect], said: &str) -> Option<String> {
    let explains = suspects.first()?.explains;
    Some(if explains == Explains::FurtherBlur {
        format!(
            "what is taken for a further blur may be a mistake: the photographs would fit as well \
            without it if {said}. Check that first: c, a and mu depend on it"
        )
    } else {
        format!(
            "mu differs between the incidences, as it does in real sheets. But it would be one \
            number if {said}"
        )
    })
}

/// Returns the warning about a camera that changed the edges.
fn reduced_noise(goodness: &Goodness) -> String {
    format!(
        "the fit is {}: the camera changed the edges of {} photographs (their noise is reduced \
        beside the edge, or smoothed more widely than the reference's edge, or sharpening made the \
        reference darker than 0 beside the edge; see their warnings), which can move c, a and mu by \
        several percent at no misfit. The standard errors of the blur are multiplied by {:.2}, \
        those of mu by {:.2}. Photograph with noise reduction, sharpening and lens corrections \
        off, and save raw or 16 bits",
        goodness.verdict.name(),
        goodness.reduced,
        goodness.scale,
        goodness.scale_of_mu
    )
}

/// Returns a sentence about a search that did not come to its end, with the space behind it.
fn cut_short(diagnosis: Diagnosis) -> String {
    let Diagnosis {
        complete,
        tried,
        of,
    } = diagnosis;
    match (complete, tried) {
        (true, _) => String::new(),
        (false, 0) => "No mistake was searched for: --diagnose 60 does so. ".to_owned(),
        (false, _) => format!(
            "The search for a mistake ended by its limit of time ({tried} of {of} were tried); \
            --diagnose 60 gives it more. "
        ),
    }
}

/// Returns a warning if the model of the lens does not describe the reference.
fn unlike_a_lens(scene: &Scene) -> Option<String> {
    let reference = scene.reference.as_ref()?;
    (reference.reduced_chi2 > POOR_LENS).then(|| {
        format!(
            "the lens model does not describe the reference photograph within its noise \
            (chi-square {:.1} per degree of freedom)",
            reference.reduced_chi2
        )
    })
}

/// Returns whether mu is above 1 by more than three standard errors. 1 sheet in 700 whose mu is 1
/// gets this warning.
fn is_above_one(mu: &Value) -> bool {
    mu.value - 3.0 * mu.standard_error > 1.0
}

/// Returns a warning if the covariance is not finite. Then the photographs have no information on a
/// parameter, or none that separates it from another.
fn not_told(best: &Estimate) -> Option<String> {
    let rows = best.parameters.iter().zip(best.covariance.row_iter());
    let lost = rows.filter(|(_, row)| row.iter().any(|v| !v.is_finite()));
    let lost: Vec<String> = lost.map(|(id, _)| id.to_string()).collect();
    (!lost.is_empty()).then(|| {
        format!(
            "the photographs do not determine {} (not at all, or not separately): covariances that \
            are not finite are null in the result",
            lost.join(", ")
        )
    })
}

/// Returns a warning if the samples of a render cause a large part of the standard errors.
fn coarse(best: &Estimate) -> Option<String> {
    // Without the samples an error with a part of one half would be sqrt(1 - 1/4) = 0.87 of itself.
    const GOOD_PART: f64 = 0.5;
    let own = best.sampling.as_ref()?;
    let parts = own.standard_error.iter().enumerate();
    let worst = parts
        .map(|(i, error)| error / best.covariance[(i, i)].sqrt())
        .fold(0.0, f64::max);
    (worst > GOOD_PART).then(|| {
        format!(
            "up to {:.0} % of a standard error is the render's own sampling error: give more than \
            --samples {}",
            100.0 * worst,
            own.sampling.samples
        )
    })
}

/// Returns a warning for each other azimuth that fits as well.
pub(crate) fn of_azimuth(found: &Azimuth) -> Vec<String> {
    let others = found.others_deg.iter();
    let said = others.map(|deg| {
        format!(
            "azimuth {deg:.2} deg fits the photographs as well; a photograph of an edge in another \
            direction would tell the azimuths apart"
        )
    });
    said.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the limit on both sides of three standard errors. The numbers are eighths, so the
    /// comparison is exact.
    #[test]
    fn mu_is_above_one_beyond_three_standard_errors() {
        let cases = [
            (1.5, 0.125, true),
            (1.375, 0.125, false),
            (1.25, 0.125, false),
            (1.125, 0.0, true),
            (1.0, 0.0, false),
            (0.5, 0.125, false),
        ];
        for (value, standard_error, above) in cases {
            let mu = Value {
                value,
                standard_error,
            };
            assert_eq!(is_above_one(&mu), above, "{value} +- {standard_error}");
        }
        assert_eq!(cases.len(), 6);
    }
}
