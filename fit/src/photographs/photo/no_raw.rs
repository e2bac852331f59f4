//! Camera raw without the feature `raw`: refused, naming it.

use std::path::Path;

use crate::photographs::photo::channel::Decode;
use crate::photographs::photo::error::Error;
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::settings::Settings;

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
