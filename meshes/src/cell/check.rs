//! Faults of a mesh that no cell can have: each its own [`Fault`].

use std::collections::HashMap;

use crate::cell::surface::Surface;
use crate::mesh::error::Fault;
use crate::mesh::mesh::Mesh;

/// Smallest and largest extent that is accepted, file units: squares of lengths stay far from
/// under- and overflow.
pub(crate) const EXTENT: (f64, f64) = (1e-60, 1e60);
/// A triangle is degenerate where its height is below this part of its longest edge: its normal has
/// then lost all but four digits, and a mirror without a normal reflects nowhere.
pub(crate) const THIN: f64 = 1e-12;

/// Checks that there are triangles, that vertices are finite and indices in range, and that squares
/// do not overflow.
///
/// # Errors
/// [`Fault::Empty`], [`Fault::IndexOutOfRange`], [`Fault::NotFinite`], [`Fault::Extent`].
pub(crate) fn vertices(mesh: &Mesh) -> Result<(), Fault> {
    if mesh.triangles.is_empty() {
        return Err(Fault::Empty);
    }
    let vertices = mesh.positions.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= vertices) {
            let (face, vertex) = (mesh.face_number(triangle), u64::from(vertex) + 1);
            return Err(Fault::IndexOutOfRange {
                face,
                vertex,
                vertices,
            });
        }
    }
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(Fault::NotFinite { vertex: vertex + 1 });
    }
    let base = mesh.positions[mesh.triangles[0][0] as usize];
    let used = mesh
        .triangles
        .iter()
        .flatten()
        .map(|&vertex| mesh.positions[vertex as usize]);
    let extent = used
        .map(|p| (p - base).abs().max_element())
        .fold(0.0, f64::max);
    // All vertices in one point: the first face says it better.
    if extent != 0.0 && !(EXTENT.0..=EXTENT.1).contains(&extent) {
        return Err(Fault::Extent {
            extent,
            least: EXTENT.0,
            most: EXTENT.1,
        });
    }
    Ok(())
}

/// Checks triangles and edges: degenerate, duplicate or coincident faces, edges of more than two
/// faces, winding.
///
/// A surface wound consistently passes, whichever side it faces.
///
/// # Errors
/// [`Fault::DegenerateFace`], [`Fault::DuplicateFace`], [`Fault::CoincidentFace`],
/// [`Fault::NonManifoldEdge`], [`Fault::MixedWinding`], [`Fault::OneSided`]; the first in the order
/// of the file, by kind in this order.
pub(crate) fn surface(surface: &Surface<'_>) -> Result<(), Fault> {
    degenerate(surface)?;
    duplicate(surface)?;
    non_manifold(surface)?;
    winding(surface)
}

fn degenerate(surface: &Surface<'_>) -> Result<(), Fault> {
    for (triangle, &[i, j, k]) in surface.welded.iter().enumerate() {
        let [a, b, c] = surface.mesh.corners(triangle);
        let edge = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let height = if edge > 0.0 {
            ((b - a) / edge).cross((c - a) / edge).length() * edge
        } else {
            0.0
        };
        if i == j || j == k || k == i || height <= THIN * edge + 2.0 * surface.rounding {
            return Err(Fault::DegenerateFace {
                face: surface.mesh.face_number(triangle),
                height,
                edge,
            });
        }
    }
    Ok(())
}

fn duplicate(surface: &Surface<'_>) -> Result<(), Fault> {
    let mut seen: HashMap<[u32; 3], (usize, bool)> = HashMap::with_capacity(surface.welded.len());
    for (triangle, &[i, j, k]) in surface.welded.iter().enumerate() {
        let mut sorted = [i, j, k];
        sorted.sort_unstable();
        // Three distinct numbers run upwards in one or in two of their cyclic steps: that tells the
        // two sides apart.
        let even = [(i, j), (j, k), (k, i)]
            .iter()
            .filter(|(a, b)| a < b)
            .count()
            == 2;
        if let Some((first, first_even)) = seen.insert(sorted, (triangle, even)) {
            let (face, first) = (
                surface.mesh.face_number(triangle),
                surface.mesh.face_number(first),
            );
            return Err(if even == first_even {
                Fault::DuplicateFace { face, first }
            } else {
                Fault::CoincidentFace { face, first }
            });
        }
    }
    Ok(())
}

/// Closed bodies may touch along an edge (two prisms with a front face each): two faces each, wound
/// against each other.
fn non_manifold(surface: &Surface<'_>) -> Result<(), Fault> {
    let closed = surface.meetings().all(|sides| sides.len() > 1);
    for sides in surface.meetings() {
        let touching =
            closed && sides.len() == 4 && sides.iter().filter(|side| side.ascending).count() == 2;
        if sides.len() > 2 && !touching {
            let face = surface
                .mesh
                .face_number(sides[sides.len() - 1].triangle as usize);
            let (a, b) = (sides[0].low as usize + 1, sides[0].high as usize + 1);
            return Err(Fault::NonManifoldEdge {
                a,
                b,
                faces: sides.len(),
                face,
            });
        }
    }
    Ok(())
}

/// Spreads the winding of each part's first triangle over the part; the smaller party is the
/// flipped one.
fn winding(surface: &Surface<'_>) -> Result<(), Fault> {
    let agree = surface
        .meetings()
        .all(|sides| sides.len() != 2 || sides[0].ascending != sides[1].ascending);
    if agree {
        return Ok(());
    }
    let faces = surface.welded.len();
    let mut neighbours: Vec<Vec<(u32, bool)>> = vec![Vec::new(); faces];
    for sides in surface.meetings() {
        if let [one, other] = sides {
            let opposed = one.ascending == other.ascending;
            neighbours[one.triangle as usize].push((other.triangle, opposed));
            neighbours[other.triangle as usize].push((one.triangle, opposed));
        }
    }
    let mut flipped: Vec<Option<bool>> = vec![None; faces];
    for start in 0..faces {
        if flipped[start].is_some() {
            continue;
        }
        flipped[start] = Some(false);
        let mut part = vec![start];
        let mut reached = 0;
        while reached < part.len() {
            let here = part[reached];
            reached += 1;
            for &(there, opposed) in &neighbours[here] {
                let expected = flipped[here].map(|f| f != opposed);
                match flipped[there as usize] {
                    None => {
                        flipped[there as usize] = expected;
                        part.push(there as usize);
                    }
                    known if known != expected => {
                        return Err(Fault::OneSided {
                            face: surface.mesh.face_number(there as usize),
                        });
                    }
                    _ => {}
                }
            }
        }
        let against = part.iter().filter(|&&t| flipped[t] == Some(true)).count();
        if against > 0 {
            let minority = 2 * against <= part.len();
            let wrong = part
                .iter()
                .filter(|&&t| flipped[t] == Some(minority))
                .min()
                .copied()
                .unwrap_or(start);
            let count = if minority {
                against
            } else {
                part.len() - against
            };
            let face = surface.mesh.face_number(wrong);
            return Err(Fault::MixedWinding {
                face,
                flipped: count,
                faces: part.len(),
            });
        }
    }
    Ok(())
}
