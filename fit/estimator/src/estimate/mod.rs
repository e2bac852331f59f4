//! Estimates of c, a and mu with their errors, from the photographs of a campaign.
//!
//! Photographs from files or from memory, a table, and options enter. An estimate with its terms,
//! bounds and warnings leaves. [`campaign`] does all of it. Photographs are measured once, into a
//! scene that nothing rewrites. This module writes no file and prints nothing.
//!
//! The files, from the lowest to the highest:
//!
//! - [`layout`]: the parameters of a candidate, and their order in a vector.
//! - [`direction`], [`scene`], `perturbed`: photographs with their directions. `compared`: their
//!   models.
//! - `joint`, [`loss`]: the function that is minimised. [`start`], [`optimum`]: its minimum.
//! - `covariance`, [`fitted`]: the results that follow from the minimum.
//! - [`select`](mod@select): the choice of the terms.
//! - [`bound`], `azimuth`, [`forward`]: bounds, the azimuth, and the estimate by samples.
//! - [`mod@goodness`], `suspects`: how well the fit describes the photographs, and why it does not.
//! - `unverified`: effects of what no photograph can check.
//! - `mirror`, `verdict`: warnings. [`progress`]: progress and cancellation.

mod azimuth;
pub mod bound;
pub mod campaign;
mod compared;
mod covariance;
pub mod direction;
pub mod error;
pub mod fitted;
pub mod forward;
pub mod goodness;
mod joint;
pub mod layout;
pub mod loss;
mod mirror;
pub(crate) mod optics;
pub mod optimum;
mod perturbed;
pub mod progress;
mod reference;
mod remarks;
pub mod scene;
pub mod select;
pub mod start;
mod suspects;
mod unverified;
mod verdict;

pub use azimuth::{Azimuth, find, scatter};
pub use bound::Bound;
pub(crate) use bound::Bounds;
pub use bound::{absent, bounds};
pub use campaign::{Estimated, Options};
pub use compared::curve;
pub use compared::{compare, model};
pub use error::Conflict;
pub use error::Error;
pub use fitted::Estimate;
pub use fitted::estimate;
pub use forward::Forward;
pub use forward::RANDOMISATIONS;
pub use forward::Renders;
pub use goodness::of as goodness;
pub use goodness::{Chances, Goodness, Verdict, Worst};
pub use joint::{Joint, Used};
pub use layout::{Choice, Layout, Value};
pub use loss::Kind;
pub use loss::Loss;
pub use optimum::Optimum;
pub use optimum::residuals_at;
pub use optimum::{refined, sum_of_squares_with, tolerance_for};
pub use perturbed::{Conditions, OtherIndex};
pub use progress::{Progress, Step};
pub use reference::measure as measured_reference;
pub use scene::{Aerial, Scene};
pub use select::Candidates;
pub use select::Ranked;
pub use select::Selection;
pub use select::{CLEAR, own_mu_limit, scatter_of_mu};
pub use suspects::{Diagnosis, OtherTable, Suspect};
pub use unverified::Doubted;
pub use unverified::in_words as unverified_in_words;
pub use unverified::{Effect, Unverified, UnverifiedInput};
