//! The exact bake against closed forms, and its invariants on cells that have no closed form.
//!
//! Run with `cargo test -p bake --lib tests::exact`.

pub(crate) mod arrays;
pub(crate) mod cells;
pub(crate) mod closed_form;
pub(crate) mod designs;
pub(crate) mod imperfect;
pub(crate) mod invariants;
pub(crate) mod losses;
pub(crate) mod sheets;
pub(crate) mod spots;
pub(crate) mod waves;
