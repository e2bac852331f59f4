//! TOML files, read into structs by the crate `documents`, and the spectra in them.

use serde::Deserialize;
use serde::de::{Deserializer, Error as _};
use toml::Value;

use crate::names::Spectrum;

pub use documents::*;

/// Reads a spectrum: a number, or text that [`Spectrum::parse`] reads.
pub fn spectrum<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Spectrum>, D::Error> {
    let spectrum = match Value::deserialize(value)? {
        Value::String(text) => Spectrum::parse(&text),
        Value::Float(number) => Spectrum::monochromatic(number),
        Value::Integer(number) => Spectrum::monochromatic(number as f64),
        other => {
            let found = other.type_str();
            return Err(D::Error::custom(format!(
                "must be a number or a text such as \"450:0.2,550:0.5\", not of type {found}; \
                change the value"
            )));
        }
    };
    spectrum.map(Some).map_err(D::Error::custom)
}
