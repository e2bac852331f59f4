//! Tests of several modules together.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod captures_manifest;
mod curves;
mod exif;
mod jpeg;
mod noise;
mod pages;
mod photo_formats;
pub(crate) mod photographs;
mod ripples;
mod transfers;
mod uneven;
