//! The normalised cell that rays and beams are traced through.
//!
//! **Cell frame**: origin at the (first) apex; z = n, the sheet's normal towards the light; x = the
//! projection of the first edge on the entrance plane (azimuth 0); y = n x x. Lengths are in edge
//! lengths (a leg from the apex is 1).

use glam::{DVec2, DVec3};

use crate::cell::normals::Normals;

/// Where rays enter: a polygon or one lattice parallelogram of the plane z = `height`.
#[derive(Debug, Clone, PartialEq)]
pub struct Entrance {
    /// Height of the entrance plane above the apex, edge lengths.
    pub height: f64,
    /// Corners of the entrance polygon in the cell frame, counter-clockwise seen from the light,
    /// edge lengths; simple, not necessarily convex. For a periodic cell this is the lattice
    /// parallelogram.
    pub polygon: Vec<DVec2>,
    /// Lattice vectors of a periodic cell, edge lengths, right-handed (a x b > 0); `None` where
    /// rays end at the rim.
    pub lattice: Option<[DVec2; 2]>,
}

/// A checked, normalised corner-cube cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Mirror facets as triangles in the cell frame, counter-clockwise seen from the light; a front
    /// face is not among them. For a periodic cell: one period, facets may overhang the
    /// parallelogram.
    pub facets: Vec<[DVec3; 3]>,
    /// Normals of the curved faces that the facets stand for, where they were asked for; else
    /// facets are planes.
    pub normals: Option<Normals>,
    /// Whether light goes through each facet, where that was asked for; else empty, and all are
    /// mirrors.
    pub glass: Vec<bool>,
    /// Where rays enter.
    pub entrance: Entrance,
    /// Refractive index of a closed prism whose front face was taken off, as the file gives it.
    pub refractive_index: Option<f64>,
    /// Its Abbe number V_d, as the file gives it.
    pub abbe_number: Option<f64>,
    /// Whether the mesh was closed: it then has a front face of its own, in the entrance plane.
    pub closed: bool,
    /// Length of one edge in file units: what 1 stands for.
    pub edge_length: f64,
    /// First edge (azimuth 0) in the file's frame, unit length; for the table's provenance.
    pub azimuth_zero: DVec3,
    /// Name of the design.
    pub design: String,
    /// Hash of the mesh file, lower-case hex.
    pub mesh_hash: String,
    /// What was repaired or assumed, for the user.
    pub warnings: Vec<String>,
}

impl Cell {
    /// The file's refractive index at a vacuum wavelength: where the file gives an Abbe number by
    /// the two terms of Cauchy that KHR_materials_dispersion prescribes, its index being that of
    /// the d line, 587.6 nm; else the same at all.
    pub fn refractive_index_at(&self, wavelength_nm: Option<f64>) -> Option<f64> {
        let at_d = self.refractive_index?;
        let (Some(abbe), Some(nm)) = (self.abbe_number, wavelength_nm) else {
            return Some(at_d);
        };
        let index = at_d + (at_d - 1.0) / abbe * (523_655.0 / (nm * nm) - 1.5168);
        Some(index.max(1.0))
    }
}
