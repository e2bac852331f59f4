//! Normals at the corners of facets that stand for a curved face.
//!
//! A file may give each corner of a face a normal of its own (OBJ `vn`, glTF `NORMAL`): that of the
//! curved face which the flat facets approximate. They have no effect unless the user asks for them
//! ([`crate::CellOptions::file_normals`]), because programs write them for flat faces too, often
//! averaged over an edge.

use glam::DVec3;

use crate::cell::frame::Frame;
use crate::cell::rounding::RIGHT;
use crate::cell::surface::Surface;
use crate::mesh::error::Fault;

/// Angle within which normals count as equal, rad.
///
/// Files with four digits, as some programs write them, round each coordinate by 5e-5, and turn two
/// vectors against each other by up to 1.8e-4.
const SAME: f64 = 2e-4;

/// Normals at the corners of facets, unit length, within 90 degrees of the facet's front.
#[derive(Debug, Clone, PartialEq)]
pub struct Normals {
    /// Unit vectors, cell frame.
    pub vectors: Vec<DVec3>,
    /// For each facet, the indices of the vectors at its corners.
    pub corners: Vec<[u32; 3]>,
}

/// Returns the normals that the file of `surface` gives, in `frame`.
///
/// Facets without normals are planes. All normals may point to the front or all to the back,
/// because a reflection does not depend on their sign.
///
/// # Errors
/// Fails if there are no normals, if a facet has them at some corners only, if one is out of range
/// or has no direction, or if they are not all on one side.
pub(crate) fn of_file(
    surface: &Surface<'_>,
    frame: &Frame,
    warnings: &mut Vec<String>,
) -> Result<Normals, Fault> {
    let mesh = surface.mesh;
    if mesh.corner_normals.is_empty() {
        return Err(Fault::NoNormals);
    }
    // Scale first, because squares of a file's numbers might overflow.
    let unit = |n: DVec3| frame.direction(n / n.abs().max_element()).try_normalize();
    let given: Vec<Option<DVec3>> = mesh.normals.iter().map(|&n| unit(n)).collect();
    let mut vectors: Vec<DVec3> = given.iter().map(|n| n.unwrap_or(DVec3::Z)).collect();
    let mut corners = Vec::with_capacity(mesh.triangles.len());
    let mut planes = Vec::new();
    // Side and number of the first facet with normals, and whether any normal differs from its
    // facet's own.
    let mut first: Option<(bool, u32)> = None;
    let mut curved = false;
    for (triangle, numbers) in mesh.corner_normals.iter().enumerate() {
        let face = mesh.face_number(triangle);
        let own = frame
            .direction(surface.normals[triangle])
            .normalize_or_zero();
        let [Some(a), Some(b), Some(c)] = *numbers else {
            if numbers.iter().any(Option::is_some) {
                return Err(Fault::NormalMissing { face });
            }
            planes.push(triangle);
            corners.push([vectors.len() as u32; 3]);
            vectors.push(own);
            continue;
        };
        let indices = [a, b, c].map(|number| number.get() - 1);
        for index in indices {
            let normal = match given.get(index as usize) {
                None => {
                    let normals = given.len();
                    return Err(Fault::NormalOutOfRange { face, normals });
                }
                Some(normal) => normal.ok_or(Fault::NormalNoDirection { face })?,
            };
            let cosine = normal.dot(own);
            let (front, known) = *first.get_or_insert((cosine > 0.0, face));
            if cosine == 0.0 || front != (cosine > 0.0) {
                return Err(Fault::NormalBehind {
                    face,
                    degrees: cosine.clamp(-1.0, 1.0).acos().to_degrees(),
                    known,
                });
            }
        }
        let [a, b, c] = indices.map(|index| vectors[index as usize]);
        curved |= a != b || b != c || a.dot(own).abs() < SAME.cos();
        corners.push(indices);
    }
    let (front, _) = first.ok_or(Fault::NoNormals)?;
    if !front {
        vectors[..given.len()].iter_mut().for_each(|n| *n = -*n);
    }
    // Rounding turns a normal by up to half the diagonal of a cube of one step, and a reflection
    // turns light by twice as much; light meets three faces.
    let turn = 3.0 * 3_f64.sqrt() * mesh.normal_step;
    if curved && turn > 4.0 * RIGHT {
        warnings.push(format!(
            "the normals in the file are given in steps of {:.0e}, which turn light by up to {:.2} \
            mrad; write them with {} more digits",
            mesh.normal_step,
            1e3 * turn,
            (turn / (4.0 * RIGHT)).log10().ceil()
        ));
    }
    if !curved {
        warnings.push(
            "--normals file changes nothing: the normals in the file are those of the facets"
                .into(),
        );
    }
    if let Some(&plane) = planes.first() {
        warnings.push(format!(
            "{} of {} facets have no normals in the file and are planes (face {} is the first)",
            planes.len(),
            corners.len(),
            mesh.face_number(plane)
        ));
    }
    Ok(Normals { vectors, corners })
}

/// Returns a warning if the file has normals that differ from its facets' own and were not asked
/// for.
pub(crate) fn left_out(surface: &Surface<'_>) -> Option<String> {
    let mesh = surface.mesh;
    let sine = |triangle: usize, number: std::num::NonZeroU32| {
        let normal = *mesh.normals.get(number.get() as usize - 1)?;
        let unit = (normal / normal.abs().max_element()).try_normalize()?;
        Some(unit.cross(surface.normals[triangle]).length())
    };
    let numbers = mesh.corner_normals.iter().enumerate();
    let largest = numbers
        .flat_map(|(triangle, numbers)| {
            numbers
                .iter()
                .flatten()
                .filter_map(move |&number| sine(triangle, number))
        })
        .fold(0.0, f64::max);
    (largest > SAME).then(|| {
        format!(
            "the file has normals up to {:.2} degrees off its facets, which are taken as planes; \
            if they stand for a curved face, give --normals file",
            largest.min(1.0).asin().to_degrees()
        )
    })
}
