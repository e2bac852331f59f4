//! The exposure of a photograph from what the camera wrote into it (Exif 2.32, section 4.6.5).

use std::fs::File;
use std::io::BufReader;
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
    /// Reads them from a JPEG, TIFF or PNG.
    ///
    /// # Errors
    /// What is missing, in words: the settings by name, or that there are none at all.
    pub fn of(image: &Path) -> Result<Settings, String> {
        let none = || "no Exif data".to_owned();
        let file = File::open(image).map_err(|error| error.to_string())?;
        // A damaged entry is no reason to lose the others.
        let exif = exif::Reader::new()
            .continue_on_error(true)
            .read_from_container(&mut BufReader::new(file))
            .or_else(|error| error.distill_partial_result(|_| ()))
            .map_err(|_| none())?;
        let found = [
            ("ExposureTime", Tag::ExposureTime),
            ("FNumber", Tag::FNumber),
            (
                "PhotographicSensitivity (ISO)",
                Tag::PhotographicSensitivity,
            ),
        ]
        .map(|(name, tag)| positive(&exif, tag).ok_or(name));
        match found {
            [Ok(seconds), Ok(f_number), Ok(iso)] => Ok(Settings {
                seconds,
                f_number,
                iso,
            }),
            _ if exif.fields().len() == 0 => Err(none()),
            _ => {
                let lacking: Vec<&str> = found.into_iter().filter_map(Result::err).collect();
                Err(format!("no {} in its Exif data", lacking.join(", no ")))
            }
        }
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

/// The first number of a field, where it is finite and above 0.
fn positive(exif: &Exif, tag: Tag) -> Option<f64> {
    debug_assert_eq!(tag.context(), Context::Exif);
    let Field { value, .. } = exif.get_field(tag, In::PRIMARY)?;
    let number = match value {
        Value::Rational(numbers) => numbers.first()?.to_f64(),
        other => f64::from(other.get_uint(0)?),
    };
    (number.is_finite() && number > 0.0).then_some(number)
}
