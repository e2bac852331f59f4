//! Options that only some scenes need, such as roughness and the recording of exit directions; each
//! costs nothing where it is left out.

use crate::options::values::{Element, Front, NormalsFrom};
use std::fmt;
use std::str::FromStr;

/// Options that only some scenes need. As text, as in a table, those that are not at their default.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct SceneOptions {
    /// Normals of facets
    ///
    /// Facets reflect about these normals.
    #[cfg_attr(feature = "cli", arg(long, value_enum, default_value_t = NormalsFrom::Facets))]
    pub normals: NormalsFrom,
    /// Roughness of the facets: ALPHA or ggx:ALPHA
    ///
    /// ALPHA is the roughness of Beckmann's slopes (sqrt 2 times their rms), above 0 and at most 1.
    /// The normal of a facet is drawn anew at each reflection.
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "ALPHA", allow_negative_numbers = true)
    )]
    pub roughness: Option<Roughness>,
    /// Record of exit directions: auto, off or MRAD
    ///
    /// The direction in which each ray leaves is recorded together with its shift: auto (only if
    /// the cell is not ideal), off, or in bins from -MRAD to +MRAD.
    #[cfg_attr(feature = "cli", arg(long, value_name = "MRAD", default_value_t = Record::Auto))]
    pub deviations: Record,
    /// Kind of optical element
    #[cfg_attr(feature = "cli", arg(long, value_enum, default_value_t = Element::Retroreflector))]
    pub element: Element,
    /// Refractive index of bodies of glass
    ///
    /// Light goes through faces of the material named glass, wound outward, and every other face is
    /// a mirror on both sides. Light that leaves straight back within --angular-tolerance counts as
    /// retroreflected.
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "M", allow_negative_numbers = true)
    )]
    pub glass_index: Option<f64>,
    /// Light that meets the front face from inside: once or trapped
    #[cfg_attr(feature = "cli", arg(long, value_enum, default_value_t = Front::Once))]
    pub front: Front,
}

/// Names of the options in a table.
pub(super) const NORMALS: &str = "--normals";
pub(super) const ROUGHNESS: &str = "--roughness";
pub(super) const DEVIATIONS: &str = "--deviations";
pub(super) const ELEMENT: &str = "--element";
pub(super) const GLASS_INDEX: &str = "--glass-index";
pub(super) const FRONT: &str = "--front";

impl fmt::Display for SceneOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut named = Vec::new();
        if self.normals != NormalsFrom::default() {
            named.push(format!("{NORMALS} {}", self.normals.name()));
        }
        if let Some(roughness) = self.roughness {
            named.push(format!("{ROUGHNESS} {roughness}"));
        }
        if self.deviations != Record::default() {
            named.push(format!("{DEVIATIONS} {}", self.deviations));
        }
        if self.element != Element::default() {
            named.push(format!("{ELEMENT} {}", self.element.name()));
        }
        if let Some(index) = self.glass_index {
            named.push(format!("{GLASS_INDEX} {index}"));
        }
        if self.front != Front::default() {
            named.push(format!("{FRONT} {}", self.front.name()));
        }
        f.write_str(&named.join(" "))
    }
}

/// Value of `--deviations`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Record {
    /// Histogram of exit directions if the cell is not ideal; its range follows from the cell and
    /// the angular tolerance.
    #[default]
    Auto,
    /// No histogram of exit directions.
    Off,
    /// Histogram with this range, mrad, whatever the cell.
    Within(f64),
}

impl FromStr for Record {
    type Err = String;

    fn from_str(text: &str) -> Result<Record, String> {
        let number = || text.parse().ok().filter(|x| (1e-3..=1e3).contains(x));
        match text {
            "auto" => Ok(Record::Auto),
            "off" => Ok(Record::Off),
            _ => number()
                .map(Record::Within)
                .ok_or_else(|| "give auto, off, or a range in mrad from 0.001 to 1000".into()),
        }
    }
}

impl fmt::Display for Record {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Record::Auto => f.write_str("auto"),
            Record::Off => f.write_str("off"),
            Record::Within(mrad) => write!(f, "{mrad}"),
        }
    }
}

/// Distribution of the slopes of rough facets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slopes {
    /// Gaussian distribution.
    Beckmann,
    /// Distribution with long tails (Trowbridge and Reitz).
    Ggx,
}

/// Roughness of facets: the distribution of slopes and its width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roughness {
    slopes: Slopes,
    alpha: f64,
}

/// Error of a roughness that is out of range or cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "give ALPHA or ggx:ALPHA, such as 0.001, with ALPHA above 0 and at most 1 (sqrt 2 times the \
    rms slope); leave it out where facets are smooth"
)]
pub struct NoRoughness;

impl Roughness {
    /// Makes a roughness of these slopes; `alpha` must be above 0 and at most 1.
    ///
    /// # Errors
    /// Returns [`NoRoughness`] if `alpha` is out of this range.
    pub fn new(slopes: Slopes, alpha: f64) -> Result<Self, NoRoughness> {
        let fits = alpha > 0.0 && alpha <= 1.0;
        fits.then_some(Roughness { slopes, alpha })
            .ok_or(NoRoughness)
    }

    /// Returns the distribution of the slopes.
    #[inline]
    pub fn slopes(&self) -> Slopes {
        self.slopes
    }

    /// Returns the width of the slopes: for Beckmann, sqrt 2 times their rms.
    #[inline]
    pub fn alpha(&self) -> f64 {
        self.alpha
    }
}

impl FromStr for Roughness {
    type Err = NoRoughness;

    fn from_str(text: &str) -> Result<Self, NoRoughness> {
        let (name, alpha) = text.split_once(':').unwrap_or(("beckmann", text));
        let slopes = match name {
            "beckmann" => Slopes::Beckmann,
            "ggx" => Slopes::Ggx,
            _ => return Err(NoRoughness),
        };
        Roughness::new(slopes, alpha.parse().map_err(|_| NoRoughness)?)
    }
}

impl fmt::Display for Roughness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.slopes {
            Slopes::Beckmann => write!(f, "{}", self.alpha),
            Slopes::Ggx => write!(f, "ggx:{}", self.alpha),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_is_read_back() {
        for record in [Record::Auto, Record::Off, Record::Within(2.5)] {
            assert_eq!(record.to_string().parse(), Ok(record));
        }
        for bad in ["", "on", "0", "-1", "nan", "inf", "5000"] {
            assert!(bad.parse::<Record>().is_err(), "{bad}");
        }
    }
}
