//! Rays among the curved faces themselves, one by one: the truth that the facets stand for.

use crate::optics::{Incidence, Rules, fate_of_leaving};
use crate::rays::Outcome;
use glam::{DMat3, DVec2, DVec3};
use meshes::Cell;
use tables::Fate;

/// A triangle raised by 27 sag b0 b1 b2 along its normal, with the barycentric coordinates b.
struct Face {
    corner: DVec3,
    normal: DVec3,
    /// Gradients of the barycentric coordinates: b1 = first . (p - corner), b2 = second . (p -
    /// corner).
    first: DVec3,
    second: DVec3,
    sag: f64,
}

/// Evaluates a polynomial at t. Its coefficients begin with the constant.
fn at(polynomial: &[f64], t: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

impl Face {
    fn new([a, b, c]: [DVec3; 3], sag: f64) -> Self {
        let (along, beside) = (b - a, c - a);
        let area = along.cross(beside);
        let square = area.length_squared();
        Face {
            corner: a,
            normal: area.normalize(),
            first: beside.cross(area) / square,
            second: area.cross(along) / square,
            sag,
        }
    }

    /// Returns constant and slope, along a ray, of the barycentric coordinates.
    fn coordinates(&self, origin: DVec3, direction: DVec3) -> [[f64; 2]; 3] {
        let way = origin - self.corner;
        let b1 = [self.first.dot(way), self.first.dot(direction)];
        let b2 = [self.second.dot(way), self.second.dot(direction)];
        [[1.0 - b1[0] - b2[0], -b1[1] - b2[1]], b1, b2]
    }

    /// Returns the distance to the face: the least root past `start` of a cubic.
    ///
    /// Roots are sought between the ends of the ray's way over the triangle and the turning points
    /// of the cubic. Between two of these there is at most one root.
    fn meet(&self, origin: DVec3, direction: DVec3, start: f64) -> Option<f64> {
        let b = self.coordinates(origin, direction);
        let (mut from, mut to) = (start, 10.0_f64);
        for [constant, slope] in b {
            let zero = -constant / slope;
            if slope > 0.0 {
                from = from.max(zero);
            } else if slope < 0.0 {
                to = to.min(zero);
            } else if constant < 0.0 {
                return None;
            }
        }
        let raised = 27.0 * self.sag;
        let [[a0, a1], [b0, b1], [c0, c1]] = b;
        let height = [
            self.normal.dot(origin - self.corner),
            self.normal.dot(direction),
        ];
        let cubic = [
            height[0] - raised * a0 * b0 * c0,
            height[1] - raised * (a1 * b0 * c0 + a0 * b1 * c0 + a0 * b0 * c1),
            -raised * (a1 * b1 * c0 + a1 * b0 * c1 + a0 * b1 * c1),
            -raised * a1 * b1 * c1,
        ];
        let mut ends = vec![from];
        let slope = [cubic[1], 2.0 * cubic[2], 3.0 * cubic[3]];
        let root = (slope[1] * slope[1] - 4.0 * slope[0] * slope[2]).sqrt();
        let q = -0.5 * (slope[1] + root.copysign(slope[1]));
        let mut turns = [q / slope[2], slope[0] / q];
        turns.sort_by(f64::total_cmp);
        ends.extend(turns.into_iter().filter(|t| (from..to).contains(t)));
        ends.push(to);
        ends.windows(2).find_map(|ends| {
            let (mut low, mut high) = (ends[0], ends[1]);
            let sign = at(&cubic, low);
            if low > high || sign * at(&cubic, high) > 0.0 {
                return None;
            }
            // The interval is halved until no number lies between its ends.
            loop {
                let middle = 0.5 * (low + high);
                if middle <= low || middle >= high {
                    return Some(middle);
                }
                if at(&cubic, middle) * sign > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
        })
    }

    /// Returns the unit normal at `point` of the face.
    fn normal_at(&self, point: DVec3) -> DVec3 {
        let way = point - self.corner;
        let (v, w) = (self.first.dot(way), self.second.dot(way));
        let u = 1.0 - v - w;
        let third = -(self.first + self.second);
        let slope = third * (v * w) + self.first * (u * w) + self.second * (u * v);
        (self.normal - slope * (27.0 * self.sag)).normalize()
    }
}

/// An oracle for rays among the faces of `flat`, one facet each, raised by `sag` edge lengths.
pub(crate) struct Oracle {
    faces: Vec<Face>,
    height: f64,
}

impl Oracle {
    pub(crate) fn new(flat: &Cell, sag: f64) -> Self {
        let faces = flat.facets.iter().map(|&corners| Face::new(corners, sag));
        Oracle {
            faces: faces.collect(),
            height: flat.entrance.height,
        }
    }

    pub(crate) fn trace(&self, rules: &Rules, light: &Incidence, point: DVec2) -> Outcome {
        let (mut origin, mut direction) = (point.extend(self.height), light.travel);
        let (mut map, mut bounces) = (DMat3::IDENTITY, 0);
        let mut left = usize::MAX;
        loop {
            // A shallow face is not met again near the point where a ray leaves it.
            let start = |face| if face == left { 1e-9 } else { 0.0 };
            let met = self.faces.iter().enumerate().filter_map(|(number, face)| {
                Some((face.meet(origin, direction, start(number))?, number))
            });
            let Some((distance, number)) = met.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                break;
            };
            origin += direction * distance;
            let normal = self.faces[number].normal_at(origin);
            assert!(direction.dot(normal) < 0.0, "a face from behind");
            direction -= normal * (2.0 * normal.dot(direction));
            let column = |axis: DVec3| axis - normal * (2.0 * normal.dot(axis));
            map = DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z)) * map;
            bounces += 1;
            left = number;
        }
        let fate = fate_of_leaving(map, light.travel, bounces, rules);
        let exit = origin + direction * ((self.height - origin.z) / direction.z);
        Outcome {
            fate,
            shift: match fate {
                Fate::Retroreflected => light.to_frame(exit.truncate() - point),
                _ => DVec2::ZERO,
            },
            bounces,
            travel: direction,
        }
    }
}
