//! The exact bake against closed forms, and its invariants on cells that have none.
//!
//! Run with `cargo test -p bake --test exact`.

mod arrays;
mod cells;
mod closed_form;
mod designs;
mod imperfect;
mod invariants;
mod losses;
mod sheets;
mod spots;
