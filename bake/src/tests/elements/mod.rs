//! Optical elements that are no corner cubes, against their closed forms.

pub(crate) mod bead;
pub(crate) mod plate;
