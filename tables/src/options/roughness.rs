//! How rough facets are, in numbers; `bake` says what that does to light.

use std::fmt;
use std::str::FromStr;

/// How slopes are distributed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slopes {
    /// As a Gaussian.
    Beckmann,
    /// With long tails (Trowbridge and Reitz).
    Ggx,
}

/// How rough facets are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roughness {
    slopes: Slopes,
    alpha: f64,
}

/// A roughness that is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "give ALPHA or ggx:ALPHA, such as 0.001, with ALPHA above 0 and at most 1 (sqrt 2 times the \
    rms slope); leave it out \
     where facets are smooth"
)]
pub struct NoRoughness;

impl Roughness {
    /// Slopes of the roughness `alpha`, above 0 and at most 1.
    ///
    /// # Errors
    /// [`NoRoughness`].
    pub fn new(slopes: Slopes, alpha: f64) -> Result<Self, NoRoughness> {
        let fits = alpha > 0.0 && alpha <= 1.0;
        fits.then_some(Roughness { slopes, alpha })
            .ok_or(NoRoughness)
    }

    /// How slopes are distributed.
    #[inline]
    pub fn slopes(&self) -> Slopes {
        self.slopes
    }

    /// The width of the slopes: sqrt 2 times their rms of Beckmann's.
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
