//! Rim of an open surface: the only loop of its boundary.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use crate::cell::surface::Surface;
use crate::mesh::error::Fault;
use crate::mesh::polygon;

/// Most corners of a rim that is tested for crossing itself, because the test is quadratic.
const MAX_TESTED_CORNERS: usize = 4096;

/// Returns the rim's welded vertices in order, with the surface on their left seen from the light.
///
/// # Errors
/// Returns [`Fault::SeveralRims`] if there are holes or several parts, and [`Fault::RimCrossed`] if
/// parts touch in a vertex.
pub(crate) fn vertices(surface: &Surface<'_>) -> Result<Vec<u32>, Fault> {
    let boundary = surface.boundary();
    let mut next: HashMap<u32, u32> = HashMap::with_capacity(boundary.len());
    let mut starts: Vec<u32> = Vec::with_capacity(boundary.len());
    for &(from, to) in &boundary {
        if next.insert(from, to).is_some() {
            return Err(Fault::RimCrossed {
                vertex: from as usize + 1,
            });
        }
        starts.push(from);
    }
    starts.sort_unstable();
    let mut rims: Vec<Vec<u32>> = Vec::new();
    for start in starts {
        if next.contains_key(&start) {
            rims.push(walk(&mut next, start));
        }
    }
    if let Some(second) = rims.get(1) {
        return Err(Fault::SeveralRims {
            loops: rims.len(),
            vertex: second[0] as usize + 1,
        });
    }
    Ok(rims.into_iter().next().unwrap_or_default())
}

/// Removes the loop that begins at `start` from `next`, and returns its vertices.
fn walk(next: &mut HashMap<u32, u32>, start: u32) -> Vec<u32> {
    let mut path = vec![start];
    let mut here = start;
    while let Some(to) = next.remove(&here) {
        if to == start {
            break;
        }
        path.push(to);
        here = to;
    }
    path
}

/// Returns entrance height and polygon of a rim.
///
/// `points` are the rim's vertices in the cell frame, and `vertices` their numbers. The height is
/// that of the highest rim vertex. Corners on a straight line (to 1e-12 edge lengths) are left out.
///
/// # Errors
/// Returns [`Fault::RimNotPlanar`] if a vertex is more than `tolerance` (edge lengths) off the
/// plane, and [`Fault::RimCrossed`] if the rim crosses or touches itself.
pub(crate) fn polygon(
    points: &[DVec3],
    vertices: &[u32],
    tolerance: f64,
) -> Result<(f64, Vec<DVec2>), Fault> {
    let mean = points.iter().map(|p| p.z).sum::<f64>() / points.len() as f64;
    let worst = (0..points.len())
        .max_by(|&a, &b| f64::total_cmp(&(points[a].z - mean).abs(), &(points[b].z - mean).abs()));
    if let Some(worst) = worst.filter(|&worst| (points[worst].z - mean).abs() > tolerance) {
        return Err(Fault::RimNotPlanar {
            vertex: vertices[worst] as usize + 1,
            height: points[worst].z - mean,
        });
    }
    let height = points.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let flat: Vec<DVec2> = points.iter().map(|p| p.truncate()).collect();
    let mut kept: Vec<usize> = Vec::with_capacity(flat.len());
    for (index, &here) in flat.iter().enumerate() {
        let before = kept.last().map_or(flat[flat.len() - 1], |&k| flat[k]);
        let after = flat[(index + 1) % flat.len()];
        let chord = after - before;
        let off = chord.perp_dot(here - before).abs();
        if off > 1e-12 * chord.length() || (here - before).dot(chord) < 0.0 {
            kept.push(index);
        }
    }
    let corners: Vec<DVec2> = kept.iter().map(|&k| flat[k]).collect();
    let tested = if corners.len() <= MAX_TESTED_CORNERS {
        polygon::first_crossing(&corners)
    } else {
        None
    };
    if let Some(edge) = tested {
        return Err(Fault::RimCrossed {
            vertex: vertices[kept[edge]] as usize + 1,
        });
    }
    Ok((height, corners))
}
