//! What the digits of a file may have changed: right angles between facets, and a planar rim.

use glam::DVec3;

use crate::cell::frame::Frame;
use crate::cell::surface::Surface;
use crate::mesh::error::Fault;

/// Error of a right angle, rad, up to which light does not notice it: it leaves within 2e-5 rad of
/// straight back, and `bake` takes the angle as a right one.
pub(crate) const RIGHT: f64 = 5e-6;

/// Greatest sine of the error of an angle that was meant to be a right one (5.7 deg), as for the
/// facets of a corner.
const MEANT: f64 = 0.1;

/// Most triangles of which all pairs are compared, because this takes the square of their number.
///
/// Of more triangles, those that share an edge are compared. All pairs matter where facets of a
/// cube do not touch, as in worn cubes.
const ALL_PAIRS: usize = 512;

/// Part of the largest triangle's area below which a triangle is left out: it meets little light.
///
/// The smallest facets of worn edges stand at all angles, and f32 turns them by 0.2 mrad.
const SMALL: f64 = 0.01;

/// Pair of triangles that may have been at right angles before their coordinates were rounded.
#[derive(Debug, Clone, Copy)]
struct Bent {
    pair: [usize; 2],
    /// Error of the right angle, rad.
    error: f64,
    /// Largest error that rounding can cause, rad.
    possible: f64,
}

/// Returns a warning if facets miss a right angle by no more than the rounding of their coordinates
/// can cause, and by so much that light notices it.
pub(crate) fn bent(surface: &Surface<'_>) -> Option<String> {
    if surface.mesh.steps.is_empty() {
        return None;
    }
    let count = surface.welded.len();
    let area = |triangle: usize| doubled_area(surface, triangle);
    let least = SMALL * (0..count).map(area).fold(0.0, f64::max);
    let mut worst: Option<Bent> = None;
    let mut most = 0.0_f64;
    let mut compare = |one: usize, other: usize| {
        let large = area(one).min(area(other)) >= least;
        if let Some(found) = compared(surface, [one, other]).filter(|_| large) {
            most = most.max(found.possible);
            if worst.is_none_or(|known| found.error > known.error) {
                worst = Some(found);
            }
        }
    };
    if count <= ALL_PAIRS {
        (0..count).for_each(|one| (0..one).for_each(|other| compare(other, one)));
    } else {
        for sides in surface.meetings() {
            for pair in sides.windows(2) {
                compare(pair[0].triangle as usize, pair[1].triangle as usize);
            }
        }
    }
    let Bent { pair, error, .. } = worst?;
    let step = coarsest(surface, pair);
    let digits = (most / RIGHT).log10().ceil().max(1.0);
    let [one, other] = pair.map(|triangle| surface.mesh.face_number(triangle));
    Some(format!(
        "faces {one} and {other} miss a right angle by {:.2} mrad, which the rounding of their \
        coordinates (in steps of {step:.0e} file units) can cause, and light goes elsewhere by it: \
        if the angle should be a right one, write the mesh with {digits} more digits (steps of \
        {:.0e})",
        1e3 * error,
        step * 10_f64.powf(-digits)
    ))
}

/// Returns what rounding may have done to the angle between two triangles, if it explains that the
/// angle is not a right one.
fn compared(surface: &Surface<'_>, pair: [usize; 2]) -> Option<Bent> {
    let [n, m] = pair.map(|triangle| surface.normals[triangle]);
    let sine = n.dot(m).abs();
    if !(RIGHT..MEANT).contains(&sine) {
        return None;
    }
    let possible = tilt(surface, pair[0], m) + tilt(surface, pair[1], n);
    let error = sine.asin();
    (error <= possible).then_some(Bent {
        pair,
        error,
        possible,
    })
}

/// Returns how far rounding can tilt a triangle towards `other`, rad, to first order.
///
/// A corner that moves by h along the normal turns the normal by h / height about the opposite
/// side.
fn tilt(surface: &Surface<'_>, triangle: usize, other: DVec3) -> f64 {
    let [a, b, c] = surface.mesh.corners(triangle);
    let normal = surface.normals[triangle];
    let doubled = doubled_area(surface, triangle);
    let sides = [c - b, a - c, b - a];
    let turns = surface.mesh.triangles[triangle].iter().zip(sides);
    turns
        .map(|(&vertex, side)| {
            reach(surface, vertex, normal) * (normal.cross(side) / doubled).dot(other).abs()
        })
        .sum()
}

/// Returns twice the area of a triangle, square file units.
fn doubled_area(surface: &Surface<'_>, triangle: usize) -> f64 {
    let [a, b, c] = surface.mesh.corners(triangle);
    (b - a).cross(c - a).length()
}

/// Returns how far rounding can move a vertex along `normal`, file units: half a step on each axis.
fn reach(surface: &Surface<'_>, vertex: u32, normal: DVec3) -> f64 {
    let steps = surface.mesh.steps.get(vertex as usize);
    0.5 * steps.map_or(0.0, |steps| normal.abs().dot(*steps))
}

/// Returns the coarsest step of the corners of these triangles, file units.
fn coarsest(surface: &Surface<'_>, triangles: impl IntoIterator<Item = usize>) -> f64 {
    let corners = triangles
        .into_iter()
        .flat_map(|triangle| surface.mesh.triangles[triangle]);
    corners
        .filter_map(|vertex| surface.mesh.steps.get(vertex as usize))
        .map(|steps| steps.max_element())
        .fold(0.0, f64::max)
}

/// Returns the fault of a rim that rounding can have moved out of its plane as one of too few
/// digits, and any other fault as it is.
///
/// A vertex moves by up to its reach; the plane, which goes through vertices that are rounded
/// alike, by as much; and its tilt does that again to both. `planar` is the distance from the plane
/// that is accepted, edge lengths.
pub(crate) fn of_rim(fault: Fault, surface: &Surface<'_>, frame: &Frame, planar: f64) -> Fault {
    let (Fault::RimNotPlanar { vertex, height } | Fault::AboveRim { vertex, height }) = fault
    else {
        return fault;
    };
    let used = surface.welded.iter().flatten();
    let moved = used.map(|&vertex| reach(surface, vertex, frame.axes[2]));
    let possible = 4.0 * moved.fold(0.0, f64::max) / frame.edge_length;
    if height.abs() > possible {
        return fault;
    }
    Fault::RimRounded {
        vertex,
        height,
        step: coarsest(surface, 0..surface.welded.len()),
        digits: (possible / planar).log10().ceil().max(1.0) as u32,
    }
}
