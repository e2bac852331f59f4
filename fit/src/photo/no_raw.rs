//! Camera raw without the feature `raw`: refused, naming it.

use std::path::Path;

use super::{Decode, Error, Photo, Settings};

/// Refuses.
///
/// # Errors
/// Always.
pub(super) fn read(path: &Path, _: &Decode) -> Result<Photo, Error> {
    Err(Error::CameraRaw {
        file: path.to_owned(),
    })
}

/// Refuses.
///
/// # Errors
/// Always.
pub(super) fn settings(_: &Path) -> Result<Settings, String> {
    Err("no Exif data that are read without the feature `raw`".into())
}
