//! The rules that rays and beams share: what facets do to light, and what counts as retroreflected.

use crate::optics::element;
use crate::optics::light::Backing;
use crate::optics::mirror::totally_reflected;
use glam::{DMat3, DVec3};
use tables::Fate;
use tables::options::{Element, Roughness};

/// Largest number of reflections of a ray that is followed. A corner cube takes three; periodic and
/// canted cubes take up to about ten.
pub(crate) const BOUNCE_LIMIT: u32 = 64;

/// The rules of a bake: what facets do to light, and what counts as retroreflected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rules {
    /// Refractive index behind the flat front face; 1 for a hollow cell.
    pub refractive_index: f64,
    /// True if facets reflect at every angle (a mirror coating), false if only totally.
    pub mirror_back: bool,
    /// Backing of the facets if Fresnel's losses count. Then `mirror_back` has no effect.
    pub losses: Option<Backing>,
    /// Largest angle, rad, of the rotation between a path's linear map and the ideal map of
    /// [`Rules::element`] that still counts as retroreflected.
    pub angular_tolerance_rad: f64,
    /// Roughness of the facets, `None` if they are smooth.
    pub roughness: Option<Roughness>,
    /// Element whose ideal map counts as retroreflected.
    pub element: Element,
    /// Refractive index of bodies of glass, `None` if all facets are mirrors. A path through glass
    /// has no linear map, so its direction alone counts.
    pub glass_index: Option<f64>,
}

impl Rules {
    /// Returns whether all light passes a facet that it meets at an angle of cosine `cosine` from
    /// the normal.
    pub(crate) fn lets_through(&self, cosine: f64) -> bool {
        self.losses.is_none()
            && !self.mirror_back
            && !totally_reflected(cosine, self.refractive_index)
    }
}

/// Returns whether the rotation between the linear maps `map` and `ideal` is at most
/// `tolerance_rad`.
///
/// For a rotation R by the angle w, the Frobenius norm of R - I is 2 sqrt 2 sin(w/2). An improper
/// map is never near.
fn is_near(map: DMat3, ideal: DMat3, tolerance_rad: f64) -> bool {
    let defect = map - ideal;
    let squared: f64 = defect.to_cols_array().iter().map(|x| x * x).sum();
    let sine = libm::sin(tolerance_rad / 2.0);
    squared <= 8.0 * sine * sine
}

/// Returns the fate of a ray that leaves after `bounces` reflections with the linear map `map`,
/// launched along `travel`.
///
/// All angles are inside the cell. Light that a front face would reflect back inside counts as
/// leaving.
pub(crate) fn fate_of_leaving(map: DMat3, travel: DVec3, bounces: u32, rules: &Rules) -> Fate {
    if bounces == 0 {
        return element::unmet(rules.element);
    }
    let (ideal, tolerance_rad) = (element::imaging(rules.element), rules.angular_tolerance_rad);
    if is_near(map, ideal, tolerance_rad) {
        return Fate::Retroreflected;
    }
    // |a - b| = 2 sin(w/2) for unit vectors at an angle w.
    if (map * travel - ideal * travel).length() <= 2.0 * libm::sin(tolerance_rad / 2.0) {
        return Fate::AntiparallelOther;
    }
    match bounces {
        1 => Fate::LeftAfter1,
        2 => Fate::LeftAfter2,
        _ => Fate::Deviated,
    }
}
