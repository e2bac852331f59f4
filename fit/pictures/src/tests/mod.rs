//! Tests of several modules together.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod coating;
mod explore;
mod export;
mod figures;
mod render;
