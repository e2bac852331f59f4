//! Elements that are no corner cubes, against their closed forms.

mod bead;
mod plate;
