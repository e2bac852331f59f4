//! Micro-mirror array plate: two crossed layers of parallel slit mirrors, upright on the plate.

use glam::DVec3;

use crate::design::cube::inside;
use crate::files::write;
use crate::mesh::error::Fault;
use crate::mesh::mesh::{Mesh, sha256};

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
