//! Program `bake`: traces corner-cube retroreflector cells into ray-shift tables.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    bake::cli::main(std::env::args_os(), option_env!("AIRR_COMMIT"))
}
