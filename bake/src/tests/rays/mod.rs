//! Tests of the ways in which rays are traced, one against the other.

mod batches;
mod bounces;
mod index;
mod kernels;
mod leaks;
mod ten_million;
