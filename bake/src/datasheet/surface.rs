//! Surfaces of the facets that a data sheet compares.

use crate::optics::{Backing, Rules};
use num_complex::Complex64;
use tables::options::{Element, Front};

/// Surface of the facets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surface {
    /// Ideal mirrors without losses: the geometry alone.
    Mirrors,
    /// Metal, aluminium unless another one was asked for, with the losses of a front face.
    Metal,
    /// No coating: total internal reflection and Fresnel's partial reflection, with the losses of a
    /// front face.
    TotalReflection,
}

impl Surface {
    /// All surfaces.
    pub const ALL: [Surface; 3] = [Surface::Mirrors, Surface::Metal, Surface::TotalReflection];

    /// Returns the surfaces that a cell of this refractive index can have.
    ///
    /// A hollow cell (index 1) has no total reflection.
    pub fn of_index(refractive_index: f64) -> &'static [Surface] {
        match refractive_index > 1.0 {
            true => &Surface::ALL,
            false => &Surface::ALL[..2],
        }
    }

    /// Returns the name in CSV and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Surface::Mirrors => "mirrors",
            Surface::Metal => "metal",
            Surface::TotalReflection => "total_reflection",
        }
    }

    /// Returns the name for a person; `metal` is that of the metal.
    pub(crate) fn title(self, metal: &str) -> String {
        match self {
            Surface::Mirrors => "ideal mirrors".into(),
            Surface::Metal => metal.into(),
            Surface::TotalReflection => "total reflection".into(),
        }
    }

    /// Returns the rules by which facets change light.
    pub(crate) fn rules(
        self,
        refractive_index: f64,
        metal: Complex64,
        angular_tolerance_rad: f64,
    ) -> Rules {
        Rules {
            refractive_index,
            mirror_back: self != Surface::TotalReflection,
            losses: match self {
                Surface::Mirrors => None,
                Surface::Metal => Some(Backing::Metal(metal)),
                Surface::TotalReflection => Some(Backing::Bare),
            },
            angular_tolerance_rad,
            roughness: None,
            element: Element::Retroreflector,
            glass_index: None,
            front: Front::Once,
        }
    }
}
