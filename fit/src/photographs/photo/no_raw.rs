//! Refusal of camera raw in a program that was built without the feature `raw`.

use std::path::Path;

use crate::photographs::photo::channel::Decode;
use crate::photographs::photo::error::Error;
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::settings::Settings;

/// Refuses to read a camera raw file.
///
/// # Errors
/// Returns [`Error::CameraRaw`] always.
pub(crate) fn read(path: &Path, _: &Decode) -> Result<Photo, Error> {
    Err(Error::CameraRaw {
        file: path.to_owned(),
    })
}

/// Refuses to read the settings of a camera raw file.
///
/// # Errors
/// Returns a message that names the feature `raw`, always.
pub(crate) fn settings(_: &Path) -> Result<Settings, String> {
    Err("no Exif data that this build of fit can read (it lacks the feature `raw`)".into())
}
