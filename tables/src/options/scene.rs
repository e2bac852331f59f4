//! Options that only some scenes need; each costs nothing where it is left out.

use std::fmt;

use crate::options::deviations::Record;
use crate::options::roughness::Roughness;
use crate::options::values::{Element, NormalsFrom};

/// Options that only some scenes need. As text, as in a table, those that are not at their default.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct SceneOptions {
    /// Normals about which facets reflect
    #[cfg_attr(feature = "cli", arg(long, value_enum, default_value_t = NormalsFrom::Facets))]
    pub normals: NormalsFrom,
    /// Roughness of the facets, whose normals are drawn at each reflection: alpha of Beckmann's
    /// slopes (sqrt 2 times their rms) or ggx:ALPHA
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "ALPHA", allow_negative_numbers = true)
    )]
    pub roughness: Option<Roughness>,
    /// Records the direction in which each ray leaves, together with its shift: auto (only if the
    /// cell is not ideal), off, or bins from -MRAD to +MRAD
    #[cfg_attr(feature = "cli", arg(long, value_name = "MRAD", default_value_t = Record::Auto))]
    pub deviations: Record,
    /// Optical element that the mesh is
    #[cfg_attr(feature = "cli", arg(long, value_enum, default_value_t = Element::Retroreflector))]
    pub element: Element,
    /// Refractive index of bodies of glass: light goes through faces of the material named glass,
    /// wound outward, and every other face is a mirror on both sides. Light that leaves straight
    /// back within --angular-tolerance then counts as retroreflected
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "M", allow_negative_numbers = true)
    )]
    pub glass_index: Option<f64>,
}

/// Names of the options in a table.
pub(super) const NORMALS: &str = "--normals";
pub(super) const ROUGHNESS: &str = "--roughness";
pub(super) const DEVIATIONS: &str = "--deviations";
pub(super) const ELEMENT: &str = "--element";
pub(super) const GLASS_INDEX: &str = "--glass-index";

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
        f.write_str(&named.join(" "))
    }
}
