//! Designs that are no corner cubes.
//!
//! A micro-mirror array plate has two crossed layers of parallel slit mirrors, upright on the plate.
//! A glass bead on a mirror is a sphere whose lower half is silvered, in a hexagonal lattice.

use crate::design::cube::inside;
use crate::files::write;
use crate::mesh::error::Fault;
use crate::mesh::mesh::{Mesh, sha256};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::num::NonZeroU32;

/// One period of the plate, the light towards +z: mirrors across x above, mirrors across y below.
///
/// A mirror reflects on both sides and has a thickness. Its upper edge is a mirror too, facing the
/// light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plate {
    /// Distance from mirror to mirror in either layer, file units.
    pub pitch: f64,
    /// Depth of each layer, pitches; from 1e-3 to 1e3.
    pub depth: f64,
    /// Thickness of a mirror, pitches; from 1e-6 to 0.9.
    pub thickness: f64,
}

impl Plate {
    /// Name on the command line and in files.
    pub const NAME: &'static str = "plate";
    /// Description in one line, for a list.
    pub const DESCRIPTION: &'static str =
        "two crossed layers of slit mirrors, periodic: trace it with --element plate";

    /// Returns the mesh; its hash is that of the OBJ file that [`write::obj`] makes of it.
    ///
    /// # Errors
    /// Returns [`Fault::DesignOption`] if a number is out of its range.
    pub fn mesh(&self) -> Result<Mesh, Fault> {
        inside("edge length", self.pitch, 1e-30, 1e30)?;
        inside("depth", self.depth, 1e-3, 1e3)?;
        inside("thickness", self.thickness, 1e-6, 0.9)?;
        let (half, depth) = (self.pitch / 2.0, self.depth * self.pitch);
        let side = self.thickness * half;
        let mut mesh = Mesh {
            lattice: Some([DVec3::X * self.pitch, DVec3::Y * self.pitch]),
            edge_length: Some(self.pitch),
            design: Self::NAME.to_owned(),
            ..Mesh::default()
        };
        // The layer across x is first, because the lattice's first vector, which is azimuth 0, is
        // the normal of the upper mirrors.
        let layers = [(DVec3::X, DVec3::Y, depth), (DVec3::Y, DVec3::NEG_X, 0.0)];
        for (across, along, bottom) in layers {
            let first = mesh.positions.len() as u32;
            for height in [bottom, bottom + depth] {
                // Corners are counter-clockwise seen from the light.
                for (x, y) in [(-side, -half), (side, -half), (side, half), (-side, half)] {
                    mesh.positions
                        .push(across * x + along * y + DVec3::Z * height);
                }
            }
            let quads = [[1, 2, 6, 5], [3, 0, 4, 7], [4, 5, 6, 7]];
            for [a, b, c, d] in quads.map(|quad| quad.map(|corner| first + corner)) {
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh.hash = sha256([write::obj(&mesh).as_bytes()]);
        Ok(mesh)
    }
}

/// One bead of a sheet, the light towards +z.
///
/// It is an octahedron whose faces are cut into facets and brought onto the sphere. Facets above
/// the equator have the material `glass`, facets below are mirrors. Corners have the sphere's
/// normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bead {
    /// Distance from bead to bead, file units.
    pub pitch: f64,
    /// Diameter of a bead, pitches; from 1e-3 to 1, where beads touch.
    pub diameter: f64,
    /// Number of facets along each edge of the octahedron; from 1 to 1000.
    pub segments: u32,
}

impl Bead {
    /// Name on the command line and in files.
    pub const NAME: &'static str = "bead";
    /// Description in one line, for a list.
    pub const DESCRIPTION: &'static str = "a glass bead, its lower half a mirror, periodic: trace \
    it with --glass-index and --normals file";

    /// Returns the mesh; its hash is that of the OBJ file that [`write::obj`] makes of it.
    ///
    /// # Errors
    /// Returns [`Fault::DesignOption`] if a number is out of its range.
    pub fn mesh(&self) -> Result<Mesh, Fault> {
        inside("edge length", self.pitch, 1e-30, 1e30)?;
        inside("diameter", self.diameter, 1e-3, 1.0)?;
        inside("number of segments", f64::from(self.segments), 1.0, 1000.0)?;
        let step = DVec2::from_angle(std::f64::consts::FRAC_PI_3) * self.pitch;
        let mut mesh = Mesh {
            lattice: Some([DVec3::X * self.pitch, step.extend(0.0)]),
            edge_length: Some(self.pitch),
            design: Self::NAME.to_owned(),
            ..Mesh::default()
        };
        let radius = self.diameter * self.pitch / 2.0;
        let n = self.segments as i32;
        // Points of the octahedron |i| + |j| + |k| = n, shared by its faces.
        let mut vertices = HashMap::new();
        let mut vertex = |steps: [i32; 3], mesh: &mut Mesh| {
            *vertices.entry(steps).or_insert_with(|| {
                let normal = DVec3::from_array(steps.map(f64::from)).normalize();
                mesh.normals.push(normal);
                mesh.positions.push(normal * radius);
                mesh.positions.len() as u32 - 1
            })
        };
        for octant in 0..8 {
            let [x, y, z] = [1, 2, 4].map(|bit| if octant & bit == 0 { 1 } else { -1 });
            let mut facet = |corners: [[i32; 3]; 3]| {
                let [a, b, c] = corners.map(|[i, j, k]| vertex([x * i, y * j, z * k], &mut mesh));
                // A reflection reverses the winding.
                let corners = if x * y * z > 0 { [a, b, c] } else { [a, c, b] };
                mesh.triangles.push(corners);
                mesh.glass.push(z > 0);
                mesh.corner_normals
                    .push(corners.map(|v| NonZeroU32::new(v + 1)));
            };
            for (j, k) in (0..n).flat_map(|k| (0..n - k).map(move |j| (j, k))) {
                let i = n - 1 - j - k;
                facet([[i + 1, j, k], [i, j + 1, k], [i, j, k + 1]]);
                if i > 0 {
                    facet([[i - 1, j + 1, k + 1], [i, j, k + 1], [i, j + 1, k]]);
                }
            }
        }
        mesh.hash = sha256([write::obj(&mesh).as_bytes()]);
        Ok(mesh)
    }
}
