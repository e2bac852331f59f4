//! Pictures in and out.

use std::path::PathBuf;

use fit::InMemory;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use crate::refusal;

/// Picture as Python hands it over: its name, its planes `[plane, row, column]`, and whether its
/// values were integers.
pub(crate) type Given<'py> = (PathBuf, PyReadonlyArray3<'py, f32>, bool);

/// Copies a picture.
pub(crate) fn held((name, planes, of_integers): Given) -> PyResult<InMemory> {
    let view = planes.as_array();
    let (count, height, width) = view.dim();
    if !matches!(count, 1 | 3) || width == 0 || height == 0 {
        return Err(refusal(format!(
            "{}: has {count} planes of {height} x {width} pixels; give an array of shape (rows, \
            columns) or (rows, columns, 3)",
            name.display()
        )));
    }
    Ok(InMemory {
        name,
        width,
        height,
        planes: view
            .outer_iter()
            .map(|plane| plane.iter().copied().collect())
            .collect(),
        of_integers,
    })
}

/// Hands planes over without copying them, each as an array `[row, column]`.
pub(crate) fn planes(
    py: Python<'_>,
    [height, width]: [usize; 2],
    planes: Vec<Vec<f32>>,
) -> PyResult<Vec<Bound<'_, PyArray2<f32>>>> {
    let array = |plane| Array2::from_shape_vec((height, width), plane).map_err(refusal);
    let each = planes.into_iter();
    each.map(|plane| Ok(array(plane)?.into_pyarray(py)))
        .collect()
}
