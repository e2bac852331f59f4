//! Tests of several rooms together: planted answers, closed forms, known photographs.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod azimuth;
mod baselines;
mod by_hand;
mod campaign;
mod captures_manifest;
mod carried;
mod channels;
#[cfg(feature = "images")]
mod coating;
mod correlation;
mod curves;
mod edge;
mod estimate;
#[cfg(feature = "report")]
#[cfg(all(feature = "images", feature = "report"))]
mod exif;
mod explore;
mod exponent;
mod export;
#[cfg(feature = "report")]
mod figures;
mod forward;
mod jpeg;
mod known;
mod lamps;
mod mirror;
mod noise;
mod nominal;
mod pages;
mod photo_formats;
pub(crate) mod photographs;
mod pixels;
mod placed;
pub(crate) mod planted;
mod prediction;
#[cfg(feature = "raw")]
mod raw;
#[cfg(feature = "images")]
mod render;
mod ripples;
mod sample;
mod simulate_campaign;
mod statistics;
mod study;
mod suspects;
mod transfers;
mod trusted;
mod wave;
