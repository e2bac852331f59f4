//! RESULT.json: an estimate, written to a file and read from it.
//!
//! An estimate and its table enter. A structure leaves whose fields are the keys of the file. The
//! module computes nothing but the scatter of several results, and the width of the lobe against
//! diffraction. It knows parameters as types; their text form (`a_per_mm_at_20`) exists only in the
//! file.

pub mod agreement;
mod by_hand;
mod capture;
mod diffraction;
mod domain;
mod nominal;
mod parameter;
mod quality;
pub(crate) mod report;
mod table;
pub mod truth;

pub use by_hand::{ByHand, Spread};
pub use capture::{CameraResult, CaptureResult};
pub use diffraction::WidthResult;
pub use domain::Domain;
pub use nominal::Nominal;
pub use parameter::{AtAngle, AtDistance, Number, OwnBlur, Parameter, Part};
pub use quality::{Candidate, FitResult, sharing};
pub use report::ResultFile;
pub use table::TableResult;
pub use truth::Truth;
