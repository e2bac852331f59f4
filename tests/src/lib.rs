//! What the end-to-end tests share: the two programs as processes, the files of this folder,
//! results and truths.

#![forbid(unsafe_code)]

pub mod browser;
pub mod estimate;
pub mod files;
pub mod page;
pub mod program;
pub mod rooms;
pub mod words;
