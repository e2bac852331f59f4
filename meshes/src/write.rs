//! Writing meshes: OBJ in full f64 digits, GLB in f32.

use glam::DVec3;

use crate::mesh::Mesh;

/// A number in the fewest digits that read back as the same f64.
fn digits(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 {
        "0".to_owned()
    } else if (1e-5..1e16).contains(&magnitude) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

fn joined(vectors: &[DVec3], separator: &str) -> String {
    let words: Vec<String> = vectors
        .iter()
        .flat_map(|v| v.to_array())
        .map(digits)
        .collect();
    words.join(separator)
}

/// The mesh as OBJ text: `# design`, `# lattice` and `# edge_length` comments where the mesh has them, then `v` and `f`
/// lines. Every coordinate reads back as the same f64.
pub fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    let mut line = |content: String| {
        text.push_str(&content);
        text.push('\n');
    };
    if !mesh.design.is_empty() {
        line(format!(
            "# design {}",
            mesh.design.replace(['\n', '\r'], " ")
        ));
    }
    if let Some(lattice) = &mesh.lattice {
        line(format!("# lattice {}", joined(lattice, ",")));
    }
    if let Some(length) = mesh.edge_length {
        line(format!("# edge_length {}", digits(length)));
    }
    for &p in &mesh.positions {
        line(format!("v {}", joined(&[p + mesh.origin], " ")));
    }
    for [a, b, c] in &mesh.triangles {
        line(format!(
            "f {} {} {}",
            u64::from(*a) + 1,
            u64::from(*b) + 1,
            u64::from(*c) + 1
        ));
    }
    text
}
