//! Rows of many photographs: CSV, and JSON.

use serde::Serialize;
use tables::cli as terminal;

use crate::cli::mtf::report::{Frequency, Report, Request};

/// A photograph that was measured, or the reason why it was refused.
#[derive(Serialize)]
#[serde(untagged)]
pub(crate) enum Entry {
    /// Measurement of the photograph. It is boxed because a refusal is small.
    Measured(Box<Report>),
    /// A photograph that could not be measured.
    Refused {
        /// File of the photograph.
        image: String,
        /// Reason, with the remedy.
        error: String,
    },
}

impl Entry {
    /// Returns the report, or `None` for a refused photograph.
    pub(crate) fn report(&self) -> Option<&Report> {
        match self {
            Entry::Measured(report) => Some(report),
            Entry::Refused { .. } => None,
        }
    }
}

/// All photographs, as one JSON object.
#[derive(Serialize)]
pub(crate) struct Photographs<'a> {
    /// In the order in which they were named.
    pub photographs: &'a [Entry],
}

/// Returns CSV with one row per photograph, in their order. Fields are quoted as in RFC 4180.
pub(crate) fn csv(entries: &[Entry], request: &Request) -> String {
    let mut text = line(&columns(request));
    for entry in entries {
        text += &line(&row(entry, request));
    }
    text
}

fn columns(request: &Request) -> Vec<String> {
    let mut names = vec!["image".to_owned()];
    for level in ["mtf50", "mtf10"] {
        let mut units = vec!["cycles_per_pixel"];
        if request.pitch_mm.is_some() {
            units.push("per_mm");
        }
        for unit in units {
            names.push(format!("{level}_{unit}"));
            names.push(format!("{level}_{unit}_standard_error"));
        }
    }
    let unit = if request.pitch_mm.is_some() {
        "per_mm"
    } else {
        "cycles_per_pixel"
    };
    for at in &request.at {
        names.push(format!("mtf_at_{at}_{unit}"));
        names.push(format!("mtf_at_{at}_{unit}_standard_error"));
    }
    let rest = [
        "edge_angle_deg",
        "edge_tilt_deg",
        "edge_bow_px",
        "edge_order",
        "contrast",
        "signal_to_noise",
        "warnings",
        "error",
    ];
    names.extend(rest.map(str::to_owned));
    names
}

fn row(entry: &Entry, request: &Request) -> Vec<String> {
    let report = match entry {
        Entry::Measured(report) => report,
        Entry::Refused { image, error } => {
            let mut fields = vec![String::new(); columns(request).len()];
            let last = fields.len() - 1;
            (fields[0], fields[last]) = (image.clone(), error.clone());
            return fields;
        }
    };
    let mut fields = vec![report.image.clone()];
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.6}"));
    for level in report.levels {
        let of = |part: fn(Frequency) -> Option<f64>| number(level.and_then(part));
        fields.push(of(|level| Some(level.cycles_per_pixel)));
        fields.push(of(|level| Some(level.cycles_per_pixel_standard_error)));
        if request.pitch_mm.is_some() {
            fields.push(of(|level| level.per_mm));
            fields.push(of(|level| level.per_mm_standard_error));
        }
    }
    for at in &report.at {
        fields.push(number(Some(at.mtf)));
        fields.push(number(Some(at.standard_error)));
    }
    fields.extend([
        format!("{:.4}", report.edge_angle_deg),
        format!("{:.4}", report.edge_tilt_deg),
        format!("{:.3}", report.edge_bow_px),
        report.edge_order.to_string(),
        format!("{:.6}", report.contrast),
        format!("{:.1}", report.signal_to_noise),
        report.warnings.join("; "),
        String::new(),
    ]);
    fields
}

/// Joins fields to a line. A field with a comma or a quotation mark is quoted, and its quotation
/// marks are doubled. A line break, in the name of a file, is written as an escape.
fn line(fields: &[String]) -> String {
    let quoted = |field: &String| {
        let field = terminal::in_a_line(field);
        if field.contains([',', '"']) {
            format!("\"{}\"", field.replace('"', "\"\""))
        } else {
            field.into_owned()
        }
    };
    let fields: Vec<String> = fields.iter().map(quoted).collect();
    fields.join(",") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of RFC 4180, section 2, rules 5 to 7, but for line breaks.
    #[test]
    fn fields_are_quoted_where_they_must_be() {
        let fields = ["aaa", "b,bb", "c\"c", "d\nd", "", " e "].map(str::to_owned);
        assert_eq!(line(&fields), "aaa,\"b,bb\",\"c\"\"c\",d\\nd,, e \n");
    }
}
