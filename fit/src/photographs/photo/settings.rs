//! Settings of a camera that decide the exposure.

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
    /// Returns the signal per unit of light: seconds x ISO / f-number^2.
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

/// Checks seconds, f-number and ISO, and returns them as settings.
///
/// # Errors
/// Returns the names of the settings that are missing, not finite or not above 0, in words.
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
