//! Which blur terms a model has, and how its diffraction spread scales with the floating distance.

use serde::{Deserialize, Serialize};

/// The blur model of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Kernel {
    /// Ray shift and the lobe of Eq. (1), read literally: a (1/mm) does not depend on the floating distance.
    Eq1,
    /// Ray shift and the lobe as an angle (Fraunhofer): a = A / R, the dimensionless A = a R is the parameter.
    Angular,
    /// Ray shift alone.
    Shift,
    /// The lobe of Eq. (1) alone, a in 1/mm.
    Lobe,
    /// Wave optics of the aperture: shift and diffraction from c and the wavelength, no lobe.
    Wave,
}

impl Kernel {
    /// All kernels; among equals the literal Eq. (1) is preferred.
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
        }
    }

    /// Whether the corner size c is part of the model.
    pub const fn has_c(self) -> bool {
        !matches!(self, Kernel::Lobe)
    }

    /// Whether the diffraction lobe, and with it a or A, is part of the model.
    pub const fn has_lobe(self) -> bool {
        !matches!(self, Kernel::Shift | Kernel::Wave)
    }

    /// The divisor that turns the spread parameter into a (1/mm) at floating distance `r_mm`: 1 or R.
    pub fn distance_scale(self, r_mm: f64) -> f64 {
        match self {
            Kernel::Angular => r_mm,
            Kernel::Eq1 | Kernel::Shift | Kernel::Lobe | Kernel::Wave => 1.0,
        }
    }
}

/// One model of the blur at one incidence: what a fit varies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blur {
    /// a in 1/mm (eq1, lobe) or A = a R (angular); ignored by `shift` and `wave`.
    pub spread: f64,
    /// Corner size, mm; ignored by `lobe`.
    pub c_mm: f64,
}
