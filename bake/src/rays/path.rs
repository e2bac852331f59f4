//! Tracing of one ray from the entrance to its fate.
//!
//! All faster tracers are checked against this one.

use crate::geometry::Stream;
use crate::optics::{
    Backing, Incidence, LEAST_POWER, Leaving, PASSES, PolarisedLight, Ray, Rules, element,
    fate_of_leaving, mirrored, reflect, refract, roughness,
};
use crate::rays::scene::{Event, Scene};
use glam::{DMat3, DVec2, DVec3};
use tables::Fate;
use tables::options::Sampler;

/// Distance from a surface of glass at which light goes on, in units of the error of its position.
///
/// The error grows with every prism of a lattice that is crossed, and a facet may extend over as
/// many prisms as this.
const CLEAR: f64 = 64.0;

/// Fate of one ray, with its shift and its direction at the end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outcome {
    /// Fate of the ray. If the shift lies outside the histogram, a table counts the ray as
    /// out_of_range instead of retroreflected.
    pub fate: Fate,
    /// Shift p' - p in the incidence frame (u, v), edge lengths, on the plane of
    /// [`element::plane`]; zero unless retroreflected.
    pub shift: DVec2,
    /// Number of reflections.
    pub bounces: u32,
    /// Direction of travel at the end, cell frame, unit length.
    pub travel: DVec3,
}

/// State that rays share after they have met the same facets in the same order: they are parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Course {
    /// Direction of travel, unit length.
    pub direction: DVec3,
    /// Linear map of the reflections so far.
    map: DMat3,
    bounces: u32,
    /// Number of times that the light has gone through a surface of glass.
    crossings: u32,
    /// Number of times that the front face has sent the light back.
    passes: u32,
}

impl Course {
    /// Starts the course of rays launched along `direction`.
    pub(crate) fn new(direction: &Incidence) -> Self {
        Course {
            direction: direction.travel,
            map: DMat3::IDENTITY,
            bounces: 0,
            crossings: 0,
            passes: 0,
        }
    }

    /// Returns the course after the front face has sent the light back inside.
    fn sent_back(&self) -> Self {
        Course {
            direction: reflect(self.direction, DVec3::Z),
            map: mirrored(self.map, DVec3::Z),
            passes: self.passes + 1,
            ..*self
        }
    }

    /// Returns the course after the facet with the unit normal `normal`.
    ///
    /// # Errors
    /// Returns the fate of the rays if they end at the facet.
    pub(crate) fn past(&self, normal: DVec3, front: bool, rules: &Rules) -> Result<Self, Fate> {
        if !front {
            return Err(Fate::Absorbed);
        }
        if Rules::is_at_limit(self.bounces, self.passes) {
            return Err(Rules::given_up(self.passes));
        }
        let cosine = self.direction.dot(normal);
        if rules.lets_through(cosine) {
            return Err(Fate::Transmitted);
        }
        Ok(Course {
            direction: reflect(self.direction, normal),
            map: mirrored(self.map, normal),
            bounces: self.bounces + 1,
            ..*self
        })
    }

    /// Returns the course after a facet of a sheet with bodies of glass of index `glass`.
    ///
    /// A mirror in such a sheet reflects on both sides.
    ///
    /// # Errors
    /// Returns [`Fate::BounceLimit`] if the rays have met [`BOUNCE_LIMIT`] facets before.
    fn past_glass(&self, hit: &Hit, glass: f64, rules: &Rules) -> Result<Self, Fate> {
        if Rules::is_at_limit(self.bounces + self.crossings, self.passes) {
            return Err(Fate::BounceLimit);
        }
        let outside = rules.refractive_index;
        let (from, to) = if hit.front {
            (outside, glass)
        } else {
            (glass, outside)
        };
        let onward = hit
            .glass
            .then(|| refract(self.direction, hit.normal, from, to));
        Ok(match onward.flatten() {
            Some(direction) => Course {
                direction,
                crossings: self.crossings + 1,
                ..*self
            },
            None => Course {
                direction: reflect(self.direction, hit.normal),
                bounces: self.bounces + 1,
                ..*self
            },
        })
    }

    /// Returns the fate of rays, launched along `travel`, that leave a sheet with bodies of glass.
    fn left_glass(&self, travel: DVec3, rules: &Rules) -> Fate {
        match self.bounces {
            0 if self.crossings == 0 => element::unmet(rules.element),
            _ if Leaving::new(rules).is_straight(self.direction, travel) => Fate::Retroreflected,
            _ if self.direction.z < 0.0 => Fate::Transmitted,
            1 => Fate::LeftAfter1,
            2 => Fate::LeftAfter2,
            _ => Fate::Deviated,
        }
    }

    /// Returns the fate of rays, launched along `direction`, that leave the cell.
    pub(crate) fn left(&self, direction: &Incidence, rules: &Rules) -> Fate {
        if rules.glass_index.is_some() {
            return self.left_glass(direction.travel, rules);
        }
        fate_of_leaving(self.map, direction.travel, self.bounces, rules)
    }

    /// Returns the point where rays that are at `origin` cross the plane at `height`, edge lengths.
    ///
    /// The rays may have passed this point already, or they come to it later.
    #[inline]
    pub(crate) fn at_height(&self, height: f64, origin: DVec3) -> DVec2 {
        let along = self.direction;
        (origin + along * ((height - origin.z) / along.z)).truncate()
    }
}

/// Random numbers that decide the way of one ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RandomNumbers {
    /// Number in (0, 1) that decides how far the ray comes where the rules have losses.
    ///
    /// If chances are evenly spread, the share of rays that come back is the share of power that
    /// comes back. So photons are counted in whole numbers.
    pub chance: f64,
    /// Stream and index of the sample, from which the normals of rough facets are drawn.
    pub sample: (Stream, u64),
}

/// Makes random numbers from a chance alone, for smooth facets.
impl From<f64> for RandomNumbers {
    fn from(chance: f64) -> Self {
        let stream = Stream::new(Sampler::Random, 0, 0.0, 0.0, 0);
        let sample = (stream, 0);
        RandomNumbers { chance, sample }
    }
}

/// Photon of unpolarised light.
///
/// It goes on as long as the power that a beam would have left exceeds its `chance`.
struct Photon {
    light: PolarisedLight,
    surface: Backing,
    chance: f64,
}

impl Photon {
    /// Ends the photon with the fate given if the remaining `power` is not above its chance.
    fn survive(&self, power: f64, fate: Fate) -> Result<(), Fate> {
        if power > self.chance {
            Ok(())
        } else {
            Err(fate)
        }
    }
}

/// Facet as light meets it.
struct Hit {
    normal: DVec3,
    front: bool,
    glass: bool,
}

/// Ray under way.
pub(crate) struct RayPath {
    /// Present piece of the path.
    pub ray: Ray,
    point: DVec2,
    course: Course,
    prism: [i32; 2],
    photon: Option<Photon>,
    sample: (Stream, u64),
}

impl RayPath {
    /// Makes the path of the ray that starts at `point` of the entrance plane, edge lengths.
    #[inline]
    pub(crate) fn new(
        scene: &Scene,
        rules: &Rules,
        direction: &Incidence,
        point: DVec2,
        RandomNumbers { chance, sample }: RandomNumbers,
    ) -> Self {
        RayPath {
            ray: scene.enter(point, direction.travel),
            point,
            course: Course::new(direction),
            prism: [0, 0],
            photon: rules.losses.map(|surface| Photon {
                light: PolarisedLight::entered(direction.travel, rules.refractive_index),
                surface,
                chance,
            }),
            sample,
        }
    }

    /// Takes the path through the entrance; returns the fate if the path ends there.
    pub(crate) fn enter(&self) -> Result<(), Fate> {
        self.photon.as_ref().map_or(Ok(()), |photon| {
            photon.survive(photon.light.power(), Fate::ReflectedByFront)
        })
    }

    /// Returns the outcome of a path that has ended with `fate`.
    pub(crate) fn outcome(
        &self,
        fate: Fate,
        scene: &Scene,
        rules: &Rules,
        direction: &Incidence,
    ) -> Outcome {
        let mut shift = DVec2::ZERO;
        if fate == Fate::Retroreflected {
            let plane = element::plane(rules.element, scene.height(), scene.bottom());
            let exit = self.course.at_height(plane, self.ray.origin);
            let exit = exit + scene.displacement(self.prism);
            let lead =
                direction.travel.truncate() * ((plane - scene.height()) / direction.travel.z);
            shift = direction.to_frame(exit - (self.point + lead));
        }
        Outcome {
            fate,
            shift,
            bounces: self.course.bounces,
            travel: self.course.direction,
        }
    }

    /// Takes the path past the next event of its ray; returns the fate if the path ends there.
    #[inline]
    pub(crate) fn pass(
        &mut self,
        event: &Event,
        height: f64,
        rules: &Rules,
        direction: &Incidence,
    ) -> Result<(), Fate> {
        match *event {
            Event::Hit {
                arrival,
                normal,
                front_normal,
                front,
                prism,
                glass,
                ..
            } => {
                let before = self.course.direction;
                if let Some(index) = rules.glass_index {
                    let hit = Hit {
                        normal,
                        front,
                        glass,
                    };
                    let onward = self.course.past_glass(&hit, index, rules)?;
                    // An interpolated normal may turn light to the wrong side of its facet.
                    let side = onward.direction.dot(front_normal);
                    let crosses = onward.crossings > self.course.crossings;
                    if crosses != (side * before.dot(front_normal) > 0.0) {
                        return Err(Fate::Absorbed);
                    }
                    // Within the error of its position, the light could meet the same facet again.
                    // In the next prism it could do so too, where the error counts for more. So it
                    // goes on from a point beyond that error.
                    let clear = front_normal * (CLEAR * arrival.slack).copysign(side);
                    self.course = onward;
                    self.prism = [self.prism[0] + prism[0], self.prism[1] + prism[1]];
                    self.ray = Ray {
                        origin: arrival.origin + clear,
                        direction: onward.direction,
                        ..arrival
                    };
                    return Ok(());
                }
                let normal = match rules.roughness {
                    // Light from behind the curved face that a facet stands for ends below.
                    Some(roughness) if front && before.dot(normal) < 0.0 => {
                        let (stream, index) = &self.sample;
                        let at = stream.at_bounce(*index, self.course.bounces);
                        roughness::normal(&roughness, normal, before, at)
                    }
                    _ => normal,
                };
                self.course = self.course.past(normal, front, rules)?;
                // Rough facets, and facets that stand for a curved face, may send light behind
                // their own plane.
                if self.course.direction.dot(front_normal) <= 0.0 {
                    return Err(Fate::Absorbed);
                }
                if let Some(photon) = &mut self.photon {
                    let (surface, index) = (photon.surface, rules.refractive_index);
                    photon.light = photon.light.reflected(before, normal, &surface, index);
                    photon.survive(photon.light.power(), surface.takes())?;
                }
                self.prism = [self.prism[0] + prism[0], self.prism[1] + prism[1]];
                self.ray = Ray {
                    direction: self.course.direction,
                    ..arrival
                };
                Ok(())
            }
            Event::Endless => Err(Rules::given_up(self.course.passes)),
            Event::Out if rules.follows_the_front() && self.course.direction.z > 0.0 => {
                self.meet_front(height, rules, direction)
            }
            Event::Out => {
                if let Some(photon) = &self.photon {
                    let travel = self.course.direction;
                    let outside = photon.light.power_outside(travel, rules.refractive_index);
                    photon.survive(outside, Fate::Trapped)?;
                }
                Err(self.course.left(direction, rules))
            }
        }
    }
}

impl RayPath {
    /// Takes the path back inside at the front face, or returns the fate of light that leaves.
    ///
    /// A photon goes on if its chance is below the power that goes on, and leaves if it is below
    /// the power before.
    fn meet_front(
        &mut self,
        height: f64,
        rules: &Rules,
        direction: &Incidence,
    ) -> Result<(), Fate> {
        let travel = self.course.direction;
        let goes_on = match &mut self.photon {
            None => rules.is_trapped(travel),
            Some(photon) => {
                let inside = photon.light.kept_inside(travel, rules.refractive_index);
                let goes_on = inside.power() > photon.chance;
                if goes_on {
                    photon.light = inside;
                }
                goes_on
            }
        };
        if !goes_on {
            return Err(self.course.left(direction, rules));
        }
        let left_over = |photon: &Photon| photon.light.power() < LEAST_POWER;
        if self.course.passes == PASSES || self.photon.as_ref().is_some_and(left_over) {
            return Err(Fate::Trapped);
        }
        let at = self.course.at_height(height, self.ray.origin);
        self.course = self.course.sent_back();
        self.ray = Ray {
            origin: at.extend(height),
            direction: self.course.direction,
            ..self.ray
        };
        Ok(())
    }
}

/// Traces the ray that enters `scene` along `direction` at `point` of the entrance plane.
///
/// `point` is in the cell frame, edge lengths. `random` has no effect if the rules have neither
/// losses nor roughness.
pub(crate) fn trace(
    scene: &Scene,
    rules: &Rules,
    direction: &Incidence,
    point: DVec2,
    random: impl Into<RandomNumbers>,
) -> Outcome {
    let mut path = RayPath::new(scene, rules, direction, point, random.into());
    let fate = match path.enter() {
        Err(fate) => fate,
        Ok(()) => loop {
            let event = scene.next(&path.ray);
            if let Err(fate) = path.pass(&event, scene.height(), rules, direction) {
                break fate;
            }
        },
    };
    path.outcome(fate, scene, rules, direction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tables::options::Element;

    /// In a sheet with glass, light is retroreflected if it leaves within the tolerance of straight
    /// back, whatever the plane in which it is off. Within 1 % of the tolerance, the length of the
    /// difference is off by at least 1e-6 of lengths that round by 1e-16.
    #[test]
    fn light_leaves_glass_straight_back_up_to_the_tolerance_and_no_further() {
        let travel = DVec3::new(0.36, 0.48, -0.8);
        let mut cases = 0;
        for tolerance in [1e-4, 8.7e-3, 0.2] {
            for kind in [Element::Retroreflector, Element::Plate] {
                let rules = Rules {
                    angular_tolerance_rad: tolerance,
                    element: kind,
                    glass_index: Some(1.5),
                    ..Rules::mirrors(1.0)
                };
                let back = element::imaging(kind) * travel;
                let across = back.cross(DVec3::X).normalize();
                for axis in [across, back.cross(across)] {
                    for part in [0.0, 0.99, -0.99, 1.01, -1.01] {
                        let course = Course {
                            direction: DMat3::from_axis_angle(axis, part * tolerance) * back,
                            map: DMat3::IDENTITY,
                            bounces: 1,
                            crossings: 2,
                            passes: 0,
                        };
                        let beyond = match kind {
                            Element::Retroreflector => Fate::LeftAfter1,
                            Element::Plate => Fate::Transmitted,
                        };
                        let expected = match part.abs() < 1.0 {
                            true => Fate::Retroreflected,
                            false => beyond,
                        };
                        let found = course.left_glass(travel, &rules);
                        assert_eq!(found, expected, "{kind:?} {tolerance} {part}");
                        cases += 1;
                    }
                }
            }
        }
        assert_eq!(cases, 3 * 2 * 2 * 5);
    }
}
