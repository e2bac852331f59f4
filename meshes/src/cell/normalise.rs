//! Normalisation: from a mesh in file units to a cell in its own frame.

use std::path::Path;

use glam::DVec3;

use crate::cell::apex::Fans;
use crate::cell::cell::Cell;
use crate::cell::cell::CellOptions;
use crate::cell::check;
use crate::cell::entrance;
use crate::cell::frame::Frame;
use crate::cell::normals;
use crate::cell::prism;
use crate::cell::rounding;
use crate::cell::surface::Surface;
use crate::files::load::load;
use crate::mesh::error::{Error, Fault};
use crate::mesh::mesh::Mesh;

/// Greatest rounding of coordinates, edge lengths; a hundredth of it gives a warning.
const DIGITS: f64 = 1e-6;

/// Loads a mesh file with [`load`] and normalises it with [`normalise`].
///
/// # Errors
/// Returns the errors of [`load`] and of [`normalise`].
pub fn load_cell(path: &Path, options: &CellOptions) -> Result<Cell, Error> {
    normalise(&load(path)?, path, options)
}

/// Checks a mesh and brings it into the cell frame, with edge length 1.
///
/// Nothing is snapped or straightened: facets are the file's vertices minus the apex, divided by
/// the edge length, and turned into the frame. Accuracy: the rounding of the file's coordinates
/// (2e-16 of the largest, file units) over the edge length, and 4e-16 of the cell's extent.
///
/// `path` appears in messages only.
///
/// # Errors
/// Returns an [`Error`] with the [`Fault`] if the mesh's faces, its rim, its lattice or the options
/// are wrong.
pub fn normalise(mesh: &Mesh, path: &Path, options: &CellOptions) -> Result<Cell, Error> {
    cell(mesh, options).map_err(|fault| Error::new(path, fault))
}

/// Checks a mesh, turns it to the light and places it in the cell frame.
fn cell(mesh: &Mesh, options: &CellOptions) -> Result<Cell, Fault> {
    if let Some(edge_length) = options.edge_length.filter(|e| !(e.is_finite() && *e > 0.0)) {
        return Err(Fault::EdgeLength { edge_length });
    }
    check::vertices(mesh)?;
    let surface = Surface::new(mesh);
    check::surface(&surface)?;
    let mut warnings = Vec::new();
    if options.glass {
        if mesh.glass.is_empty() {
            return Err(Fault::NoGlass);
        }
        return placed(&surface, false, options, warnings);
    }
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

/// Returns whether the surface has no boundary; it must then be one body.
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

/// Returns a closed prism without its front face, facing the light.
fn opened(surface: &Surface<'_>, warnings: &mut Vec<String>) -> Result<Mesh, Fault> {
    if prism::volume(surface) < 0.0 {
        warnings.push("the closed mesh is wound inward: all faces were turned outward".to_owned());
        let outward = prism::flipped(surface.mesh);
        let surface = Surface::new(&outward);
        // The facets of a prism face outward, so its corners are peaks there.
        let corner = Fans::new(&surface)
            .corners()
            .into_iter()
            .find(|corner| !corner.hollow);
        return prism::open(&surface, corner.as_ref(), warnings);
    }
    let corner = Fans::new(surface)
        .corners()
        .into_iter()
        .find(|corner| !corner.hollow);
    prism::open(surface, corner.as_ref(), warnings)
}

/// Turns a hollow surface over if it has peaks and no hollow corner.
///
/// Returns `None` if it already faces the light.
///
/// # Errors
/// Returns [`Fault::MixedWinding`] if one part has hollow corners and another part has only peaks.
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

/// Places an open surface that faces the light in the cell frame.
fn placed(
    surface: &Surface<'_>,
    closed: bool,
    options: &CellOptions,
    mut warnings: Vec<String>,
) -> Result<Cell, Fault> {
    let mesh = surface.mesh;
    let lattice = options.lattice.or(mesh.lattice);
    let frame = Frame::of(surface, lattice, options)?;
    if let Some(edge_length) = options.edge_length {
        let extent = extent(&mesh.positions);
        // A cell of a millionth of an edge, or of a million edges, is in a wrong unit.
        if !(1e-6..=1e6).contains(&(extent / edge_length)) {
            return Err(Fault::EdgeLengthScale {
                edge_length,
                extent,
            });
        }
        warnings.extend(other_edge_length(edge_length, frame.found_edge_length));
    }
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
        warnings.push(format!(
            "the mesh lies so far from the origin that its coordinates are rounded to \
            {rounding:.0e} edge lengths; move it to the origin"
        ));
    }
    let points: Vec<DVec3> = mesh.positions.iter().map(|&p| frame.point(p)).collect();
    let facets: Vec<[DVec3; 3]> = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| points[v as usize]))
        .collect();
    let entrance = match lattice {
        Some(lattice) => entrance::periodic(&frame, lattice, &facets, &mut warnings)?,
        None => entrance::rim(surface, &points, rounding)
            .map_err(|fault| rounding::of_rim(fault, surface, &frame, entrance::PLANAR))?,
    };
    let entrance = match options.periodic {
        true => entrance::tiled(entrance)?,
        false => entrance,
    };
    let normals = if options.file_normals {
        Some(normals::of_file(surface, &frame, &mut warnings)?)
    } else {
        // Facets that stand for curved faces, and surfaces of glass, need no right angles.
        warnings.extend(rounding::bent(surface).filter(|_| !options.glass));
        warnings.extend(normals::left_out(surface));
        None
    };
    Ok(Cell {
        facets,
        normals,
        glass: match options.glass {
            true => (0..mesh.triangles.len())
                .map(|t| mesh.is_glass(t))
                .collect(),
            false => Vec::new(),
        },
        entrance,
        refractive_index: match mesh.hollow {
            true => Some(1.0),
            false => mesh.refractive_index.filter(|_| closed),
        },
        abbe_number: mesh.abbe_number.filter(|_| closed),
        closed,
        edge_length: frame.edge_length,
        edge_length_from: frame.edge_length_from,
        unit: None,
        azimuth_zero: frame.azimuth_zero,
        design: mesh.design.clone(),
        mesh_hash: mesh.hash.clone(),
        warnings,
    })
}

/// Returns a warning if the mesh has another edge length than the one that was given.
///
/// Edges of cubes with other angles, or cut ones, are a few per cent longer or shorter than the
/// user's unit. A wrong unit or a slip is off by more.
fn other_edge_length(given: f64, found: Option<f64>) -> Option<String> {
    const MOST: f64 = 1.1;
    let found = found.filter(|found| !(1.0 / MOST..=MOST).contains(&(found / given)))?;
    Some(format!(
        "--edge-length is {given}, but that of the mesh is {found:.6}: all shifts of the table are \
        in units of {given}, and so is the corner size c of estimates"
    ))
}

/// Returns the greatest side of the box around the points.
fn extent(points: &[DVec3]) -> f64 {
    let least = points.iter().copied().reduce(DVec3::min);
    let most = points.iter().copied().reduce(DVec3::max);
    least.zip(most).map_or(0.0, |(a, b)| (b - a).max_element())
}
