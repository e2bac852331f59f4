//! TODO

pub mod check;
pub mod cli;
pub mod element;
pub mod failure;
pub mod inspect;
pub mod progress;
pub mod report;
pub mod study;
pub mod trace;
