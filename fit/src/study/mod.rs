//! How good the estimates are: against the Cramer-Rao bound, and over simulated campaigns.
//!
//! Given photographs, or ranges to draw campaigns from, and a table enter; errors, coverage,
//! seconds and shares of right choices leave. Drawn campaigns are photographed in memory by
//! `simulate` and go through the very call of `estimate` that the program makes. The room prints
//! and draws nothing. It may touch `simulate`, `estimate` and the rooms below them.

pub(crate) mod choice;
pub(crate) mod forward;
mod given;
mod ranges;
pub(crate) mod refused;
pub(crate) mod summary;
pub(crate) mod trial;

pub(crate) use forward::{Speed, speed};
pub(crate) use given::{Study, photographs};
pub use ranges::Ranges;
pub(crate) use refused::Refused;
#[cfg(test)]
pub(crate) use summary::tells;
pub(crate) use summary::{Figure, LOOSE, Summary};
pub(crate) use trial::{LOSSES, PARAMETERS, Trial};
