//! Roughness of facets in numbers; `bake` computes its effect on light.

use std::fmt;
use std::str::FromStr;

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
