//! Normalised cell through which rays and beams are traced.
//!
//! **Cell frame**: the origin is the (first) apex; z = n, the sheet's normal towards the light; x
//! is the projection of the first edge on the entrance plane (azimuth 0); y = n x x. Lengths are in
//! edge lengths (a leg from the apex is 1).

use crate::cell::normals::Normals;
use glam::{DVec2, DVec3};

/// Entrance of rays: a polygon, or one lattice parallelogram, in the plane z = `height`.
#[derive(Debug, Clone, PartialEq)]
pub struct Entrance {
    /// Height of the entrance plane above the apex, edge lengths.
    pub height: f64,
    /// Corners of the entrance polygon in the cell frame, counter-clockwise seen from the light,
    /// edge lengths.
    ///
    /// The polygon is simple, but not necessarily convex. For a periodic cell it is the lattice
    /// parallelogram.
    pub polygon: Vec<DVec2>,
    /// Lattice vectors of a periodic cell, edge lengths, right-handed (a x b > 0); `None` if rays
    /// end at the rim.
    pub lattice: Option<[DVec2; 2]>,
}

/// Corner-cube cell, checked and normalised.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Mirror facets as triangles in the cell frame, counter-clockwise seen from the light.
    ///
    /// A front face is not among them. For a periodic cell they are one period, and may overhang
    /// the parallelogram.
    pub facets: Vec<[DVec3; 3]>,
    /// Normals of the curved faces that the facets stand for, if they were asked for; `None` if
    /// facets are planes.
    pub normals: Option<Normals>,
    /// For each facet, true if light goes through it; empty if all facets are mirrors.
    pub glass: Vec<bool>,
    /// Entrance of the rays.
    pub entrance: Entrance,
    /// Refractive index of a closed prism whose front face was taken off, as the file gives it; 1
    /// if the file says that the cubes are hollow.
    pub refractive_index: Option<f64>,
    /// Abbe number V_d of the prism, as the file gives it.
    pub abbe_number: Option<f64>,
    /// True if the mesh was closed: it then has a front face of its own, in the entrance plane.
    pub closed: bool,
    /// Length of one edge in file units: the unit of the cell frame.
    pub edge_length: f64,
    /// Where this length comes from.
    pub edge_length_from: EdgeLengthFrom,
    /// Unit of the file's lengths, if somebody says it. No format's own is taken.
    pub unit: Option<String>,
    /// Direction of the first edge (azimuth 0) in the file's frame, unit length; for the table's
    /// provenance.
    pub azimuth_zero: DVec3,
    /// Name of the design.
    pub design: String,
    /// Hash of the mesh file, lower-case hex.
    pub mesh_hash: String,
    /// Repairs and assumptions, for the user.
    pub warnings: Vec<String>,
}

/// Where the edge length of a cell comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeLengthFrom {
    /// The user gave it.
    User,
    /// The mesh file states it.
    File,
    /// It is the longest edge from the apex. In a truncated cell that is less than the edge of the
    /// whole cube.
    Longest,
}

impl Cell {
    /// Returns the file's refractive index at a vacuum wavelength in nm.
    ///
    /// If the file gives an Abbe number, the index follows from the two terms of Cauchy that
    /// KHR_materials_dispersion prescribes; the index in the file is that of the d line, 587.6 nm.
    /// Without an Abbe number or a wavelength the file's index is returned.
    pub fn refractive_index_at(&self, wavelength_nm: Option<f64>) -> Option<f64> {
        let at_d = self.refractive_index?;
        let (Some(abbe), Some(nm)) = (self.abbe_number, wavelength_nm) else {
            return Some(at_d);
        };
        let index = at_d + (at_d - 1.0) / abbe * (523_655.0 / (nm * nm) - 1.5168);
        Some(index.max(1.0))
    }
}

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
