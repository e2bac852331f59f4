//! `bake inspect`: prints the content of a table and draws it.

use crate::cli::report::{directions_json, directions_text};
use crate::error::Error;
use crate::plots::{exits, shifts};
use clap::Args;
use serde_json::json;
use std::fmt::{Display, Write};
use std::path::PathBuf;
use tables::cli::{in_a_line, print, reserve_plot};
use tables::deviation::Grid;
use tables::{Exact, Outputs, Provenance, Symmetry, Table};

/// Options of `bake inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// Table to read
    table: PathBuf,
    /// Plot of the shifts, .svg
    ///
    /// Exact tables show their polygons, tables of rays their bins. All panels have one scale. At
    /// most 24 directions are drawn, evenly spread; the plot says which part of all they are.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Plot of the exit directions of light, .svg
    ///
    /// For cells that are not ideal, so that light leaves off the way back.
    #[arg(long, value_name = "FILE")]
    plot_deviations: Option<PathBuf>,
    /// Prints the content as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs `bake inspect`: draws the plots that were asked for and prints the report.
pub(crate) fn run(args: &InspectArgs) -> Result<(), Error> {
    let mut outputs = Outputs::beside([args.table.as_path()]);
    let moved = reserve_plot(args.plot.as_deref(), &mut outputs)?;
    let spots = reserve_plot(args.plot_deviations.as_deref(), &mut outputs)?;
    let table = tables::read(&args.table)?;
    if let Some(output) = moved {
        output.commit(shifts(&table).as_bytes())?;
    }
    if let Some(output) = spots {
        let picture = exits(&table).ok_or_else(|| {
            Error::Failed(
                "--plot-deviations: nothing to plot, because the table records no light that \
                leaves in another direction than straight back; either its cells are ideal, or it \
                was baked with --deviations off"
                    .into(),
            )
        })?;
        output.commit(picture.as_bytes())?;
    }
    Ok(print(&if args.json {
        json(&table)
    } else {
        text(&table)
    })?)
}

/// Report of lines, each with a name and a value.
#[derive(Default)]
struct Lines(String);

impl Lines {
    /// Appends one line.
    fn add(&mut self, name: &str, value: impl Display) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.0, "{name:20} {}", in_a_line(&value.to_string()));
    }
}

/// Returns the report of a table as text.
fn text(table: &Table) -> String {
    let from = &table.provenance;
    let axes = &table.axes;
    let mut lines = Lines::default();
    cell(&mut lines, from);
    options(&mut lines, from);
    deviations(&mut lines, table);
    lines.add(
        "histogram",
        format!(
            "{0} x {0} bins, u and v in [-{1}, {1}] edge lengths",
            axes.bins, axes.range
        ),
    );
    directions(&mut lines, from);
    lines.add(
        "frame",
        "u along the in-plane direction of travel, v = n x u; the shift is p' - p",
    );
    lines.add("generator", &from.generator);
    lines.add("content SHA-256", table.content_hash());
    let Lines(mut text) = lines;
    text.push('\n');
    text.push_str(&directions_text(table));
    text
}

/// Appends what the table says about its cell.
fn cell(lines: &mut Lines, from: &Provenance) {
    lines.add("design", &from.design);
    lines.add("mesh SHA-256", &from.mesh_hash);
    lines.add(
        "edge length",
        format!("{} ({})", from.edge_length, from.edge_length_unit),
    );
    if let Some([a, b]) = from.lattice {
        lines.add(
            "lattice",
            format!("({}, {}), ({}, {}) edge lengths", a[0], a[1], b[0], b[1]),
        );
    }
    lines.add("refractive index", from.refractive_index.to_string());
}

/// Appends the options that the table was baked with.
fn options(lines: &mut Lines, from: &Provenance) {
    lines.add(
        "back, losses",
        format!("{}, {}", from.back, from.losses_text()),
    );
    if let Some(nm) = from.wavelength_nm {
        lines.add("wavelength", format!("{nm} nm"));
    }
    let sampler = from.sampler.as_ref();
    let sampler = sampler.map_or(String::new(), |name| {
        format!(", {name}, seed {}", from.seed)
    });
    lines.add("method", format!("{}{sampler}", from.method));
    if !from.options.text().is_empty() {
        lines.add("options", from.options.to_string());
    }
    if let Some(shards) = &from.shards {
        lines.add("shards", shards.to_string());
    }
    lines.add(
        "angular tolerance",
        format!("{} deg", from.angular_tolerance_deg),
    );
}

/// Appends how far light leaves off the way back, if the table records it.
fn deviations(lines: &mut Lines, table: &Table) {
    let deviation = table.exact.as_ref().map(Exact::largest_deviation_rad);
    if let Some(largest) = deviation.filter(|largest| *largest > 0.0) {
        lines.add(
            "deviation",
            format!("up to {:.4} mrad from straight back", 1e3 * largest),
        );
    }
    if let Some(found) = &table.deviations {
        let Grid { cells, bins, .. } = found.grid;
        let spreads = (0..found.entries.len()).map(|direction| found.spread(direction));
        let (rms, largest) = spreads.fold((0.0, 0.0), |(rms, largest): (f64, f64), spread| {
            (rms.max(spread.rms_rad), largest.max(spread.largest_rad))
        });
        lines.add(
            "deviation",
            format!(
                "up to {:.4} mrad from straight back, rms up to {:.4}: {bins} x {bins} bins of \
                {:.4} mrad, with the shift in \
                 {cells} x {cells} cells",
                1e3 * largest,
                1e3 * rms,
                1e3 * found.grid.bin_width(),
            ),
        );
    }
}

/// Appends which further directions the table stands for: by symmetry, or by interpolation.
fn directions(lines: &mut Lines, from: &Provenance) {
    let Symmetry {
        rotations,
        mirror_deg,
    } = from.symmetry;
    if from.symmetry != Symmetry::NONE {
        let mirror = mirror_deg.map_or(String::new(), |m| {
            format!(", mirror plane at azimuth {m} deg")
        });
        lines.add(
            "symmetry",
            format!("{rotations} rotations{mirror}: the azimuths below stand for all"),
        );
    }
    if let Some(tolerance) = from.direction_tolerance {
        lines.add(
            "between directions",
            format!(
                "interpolated polygons are within {tolerance} (total variation of eta x histogram)"
            ),
        );
    }
}

/// Returns the largest deviation in the table, radians, if the table records deviations.
fn largest_deviation_rad(table: &Table) -> Option<f64> {
    let of_beams = || table.exact.as_ref().map(Exact::largest_deviation_rad);
    let of_rays = table.deviations.as_ref().map(|found| {
        let spreads = (0..found.entries.len()).map(|direction| found.spread(direction));
        spreads.map(|spread| spread.largest_rad).fold(0.0, f64::max)
    });
    of_rays.or_else(of_beams)
}

/// Returns the report of a table as one line of JSON.
fn json(table: &Table) -> String {
    let from = &table.provenance;
    let value = json!({
        "design": from.design,
        "mesh_hash": from.mesh_hash,
        "edge_length": from.edge_length,
        "edge_length_unit": from.edge_length_unit,
        "azimuth_zero": from.azimuth_zero,
        "lattice": from.lattice,
        "refractive_index": from.refractive_index,
        "back": from.back.text(),
        "losses": from.losses.text(),
        "reflectance": from.reflectance,
        "metal_index": from.metal_index,
        "wavelength_nm": from.wavelength_nm,
        "method": from.method.text(),
        "sampler": from.sampler_text(),
        "seed": from.seed,
        "symmetry": {
            "rotations": from.symmetry.rotations, "mirror_deg": from.symmetry.mirror_deg
        },
        "direction_tolerance": from.direction_tolerance,
        "options": from.options.text(),
        "shards": from.shards.as_ref().map(ToString::to_string),
        "angular_tolerance_deg": from.angular_tolerance_deg,
        "tolerance": from.tolerance,
        "largest_deviation_mrad": largest_deviation_rad(table).map(|angle| 1e3 * angle),
        "bins": table.axes.bins,
        "range": table.axes.range,
        "randomisations": table.counts.as_ref().map(|counts| counts.shape()[2]),
        "generator": from.generator,
        "content_hash": table.content_hash(),
        "directions": directions_json(table),
    });
    format!("{value}\n")
}
