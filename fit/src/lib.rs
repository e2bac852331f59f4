//! Estimates what a retroreflective sheet does to mid-air images, and predicts what it will show
//! elsewhere.
//!
//! Mid-air images of corner-cube sheets are blurred and dimmed. Three numbers of the sheet describe
//! it: `c` (corner size, of which the ray shift is a multiple), `a` (diffraction spread) and `mu`
//! (reflectance). This crate finds them, with standard errors, from photographs of an edge and a
//! table of the ray shifts that the program `bake` makes; and with them it gives MTF and luminance
//! at any distance and angle. The method is Sugawara and Koizumi's (SIGGRAPH Asia 2025 Posters).
//!
//! # Units
//! Lengths in mm, of the aerial image's plane; `a` and frequencies in 1/mm. Angles in radians, but
//! for names that end in `_deg`, as in files and options. Light is linear, of any unit, and a
//! photograph's exposure is relative to the reference's.
//!
//! # Measure an edge
//! ```
//! use fit::{Decode, Estimator, crossing, load_photo, measure_edge};
//!
//! let photo = load_photo("../tests/edges/camera_5deg.exr".as_ref(), &Decode::default())?;
//! let edge = measure_edge(&photo, None, &[])?;
//! // The pitch of the pixels: 1, so that frequencies are in cycles per pixel. 101 of them, up to the sampling frequency.
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
//! use fit::{Candidates, Kernel, LobeShape, Options, Shot, Watch, estimate_campaign, load_campaign};
//!
//! let mut campaign = load_campaign("../tests/captures/public_shared/captures.toml".as_ref())?;
//! // This small table holds two angles of incidence; the photographs were taken at more.
//! let table = tables::read("../tables/tests/kept/version_1_exact.h5".as_ref())?;
//! campaign.captures.retain(|capture| capture.incidence_deg == 0.0);
//!
//! let options = Options::new(Candidates {
//!     kernels: vec![Kernel::Eq1],
//!     shapes: vec![LobeShape::Separable],
//!     ..Candidates::proposed()
//! });
//! // Photographs come from their files here; any other function of a `Shot` will do.
//! let found = estimate_campaign(&campaign, &Shot::load, &table, &options, &Watch::NOBODY)?;
//! let c = found.best.c_mm.expect("the kernel has a corner size");
//! println!("c = {:.4} +- {:.4} mm", c.value, c.standard_error);
//! // The photographs were made with c = 0.33 mm.
//! assert!((c.value - 0.33).abs() < 4.0 * c.standard_error);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Rooms
//! Every folder is a room, and imports only those that stand before it here: `numerics`
//! (mathematics), `names` (kernels, lobes, parameters), `document` (TOML), `photographs` (files to
//! edges), `model` (the blur's transfer function), `samples` (the blur by samples), `simulate`
//! (photographs with a planted answer, by another road than the model's), `compare` (a model seen
//! through a photograph's estimator), `estimate`, `result` (result.json), `predict`, `images`
//! (pictures through a sheet; a feature), `study` (how good estimates are), `report` (plots and the
//! HTML page; a feature), `cli` (the program).

#![forbid(unsafe_code)]
#![warn(unreachable_pub)]
// A room serves the rooms above it, two of which the lean fitter leaves out.
#![cfg_attr(
    not(all(feature = "images", feature = "report")),
    allow(unused_imports, dead_code, reason = "rooms of features use it")
)]

pub mod cli;
mod compare;
mod document;
mod estimate;
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
pub use crate::estimate::{Choice, Value};
pub use crate::estimate::{Estimated, Options};
pub use crate::estimate::{Step, Watch};
pub use crate::names::Kernel;
pub use crate::names::LobeShape;
pub use crate::names::Spectrum;
pub use crate::names::{ParameterId, ParameterKind};
pub use crate::photographs::Measurement;
pub use crate::photographs::captures::load as load_campaign;
pub use crate::photographs::measure::edge as measure_edge;
pub use crate::photographs::photo::channel::Decode;
pub use crate::photographs::photo::load as load_photo;
pub use crate::photographs::photo::load_colour;
pub use crate::photographs::photo::picture::{Picture, Writing};
pub use crate::photographs::photo::plane::Photo;
pub use crate::photographs::photo::settings::Settings;
pub use crate::photographs::photo::transfer::Transfer;
pub use crate::photographs::{Campaign, Capture, Setup, Shot};
pub use crate::photographs::{Estimator, crossing};
pub use crate::predict::{Places, Prediction, predict as predict_mtf};
pub use crate::result::ResultFile;
pub use crate::result::TableResult;
pub use crate::simulate::Params as SimulationParams;
pub use crate::study::Ranges as StudyRanges;
