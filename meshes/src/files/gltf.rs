//! Reading of glTF 2.0, as JSON with its buffers or as GLB.
//!
//! The `gltf` crate parses and validates the document. Node transforms are accumulated here in f64
//! (the product of the crate is f32), quaternions are renormalised, and the winding is reversed if
//! a transform mirrors. Positions are kept relative to the origin of the first node that has a
//! mesh: exact local vertices stay exact under a node translation of 10^6.

use std::num::NonZeroU32;
use std::path::Path;

use ::gltf::mesh::Mode;
use ::gltf::scene::Transform;
use ::gltf::{Document, Gltf, Node};
use glam::{DMat3, DQuat, DVec3};
use serde_json::Value;

use crate::files::buffer::Buffers;
use crate::files::glb;
use crate::files::load::within;
use crate::mesh::error::Fault;
use crate::mesh::mesh::{GLASS, Mesh, sha256};

/// Frame of a node in the scene.
#[derive(Clone, Copy)]
struct Placement {
    linear: DMat3,
    translation: DVec3,
}

/// Parses the bytes of a .gltf or .glb file.
///
/// `folder` is the folder of buffers in files of their own. Only the default scene is read (the
/// first scene if none is default); all its mesh nodes are merged in depth-first order. Skins,
/// morph targets, and materials other than `KHR_materials_ior` and `KHR_materials_dispersion` do
/// not shape a mirror and are ignored.
///
/// # Errors
/// Returns a [`Fault`] if a container, document, buffer or accessor is malformed, if the nodes form
/// a cycle, or if the scene has no triangles.
pub fn parse(bytes: &[u8], folder: Option<&Path>) -> Result<Mesh, Fault> {
    let (json, binary) = if glb::is_binary(bytes) {
        glb::chunks(bytes)?
    } else {
        // A text may begin with a byte order mark.
        (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None)
    };
    light(json)?;
    numbers_fit(json)?;
    let document = validated(json)?;
    let buffers = Buffers::resolve(&document, binary, folder)?;
    let external = buffers
        .contents
        .iter()
        .zip(&buffers.external)
        .filter(|(_, external)| **external);
    let hash =
        sha256(std::iter::once(bytes).chain(external.map(|(content, _)| content.as_slice())));
    let mut mesh = Mesh {
        hash,
        ..Mesh::default()
    };
    extras(&document, &mut mesh)?;
    merge_scene(&document, &buffers, &mut mesh)?;
    if !mesh.glass.contains(&true) {
        mesh.glass = Vec::new();
    }
    if mesh.triangles.is_empty() {
        return Err(Fault::Empty);
    }
    Ok(mesh)
}

/// Refuses JSON that would take far more memory than its bytes do.
///
/// An object of two bytes may become a node of hundreds, and a number of one byte a value of 32.
/// Long texts (buffers as data URIs) take only their own length.
fn light(json: &[u8]) -> Result<(), Fault> {
    let (mut objects, mut outside) = (0, 0);
    let (mut in_text, mut escaped) = (false, false);
    for &byte in json {
        if in_text {
            in_text = escaped || byte != b'"';
            escaped = !escaped && byte == b'\\';
        } else {
            outside += 1;
            objects += u64::from(byte == b'{');
            in_text = byte == b'"';
        }
    }
    let counted = [
        ("bytes of JSON", json.len() as u64, 1 << 27),
        ("bytes of JSON outside of texts", outside, 1 << 24),
        ("JSON objects", objects, 1 << 17),
    ];
    match counted.into_iter().find(|&(_, found, limit)| found > limit) {
        Some((what, found, limit)) => Err(Fault::TooLarge { what, found, limit }),
        None => Ok(()),
    }
}

/// Refuses whole numbers above those of 32 bits, outside of texts.
///
/// The `gltf` crate reads an index as a number of 64 bits and keeps 32 of them, so that 2^32 would
/// name the first object. No count, offset or length is that great in a file that is read here.
fn numbers_fit(json: &[u8]) -> Result<(), Fault> {
    let (mut in_text, mut escaped) = (false, false);
    let mut start = None;
    for (at, &byte) in json.iter().chain(b" ").enumerate() {
        if in_text {
            in_text = escaped || byte != b'"';
            escaped = !escaped && byte == b'\\';
            continue;
        }
        in_text = byte == b'"';
        if byte.is_ascii_alphanumeric() || b"+-.".contains(&byte) {
            start = start.or(Some(at));
        } else if let Some(start) = start.take() {
            let word = &json[start..at];
            let digits = word.iter().all(u8::is_ascii_digit);
            let number = str::from_utf8(word).unwrap_or_default();
            if digits && number.parse::<u32>().is_err() {
                let number = number.chars().take(40).collect();
                return Err(Fault::GltfNumber { number });
            }
        }
    }
    Ok(())
}

/// Extensions that pack a mesh so that it is not read here, each with the command that unpacks it.
const PACKED: [(&str, &str); 3] = [
    (
        "KHR_draco_mesh_compression",
        "gltf-transform cp IN.glb OUT.glb",
    ),
    (
        "EXT_meshopt_compression",
        "gltfpack -noq -i IN.glb -o OUT.glb",
    ),
    (
        "KHR_meshopt_compression",
        "gltfpack -noq -i IN.glb -o OUT.glb",
    ),
];

/// Extension of integers for positions, which the `gltf` crate does not know and refuses.
const QUANTIZED: &str = "KHR_mesh_quantization";

/// Parses the document and validates it with the `gltf` crate.
///
/// The crate looks positions up before it checks their index, and panics if the index is wrong. So
/// the indices are checked first.
fn validated(json: &[u8]) -> Result<Document, Fault> {
    let mut root = Gltf::from_slice_without_validation(json)
        .map_err(Fault::Gltf)?
        .document
        .into_json();
    let version = &root.asset.version;
    let least = root.asset.min_version.as_deref().unwrap_or("2.0");
    if let Some(other) = [version.as_str(), least]
        .into_iter()
        .find(|version| version.split('.').next() != Some("2"))
    {
        let version = other.chars().take(40).collect();
        return Err(Fault::GltfVersion { version });
    }
    let packed = |names: &[String]| {
        let mut known = PACKED.into_iter();
        known.find(|(extension, _)| names.iter().any(|name| name == extension))
    };
    let as_packed = |(extension, command)| Fault::GltfPacked { extension, command };
    if let Some(found) = packed(&root.extensions_required) {
        return Err(as_packed(found));
    }
    // A file that only uses it may hold the plain mesh too.
    let used = packed(&root.extensions_used);
    root.extensions_required.retain(|name| name != QUANTIZED);
    let positions = ::gltf::json::validation::Checked::Valid(::gltf::Semantic::Positions);
    for (mesh, source) in root.meshes.iter().enumerate() {
        let accessors = source
            .primitives
            .iter()
            .filter_map(|primitive| primitive.attributes.get(&positions));
        if accessors
            .into_iter()
            .any(|accessor| accessor.value() >= root.accessors.len())
        {
            return Err(Fault::Accessor {
                mesh,
                what: "positions",
                reason: "their accessor does not exist",
            });
        }
    }
    Document::from_json(root).map_err(|error| used.map_or(Fault::Gltf(error), as_packed))
}

/// Appends every mesh of the scene, depth first.
fn merge_scene(document: &Document, buffers: &Buffers, mesh: &mut Mesh) -> Result<(), Fault> {
    let scenes = document.scenes().len();
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next())
        .ok_or(Fault::NoScene { scenes })?;
    let root = Placement {
        linear: DMat3::IDENTITY,
        translation: DVec3::ZERO,
    };
    let mut visited = vec![false; document.nodes().len()];
    let mut origin = None;
    // The stack is explicit, because a hostile scene may be deeper than the thread's stack.
    let mut open: Vec<(Node<'_>, Placement)> = scene.nodes().map(|node| (node, root)).collect();
    open.reverse();
    while let Some((node, parent)) = open.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(Fault::NodeRevisited { node: node.index() });
        }
        let here = placed(&node, parent)?;
        if node.mesh().is_some() {
            let origin = *origin.get_or_insert(here.translation);
            mesh.origin = origin;
            append(&node, here, origin, buffers, mesh)?;
        }
        let first = open.len();
        open.extend(node.children().map(|child| (child, here)));
        open[first..].reverse();
    }
    Ok(())
}

/// Returns the frame of a node under that of its parent.
fn placed(node: &Node<'_>, parent: Placement) -> Result<Placement, Fault> {
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let (linear, translation) = match node.transform() {
        Transform::Matrix {
            matrix: [x, y, z, t],
        } => {
            let column = |c: [f32; 4]| wide([c[0], c[1], c[2]]);
            (DMat3::from_cols(column(x), column(y), column(z)), column(t))
        }
        Transform::Decomposed {
            translation,
            rotation,
            scale,
        } => {
            // f32 leaves a quaternion 1e-7 off unit length, which would be an unwanted scale and
            // shear.
            let rotation = DQuat::from_array(rotation.map(f64::from)).normalize();
            (
                DMat3::from_quat(rotation) * DMat3::from_diagonal(wide(scale)),
                wide(translation),
            )
        }
    };
    let here = Placement {
        linear: parent.linear * linear,
        translation: parent.linear * translation + parent.translation,
    };
    let size = here
        .linear
        .to_cols_array()
        .iter()
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    // The comparison is relative to the largest entry, so it also catches a determinant that
    // underflows.
    let flattened = (here.linear * (1.0 / size)).determinant().abs() < 1e-18;
    if !(here.linear.is_finite() && here.translation.is_finite()) || size == 0.0 || flattened {
        return Err(Fault::NodeTransform { node: node.index() });
    }
    Ok(here)
}

/// Appends the primitives of a node's mesh.
fn append(
    node: &Node<'_>,
    here: Placement,
    origin: DVec3,
    buffers: &Buffers,
    mesh: &mut Mesh,
) -> Result<(), Fault> {
    let Some(source) = node.mesh() else {
        return Ok(());
    };
    let index = source.index();
    let mirrored = here.linear.determinant() < 0.0;
    let offset = here.translation - origin;
    for primitive in source.primitives() {
        let wrong = |what| {
            move |reason| Fault::Accessor {
                mesh: index,
                what,
                reason,
            }
        };
        let accessor = primitive
            .get(&::gltf::Semantic::Positions)
            .ok_or(wrong("positions")("it has none"))?;
        let count = |have: usize, more: usize| have.saturating_add(more);
        let vertices = count(mesh.positions.len(), accessor.count());
        within("vertices", vertices)?;
        let (local, steps) = buffers.positions(&accessor).map_err(wrong("positions"))?;
        let indices = match primitive.indices() {
            Some(accessor) => {
                within(
                    "triangles",
                    count(3 * mesh.triangles.len(), accessor.count() / 3),
                )?;
                buffers.indices(&accessor).map_err(wrong("indices"))?
            }
            None => (0..local.len() as u32).collect(),
        };
        let triangles = triangles(primitive.mode(), &indices)
            .map_err(|mode| Fault::NotTriangles { mesh: index, mode })?;
        within("triangles", count(mesh.triangles.len(), triangles.len()))?;
        let first = mesh.positions.len() as u32;
        let glass = primitive.material().name() == Some(GLASS);
        let normals = normals(&primitive, here, buffers);
        let first_normal = mesh.normals.len() as u32 + 1;
        let before = mesh.triangles.len();
        for [a, b, c] in triangles {
            let face = mesh.triangles.len() as u32 + 1;
            if let Some(&vertex) = [a, b, c].iter().find(|&&v| v as usize >= local.len()) {
                return Err(Fault::IndexOutOfRange {
                    face,
                    vertex: u64::from(vertex) + 1,
                    vertices: local.len(),
                });
            }
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            mesh.triangles.push(corners.map(|v| first + v));
            mesh.glass.push(glass);
        }
        if let Some(normals) = normals {
            mesh.corner_normals.resize(before, [None; 3]);
            let number = |vertex: u32| NonZeroU32::new(vertex - first + first_normal);
            mesh.corner_normals
                .extend(mesh.triangles[before..].iter().map(|t| t.map(number)));
            mesh.normals.extend(normals);
        } else if !mesh.corner_normals.is_empty() {
            mesh.corner_normals.resize(mesh.triangles.len(), [None; 3]);
        }
        mesh.positions
            .extend(local.iter().map(|&p| here.linear * p + offset));
        let [x, y, z] = [0, 1, 2].map(|k| here.linear.col(k).abs());
        mesh.steps.extend(
            steps
                .iter()
                .map(|step| x * step.x + y * step.y + z * step.z),
        );
        material(&primitive, mesh);
    }
    Ok(())
}

/// Takes index and Abbe number of a primitive's material, unless an earlier one gave them.
fn material(primitive: &::gltf::Primitive<'_>, mesh: &mut Mesh) {
    // Keep the decimal digits that were typed: 1.49, not the f32 next to it.
    let typed = |index: f32| index.to_string().parse().unwrap_or(f64::from(index));
    mesh.refractive_index = mesh
        .refractive_index
        .or(primitive.material().ior().map(typed));
    let dispersion = primitive
        .material()
        .extension_value("KHR_materials_dispersion")
        .and_then(|extension| extension.get("dispersion"))
        .and_then(Value::as_f64);
    // The value 0 stands for no dispersion.
    let abbe = dispersion.filter(|d| *d > 0.0).map(|d| 20.0 / d);
    mesh.abbe_number = mesh.abbe_number.or(abbe);
}

/// Returns the normals of a primitive's vertices in the scene.
///
/// Returns `None` unless they are plain floats, one for each vertex.
fn normals(
    primitive: &::gltf::Primitive<'_>,
    here: Placement,
    buffers: &Buffers,
) -> Option<Vec<DVec3>> {
    let vertices = primitive.get(&::gltf::Semantic::Positions)?.count();
    let accessor = primitive.get(&::gltf::Semantic::Normals)?;
    if accessor.count() != vertices {
        return None;
    }
    // The normal of a plane transforms with the inverse transpose.
    let turn = here.linear.inverse().transpose();
    let normals = buffers.vectors(&accessor).ok()?;
    Some(normals.into_iter().map(|n| turn * n).collect())
}

/// Returns the triangles of a primitive, wound as glTF 2.0 says.
///
/// # Errors
/// Returns the name of the mode, if it draws no triangles.
fn triangles(mode: Mode, indices: &[u32]) -> Result<Vec<[u32; 3]>, &'static str> {
    Ok(match mode {
        Mode::Triangles => indices.as_chunks::<3>().0.to_vec(),
        Mode::TriangleStrip => {
            let windows = indices.windows(3).enumerate();
            windows
                .map(|(i, w)| {
                    if i % 2 == 0 {
                        [w[0], w[1], w[2]]
                    } else {
                        [w[1], w[0], w[2]]
                    }
                })
                .collect()
        }
        Mode::TriangleFan => indices
            .get(1..)
            .unwrap_or_default()
            .windows(2)
            .map(|w| [indices[0], w[0], w[1]])
            .collect(),
        Mode::Points => return Err("points"),
        Mode::Lines | Mode::LineLoop | Mode::LineStrip => return Err("lines"),
    })
}

/// Reads `lattice`, `design`, `edge_length`, `azimuth_zero` and `hollow` from extras.
///
/// The extras of the document, of its asset and of its scene are read in this order; the first
/// value counts.
fn extras(document: &Document, mesh: &mut Mesh) -> Result<(), Fault> {
    let root = document.as_json();
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next());
    let places = [
        root.extras.as_ref(),
        root.asset.extras.as_ref(),
        scene.as_ref().and_then(|s| s.extras().as_ref()),
    ];
    for place in places.into_iter().flatten() {
        let Ok(Value::Object(entries)) = serde_json::from_str::<Value>(place.get()) else {
            continue;
        };
        if let (None, Some(lattice)) = (mesh.lattice, entries.get("lattice")) {
            let wanted = "six finite numbers ax, ay, az, bx, by, bz in file units";
            let Some([ax, ay, az, bx, by, bz]) = numbers(lattice) else {
                return Err(Fault::Extras {
                    key: "lattice",
                    wanted,
                });
            };
            mesh.lattice = Some([DVec3::new(ax, ay, az), DVec3::new(bx, by, bz)]);
        }
        if let (None, Some(length)) = (mesh.edge_length, entries.get("edge_length")) {
            let length = length.as_f64().filter(|l| l.is_finite() && *l > 0.0);
            let wrong = Fault::Extras {
                key: "edge_length",
                wanted: "a positive number of file units",
            };
            mesh.edge_length = Some(length.ok_or(wrong)?);
        }
        if let (None, Some(direction)) = (mesh.azimuth_zero, entries.get("azimuth_zero")) {
            let wrong = Fault::Extras {
                key: "azimuth_zero",
                wanted: "three finite numbers x, y, z in the file's frame",
            };
            let direction = numbers(direction).ok_or(wrong)?;
            mesh.azimuth_zero = Some(DVec3::from_array(direction));
        }
        if let Some(hollow) = entries.get("hollow") {
            let wrong = Fault::Extras {
                key: "hollow",
                wanted: "true or false",
            };
            mesh.hollow |= hollow.as_bool().ok_or(wrong)?;
        }
        if let (true, Some(design)) = (mesh.design.is_empty(), entries.get("design")) {
            let wrong = Fault::Extras {
                key: "design",
                wanted: "a string",
            };
            mesh.design = design.as_str().ok_or(wrong)?.to_owned();
        }
    }
    Ok(())
}

/// Returns a list of `N` numbers, or `None` if the value is something else.
fn numbers<const N: usize>(list: &Value) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = list.as_array()?.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}
