//! Tests of what is computed from many bakes: data sheets, the best cell, studies.

mod datasheet;
mod optimise;
mod study;
