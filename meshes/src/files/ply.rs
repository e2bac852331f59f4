//! Reading of PLY, as text or binary, through `ply-rs-bw`.

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess};
use ply_rs_bw::ply::{PropertyAccessResult, PropertyType, ScalarType};

use crate::files::load::within;
use crate::files::obj;
use crate::mesh::digits::{Digits, single};
use crate::mesh::error::Fault;
use crate::mesh::mesh::{Mesh, sha256};
use crate::mesh::polygon;

/// Vertex, face, or another element, of which nothing is kept.
#[derive(Default)]
struct PlyElement {
    position: DVec3,
    corners: Vec<u32>,
}

impl PropertyAccess for PlyElement {
    fn new() -> Self {
        PlyElement::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "x" => self.position.x = scalar(&property),
            "y" => self.position.y = scalar(&property),
            "z" => self.position.z = scalar(&property),
            "vertex_indices" | "vertex_index" => self.corners = indices(property),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// Returns a number; NaN for a list.
fn scalar(property: &Property) -> f64 {
    match *property {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x.into(),
        Property::UInt(x) => x.into(),
        Property::Float(x) => x.into(),
        Property::Double(x) => x,
        _ => f64::NAN,
    }
}

/// Returns a list of indices; one below 0 becomes the greatest number, and what is no list of
/// integers becomes empty.
fn indices(property: Property) -> Vec<u32> {
    fn all<T: TryInto<u32>>(list: Vec<T>) -> Vec<u32> {
        let index = |index: T| index.try_into().unwrap_or(u32::MAX);
        list.into_iter().map(index).collect()
    }
    match property {
        Property::ListChar(list) => all(list),
        Property::ListUChar(list) => all(list),
        Property::ListShort(list) => all(list),
        Property::ListUShort(list) => all(list),
        Property::ListInt(list) => all(list),
        Property::ListUInt(list) => list,
        _ => Vec::new(),
    }
}

/// Parses a PLY file: the elements `vertex` and `face`, and comments as OBJ has them (`comment
/// lattice ax,ay,az,bx,by,bz`).
///
/// # Errors Fails if the file is not PLY or is cut short, if it has no faces, if an index is out of
/// range, a face has fewer than three corners, a polygon is not flat or crosses itself, or if a
/// vertex is not finite.
pub fn parse(bytes: &[u8]) -> Result<Mesh, Fault> {
    let text = header(bytes)
        .contains("format ascii")
        .then(|| obj::text(bytes));
    let content = text.as_ref().map_or(bytes, |text| text.as_bytes());
    let mut mesh = Mesh {
        hash: sha256([bytes]),
        ..Mesh::default()
    };
    for (line, content) in (1..).zip(header(content).lines()) {
        if let Some(comment) = content.strip_prefix("comment") {
            obj::comment(&mut mesh, line, comment)?;
        }
    }
    let mut reader = Reader::new(content);
    let parser = Parser::<PlyElement>::new();
    let read = parser.read_header(&mut reader).map_err(fault)?;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    let mut before = reader.line() - 1;
    for (name, element) in &read.elements {
        let what = match name.as_str() {
            "vertex" => "vertices",
            "face" => "triangles",
            _ => "elements of one kind",
        };
        within(what, element.count)?;
        let elements = parser.read_payload_for_element(&mut reader, element, &read);
        let elements = elements.map_err(fault)?;
        match what {
            "vertices" => {
                vertices = elements
                    .into_iter()
                    .map(|element| element.position)
                    .collect();
                mesh.steps = match (&text, read.encoding) {
                    (Some(text), Encoding::Ascii) => written(text, before, element, &vertices),
                    _ => Vec::new(),
                };
                if is_single(element) {
                    mesh.steps.resize(vertices.len(), DVec3::ZERO);
                    let steps = mesh.steps.iter_mut().zip(&vertices);
                    steps.for_each(|(step, &position)| *step = step.max(single(position)));
                }
            }
            "triangles" => faces = elements,
            _ => {}
        }
        before += element.count;
    }
    if !reader.into_inner().iter().all(u8::is_ascii_whitespace) {
        let reason = "it holds more than its header says".to_owned();
        return Err(Fault::Ply { line: None, reason });
    }
    if let Some(vertex) = vertices.iter().position(|p| !p.is_finite()) {
        return Err(Fault::NotFinite { vertex: vertex + 1 });
    }
    mesh.positions = vertices;
    polygons(&mut mesh, faces)?;
    Ok(mesh)
}

/// Returns the text of a header, as far as it is UTF-8; empty if it has no end.
fn header(bytes: &[u8]) -> &str {
    let end = b"end_header";
    let length = bytes.windows(end.len()).position(|window| window == end);
    let header = &bytes[..length.unwrap_or(0)];
    let utf8 = str::from_utf8(header).map_err(|error| error.valid_up_to());
    utf8.unwrap_or_else(|valid| str::from_utf8(&header[..valid]).unwrap_or_default())
}

/// Cuts faces into the triangles of `mesh`.
fn polygons(mesh: &mut Mesh, faces: Vec<PlyElement>) -> Result<(), Fault> {
    let vertices = mesh.positions.len();
    let mut all_triangles = true;
    for (face, PlyElement { corners, .. }) in (1_u32..).zip(faces) {
        if corners.len() < 3 {
            let corners = corners.len();
            return Err(Fault::FewFaceCorners { face, corners });
        }
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= vertices) {
            let vertex = u64::from(vertex) + 1;
            return Err(Fault::IndexOutOfRange {
                face,
                vertex,
                vertices,
            });
        }
        within("triangles", mesh.triangles.len() + corners.len())?;
        all_triangles &= corners.len() == 3;
        polygon::cut(&mesh.positions, &corners, face, &mut mesh.triangles)?;
        mesh.faces.resize(mesh.triangles.len(), face);
    }
    if all_triangles {
        mesh.faces = Vec::new();
    }
    match mesh.triangles.is_empty() {
        true => Err(Fault::Empty),
        false => Ok(()),
    }
}

/// Returns whether a coordinate of the vertices is an f32.
fn is_single(vertex: &ElementDef) -> bool {
    let float = PropertyType::Scalar(ScalarType::Float);
    let mut axes = ["x", "y", "z"].iter();
    axes.any(|&axis| {
        vertex
            .properties
            .get(axis)
            .is_some_and(|p| p.data_type == float)
    })
}

/// Returns the steps in which a text gives the vertices, whose lines follow `before` others.
fn written(text: &str, before: usize, vertex: &ElementDef, positions: &[DVec3]) -> Vec<DVec3> {
    let properties = &vertex.properties;
    let columns = ["x", "y", "z"].map(|axis| properties.get_index_of(axis));
    let mut digits = Digits::default();
    for line in text.lines().skip(before).take(positions.len()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let numbers = columns.iter().flatten();
        numbers
            .filter_map(|&column| words.get(column))
            .for_each(|word| digits.read(word));
    }
    digits.steps(positions)
}

/// Returns an error of the parser, which takes several lines, in one.
fn fault(error: ParseError) -> Fault {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default();
    let (_, reason) = first
        .split_once(": ")
        .filter(|_| error.line().is_some())
        .unwrap_or(("", first));
    Fault::Ply {
        line: error.line(),
        reason: reason.trim_end_matches('.').chars().take(100).collect(),
    }
}
