//! Writing of attributes and datasets, one at a time.

use std::str::FromStr;

use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, Group, H5Type, Location, Result};
use ndarray::{ArrayView, Dimension};

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
