//! Faults of meshes: what is wrong, where it is, and what to do about it.
//!
//! Vertices and faces are numbered from 1, in the order of the file. In OBJ these are the `v` and
//! `f` lines. In glTF, vertices and triangles are counted through the nodes of the scene in
//! depth-first order.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Fault together with its file.
#[derive(Debug, Error)]
#[error("{}: {fault}", file.display())]
pub struct Error {
    /// Path of the mesh file.
    pub file: PathBuf,
    /// Fault of the file or of the mesh. It is boxed, because results pass through every function
    /// of the crate.
    #[source]
    pub fault: Box<Fault>,
}

impl Error {
    /// Ties `fault` to `file`.
    pub fn new(file: &Path, fault: Fault) -> Self {
        Self {
            file: file.to_path_buf(),
            fault: Box::new(fault),
        }
    }
}

/// Fault of a mesh file, of a mesh, or of the options given for it.
#[derive(Debug, Error)]
#[allow(
    missing_docs,
    reason = "each message says what its variant and fields mean"
)]
pub enum Fault {
    // ---- the file as such
    #[error("cannot be read ({0}); check the path and its permissions")]
    Unreadable(#[source] std::io::Error),
    #[error("is a folder; name a mesh in it")]
    Folder,
    #[error("cannot be written ({0}); check the folder and its permissions")]
    Unwritable(#[source] std::io::Error),
    #[error(
        "{}, so it is no mesh format read here; convert it to .obj, .gltf, .glb, .stl or \
        .ply",
        match extension.as_str() {
            "" => "has no extension".to_owned(),
            other => format!("has the extension '{other}'"),
        }
    )]
    UnknownExtension { extension: String },
    #[error(
        "holds {found} {what}, more than the limit of {limit}; reduce the mesh to one cell or one \
        period"
    )]
    TooLarge {
        what: &'static str,
        found: u64,
        limit: u64,
    },
    #[error("holds no triangles; export the mirror facets as faces")]
    Empty,

    // ---- OBJ
    #[error("line {line} cannot be parsed ({reason}): '{text}'; correct that line")]
    ObjLine {
        line: usize,
        text: String,
        #[source]
        reason: tobj::LoadError,
    },
    #[error("cannot be parsed as OBJ ({0}); export it again")]
    Obj(#[source] tobj::LoadError),
    #[error("line {line} is a face of {corners} corners; give it three or more, or delete it")]
    FewCorners { line: usize, corners: usize },
    #[error(
        "line {line} refers to vertex {index}, but the file has {vertices} vertices; correct the \
        index"
    )]
    ObjIndex {
        line: usize,
        index: i64,
        vertices: usize,
    },
    #[error("line {line} is not {what} ('{text}'); write '# {wanted}")]
    Comment {
        line: usize,
        text: String,
        what: &'static str,
        wanted: &'static str,
    },
    #[error(
        "face {face} is not flat (a corner is {relative:.1e} of its size off its plane); write it \
        with more digits, or split it into triangles"
    )]
    PolygonNotFlat { face: u32, relative: f64 },
    #[error("face {face} crosses itself; split it into triangles")]
    PolygonCrossed { face: u32 },

    // ---- STL and PLY
    #[error("line {line} is not STL: '{text}'; correct that line, or export it as binary STL")]
    StlLine { line: usize, text: String },
    #[error("is a text that ends before 'endsolid', so triangles may be missing; export it again")]
    StlCut,
    #[error(
        "has {found} bytes, where its count of triangles asks for {expected}, and is no text of \
        STL; export it again"
    )]
    StlLength { found: usize, expected: usize },
    #[error(
        "{}cannot be parsed as PLY ({reason}); export it again",
        line.map_or(String::new(), |line| format!("line {line} "))
    )]
    Ply { line: Option<usize>, reason: String },
    #[error("face {face} has {corners} corners; give it three or more, or delete it")]
    FewFaceCorners { face: u32, corners: usize },

    // ---- glTF
    #[error("is not a binary glTF file ({reason}); export it again as glTF 2.0 (.glb)")]
    GlbContainer { reason: &'static str },
    #[error("is not valid glTF 2.0 ({0}); export it again")]
    Gltf(#[source] ::gltf::Error),
    #[error(
        "is packed by {extension}, which is not read here; unpack it with `{command}`, or export \
        it again without compression"
    )]
    GltfPacked {
        extension: &'static str,
        command: &'static str,
    },
    #[error("is glTF of version {version:?}, and 2.0 is read; export it as glTF 2.0")]
    GltfVersion { version: String },
    #[error("holds the number {number}, above all indices and lengths of glTF; export it again")]
    GltfNumber { number: String },
    #[error("is no regular file; name a mesh file, not a folder, a pipe or a device")]
    NotAFile,
    #[error("has no scene to read (no default scene and {scenes} scenes); set 'scene' in the file")]
    NoScene { scenes: usize },
    #[error("reaches node {node} twice; give every node one parent, without cycles")]
    NodeRevisited { node: usize },
    #[error(
        "has a node {node} whose transform is not finite or flattens the mesh; correct its \
        matrix, rotation or scale"
    )]
    NodeTransform { node: usize },
    #[error(
        "has a buffer {buffer} whose URI '{uri}' cannot be resolved ({reason}); embed it or keep \
        it beside the file"
    )]
    BufferUri {
        buffer: usize,
        uri: String,
        reason: &'static str,
    },
    #[error(
        "has a buffer {buffer} in '{}' that cannot be read ({source}); put that file beside this \
        one",
        path.display()
    )]
    BufferUnreadable {
        buffer: usize,
        path: PathBuf,
        #[source]
        source: std::io::Error,
    },
    #[error("has a buffer {buffer} of {found} bytes where {needed} are declared; export it again")]
    BufferShort {
        buffer: usize,
        found: usize,
        needed: usize,
    },
    #[error(
        "has a mesh {mesh} whose {what} cannot be read ({reason}); export it as plain triangles"
    )]
    Accessor {
        mesh: usize,
        what: &'static str,
        reason: &'static str,
    },
    #[error("has a mesh {mesh} drawn as {mode}; export it as triangles")]
    NotTriangles { mesh: usize, mode: &'static str },
    #[error("has an extras entry '{key}' that is not {wanted}; correct or delete it")]
    Extras {
        key: &'static str,
        wanted: &'static str,
    },

    // ---- vertices and faces
    #[error("vertex {vertex} is not finite; correct its coordinates")]
    NotFinite { vertex: usize },
    #[error("face {face} refers to vertex {vertex}, but there are {vertices}; correct the index")]
    IndexOutOfRange {
        face: u32,
        vertex: u64,
        vertices: usize,
    },
    #[error(
        "measures {extent:e} file units across, outside {least:e} to {most:e}; choose another unit"
    )]
    Extent { extent: f64, least: f64, most: f64 },
    #[error(
        "face {face} is degenerate (height {height:.1e} on an edge of {edge:.1e}); delete it or \
        merge its vertices"
    )]
    DegenerateFace { face: u32, height: f64, edge: f64 },
    #[error(
        "face {face} repeats face {first} (same three vertices, same side); delete one of them"
    )]
    DuplicateFace { face: u32, first: u32 },
    #[error(
        "face {face} lies back to back on face {first} (same three vertices, other side); delete \
        one of them"
    )]
    CoincidentFace { face: u32, first: u32 },
    #[error(
        "the edge between vertices {a} and {b} joins {faces} faces (face {face} is one); leave \
        two, deleting faces that lie on others"
    )]
    NonManifoldEdge {
        a: usize,
        b: usize,
        faces: usize,
        face: u32,
    },
    #[error(
        "face {face} is flipped against its neighbours ({flipped} of {faces} faces are); make the \
        winding agree"
    )]
    MixedWinding {
        face: u32,
        flipped: usize,
        faces: usize,
    },
    #[error(
        "the surface at face {face} has one side only (a Moebius strip); cut it so that its \
        winding can agree"
    )]
    OneSided { face: u32 },

    // ---- materials
    #[error(
        "has no face of the material \"glass\" (OBJ usemtl, glTF material name) for \
        --glass-index; name it so where light goes through, or leave out --glass-index"
    )]
    NoGlass,
    #[error(
        "the design has faces of two materials, which are written as .obj only; name the mesh so"
    )]
    GlassInGlb,

    // ---- normals
    #[error(
        "has no normals to interpolate (OBJ vn, glTF NORMAL); export it with smooth normals, or \
        leave out --normals file"
    )]
    NoNormals,
    #[error("face {face} has normals at some of its corners only; give all of them one, or none")]
    NormalMissing { face: u32 },
    #[error(
        "face {face} refers to a normal that is not among the {normals} of the file; correct the \
        index"
    )]
    NormalOutOfRange { face: u32, normals: usize },
    #[error("face {face} has a normal that is zero or not finite; export the normals again")]
    NormalNoDirection { face: u32 },
    #[error(
        "face {face} has a normal {degrees:.1} degrees off its front, on the other side than \
        those of face {known}; compute the normals again from the faces"
    )]
    NormalBehind { face: u32, degrees: f64, known: u32 },

    // ---- the cell
    #[error(
        "no apex was found (no inner vertex where three perpendicular facets meet, seen from the \
        light): the cell cannot be normalised; merge the facets' vertices, or give --edge-length \
        and --azimuth-zero"
    )]
    NoApex,
    #[error(
        "lies {distance:.1e} edge lengths from the origin, where f64 rounds to {left:.1e} of an \
        edge; move it to the origin"
    )]
    DigitsLost { distance: f64, left: f64 },
    #[error(
        "the rim is not planar (vertex {vertex} is {height:.3e} edge lengths off its plane); \
        flatten it or give --lattice"
    )]
    RimNotPlanar { vertex: usize, height: f64 },
    #[error(
        "the rim is not planar (vertex {vertex} is {height:.1e} edge lengths off its plane), which \
        the rounding of the coordinates (in steps of {step:.0e} file units) can cause; write the \
        mesh with {digits} more digits, or give --lattice"
    )]
    RimRounded {
        vertex: usize,
        height: f64,
        step: f64,
        digits: u32,
    },
    #[error(
        "has {loops} boundary loops (a second one at vertex {vertex}); close the holes, join the \
        cells or give --lattice"
    )]
    SeveralRims { loops: usize, vertex: usize },
    #[error(
        "the rim crosses or touches itself at vertex {vertex}; join the cells along whole edges \
        or give --lattice"
    )]
    RimCrossed { vertex: usize },
    #[error(
        "vertex {vertex} stands {height:.3e} edge lengths above the rim; lower it, or raise the \
        rim to the highest vertex"
    )]
    AboveRim { vertex: usize, height: f64 },
    #[error(
        "is closed but has no flat front face opposite its apex; flatten the front face (if it \
        should be flat, write more digits), or delete it for a hollow cell"
    )]
    NoFrontFace,
    #[error(
        "has {bodies} closed bodies or open parts beside a closed one (face {face}); keep one body"
    )]
    SeveralBodies { bodies: usize, face: u32 },
    #[error(
        "has no lattice, and a rim of {corners} corners that is no parallelogram, so the \
        neighbours are unknown to which the front face sends light; give --lattice, or one period \
        with a parallelogram for a rim, such as `bake design triangular-pair`"
    )]
    NotPeriodic { corners: usize },
    #[error(
        "the lattice vectors are degenerate (parallel, zero or not finite); give two independent \
        ones in file units"
    )]
    LatticeDegenerate,
    #[error(
        "the lattice plane is {degrees:.2} degrees off the plane of the cell; give lattice \
        vectors in the sheet's plane"
    )]
    LatticeTilted { degrees: f64 },
    #[error(
        "the facets cover {covered:.4} lattice cells, more than one; give one period and lattice \
        vectors in file units"
    )]
    LatticeOverfull { covered: f64 },
    #[error(
        "edge length {edge_length} is not usable; give a positive number of file units \
        (--edge-length)"
    )]
    EdgeLength { edge_length: f64 },
    #[error(
        "edge length {edge_length} does not fit a cell {extent} wide; give the length of an edge \
        in file units (--edge-length)"
    )]
    EdgeLengthScale { edge_length: f64, extent: f64 },
    #[error(
        "azimuth zero {x},{y},{z} has no direction in the sheet's plane; give another one \
        (--azimuth-zero)"
    )]
    AzimuthZero { x: f64, y: f64, z: f64 },

    // ---- designs
    #[error("there is no design '{name}'; choose one of {known}")]
    UnknownDesign { name: String, known: String },
    #[error("the design's {option} of {value} is outside {least} to {most}; choose a value inside")]
    DesignOption {
        option: &'static str,
        value: f64,
        least: f64,
        most: f64,
    },
    #[error("design {design} does not take {option}; leave that option out")]
    DesignOptionUnused {
        design: String,
        option: &'static str,
    },
}
