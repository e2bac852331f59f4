//! Estimates of c, a and mu with their errors, from the photographs of a campaign.
//!
//! Photographs from files or from memory, a table, and options enter. An estimate with its terms,
//! bounds and warnings leaves. [`campaign`] does all of it. Photographs are measured once, into a
//! scene that nothing rewrites. This module writes no file and prints nothing.
//!
//! - [`scene`]: photographs with their directions of the table, the lens by photographs of the source
//!   edge, and the scene under other conditions.
//! - [`search`]: candidates and their parameters, the function that is minimised and its minimum,
//!   the choice of the terms, covariances and bounds.
//! - [`trust`]: misfit and verdict, suspects, and effects of what no photograph can check.
//! - [`progress`]: progress and cancellation.

pub mod campaign;
pub mod progress;
mod remarks;
pub mod scene;
pub mod search;
pub mod trust;

pub use campaign::{Estimated, Options};
pub use progress::{Progress, Step};
pub use scene::perturbed::{Conditions, OtherIndex};
pub use scene::reference::measure as measured_reference;
pub use scene::reference::measure_parametric;
pub use scene::{Aerial, Place, Scene};
pub use search::azimuth::{Azimuth, find, scatter};
pub use search::bound::Bound;
pub(crate) use search::bound::Bounds;
pub use search::bound::{absent, bounds};
pub use search::compared::curve;
pub use search::compared::{compare, model};
pub use search::fitted::Estimate;
pub use search::fitted::estimate;
pub use search::forward::Forward;
pub use search::forward::RANDOMISATIONS;
pub use search::forward::Renders;
pub use search::joint::{Joint, Used};
pub use search::layout::{Choice, Layout, Value};
pub use search::loss::Kind;
pub use search::loss::Loss;
pub use search::optimum::Optimum;
pub use search::optimum::residuals_at;
pub use search::optimum::{refined, sum_of_squares_with, tolerance_for};
pub use search::select::Candidates;
pub use search::select::Ranked;
pub use search::select::Selection;
pub use search::select::{CLEAR, own_mu_limit, scatter_of_mu};
pub use trust::doubts::Doubted;
pub use trust::goodness::of as goodness;
pub use trust::goodness::{Chances, Goodness, Verdict, Worst};
pub use trust::suspects::{Diagnosis, Explains, OtherTable, Suspect};
pub use trust::unverified::in_words as unverified_in_words;
pub use trust::unverified::{Effect, Unverified, UnverifiedInput};
