//! Estimates three numbers of a retroreflective sheet from photographs, and predicts with them the
//! mid-air images of the sheet at other distances and angles.
//!
//! A sheet of corner cubes blurs and dims its mid-air images. Three numbers describe this: `c`, the
//! size of the corner cubes, which scales the ray shift; `a`, the diffraction spread; and `mu`, the
//! reflectance. This crate estimates them, with standard errors, from photographs of an edge and
//! from a table of ray shifts, which the program `bake` makes. From the three numbers it computes
//! MTF and luminance at any distance and angle. The method is that of Sugawara and Koizumi
//! (SIGGRAPH Asia 2025 Posters).
//!
//! # Units
//! - Lengths are in mm, in the plane of the mid-air image. `a` and frequencies are in 1/mm.
//! - Angles are in radians. Names that end in `_deg`, files and options have degrees.
//! - Light is linear, in any unit. The exposure of a photograph is relative to that of the
//!   reference.
//!
//! # Measure an edge
//! ```
//! use fit::{Decode, Estimator, crossing, load_photo, measure_edge};
//!
//! let photo = load_photo("../tests/edges/camera_5deg.exr".as_ref(), &Decode::default())?;
//! let edge = measure_edge(&photo, None, &[])?;
//! // With a pixel pitch of 1, frequencies are in cycles per pixel. 101 of them reach from 0 to the
//! // sampling frequency.
//! let estimator = Estimator::new(&edge.profile, 1.0, 400, 101);
//! let mtf = estimator.measure(&edge.profile).modulus;
//! let half = crossing(&estimator.frequencies_per_mm, &mtf, 0.5);
//! assert!((edge.line.normal_rad.to_degrees() - 5.0).abs() < 0.1);
//! assert!(half.is_some_and(|f| f > 0.1 && f < 0.5));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Estimate a sheet
//! ```
//! use fit::{Candidates, Kernel, LobeShape, Options, Shot, Progress};
//! use fit::{estimate_campaign, load_campaign};
//!
//! let mut campaign = load_campaign("../tests/captures/public_shared/captures.toml".as_ref())?;
//! // This small table holds two incidences. The photographs were taken at more.
//! let table = tables::read("../tables/tests/kept/version_1_exact.h5".as_ref())?;
//! campaign.captures.retain(|capture| capture.incidence_deg == 0.0);
//!
//! let options = Options::new(Candidates {
//!     kernels: vec![Kernel::Eq1],
//!     shapes: vec![LobeShape::Separable],
//!     ..Candidates::proposed()
//! });
//! // Here the photographs come from their files. Any other function of a `Shot` can supply them.
//! let found = estimate_campaign(&campaign, &Shot::load, &table, &options, &Progress::SILENT)?;
//! let c = found.best.c_mm.expect("the kernel has a corner size");
//! println!("c = {:.4} +- {:.4} mm", c.value, c.standard_error);
//! // The photographs were made with c = 0.33 mm.
//! assert!((c.value - 0.33).abs() < 4.0 * c.standard_error);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]
#![warn(unreachable_pub)]
#![cfg_attr(
    not(feature = "full"),
    allow(
        unused_imports,
        dead_code,
        unreachable_pub,
        reason = "the verbs that are left out use it"
    )
)]
pub mod cli;

pub use edges::names::Kernel;
pub use edges::names::LobeShape;
pub use edges::names::Spectrum;
pub use edges::names::{ParameterId, ParameterKind};
pub use edges::photographs::Measurement;
pub use edges::photographs::manifest::captures::load as load_campaign;
pub use edges::photographs::measure::edge as measure_edge;
pub use edges::photographs::photo::channel::Decode;
pub use edges::photographs::photo::exif::Settings;
pub use edges::photographs::photo::in_memory::InMemory;
pub use edges::photographs::photo::load as load_photo;
pub use edges::photographs::photo::load_colour;
pub use edges::photographs::photo::picture::Picture;
pub use edges::photographs::photo::plane::Photo;
pub use edges::photographs::photo::taken::Taken;
pub use edges::photographs::photo::transfer::Transfer;
pub use edges::photographs::{Campaign, Capture, Setup, Shot};
pub use edges::photographs::{Estimator, crossing};
pub use estimator::Error;
pub use estimator::estimate::Bound;
pub use estimator::estimate::Candidates;
pub use estimator::estimate::Estimate;
pub use estimator::estimate::Kind as LossKind;
pub use estimator::estimate::campaign::campaign as estimate_campaign;
pub use estimator::estimate::{Chances, Goodness, Verdict, Worst};
pub use estimator::estimate::{Choice, Value};
pub use estimator::estimate::{Effect, Unverified, UnverifiedInput};
pub use estimator::estimate::{Estimated, Options};
pub use estimator::estimate::{OtherTable, Suspect};
pub use estimator::estimate::{Progress, Step};
pub use estimator::predict::{Places, Prediction, predict as predict_mtf};
pub use estimator::result::ResultFile;
pub use estimator::result::TableResult;
#[cfg(feature = "full")]
pub use lab::simulate::Params as SimulationParams;
#[cfg(feature = "full")]
pub use lab::study::Ranges as StudyRanges;
#[cfg(feature = "full")]
pub use pictures::images::Writing;
