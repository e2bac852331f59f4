//! The fates of beams: at a facet, back inside from the front face, or out of the sheet, with the map
//! by which the light leaves.

use glam::{DMat2, DVec2, DVec3};
use tables::Fate;

use crate::beams::beam::{Beam, BeamCourse, Follower, LitPiece};
use crate::beams::exact::total_area;
use crate::beams::view::{Shadow, View};
use crate::geometry::{Polygon, polygon};
use crate::optics::{
    Backing, LEAST_POWER, PASSES, Rules, element, fate_of_leaving, mirror, passes_outside,
};

/// Largest angle from the exact way back that counts as no deviation, rad. Rounding turns light by
/// some 1e-15 over the cosine of the incidence. Any dihedral error that a mesh can mean is far
/// larger than this limit.
const STRAIGHT: f64 = 1e-12;

impl Follower<'_> {
    /// Reflects the light that hit a facet, or ends it there.
    pub(super) fn hit(&mut self, shadow: &Shadow, polygon: Polygon, course: &BeamCourse) {
        let rules = self.rules;
        let facet = &self.view.facets[shadow.facet];
        let travel = course.isometry.linear * self.view.direction;
        let area = polygon::area(&polygon);
        if facet.dark {
            return self.settle(area * course.power(), Fate::Absorbed);
        }
        if Rules::is_at_limit(course.reflections, course.passes) {
            return self.settle(area * course.power(), Rules::given_up(course.passes));
        }
        if rules.lets_through(facet.normal.dot(travel)) {
            return self.settle(area, Fate::Transmitted);
        }
        let offset = facet.offset + facet.normal.dot(shadow.translation);
        let mut onward = BeamCourse {
            isometry: course.isometry.reflected(facet.normal, offset),
            reflections: course.reflections + 1,
            ..*course
        };
        if let Some(normal) = onward.normals.get_mut(course.reflections as usize) {
            *normal = facet.normal;
        }
        if let Some(light) = &mut onward.light {
            let surface = rules.losses.unwrap_or(Backing::Bare);
            *light = light.reflected(travel, facet.normal, &surface, rules.refractive_index);
        }
        if let (Some(surface), Some(light)) = (&rules.losses, onward.light) {
            let lost = course.power() - light.power();
            self.settle(area * lost, surface.takes());
        }
        self.pending.push(Beam {
            polygon,
            course: onward,
            depth: shadow.depth,
        });
    }

    /// Ends the light of a beam that meets no further facet. `parts` are convex, and their areas
    /// sum to `rest` within rounding.
    pub(super) fn leave(&mut self, beam: &Beam, toward: DVec3, parts: Vec<Polygon>, rest: f64) {
        let rules = self.rules;
        let BeamCourse {
            isometry,
            reflections,
            ..
        } = beam.course;
        let outside = if rules.follows_the_front() && toward.z > 0.0 {
            let inside = self.send_back(beam, toward, &parts);
            self.outcome.dropped += (rest - total_area(&parts)) * inside;
            // Rounding may take the rest of totally reflected light below 0.
            (beam.course.power() - inside).max(0.0)
        } else {
            let outside = beam.course.power_outside(toward, rules.refractive_index);
            self.settle(rest * (beam.course.power() - outside), Fate::Trapped);
            outside
        };
        match fate_of_leaving(isometry.linear, self.view.direction, reflections, rules) {
            Fate::Retroreflected if outside > 0.0 => {
                self.outcome.dropped += (rest - total_area(&parts)) * outside;
                self.return_light(&beam.course, toward, parts, outside);
            }
            fate => self.settle(rest * outside, fate),
        }
    }

    /// Sends light back inside that the front face reflects. Returns its power, as a share of the
    /// launched power.
    fn send_back(&mut self, beam: &Beam, toward: DVec3, parts: &[Polygon]) -> f64 {
        let BeamCourse {
            isometry, light, ..
        } = beam.course;
        let light = light.map(|light| light.kept_inside(toward, self.rules.refractive_index));
        let power = match light {
            Some(light) if beam.course.is_lossy => light.power(),
            _ if self.rules.is_trapped(toward) => 1.0,
            _ => return 0.0,
        };
        if beam.course.passes == PASSES || power < LEAST_POWER {
            self.settle(total_area(parts) * power, Fate::Trapped);
            return power;
        }
        let course = BeamCourse {
            isometry: isometry.reflected(DVec3::Z, self.view.height),
            passes: beam.course.passes + 1,
            light,
            ..beam.course
        };
        let depth = self.view.depth_of_front(&isometry);
        self.pending.extend(parts.iter().map(|polygon| Beam {
            polygon: polygon.clone(),
            course,
            depth,
        }));
        power
    }

    /// Stores retroreflected light with its map, weight and deviation.
    fn return_light(
        &mut self,
        course: &BeamCourse,
        toward: DVec3,
        parts: Vec<Polygon>,
        weight: f64,
    ) {
        let BeamCourse {
            isometry, passes, ..
        } = *course;
        let View {
            height,
            floor,
            direction,
            ..
        } = *self.view;
        let kind = self.rules.element;
        let plane = element::plane(kind, height, floor);
        // The light that entered at p leaves at y = linear (p, height) + shift. Here y is carried
        // along `toward` to the plane of the shift, as the entry point is carried along
        // `direction`.
        let carry = |y: DVec3| y.truncate() - y.z / toward.z * toward.truncate();
        let (u, v) = (carry(isometry.linear.x_axis), carry(isometry.linear.y_axis));
        let start = isometry.linear.z_axis * height + isometry.shift - DVec3::Z * plane;
        let lead = (height - plane) / direction.z * direction.truncate();
        let matrix = DMat2::from_cols(u - DVec2::X, v - DVec2::Y);
        let offset = carry(start) + lead;
        let index = self.rules.refractive_index;
        let deviation = mirror::deviation(direction, element::straight_back(kind, toward), index);
        let front = match course.is_lossy {
            true => passes_outside(toward, index),
            false => [1.0; 2],
        };
        let jones = course
            .light
            .map(|light| light.jones(direction, toward, front));
        let cube = course.cube();
        let straight = deviation.length() < STRAIGHT;
        let deviation = if straight { DVec2::ZERO } else { deviation };
        self.outcome
            .pieces
            .extend(parts.into_iter().map(|polygon| LitPiece {
                polygon,
                matrix,
                offset,
                weight,
                jones,
                deviation,
                passes,
                cube,
            }));
    }

    /// Adds an area times power to a fate, or to the slivers if it is no more than rounding.
    pub(super) fn settle(&mut self, area: f64, fate: Fate) {
        if area <= self.view.least_area {
            self.outcome.dropped += area;
        } else {
            self.outcome.area[fate as usize] += area;
        }
    }
}
