//! Defaults of `bake trace`, in the form that a user types. Each default stands here and nowhere
//! else.

/// Default of `--incidence`: angles, degrees.
pub(crate) const INCIDENCE: &str = "0:45:5";
/// Default of `--azimuth`: angles, degrees.
pub(crate) const AZIMUTH: &str = "0";
/// Default step of `--azimuth full`, degrees.
pub(crate) const FULL_STEP_DEG: f64 = 5.0;
/// Default of `--rays`: rays per direction.
pub(crate) const RAYS: u64 = 4_194_304;
/// Default of `--bins`: bins along each axis of the histogram.
pub(crate) const BINS: usize = 128;
/// Default of `--range`: half the width of the histogram, edge lengths.
pub(crate) const RANGE: f64 = 2.0;
/// Default of `--angular-tolerance`, degrees.
pub(crate) const ANGULAR_TOLERANCE_DEG: f64 = 0.5;
/// Default of `--seed`.
pub(crate) const SEED: u64 = 1;
/// Number of independent randomisations of a low-discrepancy sequence for a number of rays.
///
/// With 16 of them the standard error is known to 18 %.
pub(crate) const RANDOMISATIONS: u64 = 16;
/// Number of independent randomisations of a low-discrepancy sequence for `--tolerance`.
///
/// `--tolerance` limits the error of a histogram, which is a sum over thousands of bins. With R
/// randomisations and N rays in all, this error grows as R^(1/4). So 4 randomisations reach a given
/// error with 1.6 times fewer rays than 16. The price is that the standard error of each eta is
/// known to 41 % only.
pub(crate) const RANDOMISATIONS_TO_TOLERANCE: u64 = 4;
