//! Tests of the crate from outside, in one program. `cargo test -p meshes --test all normals` runs
//! those of one file.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod cells;
mod damaged;
mod designs;
mod digits;
mod elements;
mod files;
mod large;
mod normals;
mod options;
mod placement;
mod prisms;
