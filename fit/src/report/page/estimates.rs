//! The numbers: c, a and mu with 95 % intervals, or bounds.

use crate::estimate::Bound;
use crate::names::{ParameterId, ParameterKind};
use crate::result::{AtAngle, Number, Parameter};

use crate::report::page::chart::{Axis, Panel, svg};
use crate::report::page::markup::{Row, minus, rounded, significant, table};
use crate::report::page::shown::Page;

/// Half a 95 % interval, in standard errors of a normal distribution.
pub(crate) const INTERVAL: f64 = 1.959_964;

/// One parameter as the page shows it.
struct Shown<'a> {
    kind: ParameterKind,
    symbol: &'static str,
    meaning: &'static str,
    unit: &'static str,
    entries: Vec<Entry>,
    page: &'a Page<'a>,
}

/// One number of it.
struct Entry {
    incidence_deg: Option<f64>,
    number: Number,
    bound: Option<Bound>,
    truth: Option<f64>,
}

/// Symbol, meaning and unit of a parameter.
pub(crate) fn symbol(kind: ParameterKind) -> (&'static str, &'static str, &'static str) {
    match kind {
        ParameterKind::CornerSize => ("c", "corner size", "mm"),
        ParameterKind::ATimesR => ("a\u{a0}R", "diffraction spread times distance", ""),
        ParameterKind::Roughness => ("\u{3b1}", "roughness", ""),
        ParameterKind::Azimuth => ("\u{3c6}", "azimuth of the sheet", "\u{b0}"),
        ParameterKind::SurfaceRoughness => ("\u{3b1}\u{2080}", "roughness of the front", ""),
        ParameterKind::Mu => ("\u{b5}", "reflectance", ""),
        ParameterKind::APerMm => ("a", "diffraction spread", "1/mm"),
    }
}

fn shown<'a>(page: &'a Page, kind: ParameterKind, parameter: &Parameter) -> Shown<'a> {
    let entry = |incidence_deg: Option<f64>, number: Number| {
        let id = ParameterId {
            kind,
            incidence_deg,
        };
        Entry {
            incidence_deg,
            number,
            bound: page.result.bounds.get(&id).copied(),
            truth: page.truth.and_then(|truth| truth.of(id)),
        }
    };
    let (symbol, meaning, unit) = symbol(kind);
    let entries = match parameter {
        Parameter::Shared(number) => vec![entry(None, *number)],
        Parameter::PerAngle { per_angle } => per_angle
            .iter()
            .map(
                |&AtAngle {
                     incidence_deg,
                     value,
                     standard_error,
                 }| {
                    entry(
                        Some(incidence_deg),
                        Number {
                            value,
                            standard_error,
                        },
                    )
                },
            )
            .collect(),
    };
    Shown {
        kind,
        symbol,
        meaning,
        unit,
        entries,
        page,
    }
}

/// Cards, charts by angle, and the whole table.
pub(crate) fn section(page: &Page) -> String {
    let result = page.result;
    // A term that the model lacks may have a bound all the same.
    let absent = |kind: ParameterKind| {
        let nothing = Number {
            value: None,
            standard_error: None,
        };
        let bounded = result.bounds.contains_key(&kind.shared());
        bounded.then_some(Parameter::Shared(nothing))
    };
    let c = result.c_mm.map(Parameter::Shared);
    let c = c.or_else(|| absent(ParameterKind::CornerSize));
    let a = result
        .a_per_mm
        .clone()
        .or_else(|| absent(ParameterKind::APerMm));
    let front = result.surface_roughness.map(Parameter::Shared);
    let front = front.or_else(|| absent(ParameterKind::SurfaceRoughness));
    let azimuth = result.azimuth_deg.map(Parameter::Shared);
    let all: Vec<Shown> = [
        (ParameterKind::CornerSize, c.as_ref()),
        (ParameterKind::APerMm, a.as_ref()),
        (ParameterKind::ATimesR, result.a_times_r.as_ref()),
        (ParameterKind::Roughness, result.roughness.as_ref()),
        (ParameterKind::SurfaceRoughness, front.as_ref()),
        (ParameterKind::Mu, result.mu.as_ref()),
        (ParameterKind::Azimuth, azimuth.as_ref()),
    ]
    .into_iter()
    .filter_map(|(kind, parameter)| Some(shown(page, kind, parameter?)))
    .collect();
    let mut out = String::from("<dl class=\"cards\">\n");
    out.extend(all.iter().map(Shown::card));
    out.push_str("</dl>\n");
    let charts: String = all.iter().filter_map(Shown::by_angle).collect();
    if !charts.is_empty() {
        out.push_str(&format!("<div class=\"wide grid\">\n{charts}</div>\n"));
    }
    let mut head = vec!["", "incidence", "estimate", "std. error", "95 % interval"];
    if page.truth.is_some() {
        head.extend(["truth", "difference", "in std. errors"]);
    }
    let rows: Vec<Row> = all
        .iter()
        .flat_map(|shown| shown.entries.iter().map(|entry| shown.row(entry).into()))
        .collect();
    out.push_str(&table("All estimates", &head, &rows));
    if result.mu.is_none() {
        out.push_str("<p>\u{b5} is a ratio to the reference photograph, and there is none.</p>\n");
    }
    out
}

impl Entry {
    fn interval(&self) -> Option<[f64; 2]> {
        let (value, error) = (self.number.value?, self.number.standard_error?);
        Some([value - INTERVAL * error, value + INTERVAL * error])
    }

    /// What stands in place of the number: a bound, at 95 %.
    fn bounded(&self) -> String {
        match self.bound.map(|b| (b.at_least, b.at_most)) {
            Some((Some(least), Some(most))) => {
                format!(
                    "{} \u{2026} {}",
                    significant(least, 3),
                    significant(most, 3)
                )
            }
            Some((Some(least), _)) => format!("&gt; {}", significant(least, 3)),
            Some((_, Some(most))) => format!("&lt; {}", significant(most, 3)),
            _ => "not bounded".into(),
        }
    }
}

impl Shown<'_> {
    fn card(&self) -> String {
        let unit = if self.unit.is_empty() {
            String::new()
        } else {
            format!(" <small>{}</small>", self.unit)
        };
        let (value, note) = match &self.entries[..] {
            [one] => self.card_of_one(one),
            several => {
                let values: Vec<f64> = several.iter().filter_map(|e| e.number.value).collect();
                let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let range = match values.len() {
                    0 => "no value".into(),
                    1 => significant(low, 4),
                    _ => format!("{} \u{2013} {}", significant(low, 4), significant(high, 4)),
                };
                let mut note = format!("one for each of {} incidence angles", several.len());
                if values.len() < several.len() {
                    note.push_str(&format!(", {} only bounded", several.len() - values.len()));
                }
                (range, note)
            }
        };
        format!(
            "<div><dt><b>{}</b> {}</dt>\n<dd \
            class=\"value\">{value}{unit}</dd>\n<dd>{note}</dd></div>\n",
            self.symbol, self.meaning
        )
    }

    fn card_of_one(&self, one: &Entry) -> (String, String) {
        match (one.number.value, one.interval()) {
            (Some(value), Some([low, high])) => {
                let error = one.number.standard_error.unwrap_or(0.0);
                let mut note = format!("95 %: {} to {}", rounded(low, error), rounded(high, error));
                if let Some(truth) = one.truth {
                    note.push_str(&format!("<br/>truth {truth}"));
                }
                (rounded(value, error), note)
            }
            (Some(value), None) => (significant(value, 4), "no finite error".into()),
            (None, _) => (
                one.bounded(),
                "at 95 %: the photographs only bound it".into(),
            ),
        }
    }

    fn row(&self, entry: &Entry) -> Vec<String> {
        let error = entry.number.standard_error;
        let dash = || "\u{2013}".to_owned();
        let mut cells = vec![
            match self.unit {
                "" => self.symbol.to_owned(),
                unit => format!("{} <small>{unit}</small>", self.symbol),
            },
            entry
                .incidence_deg
                .map_or("all".to_owned(), |angle| format!("{angle}\u{b0}")),
            entry
                .number
                .value
                .map_or_else(|| entry.bounded(), |v| rounded(v, error.unwrap_or(0.0))),
            error.map_or_else(dash, |e| significant(e, 2)),
            entry.interval().map_or_else(dash, |[low, high]| {
                let error = error.unwrap_or(0.0);
                format!("{} \u{2026} {}", rounded(low, error), rounded(high, error))
            }),
        ];
        if self.page.truth.is_some() {
            let compared = entry.truth.zip(entry.number.value);
            cells.push(
                entry
                    .truth
                    .map_or_else(dash, |truth| minus(format!("{truth}"))),
            );
            cells.push(compared.map_or_else(dash, |(truth, value)| {
                minus(format!("{:+.3} %", 100.0 * (value / truth - 1.0)))
            }));
            cells.push(
                compared
                    .zip(error)
                    .map_or_else(dash, |((truth, value), error)| {
                        minus(format!("{:+.1}", (value - truth) / error))
                    }),
            );
        }
        cells
    }

    /// The parameter against incidence, where there is one per angle.
    fn by_angle(&self) -> Option<String> {
        let known = || {
            self.entries
                .iter()
                .filter_map(|e| Some((e.incidence_deg?, e.number.value?, e.interval()?)))
        };
        if known().count() < 2 {
            return None;
        }
        let planted: Vec<[f64; 2]> = self
            .entries
            .iter()
            .filter_map(|e| Some([e.incidence_deg?, e.truth?]))
            .collect();
        let values = known().flat_map(|(_, _, interval)| interval);
        let panel = Panel {
            x: Axis::around(known().map(|k| k.0)),
            y: Axis::around(values.chain(planted.iter().map(|p| p[1]))),
            frame: [52.0, 10.0, 300.0, 150.0],
        };
        let unit = if self.unit.is_empty() {
            String::new()
        } else {
            format!(" ({})", self.unit)
        };
        let body = [
            panel.grid(5, true),
            panel.names("incidence (\u{b0})", &format!("{}{unit}", self.symbol)),
            panel.dots("truth", &planted),
            panel.bars("error", &known().map(|k| (k.0, k.2)).collect::<Vec<_>>()),
            panel.dots(
                "measured big",
                &known().map(|k| [k.0, k.1]).collect::<Vec<_>>(),
            ),
        ]
        .concat();
        let legend = if planted.is_empty() {
            ""
        } else {
            "; rings are the truth"
        };
        let picture = svg(
            [360.0, 196.0],
            &format!(
                "{} ({}) against incidence; the values are in the table below",
                self.symbol,
                self.kind.name()
            ),
            &body,
        );
        Some(format!(
            "<figure>{picture}<figcaption><b>{}</b> {} by incidence, with 95 % \
            intervals{legend}</figcaption></figure>\n",
            self.symbol, self.meaning
        ))
    }
}
