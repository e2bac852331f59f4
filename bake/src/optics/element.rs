//! What an element is to do with light: where it makes the image, and on which plane a shift is measured.

use glam::{DMat3, DVec3};
use tables::Fate;

/// Kinds of element, by the image that they make.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Element {
    /// Sends light back: the image is where the object is
    #[default]
    Retroreflector,
    /// Lets light through, as a micro-mirror array plate: the image is the object's mirror image behind the plate
    Plate,
}

impl Element {
    /// The name in options.
    pub const fn name(self) -> &'static str {
        match self {
            Element::Retroreflector => "retroreflector",
            Element::Plate => "plate",
        }
    }

    /// The linear map of a path that makes the image: -I, or both components along the plate turned round.
    pub const fn imaging(self) -> DMat3 {
        let along_normal = match self {
            Element::Retroreflector => -1.0,
            Element::Plate => 1.0,
        };
        DMat3::from_cols_array(&[-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, along_normal])
    }

    /// The direction `left`, turned so that light which makes the image goes straight back.
    pub fn straight_back(self, left: DVec3) -> DVec3 {
        -(self.imaging() * left)
    }

    /// Height of the plane that the lines of light are extended to, where it enters and where it leaves, for their distance
    /// to be the shift: the entrance plane, or the middle one between `height`, the entrance's, and `bottom`.
    pub fn plane(self, height: f64, bottom: f64) -> f64 {
        match self {
            Element::Retroreflector => height,
            Element::Plate => f64::midpoint(height, bottom),
        }
    }

    /// The fate of light that meets nothing.
    pub const fn unmet(self) -> Fate {
        match self {
            Element::Retroreflector => Fate::Missed,
            Element::Plate => Fate::Transmitted,
        }
    }
}
