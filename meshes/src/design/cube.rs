//! Parametric cells.
//!
//! All have their first apex at the origin, the cube's axes along x, y, z (unless a dihedral error
//! bends them), and the light towards +x +y +z. The vertices are in the order apex, then the ends
//! of its three edges. With the default edge length of 3, every coordinate of the ideal cells is an
//! integer: exact in text and in f32.

use crate::design::corner::CornerFacets;
use crate::design::curved;
use crate::design::elements::Bead;
use crate::design::elements::Plate;
use crate::files::write;
use crate::mesh::error::Fault;
use crate::mesh::mesh::{Mesh, sha256};
use glam::{DMat3, DVec3};

/// Kinds of corner-cube cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// One cube corner with a triangular aperture through the ends of its edges.
    Triangular,
    /// Cube corner and its copy turned by 180 degrees about the normal: a rhombic aperture that
    /// tiles the plane.
    TriangularPair,
    /// Three square facets with a hexagonal outline and a rim that is not planar: one period of a
    /// lattice.
    FullCube,
    /// Pair of cube corners tilted against the sheet's normal, cut by the sheet's plane.
    Canted,
}

impl Shape {
    /// All shapes, in the order of [`list`].
    pub const ALL: [Self; 4] = [
        Self::Triangular,
        Self::TriangularPair,
        Self::FullCube,
        Self::Canted,
    ];

    /// Returns the name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Triangular => "triangular",
            Self::TriangularPair => "triangular-pair",
            Self::FullCube => "full-cube",
            Self::Canted => "canted",
        }
    }

    /// Returns a description in one line, for a list.
    pub fn description(self) -> &'static str {
        match self {
            Self::Triangular => "one cube corner with a triangular aperture",
            Self::TriangularPair => {
                "a cube corner and its copy turned by 180 degrees: a rhombic aperture that tiles"
            }
            Self::FullCube => {
                "three square facets with a hexagonal outline and a rim that is not planar, \
                periodic"
            }
            Self::Canted => {
                "a pair of cube corners tilted against the sheet's normal, with a planar rim"
            }
        }
    }

    /// Returns the shape of this name.
    ///
    /// # Errors
    /// Returns [`Fault::UnknownDesign`], which names all designs, if there is no such shape.
    pub fn from_name(name: &str) -> Result<Self, Fault> {
        Self::ALL
            .into_iter()
            .find(|shape| shape.name() == name)
            .ok_or_else(|| Fault::UnknownDesign {
                name: name.to_owned(),
                known: list().map(|(name, _)| name).collect::<Vec<_>>().join(", "),
            })
    }
}

/// Returns names and descriptions of all designs; elements that are no corner cubes come last.
pub fn list() -> impl Iterator<Item = (&'static str, &'static str)> {
    let cubes = Shape::ALL.map(|shape| (shape.name(), shape.description()));
    cubes.into_iter().chain([
        (Plate::NAME, Plate::DESCRIPTION),
        (Bead::NAME, Bead::DESCRIPTION),
    ])
}

/// Parametric cell: a shape and its deviations from the ideal.
///
/// ```
/// use meshes::design::{Design, Shape};
/// let ideal = Design::new(Shape::TriangularPair);
/// let mesh = Design { dihedral_error_rad: [1e-4, 0.0, 0.0], ..ideal }.mesh()?;
/// assert_eq!(mesh.triangles.len(), 6);
/// # Ok::<(), meshes::Fault>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Design {
    /// Kind of cell.
    pub shape: Shape,
    /// Length of the longest edge from the apex before truncation, file units; 3 by default.
    pub edge_length: f64,
    /// Errors of the dihedral angles at edges 1, 2 and 3 (between the two facets that share the
    /// edge), rad.
    ///
    /// Positive errors make angles wider than 90 degrees. From -0.1 to 0.1.
    pub dihedral_error_rad: [f64; 3],
    /// Height by which the top is lower than the ideal one, as a part of the ideal height above the
    /// apex.
    ///
    /// From 0 to 0.99, and to 0.49 for the full cube. The three top corners of the full cube are
    /// cut off flat and closed by mirrors. The other shapes stay similar and become smaller, which
    /// only the recorded edge length tells.
    pub truncation: f64,
    /// Angle of the sheet's normal against the cube's axis for [`Shape::Canted`], rad; positive
    /// towards edge 1.
    ///
    /// From -0.602 (-34.5 degrees) to 0.907 (52 degrees); 0.15 by default. It is 0 for all other
    /// shapes.
    pub cant_rad: f64,
    /// Height by which the middle of each face bulges towards the light, edge lengths; 0 for
    /// planes.
    ///
    /// From -0.05 to 0.05. Not for the full cube.
    pub sag: f64,
    /// Number of facets along each edge of a face, which has the square of it in all; from 1 to
    /// 1000.
    pub segments: u32,
    /// Radius of the cylinders that fill the three edges from the apex, and of the sphere that
    /// fills the apex, file units.
    ///
    /// At most a fifth of the shortest edge. 0 is a sharp edge, and the only value for
    /// [`Shape::FullCube`].
    pub edge_radius: f64,
    /// Number of planar strips of a cylinder, 1 to 24; the sphere has the square of it in
    /// triangles.
    pub strips: u32,
    /// Part of each edge from the apex that a flat facet cuts off; from 0 to 0.5.
    ///
    /// It is 0 with rounded edges and for [`Shape::FullCube`].
    pub apex_flat: f64,
    /// Width of the land between neighbouring cubes, file units, up to ten edge lengths.
    ///
    /// The land is a flat mirror in the plane of the rim; between full cubes it is open.
    pub gap: f64,
}

impl Design {
    /// Returns the ideal cell of this shape.
    pub fn new(shape: Shape) -> Self {
        let cant_rad = if shape == Shape::Canted { 0.15 } else { 0.0 };
        Self {
            shape,
            edge_length: 3.0,
            dihedral_error_rad: [0.0; 3],
            truncation: 0.0,
            cant_rad,
            sag: 0.0,
            segments: 1,
            edge_radius: 0.0,
            strips: 8,
            apex_flat: 0.0,
            gap: 0.0,
        }
    }

    /// Returns the cell as a mesh; its hash is that of the OBJ file that [`write::obj`] makes of
    /// it.
    ///
    /// Accuracy: dihedral errors to 2e-16 rad, heights and lengths to 4e-16 of the edge length.
    ///
    /// # Errors
    /// Returns [`Fault::DesignOption`] if a number is out of its range, and
    /// [`Fault::DesignOptionUnused`] if an option does not fit the shape or another option.
    pub fn mesh(&self) -> Result<Mesh, Fault> {
        self.check()?;
        let legs = legs(self.dihedral_error_rad).map(|leg| leg * self.edge_length);
        let mut mesh = match self.shape {
            Shape::FullCube => full_cube(legs, 2.0 * self.truncation, self.gap),
            Shape::Canted => self.of_corners(self.canted(legs))?,
            Shape::Triangular | Shape::TriangularPair => self.of_corners(legs)?,
        };
        if self.sag != 0.0 || self.segments > 1 {
            mesh = curved::faces(&mesh, self.sag * self.edge_length, self.segments);
        }
        mesh.design = self.shape.name().to_owned();
        let has_apex = self.edge_radius == 0.0 && self.apex_flat == 0.0;
        mesh.edge_length = (self.truncation > 0.0 || !has_apex).then_some(self.edge_length);
        mesh.azimuth_zero = (!has_apex).then_some(legs[0]);
        mesh.hash = sha256([write::obj(&mesh).as_bytes()]);
        Ok(mesh)
    }

    /// Makes the cell of one or two cube corners between the edges `legs` before truncation.
    fn of_corners(&self, legs: [DVec3; 3]) -> Result<Mesh, Fault> {
        let legs = legs.map(|leg| leg * (1.0 - self.truncation));
        let shortest = legs
            .map(DVec3::length)
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        inside("edge radius", self.edge_radius, 0.0, 0.2 * shortest)?;
        let corner = if self.edge_radius > 0.0 {
            CornerFacets::rounded(legs, self.edge_radius, self.strips)
        } else if self.apex_flat > 0.0 {
            CornerFacets::blunt(legs, self.apex_flat)
        } else {
            CornerFacets::sharp(legs)
        };
        let (corner, ends) = corner.with_land(legs, 0.5 * self.gap);
        Ok(match self.shape {
            Shape::Triangular => corner.mesh(),
            Shape::TriangularPair | Shape::FullCube | Shape::Canted => {
                corner.pair(ends, rim_normal(legs))
            }
        })
    }

    /// Checks that all numbers are in their ranges and that all options fit the shape.
    fn check(&self) -> Result<(), Fault> {
        inside("edge length", self.edge_length, 1e-30, 1e30)?;
        for error in self.dihedral_error_rad {
            inside("dihedral error in mrad", 1e3 * error, -100.0, 100.0)?;
        }
        inside(
            "truncation",
            self.truncation,
            0.0,
            if self.shape == Shape::FullCube {
                0.49
            } else {
                0.99
            },
        )?;
        inside("sag in edge lengths", self.sag, -0.05, 0.05)?;
        inside("number of segments", f64::from(self.segments), 1.0, 1000.0)?;
        inside("number of strips", f64::from(self.strips), 1.0, 24.0)?;
        inside("flat apex", self.apex_flat, 0.0, 0.5)?;
        inside("gap", self.gap, 0.0, 10.0 * self.edge_length)?;
        let unused = |option| {
            let design = self.shape.name().to_owned();
            Err(Fault::DesignOptionUnused { design, option })
        };
        match (self.edge_radius != 0.0, self.apex_flat != 0.0) {
            (true, true) => return unused("both an edge radius and a flat apex"),
            (true, _) if self.shape == Shape::FullCube => return unused("an edge radius"),
            (_, true) if self.shape == Shape::FullCube => return unused("a flat apex"),
            _ if self.sag == 0.0 => {}
            _ if self.shape == Shape::FullCube => return unused("a sag"),
            (false, false) if self.gap == 0.0 => {}
            _ => return unused("a sag together with an edge radius, a flat apex or a gap"),
        }
        if self.shape == Shape::Canted {
            // Beyond these angles the sheet's normal comes near a facet (at -35.26 degrees) or an
            // edge (at 54.74 degrees).
            return inside("cant in degrees", self.cant_rad.to_degrees(), -34.5, 52.0);
        }
        if self.cant_rad != 0.0 {
            return unused("a cant");
        }
        Ok(())
    }

    /// Returns the legs cut off by the plane whose normal is canted; the longest of them is one
    /// edge length.
    fn canted(&self, legs: [DVec3; 3]) -> [DVec3; 3] {
        let axis = rim_normal(legs).normalize();
        let towards = (legs[0] - axis * axis.dot(legs[0])).normalize();
        let normal = axis * self.cant_rad.cos() + towards * self.cant_rad.sin();
        let rise = legs.map(|leg| leg.dot(normal));
        let height = rise[0].min(rise[1]).min(rise[2]);
        [0, 1, 2].map(|k| legs[k] * (height / rise[k]))
    }
}

/// Returns the unit edges from the apex for the given dihedral errors: those nearest to x, y, z.
///
/// Spherical trigonometry gives the angle between two edges from the three dihedral angles A = 90
/// deg + error: cos a = (cos A + cos B cos C) / (sin B sin C). These cosines are the Gram matrix G
/// of the edges, and the edges are G^(1/2), the symmetric square root.
fn legs(error: [f64; 3]) -> [DVec3; 3] {
    let [a, b, c] = error;
    let between =
        |opposite: f64, d: f64, e: f64| (-opposite.sin() + d.sin() * e.sin()) / (d.cos() * e.cos());
    // The angle between edges 2 and 3 lies opposite edge 1.
    let (g23, g31, g12) = (between(a, b, c), between(b, c, a), between(c, a, b));
    let excess = DMat3::from_cols(
        DVec3::new(0.0, g12, g31),
        DVec3::new(g12, 0.0, g23),
        DVec3::new(g31, g23, 0.0),
    );
    // G^(1/2) = I + S with S = (E - S S) / 2. The iteration is on the excess E alone, so that 1e-9
    // keeps its digits.
    let mut root = excess * 0.5;
    for _ in 0..60 {
        root = (excess - root * root) * 0.5;
    }
    [
        DVec3::X + root.x_axis,
        DVec3::Y + root.y_axis,
        DVec3::Z + root.z_axis,
    ]
}

/// Returns a normal of the plane through the ends of three edges, away from the apex.
///
/// It is not of unit length, because normalising would turn integers into roots.
fn rim_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Makes the full cube; `cut` is the part of each upper edge that is cut off at the top corners.
fn full_cube([a, b, c]: [DVec3; 3], cut: f64, gap: f64) -> Mesh {
    let wider = |period: DVec3| match gap {
        0.0 => period,
        _ => period * (1.0 + gap / period.length()),
    };
    let lattice = Some([a - b, b - c].map(wider));
    if cut == 0.0 {
        let positions = vec![DVec3::ZERO, a, b, c, a + b, b + c, c + a];
        let triangles = vec![
            [0, 1, 4],
            [0, 4, 2],
            [0, 2, 5],
            [0, 5, 3],
            [0, 3, 6],
            [0, 6, 1],
        ];
        return Mesh {
            positions,
            triangles,
            lattice,
            ..Mesh::default()
        };
    }
    let keep = 1.0 - cut;
    let mut positions = vec![DVec3::ZERO, a, b, c];
    let mut triangles = Vec::new();
    for (first, second, u, v) in [(1, 2, a, b), (2, 3, b, c), (3, 1, c, a)] {
        let next = positions.len() as u32;
        positions.extend([u + v * keep, v + u * keep]);
        triangles.extend([[0, first, next], [0, next, next + 1], [0, next + 1, second]]);
    }
    // The third corner of the flat top over a + b lies on the edge towards a + b - c, in a
    // neighbouring cell.
    let next = positions.len() as u32;
    positions.push(a + b - c * cut);
    triangles.push([5, 4, next]);
    Mesh {
        positions,
        triangles,
        lattice,
        ..Mesh::default()
    }
}

/// Checks that an option of a design is a number from `least` to `most`.
pub(crate) fn inside(option: &'static str, value: f64, least: f64, most: f64) -> Result<(), Fault> {
    // NaN is outside of every range.
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(Fault::DesignOption {
            option,
            value,
            least,
            most,
        })
    }
}
