//! RESULT.json: an estimate as it is written, and read again.
//!
//! An estimate and its table enter; a structure leaves whose fields are the keys of the file. The
//! room computes nothing, and knows parameters as types: their text form (`a_per_mm_at_20`) is made
//! at the border of the file. It may touch `estimate` and the rooms below it.

pub(crate) mod report;
mod table;

pub use report::ResultFile;
pub(crate) use report::sharing;
pub(crate) use report::{AtAngle, Candidate, CaptureResult, Number, Parameter};
pub use table::TableResult;
