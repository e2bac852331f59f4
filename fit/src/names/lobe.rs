//! Names of the shapes of a lobe.

use serde::{Deserialize, Serialize};

/// The two-dimensional shape of the diffraction lobe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum LobeShape {
    /// sinc^2(a r), cut at a r = 2.4 pi and energy-normalised.
    Radial,
    /// sinc^2(a x) sinc^2(a y).
    Separable,
    /// exp(-(a r)^2): slopes after Beckmann.
    Beckmann,
    /// 1 / (1 + (a r)^2)^2: slopes after GGX.
    Ggx,
}

impl LobeShape {
    /// The shapes of a diffraction lobe; a scene that names none means the first.
    pub const ALL: [LobeShape; 2] = [LobeShape::Radial, LobeShape::Separable];

    /// Their names in files.
    pub const NAMES: [&'static str; 2] = ["radial", "separable"];

    /// The shapes of a baseline's lobe.
    pub const MICROFACETS: [LobeShape; 2] = [LobeShape::Beckmann, LobeShape::Ggx];

    /// The shape of a diffraction lobe by its name in a file.
    pub fn from_name(name: &str) -> Option<LobeShape> {
        LobeShape::ALL
            .into_iter()
            .find(|shape| shape.name() == name)
    }

    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            LobeShape::Radial => "radial",
            LobeShape::Separable => "separable",
            LobeShape::Beckmann => "beckmann",
            LobeShape::Ggx => "ggx",
        }
    }
}
