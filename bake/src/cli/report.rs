//! Reports of a bake and of a comparison, as text for a person and as JSON for a script.

use crate::run::{Baked, Between, Comparison};
use meshes::EdgeLengthFrom;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use tables::cli::in_a_line;
use tables::{Fate, Table};

/// Report of `bake trace`.
pub(crate) struct Trace<'a> {
    /// Table that was baked, and its time.
    pub baked: &'a Baked,
    /// File that holds the table.
    pub file: &'a Path,
    /// Error between directions, as far as it was tried.
    pub between: Option<Between>,
    /// Where the edge length comes from.
    pub edge_length_from: EdgeLengthFrom,
    /// Content of the file before, if it was another.
    pub replaced: Option<String>,
}

impl Trace<'_> {
    /// Returns the report as text: one line about the bake, then one line for each direction.
    pub(crate) fn text(&self) -> String {
        let Baked { table, seconds } = self.baked;
        let rays: u64 = table.rays.sum();
        let (incidences, azimuths) = table.axes.shape();
        let directions = incidences * azimuths;
        let mut text = format!(
            "{}: {directions} directions, method {}",
            self.file.display(),
            table.provenance.method
        );
        // Writing to a String cannot fail.
        let _ = if rays > 0 {
            let speed = rays as f64 / seconds / 1e6;
            writeln!(
                text,
                ", {rays} rays in {seconds:.3} s ({speed:.1} million rays/s)"
            )
        } else {
            writeln!(text, ", {seconds:.4} s")
        };
        let _ = writeln!(
            text,
            "edge length: {} ({}), the unit of c",
            self.length(),
            self.length_from()
        );
        if let Some(before) = &self.replaced {
            let _ = writeln!(text, "replaced: {before}");
        }
        if let Some(own) = self.between {
            let hint = match table.provenance.direction_tolerance {
                Some(_) => "",
                None => "; --direction-tolerance chooses directions",
            };
            let _ = writeln!(
                text,
                "between directions: off by up to {:.2e} (total variation; {} tried), most at \
                incidence {} deg, azimuth {} deg{hint}",
                own.error, own.tried, own.incidence_deg, own.azimuth_deg
            );
        }
        text.push_str(&directions_text(table));
        text
    }

    /// Returns the edge length with its unit.
    fn length(&self) -> String {
        let from = &self.baked.table.provenance;
        format!("{} {}", from.edge_length, in_a_line(&from.edge_length_unit))
    }

    /// Returns where the edge length comes from.
    const fn length_from(&self) -> &'static str {
        match self.edge_length_from {
            EdgeLengthFrom::User => "--edge-length",
            EdgeLengthFrom::File => "stated by the mesh",
            EdgeLengthFrom::Longest => "longest edge from the apex",
        }
    }

    /// Returns the report as JSON.
    pub(crate) fn json(&self) -> Value {
        let Baked { table, seconds } = self.baked;
        let rays: u64 = table.rays.sum();
        json!({
            "table": self.file.display().to_string(),
            "content_hash": table.content_hash(),
            "method": table.provenance.method.text(),
            "edge_length": table.provenance.edge_length,
            "edge_length_unit": table.provenance.edge_length_unit,
            "edge_length_from": self.length_from(),
            "replaced": self.replaced,
            "seconds": seconds,
            "rays": rays,
            "rays_per_second":
                if rays > 0 { json!(rays as f64 / seconds) } else { Value::Null },
            "between_directions_error": self.between.map(|own| json!({
                "total_variation": own.error,
                "incidence_deg": own.incidence_deg,
                "azimuth_deg": own.azimuth_deg,
                "tried": own.tried,
            })),
            "directions": directions_json(table),
        })
    }
}

/// Returns one line for each direction: angles, eta, its error, and the other fates that occur.
pub(crate) fn directions_text(table: &Table) -> String {
    let mut text = String::from("incidence  azimuth  retroreflected  std. error  other fates\n");
    let fates = table.fates();
    for ((i, a), &eta) in table.retroreflected.indexed_iter() {
        let azimuth = table.axes.azimuth_deg[a];
        let azimuth = if azimuth.is_nan() {
            "mean".into()
        } else {
            azimuth.to_string()
        };
        let others: Vec<String> = fates
            .iter()
            .filter(|&&fate| fate != Fate::Retroreflected)
            .map(|&fate| (fate.name(), table.fate[[i, a, fate as usize]]))
            .filter(|(_, share)| *share > 0.0)
            .map(|(name, share)| format!("{name} {share:.4}"))
            .collect();
        let error = table.standard_error[[i, a]];
        let incidence = table.axes.incidence_deg[i];
        let _ = writeln!(
            text,
            "{incidence:9}  {azimuth:>7}  {eta:14.6}  {error:10.1e}  {}",
            others.join(", ")
        );
    }
    text
}

/// Returns the directions of a table as a JSON array: angles, eta, error, rays, deviation, fates.
pub(crate) fn directions_json(table: &Table) -> Value {
    let (deviations, azimuths) = (table.deviations.as_ref(), table.axes.azimuth_deg.len());
    let direction = |((i, a), &eta): ((usize, usize), &f64)| {
        let fates: serde_json::Map<String, Value> = table
            .fates()
            .iter()
            .map(|&fate| (fate.name().into(), json!(table.fate[[i, a, fate as usize]])))
            .collect();
        json!({
            "incidence_deg": table.axes.incidence_deg[i],
            // JSON has no NaN: null stands for the mean over all azimuths.
            "azimuth_deg": table.axes.azimuth_deg[a],
            "retroreflected": eta,
            "standard_error": table.standard_error[[i, a]],
            "rays": table.rays[[i, a]],
            "deviation": deviations.map(|found| {
                let spread = found.spread(i * azimuths + a);
                json!({
                    "rms_mrad": 1e3 * spread.rms_rad, "largest_mrad": 1e3 * spread.largest_rad
                })
            }),
            "fates": fates,
        })
    };
    table.retroreflected.indexed_iter().map(direction).collect()
}

/// Returns a comparison as text, one line for each direction.
pub(crate) fn comparison_text(comparison: &Comparison) -> String {
    let mut text = String::from(
        "incidence  azimuth  L1 distance  counting noise  largest bin  eta differs  in sigmas  \
        polygons  exits' L1  agrees\n",
    );
    for row in &comparison.rows {
        let azimuth = if row.azimuth_deg.is_nan() {
            "mean".into()
        } else {
            row.azimuth_deg.to_string()
        };
        let _ = writeln!(
            text,
            "{:9}  {azimuth:>7}  {:11.2e}  {:14.2e}  {:11.2e}  {:11.2e}  {:>9}  {:>8}  {:>9}  {}",
            row.incidence_deg,
            row.l1,
            row.noise,
            row.largest,
            row.eta,
            row.sigmas
                .map_or("-".into(), |sigmas| format!("{sigmas:.2}")),
            number(row.paths),
            number(row.exits.map(|gap| gap.l1)),
            if row.agrees() { "yes" } else { "no" }
        );
    }
    text
}

/// Returns a number that a direction may lack.
fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.2e}"))
}

/// Returns a comparison as one line of JSON.
pub(crate) fn comparison_json(comparison: &Comparison) -> String {
    let rows: Vec<Value> = comparison
        .rows
        .iter()
        .map(|row| {
            json!({
                "incidence_deg": row.incidence_deg, "azimuth_deg": row.azimuth_deg, "l1": row.l1,
                "counting_noise": row.noise, "largest_bin": row.largest,
                "eta_difference": row.eta, "sigmas": row.sigmas,
                "polygons": row.paths, "exits_l1": row.exits.map(|gap| gap.l1),
                "exits_limit": row.exits.map(|gap| gap.limit),
                "agrees": row.agrees(),
            })
        })
        .collect();
    format!(
        "{}\n",
        json!({ "agrees": comparison.agrees(), "directions": rows })
    )
}
