//! Rays and the directions in which they are launched.

use crate::optics::mirror as optics;
use crate::optics::mirror::refracted_sine;
use glam::{DVec2, DVec3};

/// A straight piece of a path, in the cell frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ray {
    /// Start of the piece, edge lengths.
    pub origin: DVec3,
    /// Direction of travel, unit length.
    pub direction: DVec3,
    /// Bound on the error of `origin`, edge lengths. By this much a facet may seem to lie behind
    /// the start of the ray although it is in front. The bound replaces the usual self-hit epsilon.
    pub slack: f64,
    /// Bound on the rounding error of a triple product of the unit direction and two vectors from
    /// `origin` to corners of a facet, square edge lengths.
    pub grain: f64,
}

impl Ray {
    /// Creates a ray whose origin is exact to rounding, among facets within `reach` edge lengths of
    /// it.
    pub(crate) fn new(origin: DVec3, direction: DVec3, reach: f64) -> Self {
        Ray {
            origin,
            direction,
            slack: 16.0 * f64::EPSILON * reach,
            grain: 16.0 * f64::EPSILON * reach * reach,
        }
    }
}

/// A direction of incidence and its frame.
///
/// The **incidence frame** of the entrance plane has the axes u and v = n x u. u is the in-plane
/// direction of travel at the azimuth, at normal incidence too. The angle is taken outside the
/// sheet and the direction of travel inside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Incidence {
    /// Direction of travel inside the cell, unit length, cell frame.
    pub travel: DVec3,
    /// Axis u of the incidence frame in the entrance plane, unit length, cell frame.
    pub u: DVec2,
}

impl Incidence {
    /// Creates the direction with the angle `incidence_rad` from n outside a sheet of refractive
    /// index `index`, at the azimuth `azimuth_rad` about n.
    ///
    /// Sines come from `libm` and not from the system. The system's sines depend on the processor,
    /// and a table must not.
    pub(crate) fn new(incidence_rad: f64, azimuth_rad: f64, index: f64) -> Self {
        let (sine, cosine) = if index == 1.0 {
            libm::sincos(incidence_rad)
        } else {
            let sine = refracted_sine(libm::sin(incidence_rad), index);
            (sine, (1.0 - sine * sine).sqrt())
        };
        let (y, x) = libm::sincos(azimuth_rad);
        Incidence {
            travel: DVec3::new(sine * x, sine * y, -cosine),
            u: DVec2::new(x, y),
        }
    }

    /// Returns the axis v = n x u of the incidence frame, cell frame.
    pub(crate) fn v(&self) -> DVec2 {
        DVec2::new(-self.u.y, self.u.x)
    }

    /// Turns a vector of the entrance plane from the cell frame to the incidence frame (u, v).
    pub(crate) fn to_frame(self, vector: DVec2) -> DVec2 {
        DVec2::new(vector.dot(self.u), vector.dot(self.v()))
    }

    /// Returns the deviation of light that leaves along `travel` inside a sheet of refractive index
    /// `index`, as [`tables::Path::deviation`] defines it.
    pub(crate) fn deviation(&self, travel: DVec3, index: f64) -> DVec2 {
        let turned = |x: DVec3| self.to_frame(x.truncate()).extend(x.z);
        optics::deviation(turned(self.travel), turned(travel), index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn travel_goes_down_and_along_u() {
        let d = Incidence::new(20_f64.to_radians(), 30_f64.to_radians(), 1.49);
        let inside = (20_f64.to_radians().sin() / 1.49).asin();
        assert!((d.travel.z + inside.cos()).abs() < 1e-15);
        let along = DVec2::new(d.travel.x, d.travel.y);
        assert!((d.to_frame(along) - DVec2::new(inside.sin(), 0.0)).length() < 1e-15);
        assert!(
            (d.u.perp_dot(d.v()) - 1.0).abs() < 1e-15,
            "(u, v) is right-handed seen from the light"
        );
    }
}
