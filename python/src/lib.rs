//! The native half of the Python package `midair`: tables, meshes and fits as classes, and the
//! verbs of `bake` and `fit` as functions.
//!
//! Options enter as the words of a command line, so that a name, a default and a refusal are those
//! of the programs. The Python half (`midair/*.py`) gives them signatures, and makes xarray
//! datasets of arrays. Long work runs on another thread without the lock of the interpreter: meanwhile the
//! calling thread looks for Ctrl-C and tells the progress.

mod arrays;
mod fits;
mod mesh;
mod table;
mod work;

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;

pyo3::create_exception!(
    _midair,
    Refusal,
    pyo3::exceptions::PyException,
    "The reason why a verb did not do its work, as one sentence."
);

/// Makes the exception of a refusal.
fn refusal(reason: impl std::fmt::Display) -> PyErr {
    Refusal::new_err(tables::cli::in_a_line(&reason.to_string()).into_owned())
}

/// Words of a command line.
type Words = Vec<OsString>;

/// Names the program that opens tables, once for the process.
#[pyfunction]
fn use_reader(program: PathBuf) {
    tables::apart::start_with(program);
}

/// Writes a text to a file, whole or not at all.
#[pyfunction]
fn write(py: Python<'_>, path: PathBuf, text: &str) -> PyResult<()> {
    let written = py.detach(|| tables::Output::reserve(&path)?.commit(text.as_bytes()));
    written.map_err(refusal)
}

/// Functions and classes of the module.
#[pymodule]
mod _midair {
    #[pymodule_export]
    use super::Refusal;
    #[pymodule_export]
    use super::fits::{
        Result, estimate, explore, measure, plan, predict, read_picture, read_result, render,
        result_of_json, sheet, simulate, study, table_of_sheet,
    };
    #[pymodule_export]
    use super::mesh::{Mesh, datasheet, design, optimise};
    #[pymodule_export]
    use super::table::{Table, open, trace};
    #[pymodule_export]
    use super::{use_reader, write};
}
