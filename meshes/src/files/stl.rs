//! Reading of STL, as text or binary.
//!
//! STL gives each triangle its own corners. Corners with the same coordinates become one vertex
//! here. The normals in the file are left out: the order of the corners says the side.
//!
//! No crate is used. `stl_io` 0.11 takes a binary file that begins with `solid ` for text and a
//! text that begins with `solid` alone for binary, leaves out all solids but the first, keeps f32
//! of the numbers of a text, and does not tell the line of an error.

use std::collections::HashMap;

use glam::DVec3;

use crate::files::buffer::number;
use crate::files::load::within;
use crate::files::obj;
use crate::mesh::digits::{Digits, single};
use crate::mesh::error::Fault;
use crate::mesh::mesh::{Mesh, sha256};

/// Bytes before the triangles of a binary file: a free text of 80, and their number.
const HEADER: usize = 84;
/// Bytes of a triangle: a normal and three corners of three f32 each, and two bytes more.
const TRIANGLE: usize = 50;

/// Parses an STL file.
///
/// # Errors
/// Fails if the file is neither text nor binary STL, is cut short, or has no triangles or too many.
pub fn parse(bytes: &[u8]) -> Result<Mesh, Fault> {
    let mut mesh = Mesh {
        hash: sha256([bytes]),
        ..Mesh::default()
    };
    let mut known = Known::default();
    // A binary file may begin with the word of a text, so its length decides.
    let count = bytes.get(HEADER - 4..HEADER).map(number);
    let expected = count.map(|count| HEADER + TRIANGLE * count as usize);
    let text = obj::text(bytes);
    let is_text = text.trim_start().get(..5).is_some_and(is("solid"));
    let mut digits = None;
    if expected != Some(bytes.len()) && is_text {
        digits = Some(read_text(&text, &mut mesh, &mut known)?);
    } else {
        let (Some(count), Some(expected)) = (count, expected) else {
            return Err(Fault::StlLength {
                found: bytes.len(),
                expected: HEADER,
            });
        };
        within("triangles", count as usize)?;
        if expected != bytes.len() {
            return Err(Fault::StlLength {
                found: bytes.len(),
                expected,
            });
        }
        for triangle in bytes[HEADER..].as_chunks::<TRIANGLE>().0 {
            let float = |at: usize| f64::from(f32::from_bits(number(&triangle[at..at + 4])));
            let corner = |at: usize| DVec3::new(float(at), float(at + 4), float(at + 8));
            known.push([12, 24, 36].map(corner), &mut mesh)?;
        }
    }
    if mesh.triangles.is_empty() {
        return Err(Fault::Empty);
    }
    mesh.steps = digits.map_or(Vec::new(), |digits: Digits| digits.steps(&mesh.positions));
    // Programs keep f32 of STL, whatever they write.
    mesh.steps.resize(mesh.positions.len(), DVec3::ZERO);
    let steps = mesh.steps.iter_mut().zip(&mesh.positions);
    steps.for_each(|(step, &position)| *step = step.max(single(position)));
    Ok(mesh)
}

/// Vertices by the bits of their coordinates.
#[derive(Default)]
struct Known(HashMap<[u64; 3], u32>);

impl Known {
    /// Appends a triangle to `mesh`, and its corners unless they are vertices already.
    fn push(&mut self, corners: [DVec3; 3], mesh: &mut Mesh) -> Result<(), Fault> {
        within("triangles", mesh.triangles.len() + 1)?;
        let vertices = corners.map(|corner| {
            // Adding 0 makes -0 the same place as 0.
            let key = (corner + DVec3::ZERO).to_array().map(f64::to_bits);
            *self.0.entry(key).or_insert_with(|| {
                mesh.positions.push(corner);
                mesh.positions.len() as u32 - 1
            })
        });
        mesh.triangles.push(vertices);
        within("vertices", mesh.positions.len())
    }
}

/// Reads the triangles of a text, and returns the digits of their corners.
fn read_text(text: &str, mesh: &mut Mesh, known: &mut Known) -> Result<Digits, Fault> {
    let mut digits = Digits::default();
    let mut corners: Vec<DVec3> = Vec::with_capacity(3);
    let mut whole = false;
    for (line, content) in (1..).zip(text.lines()) {
        let wrong = || Fault::StlLine {
            line,
            text: content.trim().chars().take(60).collect(),
        };
        let mut words = content.split_whitespace();
        let Some(keyword) = words.next() else {
            continue;
        };
        whole = false;
        match keyword.to_ascii_lowercase().as_str() {
            "vertex" => {
                let words: Vec<&str> = words.collect();
                let numbers = words.iter().filter_map(|word| word.parse().ok());
                let numbers: Vec<f64> = numbers.filter(|x: &f64| x.is_finite()).collect();
                match (words.len(), &numbers[..]) {
                    (3, &[x, y, z]) => corners.push(DVec3::new(x, y, z)),
                    _ => return Err(wrong()),
                }
                words.iter().for_each(|word| digits.read(word));
            }
            "endfacet" => {
                let triangle = <[DVec3; 3]>::try_from(&corners[..]).map_err(|_| wrong())?;
                known.push(triangle, mesh)?;
                corners.clear();
            }
            "endsolid" => whole = true,
            "solid" | "facet" | "outer" | "endloop" => {}
            _ => return Err(wrong()),
        }
        if !corners.is_empty() && is("facet")(keyword) {
            return Err(wrong());
        }
    }
    match whole {
        true => Ok(digits),
        false => Err(Fault::StlCut),
    }
}

/// Returns a comparison with a lower-case word that does not mind capitals.
fn is(word: &str) -> impl Fn(&str) -> bool {
    move |other| other.eq_ignore_ascii_case(word)
}
