//! The transfer that a PNG, TIFF or JPEG states.

use std::io::BufReader;
use std::path::Path;

use crate::photographs::photo::error::Error;
use crate::photographs::photo::format::Format;
use crate::photographs::photo::taken::Curves;
use crate::photographs::photo::{chunks, colour_space, exif_data, icc};

/// Name of the profile of a JPEG or TIFF.
const PROFILE: &str = "ICC profile";

/// Returns the curves that a file states, or `None` if it states none.
///
/// `colour` says whether the picture has colours. `profile` returns the profile of a JPEG or TIFF,
/// and fails, in words, if the profile is damaged.
///
/// # Errors
/// Returns [`Error::Tone`] if the statement cannot be followed, and [`Error::Io`] if the file
/// cannot be read.
pub(crate) fn curves(
    path: &Path,
    format: Format,
    colour: bool,
    profile: impl FnOnce() -> Result<Option<Vec<u8>>, String>,
) -> Result<Option<Curves>, Error> {
    let tone = |(part, reason)| Error::Tone {
        file: path.to_owned(),
        part,
        reason,
    };
    let open = || {
        let file = crate::document::open(path).map_err(|source| Error::Io {
            file: path.to_owned(),
            source,
        })?;
        Ok(BufReader::new(file))
    };
    let profile = match format {
        Format::Png => return chunks::curves(&mut open()?, colour).map_err(tone),
        Format::Tiff | Format::Jpeg => profile(),
        Format::Exr | Format::Raw => Ok(None),
    };
    let curves = profile.and_then(|profile| {
        let read = profile.map(|bytes| icc::curves(&bytes, PROFILE, colour));
        read.transpose()
    });
    let curves = curves.map_err(|reason| tone((PROFILE, reason)))?;
    if curves.is_some() || format != Format::Jpeg {
        return Ok(curves);
    }
    let exif = exif_data::read(open()?.into_inner());
    Ok(exif.as_ref().and_then(colour_space::curves))
}
