//! Indexed triangles as a file holds them: file units, file frame.

use glam::DVec3;

/// Triangles in file units and the file's own frame, with what the file says about them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions, file units.
    pub positions: Vec<DVec3>,
    /// Vertex indices, wound counter-clockwise seen from the light (hollow facets) or outward (closed prisms).
    pub triangles: Vec<[u32; 3]>,
    /// Lattice vectors of a periodic cell, file units.
    pub lattice: Option<[DVec3; 2]>,
    /// Refractive index that the file gives (`KHR_materials_ior`).
    pub refractive_index: Option<f64>,
    /// Name of the design, from the file (`# design ...` comment, `extras.design`) or its stem.
    pub design: String,
    /// SHA-256 of the file's bytes and of every buffer that it refers to, lower-case hex.
    pub hash: String,
}
