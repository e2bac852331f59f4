//! The exposure of a photograph from what the camera wrote into it (Exif 2.32, section 4.6.5).

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use exif::{Context, Exif, Field, In, Tag, Value};

/// Settings of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Shutter time, s, > 0.
    pub seconds: f64,
    /// Focal length over aperture, > 0.
    pub f_number: f64,
    /// ISO sensitivity, > 0.
    pub iso: f64,
}

impl Settings {
    /// Reads them from a JPEG, TIFF, PNG or, with the feature `raw`, camera raw.
    ///
    /// # Errors
    /// What is missing, in words: the settings by name, or that there are none at all.
    pub fn of(image: &Path) -> Result<Settings, String> {
        let mut first = Vec::with_capacity(16);
        let file = File::open(image).map_err(|error| error.to_string())?;
        let read = file.take(16).read_to_end(&mut first);
        read.map_err(|error| error.to_string())?;
        if crate::photographs::photo::is_raw(&crate::photographs::photo::extension(image), &first) {
            return crate::photographs::photo::raw::settings(image);
        }
        let none = || "no Exif data".to_owned();
        let file = File::open(image).map_err(|error| error.to_string())?;
        // A damaged entry is no reason to lose the others.
        let exif = exif::Reader::new()
            .continue_on_error(true)
            .read_from_container(&mut BufReader::new(file))
            .or_else(|error| error.distill_partial_result(|_| ()))
            .map_err(|_| none())?;
        if exif.fields().len() == 0 {
            return Err(none());
        }
        let tags = [
            Tag::ExposureTime,
            Tag::FNumber,
            Tag::PhotographicSensitivity,
        ];
        settings(tags.map(|tag| number(&exif, tag)))
    }

    /// Signal per unit of light: seconds x ISO / f-number^2.
    pub fn exposure(&self) -> f64 {
        self.seconds * self.iso / (self.f_number * self.f_number)
    }
}

impl std::fmt::Display for Settings {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Settings {
            seconds,
            f_number,
            iso,
        } = self;
        write!(formatter, "{seconds} s, f/{f_number}, ISO {iso}")
    }
}

/// Settings of seconds, f-number and ISO, where all are there, finite and above 0.
///
/// # Errors
/// Which are not, in words.
pub(crate) fn settings(found: [Option<f64>; 3]) -> Result<Settings, String> {
    let positive = found.map(|number| number.filter(|n| n.is_finite() && *n > 0.0));
    if let [Some(seconds), Some(f_number), Some(iso)] = positive {
        return Ok(Settings {
            seconds,
            f_number,
            iso,
        });
    }
    let names = ["ExposureTime", "FNumber", "PhotographicSensitivity (ISO)"];
    let lacking = names.iter().zip(positive).filter(|(_, n)| n.is_none());
    let lacking: Vec<&str> = lacking.map(|(name, _)| *name).collect();
    Err(format!("no {} in its Exif data", lacking.join(", no ")))
}

/// The first number of a field.
fn number(exif: &Exif, tag: Tag) -> Option<f64> {
    debug_assert_eq!(tag.context(), Context::Exif);
    let Field { value, .. } = exif.get_field(tag, In::PRIMARY)?;
    Some(match value {
        Value::Rational(numbers) => numbers.first()?.to_f64(),
        other => f64::from(other.get_uint(0)?),
    })
}
