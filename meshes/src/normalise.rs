//! From a mesh in file units to a cell in its own frame.

use std::path::Path;

use glam::{DVec2, DVec3};

use crate::apex::{Corner, Fans};
use crate::cell::{Cell, Entrance};
use crate::check;
use crate::error::{Error, Fault};
use crate::mesh::{Mesh, load};
use crate::prism;
use crate::rim;
use crate::surface::Surface;

/// A rim is planar, and no vertex above it, to this part of the cell's extent (f32 files round to 6e-8 of it).
pub const PLANAR: f64 = 1e-6;
/// A lattice may lean this much against the surface, rad: vectors typed with few digits do.
const LATTICE_TILT: f64 = 0.02;
/// Facets may cover more than their lattice cell by this part of it: lattice vectors typed with few digits.
const OVERFULL: f64 = 1e-3;
/// Least number of digits: rounding past this part of an edge is an error, past a hundredth of it a warning.
const DIGITS: f64 = 1e-6;

/// What the user says about a cell instead of the file.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CellOptions {
    /// Lattice vectors, file units and frame; overrides the file's.
    pub lattice: Option<[DVec3; 2]>,
    /// Direction of azimuth 0, file frame, any length; its part in the entrance plane counts.
    pub azimuth_zero: Option<DVec3>,
    /// Length of an edge (a leg from the apex), file units.
    pub edge_length: Option<f64>,
}

/// Loads a mesh file and normalises it: [`load`], then [`normalise`].
///
/// # Errors
/// Those of the two.
pub fn load_cell(path: &Path, options: &CellOptions) -> Result<Cell, Error> {
    normalise(&load(path)?, path, options)
}

/// Checks a mesh and brings it into the cell frame, with edge length 1.
///
/// Nothing is snapped or straightened: facets are the file's vertices less the apex, over the edge length, turned into
/// the frame. Accuracy: the rounding of the file's coordinates (2e-16 of the largest, file units) over the edge length,
/// and 4e-16 of the cell's extent.
///
/// `path` appears in messages only.
///
/// # Errors
/// Any [`Fault`] of the mesh's faces, its rim, its lattice or the options.
pub fn normalise(mesh: &Mesh, path: &Path, options: &CellOptions) -> Result<Cell, Error> {
    cell(mesh, options).map_err(|fault| Error::new(path, fault))
}

fn cell(mesh: &Mesh, options: &CellOptions) -> Result<Cell, Fault> {
    if let Some(edge_length) = options.edge_length.filter(|e| !(e.is_finite() && *e > 0.0)) {
        return Err(Fault::EdgeLength { edge_length });
    }
    check::vertices(mesh)?;
    let surface = Surface::new(mesh);
    check::surface(&surface)?;
    let mut warnings = Vec::new();
    let closed = is_closed(&surface)?;
    let turned = if closed {
        Some(opened(&surface, &mut warnings)?)
    } else {
        facing_light(&surface, &mut warnings)?
    };
    match turned {
        None => placed(&surface, closed, options, warnings),
        Some(mesh) => placed(&Surface::new(&mesh), closed, options, warnings),
    }
}

/// Whether the surface has no boundary; it must then be one body.
fn is_closed(surface: &Surface<'_>) -> Result<bool, Fault> {
    let (part, parts) = surface.parts();
    let mut open = vec![false; parts];
    for sides in surface.meetings() {
        if let [side] = sides {
            open[part[side.triangle as usize] as usize] = true;
        }
    }
    let Some(closed) = open.iter().position(|open| !open) else {
        return Ok(false);
    };
    if parts > 1 {
        let first = part
            .iter()
            .position(|&p| p as usize == closed)
            .unwrap_or_default();
        return Err(Fault::SeveralBodies {
            bodies: parts,
            face: surface.mesh.face_number(first),
        });
    }
    Ok(true)
}

/// A closed prism without its front face, facing the light.
fn opened(surface: &Surface<'_>, warnings: &mut Vec<String>) -> Result<Mesh, Fault> {
    if prism::volume(surface) < 0.0 {
        warnings.push("the closed mesh is wound inward: all faces were turned outward".to_owned());
        let outward = prism::flipped(surface.mesh);
        let surface = Surface::new(&outward);
        // Facets of a prism face outward, its corners are peaks there.
        let corner = Fans::new(&surface)
            .corners()
            .into_iter()
            .find(|corner| !corner.hollow);
        return prism::open(&surface, corner.as_ref());
    }
    let corner = Fans::new(surface)
        .corners()
        .into_iter()
        .find(|corner| !corner.hollow);
    prism::open(surface, corner.as_ref())
}

/// A hollow surface turned over, where it has peaks and no hollow corner; `None` where it already faces the light.
///
/// # Errors
/// [`Fault::MixedWinding`] where one part has hollow corners and another one only peaks.
fn facing_light(surface: &Surface<'_>, warnings: &mut Vec<String>) -> Result<Option<Mesh>, Fault> {
    let fans = Fans::new(surface);
    let corners = fans.corners();
    let hollow = corners.iter().filter(|corner| corner.hollow).count();
    if hollow == 0 && !corners.is_empty() {
        warnings.push(
            "all facets are wound clockwise seen from the light: the mesh was turned over"
                .to_owned(),
        );
        return Ok(Some(prism::flipped(surface.mesh)));
    }
    let (part, parts) = surface.parts();
    if parts > 1 && hollow < corners.len() {
        let mut seen = vec![(false, false); parts];
        let mut part_of = vec![0; surface.mesh.positions.len()];
        for (triangle, vertices) in surface.welded.iter().enumerate() {
            vertices
                .iter()
                .for_each(|&v| part_of[v as usize] = part[triangle]);
        }
        for corner in &corners {
            let seen = &mut seen[part_of[corner.vertex as usize] as usize];
            *seen = (seen.0 || corner.hollow, seen.1 || !corner.hollow);
        }
        if let Some(wrong) = seen.iter().position(|&(hollow, peak)| peak && !hollow) {
            let own = |&(_, &p): &(usize, &u32)| p as usize == wrong;
            let flipped = part.iter().enumerate().filter(own).count();
            let first = part
                .iter()
                .enumerate()
                .find(own)
                .map_or(0, |(triangle, _)| triangle);
            let (face, faces) = (surface.mesh.face_number(first), part.len());
            return Err(Fault::MixedWinding {
                face,
                flipped,
                faces,
            });
        }
    }
    Ok(None)
}

/// Origin, axes and unit of a cell, in the file's frame (positions relative to the mesh's origin).
struct Frame {
    apex: DVec3,
    axes: [DVec3; 3],
    edge_length: f64,
    azimuth_zero: DVec3,
}

impl Frame {
    fn direction(&self, v: DVec3) -> DVec3 {
        let [x, y, z] = self.axes.map(|axis| axis.dot(v / self.edge_length));
        DVec3::new(x, y, z)
    }

    fn point(&self, p: DVec3) -> DVec3 {
        self.direction(p - self.apex)
    }
}

fn placed(
    surface: &Surface<'_>,
    closed: bool,
    options: &CellOptions,
    mut warnings: Vec<String>,
) -> Result<Cell, Fault> {
    let mesh = surface.mesh;
    let lattice = options.lattice.or(mesh.lattice);
    let frame = frame(surface, lattice, options)?;
    let (largest, rounding) = (
        surface.rounding / f64::EPSILON,
        surface.rounding / frame.edge_length,
    );
    if rounding > DIGITS {
        return Err(Fault::DigitsLost {
            distance: largest / frame.edge_length,
            left: rounding,
        });
    }
    if rounding > DIGITS / 100.0 {
        warnings.push(format!("the file's coordinates are rounded to {rounding:.0e} edge lengths, so far is the cell away"));
    }
    let points: Vec<DVec3> = mesh.positions.iter().map(|&p| frame.point(p)).collect();
    let facets: Vec<[DVec3; 3]> = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| points[v as usize]))
        .collect();
    let entrance = match lattice {
        Some(lattice) => periodic_entrance(&frame, lattice, &facets, &mut warnings)?,
        None => rim_entrance(surface, &points, rounding)?,
    };
    Ok(Cell {
        facets,
        entrance,
        refractive_index: mesh.refractive_index.filter(|_| closed),
        closed,
        edge_length: frame.edge_length,
        azimuth_zero: frame.azimuth_zero,
        design: mesh.design.clone(),
        mesh_hash: mesh.hash.clone(),
        warnings,
    })
}

fn frame(
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
    let edge_length = options
        .edge_length
        .or(mesh.edge_length)
        .or(longest)
        .ok_or(Fault::NoApex)?;
    let azimuth_zero = options
        .azimuth_zero
        .or(legs.map(|legs| legs[0].along))
        .ok_or(Fault::NoApex)?;
    let origin = match apex {
        Some(apex) => apex.vertex,
        None => lowest(surface, normal),
    };
    let no_direction = || Fault::AzimuthZero {
        x: azimuth_zero.x,
        y: azimuth_zero.y,
        z: azimuth_zero.z,
    };
    let azimuth_zero = azimuth_zero.try_normalize().ok_or_else(no_direction)?;
    // Projected twice: once leaves 1e-16 over the length of what it leaves.
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
        azimuth_zero,
    })
}

/// First vertex of the lowest ones along `normal`: the origin of a cell without an apex.
fn lowest(surface: &Surface<'_>, normal: DVec3) -> u32 {
    let mut vertices: Vec<u32> = surface.welded.iter().flatten().copied().collect();
    vertices.sort_unstable();
    let height = |v: u32| normal.dot(surface.mesh.positions[v as usize]);
    vertices
        .into_iter()
        .min_by(|&a, &b| height(a).total_cmp(&height(b)))
        .unwrap_or_default()
}

/// Unit normal of the sheet towards the light: of the lattice, else of the rim.
fn normal(surface: &Surface<'_>, lattice: Option<[DVec3; 2]>) -> Result<DVec3, Fault> {
    let facing = surface.vector_area();
    let Some([a, b]) = lattice else {
        let first = surface.boundary().first().map_or(0, |edge| edge.0);
        let no_plane = Fault::RimNotPlanar {
            vertex: first as usize + 1,
            height: f64::INFINITY,
        };
        return facing.try_normalize().ok_or(no_plane);
    };
    let cross = a.cross(b);
    let sine = cross.length() / (a.length() * b.length());
    if !(a.is_finite() && b.is_finite() && sine > 1e-6) {
        return Err(Fault::LatticeDegenerate);
    }
    let normal = cross.normalize() * if cross.dot(facing) < 0.0 { -1.0 } else { 1.0 };
    let tilt = normal.angle_between(facing.normalize_or(normal));
    if tilt > LATTICE_TILT {
        return Err(Fault::LatticeTilted {
            degrees: tilt.to_degrees(),
        });
    }
    Ok(normal)
}

/// One lattice parallelogram at the height of the highest vertex, around the middle of the facets.
fn periodic_entrance(
    frame: &Frame,
    lattice: [DVec3; 2],
    facets: &[[DVec3; 3]],
    warnings: &mut Vec<String>,
) -> Result<Entrance, Fault> {
    let [a, b] = lattice.map(|v| frame.direction(v).truncate());
    let [a, b] = if a.perp_dot(b) < 0.0 { [b, a] } else { [a, b] };
    let height = facets
        .iter()
        .flatten()
        .map(|p| p.z)
        .fold(f64::NEG_INFINITY, f64::max);
    let (mut covered, mut moment) = (0.0, DVec2::ZERO);
    for [p, q, r] in facets.iter().map(|facet| facet.map(|p| p.truncate())) {
        let area = (q - p).perp_dot(r - p) / 2.0;
        covered += area;
        moment += (p + q + r) / 3.0 * area;
    }
    let middle = if covered > 0.0 {
        moment / covered
    } else {
        DVec2::ZERO
    };
    let period = a.perp_dot(b);
    let covered = covered / period;
    if covered > 1.0 + OVERFULL {
        return Err(Fault::LatticeOverfull { covered });
    }
    if (covered - 1.0).abs() > PLANAR {
        warnings.push(format!(
            "the facets cover {covered:.6} of the lattice cell: the rest is open"
        ));
    }
    let polygon = vec![
        middle - (a + b) / 2.0,
        middle + (a - b) / 2.0,
        middle + (a + b) / 2.0,
        middle + (b - a) / 2.0,
    ];
    Ok(Entrance {
        height,
        polygon,
        lattice: Some([a, b]),
    })
}

fn rim_entrance(surface: &Surface<'_>, points: &[DVec3], rounding: f64) -> Result<Entrance, Fault> {
    let rim = rim::vertices(surface)?;
    let at: Vec<DVec3> = rim.iter().map(|&vertex| points[vertex as usize]).collect();
    let used = || {
        surface
            .welded
            .iter()
            .flatten()
            .map(|&vertex| (vertex, points[vertex as usize]))
    };
    let extent = used().map(|(_, p)| p.length()).fold(1.0, f64::max);
    let tolerance = PLANAR * extent + 8.0 * rounding;
    let (height, polygon) = rim::polygon(&at, &rim, tolerance)?;
    if let Some((vertex, p)) = used()
        .max_by(|a, b| a.1.z.total_cmp(&b.1.z))
        .filter(|(_, p)| p.z > height + tolerance)
    {
        return Err(Fault::AboveRim {
            vertex: vertex as usize + 1,
            height: p.z - height,
        });
    }
    Ok(Entrance {
        height,
        polygon,
        lattice: None,
    })
}
