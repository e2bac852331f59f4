//! Words of a verb that another program calls, and the reason why the verb refuses.

use std::ffi::OsString;

use clap::{Args, Parser};

/// Returns an error of the command line as one sentence, without the lines that only a terminal
/// needs.
///
/// ```
/// # use clap::{Arg, Command, value_parser};
/// let bins = Arg::new("bins").long("bins").value_parser(value_parser!(u8));
/// let program = Command::new("bake").arg(bins);
/// let error = program.try_get_matches_from(["bake", "--bins", "many"]).unwrap_err();
/// let sentence = tables::cli::sentence(&error);
/// assert_eq!(sentence, "invalid value 'many' for '--bins <bins>': invalid digit found in string");
/// ```
pub fn sentence(usage: &clap::Error) -> String {
    let text = usage.render().to_string();
    let lines = text.lines().map(str::trim);
    let told = lines.take_while(|line| {
        !line.starts_with("Usage:") && !line.starts_with("For more information")
    });
    let mut sentence = String::new();
    for line in told.filter(|line| !line.is_empty()) {
        let between = match sentence.chars().last() {
            None => "",
            Some(':') => " ",
            Some(_) => "; ",
        };
        sentence = sentence + between + line;
    }
    sentence
        .strip_prefix("error: ")
        .unwrap_or(&sentence)
        .to_owned()
}

/// Reason why a verb did not do its work for the program that called it.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// The caller stopped the work.
    #[error("stopped")]
    Stopped,
    /// One sentence with the file, the place and the remedy, as the program prints it.
    #[error("{0}")]
    Sentence(String),
}

impl From<clap::Error> for Refused {
    fn from(usage: clap::Error) -> Refused {
        Refused::Sentence(sentence(&usage))
    }
}

/// One verb as a command line.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct Words<A: Args> {
    #[command(flatten)]
    verb: A,
}

/// Reads the words of one verb, without the names of program and verb.
///
/// # Errors
/// Returns the error of clap for wrong usage.
pub fn parsed<A: Args>(words: &[OsString]) -> Result<A, clap::Error> {
    Ok(Words::<A>::try_parse_from(words)?.verb)
}
