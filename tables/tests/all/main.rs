//! Tests of the crate from outside, in one program, because linking HDF5 costs more than most of
//! them. `cargo test -p tables --test all merge` runs those of one file.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod bad;
mod file;
mod flips;
mod kept;
mod lookup;
mod merge;
mod python;
mod rewritten;
mod sample;
mod together;
