//! Program `airr-reader`: opens a table for `bake` and `fit`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    reader::run(std::env::args_os().skip(1))
}
