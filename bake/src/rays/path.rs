//! One ray from the entrance to its fate: the tracer that everything faster is checked against.

use crate::optics::element::Element;
use crate::optics::light::{Light, Surface};
use crate::optics::mirror::{reflect, reflection, refract, totally_reflected};
use crate::optics::ray::{Direction, Ray};
use crate::optics::roughness::Roughness;
use crate::plan::plan::default;
use crate::rays::scene::{Event, Scene};
use crate::samples::sequence::{Sampler, Stream};
use glam::{DMat3, DVec2, DVec3};
use tables::Fate;

/// Reflections after which a ray is given up. A corner cube takes three; periodic and canted ones take up to about
/// ten.
pub const BOUNCE_LIMIT: u32 = 64;

/// How far from a surface of glass light goes on, in errors of its position: a facet may reach over so many prisms of a
/// lattice.
const CLEAR: f64 = 64.0;

/// What facets do to light, and what counts as retroreflected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Refractive index behind the flat front face; 1 for a hollow cell.
    pub refractive_index: f64,
    /// Whether facets reflect at every angle (a mirror coating) or only totally.
    pub mirror_back: bool,
    /// What is behind the facets, where Fresnel's losses count; then `mirror_back` says nothing.
    pub losses: Option<Surface>,
    /// Largest angle of the rotation between a path's linear map and that of [`Rules::element`] which counts as
    /// retroreflected, rad.
    pub angular_tolerance_rad: f64,
    /// How rough facets are; `None` where they are smooth.
    pub roughness: Option<Roughness>,
    /// What counts as retroreflected.
    pub element: Element,
    /// Refractive index of bodies of glass; `None` where all facets are mirrors. A path through glass has no linear map: its
    /// direction alone counts.
    pub glass_index: Option<f64>,
}

impl Rules {
    /// Mirrors that take nothing, behind a flat front face of that refractive index, and the usual tolerance: what rules name
    /// beyond that is an option.
    pub const fn mirrors(refractive_index: f64) -> Self {
        Rules {
            refractive_index,
            mirror_back: true,
            losses: None,
            angular_tolerance_rad: default::ANGULAR_TOLERANCE_DEG.to_radians(),
            roughness: None,
            element: Element::Retroreflector,
            glass_index: None,
        }
    }

    /// Whether all light goes through a facet that it meets at an angle of cosine `cosine` from the normal.
    pub fn lets_through(&self, cosine: f64) -> bool {
        self.losses.is_none()
            && !self.mirror_back
            && !totally_reflected(cosine, self.refractive_index)
    }
}

/// What became of one ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Its fate; a table calls it out_of_range instead where the shift lies outside the histogram.
    pub fate: Fate,
    /// Shift p' - p on the plane of [`crate::optics::element::plane`] in the incidence frame (u, v), edge lengths; zero unless retroreflected.
    pub shift: DVec2,
    /// Reflections.
    pub bounces: u32,
    /// Direction of travel at the end, cell frame.
    pub travel: DVec3,
}

/// Whether the linear maps `map` and `ideal` are one within the rotation angle `tolerance_rad`.
///
/// For a rotation by the angle w, the Frobenius norm of R - I is 2 sqrt 2 sin(w/2); an improper map is never near.
fn is_near(map: DMat3, ideal: DMat3, tolerance_rad: f64) -> bool {
    let defect = map - ideal;
    let squared: f64 = defect.to_cols_array().iter().map(|x| x * x).sum();
    let sine = libm::sin(tolerance_rad / 2.0);
    squared <= 8.0 * sine * sine
}

/// The fate of a ray that leaves after `bounces` reflections with the linear map `map`, launched along `travel`.
///
/// All angles are those inside the cell. Light that a front face would reflect back inside counts as leaving.
pub fn fate_of_leaving(map: DMat3, travel: DVec3, bounces: u32, rules: &Rules) -> Fate {
    if bounces == 0 {
        return crate::optics::element::unmet(rules.element);
    }
    let (ideal, tolerance_rad) = (
        crate::optics::element::imaging(rules.element),
        rules.angular_tolerance_rad,
    );
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

/// What rays have in common that have met the same facets in the same order: they travel alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// Direction of travel, unit length.
    pub direction: DVec3,
    /// Linear map of the reflections so far.
    map: DMat3,
    bounces: u32,
    /// Times that it has gone through a surface of glass.
    crossings: u32,
}

impl Course {
    /// That of rays launched along `direction`.
    pub fn new(direction: &Direction) -> Self {
        Course {
            direction: direction.travel,
            map: DMat3::IDENTITY,
            bounces: 0,
            crossings: 0,
        }
    }

    /// What follows a facet with unit normal `normal`.
    ///
    /// # Errors
    /// The fate of rays that end there.
    pub fn past(&self, normal: DVec3, front: bool, rules: &Rules) -> Result<Self, Fate> {
        if !front {
            return Err(Fate::Absorbed);
        }
        if self.bounces == BOUNCE_LIMIT {
            return Err(Fate::BounceLimit);
        }
        let cosine = self.direction.dot(normal);
        if rules.lets_through(cosine) {
            return Err(Fate::Transmitted);
        }
        Ok(Course {
            direction: reflect(self.direction, normal),
            map: reflection(normal) * self.map,
            bounces: self.bounces + 1,
            ..*self
        })
    }

    /// What follows a facet of a sheet with bodies of glass of index `glass`, or a mirror there, which reflects on both sides.
    ///
    /// # Errors
    /// [`Fate::BounceLimit`].
    fn past_glass(&self, hit: &Hit, glass: f64, rules: &Rules) -> Result<Self, Fate> {
        if self.bounces + self.crossings == BOUNCE_LIMIT {
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

    /// The fate of rays, launched along `travel`, that leave a sheet with bodies of glass.
    fn left_glass(&self, travel: DVec3, rules: &Rules) -> Fate {
        let off =
            (self.direction - crate::optics::element::imaging(rules.element) * travel).length();
        match self.bounces {
            0 if self.crossings == 0 => crate::optics::element::unmet(rules.element),
            _ if off <= 2.0 * libm::sin(rules.angular_tolerance_rad / 2.0) => Fate::Retroreflected,
            _ if self.direction.z < 0.0 => Fate::Transmitted,
            1 => Fate::LeftAfter1,
            2 => Fate::LeftAfter2,
            _ => Fate::Deviated,
        }
    }

    /// The fate of rays, launched along `direction`, that leave the cell.
    pub fn left(&self, direction: &Direction, rules: &Rules) -> Fate {
        if rules.glass_index.is_some() {
            return self.left_glass(direction.travel, rules);
        }
        fate_of_leaving(self.map, direction.travel, self.bounces, rules)
    }

    /// Where rays that are at `origin` cross the plane at `height`: where they have been or come to.
    #[inline]
    pub fn at_height(&self, height: f64, origin: DVec3) -> DVec2 {
        let along = self.direction;
        (origin + along * ((height - origin.z) / along.z)).truncate()
    }
}

/// What chance decides on the way of one ray.
#[derive(Debug, Clone, Copy)]
pub struct Luck {
    /// In (0, 1): how far it comes where the rules have losses. Of evenly spread chances as many come back as power does, so
    /// that a tally of photons has whole numbers.
    pub chance: f64,
    /// Stream and index of the sample, which draw the normals of rough facets.
    pub sample: (Stream, u64),
}

/// A chance alone, for smooth facets.
impl From<f64> for Luck {
    fn from(chance: f64) -> Self {
        let stream = Stream::new(Sampler::Random, 0, 0.0, 0.0, 0);
        let sample = (stream, 0);
        Luck { chance, sample }
    }
}

/// A photon of unpolarised light: it goes on as long as the power that a beam would have left exceeds its `chance`.
struct Photon {
    light: Light,
    surface: Surface,
    chance: f64,
}

impl Photon {
    /// Ends it, with the fate given, where only `power` is left.
    fn survive(&self, power: f64, fate: Fate) -> Result<(), Fate> {
        if power > self.chance {
            Ok(())
        } else {
            Err(fate)
        }
    }
}

/// A facet as light meets it.
struct Hit {
    normal: DVec3,
    front: bool,
    glass: bool,
}

/// A ray under way.
struct Path {
    /// Its present piece.
    ray: Ray,
    course: Course,
    prism: [i32; 2],
    photon: Option<Photon>,
    sample: (Stream, u64),
}

impl Path {
    /// Takes the path past the next event of its ray; its fate if it ends there.
    #[inline]
    fn pass(&mut self, event: &Event, rules: &Rules, direction: &Direction) -> Result<(), Fate> {
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
                    // Behind a facet, within its error, it would meet it again, in the next prism too, where the error counts
                    // for more: it goes on from beyond that.
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
                        crate::optics::roughness::normal(&roughness, normal, before, at)
                    }
                    _ => normal,
                };
                self.course = self.course.past(normal, front, rules)?;
                // Off rough facets, and off those that stand for a curved face, light may be sent behind its facet.
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
            Event::Endless => Err(Fate::BounceLimit),
            Event::Out => {
                if let Some(photon) = &self.photon {
                    let travel = self.course.direction;
                    let outside = photon.light.power_outside(travel, rules.refractive_index);
                    photon.survive(outside, Fate::Absorbed)?;
                }
                Err(self.course.left(direction, rules))
            }
        }
    }
}

/// Traces the ray that enters `scene` at `point` of the entrance plane (cell frame, edge lengths) along `direction`. `luck`
/// says nothing where the rules have neither losses nor roughness.
pub fn trace(
    scene: &Scene,
    rules: &Rules,
    direction: &Direction,
    point: DVec2,
    luck: impl Into<Luck>,
) -> Outcome {
    let Luck { chance, sample } = luck.into();
    let mut path = Path {
        ray: scene.enter(point, direction.travel),
        course: Course::new(direction),
        prism: [0, 0],
        photon: rules.losses.map(|surface| Photon {
            light: Light::entered(direction.travel, rules.refractive_index),
            surface,
            chance,
        }),
        sample,
    };
    let entered = path.photon.as_ref().map_or(Ok(()), |photon| {
        photon.survive(photon.light.power(), Fate::Absorbed)
    });
    let fate = match entered {
        Err(fate) => fate,
        Ok(()) => loop {
            let event = scene.next(&path.ray);
            if let Err(fate) = path.pass(&event, rules, direction) {
                break fate;
            }
        },
    };
    let mut shift = DVec2::ZERO;
    if fate == Fate::Retroreflected {
        let plane = crate::optics::element::plane(rules.element, scene.height(), scene.bottom());
        let exit = path.course.at_height(plane, path.ray.origin) + scene.displacement(path.prism);
        let lead = direction.travel.truncate() * ((plane - scene.height()) / direction.travel.z);
        shift = direction.to_frame(exit - (point + lead));
    }
    Outcome {
        fate,
        shift,
        bounces: path.course.bounces,
        travel: path.course.direction,
    }
}
