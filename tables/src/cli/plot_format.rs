//! The formats that plots are written in, as the name of a file says them.

use std::path::Path;

use crate::cli::error::Error;

/// A format of plots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlotFormat {
    /// Vectors.
    Svg,
    /// Pixels.
    Png,
}

impl PlotFormat {
    /// Returns the format that the extension of `file` names, in small letters or capitals.
    ///
    /// # Errors
    /// [`Error::PlotExtension`] when it names none.
    pub fn of(file: &Path) -> Result<PlotFormat, Error> {
        let extension = file
            .extension()
            .map(|extension| extension.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("svg") => Ok(PlotFormat::Svg),
            Some("png") => Ok(PlotFormat::Png),
            _ => Err(Error::PlotExtension(file.to_owned())),
        }
    }
}
