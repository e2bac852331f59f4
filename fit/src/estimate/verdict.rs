//! Warnings about an estimate.

use crate::estimate::azimuth::Azimuth;
use crate::estimate::choice::Value;
use crate::estimate::fitted::Estimate;
use crate::estimate::goodness::{Goodness, Verdict};
use crate::estimate::scene::Scene;
use crate::estimate::select::Ranked;
use crate::names::Kernel;

/// Chi-square per degree of freedom of the reference's MTF above which the lens model does not
/// describe it.
///
/// Chi-square per degree of freedom is 1 + the mean square of the misfit in units of the noise. So
/// from 2 on the misfit is as large as the noise. This limit is a convention. Noise alone exceeds
/// it in 5 of 1000 fits with 20 degrees of freedom.
const POOR_LENS: f64 = 2.0;

/// Returns the warnings about an estimate: undetermined parameters, a model that does not describe
/// the photographs, and impossible values.
pub(crate) fn of_estimate(
    scene: &Scene,
    best: &Estimate,
    compared: &[Ranked],
    goodness: &Goodness,
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
    warnings.extend(misfit(goodness));
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

/// Returns a warning about a significant misfit.
fn misfit(goodness: &Goodness) -> Option<String> {
    let grave = match goodness.verdict {
        Verdict::Good => return None,
        Verdict::Strained => "noise does not explain all differences between photographs and model",
        Verdict::Poor => "the model does not describe the photographs",
    };
    let worst = goodness
        .worst
        .as_ref()
        .map(|(image, reduced)| format!("; {image} fits worst ({reduced:.2})"));
    Some(format!(
        "the fit is {}: {grave} (chi-square {:.3} per degree of freedom{}); all standard errors \
        are multiplied by {:.2}; check the manifest and the table, or try another --kernel or \
        --lobe",
        goodness.verdict.name(),
        goodness.reduced_chi2(),
        worst.unwrap_or_default(),
        goodness.scale
    ))
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
