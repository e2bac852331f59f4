//! Glass bead on a mirror: a sphere whose lower half is silvered, in a hexagonal lattice.

use std::collections::HashMap;
use std::num::NonZeroU32;

use glam::{DVec2, DVec3};

use crate::design::cube::inside;
use crate::files::write;
use crate::mesh::error::Fault;
use crate::mesh::mesh::{Mesh, sha256};

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
