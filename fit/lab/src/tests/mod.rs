//! Tests of several modules together.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod azimuth;
mod baselines;
mod by_hand;
mod cameras;
mod campaign;
mod carried;
mod channels;
mod correlation;
mod diagnosis;
mod direction;
mod edge;
mod effects;
mod estimate;
mod exponent;
mod forward;
mod further;
mod goodness;
mod known;
mod lamps;
mod legibility;
mod lens;
mod mirror;
mod nominal;
mod one_sided;
mod perturbed;
mod pixels;
mod plan;
mod prediction;
#[cfg(feature = "raw")]
mod raw;
mod sample;
mod selection;
mod simulate_campaign;
mod statistics;
mod study;
mod suspects;
mod unverified;
mod wave;
