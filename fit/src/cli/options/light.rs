//! The options of the light in which a mid-air image is looked at.

use crate::cli::options::parse;

/// Luminance of the source and of what is seen through the image.
#[derive(Debug, Clone, Copy, clap::Args)]
#[command(next_help_heading = "Light")]
pub(crate) struct Light {
    /// Luminance of the white of the source, cd/m2.
    ///
    /// Luminances are then given in cd/m2 too.
    #[arg(
        long,
        value_name = "CD_M2",
        value_parser = parse::positive,
        allow_negative_numbers = true
    )]
    pub luminance: Option<f64>,
    /// Luminance behind the image, in units of the white of the source.
    ///
    /// It is the light of the scene that is seen through the mid-air image.
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.0,
        value_parser = parse::not_negative,
        allow_negative_numbers = true
    )]
    pub ambient: f64,
    /// Luminance behind the image, cd/m2 (nits), in place of --ambient.
    #[arg(
        long,
        value_name = "CD_M2",
        value_parser = parse::not_negative,
        allow_negative_numbers = true,
        requires = "luminance",
        conflicts_with = "ambient"
    )]
    pub ambient_nits: Option<f64>,
}

impl Light {
    /// Returns the luminance behind the image, in units of the white of the source.
    pub(crate) fn ambient(&self) -> f64 {
        let nits = self.ambient_nits.zip(self.luminance);
        nits.map_or(self.ambient, |(nits, source)| nits / source)
    }
}
