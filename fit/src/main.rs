//! The `fit` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    fit::cli::main(option_env!("AIRR_COMMIT"))
}
