//! Measurements, estimates and what is predicted from them.

use std::path::PathBuf;
use std::sync::Arc;

use fit::cli::calls::{self, Caller, Campaign, Fit};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::arrays::{Given, held, planes};
use crate::table::Table;
use crate::work::{Host, run};
use crate::{Words, refusal};

/// Estimate of a sheet.
#[pyclass(frozen, module = "midair._midair")]
pub(crate) struct Result {
    result: fit::ResultFile,
    /// The photographs behind the result; `None` if it was read from a file.
    fit: Option<Fit>,
}

#[pymethods]
impl Result {
    /// Returns the text of the result, as `fit estimate -o` writes it.
    fn json(&self) -> String {
        calls::json(&self.result)
    }

    /// Returns the page of the estimate as HTML, or None if the result was read from a file.
    fn report(&self, py: Python<'_>, command: &str) -> Option<String> {
        let fit = self.fit.as_ref()?;
        Some(py.detach(|| fit.report(command)))
    }
}

/// Returns the caller of a verb for this host.
fn called<T>(host: &Host, verb: impl FnOnce(Caller) -> T) -> T {
    verb(Caller {
        told: &|what, done, of| host.tell(what, done, Some(of)),
        stop: &host.stop,
    })
}

/// Measures one photograph; returns JSON.
#[pyfunction]
pub(crate) fn measure(py: Python<'_>, words: Words, picture: Option<Given>) -> PyResult<String> {
    let picture = picture.map(held).transpose()?;
    run(py, None, |_| calls::measure(&words, picture.as_ref()))
}

/// Estimates a sheet from a manifest, which is a file or, with its photographs, in memory.
#[pyfunction]
pub(crate) fn estimate(
    py: Python<'_>,
    words: Words,
    tables: Vec<PyRef<'_, Table>>,
    campaign: Option<(String, Vec<Given>)>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Result> {
    let tables: Vec<_> = tables.iter().map(|table| table.named()).collect();
    let campaign = match campaign {
        Some((manifest, photographs)) => Some(Campaign {
            manifest,
            photographs: photographs.into_iter().map(held).collect::<PyResult<_>>()?,
        }),
        None => None,
    };
    let fit = run(py, progress, |host| {
        called(host, |caller| {
            calls::estimate(&words, campaign, &tables, caller)
        })
    })?;
    Ok(Result {
        result: fit.result().clone(),
        fit: Some(fit),
    })
}

/// Reads a result that was written to a file; of several channels, the named one.
#[pyfunction]
pub(crate) fn read_result(file: PathBuf, channel: Option<&str>) -> PyResult<Result> {
    let result = calls::read(&file, channel).map_err(refusal)?;
    Ok(Result { result, fit: None })
}

/// Returns the result of a text that [`Result::json`] made.
#[pyfunction]
pub(crate) fn result_of_json(text: &str) -> PyResult<Result> {
    let result = calls::of_json(text).map_err(refusal)?;
    Ok(Result { result, fit: None })
}

/// Makes the result of a sheet whose numbers are given by hand.
#[pyfunction]
pub(crate) fn sheet(words: Words, table: PyRef<'_, Table>) -> PyResult<Result> {
    let result = calls::sheet(&words, &table.table).map_err(refusal)?;
    Ok(Result { result, fit: None })
}

/// Reads the table of a nominal sheet.
#[pyfunction]
pub(crate) fn table_of_sheet(name: &str) -> PyResult<Table> {
    let table = calls::table_of_sheet(name).map_err(refusal)?;
    Ok(Table::held(table, name))
}

/// Predicts MTF and luminance; returns JSON.
#[pyfunction]
pub(crate) fn predict(
    py: Python<'_>,
    words: Words,
    result: PyRef<'_, Result>,
    table: PyRef<'_, Table>,
) -> PyResult<String> {
    let (result, table) = (&result.result, Arc::clone(&table.table));
    run(py, None, |_| calls::predict(&words, result, &table))
}

/// Planes of a picture, and the warnings about it.
type Read<'py> = (Vec<Bound<'py, PyArray2<f32>>>, Vec<String>);

/// Reads a picture from a file as linear light, one plane or three.
#[pyfunction]
pub(crate) fn read_picture<'py>(
    py: Python<'py>,
    file: PathBuf,
    transfer: Option<&str>,
) -> PyResult<Read<'py>> {
    let transfer = match transfer {
        Some(name) => Some(
            fit::Transfer::from_name(name)
                .ok_or_else(|| refusal(format!("transfer {name}: must be linear or srgb")))?,
        ),
        None => None,
    };
    let picture = py
        .detach(|| fit::load_colour(&file, transfer))
        .map_err(refusal)?;
    let size = [picture.height, picture.width];
    Ok((planes(py, size, picture.planes)?, picture.warnings))
}

/// Planes of an image, and the facts about it as JSON.
type Rendered<'py> = (Vec<Bound<'py, PyArray2<f32>>>, String);

/// Renders the mid-air image of a picture.
#[pyfunction]
pub(crate) fn render<'py>(
    py: Python<'py>,
    words: Words,
    result: PyRef<'py, Result>,
    camera: Option<PyRef<'py, Result>>,
    tables: Vec<PyRef<'py, Table>>,
    picture: Given<'py>,
) -> PyResult<Rendered<'py>> {
    let source = held(picture)?;
    let result = &result.result;
    let tables: Vec<_> = tables.iter().map(|own| Arc::clone(&own.table)).collect();
    let camera = camera.as_ref().map(|own| &own.result);
    let (image, facts) = run(py, None, |_| {
        let tables: Vec<_> = tables.iter().map(|own| &**own).collect();
        calls::render(&words, result, camera, &tables, source)
    })?;
    Ok((
        planes(py, [image.height, image.width], image.planes)?,
        facts,
    ))
}

/// Makes a page with sliders; returns it, and the facts about it as JSON.
#[pyfunction]
pub(crate) fn explore(
    py: Python<'_>,
    words: Words,
    result: PyRef<'_, Result>,
    table: PyRef<'_, Table>,
    picture: Option<Given<'_>>,
) -> PyResult<(String, String)> {
    let source = picture.map(held).transpose()?;
    let (result, table) = (&result.result, Arc::clone(&table.table));
    run(py, None, |_| calls::explore(&words, result, &table, source))
}

/// Plan, manifest to fill in, page to print, and warnings.
type Planned = (String, String, String, Vec<String>);

/// Plans photographs; returns the plan as JSON, the manifest, the page and warnings.
#[pyfunction]
pub(crate) fn plan(
    py: Python<'_>,
    words: Words,
    table: PyRef<'_, Table>,
    given: Option<PyRef<'_, Result>>,
) -> PyResult<Planned> {
    let table = Arc::clone(&table.table);
    let given = given.as_ref().map(|own| &own.result);
    let made = run(py, None, |_| calls::plan(&words, &table, given))?;
    Ok((made.json, made.manifest, made.page, made.warnings))
}

/// Writes a synthetic campaign; returns JSON.
#[pyfunction]
pub(crate) fn simulate(py: Python<'_>, words: Words) -> PyResult<String> {
    run(py, None, |_| calls::simulate(&words))
}

/// Studies how good estimates are; returns JSON.
#[pyfunction]
pub(crate) fn study(py: Python<'_>, words: Words, progress: Option<Py<PyAny>>) -> PyResult<String> {
    run(py, progress, |host| {
        called(host, |caller| calls::study(&words, caller))
    })
}
