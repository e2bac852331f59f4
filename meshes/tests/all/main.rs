//! Tests of the crate from outside, in one program. `cargo test -p meshes --test all normals` runs those of one file.

mod damaged;
mod designs;
mod elements;
mod files;
mod large;
mod normals;
mod options;
mod placement;
mod prisms;
