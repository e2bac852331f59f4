//! The task of an optical element: where it makes the image, and on which plane a ray shift is
//! measured.

use glam::{DMat3, DVec3};
use tables::Fate;
use tables::options::Element;

/// Returns the linear map of a path that makes the image.
///
/// For a retroreflector it is -I. A plate turns round both components along its plane.
pub(crate) const fn imaging(element: Element) -> DMat3 {
    let along_normal = match element {
        Element::Retroreflector => -1.0,
        Element::Plate => 1.0,
    };
    DMat3::from_cols_array(&[-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, along_normal])
}

/// Turns the direction `left` so that light which makes the image goes straight back.
pub(crate) fn straight_back(element: Element, left: DVec3) -> DVec3 {
    -(imaging(element) * left)
}

/// Returns the height of the plane on which ray shifts are measured.
///
/// The lines of the entering and the leaving light are extended to this plane; the distance of
/// their points there is the ray shift. It is the entrance plane at `height` for a retroreflector,
/// and the middle between `height` and `bottom` for a plate.
pub(crate) fn plane(element: Element, height: f64, bottom: f64) -> f64 {
    match element {
        Element::Retroreflector => height,
        Element::Plate => f64::midpoint(height, bottom),
    }
}

/// Returns the fate of light that meets nothing.
pub(crate) const fn unmet(element: Element) -> Fate {
    match element {
        Element::Retroreflector => Fate::Missed,
        Element::Plate => Fate::Transmitted,
    }
}
