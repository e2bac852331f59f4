//! Campaigns that gave no trial, grouped by the reason for which a photograph was refused.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use estimator::Error;

/// Campaigns refused for one reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Refused {
    /// Kind of the fault of the first photograph that was refused; see
    /// [`edges::photographs::edge::fault::Fault::kind`].
    pub reason: &'static str,
    /// Number of campaigns with this reason.
    pub campaigns: usize,
    /// Index of the first of these campaigns.
    pub first: usize,
    /// Message of the first of these campaigns, which names the photograph by its number (or the
    /// source) and its fault.
    pub message: String,
}

/// Splits the results of all campaigns, in order, into trials and refusals. The most frequent
/// reason comes first.
pub fn part<T>(all: impl IntoIterator<Item = Result<T, Error>>) -> (Vec<T>, Vec<Refused>) {
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
    // The sort is stable, so the order does not depend on the threads.
    refused.sort_by_key(|of| std::cmp::Reverse(of.campaigns));
    (trials, refused)
}

fn reason(error: &Error) -> &'static str {
    match error {
        Error::Edge(_, fault) => fault.kind(),
        Error::NothingLeft(_) => "nothing retroreflected",
        Error::Sharper { .. } => "sharper than the reference",
        Error::Captures(_) | Error::Direction { .. } => "no photograph",
        _ => "no estimate",
    }
}

/// Returns the number of campaigns that were refused for any reason.
pub(crate) fn total(refused: &[Refused]) -> usize {
    refused.iter().map(|of| of.campaigns).sum()
}

/// Returns one line for each reason, with the first campaign and its message.
pub fn examples(refused: &[Refused]) -> String {
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

/// Returns one line: the number of refused campaigns, in all and for each reason.
pub fn line(refused: &[Refused]) -> String {
    let mut text = format!("{} refused", total(refused));
    for (i, of) in refused.iter().enumerate() {
        let mark = if i == 0 { ": " } else { ", " };
        let _ = write!(text, "{mark}{} {}", of.campaigns, of.reason);
    }
    text
}
