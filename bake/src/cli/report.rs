//! Reports of a bake and of a comparison, as text for a person and as JSON for a script.

use crate::run::{Between, Comparison};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use tables::options::{Element, Front};
use tables::{Fate, Table};

/// Share of a direction's light in the outermost bins of deviations above which a warning is given.
const OUTERMOST: f64 = 1e-4;

/// Share of a direction's light that three or more facets send back too far from straight back,
/// from which on a warning is given. No ideal cube has any.
const DEVIATED: f64 = 0.01;

/// Bins of deviations, in the rms spread of the light, below which a warning calls them coarse.
///
/// A bin of width w takes 1 - sinc(f R w) of an MTF. Of a Gaussian lobe with the rms s along each
/// axis that is at most 0.031 (w / s)^2, at any distance: 1 % where the rms of both axes together
/// is 2.5 w.
const FEW_BINS: f64 = 2.5;

/// Width of a bin of deviations, mrad, that is fine enough for any cell: 10 um at 1 m.
const FINE_MRAD: f64 = 0.01;

/// Report of `bake trace`.
pub(crate) struct Trace<'a> {
    /// Table that was baked.
    pub table: &'a Table,
    /// File that holds the table.
    pub file: &'a Path,
    /// Time of the bake in seconds, without reading and writing.
    pub seconds: f64,
    /// Error between directions, as far as it was tried.
    pub between: Option<Between>,
}

impl Trace<'_> {
    /// Returns the report as text: one line about the bake, then one line for each direction.
    pub(crate) fn text(&self) -> String {
        let table = self.table;
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
            let speed = rays as f64 / self.seconds / 1e6;
            writeln!(
                text,
                ", {rays} rays in {:.3} s ({speed:.1} million rays/s)",
                self.seconds
            )
        } else {
            writeln!(text, ", {:.4} s", self.seconds)
        };
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

    /// Returns warnings about the table: no light comes back, or its deviations are badly binned.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.table.retroreflected.iter().all(|&eta| eta == 0.0) {
            let other = [Fate::AntiparallelOther, Fate::Deviated];
            warnings.push(match self.most(&other) {
                0.0 => "no light comes back in any direction: the fates say where it goes (give \
                    --element plate for a plate that light passes, --glass-index for bodies of \
                    glass)"
                    .into(),
                share => format!(
                    "no light comes straight back, but up to {:.1} % of a direction's light \
                    leaves farther from straight back than --angular-tolerance ({} deg); give a \
                    larger one if this light is part of the mid-air image",
                    100.0 * share,
                    self.table.provenance.angular_tolerance_deg
                ),
            });
        } else {
            warnings.extend(self.deviated());
        }
        let Some(found) = &self.table.deviations else {
            return warnings;
        };
        let spreads = (0..found.entries.len()).map(|k| found.spread(k));
        let (mut outermost, mut rms) = (0.0_f64, 0.0_f64);
        for spread in spreads {
            (outermost, rms) = (outermost.max(spread.outermost), rms.max(spread.rms_rad));
        }
        let (width, range) = (1e3 * found.grid.bin_width(), 1e3 * found.grid.range);
        if outermost > OUTERMOST {
            warnings.push(format!(
                "up to {:.2} % of the light of a direction goes to the outermost bins of \
                deviations, or beyond them; give --deviations above {range:.4} mrad",
                100.0 * outermost
            ));
        }
        let returns = found.entries.iter().any(|entries| !entries.is_empty());
        if returns && 1e3 * rms < FEW_BINS * width && width > FINE_MRAD {
            warnings.push(format!(
                "exit directions are counted in bins of {width:.4} mrad, which is coarse for their \
                spread (rms {:.4} mrad); give --deviations {:.4}",
                1e3 * rms,
                found.advised_mrad()
            ));
        }
        warnings
    }

    /// Returns a warning about light of three or more facets that is too far from straight back.
    /// Light in a plate, through glass, or that a front face has sent back takes any direction, and
    /// is none of it.
    fn deviated(&self) -> Option<String> {
        let from = &self.table.provenance;
        let cubes = from.element() == Element::Retroreflector && !from.has_glass();
        let once = from.options.front() == Front::Once;
        let share = self.most(&[Fate::Deviated]);
        (cubes && once && share > DEVIATED).then(|| {
            format!(
                "up to {:.1} % of a direction's light leaves after three or more reflections, but \
                farther from straight back than --angular-tolerance ({} deg): facets are not at \
                right angles; if they should be, write the mesh with more digits, and if not, give \
                a larger tolerance where this light is part of the mid-air image",
                100.0 * share,
                self.table.provenance.angular_tolerance_deg
            )
        })
    }

    /// Returns the largest share of the light of a direction that has one of these fates.
    fn most(&self, fates: &[Fate]) -> f64 {
        let table = self.table;
        let (incidences, azimuths) = table.axes.shape();
        let all = (0..incidences).flat_map(|i| (0..azimuths).map(move |a| (i, a)));
        let of = |i, a, fate| table.fate[[i, a, fate as usize]];
        all.map(|(i, a)| fates.iter().map(|&fate| of(i, a, fate)).sum())
            .fold(0.0, f64::max)
    }

    /// Returns the report as JSON.
    pub(crate) fn json(&self) -> Value {
        let rays: u64 = self.table.rays.sum();
        json!({
            "table": self.file.display().to_string(),
            "content_hash": self.table.content_hash(),
            "method": self.table.provenance.method.text(),
            "seconds": self.seconds,
            "rays": rays,
            "rays_per_second":
                if rays > 0 { json!(rays as f64 / self.seconds) } else { Value::Null },
            "between_directions_error": self.between.map(|own| json!({
                "total_variation": own.error,
                "incidence_deg": own.incidence_deg,
                "azimuth_deg": own.azimuth_deg,
                "tried": own.tried,
            })),
            "directions": directions_json(self.table),
        })
    }
}

/// Returns one line for each direction: angles, eta, its error, and the other fates that occur.
pub(crate) fn directions_text(table: &Table) -> String {
    let mut text = String::from("incidence  azimuth  retroreflected  std. error  other fates\n");
    let fates = Fate::of(table.provenance.options.front());
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
        let fates: serde_json::Map<String, Value> = Fate::of(table.provenance.options.front())
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
        "incidence  azimuth  L1 distance  counting noise  largest bin  eta, sigmas  polygons  \
        exits' L1  agrees\n",
    );
    for row in &comparison.rows {
        let azimuth = if row.azimuth_deg.is_nan() {
            "mean".into()
        } else {
            row.azimuth_deg.to_string()
        };
        let _ = writeln!(
            text,
            "{:9}  {azimuth:>7}  {:11.2e}  {:14.2e}  {:11.2e}  {:11.2}  {:>8}  {:>9}  {}",
            row.incidence_deg,
            row.l1,
            row.noise,
            row.largest,
            row.sigmas,
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
                "counting_noise": row.noise, "largest_bin": row.largest, "sigmas": row.sigmas,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Prepared;
    use crate::plan::{Plan, Request};
    use crate::run::{Bake, Progress};
    use meshes::design::{Design, Shape};

    /// A pair loses half of its light without a word if one of its apexes is 2 % off. That is said
    /// from 1 % of the light on, and not of the pair itself.
    #[test]
    fn light_that_facets_send_astray_is_said() {
        let warnings = |off: f64| {
            let mut mesh = Design::new(Shape::TriangularPair).mesh().expect("a mesh");
            // The apex of the second cube.
            mesh.positions[4].x += off;
            let options = meshes::CellOptions::default();
            let cell = meshes::normalise(&mesh, "cell.obj".as_ref(), &options).expect("a cell");
            let prepared = Prepared::new(cell);
            let plan = Plan::new(&Request {
                incidence: "0,20".into(),
                refractive_index: Some(1.0),
                ..Request::default()
            });
            let plan = plan.expect("a plan");
            let bake = Bake::new(&prepared, &plan).expect("a bake");
            let table = bake.table(Progress::none()).expect("a table");
            let report = Trace {
                table: &table,
                file: "t.h5".as_ref(),
                seconds: 1.0,
                between: None,
            };
            report.warnings()
        };
        assert_eq!(warnings(0.0), Vec::<String>::new());
        let [said] = &warnings(0.02)[..] else {
            panic!("one warning");
        };
        assert!(
            said.contains("32.8 %") && said.contains("more digits"),
            "{said}"
        );
    }
}
