//! Hard cases, a number for each: what is documented to happen does, by rays and exactly, and both agree.
//!
//! Every test prints its number (`cargo test -p bake --test hard_cases -- --nocapture`) and asserts it.

mod angles;
mod both;
#[path = "../cells/mod.rs"]
mod cells;
mod counters;
mod facets;
mod leaks;
mod placement;
