//! Tests of the inside of the crate. Every fast path is compared with a slow one that is plain, and
//! all paths with closed forms.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod answers;
mod azimuth;
mod bakes;
mod cells;
mod closed_form;
mod curved;
mod determinism;
mod deviations;
mod elements;
mod exact;
mod hard_cases;
mod ranks;
mod rays;
mod roughness;
mod trapped;
