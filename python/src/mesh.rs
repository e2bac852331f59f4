//! Meshes of cells.

use std::path::PathBuf;

use bake::cli::calls::{self, Caller};
use glam::DVec3;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::work::{Host, run};
use crate::{Words, refusal};

/// Mesh of a cell, in the units of its file.
#[pyclass(frozen, module = "midair._midair")]
pub(crate) struct Mesh {
    pub(crate) mesh: meshes::Mesh,
}

/// Returns vectors as an array, one row for each.
fn rows<T: Copy + numpy::Element>(rows: &[[T; 3]]) -> Array2<T> {
    Array2::from_shape_fn((rows.len(), 3), |(row, column)| rows[row][column])
}

#[pymethods]
impl Mesh {
    /// Makes the mesh of vertices and faces, as if it had been read from an OBJ file.
    #[new]
    fn new(
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, u32>,
        design: String,
        lattice: Option<[[f64; 3]; 2]>,
        hollow: bool,
    ) -> PyResult<Self> {
        let three = |columns: usize| match columns {
            3 => Ok(()),
            _ => Err(refusal(
                "vertices and faces of a mesh have three columns; give arrays of shapes (n, 3) \
                and (m, 3)",
            )),
        };
        let (vertices, faces) = (vertices.as_array(), faces.as_array());
        three(vertices.ncols())?;
        three(faces.ncols())?;
        if let Some(&vertex) = faces
            .iter()
            .find(|&&vertex| vertex as usize >= vertices.nrows())
        {
            return Err(refusal(format!(
                "faces: {vertex} is the index of no vertex; indices run from 0 to below the {} \
                vertices",
                vertices.nrows()
            )));
        }
        let vector = |[x, y, z]: [f64; 3]| DVec3::new(x, y, z);
        let made = meshes::Mesh {
            positions: (vertices.rows().into_iter())
                .map(|row| vector([row[0], row[1], row[2]]))
                .collect(),
            triangles: (faces.rows().into_iter())
                .map(|row| [row[0], row[1], row[2]])
                .collect(),
            lattice: lattice.map(|vectors| vectors.map(vector)),
            design,
            hollow,
            ..meshes::Mesh::default()
        };
        Mesh::read_back(&made)
    }

    /// Returns the vertices, file units, shape (n, 3).
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let positions: Vec<[f64; 3]> = (self.mesh.positions.iter())
            .map(|position| (*position + self.mesh.origin).to_array())
            .collect();
        rows(&positions).into_pyarray(py)
    }

    /// Returns indices of vertices, one row for each triangle, shape (m, 3).
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        rows(&self.mesh.triangles).into_pyarray(py)
    }

    /// Returns the name of the design.
    #[getter]
    fn design(&self) -> &str {
        &self.mesh.design
    }

    /// Returns the SHA-256 of the mesh as an OBJ file, which a table of this mesh holds.
    #[getter]
    fn hash(&self) -> &str {
        &self.mesh.hash
    }

    /// Returns the text of the mesh as an OBJ file.
    fn obj(&self) -> String {
        meshes::write::obj(&self.mesh)
    }

    /// Returns the mesh that this text of an OBJ file holds.
    #[staticmethod]
    fn of_obj(text: &str) -> PyResult<Self> {
        let mesh = meshes::obj::parse(text.as_bytes()).map_err(refusal)?;
        Ok(Mesh { mesh })
    }

    /// Writes the mesh to a file, .obj or .glb.
    fn write(&self, path: PathBuf) -> PyResult<()> {
        calls::write(&self.mesh, &path).map_err(refusal)
    }
}

impl Mesh {
    /// Returns the mesh as it is read from the OBJ file that it would be written to.
    fn read_back(mesh: &meshes::Mesh) -> PyResult<Self> {
        Mesh::of_obj(&meshes::write::obj(mesh))
    }
}

/// Makes the mesh of a design.
#[pyfunction]
pub(crate) fn design(words: Words) -> PyResult<Mesh> {
    let mesh = calls::design(&words).map_err(refusal)?;
    Ok(Mesh { mesh })
}

/// Returns the caller of a verb for this host; `what` names its pieces.
fn called<T>(host: &Host, what: &str, verb: impl FnOnce(Caller) -> T) -> T {
    verb(Caller {
        told: &|done, of| host.tell(what, done, of),
        stop: &host.stop,
    })
}

/// Makes the data sheet of a cell, or of two compared; returns the page, JSON and warnings.
#[pyfunction]
pub(crate) fn datasheet(
    py: Python<'_>,
    words: Words,
    meshes: [Option<PyRef<'_, Mesh>>; 2],
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String, Vec<String>)> {
    let held = meshes
        .each_ref()
        .map(|mesh| mesh.as_ref().map(|mesh| &mesh.mesh));
    let made = run(py, progress, |host| {
        called(host, "bakes", |caller| {
            calls::datasheet(&words, held, caller)
        })
    })?;
    Ok((made.page, made.json, made.warnings))
}

/// Best cell, JSON, picture of the front and warnings.
type Best = (Mesh, String, Option<String>, Vec<String>);

/// Searches the best cell of a goal.
#[pyfunction]
pub(crate) fn optimise(
    py: Python<'_>,
    words: Words,
    progress: Option<Py<PyAny>>,
) -> PyResult<Best> {
    let made = run(py, progress, |host| {
        called(host, "cells", |caller| calls::optimise(&words, caller))
    })?;
    let mesh = Mesh { mesh: made.mesh };
    Ok((mesh, made.json, made.front, made.warnings))
}
