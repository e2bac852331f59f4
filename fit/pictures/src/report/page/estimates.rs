//! Section of the page with the numbers: c, a and mu with 95 % intervals, or bounds.

use edges::names::{ParameterId, ParameterKind};
use estimator::estimate::Bound;
use estimator::result::{Number, OwnBlur, Parameter};

use crate::report::page::markup::{Row, rounded, significant, table};
use crate::report::page::shown::Page;
use charts::{Axis, Panel, minus, svg};

/// Half width of a 95 % interval of a normal distribution, standard errors.
pub(crate) const INTERVAL: f64 = 1.959_964;

/// Parameter as the page shows it.
struct Shown<'a> {
    kind: ParameterKind,
    symbol: &'static str,
    meaning: &'static str,
    unit: &'static str,
    entries: Vec<Entry>,
    page: &'a Page<'a>,
}

/// One number of a parameter.
struct Entry {
    id: ParameterId,
    number: Number,
    bound: Option<Bound>,
    truth: Option<f64>,
}

/// Returns symbol, meaning and unit of a parameter.
pub(crate) fn symbol(kind: ParameterKind) -> (&'static str, &'static str, &'static str) {
    match kind {
        ParameterKind::CornerSize => ("c", "corner size", "mm"),
        ParameterKind::ATimesR => ("a\u{a0}R", "diffraction spread times distance", ""),
        ParameterKind::Roughness => ("\u{3b1}", "roughness", ""),
        ParameterKind::Azimuth => ("\u{3c6}", "azimuth of the sheet", "\u{b0}"),
        ParameterKind::SurfaceRoughness => ("\u{3b1}\u{2080}", "roughness of the front", ""),
        ParameterKind::OwnBlur => ("w", "blur that the reference does not have", "px"),
        ParameterKind::AngularSpread => ("\u{3c3}", "angular spread", "mrad"),
        ParameterKind::DihedralError1 => ("\u{3b5}\u{2081}", "dihedral error at edge 1", "mrad"),
        ParameterKind::DihedralError2 => ("\u{3b5}\u{2082}", "dihedral error at edge 2", "mrad"),
        ParameterKind::DihedralError3 => ("\u{3b5}\u{2083}", "dihedral error at edge 3", "mrad"),
        ParameterKind::Mu => ("\u{b5}", "reflectance", ""),
        ParameterKind::APerMm => ("a", "diffraction spread", "1/mm"),
    }
}

/// Explains a parameter in one or two sentences.
fn explained(kind: ParameterKind) -> &'static str {
    match kind {
        ParameterKind::CornerSize => {
            "c is the edge of one corner cube, measured from its innermost corner. A larger c \
             means a larger ray shift (the small step to the side of each returned ray) and more \
             blur."
        }
        ParameterKind::APerMm => {
            "a says how narrow the spot is into which diffraction spreads the light. A larger a \
             means less blur."
        }
        ParameterKind::ATimesR => {
            "a R is the diffraction spread a times the distance R from the sheet to the image. It \
             says how narrow the angle is into which diffraction spreads the light. A larger a R \
             means less blur."
        }
        ParameterKind::Roughness => {
            "\u{3b1} is the roughness of the facets. A larger \u{3b1} means more blur."
        }
        ParameterKind::SurfaceRoughness => {
            "\u{3b1}\u{2080} is the roughness of the front face. A larger \u{3b1}\u{2080} means \
             more blur."
        }
        ParameterKind::OwnBlur => {
            "w is a blur of the mid-air photographs that the reference does not have: focus or \
             vibration. It is negative if the reference is less sharp."
        }
        ParameterKind::AngularSpread => {
            "\u{3c3} is the spread of the direction of the returned light (standard deviation, \
             across the plane of incidence). Cubes whose angles differ from cell to cell cause it."
        }
        ParameterKind::DihedralError1
        | ParameterKind::DihedralError2
        | ParameterKind::DihedralError3 => {
            "\u{3b5} is the error of the angle between the two facets at an edge, which all cubes \
             share. Positive errors make the angle wider than 90 degrees. Photographs of edges in \
             one direction tell only a combination of the three errors."
        }
        ParameterKind::Mu => {
            "\u{b5} (mu) is the returned light, divided by the light that the model expects \
             without further losses. A \u{b5} of 1 means that there are no such losses."
        }
        ParameterKind::Azimuth => {
            "\u{3c6} is the angle by which the sheet was turned about its normal, beyond the \
             azimuths of the photographs."
        }
    }
}

/// Collects the numbers of a parameter with their bounds and truths.
fn shown<'a>(page: &'a Page, kind: ParameterKind, numbers: &[(ParameterId, Number)]) -> Shown<'a> {
    let entry = |&(id, number): &(ParameterId, Number)| Entry {
        id,
        number,
        bound: page.result.bounds.get(&id).copied(),
        truth: page.truth.and_then(|truth| truth.of(id)),
    };
    let (symbol, meaning, unit) = symbol(kind);
    Shown {
        kind,
        symbol,
        meaning,
        unit,
        entries: numbers.iter().map(entry).collect(),
        page,
    }
}

/// Collects all parameters of a page.
fn collected<'a>(page: &'a Page) -> Vec<Shown<'a>> {
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
    let blurs = result.own_blur_px.as_ref();
    let blurs = blurs.map_or(Vec::new(), OwnBlur::numbers);
    let angular = result.angular_spread_mrad.map(Parameter::Shared);
    let angular = angular.or_else(|| absent(ParameterKind::AngularSpread));
    let errors = result.dihedral_errors();
    [
        (ParameterKind::CornerSize, c.as_ref()),
        (ParameterKind::APerMm, a.as_ref()),
        (ParameterKind::ATimesR, result.a_times_r.as_ref()),
        (ParameterKind::Roughness, result.roughness.as_ref()),
        (ParameterKind::SurfaceRoughness, front.as_ref()),
        (ParameterKind::OwnBlur, None),
        (ParameterKind::AngularSpread, angular.as_ref()),
        (ParameterKind::DihedralError1, errors[0].as_ref()),
        (ParameterKind::DihedralError2, errors[1].as_ref()),
        (ParameterKind::DihedralError3, errors[2].as_ref()),
        (ParameterKind::Mu, result.mu.as_ref()),
        (ParameterKind::Azimuth, azimuth.as_ref()),
    ]
    .into_iter()
    .map(|(kind, parameter)| match parameter {
        Some(parameter) => shown(page, kind, &parameter.numbers(kind)),
        None if kind == ParameterKind::OwnBlur => shown(page, kind, &blurs),
        None => shown(page, kind, &[]),
    })
    .filter(|shown| !shown.entries.is_empty())
    .collect()
}

/// Writes the numbers of the first screen: each with its standard error, without words.
pub(crate) fn brief(page: &Page) -> String {
    let all = collected(page);
    // A spread that nothing asks for is no number of the sheet.
    let spread = page.result.angular_spread_mrad.is_some();
    let cards = all.iter().filter(|shown| match shown.kind {
        ParameterKind::Azimuth => false,
        ParameterKind::AngularSpread => spread,
        _ => true,
    });
    let cards: String = cards.map(Shown::brief).collect();
    format!("<dl class=\"brief cards\">\n{cards}</dl>\n")
}

/// Writes cards, charts by angle, and a table of all numbers.
pub(crate) fn section(page: &Page) -> String {
    let result = page.result;
    let all = collected(page);
    let mut out = String::from(
        "<p>The large number is the estimate. The 95 % interval says how sure it is: if the \
         photographs were repeated many times, 95 of 100 such intervals would hold the true \
         value. The standard error is the typical size of the random error.",
    );
    if !result.bounds.is_empty() {
        out.push_str(
            " A sign &lt; or &gt; marks a bound: the photographs say only that the value is \
             smaller or larger.",
        );
    }
    if page.truth.is_some() {
        out.push_str(" The truth is the known value from the file of <code>--truth</code>.");
    }
    out.push_str("</p>\n<dl class=\"cards\">\n");
    out.extend(all.iter().map(Shown::card));
    out.push_str("</dl>\n");
    let charts: String = all.iter().filter_map(Shown::by_angle).collect();
    if !charts.is_empty() {
        out.push_str(&format!("<div class=\"wide grid\">\n{charts}</div>\n"));
    }
    let mut head = vec![
        "",
        "incidence",
        "estimate",
        "standard error",
        "95 % interval",
    ];
    if page.truth.is_some() {
        head.extend(["truth", "difference", "in standard errors"]);
    }
    let rows: Vec<Row> = all
        .iter()
        .flat_map(|shown| shown.entries.iter().map(|entry| shown.row(entry).into()))
        .collect();
    out.push_str(&table("All estimates", &head, &rows));
    if result.mu.is_none() {
        out.push_str(
            "<p>There is no value for the reflectance \u{b5} (mu), because there is no reference \
             photograph. The reference photograph shows the source itself, without sheet and \
             half mirror.</p>\n",
        );
    }
    out
}

/// Writes the smallest and the largest value.
fn range(values: impl Iterator<Item = f64>, digits: usize) -> String {
    let empty = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.fold(empty, |(low, high), v| (low.min(v), high.max(v)));
    let (least, most) = (significant(low, digits), significant(high, digits));
    match low <= high {
        false => "no value".into(),
        true if least == most => least,
        true => format!("{least} \u{2013} {most}"),
    }
}

impl Entry {
    /// Returns the 95 % interval, or `None` without a value or an error.
    fn interval(&self) -> Option<[f64; 2]> {
        let (value, error) = (self.number.value?, self.number.standard_error?);
        Some([value - INTERVAL * error, value + INTERVAL * error])
    }

    /// Returns true if there is a bound at one side or at both.
    fn is_bounded(&self) -> bool {
        self.bound
            .is_some_and(|b| b.at_least.is_some() || b.at_most.is_some())
    }

    /// Writes the bound that stands in place of the number, at 95 %.
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
    /// Writes the card of a parameter.
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
                let range = range(values.iter().copied(), 4);
                let mut note = format!(
                    "from the smallest to the largest value at {} {}",
                    several.len(),
                    self.places()
                );
                if values.len() < several.len() {
                    note.push_str(&format!(
                        "; at {} of them there is only a bound",
                        several.len() - values.len()
                    ));
                }
                (range, note)
            }
        };
        format!(
            "<div><dt><b>{}</b> {}</dt>\n<dd class=\"value\">{value}{unit}</dd>\n\
             <dd>{note}</dd>\n<dd>{}</dd></div>\n",
            self.symbol,
            self.meaning,
            explained(self.kind)
        )
    }

    /// Returns what tells several numbers of the parameter apart.
    fn places(&self) -> &'static str {
        match self.kind {
            ParameterKind::OwnBlur => "distances",
            _ => "incidence angles",
        }
    }

    /// Writes the number of the first screen.
    fn brief(&self) -> String {
        let value = match &self.entries[..] {
            [one] => self.card_of_one(one).0,
            several => range(several.iter().filter_map(|entry| entry.number.value), 4),
        };
        let errors = self.entries.iter().filter_map(|e| e.number.standard_error);
        let note = match errors.clone().count() {
            0 => "no standard error".into(),
            1 => format!("standard error {}", range(errors, 2)),
            many => format!(
                "standard errors {} at {many} {}",
                range(errors, 2),
                self.places()
            ),
        };
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(" <small>{unit}</small>"),
        };
        format!(
            "<div><dt><b>{}</b> {}</dt>\n<dd class=\"value\">{value}{unit}</dd>\n\
             <dd>{note}</dd></div>\n",
            self.symbol, self.meaning
        )
    }

    /// Returns the number and the note of the card of a parameter that all angles share.
    fn card_of_one(&self, one: &Entry) -> (String, String) {
        match (one.number.value, one.interval()) {
            (Some(value), Some([low, high])) => {
                let error = one.number.standard_error.unwrap_or(0.0);
                let (low, high) = (rounded(low, error), rounded(high, error));
                let mut note = format!("95 % interval: {low} to {high}");
                if let Some(truth) = one.truth {
                    note.push_str(&format!("<br/>truth: {truth}"));
                }
                (rounded(value, error), note)
            }
            (Some(value), None) => (
                significant(value, 4),
                "The photographs give no standard error.".into(),
            ),
            (None, _) if one.is_bounded() => (
                one.bounded(),
                "The photographs give only this bound. 95 of 100 such bounds are right.".into(),
            ),
            (None, _) => (
                one.bounded(),
                "The photographs give no value and no bound.".into(),
            ),
        }
    }

    /// Writes the row of one number in the table.
    fn row(&self, entry: &Entry) -> Vec<String> {
        let error = entry.number.standard_error;
        let dash = || "\u{2013}".to_owned();
        let mut cells = vec![
            match self.unit {
                "" => self.symbol.to_owned(),
                unit => format!("{} <small>{unit}</small>", self.symbol),
            },
            entry.id.place().unwrap_or("all".to_owned()),
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

    /// Draws the parameter against the incidence, if it has at least two values.
    fn by_angle(&self) -> Option<String> {
        let known = || {
            self.entries
                .iter()
                .filter_map(|e| Some((e.id.at?, e.number.value?, e.interval()?)))
        };
        if known().count() < 2 || self.kind == ParameterKind::OwnBlur {
            return None;
        }
        let planted: Vec<[f64; 2]> = self
            .entries
            .iter()
            .filter_map(|e| Some([e.id.at?, e.truth?]))
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
            " Rings are the truth."
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
            "<figure>{picture}<figcaption><b>{}</b>, {}, at each incidence angle. The bars are \
             95 % intervals.{legend}</figcaption></figure>\n",
            self.symbol, self.meaning
        ))
    }
}
