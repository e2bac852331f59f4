//! Options of a cell.

use glam::DVec3;

/// Options of a cell, which take precedence over the file.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CellOptions {
    /// Lattice vectors, file units and frame; they override those of the file.
    pub lattice: Option<[DVec3; 2]>,
    /// Direction of azimuth 0, file frame, any length; only its part in the entrance plane counts.
    pub azimuth_zero: Option<DVec3>,
    /// Length of an edge from the apex, file units.
    pub edge_length: Option<f64>,
    /// True if facets stand for a curved face that has the file's normals (`normals`); false if
    /// they are planes.
    pub file_normals: bool,
    /// True if faces of the material `glass` are surfaces of bodies that light goes through, wound
    /// outward.
    ///
    /// The mesh is then taken as it is, closed or not. If false, all facets are mirrors.
    pub glass: bool,
    /// True if light goes on to the neighbours of the cell, so that the cell must be periodic.
    ///
    /// Without a lattice the sides of the rim are the lattice vectors, if the rim is a
    /// parallelogram.
    pub periodic: bool,
}
