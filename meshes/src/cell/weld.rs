//! Welding: finding the vertices that are one point.
//!
//! Exporters repeat a vertex for every face that has its own normal. Welding serves topology only.
//! Facets keep the positions of the file, so that welding does not round away a dihedral error of
//! 1e-9.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::DVec3;

use crate::mesh::mesh::Mesh;

/// Part of the median triangle's longest edge within which two vertices are one, besides the
/// rounding of their coordinates.
///
/// f32 files place the two sides of a shared edge to 1e-7 of it.
pub(crate) const TOLERANCE: f64 = 2e-7;

/// Returns the first of the vertices with which each vertex coincides.
///
/// A vertex that no triangle uses is returned itself. A vertex joins the first representative
/// within `tolerance` (file units). Representatives do not move, so a chain of close vertices does
/// not collapse. The expected time is linear in the number of vertices.
pub(crate) fn weld(mesh: &Mesh, tolerance: f64) -> Vec<u32> {
    let mut used = vec![false; mesh.positions.len()];
    for &vertex in mesh.triangles.iter().flatten() {
        used[vertex as usize] = true;
    }
    // This gives about twice as many cells to look into as vertices, and at most some 500
    // representatives in one cell.
    let cell = (tolerance * 8.0).max(f64::MIN_POSITIVE);
    let key = |p: DVec3| (p / cell).floor().to_array().map(|x| x as i64);
    let mut first_in: HashMap<[i64; 3], u32> = HashMap::with_capacity(mesh.positions.len());
    let mut next_in = vec![u32::MAX; mesh.positions.len()];
    let mut same: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    for (vertex, &p) in mesh
        .positions
        .iter()
        .enumerate()
        .filter(|&(vertex, _)| used[vertex])
    {
        let (low, high) = (key(p - tolerance), key(p + tolerance));
        let mut found = None;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let mut other = first_in.get(&[x, y, z]).copied().unwrap_or(u32::MAX);
                    while other != u32::MAX {
                        if mesh.positions[other as usize].distance(p) <= tolerance {
                            found = Some(found.map_or(other, |f: u32| f.min(other)));
                        }
                        other = next_in[other as usize];
                    }
                }
            }
        }
        match found {
            Some(first) => same[vertex] = first,
            None => match first_in.entry(key(p)) {
                Entry::Occupied(mut head) => next_in[vertex] = head.insert(vertex as u32),
                Entry::Vacant(head) => drop(head.insert(vertex as u32)),
            },
        }
    }
    same
}

/// Returns the distance within which two vertices of `mesh` are one point, file units.
///
/// It is [`TOLERANCE`] of the median triangle plus the rounding of the coordinates.
pub(crate) fn tolerance(mesh: &Mesh) -> f64 {
    let mut longest: Vec<f64> = (0..mesh.triangles.len())
        .map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        })
        .collect();
    if longest.is_empty() {
        return 0.0;
    }
    let middle = longest.len() / 2;
    let (_, median, _) = longest.select_nth_unstable_by(middle, f64::total_cmp);
    TOLERANCE * *median + rounding(mesh)
}

/// Returns a bound on the rounding of a distance between two positions of `mesh`, file units.
///
/// It is half a unit in the last place of the largest coordinate, for two vertices in three axes.
pub(crate) fn rounding(mesh: &Mesh) -> f64 {
    let largest = mesh
        .positions
        .iter()
        .map(|p| p.abs().max_element())
        .fold(0.0, f64::max);
    3_f64.sqrt() * f64::EPSILON * largest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares chains, cell borders and exact copies with the quadratic definition.
    #[test]
    fn agrees_with_the_quadratic_definition() {
        let mut cases = 0;
        for seed in 0..20_u64 {
            let mut state = seed + 1;
            let mut random = || {
                state = state
                    .wrapping_mul(6364136223846793005)
                    .wrapping_add(1442695040888963407);
                (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
            };
            let tolerance = 0.02;
            let positions: Vec<DVec3> = (0..300)
                .map(|_| DVec3::new(random(), random() * 0.1, random() * 0.1))
                .collect();
            let triangles = (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let mesh = Mesh {
                positions,
                triangles,
                ..Mesh::default()
            };
            let same = weld(&mesh, tolerance);
            let mut representatives: Vec<u32> = Vec::new();
            for vertex in 0..300_u32 {
                let near = |&&r: &&u32| {
                    mesh.positions[r as usize].distance(mesh.positions[vertex as usize])
                        <= tolerance
                };
                let expected = representatives.iter().find(near).copied();
                assert_eq!(same[vertex as usize], expected.unwrap_or(vertex));
                if expected.is_none() {
                    representatives.push(vertex);
                }
                cases += 1;
            }
        }
        assert_eq!(cases, 6000);
    }
}
