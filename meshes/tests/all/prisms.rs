//! Closed prisms: the front face comes off, whatever its triangles, and the mirror facets are those
//! of the hollow cell.

use glam::DVec3;
use meshes::Mesh;
use meshes::design::{Design, Shape};

use crate::cells::cell;

/// Hollow cell wound outward, closed by a fan from the middle of its rim, by two triangles, or by
/// one.
fn closed(hollow: &Mesh, rim: &[u32], fan: bool) -> Mesh {
    let mut mesh = hollow.clone();
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    if fan {
        let middle = mesh.positions.len() as u32;
        let sum: DVec3 = rim.iter().map(|&v| mesh.positions[v as usize]).sum();
        mesh.positions.push(sum / rim.len() as f64);
        mesh.triangles
            .extend((0..rim.len()).map(|i| [rim[i], rim[(i + 1) % rim.len()], middle]));
    } else {
        mesh.triangles
            .extend((1..rim.len() - 1).map(|i| [rim[0], rim[i], rim[i + 1]]));
    }
    mesh.refractive_index = Some(1.49);
    mesh
}

#[test]
fn a_prism_is_its_hollow_cell_with_a_front_face() {
    let shapes: [(Shape, &[u32], f64); 4] = [
        (Shape::Triangular, &[1, 2, 3], 0.0),
        (Shape::TriangularPair, &[1, 5, 2, 3], 0.0),
        (Shape::Canted, &[1, 5, 2, 3], 0.15),
        (Shape::Canted, &[1, 5, 2, 3], 0.9),
    ];
    let mut cases = 0;
    for (shape, rim, cant_rad) in shapes {
        for dihedral_error_rad in [[0.0; 3], [1e-9, 0.0, 0.0], [1e-3, -2e-3, 1e-2]] {
            let hollow = Design {
                cant_rad,
                dihedral_error_rad,
                ..Design::new(shape)
            }
            .mesh()
            .expect("a design");
            let expected = cell(&hollow);
            for fan in [false, true] {
                for inward in [false, true] {
                    let mut prism = closed(&hollow, rim, fan);
                    if inward {
                        prism.triangles.iter_mut().for_each(|t| t.swap(1, 2));
                    }
                    let found = cell(&prism);
                    assert_eq!((found.closed, found.refractive_index), (true, Some(1.49)));
                    assert_eq!(
                        found.warnings.len(),
                        usize::from(inward),
                        "{:?}",
                        found.warnings
                    );
                    // All numbers are used in one and the same order, so nothing is rounded on the
                    // way.
                    assert_eq!(found.facets, expected.facets, "{shape:?} {cant_rad}");
                    assert_eq!(found.entrance, expected.entrance);
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 48);
}

/// A block whose front is a slab above the rim has side walls, which a sheet has not. It is told
/// their number, and no wall is seen where the front ends at the rim.
#[test]
fn side_walls_of_a_block_are_named() {
    let mut cases = 0;
    for (shape, rim) in [
        (Shape::Triangular, &[1, 2, 3][..]),
        (Shape::TriangularPair, &[1, 5, 2, 3]),
    ] {
        let hollow = Design::new(shape).mesh().expect("a design");
        let [a, b, c] = [0, 1, 2].map(|k| hollow.positions[rim[k] as usize]);
        let up = (b - a).cross(c - a).normalize();
        let inside = hollow.positions[0] - a;
        let up = up * -up.dot(inside).signum();
        for height in [0.0, 0.1, 2.0] {
            let mut block = hollow.clone();
            block.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            let mut top = rim.to_vec();
            if height > 0.0 {
                for own in &mut top {
                    block
                        .positions
                        .push(block.positions[*own as usize] + height * up);
                    *own = block.positions.len() as u32 - 1;
                }
                for i in 0..rim.len() {
                    let j = (i + 1) % rim.len();
                    block.triangles.push([rim[i], rim[j], top[j]]);
                    block.triangles.push([rim[i], top[j], top[i]]);
                }
            }
            block
                .triangles
                .extend((1..top.len() - 1).map(|i| [top[0], top[i], top[i + 1]]));
            block.refractive_index = Some(1.49);
            let warnings = cell(&block).warnings;
            let walls = format!("{} faces", 2 * rim.len());
            let named = warnings.iter().filter(|own| own.starts_with(&walls));
            let expected = usize::from(height > 0.0);
            assert_eq!(
                (named.count(), warnings.len()),
                (expected, expected),
                "{warnings:?}"
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 6);
}
