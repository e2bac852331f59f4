//! End-to-end tests of both programs and of the whole project.
//!
//! All of them are in one test program, so that the crates are linked only once.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

mod bad_inputs;
mod boundaries;
mod campaigns;
mod caps;
mod channels;
mod corpus;
mod determinism;
mod deviations;
mod edges;
mod elements;
mod expected_table;
mod explore;
mod forged;
mod forward;
mod front;
mod help;
mod hostile;
mod kills;
mod lean;
mod links;
mod many_edges;
mod pages;
mod pictures;
mod predict;
mod python;
mod reader;
mod report_page;
mod rough;
mod sheets;
mod streams;
mod together;
mod wave;
