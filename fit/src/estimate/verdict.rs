//! Warnings about an estimate.

use crate::estimate::azimuth::Azimuth;
use crate::estimate::choice::Value;
use crate::estimate::fitted::Estimate;
use crate::estimate::scene::Scene;
use crate::estimate::select::Ranked;
use crate::names::Kernel;

/// Reduced chi-square above which a warning says that the model does not describe the photographs.
///
/// Reduced chi-square is 1 + the mean square of the misfit in units of the noise. So from 2 on the
/// misfit is as large as the noise. This limit is a convention. Noise alone scatters it by sqrt(2 /
/// degrees of freedom): it exceeds 2 in 5 of 1000 fits with 20 degrees of freedom, and in 4 of
/// 100,000 fits with 50.
///
/// The convention has a cost. With the thousands of bins of a campaign a misfit far below the noise
/// would be certain, but no warning is given. The standard errors are raised nevertheless, by up to
/// sqrt 2.
pub(crate) const POOR_FIT: f64 = 2.0;

/// Returns the warnings about an estimate: undetermined parameters, a model that does not describe
/// the photographs, and impossible values.
pub(crate) fn of_estimate(scene: &Scene, best: &Estimate, compared: &[Ranked]) -> Vec<String> {
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
    let reduced = best.reduced_chi2();
    if reduced > POOR_FIT {
        warnings.push(format!(
            "the model does not describe the photographs within their noise (chi-square \
            {reduced:.1} per degree of freedom): the standard errors are raised accordingly; try \
            another --kernel or --lobe, or check the manifest"
        ));
    }
    warnings.extend(coarse(best));
    warnings.extend(not_told(best));
    if let Some(mu) = best.mu.iter().flatten().find(|mu| is_above_one(mu)) {
        warnings.push(format!(
            "mu {:.3} means more light than falls on the sheet: check the exposures, the half \
            mirror and the table's cell",
            mu.value
        ));
    }
    if let Some(reference) = scene
        .reference
        .as_ref()
        .filter(|r| r.reduced_chi2 > POOR_FIT)
    {
        warnings.push(format!(
            "the lens model does not describe the reference photograph within its noise \
            (chi-square {:.1} per degree of freedom)",
            reference.reduced_chi2
        ));
    }
    warnings
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
