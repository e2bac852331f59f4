//! What a table says about its bake, held against the mesh.
//!
//! The bake of the mesh with the options of the table would state them in its own provenance. Where
//! that differs, the table is wrong. Options that change light are the same in both, because the
//! bake takes them from the table: their effect on the numbers is what [`super::retrace()`] and
//! [`super::rebake`] look at. What nothing can tell is listed for the user.

use std::fmt;

use crate::cell::Prepared;
use crate::error::Error;
use crate::plan::Plan;
use crate::run::bake::Progress;
use crate::run::bake::without_rays;
use crate::run::checks::retrace::{again, is_blind_to_the_back};
use crate::run::provenance::provenance;
use tables::options::{Losses, Method};
use tables::{Provenance, Table};

/// Largest relative difference of lengths that count as equal: that of a mesh that was written with
/// nine digits.
const SAME_LENGTH: f64 = 1e-9;

/// Statement of a table that its mesh contradicts.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("its {attribute} is {stated}, and the bake of the mesh says {found}")]
pub struct Contradiction {
    /// Name of the attribute or the group.
    pub attribute: &'static str,
    /// Value in the table.
    pub stated: String,
    /// Value that the bake of the mesh has.
    pub found: String,
}

/// Statement of a table that was not checked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unchecked {
    /// Name of the attribute.
    pub attribute: &'static str,
    /// Reason, as a part of a sentence.
    pub why: String,
}

impl fmt::Display for Unchecked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.attribute, self.why)
    }
}

/// Statements of a table about its bake, held against a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Claims {
    /// Statements that are wrong.
    pub wrong: Vec<Contradiction>,
    /// Statements that no comparison can tell.
    pub unchecked: Vec<Unchecked>,
}

impl Claims {
    /// Adds what is wrong if `stated` and `found` differ.
    fn same(&mut self, attribute: &'static str, stated: impl fmt::Debug, found: impl fmt::Debug) {
        let [stated, found] = [format!("{stated:?}"), format!("{found:?}")];
        if stated != found {
            self.wrong.push(Contradiction {
                attribute,
                stated,
                found,
            });
        }
    }

    /// Adds what is wrong if numbers differ by more than rounding.
    fn near(&mut self, attribute: &'static str, stated: &[f64], found: &[f64]) {
        let size = stated
            .iter()
            .chain(found)
            .fold(0.0, |a: f64, b| a.max(b.abs()));
        let apart = stated.iter().zip(found).map(|(a, b)| (a - b).abs());
        let near = apart.fold(0.0, f64::max) <= SAME_LENGTH * size;
        if stated.len() == found.len() && near {
            return;
        }
        match (stated, found) {
            ([stated], [found]) => self.same(attribute, stated, found),
            _ => self.same(attribute, stated, found),
        }
    }

    /// Adds what cannot be checked.
    fn unchecked(&mut self, attribute: &'static str, why: impl Into<String>) {
        let why = why.into();
        self.unchecked.push(Unchecked { attribute, why });
    }
}

/// Holds what a table says about its bake against a mesh.
///
/// `rays` and `seed` are those of [`crate::run::retrace()`].
///
/// # Errors
/// Returns the errors of [`crate::run::retrace()`].
pub fn claims(
    table: &Table,
    prepared: &Prepared,
    rays: u64,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Claims, Error> {
    let from = &table.provenance;
    let plan = again(table, prepared, rays, seed)?;
    let exact = from.method.is(Method::Exact);
    let own = own(table, prepared, &plan, exact);
    let mut found = origin(from, &own);
    // Every attribute has its line here, so that the compiler asks about a new one.
    let Provenance {
        generator: _, // these three by `origin`
        design: _,
        mesh_hash: _,
        edge_length,
        edge_length_unit,
        azimuth_zero,
        refractive_index,
        back: _, // known to `again`, and by the numbers
        losses,
        reflectance,
        method: _, // held against the content when a table is read
        sampler,
        seed: of_samples,
        angular_tolerance_deg: _, // by the numbers
        tolerance,
        lattice,
        wavelength_nm,
        metal_index,
        shards,
        symmetry: _,            // held against the mesh by `again`
        direction_tolerance: _, // tried by `error_between`
        options: _,             // known to `again`, and by the numbers
    } = from;
    found.near("edge_length", &[*edge_length], &[own.edge_length]);
    found.same("edge_length_unit", edge_length_unit, &own.edge_length_unit);
    found.near("azimuth_zero", azimuth_zero, &own.azimuth_zero);
    let upright = table.axes.incidence_deg.iter().all(|&angle| angle == 0.0);
    if upright && losses.is(Losses::None) && *refractive_index > 1.0 {
        found.unchecked("refractive_index", "it changes nothing at normal incidence");
    }
    if *refractive_index > 1.0 && is_blind_to_the_back(table, prepared, rays, seed, progress)? {
        let why = "in these directions mirrors and total reflection give the same";
        found.unchecked("back", why);
    }
    found.near("reflectance", &[*reflectance], &[own.reflectance]);
    if let Some(sampler) = sampler {
        found.unchecked(
            "sampler",
            format!("{sampler} points are not told from others"),
        );
        found.unchecked("seed", format!("{of_samples}, other rays are traced"));
    } else {
        found.same("seed", of_samples, own.seed);
    }
    match exact {
        true => found.same("tolerance", tolerance, own.tolerance),
        false if *tolerance > 0.0 => found.unchecked("tolerance", "it is what was asked for"),
        false => {}
    }
    let vectors = |lattice: &Option<[[f64; 2]; 2]>| lattice.map(|rows| rows.concat());
    let [stated, own_lattice] = [lattice, &own.lattice].map(vectors);
    found.near(
        "lattice",
        &stated.unwrap_or_default(),
        &own_lattice.unwrap_or_default(),
    );
    if wavelength_nm.is_some() {
        let why = "light is traced by the refractive indices alone";
        found.unchecked("wavelength_nm", why);
    }
    found.same("metal_index", metal_index, own.metal_index);
    if shards.is_some() {
        found.unchecked("shards", "any part of the samples looks like another");
    }
    if !exact {
        counted(table, &plan, prepared, &mut found);
    }
    found.unchecked(
        "frame, azimuths, units, long_name",
        "texts for people, which no program reads",
    );
    Ok(found)
}

/// Compares which rule and which mesh a table names with those of this bake, `own`.
fn origin(from: &Provenance, own: &Provenance) -> Claims {
    let mut found = Claims::default();
    let renamed = Provenance {
        generator: from.generator.clone(),
        ..own.clone()
    };
    if !own.is_of_the_bake(&renamed) {
        let why = format!(
            "\"{}\" is another rule than that of this bake",
            from.generator
        );
        found.unchecked("generator", why);
    }
    if from.mesh_hash != own.mesh_hash {
        found.unchecked("mesh_hash", "the mesh is another file");
    }
    // The name of a mesh may be that of its file, which its hash does not hold.
    if from.design != own.design {
        found.unchecked("design", format!("the mesh is \"{}\"", own.design));
    }
    found
}

/// Returns what the bake of the mesh with the options of a table would state.
fn own(table: &Table, prepared: &Prepared, plan: &Plan, exact: bool) -> Provenance {
    let from = &table.provenance;
    let method = from.method.known().unwrap_or(Method::Rays);
    let made = provenance(prepared.cell(), plan, from.symmetry, method, None);
    match exact {
        true => without_rays(plan, made),
        false => made,
    }
}

/// Holds the group of exit directions against what a bake by rays records, and says what is not
/// known of counts.
fn counted(table: &Table, plan: &Plan, prepared: &Prepared, found: &mut Claims) {
    let own = plan.deviations(prepared);
    match (table.deviations.as_ref(), own) {
        (Some(counted), Some(own)) => {
            let why = match counted.grid == own {
                true => "how exit directions depend on the shift: all shifts are taken together",
                false => "they were counted on another grid than that of this bake",
            };
            found.unchecked("group deviation", why);
        }
        (None, None) => {}
        (counted, own) => {
            let word = |there| if there { "there" } else { "absent" };
            let [stated, needed] = [counted.is_some(), own.is_some()].map(word);
            found.same("group deviation", stated, needed);
        }
    }
    if own.is_none() && plan.scene.deviations == tables::options::Record::Off {
        found.unchecked("exit directions", "the table has none, by --deviations off");
    }
    if plan.is_azimuth_mean() || plan.exact_cell(prepared).is_err() {
        let why = "rays alone do not tell how many others there were";
        found.unchecked("rays and standard_error", why);
    }
}
