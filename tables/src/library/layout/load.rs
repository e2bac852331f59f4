//! Reading of HDF5 objects into a table, without trust in the file.
//!
//! Every size is compared with the axes, and with a limit, before memory of that size is allocated.

use std::path::Path as FilePath;

use hdf5::File;
use ndarray::{Array2, Array4, Array5, Dimension};

use crate::error::Error;
use crate::library::confine::Ledger;
use crate::library::layout::names::{self, Variable, attribute};
use crate::library::layout::place::{Place, ROUNDING, near};
use crate::library::layout::{deviations, polygons};
use crate::library::{BAKE_AGAIN, NAME_A_TABLE};
use crate::options::{StatedOptions, Word};
use crate::table::axes::Axes;
use crate::table::check;
use crate::table::provenance;
use crate::table::provenance::Provenance;
use crate::table::symmetry::Symmetry;
use crate::table::table::Table;

/// Reads and checks everything but the content hash.
///
/// Returns the table and the hash that the file states.
pub(crate) fn load(file: &File, path: &FilePath) -> Result<(Table, String), Error> {
    let ledger = Ledger::new(file.size());
    let root = Place::new(file, path, "", &ledger)?;
    let format = root.text(attribute::FORMAT)?;
    if format != names::FORMAT {
        let fault = format!("attribute format is {format:?}, not {:?}", names::FORMAT);
        return Err(Error::file(path, fault, NAME_A_TABLE));
    }
    let found: u64 = root.integer(attribute::VERSION)?;
    if !(1..=names::VERSION).contains(&found) {
        let newest = names::VERSION;
        let fault = format!("is of format version {found}, this program reads 1 to {newest}");
        let remedy = "update the program or bake the table again";
        return Err(Error::file(path, fault, remedy));
    }
    let invalid = |broken| Error::file(path, broken, BAKE_AGAIN);
    let provenance = provenance(&root)?;
    let axes = Axes {
        incidence_deg: root.scale(&names::INCIDENCE)?,
        azimuth_deg: root.scale(&names::AZIMUTH)?,
        bins: root.scale(&names::SHIFT_U)?.len(),
        range: root.number(attribute::SHIFT_RANGE)?,
    };
    check::axes(&axes).map_err(invalid)?;
    root.bins(&names::SHIFT_U, &axes)?;
    root.bins(&names::SHIFT_V, &axes)?;
    let fates = root.fates(&provenance)?;

    let (i, j) = axes.shape();
    let (b, f) = (axes.bins, fates.len());
    let rays: Array2<u64> = root.array(&names::RAYS, &[i, j])?;
    let histogram = root.array(&names::HISTOGRAM, &[i, j, b, b])?;
    let retroreflected = root.array(&names::RETROREFLECTED, &[i, j])?;
    let standard_error = root.array(&names::STANDARD_ERROR, &[i, j])?;
    let fate = root.array(&names::FATE, &[i, j, f])?;
    let mut stored = Table {
        axes,
        histogram,
        counts: None,
        retroreflected,
        standard_error,
        fate,
        fate_counts: None,
        rays,
        exact: polygons::load(&root, i * j)?,
        deviations: None,
        provenance,
        passage: None,
        errors_rad: [0.0; 3],
    };
    if root.has(names::COUNTS.name) || root.has(names::FATE_COUNTS.name) {
        let r = root.randomisations()?;
        let counts: Array5<u64> = root.array(&names::COUNTS, &[i, j, r, b, b])?;
        let fate_counts: Array4<u64> = root.array(&names::FATE_COUNTS, &[i, j, r, f])?;
        check::counts(&counts, &fate_counts, &stored.rays).map_err(invalid)?;
        stored = derived(stored, counts, fate_counts, path)?;
        stored.deviations = deviations::load(&root, i * j)?;
    }
    check::check(&stored).map_err(invalid)?;
    Ok((stored, root.text(attribute::CONTENT_HASH)?))
}

/// Returns the table that follows from the counts, if the stored derived numbers agree with it.
fn derived(
    stored: Table,
    counts: Array5<u64>,
    fate_counts: Array4<u64>,
    path: &FilePath,
) -> Result<Table, Error> {
    let Table {
        axes,
        histogram,
        retroreflected,
        standard_error,
        fate,
        exact,
        provenance,
        ..
    } = stored;
    let mut table = Table::from_counts(axes, counts, fate_counts, provenance);
    table.exact = exact;
    agree(&names::HISTOGRAM, histogram, &table.histogram, path)?;
    agree(
        &names::RETROREFLECTED,
        retroreflected,
        &table.retroreflected,
        path,
    )?;
    agree(
        &names::STANDARD_ERROR,
        standard_error,
        &table.standard_error,
        path,
    )?;
    agree(&names::FATE, fate, &table.fate, path)?;
    Ok(table)
}

/// Checks that a stored array agrees with the computed one.
fn agree<D: Dimension>(
    variable: &Variable,
    stored: ndarray::Array<f64, D>,
    computed: &ndarray::Array<f64, D>,
    path: &FilePath,
) -> Result<(), Error> {
    // NaN agrees with nothing.
    let differ = |&(_, (a, b)): &(usize, (&f64, &f64))| !near(*a, *b, ROUNDING);
    match stored.iter().zip(computed).enumerate().find(differ) {
        Some((index, (stored, computed))) => {
            let name = variable.name;
            let fault = format!(
                "dataset {name} is {stored} at flat index {index}, but the counts give {computed}"
            );
            Err(Error::file(path, fault, BAKE_AGAIN))
        }
        None => Ok(()),
    }
}

/// Reads the provenance from the root attributes.
fn provenance(root: &Place) -> Result<Provenance, Error> {
    let lattice = match root.attributes.contains(attribute::LATTICE) {
        true => Some(root.numbers::<4>(attribute::LATTICE)?)
            .map(|[ax, ay, bx, by]| [[ax, ay], [bx, by]]),
        false => None,
    };
    let shards = match root.attributes.contains(attribute::SHARDS) {
        true => {
            let text = root.text(attribute::SHARDS)?;
            let record = text.parse().map_err(|()| {
                let fault = format!("is {text}, expected shards such as 1-3,7/8 of 4194304 rays");
                root.wrong("attribute", attribute::SHARDS, fault)
            })?;
            Some(record)
        }
        false => None,
    };
    let has = |name| root.attributes.contains(name);
    let symmetry = Symmetry {
        rotations: match has(attribute::SYMMETRY_ROTATIONS) {
            // `check` refuses a number that does not fit, because it is too large.
            true => u32::try_from(root.integer(attribute::SYMMETRY_ROTATIONS)?).unwrap_or(u32::MAX),
            false => 1,
        },
        mirror_deg: match has(attribute::SYMMETRY_MIRROR_DEG) {
            true => Some(root.number(attribute::SYMMETRY_MIRROR_DEG)?),
            false => None,
        },
    };
    let direction_tolerance = match has(attribute::DIRECTION_TOLERANCE) {
        true => Some(root.number(attribute::DIRECTION_TOLERANCE)?),
        false => None,
    };
    Ok(Provenance {
        generator: root.text(attribute::GENERATOR)?,
        design: root.text(attribute::DESIGN)?,
        mesh_hash: root.text(attribute::MESH_HASH)?,
        edge_length: root.number(attribute::EDGE_LENGTH)?,
        edge_length_unit: root.text(attribute::EDGE_LENGTH_UNIT)?,
        azimuth_zero: root.numbers(attribute::AZIMUTH_ZERO)?,
        refractive_index: root.number(attribute::REFRACTIVE_INDEX)?,
        back: Word::read(root.text(attribute::BACK)?),
        losses: Word::read(root.text(attribute::LOSSES)?),
        reflectance: root.number(attribute::REFLECTANCE)?,
        method: Word::read(root.text(attribute::METHOD)?),
        sampler: provenance::sampler(root.text(attribute::SAMPLER)?),
        seed: root.integer(attribute::SEED)?,
        angular_tolerance_deg: root.number(attribute::ANGULAR_TOLERANCE_DEG)?,
        tolerance: root.number(attribute::TOLERANCE)?,
        lattice,
        wavelength_nm: root
            .attributes
            .contains(attribute::WAVELENGTH_NM)
            .then(|| root.number(attribute::WAVELENGTH_NM))
            .transpose()?,
        metal_index: root
            .attributes
            .contains(attribute::METAL_INDEX)
            .then(|| root.numbers(attribute::METAL_INDEX))
            .transpose()?,
        shards,
        symmetry,
        direction_tolerance,
        options: match has(attribute::OPTIONS) {
            true => root.text(attribute::OPTIONS)?.as_str().into(),
            false => StatedOptions::none(),
        },
    })
}
