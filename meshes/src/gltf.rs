//! glTF
use crate::error::Fault;
use crate::mesh::Mesh;
use std::path::Path;
/// Parse
pub fn parse(_bytes: &[u8], _folder: Option<&Path>) -> Result<Mesh, Fault> {
    Err(Fault::Empty)
}
