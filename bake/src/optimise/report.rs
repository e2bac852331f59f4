//! The answer as text for a person, as JSON for a script, and the front as a picture.

use crate::optimise::answer::{Answer, Check, Fate, Loss, Winner};
use crate::optimise::candidate::Candidate;
use crate::optimise::goal::{Best, Goal, Parameter};
use charts::{Axis, Curve, Dash, Facet, Figure, HUES, Marks, Stroke};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// Lines of a front that are printed; all are in the JSON.
const MOST_LINES: usize = 9;

impl Candidate {
    /// Returns the parameters that the design has.
    fn own(&self) -> impl Iterator<Item = (Parameter, f64)> {
        let all = Parameter::ALL.into_iter().zip(self.values);
        let shape = self.shape;
        all.filter(move |(parameter, _)| parameter.is_of(shape))
    }

    /// Returns the design and its parameters in words, without errors of 0.
    pub(crate) fn words(&self) -> String {
        let mut words = self.shape.name().to_owned();
        for (parameter, value) in self.own() {
            if matches!(parameter, Parameter::Error(_) | Parameter::Truncation) && value == 0.0 {
                continue;
            }
            // Writing to a String cannot fail.
            let _ = write!(words, ", {} {value:.4}", parameter.name());
        }
        words
    }

    /// Returns design and parameters as JSON.
    fn json(&self) -> Value {
        let mut all = json!({ "design": self.shape.name() });
        for (parameter, value) in self.own() {
            all[parameter.name()] = json!(value);
        }
        all
    }
}

impl Fate {
    /// Says what became of the design: its cells on the front, or how good they are at best.
    fn words(&self, best: Best) -> String {
        let name = self.shape.name();
        let names: &[&str] = match best {
            Best::Mtf => &["MTF"],
            Best::Luminance => &["luminance"],
            Best::Both => &["MTF", "luminance"],
        };
        let cells = match self.on_front {
            1 => "1 cell".into(),
            count => format!("{count} cells"),
        };
        match &self.best {
            _ if self.on_front > 0 => format!("{name}: {cells} on the front"),
            None => format!(
                "{name}: not on the front, none was found that keeps the frequencies visible"
            ),
            Some(values) => {
                let values = names.iter().zip(values);
                let values: Vec<String> = values
                    .map(|(name, value)| format!("{name} {value:.4}"))
                    .collect();
                let values = values.join(" or ");
                format!("{name}: not on the front, reaches {values}")
            }
        }
    }
}

/// Returns the answer as text; `seconds` is the time of the search.
pub(crate) fn text(goal: &Goal, answer: &Answer, file: &str, seconds: f64) -> String {
    let Winner { cell, quality } = &answer.front[answer.best];
    let mut out = format!(
        "{file}: {}\n  MTF {:.4}, luminance {:.4}, lowest MTF {:.4}\n{} cells in {seconds:.1} s\n",
        cell.words(),
        quality.mtf,
        quality.luminance,
        quality.least,
        answer.tried
    );
    if let Some(advice) = answer.advice() {
        let _ = writeln!(out, "{advice}");
    }
    if goal.shapes.len() > 1 {
        let fates = answer.fates.iter().map(|fate| fate.words(goal.best));
        fates.for_each(|words| out.push_str(&format!("{words}\n")));
    }
    let count = answer.front.len();
    if count > 1 {
        let lines = count.min(MOST_LINES);
        let some = if lines < count {
            format!(", {lines} of them shown (--json has all)")
        } else {
            String::new()
        };
        let _ = writeln!(
            out,
            "\nfront of {count} cells{some}\n   MTF  luminance  cell"
        );
        let places = (0..lines).map(|k| k * (count - 1) / (lines - 1));
        for own in places.map(|place| &answer.front[place]) {
            let (mtf, luminance) = (own.quality.mtf, own.quality.luminance);
            let _ = writeln!(out, "{mtf:.4}     {luminance:.4}  {}", own.cell.words());
        }
    }
    let _ = writeln!(
        out,
        "\n{:36} change of MTF  of luminance",
        "error of the written cell"
    );
    for own in &answer.losses {
        let what = format!("{} by {:.5}", own.what, own.step);
        let _ = writeln!(out, "{what:36} {:13.4}  {:12.4}", own.mtf, own.luminance);
    }
    out.push_str("\ntraced again by rays\n");
    for own in &answer.checks {
        let verdict = if own.agrees { "agrees" } else { "differs" };
        let [incidence, azimuth] = own.direction_deg;
        let _ = writeln!(
            out,
            "  incidence {incidence}, azimuth {azimuth}: eta {:.4} \u{b1} {:.4}, exact {:.4}: \
             {verdict}",
            own.by_rays, own.standard_error, own.eta
        );
    }
    let page = Path::new(file).with_extension("html");
    let _ = writeln!(
        out,
        "\nsee more: bake datasheet {file} -o {} --refractive-index {:.4} --unit mm{}",
        page.display(),
        cell.value(Parameter::Index),
        seen(goal)
    );
    out
}

/// Returns the options by which a data sheet looks from the first view of a goal, with at most four
/// incidences.
fn seen(goal: &Goal) -> String {
    let Some(first) = goal.aims.first() else {
        return String::new();
    };
    let mut incidences: Vec<f64> = goal.aims.iter().map(|aim| aim.direction_deg[0]).collect();
    incidences.sort_by(f64::total_cmp);
    incidences.dedup();
    let list: Vec<String> = incidences.iter().take(4).map(f64::to_string).collect();
    let distance = first
        .distances
        .first()
        .map_or(String::new(), |(mm, _)| format!(" --distance {mm}"));
    format!(
        "{distance} --incidence {} --azimuth {}",
        list.join(","),
        first.direction_deg[1]
    )
}

/// Returns the answer as JSON; `seconds` is the time of the search.
pub(crate) fn json(answer: &Answer, file: &str, seconds: f64) -> Value {
    let winner = |own: &Winner| {
        let quality = &own.quality;
        json!({
            "cell": own.cell.json(), "mtf": quality.mtf, "luminance": quality.luminance,
            "lowest_mtf": quality.least,
        })
    };
    let check = |own: &Check| {
        json!({
            "incidence_deg": own.direction_deg[0], "azimuth_deg": own.direction_deg[1],
            "eta": own.eta, "eta_by_rays": own.by_rays, "standard_error": own.standard_error,
            "agrees": own.agrees,
        })
    };
    let loss = |own: &Loss| {
        json!({
            "parameter": own.what, "step": own.step, "mtf": own.mtf, "luminance": own.luminance,
        })
    };
    let fate = |own: &Fate| json!({ "design": own.shape.name(), "on_front": own.on_front, "best": own.best });
    json!({
        "mesh": file,
        "best": winner(&answer.front[answer.best]),
        "front": answer.front.iter().map(winner).collect::<Vec<_>>(),
        "advice": answer.advice(),
        "designs": answer.fates.iter().map(fate).collect::<Vec<_>>(),
        "cells": answer.tried,
        "seconds": seconds,
        "sensitivity": answer.losses.iter().map(loss).collect::<Vec<_>>(),
        "by_rays": answer.checks.iter().map(check).collect::<Vec<_>>(),
    })
}

/// Draws the front, one colour for each design, with the best cell.
pub(crate) fn picture(goal: &Goal, answer: &Answer) -> String {
    let point = |own: &Winner| [own.quality.luminance, own.quality.mtf];
    let of_shape = |(k, &shape): (usize, &meshes::design::Shape)| {
        let own = answer.front.iter().filter(|own| own.cell.shape == shape);
        let stroke = Stroke::solid(HUES[k]);
        Curve::new(shape.name(), stroke, Marks::Dots, own.map(point))
    };
    let mut curves: Vec<Curve> = goal.shapes.iter().enumerate().map(of_shape).collect();
    curves.retain(|curve| !curve.points.is_empty());
    let axes = [0, 1].map(|k| Axis::around(answer.front.iter().map(|own| point(own)[k])));
    let [x, y] = point(&answer.front[answer.best]);
    let [across, up] = [axes[0].ends(), axes[1].ends()];
    let lines = [
        ("written cell", up.map(|y| [x, y])),
        ("", across.map(|x| [x, y])),
    ];
    curves.extend(lines.map(|(name, ends)| Curve::limit(name, Dash::Dotted, ends)));
    let names = [
        "luminance: eta, mean over the views",
        "MTF, mean over views and frequencies",
    ];
    let frequencies: Vec<String> = goal.frequencies.iter().map(f64::to_string).collect();
    let figure = Figure {
        note: format!(
            "MTF at {} /mm, {} nm",
            frequencies.join(", "),
            goal.wavelength_nm
        ),
        ..Figure::new(
            "Best cells: sharper or brighter",
            vec![Facet::new("", axes, names, curves)],
            1,
        )
    };
    figure.svg()
}
