//! Campaigns that came to nothing, by what their photographs were refused for.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use crate::estimate::Error;
use crate::estimate::scene;

/// Campaigns refused for one reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) struct Refused {
    /// The kind of what is wrong with the first photograph that was refused; see
    /// [`crate::photographs::edge::fault::Fault::kind`].
    pub reason: &'static str,
    /// How many.
    pub campaigns: usize,
    /// Number of the first.
    pub first: usize,
    /// What was said of it: its photograph by number, or the source, and what is wrong with it.
    pub message: String,
}

/// Parts what came of all campaigns, in order, into trials and refusals, the most frequent reason
/// first.
pub(crate) fn part<T>(all: impl IntoIterator<Item = Result<T, Error>>) -> (Vec<T>, Vec<Refused>) {
    let (mut trials, mut found) = (Vec::new(), BTreeMap::new());
    for (index, one) in all.into_iter().enumerate() {
        match one {
            Ok(trial) => trials.push(trial),
            Err(error) => {
                let reason = reason(&error);
                let of = found.entry(reason).or_insert_with(|| Refused {
                    reason,
                    campaigns: 0,
                    first: index,
                    message: error.to_string(),
                });
                of.campaigns += 1;
            }
        }
    }
    let mut refused: Vec<Refused> = found.into_values().collect();
    // A stable sort: the same order whatever the threads.
    refused.sort_by_key(|of| std::cmp::Reverse(of.campaigns));
    (trials, refused)
}

fn reason(error: &Error) -> &'static str {
    match error {
        Error::Scene(scene::Error::Edge { fault, .. }) => fault.kind(),
        Error::Scene(scene::Error::NothingLeft { .. }) => "nothing retroreflected",
        Error::Scene(_) => "no photograph",
        _ => "no estimate",
    }
}

/// How many were refused, whatever for.
pub(crate) fn total(refused: &[Refused]) -> usize {
    refused.iter().map(|of| of.campaigns).sum()
}

/// In words: how many, of what kind, and the first of every kind.
pub(crate) fn examples(refused: &[Refused]) -> String {
    let mut text = String::new();
    for of in refused {
        let _ = writeln!(
            text,
            "refused, {}: campaign {}, {}",
            of.reason, of.first, of.message
        );
    }
    text
}

/// One line: how many, and of what kind.
pub(crate) fn line(refused: &[Refused]) -> String {
    let mut text = format!("{} refused", total(refused));
    for (i, of) in refused.iter().enumerate() {
        let mark = if i == 0 { ": " } else { ", " };
        let _ = write!(text, "{mark}{} {}", of.campaigns, of.reason);
    }
    text
}
