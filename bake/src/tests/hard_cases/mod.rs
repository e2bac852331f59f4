//! Hard cases, with a number for each: what is documented happens, by rays and by the exact method,
//! and both agree.
//!
//! Every test prints its number (`cargo test -p bake --lib hard_cases -- --nocapture`) and asserts
//! it.

pub(crate) mod angles;
pub(crate) mod both;
pub(crate) mod counters;
pub(crate) mod facets;
pub(crate) mod leaks;
pub(crate) mod placement;
