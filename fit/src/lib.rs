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
//! use fit::{Candidates, Kernel, LobeShape, Options, Shot, Watch};
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
//! let found = estimate_campaign(&campaign, &Shot::load, &table, &options, &Watch::NOBODY)?;
//! let c = found.best.c_mm.expect("the kernel has a corner size");
//! println!("c = {:.4} +- {:.4} mm", c.value, c.standard_error);
//! // The photographs were made with c = 0.33 mm.
//! assert!((c.value - 0.33).abs() < 4.0 * c.standard_error);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Rooms
//! Each folder is a room. A room imports only the rooms before it in this list:
//!
//! - `numerics`: mathematics.
//! - `names`: kernels, lobes, parameters.
//! - `document`: TOML.
//! - `photographs`: files to edges.
//! - `model`: the transfer function of the blur.
//! - `samples`: the blur by samples.
//! - `simulate`: photographs with a planted answer, computed in another way than by the model.
//! - `compare`: a model seen through a photograph's estimator.
//! - `estimate`: c, a and mu with their errors.
//! - `result`: the file `result.json`.
//! - `predict`: MTF and luminance at other distances and angles.
//! - `images`: pictures through a sheet (a feature).
//! - `explore`: the page with sliders (two features).
//! - `study`: the quality of estimates.
//! - `report`: plots and the HTML page (a feature).
//! - `cli`: the program.

#![forbid(unsafe_code)]
#![warn(unreachable_pub)]
// Two rooms are features. Without them some items of the rooms below have no user.
#![cfg_attr(
    not(all(feature = "images", feature = "report")),
    allow(
        unused_imports,
        dead_code,
        unreachable_pub,
        reason = "rooms of features use it"
    )
)]

pub mod cli;
mod compare;
mod document;
mod estimate;
#[cfg(all(feature = "images", feature = "report"))]
mod explore;
#[cfg(feature = "images")]
mod images;
mod model;
mod names;
mod numerics;
mod photographs;
mod predict;
#[cfg(feature = "report")]
mod report;
mod result;
mod samples;
mod simulate;
mod study;
#[cfg(test)]
mod tests;

pub use crate::estimate::Bound;
pub use crate::estimate::Candidates;
pub use crate::estimate::Error;
pub use crate::estimate::Estimate;
pub use crate::estimate::Kind as LossKind;
pub use crate::estimate::campaign::campaign as estimate_campaign;
pub use crate::estimate::{Chances, Goodness, Verdict, Worst};
pub use crate::estimate::{Choice, Value};
pub use crate::estimate::{Effect, Given, Trusted};
pub use crate::estimate::{Estimated, Options};
pub use crate::estimate::{OtherTable, Suspect};
pub use crate::estimate::{Step, Watch};
pub use crate::names::Kernel;
pub use crate::names::LobeShape;
pub use crate::names::Spectrum;
pub use crate::names::{ParameterId, ParameterKind};
pub use crate::photographs::Measurement;
pub use crate::photographs::captures::load as load_campaign;
pub use crate::photographs::measure::edge as measure_edge;
pub use crate::photographs::photo::channel::Decode;
pub use crate::photographs::photo::exif::Settings;
pub use crate::photographs::photo::held::Held;
pub use crate::photographs::photo::load as load_photo;
pub use crate::photographs::photo::load_colour;
pub use crate::photographs::photo::picture::{Picture, Writing};
pub use crate::photographs::photo::plane::Photo;
pub use crate::photographs::photo::taken::Taken;
pub use crate::photographs::photo::transfer::Transfer;
pub use crate::photographs::{Campaign, Capture, Setup, Shot};
pub use crate::photographs::{Estimator, crossing};
pub use crate::predict::{Places, Prediction, predict as predict_mtf};
pub use crate::result::ResultFile;
pub use crate::result::TableResult;
pub use crate::simulate::Params as SimulationParams;
pub use crate::study::Ranges as StudyRanges;
