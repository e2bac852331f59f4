//! Options that only some scenes need; each costs nothing where it is left out.

use std::fmt;

use crate::options::deviations::Record;
use crate::options::roughness::Roughness;
use crate::options::values::{Element, Front, NormalsFrom};

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
