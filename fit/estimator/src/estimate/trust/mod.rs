//! How far an estimate can be trusted: its misfit and verdict, what may have caused the misfit, and
//! what no photograph can check.

pub(crate) mod doubts;
pub mod goodness;
pub(crate) mod mirror;
pub(crate) mod suspects;
pub(crate) mod unverified;
pub(crate) mod verdict;
