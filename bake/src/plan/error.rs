//! Why the options of a bake make no plan.

use crate::optics::MaterialError;
use crate::plan::limits::DIRECTIONS_LIMIT;
use tables::MOST_SHARDS;
use tables::cli::LONGEST_LIST;
use thiserror::Error;

/// Why a request is not a plan. Each names the option, what was given and what to give instead.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// A list of angles that cannot be read.
    #[error("{option} {text}: \"{part}\" is not an angle in degrees; give a list (0,15,30), \
    start:stop:step (0:45:5){}",
        if *.option == "--azimuth" { ", full or mean" } else { "" })]
    Angle {
        /// The option.
        option: &'static str,
        /// What was given.
        text: String,
        /// The part that cannot be read.
        part: String,
    },
    /// A range of angles that is empty or too long.
    #[error(
        "{option} {text}: the step does not lead from start to stop in 1 to {LONGEST_LIST} \
        angles; give start:stop:step with start <= stop and step > 0"
    )]
    Steps {
        /// The option.
        option: &'static str,
        /// What was given.
        text: String,
    },
    /// An angle outside its range.
    #[error("{option} {value}: the angle must be {range}")]
    AngleRange {
        /// The option.
        option: &'static str,
        /// The angle, degrees.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A number outside its range.
    #[error("{option} {value}: give a number {range}")]
    Number {
        /// The option.
        option: &'static str,
        /// The number.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A whole number outside its range.
    #[error("{option} {value}: give a whole number from 1 to {most}")]
    Count {
        /// The option.
        option: &'static str,
        /// The number.
        value: u64,
        /// The greatest it may be.
        most: u64,
    },
    /// A wavelength that is named twice.
    #[error(
        "--wavelength-nm {wavelengths:?}: each wavelength once, for each has a table of its own"
    )]
    Twice {
        /// The wavelengths, nm.
        wavelengths: Vec<f64>,
    },
    /// Two options that exclude each other.
    #[error("{first} and {second} exclude each other; leave one of them out")]
    Both {
        /// One option.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// A loss without losses.
    #[error("{option} needs --losses fresnel, or nothing of it is counted; give both or neither")]
    NeedsLosses {
        /// The option.
        option: &'static str,
    },
    /// An index that no name, number or list gives.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// The place of a wavelength that is not there.
    #[error("-o {output}: {{nm}} stands for a wavelength, and none is named; give --wavelength-nm")]
    NoWavelength {
        /// What was given.
        output: String,
    },
    /// Tables of several wavelengths that would be one file.
    #[error(
        "--wavelength-nm names {wavelengths} wavelengths, each with a table of its own, and -o \
        {output} is one file; write \
         {{nm}} where the wavelength belongs, such as sheet-{{nm}}.h5"
    )]
    OneFile {
        /// How many.
        wavelengths: usize,
        /// What was given.
        output: String,
    },
    /// An error estimate without independent randomisations.
    #[error(
        "--tolerance needs --sampler sobol, whose error is estimated from independent \
        randomisations; leave out --sampler random, or give --rays"
    )]
    ToleranceSampler,
    /// A share that cannot be read.
    #[error("--shard {text}: give K/N, share K of N, such as 2/8, with N at most {MOST_SHARDS}")]
    Shard {
        /// What was given.
        text: String,
    },
    /// Too many directions.
    #[error(
        "--incidence and --azimuth make {directions} directions; a table holds at most \
        {DIRECTIONS_LIMIT}: give fewer angles"
    )]
    Directions {
        /// Number of directions.
        directions: usize,
    },
}
