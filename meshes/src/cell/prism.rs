//! Closed prisms: removal of the front face, so that only the mirror facets are left, facing the
//! light.

use glam::DVec3;

use crate::cell::apex::Corner;
use crate::cell::surface::{Surface, root};
use crate::mesh::error::Fault;
use crate::mesh::mesh::Mesh;

/// Part of the mesh's extent to which the triangles of a front face are flat.
const FLAT: f64 = 1e-6;
/// Cosine of the greatest angle (53 deg) between a front face and the direction away from the apex.
///
/// It is more than any useful cant, and less than the 54.7 deg of the other faces of a block.
const OPPOSITE_COS: f64 = 0.6;
/// Angle below which neighbouring triangles belong to one face, rad.
const SMOOTH: f64 = 1e-4;

/// Returns the volume of a closed surface, file units cubed; positive if it is wound outward.
pub(crate) fn volume(surface: &Surface<'_>) -> f64 {
    let base = surface.mesh.positions[surface.welded[0][0] as usize];
    let sixth = |triangle| {
        let [a, b, c] = surface.mesh.corners(triangle).map(|p: DVec3| p - base);
        a.dot(b.cross(c)) / 6.0
    };
    (0..surface.welded.len()).map(sixth).sum()
}

/// Returns the mesh with every triangle wound the other way.
pub(crate) fn flipped(mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.triangles
        .iter_mut()
        .for_each(|triangle| triangle.swap(1, 2));
    mesh.corner_normals
        .iter_mut()
        .for_each(|numbers| numbers.swap(1, 2));
    mesh
}

/// Returns the first triangle of the flat face of each triangle.
///
/// Triangles that meet along a side without a bend belong to one face.
fn flat_faces(surface: &Surface<'_>) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..surface.welded.len() as u32).collect();
    for sides in surface.meetings() {
        if let [one, other] = sides {
            let (n, m) = (
                surface.normals[one.triangle as usize],
                surface.normals[other.triangle as usize],
            );
            if n.cross(m).length() < SMOOTH && n.dot(m) > 0.0 {
                let (a, b) = (
                    root(&mut parent, one.triangle),
                    root(&mut parent, other.triangle),
                );
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    (0..surface.welded.len() as u32)
        .map(|t| root(&mut parent, t))
        .collect()
}

/// Returns a warning about faces at right angles to the front, by their numbers, if there are any.
fn side_walls(faces: Vec<u32>) -> Option<String> {
    let first = faces.iter().min()?;
    Some(format!(
        "{} faces, the first of them face {first}, stand at right angles to the front, as the side \
        walls of a solid block do: here they are mirrors that a sheet does not have, and light that \
        meets them is lost. Delete them, and let the front end at the rim of the cell",
        faces.len()
    ))
}

/// Returns the mirror facets of a closed, outward-wound prism, turned to face the light inside it.
///
/// The front face is the largest flat face that has the whole prism behind it and looks away from
/// the apex `corner`. Without a corner it is the largest face with the whole prism behind it. Other
/// faces in its plane belong to it.
///
/// # Errors
/// Returns [`Fault::NoFrontFace`] if there is no such face.
pub(crate) fn open(
    surface: &Surface<'_>,
    corner: Option<&Corner>,
    warnings: &mut Vec<String>,
) -> Result<Mesh, Fault> {
    let mesh = surface.mesh;
    let face_of = flat_faces(surface);
    let mut area = vec![DVec3::ZERO; surface.welded.len()];
    for (triangle, &face) in face_of.iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle);
        area[face as usize] += (b - a).cross(c - a) * 0.5;
    }
    let used: Vec<u32> = surface.welded.iter().flatten().copied().collect();
    let base = mesh.positions[used[0] as usize];
    let extent = used
        .iter()
        .map(|&v| mesh.positions[v as usize].distance(base))
        .fold(0.0, f64::max);
    let mut faces: Vec<u32> = (0..surface.welded.len() as u32)
        .filter(|&t| face_of[t as usize] == t)
        .collect();
    faces.sort_by(|&a, &b| {
        area[b as usize]
            .length()
            .total_cmp(&area[a as usize].length())
            .then(a.cmp(&b))
    });
    let slack = FLAT * extent + 8.0 * surface.rounding;
    let front = faces.into_iter().find(|&face| {
        let normal = area[face as usize].normalize_or_zero();
        // The axis of the corner points out of the prism, away from the light.
        let opposite = corner.is_none_or(|corner| normal.dot(corner.axis) < -OPPOSITE_COS);
        let on = mesh.corners(face as usize)[0];
        let height = |v: u32| normal.dot(mesh.positions[v as usize] - on);
        let flat = || {
            let own = (0..face_of.len())
                .filter(|&t| face_of[t] == face)
                .flat_map(|t| surface.welded[t]);
            own.map(height).all(|h| h.abs() <= slack)
        };
        opposite && used.iter().all(|&v| height(v) <= slack) && flat()
    });
    let front = front.ok_or(Fault::NoFrontFace)?;
    // Take every triangle in this plane, because prisms that touch along an edge of it have a front
    // face each.
    let (normal, on) = (
        area[front as usize].normalize_or_zero(),
        mesh.corners(front as usize)[0],
    );
    let in_front = |triangle: usize| {
        let flat = mesh
            .corners(triangle)
            .iter()
            .all(|p| normal.dot(*p - on).abs() <= slack);
        flat && surface.normals[triangle].dot(normal) > 0.0
    };
    let kept: Vec<usize> = (0..face_of.len()).filter(|&t| !in_front(t)).collect();
    let walls = kept
        .iter()
        .filter(|&&t| surface.normals[t].dot(normal).abs() < SMOOTH);
    warnings.extend(side_walls(walls.map(|&t| mesh.face_number(t)).collect()));
    let triangles = kept
        .iter()
        .map(|&t| mesh.triangles[t])
        .map(|[a, b, c]| [a, c, b])
        .collect();
    let faces = kept.iter().map(|&t| mesh.face_number(t)).collect();
    let normals = kept.iter().filter_map(|&t| mesh.corner_normals.get(t));
    let corner_normals = normals.map(|&[a, b, c]| [a, c, b]).collect();
    Ok(Mesh {
        triangles,
        faces,
        corner_normals,
        ..mesh.clone()
    })
}
