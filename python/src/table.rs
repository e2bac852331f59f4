//! Ray-shift tables.

use std::path::PathBuf;
use std::sync::Arc;

use bake::cli::calls::{self, Caller};
use num_complex::Complex64;
use numpy::ToPyArray;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyArray4, PyArray5, PyReadonlyArray1};
use pyo3::prelude::*;
use rayon::prelude::*;
use tables::cli::Refused;

use crate::mesh::Mesh;
use crate::work::run;
use crate::{Words, refusal};

/// Ray-shift table. Its arrays are copies.
#[pyclass(frozen, module = "midair._midair")]
pub(crate) struct Table {
    pub(crate) table: Arc<tables::Table>,
    name: PathBuf,
}

impl Table {
    /// Returns a table that the program holds.
    pub(crate) fn held(table: tables::Table, name: &str) -> Table {
        Table {
            table: Arc::new(table),
            name: name.into(),
        }
    }

    /// Returns the table with its name for messages.
    pub(crate) fn named(&self) -> (PathBuf, Arc<tables::Table>) {
        (self.name.clone(), Arc::clone(&self.table))
    }
}

/// Directions that one thread takes at a time.
const CHUNK: usize = 512;

/// One path of a direction: polygon of entry (n, 2), matrix (2, 2) and offset (2) of the shift,
/// weight, and deviation (2).
type Path<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    [f64; 2],
    f64,
    [f64; 2],
);

#[pymethods]
impl Table {
    /// Returns the file that the table was read from, or its name in messages.
    #[getter]
    fn name(&self) -> PathBuf {
        self.name.clone()
    }

    /// Returns the incidences outside the sheet, degrees, shape (incidence).
    #[getter]
    fn incidence_deg<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.table.axes.incidence_deg)
    }

    /// Returns the azimuths that the table holds, degrees, shape (azimuth); NaN for a mean over all
    /// azimuths.
    #[getter]
    fn azimuth_deg<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.table.axes.azimuth_deg)
    }

    /// Returns the half width of the histogram, edge lengths.
    #[getter]
    fn range(&self) -> f64 {
        self.table.axes.range
    }

    /// Returns the centres of the bins along u and along v, edge lengths, shape (bin).
    #[getter]
    fn shift<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let axes = &self.table.axes;
        PyArray1::from_iter(py, (0..axes.bins).map(|bin| axes.bin_centre(bin)))
    }

    /// Returns the probability of the shift of light that comes back within the range, shape
    /// (incidence, azimuth, shift_v, shift_u).
    #[getter]
    fn histogram<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray4<f64>> {
        self.table.histogram.to_pyarray(py)
    }

    /// Returns numbers of rays, shape (incidence, azimuth, randomisation, shift_v, shift_u), or
    /// None for an exact table.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray5<u64>>> {
        Some(self.table.counts.as_ref()?.to_pyarray(py))
    }

    /// Returns the retroreflected share of the light, shape (incidence, azimuth).
    #[getter]
    fn eta<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.table.retroreflected.to_pyarray(py)
    }

    /// Returns the standard error of eta, shape (incidence, azimuth); 0 for an exact table.
    #[getter]
    fn standard_error<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.table.standard_error.to_pyarray(py)
    }

    /// Returns the share of the light by fate, shape (incidence, azimuth, fate).
    #[getter]
    fn fate<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        self.table.fate.to_pyarray(py)
    }

    /// Returns the names of the fates.
    #[getter]
    fn fate_names(&self) -> Vec<&'static str> {
        self.table.fates().iter().map(|fate| fate.name()).collect()
    }

    /// Returns the rays launched, shape (incidence, azimuth); 0 for an exact table.
    #[getter]
    fn rays<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u64>> {
        self.table.rays.to_pyarray(py)
    }

    /// Returns whether the table holds polygons.
    #[getter]
    fn is_exact(&self) -> bool {
        self.table.exact.is_some()
    }

    /// Returns the SHA-256 of the content.
    #[getter]
    fn content_hash(&self) -> String {
        self.table.content_hash()
    }

    /// Returns the origin of the table, as texts by name.
    #[getter]
    fn provenance(&self) -> Vec<(&'static str, String)> {
        let own = &self.table.provenance;
        let mut all = vec![
            ("generator", own.generator.clone()),
            ("design", own.design.clone()),
            ("mesh_hash", own.mesh_hash.clone()),
            ("edge_length", own.edge_length.to_string()),
            ("edge_length_unit", own.edge_length_unit.clone()),
            ("refractive_index", own.refractive_index.to_string()),
            ("back", own.back.text().to_owned()),
            ("losses", own.losses.text().to_owned()),
            ("method", own.method.text().to_owned()),
            ("sampler", own.sampler_text().to_owned()),
            ("seed", own.seed.to_string()),
        ];
        if let Some(wavelength) = own.wavelength_nm {
            all.push(("wavelength_nm", wavelength.to_string()));
        }
        if !own.options.text().is_empty() {
            all.push(("options", own.options.text().to_owned()));
        }
        all
    }

    /// Returns the number of rotations and the azimuth of a mirror plane (degrees, or None) after
    /// which azimuths have one distribution.
    #[getter]
    fn symmetry(&self) -> (u32, Option<f64>) {
        let symmetry = self.table.provenance.symmetry;
        (symmetry.rotations, symmetry.mirror_deg)
    }

    /// Returns the azimuths in [0, 360) that the table knows by its symmetry: for each its
    /// azimuth, the index of the azimuth that it equals, and whether v is turned over.
    fn azimuths(&self) -> Vec<(f64, usize, bool)> {
        self.table.azimuths()
    }

    /// Returns whether a table of rays counts exit directions that are not straight back.
    fn has_exits(&self) -> bool {
        self.table.deviations.is_some()
    }

    /// Returns eta at a direction, and whether it was interpolated.
    fn eta_at(&self, incidence_deg: f64, azimuth_deg: Option<f64>) -> PyResult<(f64, bool)> {
        let direction = self.table.direction(incidence_deg, azimuth_deg);
        let direction = direction.map_err(refusal)?;
        Ok((direction.retroreflected, direction.interpolated))
    }

    /// Returns eta at many directions, shape (n): that of `eta_at`, hundreds of times faster.
    fn etas<'py>(
        &self,
        py: Python<'py>,
        incidence_deg: PyReadonlyArray1<'py, f64>,
        azimuth_deg: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (incidence, azimuth) = (incidence_deg.as_array(), azimuth_deg.as_array());
        let pairs = incidence.iter().zip(azimuth.iter());
        let directions: Vec<[f64; 2]> = pairs.map(|(&i, &a)| [i, a]).collect();
        let table = Arc::clone(&self.table);
        let made: Result<Vec<_>, _> = py.detach(move || {
            let chunks = directions.par_chunks(CHUNK);
            chunks.map(|chunk| table.retroreflected_at(chunk)).collect()
        });
        Ok(made.map_err(refusal)?.concat().into_pyarray(py))
    }

    /// Returns the probability of each shift per launched ray at a direction, shape (shift_v,
    /// shift_u).
    fn probability<'py>(
        &self,
        py: Python<'py>,
        incidence_deg: f64,
        azimuth_deg: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let direction = self.table.direction(incidence_deg, azimuth_deg);
        Ok(direction.map_err(refusal)?.probability.into_pyarray(py))
    }

    /// Returns the paths of a direction, and the area of the entrance, square edge lengths.
    fn paths<'py>(
        &self,
        py: Python<'py>,
        incidence_deg: f64,
        azimuth_deg: Option<f64>,
    ) -> PyResult<(Vec<Path<'py>>, f64)> {
        let Some(exact) = &self.table.exact else {
            return Err(refusal(format!(
                "{}: holds rays, no polygons; bake it with the method exact",
                self.name.display()
            )));
        };
        let direction = self.table.direction(incidence_deg, azimuth_deg);
        let paths = direction.map_err(refusal)?.paths.ok_or_else(|| {
            refusal(format!(
                "{}: has no polygons at this direction: they cannot be interpolated between its \
                neighbours, or are averaged over azimuths; bake this direction",
                self.name.display()
            ))
        })?;
        let array = |rows: &[[f64; 2]]| {
            Array2::from_shape_fn((rows.len(), 2), |(row, column)| rows[row][column])
                .into_pyarray(py)
        };
        let paths = paths.iter().map(|path| {
            let (polygon, matrix) = (array(&path.polygon), array(&path.matrix));
            (polygon, matrix, path.offset, path.weight, path.deviation)
        });
        Ok((paths.collect(), exact.entrance_area))
    }

    /// Returns the transfer function of the shifts at frequencies (fu, fv), cycles per edge length,
    /// shape (n).
    fn otf<'py>(
        &self,
        py: Python<'py>,
        fu: PyReadonlyArray1<'py, f64>,
        fv: PyReadonlyArray1<'py, f64>,
        incidence_deg: f64,
        azimuth_deg: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray1<Complex64>>> {
        let direction = self.table.direction(incidence_deg, azimuth_deg);
        let direction = direction.map_err(refusal)?;
        let (fu, fv) = (fu.as_array(), fv.as_array());
        let frequencies: Vec<[f64; 2]> = fu
            .iter()
            .copied()
            .zip(fv.iter().copied())
            .map(Into::into)
            .collect();
        let one = |&[u, v]: &[f64; 2]| {
            let length = u.hypot(v);
            let along = if length > 0.0 {
                [u / length, v / length]
            } else {
                [1.0, 0.0]
            };
            direction.otf_along(along, &[length])[0]
        };
        let values: Vec<Complex64> =
            run(py, None, |_| Ok(frequencies.par_iter().map(one).collect()))?;
        Ok(PyArray1::from_vec(py, values))
    }

    /// Writes the table to a file.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let table = &self.table;
        let written = py.detach(|| tables::write(table, &path));
        written.map_err(refusal)
    }
}

/// Reads a table, by the small reading program. Messages call it `name`, or else by its path.
#[pyfunction]
#[pyo3(signature = (path, name=None))]
pub(crate) fn open(py: Python<'_>, path: PathBuf, name: Option<PathBuf>) -> PyResult<Table> {
    let table = run(py, None, |_| {
        tables::read(&path).map_err(|error| Refused::Sentence(error.to_string()))
    })?;
    Ok(Table {
        table: Arc::new(table),
        name: name.unwrap_or(path),
    })
}

/// Bakes a table of a mesh file, or of a mesh in memory; returns it with the warnings.
#[pyfunction]
pub(crate) fn trace(
    py: Python<'_>,
    words: Words,
    mesh: Option<PyRef<'_, Mesh>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Table, Vec<String>)> {
    let mesh = mesh.as_ref().map(|mesh| &mesh.mesh);
    let (table, warnings) = run(py, progress, |host| {
        let caller = Caller {
            told: &|done, of| host.tell("rays", done, of),
            stop: &host.stop,
        };
        calls::trace(&words, mesh, caller)
    })?;
    let table = Table {
        name: format!("table of {}", table.provenance.design).into(),
        table: Arc::new(table),
    };
    Ok((table, warnings))
}
