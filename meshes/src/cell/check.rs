//! Faults of a mesh that no cell may have: each its own [`Fault`].

use std::collections::HashMap;

use crate::cell::surface::Surface;
use crate::mesh::error::Fault;
use crate::mesh::mesh::Mesh;

/// Smallest and largest extent that is accepted, file units.
///
/// Squares of lengths then stay far from underflow and overflow.
pub(crate) const EXTENT: (f64, f64) = (1e-60, 1e60);
/// Ratio of height to longest edge below which a triangle is degenerate.
///
/// Its normal has then lost all but four digits, and without a normal a mirror has no direction of
/// reflection.
pub(crate) const THIN: f64 = 1e-12;

/// Checks that there are triangles, that vertices are finite, that indices are in range, and that
/// squares do not overflow.
///
/// # Errors
/// Returns [`Fault::Empty`] without triangles, [`Fault::IndexOutOfRange`] or [`Fault::NotFinite`]
/// for a wrong index or vertex, and [`Fault::Extent`] for an extent outside of [`EXTENT`].
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
    // If all vertices are in one point, the fault of the first face explains it better.
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
/// A surface that is wound consistently passes, whichever side it faces.
///
/// # Errors
/// Returns the first fault in the order of the file. Kinds are tried in this order:
/// [`Fault::DegenerateFace`], [`Fault::DuplicateFace`] or [`Fault::CoincidentFace`],
/// [`Fault::NonManifoldEdge`], [`Fault::MixedWinding`] or [`Fault::OneSided`].
pub(crate) fn surface(surface: &Surface<'_>) -> Result<(), Fault> {
    degenerate(surface)?;
    duplicate(surface)?;
    non_manifold(surface)?;
    winding(surface)
}

/// Checks that no triangle is degenerate.
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

/// Checks that no two triangles have the same three vertices.
fn duplicate(surface: &Surface<'_>) -> Result<(), Fault> {
    let mut seen: HashMap<[u32; 3], (usize, bool)> = HashMap::with_capacity(surface.welded.len());
    for (triangle, &[i, j, k]) in surface.welded.iter().enumerate() {
        let mut sorted = [i, j, k];
        sorted.sort_unstable();
        // Three distinct numbers ascend in one or in two of their cyclic steps. This tells the two
        // sides apart.
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

/// Checks that no edge belongs to more than two faces.
///
/// Closed bodies may touch along an edge (two prisms with a front face each). The edge then has two
/// faces of each body, wound against each other.
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

/// Checks that neighbouring triangles are wound alike.
///
/// The winding of each part's first triangle is spread over the part. If some triangles disagree,
/// the smaller group counts as flipped.
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
