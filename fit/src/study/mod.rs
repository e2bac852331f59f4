//! Studies of how good the estimates are: against the Cramer-Rao bound, and over simulated
//! campaigns.
//!
//! A table enters, with given photographs or with ranges from which campaigns are drawn. Errors,
//! coverage, seconds and shares of right choices leave. `simulate` photographs the drawn campaigns
//! in memory, and they go through the same call of `estimate` that the program makes. The room
//! prints and plots nothing. It may touch `simulate`, `estimate` and the rooms below them.

pub(crate) mod choice;
pub(crate) mod forward;
pub(crate) mod given;
pub(crate) mod mistakes;
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
#[cfg(test)]
pub(crate) use trial::{campaign, source};
