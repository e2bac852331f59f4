//! File formats of plots, recognised by the extension of a file.

use std::path::Path;

use crate::error::Error;

/// File format of a plot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlotFormat {
    /// Vector graphics.
    Svg,
    /// Pixel graphics.
    Png,
}

impl PlotFormat {
    /// Returns the format that the extension of `file` names, in small letters or capitals.
    ///
    /// # Errors
    /// Returns [`Error::PlotExtension`] if the extension names no format of plots.
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
