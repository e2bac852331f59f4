//! The program `airr-reader`: opens a ray-shift table for `bake`, `fit` and whoever else reads one.
//!
//! The HDF5 library trusts a file, and tables come from strangers. So the library gets a process
//! that can do nothing but compute: [`tables::apart`] starts it with the file as its standard
//! input, an empty environment and a pipe for the answer. Before a byte is read the process limits
//! its memory and time by the length of the file, gives up all files (Landlock) and all calls to
//! the system but a few (seccomp). What a system lacks is told in the answer.
//!
//! `airr-reader --try` shows what a confined process may not do, one line a try.

#![deny(unsafe_code)]
#![warn(unreachable_pub)]

#[cfg(target_os = "linux")]
mod calls;
mod confine;
#[cfg(target_os = "linux")]
mod files;
mod program;
mod tries;

pub use program::run;
