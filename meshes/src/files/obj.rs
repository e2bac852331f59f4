//! Reading of Wavefront OBJ through `tobj`, in f64.
//!
//! `tobj` numbers vertices by their first use and forgets the file's order, cannot continue lines,
//! and fans every polygon. So it gets only the `v` and `f` lines, with continued lines joined,
//! after one polygon that names all vertices in order. Polygons are cut into triangles in
//! `crate::mesh::polygon`. Normals are read here, because `tobj` would refuse files for faulty
//! normals even if nobody asks for normals.

use std::borrow::Cow;
use std::num::NonZeroU32;

use glam::DVec3;

use crate::files::load::within;
use crate::mesh::digits::Digits;
use crate::mesh::error::Fault;
use crate::mesh::mesh::{GLASS, Mesh, sha256};
use crate::mesh::polygon;

/// Parses an OBJ file.
///
/// # Errors
/// Fails if a line is not OBJ, an index is out of range, a face has fewer than three corners, a
/// polygon is not flat or crosses itself, or a vertex is not finite.
pub fn parse(bytes: &[u8]) -> Result<Mesh, Fault> {
    let text = text(bytes);
    let mut mesh = Mesh {
        hash: sha256([bytes]),
        ..Mesh::default()
    };
    let mut digits = Digits::default();
    let (vertices, faces) = survey(&text, &mut mesh, &mut digits)?;
    let source = geometry(&text, vertices);
    let model = read(source.as_bytes()).map_err(|reason| locate(reason, &text, vertices))?;
    drop(source);
    let model = model.ok_or(Fault::Empty)?;
    mesh.positions = model
        .positions
        .chunks_exact(3)
        .map(|p| DVec3::new(p[0], p[1], p[2]))
        .collect();
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(Fault::NotFinite { vertex: vertex + 1 });
    }
    mesh.steps = digits.steps(&mesh.positions);
    // Without arities all faces are triangles, and the naming polygon is one too.
    let arities = if model.face_arities.is_empty() {
        vec![3; faces + 1]
    } else {
        model.face_arities
    };
    let normals = normals(&text, &mut mesh);
    triangulate(&mut mesh, &model.indices, &arities, &normals)?;
    Ok(mesh)
}

/// Returns the bytes of a text file with lines that end as [`str::lines`] wants them, without a
/// byte order mark.
///
/// Programs on Windows write the mark, and a lone carriage return ends a line of old ones. A byte
/// that is not UTF-8 becomes a replacement character.
pub(crate) fn text(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = String::from_utf8_lossy(bytes);
    match text.contains('\r') {
        true => Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n")),
        false => text,
    }
}

/// Reads the normals and their digits, and returns the normal's number at each corner of each face.
///
/// Faces follow one another; the list is empty if the file has no normals. A normal that is not
/// three numbers becomes a vector that is not finite. A number that names no normal becomes the
/// greatest number.
fn normals(text: &str, mesh: &mut Mesh) -> Vec<Option<NonZeroU32>> {
    let (mut numbers, mut digits) = (Vec::new(), Digits::default());
    let vectors = &mut mesh.normals;
    if !text.lines().any(|line| keyword(line) == "vn") {
        return numbers;
    }
    for (_, content) in logical_lines(text) {
        match keyword(&content) {
            "vn" => {
                let words = content.split_whitespace().skip(1);
                words.for_each(|word| digits.read(word));
                let mut words = content.split_whitespace().skip(1).map(str::parse);
                let mut next = || words.next().and_then(Result::ok).unwrap_or(f64::NAN);
                vectors.push(DVec3::new(next(), next(), next()));
            }
            "f" => numbers.extend(content.split_whitespace().skip(1).map(|corner| {
                let word = corner.split('/').nth(2).filter(|word| !word.is_empty())?;
                let number = match word.parse::<i64>() {
                    // A negative index counts back from the last normal above.
                    Ok(index) if index < 0 => index + vectors.len() as i64 + 1,
                    Ok(index) => index,
                    Err(_) => 0,
                };
                let number = u32::try_from(number).ok().and_then(NonZeroU32::new);
                Some(number.unwrap_or(NonZeroU32::MAX))
            })),
            _ => {}
        }
    }
    let steps = digits.steps(&[DVec3::ONE]);
    mesh.normal_step = steps.first().map_or(0.0, |step| step.x);
    numbers
}

/// Counts vertices, their digits and faces, and reads the comments that describe the cell.
fn survey(text: &str, mesh: &mut Mesh, digits: &mut Digits) -> Result<(usize, usize), Fault> {
    let (mut vertices, mut faces, mut words) = (0, 0, 0);
    let mut glass = false;
    for (line, content) in logical_lines(text) {
        match keyword(&content) {
            "v" => {
                vertices += 1;
                let numbers = content.split_whitespace().skip(1).take(3);
                numbers.for_each(|number| digits.read(number));
            }
            "f" => {
                let corners = content.split_whitespace().take(4).count() - 1;
                if corners < 3 {
                    return Err(Fault::FewCorners { line, corners });
                }
                faces += 1;
                words += content.split_whitespace().count() - 1;
                mesh.glass.push(glass);
            }
            "usemtl" => glass = content.split_whitespace().nth(1) == Some(GLASS),
            word if word.starts_with('#') => comment(mesh, line, &content)?,
            _ => {}
        }
    }
    for (what, found) in [
        ("vertices", vertices),
        ("triangles", faces),
        // A polygon of n corners makes n - 2 triangles, at least n / 3.
        ("triangles", words / 3),
    ] {
        within(what, found)?;
    }
    if !mesh.glass.contains(&true) {
        mesh.glass = Vec::new();
    }
    if faces == 0 {
        Err(Fault::Empty)
    } else {
        Ok((vertices, faces))
    }
}

/// Returns the text for `tobj`: a polygon that names all vertices, and the vertex and face lines.
fn geometry(text: &str, vertices: usize) -> String {
    let mut source = String::with_capacity(text.len() + 9 * vertices);
    source.push('f');
    for vertex in 1..=vertices {
        source.push(' ');
        source.push_str(&vertex.to_string());
    }
    source.push('\n');
    for (_, content) in logical_lines(text) {
        match keyword(&content) {
            "v" => source.push_str(&coordinates(&content)),
            "f" => source.push_str(&content),
            _ => continue,
        }
        source.push('\n');
    }
    source
}

/// Returns a vertex line up to its third number.
///
/// A fourth number is a rational weight or the first of a colour; neither moves a polygon's corner.
fn coordinates(content: &str) -> String {
    content
        .split_whitespace()
        .take(4)
        .collect::<Vec<_>>()
        .join(" ")
}

/// Returns the first word of a line; empty for an empty line.
fn keyword(content: &str) -> &str {
    content.split_whitespace().next().unwrap_or_default()
}

/// Returns the only model of a source without groups and materials.
fn read(mut source: impl std::io::BufRead) -> Result<Option<tobj::Mesh>, tobj::LoadError> {
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut source, &tobj::LoadOptions::default(), no_materials)?;
    Ok(models.into_iter().next().map(|model| model.mesh))
}

/// Cuts the polygons, after the one that names all vertices, into the mesh's triangles.
///
/// `normals` are the numbers of the normals at their corners, if there are any.
fn triangulate(
    mesh: &mut Mesh,
    indices: &[u32],
    arities: &[u32],
    normals: &[Option<NonZeroU32>],
) -> Result<(), Fault> {
    let named = mesh.positions.len();
    let mut start = named;
    let mut all_triangles = true;
    for (face, &arity) in (1_u32..).zip(&arities[1..]) {
        let corners = &indices[start..start + arity as usize];
        start += arity as usize;
        within("triangles", mesh.triangles.len() + corners.len())?;
        all_triangles &= corners.len() == 3;
        let before = mesh.triangles.len();
        polygon::cut(&mesh.positions, corners, face, &mut mesh.triangles)?;
        if !normals.is_empty() {
            let first = start - corners.len() - named;
            let at = |vertex: u32| {
                let corner = corners.iter().position(|&corner| corner == vertex);
                normals.get(first + corner?).copied().flatten()
            };
            let new = mesh.triangles[before..].iter().map(|t| t.map(at));
            mesh.corner_normals.extend(new);
        }
        mesh.faces.resize(mesh.triangles.len(), face);
    }
    if all_triangles {
        mesh.faces = Vec::new();
    }
    Ok(())
}

/// Returns the lines with their number from 1; a line that ends in a backslash is joined to the
/// next, and a comment behind other content is left out.
fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = (1..).zip(text.lines());
    let bare = |line: &str| line.find('#').unwrap_or(line.len());
    std::iter::from_fn(move || {
        let (number, first) = lines.next()?;
        let first = first.trim();
        // Comments are not continued, because they may end in the path of a folder.
        if first.starts_with('#') {
            return Some((number, Cow::Borrowed(first)));
        }
        let mut content = Cow::Borrowed(first[..bare(first)].trim());
        while content.ends_with('\\') {
            let content = content.to_mut();
            content.pop();
            content.push(' ');
            match lines.next() {
                Some((_, next)) => content.push_str(next[..bare(next)].trim()),
                None => break,
            }
        }
        Some((number, content))
    })
}

/// Reads `# design NAME`, `# lattice ax,ay,az,bx,by,bz`, `# edge_length L`, `# azimuth_zero x,y,z`
/// and `# hollow`, which stands alone.
///
/// Other comments are ignored.
pub(crate) fn comment(mesh: &mut Mesh, line: usize, content: &str) -> Result<(), Fault> {
    let content = content.trim_start_matches('#').trim();
    let (key, value) = content
        .split_once(char::is_whitespace)
        .unwrap_or((content, ""));
    let wrong = |what, wanted| Fault::Comment {
        line,
        text: content.to_owned(),
        what,
        wanted,
    };
    match key {
        "design" => mesh.design = value.trim().to_owned(),
        "hollow" if value.trim().is_empty() => mesh.hollow = true,
        "lattice" => {
            let wanted = "lattice ax,ay,az,bx,by,bz' with six finite numbers";
            let vectors = numbers(value).ok_or_else(|| wrong("a lattice", wanted))?;
            let [ax, ay, az, bx, by, bz] = vectors;
            mesh.lattice = Some([DVec3::new(ax, ay, az), DVec3::new(bx, by, bz)]);
        }
        "azimuth_zero" => {
            let wanted = "azimuth_zero x,y,z' with three finite numbers";
            let direction = numbers(value).ok_or_else(|| wrong("a direction", wanted))?;
            mesh.azimuth_zero = Some(DVec3::from_array(direction));
        }
        "edge_length" => {
            let length = value.trim().parse::<f64>().ok();
            let length = length.filter(|length| length.is_finite() && *length > 0.0);
            let wanted = "edge_length L' with one positive number";
            mesh.edge_length = Some(length.ok_or_else(|| wrong("an edge length", wanted))?);
        }
        _ => {}
    }
    Ok(())
}

/// Reads `N` finite numbers, separated by commas or blanks.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let words = text.split([',', ' ', '\t']).filter(|word| !word.is_empty());
    let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
    let numbers: Option<Vec<f64>> = words.map(number).collect();
    numbers?.try_into().ok()
}

/// Finds the line that `tobj` refused, because `tobj` does not report it.
fn locate(reason: tobj::LoadError, text: &str, vertices: usize) -> Fault {
    let mut before = 0;
    for (line, content) in logical_lines(text) {
        let alone = match keyword(&content) {
            "v" => {
                before += 1;
                Cow::Owned(coordinates(&content))
            }
            "f" if reason == tobj::LoadError::FaceVertexOutOfBounds => {
                if let Some(index) = wrong_index(&content, before, vertices) {
                    return Fault::ObjIndex {
                        line,
                        index,
                        vertices,
                    };
                }
                continue;
            }
            "f" => content.clone(),
            _ => continue,
        };
        if read(alone.as_bytes()).err() == Some(reason) {
            let text = content.chars().take(60).collect();
            return Fault::ObjLine { line, text, reason };
        }
    }
    Fault::Obj(reason)
}

/// Returns the first index of a face line that is out of range.
///
/// Negative indices count back from the `before` vertices above the line.
fn wrong_index(content: &str, before: i64, vertices: usize) -> Option<i64> {
    let indices = content
        .split_whitespace()
        .skip(1)
        .filter_map(|word| word.split('/').next()?.parse::<i64>().ok());
    let mut wrong = indices.filter(|&index| {
        let from_one = if index < 0 {
            index.saturating_add(before + 1)
        } else {
            index
        };
        from_one < 1 || from_one > vertices as i64
    });
    wrong.next()
}
