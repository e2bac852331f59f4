//! Defaults of `bake trace`, as a user types them: each is stated here, once.

/// `--incidence`
pub(crate) const INCIDENCE: &str = "0:45:5";
/// `--azimuth`
pub(crate) const AZIMUTH: &str = "0";
/// `--azimuth full` without a step, degrees
pub(crate) const FULL_STEP_DEG: f64 = 5.0;
/// `--rays` per direction
pub(crate) const RAYS: u64 = 4_194_304;
/// `--bins`
pub(crate) const BINS: usize = 128;
/// `--range`, edge lengths
pub(crate) const RANGE: f64 = 2.0;
/// `--angular-tolerance`, degrees
pub(crate) const ANGULAR_TOLERANCE_DEG: f64 = 0.5;
/// `--seed`
pub(crate) const SEED: u64 = 1;
/// Independent randomisations of a low-discrepancy sequence: enough for a standard error good to 18
/// %.
pub(crate) const RANDOMISATIONS: u64 = 16;
/// The same for `--tolerance`, which asks for the error of a histogram, a sum over thousands of
/// bins. The error of N rays in all grows as R^(1/4): 1.6 times fewer rays reach it than with 16,
/// at the price of a standard error of each eta that is good to 41 %.
pub(crate) const RANDOMISATIONS_TO_TOLERANCE: u64 = 4;
