//! The project as a whole: help, pages, examples, Python, borders of crates.

mod boundaries;
mod help;
mod lean;
mod links;
mod pages;
mod python;
