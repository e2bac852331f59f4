//! The `fit` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    fit::cli::verbs::main()
}
