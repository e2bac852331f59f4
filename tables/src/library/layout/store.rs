//! Writing of a table as HDF5 objects.

use crate::library::layout::deviations;
use crate::library::layout::flat::Flat;
use crate::library::layout::names::{self, DimensionScale, Variable, attribute, exact};
use crate::library::memory::{load_no_code, unused_name};
use crate::library::scales::{attach_scale, set_scale};
use crate::options::Front;
use crate::table::exact::Exact;
use crate::table::fate::Fate;
use crate::table::flat::FlatPaths;
use crate::table::provenance::Provenance;
use crate::table::symmetry::Symmetry;
use crate::table::table::Table;
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, Group, H5Type, Location, Result};
use ndarray::{Array1, ArrayView, ArrayView1, ArrayViewD, Dimension};
use std::str::FromStr;

/// Creates an empty HDF5 file in memory, without time stamps.
///
/// Every reader since HDF5 1.10 opens its version, and its metadata have checksums.
pub(crate) fn create() -> Result<File> {
    load_no_code();
    // The name is not in the bytes.
    File::with_options()
        .with_fapl(|access| access.core_filebacked(false).libver_v110())
        .with_fcpl(|creation| creation.obj_track_times(false).attr_phase_change(64, 32))
        .create(unused_name())
}

/// Writes every object of the table into an empty file.
pub(crate) fn store(table: &Table, file: &File) -> Result<()> {
    attributes(table, file)?;
    let axes = &table.axes;
    let centres: Array1<f64> = (0..axes.bins).map(|i| axes.bin_centre(i)).collect();
    let randomisations = table.counts.as_ref().map_or(0, |counts| counts.shape()[2]);
    let fates = table
        .fates()
        .iter()
        .map(|fate| text(fate.name()))
        .collect::<Result<Array1<_>>>()?;
    let mut writer = Writer {
        file,
        scales: Vec::new(),
    };
    writer.scale(&names::INCIDENCE, ArrayView1::from(&axes.incidence_deg))?;
    writer.scale(&names::AZIMUTH, ArrayView1::from(&axes.azimuth_deg))?;
    writer.scale(&names::SHIFT_V, centres.view())?;
    writer.scale(&names::SHIFT_U, centres.view())?;
    writer.scale(&names::FATE_NAME, fates.view())?;
    if randomisations > 0 {
        writer.scale(
            &names::RANDOMISATION,
            Array1::from_iter(0..randomisations as u64).view(),
        )?;
    }
    writer.variable(&names::HISTOGRAM, table.histogram.view().into_dyn())?;
    writer.variable(
        &names::RETROREFLECTED,
        table.retroreflected.view().into_dyn(),
    )?;
    writer.variable(
        &names::STANDARD_ERROR,
        table.standard_error.view().into_dyn(),
    )?;
    writer.variable(&names::FATE, table.fate.view().into_dyn())?;
    writer.variable(&names::RAYS, table.rays.view().into_dyn())?;
    if let (Some(counts), Some(fate_counts)) = (&table.counts, &table.fate_counts) {
        writer.variable(&names::COUNTS, counts.view().into_dyn())?;
        writer.variable(&names::FATE_COUNTS, fate_counts.view().into_dyn())?;
    }
    if let Some(found) = &table.deviations {
        deviations::store(found, file)?;
    }
    match &table.exact {
        Some(found) => polygons(found, file),
        None => Ok(()),
    }
}

/// Writer of datasets, with the scales that it has written.
struct Writer<'a> {
    file: &'a File,
    scales: Vec<(&'static str, Dataset)>,
}

impl Writer<'_> {
    /// Writes a dimension scale.
    fn scale<T: H5Type + Clone>(
        &mut self,
        scale: &DimensionScale,
        values: ArrayView1<T>,
    ) -> Result<()> {
        let dataset = dataset(self.file, scale.name, values, &[values.len()])?;
        set_scale(&dataset, scale.c_name)?;
        describe(&dataset, scale.units, scale.long_name)?;
        self.scales.push((scale.name, dataset));
        Ok(())
    }

    /// Writes a dataset over its scales.
    ///
    /// Large arrays have one chunk for each direction and randomisation, small arrays a single
    /// chunk.
    fn variable<T: H5Type + Clone>(
        &self,
        variable: &Variable,
        values: ArrayViewD<T>,
    ) -> Result<()> {
        let mut chunk = values.shape().to_vec();
        if let [leading @ .., _, _] = &mut chunk[..]
            && variable
                .scales
                .ends_with(&[&names::SHIFT_V, &names::SHIFT_U])
        {
            leading.fill(1);
        }
        let dataset = dataset(self.file, variable.name, values, &chunk)?;
        describe(&dataset, variable.units, variable.long_name)?;
        for (dimension, scale) in (0..).zip(variable.scales) {
            if let Some((_, scale)) = self.scales.iter().find(|(name, _)| *name == scale.name) {
                attach_scale(&dataset, scale, dimension)?;
            }
        }
        Ok(())
    }
}

/// Writes the unit and the meaning of a dataset.
fn describe(dataset: &Dataset, units: &str, long_name: &str) -> Result<()> {
    put_text(dataset, attribute::UNITS, units)?;
    put_text(dataset, attribute::LONG_NAME, long_name)
}

/// Writes the group of polygons.
fn polygons(found: &Exact, file: &File) -> Result<()> {
    let mut builder = file.create_group_builder();
    builder.gcpl().obj_track_times(false);
    let group = builder.create(exact::GROUP)?;
    put(&group, exact::ENTRANCE_AREA, &found.entrance_area)?;
    let flat = FlatPaths::new(found);
    let path = (exact::PATH, flat.weight.len());
    let [shift, entry, deviation] =
        [exact::SHIFT_AXIS, exact::ENTRY_AXIS, exact::DEVIATION_AXIS].map(|axis| (axis, 2));
    let mut group = Flat::new(&group);
    group.array(exact::PATH_DIRECTION, &flat.direction, &[path])?;
    group.array(exact::PATH_MATRIX, &flat.matrix, &[path, shift, entry])?;
    group.array(exact::PATH_OFFSET, &flat.offset, &[path, shift])?;
    group.array(exact::PATH_WEIGHT, &flat.weight, &[path])?;
    if !flat.deviation.is_empty() {
        group.array(exact::PATH_DEVIATION, &flat.deviation, &[path, deviation])?;
    }
    if !flat.passes.is_empty() {
        group.array(exact::PATH_PASSES, &flat.passes, &[path])?;
    }
    if !flat.jones.is_empty() {
        let [out, inward, part] =
            [exact::FIELD_OUT, exact::FIELD_IN, exact::COMPLEX_PART].map(|axis| (axis, 2));
        group.array(exact::PATH_JONES, &flat.jones, &[path, out, inward, part])?;
    }
    if !flat.cube.is_empty() {
        let [plane, axis] = [exact::PLANE, exact::NORMAL_AXIS].map(|axis| (axis, 3));
        group.array(exact::PATH_CUBE, &flat.cube, &[path, plane, axis])?;
    }
    group.array(
        exact::POLYGON_START,
        &flat.start,
        &[(exact::BOUND, path.1 + 1)],
    )?;
    let vertex = (exact::VERTEX, flat.vertex.len() / 2);
    group.array(exact::POLYGON_VERTEX, &flat.vertex, &[vertex, entry])
}

/// Returns the first version that can say all of the table.
fn version(table: &Table) -> u64 {
    let options = &table.provenance.options;
    let mut paths = table
        .exact
        .iter()
        .flat_map(|exact| exact.paths.iter().flatten());
    if table.fates().contains(&Fate::ReflectedByFront) {
        names::VERSION
    } else if options.front() == Front::Trapped
        || paths.any(|path| path.passes > 0 || path.jones.is_some())
    {
        names::VERSION_OF_PASSES
    } else if table.deviations.is_some() || !options.text().is_empty() {
        names::VERSION_OF_DEVIATIONS
    } else {
        1
    }
}

/// Writes the root attributes.
fn attributes(table: &Table, file: &File) -> Result<()> {
    put_text(file, attribute::CONVENTIONS, names::CONVENTIONS)?;
    put_text(file, attribute::FORMAT, names::FORMAT)?;
    put(file, attribute::VERSION, &version(table))?;
    put_text(file, attribute::FRAME, names::FRAME)?;
    let azimuths = if table.axes.is_mean() {
        "mean over all azimuths of retroreflected x histogram in the incidence frame"
    } else if table.provenance.symmetry != Symmetry::NONE {
        "as listed in azimuth_deg, for themselves and by symmetry_rotations and \
        symmetry_mirror_deg for others"
    } else {
        "as listed in azimuth_deg"
    };
    put_text(file, attribute::AZIMUTHS, azimuths)?;
    put_text(file, attribute::CONTENT_HASH, &table.content_hash())?;
    put(file, attribute::SHIFT_RANGE, &table.axes.range)?;
    provenance(&table.provenance, file)
}

/// Writes the provenance as root attributes.
fn provenance(provenance: &Provenance, file: &File) -> Result<()> {
    put_text(file, attribute::GENERATOR, &provenance.generator)?;
    put_text(file, attribute::DESIGN, &provenance.design)?;
    put_text(file, attribute::MESH_HASH, &provenance.mesh_hash)?;
    put(file, attribute::EDGE_LENGTH, &provenance.edge_length)?;
    put_text(
        file,
        attribute::EDGE_LENGTH_UNIT,
        &provenance.edge_length_unit,
    )?;
    put_array(
        file,
        attribute::AZIMUTH_ZERO,
        &provenance.azimuth_zero,
        &[3],
    )?;
    put(
        file,
        attribute::REFRACTIVE_INDEX,
        &provenance.refractive_index,
    )?;
    put_text(file, attribute::BACK, provenance.back.text())?;
    put_text(file, attribute::LOSSES, provenance.losses.text())?;
    put(file, attribute::REFLECTANCE, &provenance.reflectance)?;
    put_text(file, attribute::METHOD, provenance.method.text())?;
    put_text(file, attribute::SAMPLER, provenance.sampler_text())?;
    put(file, attribute::SEED, &provenance.seed)?;
    put(
        file,
        attribute::ANGULAR_TOLERANCE_DEG,
        &provenance.angular_tolerance_deg,
    )?;
    put(file, attribute::TOLERANCE, &provenance.tolerance)?;
    if let Some(lattice) = &provenance.lattice {
        put_array(file, attribute::LATTICE, lattice.as_flattened(), &[2, 2])?;
    }
    if let Some(wavelength_nm) = &provenance.wavelength_nm {
        put(file, attribute::WAVELENGTH_NM, wavelength_nm)?;
    }
    if let Some(metal_index) = &provenance.metal_index {
        put_array(file, attribute::METAL_INDEX, metal_index, &[2])?;
    }
    if let Some(shards) = &provenance.shards {
        put_text(file, attribute::SHARDS, &shards.to_string())?;
    }
    let Symmetry {
        rotations,
        mirror_deg,
    } = provenance.symmetry;
    if provenance.symmetry != Symmetry::NONE {
        put(file, attribute::SYMMETRY_ROTATIONS, &u64::from(rotations))?;
    }
    if let Some(mirror) = mirror_deg {
        put(file, attribute::SYMMETRY_MIRROR_DEG, &mirror)?;
    }
    if let Some(tolerance) = provenance.direction_tolerance {
        put(file, attribute::DIRECTION_TOLERANCE, &tolerance)?;
    }
    match provenance.options.text() {
        "" => Ok(()),
        options => put_text(file, attribute::OPTIONS, options),
    }
}

/// Level of compression with the best size for its time on histograms; 9 is 1 % smaller and takes 4
/// times as long.
const DEFLATE: u8 = 4;

/// Writes a compressed dataset in chunks.
pub(crate) fn dataset<T: H5Type + Clone, D: Dimension>(
    group: &Group,
    name: &str,
    values: ArrayView<T, D>,
    chunk: &[usize],
) -> Result<Dataset> {
    let values = values.as_standard_layout();
    let builder = group
        .new_dataset_builder()
        .with_data(values.view())
        .obj_track_times(false);
    // HDF5 has no chunks of length 0.
    if chunk.contains(&0) {
        return builder.create(name);
    }
    builder
        .chunk(chunk)
        .shuffle()
        .deflate(DEFLATE)
        .fletcher32()
        .create(name)
}

/// Writes an attribute of one value.
pub(crate) fn put<T: H5Type + Clone>(at: &Location, name: &str, value: &T) -> Result<()> {
    at.new_attr::<T>().create(name)?.write_scalar(value)
}

/// Writes an attribute that is an array of this shape.
pub(crate) fn put_array(at: &Location, name: &str, values: &[f64], shape: &[usize]) -> Result<()> {
    at.new_attr::<f64>()
        .shape(shape)
        .create(name)?
        .write_raw(values)
}

/// Writes an attribute that is a text.
pub(crate) fn put_text(at: &Location, name: &str, value: &str) -> Result<()> {
    put(at, name, &text(value)?)
}

/// Converts a text for HDF5.
///
/// # Errors
/// Fails if the text holds a zero byte, because HDF5 strings end there.
pub(crate) fn text(value: &str) -> Result<VarLenUnicode> {
    VarLenUnicode::from_str(value).map_err(|error| hdf5::Error::Internal(error.to_string()))
}
