//! From a campaign's photographs to c, a and mu, with their errors.
//!
//! Photographs, from files or from memory, a table and options enter; an estimate leaves, with its terms, bounds and warnings
//! ([`campaign`] does all of it). Photographs are measured once, into a scene that nothing rewrites. The room writes no file and prints
//! nothing. It may touch `compare`, `samples`, `model`, `photographs`, `names` and `numerics`, but not the simulator.
//!
//! From the ground: [`choice`] what a candidate lets vary, [`layout`] where its parameters stand, [`facing`] and [`scene`] the photographs
//! beside their directions, [`compared`] beside their models, [`joint`] and [`loss`] what is minimised, [`start`] and [`optimum`] where
//! it is least, [`covariance`] and [`fitted`] what follows, [`select`](mod@select) which terms, [`bound`], [`azimuth`] and
//! [`forward`] what else may be asked, [`verdict`] what to say, [`watch`] to whom.

pub mod azimuth;
pub mod bound;
pub mod campaign;
pub mod choice;
pub mod compared;
pub mod covariance;
pub mod error;
pub mod facing;
pub mod fitted;
pub mod forward;
pub mod joint;
pub mod layout;
pub mod loss;
pub mod optimum;
pub mod reference;
pub mod remarks;
pub mod scene;
pub mod select;
pub mod start;
pub mod verdict;
pub mod watch;
