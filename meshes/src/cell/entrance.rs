//! Entrance of rays: the rim of a cell, or one parallelogram of its lattice.

use glam::{DVec2, DVec3};

use crate::cell::cell::Entrance;
use crate::cell::frame::Frame;
use crate::cell::rim;
use crate::cell::surface::Surface;
use crate::mesh::error::Fault;

/// Part of the cell's extent to which a rim must be planar and no vertex above it; f32 files round
/// to 6e-8.
pub(crate) const PLANAR: f64 = 1e-6;
/// Part of the lattice cell by which facets may cover more than it, for lattice vectors typed with
/// few digits.
const OVERFULL: f64 = 1e-3;

/// Returns one lattice parallelogram at the height of the highest vertex, around the middle of the
/// facets.
///
/// `lattice` is in file units and frame, `facets` in the cell frame. If cubes leave gaps, a warning
/// says so.
///
/// # Errors
/// Returns [`Fault::LatticeOverfull`] if the facets cover more than one lattice cell.
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
    // The area of a closed surface is only rounding.
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
    // An element that is no sheet of cubes may well be open beside its facets.
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

/// Returns the polygon of a planar rim.
///
/// `points` are the mesh's vertices in the cell frame. `rounding` is that of the file's
/// coordinates, edge lengths.
///
/// # Errors
/// Fails if there is more than one rim, or if the rim is not planar, crosses itself, or is not the
/// highest part of the cell.
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

/// Returns the entrance with a lattice. Without one, the sides of its parallelogram are the lattice
/// vectors.
///
/// # Errors
/// Returns [`Fault::NotPeriodic`] if there is no lattice and the rim is no parallelogram.
pub(crate) fn tiled(entrance: Entrance) -> Result<Entrance, Fault> {
    if entrance.lattice.is_some() {
        return Ok(entrance);
    }
    let rim = &entrance.polygon;
    let extent = rim.iter().map(|p| p.length()).fold(1.0, f64::max);
    let corners: Vec<DVec2> = (0..rim.len())
        .filter(|&k| {
            let (before, after) = (
                rim[(k + rim.len() - 1) % rim.len()],
                rim[(k + 1) % rim.len()],
            );
            let along = (after - before).normalize_or_zero();
            along.perp_dot(rim[k] - before).abs() > PLANAR * extent
        })
        .map(|k| rim[k])
        .collect();
    match corners[..] {
        [a, b, c, d] if (a + c - b - d).length() <= PLANAR * extent => Ok(Entrance {
            lattice: Some([b - a, d - a]),
            ..entrance
        }),
        _ => Err(Fault::NotPeriodic {
            corners: corners.len(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rim(corners: &[[f64; 2]]) -> Entrance {
        Entrance {
            height: 0.5,
            polygon: corners.iter().map(|&p| p.into()).collect(),
            lattice: None,
        }
    }

    /// A parallelogram has its sides for lattice vectors, also with corners along its sides.
    #[test]
    fn a_parallelogram_is_one_period() {
        let plain = rim(&[[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [1.0, 1.0]]);
        let expected = Some([DVec2::new(2.0, 0.0), DVec2::new(1.0, 1.0)]);
        assert_eq!(tiled(plain.clone()).unwrap().lattice, expected);
        assert_eq!(tiled(plain.clone()).unwrap().polygon, plain.polygon);
        let more = rim(&[
            [0.0, 0.0],
            [0.7, 0.0],
            [2.0, 0.0],
            [3.0, 1.0],
            [1.0, 1.0],
            [0.5, 0.5],
        ]);
        assert_eq!(tiled(more).unwrap().lattice, expected);
        let own = Entrance {
            lattice: Some([DVec2::X, DVec2::Y]),
            ..rim(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        };
        assert_eq!(tiled(own.clone()).unwrap(), own);
    }

    /// A triangle, a trapezium and a hexagon are no periods.
    #[test]
    fn other_rims_are_refused_by_their_corners() {
        let trapezium = [[0.0, 0.0], [2.0, 0.0], [1.5, 1.0], [0.5, 1.0]];
        let triangle = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let side = 0.75_f64.sqrt();
        let hexagon = [
            [1.0, 0.0],
            [0.5, side],
            [-0.5, side],
            [-1.0, 0.0],
            [-0.5, -side],
            [0.5, -side],
        ];
        for corners in [&triangle[..], &trapezium, &hexagon] {
            let fault = tiled(rim(corners)).unwrap_err();
            let expected = format!("a rim of {} corners", corners.len());
            assert!(fault.to_string().contains(&expected), "{fault}");
        }
    }
}
