//! The command line of `fit`: arguments in, exit code out (0 done, 1 failed, 2 wrong usage).

use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use tables::cli as terminal;
use tables::cli::{Completions, Manual, version};

use crate::cli::failure::Failure;
#[cfg(feature = "full")]
use crate::cli::lab::{plan, simulate, study};
#[cfg(feature = "full")]
use crate::cli::pictures::{compare, explore, export, render};
use crate::cli::{estimate, mtf, predict};

/// Estimates diffraction spread a, corner size c and reflectance mu of a retroreflective sheet from
/// photographs of mid-air images, and predicts what the sheet shows elsewhere.
#[derive(Debug, Parser)]
#[command(
    name = "fit",
    version,
    arg_required_else_help = true,
    after_help = "\
`fit VERB --help` describes a verb and its options, and shows examples.
Words and formulas: fit/doc/model.md"
)]
struct Arguments {
    /// Verb that is run.
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Estimate(estimate::Arguments),
    #[cfg(feature = "full")]
    Export(export::Arguments),
    Mtf(mtf::Arguments),
    Predict(predict::Arguments),
    #[cfg(feature = "full")]
    Render(render::Arguments),
    #[cfg(feature = "full")]
    Explore(explore::Arguments),
    #[cfg(feature = "full")]
    Compare(compare::Arguments),
    /// Names the heir of a verb that is gone.
    #[command(hide = true)]
    Evaluate {
        /// Words of the former verb.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        words: Vec<std::ffi::OsString>,
    },
    #[cfg(feature = "full")]
    Plan(plan::Arguments),
    #[cfg(feature = "full")]
    Simulate(simulate::Arguments),
    #[cfg(feature = "full")]
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
/// `commit` names the commit that was built, if the build was told it; `--version` shows it.
pub fn main(commit: Option<&str>) -> ExitCode {
    tables::apart::start();
    let done = match arguments(commit).verb {
        Verb::Estimate(arguments) => estimate::run(&arguments),
        #[cfg(feature = "full")]
        Verb::Export(arguments) => export::run(&arguments),
        Verb::Mtf(arguments) => mtf::run(&arguments),
        Verb::Predict(arguments) => predict::run(&arguments),
        #[cfg(feature = "full")]
        Verb::Render(arguments) => render::run(&arguments),
        #[cfg(feature = "full")]
        Verb::Explore(arguments) => explore::run(&arguments),
        #[cfg(feature = "full")]
        Verb::Compare(arguments) => compare::run(&arguments),
        Verb::Evaluate { .. } => Err(Failure::Evaluate),
        #[cfg(feature = "full")]
        Verb::Plan(arguments) => plan::run(&arguments),
        #[cfg(feature = "full")]
        Verb::Simulate(arguments) => simulate::run(&arguments),
        #[cfg(feature = "full")]
        Verb::Study(arguments) => study::run(&arguments),
        Verb::Completions(arguments) => arguments.run(command()).map_err(Failure::from),
        Verb::Manual(arguments) => arguments.run(command()).map_err(Failure::from),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Usage(usage)) => usage.exit(),
        Err(failure) => {
            terminal::fail(&failure);
            ExitCode::from(failure.code())
        }
    }
}

/// Reads the command line of the process. Ends the program after `--help` and for wrong usage.
fn arguments(commit: Option<&str>) -> Arguments {
    let mut command = command().version(version(env!("CARGO_PKG_VERSION"), commit));
    let matches = command
        .try_get_matches_from_mut(std::env::args_os())
        .unwrap_or_else(|error| hinted(error).exit());
    Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command).exit())
}

/// Adds a hint to an error of a verb that lacks its result: a sheet may take its place.
fn hinted(mut error: clap::Error) -> clap::Error {
    let missing = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::Strings(missing)) => missing,
        _ => return error,
    };
    let result = |own: &String| own.starts_with("--params") || own.starts_with("<RESULT");
    let own_sheet = Arguments::command().get_subcommands().any(|verb| {
        let called = std::env::args().nth(1);
        called.as_deref() == Some(verb.get_name())
            && verb
                .get_arguments()
                .any(|argument| argument.get_id() == "sheet")
    });
    if error.kind() == ErrorKind::MissingRequiredArgument && own_sheet && missing.iter().any(result)
    {
        let hint = "without a fit, name a sheet in place of both, such as --sheet prism-0.1";
        let hint = ContextValue::StyledStrs(vec![hint.into()]);
        error.insert(ContextKind::Suggested, hint);
    }
    error
}

/// Returns the command line's description: all verbs and options of this build.
fn command() -> clap::Command {
    let command = Arguments::command();
    if cfg!(feature = "full") {
        return command;
    }
    let verbs: Vec<String> = command
        .get_subcommands()
        .map(|verb| verb.get_name().to_owned())
        .collect();
    verbs.into_iter().fold(command, |command, verb| {
        command.mut_subcommand(verb, |verb| {
            let Some(help) = verb.get_after_help().map(ToString::to_string) else {
                return verb;
            };
            verb.after_help(without_pictures(&help))
        })
    })
}

/// Returns `help` without the examples of `--plot` and `--report`, which need the feature `full`.
///
/// An example continues on the next line if its line ends with a backslash. It is left out whole.
fn without_pictures(help: &str) -> String {
    let mut kept: Vec<&str> = Vec::new();
    let mut example: Vec<&str> = Vec::new();
    for line in help.lines() {
        example.push(line);
        if !line.ends_with('\\') {
            let whole = std::mem::take(&mut example);
            let lacks = |line: &&str| line.contains(" --plot ") || line.contains(" --report ");
            if !whole.iter().any(lacks) {
                kept.extend(whole);
            }
        }
    }
    kept.join("\n")
}
