//! The command line of `fit`: arguments in, exit code out (0 done, 1 failed, 2 wrong usage).

use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use tables::cli::{Completions, Manual, version};

use crate::cli::failure::Failure;
use crate::cli::{estimate, export, mtf, predict, simulate, study};
#[cfg(feature = "images")]
use crate::cli::{evaluate, render};

/// Estimates diffraction spread a, corner size c and reflectance mu of a retroreflective sheet from
/// photographs of mid-air images, and predicts what the sheet shows elsewhere.
#[derive(Debug, Parser)]
#[command(name = "fit", version, arg_required_else_help = true)]
struct Arguments {
    /// What to do.
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Estimate(estimate::Arguments),
    Export(export::Arguments),
    Mtf(mtf::Arguments),
    Predict(predict::Arguments),
    #[cfg(feature = "images")]
    Render(render::Arguments),
    #[cfg(feature = "images")]
    Evaluate(evaluate::Arguments),
    Simulate(simulate::Arguments),
    Study(study::Arguments),
    #[command(after_help = "Example: for the shell that is open\n  fit completions bash")]
    Completions(Completions),
    #[command(
        after_help = "Example: read them with man -l pages/fit-estimate.1\n  fit manual pages"
    )]
    Manual(Manual),
}

/// Runs the program on the arguments of the process.
///
/// `commit` names the commit that was built, where the build was told; `--version` shows it.
pub fn main(commit: Option<&str>) -> ExitCode {
    tables::apart::serve();
    let done = match arguments(commit).verb {
        Verb::Estimate(arguments) => estimate::run(&arguments),
        Verb::Export(arguments) => export::run(&arguments),
        Verb::Mtf(arguments) => mtf::run(&arguments),
        Verb::Predict(arguments) => predict::run(&arguments),
        #[cfg(feature = "images")]
        Verb::Render(arguments) => render::run(&arguments),
        #[cfg(feature = "images")]
        Verb::Evaluate(arguments) => evaluate::run(&arguments),
        Verb::Simulate(arguments) => simulate::run(&arguments),
        Verb::Study(arguments) => study::run(&arguments),
        Verb::Completions(arguments) => arguments.run(command()).map_err(Failure::from),
        Verb::Manual(arguments) => arguments.run(command()).map_err(Failure::from),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let _ = writeln!(std::io::stderr(), "error: {failure}");
            ExitCode::from(failure.code())
        }
    }
}

/// The command line as it was given; ends the program for `--help` and wrong usage.
fn arguments(commit: Option<&str>) -> Arguments {
    let mut command = command().version(version(env!("CARGO_PKG_VERSION"), commit));
    let matches = command.get_matches_mut();
    Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command).exit())
}

/// All verbs and options of this build.
fn command() -> clap::Command {
    let command = Arguments::command();
    if cfg!(feature = "report") {
        return command;
    }
    // Examples of options that this build lacks.
    let lacks = |line: &&str| line.contains(" --plot ") || line.contains(" --report ");
    let verbs: Vec<String> = command
        .get_subcommands()
        .map(|verb| verb.get_name().to_owned())
        .collect();
    verbs.into_iter().fold(command, |command, verb| {
        command.mut_subcommand(verb, |verb| {
            let Some(help) = verb.get_after_help().map(ToString::to_string) else {
                return verb;
            };
            let kept: Vec<&str> = help.lines().filter(|line| !lacks(line)).collect();
            verb.after_help(kept.join("\n"))
        })
    })
}
