//! What the user says about a cell.

use glam::DVec3;

/// What the user says about a cell instead of the file.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CellOptions {
    /// Lattice vectors, file units and frame; overrides the file's.
    pub lattice: Option<[DVec3; 2]>,
    /// Direction of azimuth 0, file frame, any length; its part in the entrance plane counts.
    pub azimuth_zero: Option<DVec3>,
    /// Length of an edge (a leg from the apex), file units.
    pub edge_length: Option<f64>,
    /// Whether facets stand for a curved face that has the file's normals (`normals`); else they
    /// are planes.
    pub file_normals: bool,
    /// Whether faces of the material `glass` are surfaces of bodies that light goes through, wound
    /// outward. The mesh is then taken as it is, closed or not; else all facets are mirrors.
    pub glass: bool,
}
