//! Refusal of camera raw in a program that was built without the feature `raw`.

use std::path::Path;

use crate::photographs::photo::{Decode, Fault, Photo, Settings};

/// Refuses to read a camera raw file.
///
/// # Errors
/// Returns [`Fault::Raw`] always.
pub(in crate::photographs::photo) fn read(_: &Path, _: &Decode) -> Result<Photo, Fault> {
    Err(Fault::Raw(
        "camera raw is not read by this build of fit; build it with the feature `raw` (cargo \
        install --path fit --features raw), or"
            .into(),
    ))
}

/// Refuses to read the settings of a camera raw file.
///
/// # Errors
/// Returns a message that names the feature `raw`, always.
pub(crate) fn settings(_: &Path) -> Result<Settings, String> {
    Err("no Exif data that this build of fit can read (it lacks the feature `raw`)".into())
}
