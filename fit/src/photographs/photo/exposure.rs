//! Exposure of a photograph from the settings that the camera wrote into it (Exif 2.32, section
//! 4.6.5).

use std::io::Read;
use std::path::Path;

use exif::{Context, Exif, Field, In, Tag, Value};

use crate::photographs::photo::exif_data;
use crate::photographs::photo::format::{extension, is_raw};
use crate::photographs::photo::pages;
use crate::photographs::photo::raw;
use crate::photographs::photo::settings::{Settings, settings};

impl Settings {
    /// Reads the settings from a JPEG, TIFF, PNG or, with the feature `raw`, camera raw.
    ///
    /// # Errors
    /// Returns what is missing, in words: the names of the missing settings, or that there are no
    /// settings. Returns the error of the system if the file cannot be read.
    pub fn of(image: &Path) -> Result<Settings, String> {
        let mut first = Vec::with_capacity(16);
        let file = crate::document::open(image).map_err(|error| error.to_string())?;
        let read = (&file).take(16).read_to_end(&mut first);
        read.map_err(|error| error.to_string())?;
        if is_raw(&extension(image), &first) || pages::is_raw(&file) {
            return raw::settings(image);
        }
        let file = crate::document::open(image).map_err(|error| error.to_string())?;
        let exif = exif_data::read(file).ok_or("no Exif data")?;
        let tags = [
            Tag::ExposureTime,
            Tag::FNumber,
            Tag::PhotographicSensitivity,
        ];
        settings(tags.map(|tag| number(&exif, tag)))
    }
}

/// Returns the first number of an Exif field.
fn number(exif: &Exif, tag: Tag) -> Option<f64> {
    debug_assert_eq!(tag.context(), Context::Exif);
    let Field { value, .. } = exif.get_field(tag, In::PRIMARY)?;
    Some(match value {
        Value::Rational(numbers) => numbers.first()?.to_f64(),
        other => f64::from(other.get_uint(0)?),
    })
}
