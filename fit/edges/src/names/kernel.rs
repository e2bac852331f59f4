//! Names of kernels, and of the published models that they belong to.

use serde::{Deserialize, Serialize};

use crate::names::lobe::LobeShape;

/// The kernel of a model: the set of blur terms of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Kernel {
    /// Ray shift and the lobe of Eq. (1) taken literally: a (1/mm) does not depend on the floating
    /// distance.
    Eq1,
    /// Ray shift and a lobe of fixed angle (Fraunhofer): the free parameter is A = a R, without
    /// unit.
    Angular,
    /// Ray shift alone.
    Shift,
    /// The lobe of Eq. (1) alone, with a in 1/mm.
    Lobe,
    /// Wave optics of the aperture: ray shift and diffraction from c and the wavelength, without a
    /// lobe.
    Wave,
    /// Saito et al. 2024 with a smooth front: three rough facets.
    Saito,
    /// Saito et al. 2024 with a rough front: five rough interfaces.
    #[serde(rename = "saito-surface")]
    SaitoSurface,
    /// Guo et al. 2018: one lobe, from a rough front.
    Guo,
    /// Portsmouth et al. 2026: the minimal retroreflective microfacet model.
    Mrm,
}

/// The model of a sheet: the proposed one or a published baseline.
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
    /// Returns the name in files and options.
    pub const fn name(self) -> &'static str {
        match self {
            Family::Proposed => "proposed",
            Family::Saito => "saito",
            Family::Guo => "guo",
            Family::Mrm => "mrm",
        }
    }

    /// Returns the kernels of the model. Among kernels that fit equally well, earlier ones are
    /// preferred.
    pub const fn kernels(self) -> &'static [Kernel] {
        match self {
            Family::Proposed => &Kernel::ALL,
            Family::Saito => &[Kernel::Saito, Kernel::SaitoSurface],
            Family::Guo => &[Kernel::Guo],
            Family::Mrm => &[Kernel::Mrm],
        }
    }

    /// Returns the shapes that the lobe of the model may have.
    pub const fn shapes(self) -> &'static [LobeShape] {
        match self {
            Family::Proposed => &LobeShape::ALL,
            Family::Saito | Family::Guo | Family::Mrm => &LobeShape::MICROFACETS,
        }
    }

    /// Returns the shapes that are compared where none is chosen.
    pub const fn compared(self) -> &'static [LobeShape] {
        match self {
            Family::Proposed => &LobeShape::COMPARED,
            _ => self.shapes(),
        }
    }
}

impl Kernel {
    /// Returns the divisor that turns the spread parameter into a (1/mm) at the floating distance
    /// `r_mm`: R for `angular`, else 1. It has no meaning for baselines.
    pub fn distance_scale(self, r_mm: f64) -> f64 {
        match self {
            Kernel::Angular => r_mm,
            _ => 1.0,
        }
    }

    /// All kernels of the proposed model. The first is preferred among kernels that fit equally
    /// well.
    pub const ALL: [Kernel; 5] = [
        Kernel::Eq1,
        Kernel::Angular,
        Kernel::Shift,
        Kernel::Lobe,
        Kernel::Wave,
    ];

    /// Names of [`Kernel::ALL`] in files, in the same order.
    pub const NAMES: [&'static str; 5] = ["eq1", "angular", "shift", "lobe", "wave"];

    /// Returns the kernel of the proposed model that has this name in files, or `None`.
    pub fn from_name(name: &str) -> Option<Kernel> {
        Kernel::ALL.into_iter().find(|kernel| kernel.name() == name)
    }

    /// Returns the name in files.
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

    /// Returns the model that the kernel belongs to.
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

    /// Returns whether the kernel is a baseline: a lobe of rough facets, without ray shift.
    pub const fn is_baseline(self) -> bool {
        !matches!(self.family(), Family::Proposed)
    }

    /// Returns whether the kernel has a size that all angles share. The size is the corner size c,
    /// or, for a baseline, the roughness of the front.
    pub const fn has_c(self) -> bool {
        !matches!(
            self,
            Kernel::Lobe | Kernel::Saito | Kernel::Guo | Kernel::Mrm
        )
    }

    /// Returns whether the kernel has a lobe, and with it a spread: a, A or a roughness.
    pub const fn has_lobe(self) -> bool {
        !matches!(self, Kernel::Shift | Kernel::Wave)
    }

    /// Returns whether rays are shifted, without interference of waves.
    pub const fn shifts_rays(self) -> bool {
        matches!(self, Kernel::Eq1 | Kernel::Angular | Kernel::Shift)
    }

    /// Returns whether the blur is computed from waves. It then needs wavelengths and polygons.
    pub const fn has_waves(self) -> bool {
        matches!(self, Kernel::Wave)
    }

    /// Returns whether the blur changes with the floating distance.
    pub const fn uses_distance(self) -> bool {
        !matches!(self, Kernel::Eq1 | Kernel::Shift | Kernel::Lobe)
    }

    /// Returns the kernel in words, for a reader who does not know its name.
    pub const fn description(self) -> &'static str {
        match self {
            Kernel::Eq1 => "blur by ray shift and by the diffraction lobe of Eq. (1)",
            Kernel::Angular => {
                "blur by ray shift and by a diffraction lobe of fixed angle, a = A/R"
            }
            Kernel::Shift => "blur by ray shift alone",
            Kernel::Lobe => "blur by the diffraction lobe of Eq. (1) alone",
            Kernel::Wave => "blur by ray shift and diffraction together, from wave optics",
            Kernel::Saito => "blur by three rough facets behind a smooth front (Saito et al. 2024)",
            Kernel::SaitoSurface => {
                "blur by three rough facets behind a rough front (Saito et al. 2024)"
            }
            Kernel::Guo => "blur by a rough front (Guo et al. 2018)",
            Kernel::Mrm => "blur by the lobe of a rough mirror (Portsmouth et al. 2026)",
        }
    }

    /// Names the causes of blur in words, for a sentence of a report.
    pub fn causes(self, lobe: Option<LobeShape>) -> String {
        let lobe = match lobe {
            Some(shape) => format!("a {} lobe", shape.name()),
            None => "a lobe".into(),
        };
        match self {
            Kernel::Eq1 => {
                format!("the ray shift and {lobe} whose width does not change with the distance")
            }
            Kernel::Angular => format!("the ray shift and {lobe} whose width grows with the distance"),
            Kernel::Shift => "the ray shift alone".into(),
            Kernel::Lobe => format!("{lobe} alone"),
            Kernel::Wave => {
                "wave optics, which computes ray shift and diffraction together from the size of the \
                 cubes and the wavelength of the light"
                    .into()
            }
            Kernel::Saito => format!("{lobe} of three rough facets (Saito et al. 2024)"),
            Kernel::SaitoSurface => {
                format!("{lobe} of a rough front face and three rough facets (Saito et al. 2024)")
            }
            Kernel::Guo => format!("{lobe} of a rough front face (Guo et al. 2018)"),
            Kernel::Mrm => {
                format!("{lobe} of rough facets that reflect light back (Portsmouth et al. 2026)")
            }
        }
    }
}
