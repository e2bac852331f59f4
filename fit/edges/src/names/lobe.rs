//! Names of the shapes of a lobe.

use serde::{Deserialize, Serialize};

/// The two-dimensional shape of a lobe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum LobeShape {
    /// sinc^2(a r), cut at a r = 2.4 pi, with total light 1.
    #[default]
    Radial,
    /// sinc^2(a x) sinc^2(a y), not cut.
    Separable,
    /// exp(-(a r)^2): the curve of `beckmann`, offered as a diffraction lobe.
    Gaussian,
    /// exp(-(a r)^2): the facets' slopes are distributed after Beckmann.
    Beckmann,
    /// 1 / (1 + (a r)^2)^2: the facets' slopes are distributed after GGX.
    Ggx,
}

impl LobeShape {
    /// The shapes of a diffraction lobe. The first is the default of a scene that names none.
    pub const ALL: [LobeShape; 3] = [LobeShape::Radial, LobeShape::Separable, LobeShape::Gaussian];

    /// Names of [`LobeShape::ALL`] in files, in the same order.
    pub const NAMES: [&'static str; 3] = ["radial", "separable", "gaussian"];

    /// The shapes that are compared where none is chosen: the two readings of Eq. (1).
    pub const COMPARED: [LobeShape; 2] = [LobeShape::Radial, LobeShape::Separable];

    /// The shapes of a baseline's lobe.
    pub const MICROFACETS: [LobeShape; 2] = [LobeShape::Beckmann, LobeShape::Ggx];

    /// Returns the shape of a diffraction lobe that has this name in files, or `None`.
    pub fn from_name(name: &str) -> Option<LobeShape> {
        LobeShape::ALL
            .into_iter()
            .find(|shape| shape.name() == name)
    }

    /// Returns another shape of a diffraction lobe, one that is compared.
    pub const fn other(self) -> LobeShape {
        match self {
            LobeShape::Radial => LobeShape::Separable,
            LobeShape::Separable | LobeShape::Gaussian | LobeShape::Beckmann | LobeShape::Ggx => {
                LobeShape::Radial
            }
        }
    }

    /// Returns the name in files.
    pub const fn name(self) -> &'static str {
        match self {
            LobeShape::Radial => "radial",
            LobeShape::Separable => "separable",
            LobeShape::Gaussian => "gaussian",
            LobeShape::Beckmann => "beckmann",
            LobeShape::Ggx => "ggx",
        }
    }

    /// Returns a sentence on the shape, for a reader who does not know its name.
    pub const fn description(self) -> &'static str {
        match self {
            LobeShape::Radial => "A radial lobe is round.",
            LobeShape::Separable => {
                "A separable lobe is the product of one curve along each axis of the image."
            }
            LobeShape::Gaussian => "A gaussian lobe is round and follows the normal distribution.",
            LobeShape::Beckmann => {
                "The name beckmann stands for a standard formula for the slopes of a rough surface."
            }
            LobeShape::Ggx => {
                "The name ggx stands for a standard formula for the slopes of a rough surface."
            }
        }
    }
}
