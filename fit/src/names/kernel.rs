//! Names of the blur terms that a model has, and whose model it is.

use serde::{Deserialize, Serialize};

use crate::names::lobe::LobeShape;

/// The blur model of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Kernel {
    /// Ray shift and the lobe of Eq. (1), read literally: a (1/mm) does not depend on the floating
    /// distance.
    Eq1,
    /// Ray shift and the lobe as an angle (Fraunhofer): a = A / R, the dimensionless A = a R is the
    /// parameter.
    Angular,
    /// Ray shift alone.
    Shift,
    /// The lobe of Eq. (1) alone, a in 1/mm.
    Lobe,
    /// Wave optics of the aperture: shift and diffraction from c and the wavelength, no lobe.
    Wave,
    /// Saito et al. 2024 with a smooth front: three rough facets (see `baseline`).
    Saito,
    /// The same with a rough front: five rough interfaces.
    #[serde(rename = "saito-surface")]
    SaitoSurface,
    /// Guo et al. 2018: a rough front.
    Guo,
    /// Portsmouth et al. 2026, the minimal retroreflective microfacet model.
    Mrm,
}

/// Whose model of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// Ray shift and diffraction
    #[default]
    Proposed,
    /// Saito, Yue and Koizumi 2024: microfacets on five interfaces
    Saito,
    /// Guo, Guo and Pan 2018: prismatic sheeting with a rough front
    Guo,
    /// Portsmouth et al. 2026: the minimal retroreflective microfacet model
    Mrm,
}

impl Family {
    /// The name in files and options.
    pub const fn name(self) -> &'static str {
        match self {
            Family::Proposed => "proposed",
            Family::Saito => "saito",
            Family::Guo => "guo",
            Family::Mrm => "mrm",
        }
    }

    /// Its kernels, in the order of preference among equals.
    pub const fn kernels(self) -> &'static [Kernel] {
        match self {
            Family::Proposed => &Kernel::ALL,
            Family::Saito => &[Kernel::Saito, Kernel::SaitoSurface],
            Family::Guo => &[Kernel::Guo],
            Family::Mrm => &[Kernel::Mrm],
        }
    }

    /// Shapes of its lobe.
    pub const fn shapes(self) -> &'static [LobeShape] {
        match self {
            Family::Proposed => &LobeShape::ALL,
            Family::Saito | Family::Guo | Family::Mrm => &LobeShape::MICROFACETS,
        }
    }
}

impl Kernel {
    /// All kernels of the proposed model; among equals the literal Eq. (1) is preferred.
    pub const ALL: [Kernel; 5] = [
        Kernel::Eq1,
        Kernel::Angular,
        Kernel::Shift,
        Kernel::Lobe,
        Kernel::Wave,
    ];

    /// Their names in files.
    pub const NAMES: [&'static str; 5] = ["eq1", "angular", "shift", "lobe", "wave"];

    /// The kernel of a name in a file.
    pub fn from_name(name: &str) -> Option<Kernel> {
        Kernel::ALL.into_iter().find(|kernel| kernel.name() == name)
    }

    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Kernel::Eq1 => "eq1",
            Kernel::Angular => "angular",
            Kernel::Shift => "shift",
            Kernel::Lobe => "lobe",
            Kernel::Wave => "wave",
            Kernel::Saito => "saito",
            Kernel::SaitoSurface => "saito-surface",
            Kernel::Guo => "guo",
            Kernel::Mrm => "mrm",
        }
    }

    /// Whose model it is.
    pub const fn family(self) -> Family {
        match self {
            Kernel::Eq1 | Kernel::Angular | Kernel::Shift | Kernel::Lobe | Kernel::Wave => {
                Family::Proposed
            }
            Kernel::Saito | Kernel::SaitoSurface => Family::Saito,
            Kernel::Guo => Family::Guo,
            Kernel::Mrm => Family::Mrm,
        }
    }

    /// Whether it is a baseline: a lobe of rough facets, no ray shift.
    pub const fn is_baseline(self) -> bool {
        !matches!(self.family(), Family::Proposed)
    }

    /// Whether a second size is part of the model, one for all angles: the corner size c, of a
    /// baseline the roughness of the front.
    pub const fn has_c(self) -> bool {
        !matches!(
            self,
            Kernel::Lobe | Kernel::Saito | Kernel::Guo | Kernel::Mrm
        )
    }

    /// Whether a lobe, and with it a, A or a roughness, is part of the model.
    pub const fn has_lobe(self) -> bool {
        !matches!(self, Kernel::Shift | Kernel::Wave)
    }
}
