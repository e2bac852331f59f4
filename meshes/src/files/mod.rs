//! Files of meshes: OBJ, glTF, GLB, STL and PLY read, the first three written.
//!
//! A path or bytes enter and a mesh leaves, with sizes bounded before memory is allocated; or a
//! mesh enters and bytes leave.

pub(crate) mod buffer;
pub(crate) mod glb;
pub mod gltf;
pub(crate) mod load;
pub mod obj;
pub mod ply;
pub mod stl;
pub mod write;
