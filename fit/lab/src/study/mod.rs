//! Studies of how good the estimates are: against the Cramer-Rao bound, and over simulated
//! campaigns.
//!
//! A table enters, with given photographs or with ranges from which campaigns are drawn. Errors,
//! coverage, seconds and shares of right choices leave. `simulate` photographs the drawn campaigns
//! in memory, and the same call estimates them that the program makes. Nothing is printed or
//! plotted here.

pub mod choice;
pub mod forward;
pub mod given;
pub mod mistakes;
mod ranges;
pub mod refused;
pub mod summary;
pub mod trial;

pub use forward::{Speed, speed};
pub use given::{Study, photographs};
pub use ranges::Ranges;
pub use refused::Refused;
#[cfg(test)]
pub(crate) use summary::tells;
pub use summary::{Figure, LOOSE, Summary};
pub use trial::{LOSSES, PARAMETERS, Trial};
#[cfg(test)]
pub(crate) use trial::{campaign, source};
