//! Where rays enter: the rim of a cell, or one parallelogram of its lattice.

use glam::{DVec2, DVec3};

use crate::cell::cell::Entrance;
use crate::cell::frame::Frame;
use crate::cell::rim;
use crate::cell::surface::Surface;
use crate::mesh::error::Fault;

/// A rim is planar, and no vertex above it, to this part of the cell's extent (f32 files round to
/// 6e-8 of it).
pub(crate) const PLANAR: f64 = 1e-6;
/// Facets may cover more than their lattice cell by this part of it: lattice vectors typed with few
/// digits.
const OVERFULL: f64 = 1e-3;

/// One lattice parallelogram at the height of the highest vertex, around the middle of the facets.
///
/// `lattice` is in file units and frame, `facets` in the cell frame. A warning tells of cubes that
/// leave gaps.
///
/// # Errors
/// [`Fault::LatticeOverfull`].
pub(crate) fn periodic(
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
    // A closed surface covers nothing but rounding.
    let middle = if covered > 1e-9 * a.perp_dot(b) {
        moment / covered
    } else {
        DVec2::ZERO
    };
    let period = a.perp_dot(b);
    let covered = covered / period;
    if covered > 1.0 + OVERFULL {
        return Err(Fault::LatticeOverfull { covered });
    }
    // Of an element that is no sheet of cubes the rest may well be open.
    if frame.has_apex && (covered - 1.0).abs() > PLANAR {
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

/// The polygon of a planar rim.
///
/// `points` are the mesh's vertices in the cell frame, `rounding` that of the file's coordinates,
/// edge lengths.
///
/// # Errors
/// More than one rim, or one that is not planar, crosses itself or is not the highest part of the
/// cell.
pub(crate) fn rim(
    surface: &Surface<'_>,
    points: &[DVec3],
    rounding: f64,
) -> Result<Entrance, Fault> {
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
