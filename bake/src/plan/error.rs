//! Reasons why the options of a bake make no plan.

use crate::optics::MaterialError;
use crate::plan::limits::MOST_BYTES;
use tables::cli::LONGEST_LIST;
use tables::{MOST_DIRECTIONS, MOST_SHARDS};
use thiserror::Error;

/// Reason why a request makes no plan.
///
/// Each message names the option, what was given and what to give instead.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// List of angles that cannot be read.
    #[error("{option} {text}: \"{part}\" is not an angle in degrees; give a list (0,15,30), \
    start:stop:step (0:45:5){}",
        if *.option == "--azimuth" { ", full or mean" } else { "" })]
    Angle {
        /// Name of the option.
        option: &'static str,
        /// List that was given.
        text: String,
        /// Part of the list that cannot be read.
        part: String,
    },
    /// Range of angles that is empty or too long.
    #[error(
        "{option} {text}: the step does not lead from start to stop in 1 to {LONGEST_LIST} \
        angles; give start:stop:step with start <= stop and step > 0"
    )]
    Steps {
        /// Name of the option.
        option: &'static str,
        /// List that was given.
        text: String,
    },
    /// Angle outside its range.
    #[error("{option} {value}: the angle must be {range}")]
    AngleRange {
        /// Name of the option.
        option: &'static str,
        /// Angle that was given, degrees.
        value: f64,
        /// Allowed range, in words.
        range: &'static str,
    },
    /// Number outside its range.
    #[error("{option} {value}: give a number {range}")]
    Number {
        /// Name of the option.
        option: &'static str,
        /// Number that was given.
        value: f64,
        /// Allowed range, in words.
        range: &'static str,
    },
    /// Whole number outside its range.
    #[error("{option} {value}: give a whole number from 1 to {most}")]
    Count {
        /// Name of the option.
        option: &'static str,
        /// Number that was given.
        value: u64,
        /// Largest number allowed.
        most: u64,
    },
    /// Wavelength that is given twice.
    #[error(
        "--wavelength-nm {wavelengths:?}: a wavelength is given twice; give each wavelength once, \
        because each has a table of its own"
    )]
    Twice {
        /// All wavelengths that were given, nm.
        wavelengths: Vec<f64>,
    },
    /// Two options that exclude each other.
    #[error("{first} and {second} exclude each other; leave one of them out")]
    Both {
        /// One of the two options.
        first: &'static str,
        /// The other option.
        second: &'static str,
    },
    /// Option of a loss without `--losses`.
    #[error(
        "{option} needs --losses fresnel, because without it no losses are counted; give both \
        options or neither"
    )]
    NeedsLosses {
        /// Name of the option.
        option: &'static str,
    },
    /// Refractive index that no name, number or list gives.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// Placeholder `{nm}` in the name of the output, without a wavelength.
    #[error(
        "-o {output}: {{nm}} stands for a wavelength, but no wavelength is given; give \
        --wavelength-nm, or a name without {{nm}}"
    )]
    NoWavelength {
        /// Name of the output file that was given.
        output: String,
    },
    /// Several wavelengths whose tables would go to one file.
    #[error(
        "--wavelength-nm names {wavelengths} wavelengths, and each of them has a table of its \
        own, but -o {output} names one file only; write {{nm}} where the wavelength belongs in \
        the name, such as sheet-{{nm}}.h5"
    )]
    OneFile {
        /// Number of wavelengths.
        wavelengths: usize,
        /// Name of the output file that was given.
        output: String,
    },
    /// Tolerance for a sampler that has no independent randomisations to estimate the error from.
    #[error(
        "--tolerance needs --sampler sobol, whose error is estimated from independent \
        randomisations; leave out --sampler random, or give --rays"
    )]
    ToleranceSampler,
    /// Share of the samples that cannot be read.
    #[error("--shard {text}: give K/N, share K of N, such as 2/8, with N at most {MOST_SHARDS}")]
    Shard {
        /// Text that was given.
        text: String,
    },
    /// Histograms that take more memory than a table may.
    #[error(
        "--bins {bins} in {directions} directions make arrays of {bytes} bytes; a table holds at \
        most {MOST_BYTES}: give fewer bins or fewer angles"
    )]
    Memory {
        /// Number of bins along an axis.
        bins: usize,
        /// Number of directions.
        directions: usize,
        /// Length of the greatest array, bytes.
        bytes: u64,
    },
    /// More directions than a table may hold.
    #[error(
        "--incidence and --azimuth make {directions} directions; a table holds at most \
        {MOST_DIRECTIONS}: give fewer angles"
    )]
    Directions {
        /// Number of directions.
        directions: usize,
    },
}
