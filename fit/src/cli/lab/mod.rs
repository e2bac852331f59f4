//! Verbs of `lab`: photographs of known truth, studies of how good estimates are, plans of campaigns.

pub(super) mod plan;
pub(super) mod simulate;
pub(super) mod study;
