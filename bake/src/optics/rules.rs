//! The rules that rays and beams share: what facets do to light, and what counts as retroreflected.

use crate::optics::element;
use crate::optics::light::Backing;
use crate::optics::mirror::{outside, totally_reflected};
use glam::{DMat3, DVec3};
use tables::Fate;
use tables::options::{Element, Front, Roughness};

/// Largest number of reflections of a ray that is followed, for each time that it comes from the
/// front face. A corner cube takes three; periodic and canted cubes take up to about ten.
pub(crate) const BOUNCE_LIMIT: u32 = 64;

/// Largest number of times that the front face sends light back to the facets. Without losses some
/// light takes more than 20. After 64, less than 0.05 % is left in the 40 directions of the tests.
pub(crate) const PASSES: u32 = 64;

/// Least power, as a share of the launched one, of light that is followed after the front face.
pub(crate) const LEAST_POWER: f64 = 1e-6;

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
    /// Treatment of light that meets the front face from inside.
    pub front: Front,
}

impl Rules {
    /// Returns the fates that light can have, in the order of the file.
    pub(crate) fn fates(&self) -> &'static [Fate] {
        Fate::of(
            self.front,
            self.losses.is_some() && self.refractive_index > 1.0,
        )
    }

    /// Returns whether light that the front face reflects goes on.
    pub(crate) fn follows_the_front(&self) -> bool {
        self.front == Front::Trapped
    }

    /// Returns whether the front face reflects all light that comes along `travel`, the unit
    /// direction inside, and the light goes on.
    pub(crate) fn is_trapped(&self, travel: DVec3) -> bool {
        self.follows_the_front() && totally_reflected(travel.z, self.refractive_index)
    }

    /// Returns whether light is followed no further at the next facet, after `reflections` in all
    /// and after the front face has sent it back `passes` times.
    pub(crate) fn is_at_limit(reflections: u32, passes: u32) -> bool {
        reflections == BOUNCE_LIMIT * (passes + 1)
    }

    /// Returns the fate of light that is followed no further after the front face has sent it back
    /// `passes` times.
    pub(crate) fn given_up(passes: u32) -> Fate {
        match passes {
            0 => Fate::BounceLimit,
            _ => Fate::Trapped,
        }
    }

    /// Returns whether all light passes a facet that it meets at an angle of cosine `cosine` from
    /// the normal.
    pub(crate) fn lets_through(&self, cosine: f64) -> bool {
        self.reflects_only_totally() && !self.reflects_totally(cosine)
    }

    /// Returns whether facets reflect only beyond the critical angle.
    pub(crate) fn reflects_only_totally(&self) -> bool {
        self.losses.is_none() && !self.mirror_back
    }

    /// Returns whether light that meets a facet at an angle of cosine `cosine` from its normal is
    /// beyond the critical angle.
    #[inline(always)]
    pub(crate) fn reflects_totally(&self, cosine: f64) -> bool {
        totally_reflected(cosine, self.refractive_index)
    }
}

/// Tests of light that leaves, with the sine of half the tolerance computed once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leaving {
    ideal: DMat3,
    sine: f64,
    index: f64,
}

impl Leaving {
    /// Makes the tests of these rules.
    pub(crate) fn new(rules: &Rules) -> Self {
        Leaving {
            ideal: element::imaging(rules.element),
            sine: libm::sin(rules.angular_tolerance_rad / 2.0),
            index: rules.refractive_index,
        }
    }

    /// Returns whether the rotation between the linear map `map` and the ideal one is within the
    /// tolerance.
    ///
    /// For a rotation R by the angle w, the Frobenius norm of R - I is 2 sqrt 2 sin(w/2). An
    /// improper map is never near.
    #[inline(always)]
    pub(crate) fn is_near(&self, map: DMat3) -> bool {
        let defect = map - self.ideal;
        let squared: f64 = defect.to_cols_array().iter().map(|x| x * x).sum();
        squared <= 8.0 * self.sine * self.sine
    }

    /// Returns whether light launched along `travel`, which leaves along `left`, leaves to within
    /// the tolerance of where the ideal map sends it.
    ///
    /// Both directions are inside, and the angle between the two ways is that in the air: the front
    /// face widens it. |a - b| = 2 sin(w/2) for unit vectors at an angle w.
    #[inline(always)]
    pub(crate) fn is_straight(&self, left: DVec3, travel: DVec3) -> bool {
        let ideal = self.ideal * travel;
        if self.index == 1.0 {
            return (left - ideal).length() <= 2.0 * self.sine;
        }
        let [out, back] = [left, ideal].map(|inside| outside(inside, self.index));
        // Light that the front face reflects totally has no direction in the air.
        ((out - back).length() <= 2.0 * self.sine) & (out.truncate().length_squared() < 1.0)
    }
}

/// Returns the fate of a ray that leaves after `bounces` reflections with the linear map `map`,
/// launched along `travel`.
///
/// `travel` and `map` are inside the cell, and so is the rotation of a map that counts as
/// retroreflected. The angle of light by another map is that in the air. Light that a front face
/// would reflect back inside counts as leaving.
pub(crate) fn fate_of_leaving(map: DMat3, travel: DVec3, bounces: u32, rules: &Rules) -> Fate {
    if bounces == 0 {
        return element::unmet(rules.element);
    }
    let leaving = Leaving::new(rules);
    if leaving.is_near(map) {
        return Fate::Retroreflected;
    }
    if leaving.is_straight(map * travel, travel) {
        return Fate::AntiparallelOther;
    }
    match bounces {
        1 => Fate::LeftAfter1,
        2 => Fate::LeftAfter2,
        _ => Fate::Deviated,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerances, rad: from the default of 0.5 deg to nearly a right angle.
    const TOLERANCES: [f64; 4] = [1e-4, 8.7e-3, 0.2, 1.5];

    fn rules(element: Element, angular_tolerance_rad: f64) -> Rules {
        Rules {
            angular_tolerance_rad,
            element,
            ..Rules::mirrors(1.0)
        }
    }

    /// A map that is off the ideal one by a rotation is near up to the tolerance itself, about any
    /// axis. Within 1 % of the tolerance the square of the defect is off by 2 %, at least 2e-10 of
    /// numbers that round by 1e-15.
    #[test]
    fn maps_are_near_up_to_the_tolerance_and_no_further() {
        let axes = [
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            DVec3::ONE.normalize(),
            DVec3::new(0.6, 0.0, -0.8),
        ];
        for kind in [Element::Retroreflector, Element::Plate] {
            let ideal = element::imaging(kind);
            for tolerance in TOLERANCES {
                let leaving = Leaving::new(&rules(kind, tolerance));
                for axis in axes {
                    let near = |part: f64| {
                        let off = DMat3::from_axis_angle(axis, part * tolerance);
                        leaving.is_near(off * ideal)
                    };
                    assert!(near(0.0) && near(0.99) && near(-0.99), "{axis} {tolerance}");
                    assert!(!near(1.01) && !near(-1.01), "{axis} {tolerance}");
                }
            }
            let widest = Leaving::new(&rules(kind, 1.5));
            assert!(!widest.is_near(-ideal), "a map of the other handedness");
        }
    }

    /// A map that turns the light about its own direction sends it straight back, but turns its
    /// image. Beyond the tolerance such light is antiparallel and not retroreflected.
    #[test]
    fn light_is_retroreflected_up_to_the_tolerance_and_no_further() {
        let travel = DVec3::new(0.36, 0.48, -0.8);
        for kind in [Element::Retroreflector, Element::Plate] {
            let ideal = element::imaging(kind);
            let back = ideal * travel;
            let across = back.cross(DVec3::X).normalize();
            for tolerance in TOLERANCES {
                let rules = rules(kind, tolerance);
                let fate = |axis: DVec3, part: f64| {
                    let off = DMat3::from_axis_angle(axis, part * tolerance);
                    fate_of_leaving(off * ideal, travel, 3, &rules)
                };
                assert_eq!(fate(back, 0.99), Fate::Retroreflected);
                assert_eq!(fate(back, 1.01), Fate::AntiparallelOther);
                assert_eq!(fate(across, 0.99), Fate::Retroreflected);
                assert_eq!(fate(across, 1.01), Fate::Deviated);
            }
        }
    }

    /// The direction of light is compared with the tolerance as the map is. Both maps here are
    /// improper by a mirror that holds the ideal direction, so only the direction can count.
    #[test]
    fn directions_are_antiparallel_up_to_the_tolerance_and_no_further() {
        let travel = DVec3::new(0.36, 0.48, -0.8);
        let across = travel.cross(DVec3::X).normalize();
        let mirror = DMat3::IDENTITY
            - 2.0 * DMat3::from_cols(across * across.x, across * across.y, across * across.z);
        for tolerance in TOLERANCES {
            let rules = rules(Element::Retroreflector, tolerance);
            let fate = |part: f64, bounces: u32| {
                let off = DMat3::from_axis_angle(across, part * tolerance);
                fate_of_leaving(-(off * mirror), travel, bounces, &rules)
            };
            assert_eq!(fate(0.99, 3), Fate::AntiparallelOther, "{tolerance}");
            let beyond = [1, 2, 3, 64].map(|bounces| fate(1.01, bounces));
            let expected = [
                Fate::LeftAfter1,
                Fate::LeftAfter2,
                Fate::Deviated,
                Fate::Deviated,
            ];
            assert_eq!(beyond, expected, "{tolerance}");
        }
    }

    /// Behind a front face the angle from straight back is that in the air, by Snell's law of both
    /// angles. The map holds a mirror, so only the direction counts. Light is turned within the
    /// plane of incidence here; at 40 degrees in index 1.586 an angle of 0.5 degrees inside would
    /// be 0.95 outside.
    #[test]
    fn directions_behind_a_front_face_are_judged_in_the_air() {
        let (index, incidence) = (1.586_f64, 40_f64.to_radians());
        let inside = |outside: f64| (outside.sin() / index).asin();
        let along = |angle: f64| DVec3::new(angle.sin(), 0.0, -angle.cos());
        let mirror = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
        let mut cases = 0;
        for tolerance in [1e-4, 8.7e-3, 0.2] {
            let rules = Rules {
                refractive_index: index,
                ..rules(Element::Retroreflector, tolerance)
            };
            for part in [-1.01, -0.99, 0.0, 0.99, 1.01] {
                let turn = inside(incidence + part * tolerance) - inside(incidence);
                let map = -(DMat3::from_rotation_y(-turn) * mirror);
                let travel = along(inside(incidence));
                let back = along(inside(incidence + part * tolerance));
                assert!((map * travel + back).length() < 1e-15);
                let expected = match part.abs() < 1.0 {
                    true => Fate::AntiparallelOther,
                    false => Fate::LeftAfter2,
                };
                let fate = fate_of_leaving(map, travel, 2, &rules);
                assert_eq!(fate, expected, "{tolerance} {part}");
                cases += 1;
            }
        }
        // Light beyond the critical angle is not in the air at all.
        let grazing = along(inside(89.9_f64.to_radians()));
        let beyond = along(inside(89.9_f64.to_radians()) + 1e-3);
        let leaving = Leaving::new(&Rules {
            refractive_index: index,
            ..rules(Element::Retroreflector, 0.1)
        });
        assert!(leaving.is_straight(-grazing, grazing));
        assert!(!leaving.is_straight(-beyond, grazing));
        assert_eq!(cases, 15);
    }
}
