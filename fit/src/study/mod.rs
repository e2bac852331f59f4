//! How good the estimates are: against the Cramer-Rao bound, and over simulated campaigns.
//!
//! Given photographs, or ranges to draw campaigns from, and a table enter; errors, coverage, seconds and shares of right choices
//! leave. Drawn campaigns are photographed in memory by `simulate` and go through the very call of `estimate` that the program makes. The
//! room prints and draws nothing. It may touch `simulate`, `estimate` and the rooms below them.

pub mod choice;
pub mod forward;
pub mod given;
pub mod ranges;
pub mod refused;
pub mod summary;
pub mod trial;
