//! Wavefront OBJ through `tobj`, in f64.
//!
//! `tobj` numbers vertices by their first use and forgets the file's order, cannot continue lines, and fans every
//! polygon. So it is given only the `v` and `f` lines, continued lines joined, after one polygon that names all
//! vertices in order; polygons are cut into triangles in [`crate::polygon`].

use glam::DVec3;

use crate::error::{Counted, Fault};
use crate::mesh::{MAX_ELEMENTS, Mesh, sha256};
use crate::polygon;

/// A face line of the file: its number and how many vertices precede it (what negative indices count from).
struct FaceLine {
    line: usize,
    vertices_before: usize,
    text: String,
}

/// Parses an OBJ file.
///
/// # Errors
/// A line that is not OBJ, an index out of range, a face of fewer than three corners, or a polygon that is not flat or
/// crosses itself.
pub fn parse(bytes: &[u8]) -> Result<Mesh, Fault> {
    let text = String::from_utf8_lossy(bytes);
    let mut mesh = Mesh {
        hash: sha256([bytes]),
        ..Mesh::default()
    };
    let mut body = String::with_capacity(text.len());
    let mut faces = Vec::new();
    let mut vertex_lines = Vec::new();
    for (line, content) in logical_lines(&text) {
        match content.split_whitespace().next() {
            Some("v") => {
                vertex_lines.push(line);
                // A fourth number is a rational weight or the first of a colour: neither moves a polygon's corner.
                for word in content.split_whitespace().take(4) {
                    body.push_str(word);
                    body.push(' ');
                }
                body.push('\n');
            }
            Some("f") => {
                let corners = content.split_whitespace().count() - 1;
                if corners < 3 {
                    return Err(Fault::FewCorners { line, corners });
                }
                body.push_str(&content);
                body.push('\n');
                faces.push(FaceLine {
                    line,
                    vertices_before: vertex_lines.len(),
                    text: content,
                });
            }
            Some(word) if word.starts_with('#') => comment(&mut mesh, line, &content)?,
            _ => {}
        }
    }
    for (what, found) in [
        (Counted::Vertices, vertex_lines.len()),
        (Counted::Triangles, faces.len()),
    ] {
        if found > MAX_ELEMENTS {
            return Err(Fault::TooLarge {
                what,
                found: found as u64,
                limit: MAX_ELEMENTS as u64,
            });
        }
    }
    if faces.is_empty() {
        return Err(Fault::Empty);
    }
    let mut source = String::with_capacity(body.len() + 8 * vertex_lines.len());
    source.push('f');
    for vertex in 1..=vertex_lines.len() {
        source.push(' ');
        source.push_str(&vertex.to_string());
    }
    source.push('\n');
    source.push_str(&body);
    drop(body);

    let options = tobj::LoadOptions::default();
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut source.as_bytes(), &options, no_materials)
        .map_err(|reason| locate(reason, &text, &faces, vertex_lines.len()))?;
    let model = models.into_iter().next().ok_or(Fault::Empty)?.mesh;
    mesh.positions = model
        .positions
        .chunks_exact(3)
        .map(|p| DVec3::new(p[0], p[1], p[2]))
        .collect();
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(Fault::NotFinite { vertex: vertex + 1 });
    }
    // No arities: all faces are triangles, which makes the naming polygon one too.
    let arities = if model.face_arities.is_empty() {
        vec![3; faces.len() + 1]
    } else {
        model.face_arities
    };
    triangulate(&mut mesh, &model.indices, &arities)?;
    Ok(mesh)
}

/// Cuts the polygons, past the one that names all vertices, into the mesh's triangles.
fn triangulate(mesh: &mut Mesh, indices: &[u32], arities: &[u32]) -> Result<(), Fault> {
    let mut start = mesh.positions.len();
    let mut all_triangles = true;
    for (face, &arity) in (1u32..).zip(&arities[1..]) {
        let corners = &indices[start..start + arity as usize];
        start += arity as usize;
        if mesh.triangles.len() + corners.len() > MAX_ELEMENTS {
            let found = (mesh.triangles.len() + corners.len()) as u64;
            return Err(Fault::TooLarge {
                what: Counted::Triangles,
                found,
                limit: MAX_ELEMENTS as u64,
            });
        }
        all_triangles &= corners.len() == 3;
        polygon::cut(&mesh.positions, corners, face, &mut mesh.triangles)?;
        mesh.faces.resize(mesh.triangles.len(), face);
    }
    if all_triangles {
        mesh.faces = Vec::new();
    }
    Ok(())
}

/// Lines with their number from 1; a line that ends in a backslash goes on in the next.
fn logical_lines(text: &str) -> impl Iterator<Item = (usize, String)> + '_ {
    let mut lines = (1..).zip(text.lines());
    std::iter::from_fn(move || {
        let (number, first) = lines.next()?;
        let mut content = first.trim().to_owned();
        while content.ends_with('\\') {
            content.pop();
            content.push(' ');
            match lines.next() {
                Some((_, next)) => content.push_str(next.trim()),
                None => break,
            }
        }
        Some((number, content))
    })
}

/// Reads `# design NAME`, `# lattice ax,ay,az,bx,by,bz` and `# edge_length L`; other comments say nothing to us.
fn comment(mesh: &mut Mesh, line: usize, content: &str) -> Result<(), Fault> {
    let content = content.trim_start_matches('#').trim();
    let (key, value) = content
        .split_once(char::is_whitespace)
        .unwrap_or((content, ""));
    match key {
        "design" => mesh.design = value.trim().to_owned(),
        "lattice" => {
            let wrong = || Fault::LatticeComment {
                line,
                text: content.to_owned(),
            };
            let words = value
                .split([',', ' ', '\t'])
                .filter(|word| !word.is_empty());
            let numbers: Vec<f64> = words
                .map(str::parse)
                .collect::<Result<_, _>>()
                .map_err(|_| wrong())?;
            let [ax, ay, az, bx, by, bz] = numbers[..] else {
                return Err(wrong());
            };
            let lattice = [DVec3::new(ax, ay, az), DVec3::new(bx, by, bz)];
            if !lattice.iter().all(|v| v.is_finite()) {
                return Err(wrong());
            }
            mesh.lattice = Some(lattice);
        }
        "edge_length" => match value.trim().parse::<f64>() {
            Ok(length) if length.is_finite() && length > 0.0 => mesh.edge_length = Some(length),
            _ => {
                return Err(Fault::EdgeLengthComment {
                    line,
                    text: content.to_owned(),
                });
            }
        },
        _ => {}
    }
    Ok(())
}

/// Finds the line that made `tobj` refuse: it reports none.
fn locate(reason: tobj::LoadError, text: &str, faces: &[FaceLine], vertices: usize) -> Fault {
    if reason == tobj::LoadError::FaceVertexOutOfBounds {
        for face in faces {
            for word in face.text.split_whitespace().skip(1) {
                let Some(index) = word.split('/').next().and_then(|i| i.parse::<i64>().ok()) else {
                    continue;
                };
                let from_one = if index < 0 {
                    face.vertices_before as i64 + 1 + index
                } else {
                    index
                };
                if from_one < 1 || from_one > vertices as i64 {
                    return Fault::ObjIndex {
                        line: face.line,
                        index,
                        vertices,
                    };
                }
            }
        }
    }
    let refuses = |content: &str| {
        let options = tobj::LoadOptions::default();
        let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
        tobj::load_obj_buf(&mut content.as_bytes(), &options, no_materials).err() == Some(reason)
    };
    for (line, content) in logical_lines(text) {
        if matches!(content.split_whitespace().next(), Some("v" | "f")) {
            let words: Vec<&str> = content.split_whitespace().take(4).collect();
            let alone = if content.starts_with('v') {
                words.join(" ")
            } else {
                content.clone()
            };
            if refuses(&alone) {
                let text = content.chars().take(60).collect();
                return Fault::ObjLine { line, text, reason };
            }
        }
    }
    Fault::Obj(reason)
}
