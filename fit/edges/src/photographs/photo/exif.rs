//! What a camera wrote into the Exif data of a file: its settings, the side that is up, and the
//! colour space (Exif 2.32).

use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

use exif::{Exif, In, Reader, Tag, Value};

use crate::photographs::photo::formats::{pages, raw};
use crate::photographs::photo::{Curve, Curves, Transfer, caught, extension, is_raw};

/// Settings of a camera that decide the exposure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Shutter time, seconds, > 0.
    pub seconds: f64,
    /// Ratio of the focal length to the aperture, > 0.
    pub f_number: f64,
    /// ISO sensitivity, > 0.
    pub iso: f64,
}

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
        let exif = self::read(BufReader::new(file)).ok_or("no Exif data")?;
        let tags = [
            Tag::ExposureTime,
            Tag::FNumber,
            Tag::PhotographicSensitivity,
        ];
        Settings::new(tags.map(|tag| number(&exif, tag)))
    }

    /// Checks seconds, f-number and ISO.
    ///
    /// # Errors
    /// Returns the names of the settings that are missing, not finite or not above 0, in words.
    pub(crate) fn new(found: [Option<f64>; 3]) -> Result<Settings, String> {
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

    /// Returns the signal per unit of light: seconds x ISO / f-number^2.
    pub fn exposure(&self) -> f64 {
        self.seconds * self.iso / (self.f_number * self.f_number)
    }

    /// Returns the shutter time for which a rounded one stands, seconds.
    ///
    /// Cameras open the shutter for a power of two in thirds or halves of a stop, and write what
    /// photographers call it: 1/60 for 1/64, 1/13 for 1/12.7. The nearest such power is returned.
    pub fn seconds_in_stops(&self) -> f64 {
        let stops = self.seconds.log2();
        let nearest = |parts: f64| (stops * parts).round() / parts;
        let [thirds, halves] = [nearest(3.0), nearest(2.0)];
        let is_third = (thirds - stops).abs() <= (halves - stops).abs();
        (if is_third { thirds } else { halves }).exp2()
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

/// Reads the Exif data of a JPEG, TIFF or PNG as far as they can be read. Returns `None` if there
/// are none.
pub fn read(mut file: impl BufRead + Seek) -> Option<Exif> {
    // A damaged entry must not hide the others.
    let read = caught(|| {
        let mut reader = Reader::new();
        let read = reader
            .continue_on_error(true)
            .read_from_container(&mut file);
        read.or_else(|error| error.distill_partial_result(|_| ()))
    });
    read.ok()?.ok().filter(|exif| exif.fields().len() > 0)
}

/// Returns the first number of a field.
fn number(exif: &Exif, tag: Tag) -> Option<f64> {
    Some(match &exif.get_field(tag, In::PRIMARY)?.value {
        Value::Rational(numbers) => numbers.first()?.to_f64(),
        other => f64::from(other.get_uint(0)?),
    })
}

/// Returns the number of the side that is up, from 1 to 8.
pub(crate) fn orientation(exif: &Exif) -> Option<u64> {
    number(exif, Tag::Orientation).map(|number| number as u64)
}

/// Exponent of the curve of Adobe RGB (Adobe RGB (1998) Color Image Encoding, section 4.3.4.2).
const ADOBE_RGB: f64 = 563.0 / 256.0;

/// Returns the curve of the colour space that Exif data name. Returns `None` for sRGB, which is the
/// default, and if they name none.
///
/// Cameras name Adobe RGB in two parts (DCF 2.0, the "optional file"): the tag `ColorSpace` is
/// "uncalibrated", and the interoperability index is "R03". Many of them add no ICC profile. A space
/// that is not sRGB and has no name is read as sRGB, with a doubt.
pub(crate) fn curves(exif: &Exif) -> Option<Curves> {
    const SRGB: u32 = 1;
    const UNCALIBRATED: u32 = 0xffff;
    let space = exif.get_field(Tag::ColorSpace, In::PRIMARY)?;
    let space = space.value.get_uint(0).filter(|&space| space != SRGB)?;
    let index = exif.get_field(Tag::InteroperabilityIndex, In::PRIMARY);
    let is_optional = index.is_some_and(|field| match &field.value {
        Value::Ascii(texts) => texts.first().is_some_and(|text| text == b"R03"),
        _ => false,
    });
    if space == UNCALIBRATED && is_optional {
        return Some(Curves::one(Curve::Power(ADOBE_RGB), "Exif: Adobe RGB"));
    }
    let mut curves = Curves::one(Curve::Named(Transfer::Srgb), "default of 8 bits");
    curves.doubt = Some(
        "its Exif data say that its colours are not sRGB, but not which curve they have, so that \
        of sRGB was taken; convert the photograph to sRGB or to linear light, or set `transfer`"
            .into(),
    );
    Some(curves)
}
