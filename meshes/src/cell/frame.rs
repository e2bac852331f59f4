//! Position of the cell frame in the frame of the file.

use glam::DVec3;

use crate::cell::apex::{Corner, Fans};
use crate::cell::cell::{CellOptions, EdgeLengthFrom};
use crate::cell::surface::Surface;
use crate::mesh::error::Fault;

/// Greatest angle between lattice and surface, rad, for vectors typed with few digits.
const LATTICE_TILT: f64 = 0.02;

/// Origin, axes and unit of a cell, in the file's frame (positions relative to the mesh's origin).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    /// Origin of the cell frame: the first apex, or the lowest vertex if there is none.
    pub apex: DVec3,
    /// Axes x, y and z of the cell frame, unit vectors.
    pub axes: [DVec3; 3],
    /// Unit of the cell frame: length of an edge, file units.
    pub edge_length: f64,
    /// Where this length comes from.
    pub edge_length_from: EdgeLengthFrom,
    /// Length of an edge that the file states, or of the longest edge of the first cube, file
    /// units; `None` without both.
    pub found_edge_length: Option<f64>,
    /// Direction of the first edge, unit length.
    pub azimuth_zero: DVec3,
    /// True if there is an apex: the cell is made of corner cubes.
    pub has_apex: bool,
}

impl Frame {
    /// Returns a vector of the file in the cell frame, edge lengths.
    pub(crate) fn direction(&self, v: DVec3) -> DVec3 {
        let [x, y, z] = self.axes.map(|axis| axis.dot(v / self.edge_length));
        DVec3::new(x, y, z)
    }

    /// Returns a position of the mesh in the cell frame, edge lengths.
    ///
    /// The apex is subtracted first, so that digits stay.
    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.direction(p - self.apex)
    }

    /// Finds the apex, the normal and the first edge of an open surface that faces the light.
    ///
    /// # Errors
    /// Returns [`Fault::NoApex`] if neither the surface nor the options give an edge length and an
    /// azimuth zero. Returns the fault of the lattice or of the options if one of them is wrong.
    pub(crate) fn of(
        surface: &Surface<'_>,
        lattice: Option<[DVec3; 2]>,
        options: &CellOptions,
    ) -> Result<Frame, Fault> {
        let mesh = surface.mesh;
        let normal = normal(surface, lattice)?;
        let fans = Fans::new(surface);
        let apex = fans
            .corners()
            .into_iter()
            .find(|corner| corner.hollow && corner.axis.dot(normal) > 0.0);
        let legs = apex.as_ref().and_then(|apex: &Corner| fans.legs(apex));
        let longest = legs.map(|legs| {
            legs.iter()
                .map(|leg| leg.along.length())
                .fold(0.0, f64::max)
        });
        let found_edge_length = mesh.edge_length.or(longest);
        let edge_length = options
            .edge_length
            .or(found_edge_length)
            .ok_or(Fault::NoApex)?;
        let edge_length_from = match (options.edge_length, mesh.edge_length) {
            (Some(_), _) => EdgeLengthFrom::User,
            (None, Some(_)) => EdgeLengthFrom::File,
            (None, None) => EdgeLengthFrom::Longest,
        };
        let azimuth_zero = options
            .azimuth_zero
            .or(mesh.azimuth_zero)
            .or(legs.map(|legs| legs[0].along))
            // A cell that is no corner cube, but states its edge length, takes the first lattice
            // vector.
            .or(lattice.map(|[a, _]| a))
            .ok_or(Fault::NoApex)?;
        let origin = match &apex {
            Some(apex) => apex.vertex,
            None => lowest(surface, normal),
        };
        let no_direction = || Fault::AzimuthZero {
            x: azimuth_zero.x,
            y: azimuth_zero.y,
            z: azimuth_zero.z,
        };
        let azimuth_zero = azimuth_zero.try_normalize().ok_or_else(no_direction)?;
        // The vector is projected twice, because one projection of a nearly normal vector leaves an
        // error of 1e-16 over the remaining length.
        let flat = azimuth_zero - normal * normal.dot(azimuth_zero);
        let x = flat
            .try_normalize()
            .filter(|_| flat.length() > 1e-6)
            .ok_or_else(no_direction)?;
        let x = (x - normal * normal.dot(x)).normalize();
        let axes = [x, normal.cross(x), normal];
        Ok(Frame {
            apex: mesh.positions[origin as usize],
            axes,
            edge_length,
            edge_length_from,
            found_edge_length,
            azimuth_zero,
            has_apex: apex.is_some(),
        })
    }
}

/// Returns the first of the lowest vertices along `normal`: the origin of a cell without an apex.
fn lowest(surface: &Surface<'_>, normal: DVec3) -> u32 {
    let mut vertices: Vec<u32> = surface.welded.iter().flatten().copied().collect();
    vertices.sort_unstable();
    let height = |v: u32| normal.dot(surface.mesh.positions[v as usize]);
    vertices
        .into_iter()
        .min_by(|&a, &b| height(a).total_cmp(&height(b)))
        .unwrap_or_default()
}

/// Returns the unit normal of the sheet towards the light: that of the lattice, otherwise that of
/// the rim.
fn normal(surface: &Surface<'_>, lattice: Option<[DVec3; 2]>) -> Result<DVec3, Fault> {
    let vector_area = surface.vector_area();
    let Some([a, b]) = lattice else {
        let first = surface.boundary().first().map_or(0, |edge| edge.0);
        let no_plane = Fault::RimNotPlanar {
            vertex: first as usize + 1,
            height: f64::INFINITY,
        };
        return vector_area.try_normalize().ok_or(no_plane);
    };
    let cross = a.cross(b);
    let sine = cross.length() / (a.length() * b.length());
    if !(a.is_finite() && b.is_finite() && sine > 1e-6) {
        return Err(Fault::LatticeDegenerate);
    }
    // A closed surface has no side that it faces. Light then comes from the side from which the
    // lattice vectors turn counter-clockwise.
    let closed = vector_area.length() <= 1e-9 * cross.length();
    let vector_area = if closed { DVec3::ZERO } else { vector_area };
    let normal = cross.normalize()
        * if cross.dot(vector_area) < 0.0 {
            -1.0
        } else {
            1.0
        };
    let tilt = normal.angle_between(vector_area.normalize_or(normal));
    if tilt > LATTICE_TILT {
        return Err(Fault::LatticeTilted {
            degrees: tilt.to_degrees(),
        });
    }
    Ok(normal)
}
