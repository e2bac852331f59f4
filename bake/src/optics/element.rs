//! What an element is to do with light: where it makes the image, and on which plane a shift is
//! measured.

use glam::{DMat3, DVec3};
use tables::Fate;
use tables::options::Element;

/// The linear map of a path that makes the image: -I, or both components along the plate turned
/// round.
pub(crate) const fn imaging(element: Element) -> DMat3 {
    let along_normal = match element {
        Element::Retroreflector => -1.0,
        Element::Plate => 1.0,
    };
    DMat3::from_cols_array(&[-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, along_normal])
}

/// The direction `left`, turned so that light which makes the image goes straight back.
pub(crate) fn straight_back(element: Element, left: DVec3) -> DVec3 {
    -(imaging(element) * left)
}

/// Height of the plane that the lines of light are extended to, where it enters and where it
/// leaves, for their distance to be the shift: the entrance plane, or the middle one between
/// `height`, the entrance's, and `bottom`.
pub(crate) fn plane(element: Element, height: f64, bottom: f64) -> f64 {
    match element {
        Element::Retroreflector => height,
        Element::Plate => f64::midpoint(height, bottom),
    }
}

/// The fate of light that meets nothing.
pub(crate) const fn unmet(element: Element) -> Fate {
    match element {
        Element::Retroreflector => Fate::Missed,
        Element::Plate => Fate::Transmitted,
    }
}
