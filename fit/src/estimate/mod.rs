//! Estimates of c, a and mu with their errors, from the photographs of a campaign.
//!
//! Photographs from files or from memory, a table, and options enter. An estimate with its terms,
//! bounds and warnings leaves. [`campaign`] does all of it. Photographs are measured once, into a
//! scene that nothing rewrites. The room writes no file and prints nothing. It may touch `compare`,
//! `samples`, `model`, `photographs`, `names` and `numerics`, but not the simulator.
//!
//! The files, from the lowest to the highest:
//!
//! - [`choice`]: the parameters of a candidate. [`layout`]: their order in a vector.
//! - [`facing`], [`scene`], [`placed`]: photographs with their directions. [`compared`]: their
//!   models.
//! - [`joint`], [`loss`]: the function that is minimised. [`start`], [`optimum`]: its minimum.
//! - [`covariance`], [`fitted`]: the results that follow from the minimum.
//! - [`select`](mod@select): the choice of the terms.
//! - [`bound`], [`azimuth`], [`forward`]: bounds, the azimuth, and the estimate by samples.
//! - [`goodness`], [`suspects`]: how well the fit describes the photographs, and why it does not.
//! - [`trusted`]: effects of what no photograph can check.
//! - [`mirror`], [`verdict`]: warnings. [`watch`]: progress and cancellation.

mod azimuth;
mod bound;
pub(crate) mod campaign;
mod choice;
mod compared;
mod covariance;
pub(crate) mod error;
mod facing;
mod fitted;
pub(crate) mod forward;
mod goodness;
mod joint;
mod layout;
mod loss;
mod mirror;
pub(crate) mod optics;
pub(crate) mod optimum;
mod placed;
mod reference;
mod remarks;
pub(crate) mod scene;
pub(crate) mod select;
mod start;
mod suspects;
mod trusted;
mod verdict;
mod watch;

#[cfg(test)]
pub(crate) use azimuth::{Azimuth, find, scatter};
pub use bound::Bound;
pub(crate) use bound::Bounds;
#[cfg(test)]
pub(crate) use bound::{absent, bounds};
pub use campaign::{Estimated, Options};
pub use choice::{Choice, Value};
pub(crate) use compared::curve;
#[cfg(test)]
pub(crate) use compared::{compare, model};
#[cfg(test)]
pub(crate) use error::Conflict;
pub use error::Error;
pub use fitted::Estimate;
pub(crate) use fitted::estimate;
pub(crate) use forward::Forward;
#[cfg(test)]
pub(crate) use forward::RANDOMISATIONS;
pub(crate) use forward::Renders;
pub(crate) use goodness::of as goodness;
pub use goodness::{Chances, Goodness, Verdict, Worst};
pub(crate) use joint::{Joint, Used};
pub(crate) use layout::Layout;
pub use loss::Kind;
pub(crate) use loss::Loss;
pub(crate) use optimum::Optimum;
#[cfg(test)]
pub(crate) use optimum::residuals_at;
pub(crate) use optimum::{refined, sum_of_squares_with, tolerance_for};
#[cfg(test)]
pub(crate) use placed::{OtherIndex, Placed};
#[cfg(test)]
pub(crate) use reference::measure as measured_reference;
pub(crate) use scene::{Aerial, Scene};
pub use select::Candidates;
pub(crate) use select::Ranked;
#[cfg(test)]
pub(crate) use select::Selection;
pub(crate) use select::{CLEAR, own_mu_limit, scatter_of_mu};
pub use suspects::{OtherTable, Suspect};
#[cfg(test)]
pub(crate) use trusted::Doubted;
pub(crate) use trusted::in_words as trusted_in_words;
pub use trusted::{Effect, Given, Trusted};
pub use watch::{Step, Watch};
