//! The request for a bake, as typed.

use crate::plan::effort::BINS_LIMIT;
use crate::plan::effort::MOST_THREADS;
use crate::plan::{default, heading};
use clap::Args;
use num_complex::Complex64;
use tables::cli::{number, whole};
use tables::options::{Back, Losses, Method, Sampler, SceneOptions};

/// Options of `bake trace` that shape the table, as typed.
#[derive(Debug, Clone, PartialEq, Args)]
#[command(allow_negative_numbers = true)]
#[command(mut_arg("deviations", |arg| arg.help_heading(heading::ACCURACY)))]
pub struct Request {
    /// Value of `--refractive-index`, where it is given
    #[arg(skip)]
    pub refractive_index: Option<f64>,
    /// Complex refractive index n + ik of `--metal`, where it is given
    #[arg(skip)]
    pub metal: Option<Complex64>,
    /// Value of `--wavelength-nm`, the wavelength in vacuum, nm, where it is given
    #[arg(skip)]
    pub wavelength_nm: Option<f64>,
    /// Angles of incidence in the air, degrees
    ///
    /// A list such as 0,15,30, or start:stop:step. The angle is measured from the sheet's normal.
    #[arg(
        long,
        value_name = "ANGLES",
        default_value = default::INCIDENCE,
        allow_hyphen_values = true
    )]
    pub incidence: String,
    /// Azimuths about the sheet's normal, degrees
    ///
    /// A list such as 0,30; start:stop:step; full for all azimuths in steps of at most 5 degrees,
    /// or full:STEP for another step; or mean for the average over all azimuths. With full, only
    /// one sector of a symmetric cell is baked. It stands for all azimuths.
    #[arg(
        long,
        value_name = "ANGLES",
        default_value = default::AZIMUTH,
        allow_hyphen_values = true
    )]
    pub azimuth: String,
    /// Histogram bins along u and along v
    #[arg(
        long,
        value_name = "N",
        default_value_t = default::BINS,
        help_heading = heading::ACCURACY,
        value_parser = whole::<usize>(1..=BINS_LIMIT)
    )]
    pub bins: usize,
    /// Half width of the histogram, edge lengths
    ///
    /// The histogram covers shifts u and v from -RANGE to RANGE.
    #[arg(
        long,
        value_parser = number,
        default_value_t = default::RANGE,
        help_heading = heading::ACCURACY
    )]
    pub range: f64,
    /// Largest deviation of retroreflected light, degrees
    ///
    /// A path counts as retroreflected if its linear map deviates from -I by at most this angle.
    /// For a plate, the map of its image takes the place of -I. With --glass-index, the exit
    /// direction decides.
    #[arg(
        long = "angular-tolerance",
        value_parser = number,
        value_name = "DEG",
        default_value_t = default::ANGULAR_TOLERANCE_DEG,
        help_heading = heading::ACCURACY
    )]
    pub angular_tolerance_deg: f64,
    /// Chooses directions that keep the interpolation error below TV
    ///
    /// Chooses the fewest directions between the ends of --incidence and of --azimuth, so that the
    /// polygons of an exact table, interpolated, give every other direction within this total
    /// variation of eta x histogram (above 0, at most 1). Steps, and listed angles between the
    /// ends, have no effect.
    #[arg(long, value_parser = number, value_name = "TV", help_heading = heading::ACCURACY)]
    pub direction_tolerance: Option<f64>,
    /// Backing of facets
    #[arg(long, value_enum, default_value_t = Back::Mirror, help_heading = heading::MATERIAL)]
    pub back: Back,
    /// Losses at surfaces
    ///
    /// With none, the reflectance mu that fit estimates contains these losses.
    #[arg(long, value_enum, default_value_t = Losses::None, help_heading = heading::MATERIAL)]
    pub losses: Losses,
    /// Share of the light that a mirror facet reflects [default: 1]
    ///
    /// Needs --losses fresnel.
    #[arg(long, value_parser = number, value_name = "R", help_heading = heading::MATERIAL)]
    pub reflectance: Option<f64>,
    /// Options that only some scenes have.
    #[command(flatten, next_help_heading = heading::MATERIAL)]
    pub scene: SceneOptions,
    /// Exact beams or rays
    #[arg(long, value_enum, default_value_t = Method::Auto, help_heading = heading::RAYS)]
    pub method: Method,
    /// Rays per direction [default: 4194304]
    #[arg(long, value_name = "N", help_heading = heading::RAYS, value_parser = whole::<u64>(1..))]
    pub rays: Option<u64>,
    /// Traces until the estimated L1 error of every direction is below E
    ///
    /// The L1 error is the sum, over the bins of eta x histogram, of the absolute errors. It is at
    /// most 2. Not together with --rays, --shard or --sampler random.
    #[arg(long, value_parser = number, value_name = "E", help_heading = heading::RAYS)]
    pub tolerance: Option<f64>,
    /// Kind of sample points
    #[arg(long, value_enum, default_value_t = Sampler::Sobol, help_heading = heading::RAYS)]
    pub sampler: Sampler,
    /// Seed of the samples
    ///
    /// To add rays to a table, bake again with the seed that follows, and merge the two tables.
    #[arg(
        long,
        default_value_t = default::SEED,
        help_heading = heading::RAYS,
        value_parser = whole::<u64>(0..)
    )]
    pub seed: u64,
    /// Traces only share K of N equal shares of the samples
    ///
    /// Merge the N tables with bake merge. The result is the table of a single bake, byte for byte.
    #[arg(long, value_name = "K/N", help_heading = heading::LONG_RUNS)]
    pub shard: Option<String>,
    /// Number of threads [default: all processors]
    ///
    /// The table does not depend on it.
    #[arg(
        long,
        value_name = "N",
        help_heading = heading::OUTPUT,
        value_parser = whole::<usize>(1..=MOST_THREADS)
    )]
    pub threads: Option<usize>,
}

impl Default for Request {
    fn default() -> Self {
        Request {
            incidence: default::INCIDENCE.into(),
            azimuth: default::AZIMUTH.into(),
            refractive_index: None,
            back: Back::Mirror,
            losses: Losses::None,
            reflectance: None,
            metal: None,
            wavelength_nm: None,
            method: Method::Auto,
            sampler: Sampler::Sobol,
            rays: None,
            tolerance: None,
            bins: default::BINS,
            range: default::RANGE,
            angular_tolerance_deg: default::ANGULAR_TOLERANCE_DEG,
            seed: default::SEED,
            threads: None,
            shard: None,
            direction_tolerance: None,
            scene: SceneOptions::default(),
        }
    }
}
