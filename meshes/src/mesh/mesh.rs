//! Indexed triangles as a file holds them: file units, file frame.

use std::num::NonZeroU32;

use glam::DVec3;
use sha2::{Digest, Sha256};

/// Name of the material of faces that light goes through, with a glass index.
pub(crate) const GLASS: &str = "glass";
/// Largest number of vertices and of triangles that is accepted.
///
/// Beyond it the limit would be memory, not geometry.
pub(crate) const MAX_ELEMENTS: usize = 1 << 21;

/// Triangles in file units and the file's own frame, with what the file says about them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions relative to `origin`, file units, in the order of the file.
    pub positions: Vec<DVec3>,
    /// Origin of `positions` in the file's frame, file units.
    ///
    /// It is zero for OBJ. For glTF it is the origin of the first mesh node, so that exact local
    /// vertices keep their digits under a large node translation.
    pub origin: DVec3,
    /// Steps in which the file gives each position along the axes, file units: the unit of the last
    /// digit, or of the last place of an f32. Empty if positions have the digits of f64.
    pub steps: Vec<DVec3>,
    /// Vertex indices, wound counter-clockwise seen from the light (hollow facets) or outward
    /// (closed prisms).
    pub triangles: Vec<[u32; 3]>,
    /// Number (from 1) of the file's face from which each triangle was cut; empty if every face is
    /// a triangle.
    pub faces: Vec<u32>,
    /// Normals that the file gives, of any length.
    pub normals: Vec<DVec3>,
    /// Step in which the file gives components of about 1 of the normals; 0 if it gives enough
    /// digits for light not to notice.
    pub normal_step: f64,
    /// Numbers (from 1) of the normals at each triangle's corners; empty if the file gives none.
    pub corner_normals: Vec<[Option<NonZeroU32>; 3]>,
    /// For each face of the file, true if its material is `glass`; empty if none is.
    pub glass: Vec<bool>,
    /// Lattice vectors of a periodic cell, file units.
    pub lattice: Option<[DVec3; 2]>,
    /// Edge length that the file states for a truncated cell, file units (`# edge_length` comment,
    /// `extras.edge_length`).
    pub edge_length: Option<f64>,
    /// Direction of azimuth 0 that the file states for a cell without an apex, file frame, any
    /// length (`# azimuth_zero` comment, `extras.azimuth_zero`).
    pub azimuth_zero: Option<DVec3>,
    /// True if the file says that the cubes are hollow (`# hollow` comment, `extras.hollow`).
    pub hollow: bool,
    /// Refractive index that the file gives (`KHR_materials_ior`).
    pub refractive_index: Option<f64>,
    /// Abbe number V_d that the file gives (`KHR_materials_dispersion`, which stores 20 / V_d).
    pub abbe_number: Option<f64>,
    /// Name of the design, from the file (`# design ...` comment, `extras.design`) or from its
    /// stem.
    pub design: String,
    /// SHA-256 of the file's bytes and of every buffer that it refers to, lower-case hex.
    pub hash: String,
}

impl Mesh {
    /// Returns the number, from 1, of the file's face to which triangle `triangle` belongs.
    pub fn face_number(&self, triangle: usize) -> u32 {
        // u32 holds every triangle, because MAX_ELEMENTS is below its limit.
        self.faces
            .get(triangle)
            .copied()
            .unwrap_or(triangle as u32 + 1)
    }

    /// Returns whether the material of triangle `triangle` is `glass`.
    pub fn is_glass(&self, triangle: usize) -> bool {
        let face = self.face_number(triangle) as usize - 1;
        self.glass.get(face).copied().unwrap_or(false)
    }

    /// Returns the corners of triangle `triangle`, relative to `origin`, file units.
    ///
    /// # Panics
    /// Panics if the triangle or one of its indices is out of range. `crate::cell::check::vertices`
    /// excludes the latter.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }
}

/// Returns the SHA-256 over the concatenation of `parts`, lower-case hex.
pub(crate) fn sha256<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hasher = Sha256::new();
    parts.into_iter().for_each(|part| hasher.update(part));
    hasher
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}
