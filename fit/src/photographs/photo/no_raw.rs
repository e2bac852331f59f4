//! Camera raw without the feature `raw`: refused, naming it.

use std::path::Path;

use crate::photographs::photo::{Decode, Error, Photo, Settings};

/// Refuses.
///
/// # Errors
/// Always.
pub(crate) fn read(path: &Path, _: &Decode) -> Result<Photo, Error> {
    Err(Error::CameraRaw {
        file: path.to_owned(),
    })
}

/// Refuses.
///
/// # Errors
/// Always.
pub(crate) fn settings(_: &Path) -> Result<Settings, String> {
    Err("no Exif data that are read without the feature `raw`".into())
}
