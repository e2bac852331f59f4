//! Blurs that a model may have beside its kernel: two Gaussian ones, and dihedral errors.
//!
//! The Gaussian ones multiply the OTF by exp(-2 pi^2 f^2 V), where V is a variance in the plane of the mid-air
//! image, along the direction of the frequency:
//!
//! ```text
//! V = w + R^2 sigma^2 q,    q = n_s^2 + n_t^2 (cos theta' / cos theta)^2
//! ```
//!
//! - w is the blur of the camera in the photographs of the mid-air image that is not in the
//!   reference: another focus, or vibration. It is negative if the reference is less sharp.
//! - sigma is the standard deviation of the direction of the returned light, across the plane of
//!   incidence and outside of the sheet. It describes sheets whose dihedral angles differ from cell
//!   to cell.
//!
//! The factor in q follows from the refraction at the front. Let the three dihedral angles of a cube
//! be off by independent normal errors with the standard deviation e. The light that comes back is
//! turned by omega x d, where d is its direction within the cube, and omega has the components
//! +-2 e1, +-2 e2, +-2 e3 along the three edges. The signs depend on the order of the facets. The
//! covariance of omega is 4 e^2 times the identity. So whatever d and the order are, the deviation is
//! normal and round about d, with the standard deviation 2 e along each axis. At the front, Snell's
//! law multiplies the components of the direction along the face by the index m. Across the plane of
//! incidence such a component is the deviation itself: sigma_s = 2 m e. In the plane of incidence it
//! is sin theta' within the sheet and sin theta outside, and m cos theta' d theta' = cos theta
//! d theta: sigma_t = sigma_s cos theta' / cos theta. `fit/lab` checks both by rays.
//!
//! The light of a cell is displaced by R times its deviation, in the plane across the viewing ray.
//!
//! Dihedral errors that all cubes share are no such factor: each order of the facets has its own spot
//! and its own part of the ray shift. So c moves in proportion to the errors. The OTF is that of
//! [`tables::ShiftLine::with_errors`], with one error for each edge of the cube.

use std::f64::consts::PI;

/// Which of the mid-air photographs have a blur of the camera that the reference does not have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum OwnBlur {
    /// None of them.
    #[default]
    None,
    /// All have the same.
    Shared,
    /// Those at each floating distance have one of their own.
    PerDistance,
}

impl OwnBlur {
    /// Returns the number of variances in a scene with so many distances.
    pub fn count(self, distances: usize) -> usize {
        match self {
            OwnBlur::None => 0,
            OwnBlur::Shared => 1,
            OwnBlur::PerDistance => distances,
        }
    }

    /// Returns the number of the variance of the photographs at a distance, or `None` if they have none.
    pub fn of(self, distance: usize) -> Option<usize> {
        match self {
            OwnBlur::None => None,
            OwnBlur::Shared => Some(0),
            OwnBlur::PerDistance => Some(distance),
        }
    }

    fn or(self, other: OwnBlur) -> OwnBlur {
        match self {
            OwnBlur::None => other,
            own => own,
        }
    }
}

/// Blurs that a candidate has beside its kernel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Further {
    /// Blur of the mid-air photographs that the reference does not have.
    pub own_blur: OwnBlur,
    /// True for a spread of the direction of the returned light.
    pub angular_spread: bool,
    /// True for errors of the dihedral angles that all cubes share.
    pub common_errors: bool,
}

impl Further {
    /// No further blur.
    pub const NONE: Further = Further {
        own_blur: OwnBlur::None,
        angular_spread: false,
        common_errors: false,
    };

    /// A blur of the camera alone.
    pub const OWN_BLUR: Further = Further {
        own_blur: OwnBlur::Shared,
        ..Further::NONE
    };

    /// A blur of the camera at each distance alone.
    pub const PER_DISTANCE: Further = Further {
        own_blur: OwnBlur::PerDistance,
        ..Further::NONE
    };

    /// An angular spread alone.
    pub const ANGULAR_SPREAD: Further = Further {
        angular_spread: true,
        ..Further::NONE
    };

    /// Dihedral errors alone.
    pub const COMMON_ERRORS: Further = Further {
        common_errors: true,
        ..Further::NONE
    };

    /// All kinds.
    pub const ALL: Further = Further {
        own_blur: OwnBlur::Shared,
        angular_spread: true,
        common_errors: true,
    };

    /// Each alone, with one blur of the camera for all photographs.
    pub const SINGLE: [Further; 3] = [
        Further::OWN_BLUR,
        Further::ANGULAR_SPREAD,
        Further::COMMON_ERRORS,
    ];

    /// Returns the number of parameters in a scene with so many distances.
    pub fn count(self, distances: usize) -> usize {
        let variances = self.own_blur.count(distances) + usize::from(self.angular_spread);
        variances + 3 * usize::from(self.common_errors)
    }

    /// Returns the blurs of both.
    pub fn and(self, other: Further) -> Further {
        Further {
            own_blur: self.own_blur.or(other.own_blur),
            angular_spread: self.angular_spread || other.angular_spread,
            common_errors: self.common_errors || other.common_errors,
        }
    }

    /// Returns whether all of these blurs are possible. Where an own blur of each distance is, one for
    /// all photographs is too.
    pub fn are_among(self, possible: Further) -> bool {
        let apart = OwnBlur::PerDistance;
        self.without(possible) == Further::NONE
            && (self.own_blur != apart || possible.own_blur == apart)
    }

    /// Returns whether there is an own blur, of whichever photographs.
    pub fn has_own_blur(self) -> bool {
        self.own_blur != OwnBlur::None
    }

    /// Returns the blurs that the other does not have. Own blurs of whichever photographs count as
    /// one.
    pub fn without(self, other: Further) -> Further {
        Further {
            own_blur: match other.own_blur {
                OwnBlur::None => self.own_blur,
                _ => OwnBlur::None,
            },
            angular_spread: self.angular_spread && !other.angular_spread,
            common_errors: self.common_errors && !other.common_errors,
        }
    }
}

/// Square of a milliradian.
const MRAD2: f64 = 1e-6;

/// Largest logarithm of the factor. A solver that tries a camera far sharper than the reference
/// would overflow without it.
const MOST: f64 = 30.0;

/// Returns cos theta' / cos theta: by how much a spread of the light within a sheet of this index is
/// larger in the plane of incidence than across it, outside of the sheet.
pub fn tangential_gain(incidence_rad: f64, refractive_index: f64) -> f64 {
    let sine = (incidence_rad.sin() / refractive_index).clamp(-1.0, 1.0);
    (1.0 - sine * sine).sqrt() / incidence_rad.cos()
}

/// Returns R^2 q in mm^2 per mrad^2: the variance along `normal` (tangential, sagittal) that an
/// angular spread of 1 mrad causes at the distance `r_mm`. `gain` is that of [`tangential_gain`].
pub fn variance_per_mrad2(r_mm: f64, normal: [f64; 2], gain: f64) -> f64 {
    MRAD2 * r_mm * r_mm * ((normal[0] * gain).powi(2) + normal[1].powi(2))
}

/// Evaluates exp(-2 pi^2 f^2 V) for a variance in mm^2 and a frequency in 1/mm.
pub fn otf(variance_mm2: f64, frequency: f64) -> f64 {
    if variance_mm2 == 0.0 {
        return 1.0;
    }
    (variance_mm2 * slope(frequency)).min(MOST).exp()
}

/// Returns -2 pi^2 f^2, the derivative of the logarithm of the OTF by the variance, 1/mm^2.
pub fn slope(frequency: f64) -> f64 {
    -2.0 * (PI * frequency).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At normal incidence and for hollow cubes the spread is round. At 40 degrees and an index of
    /// 1.49 the ratio by hand is cos(25.557 deg) / cos(40 deg) = 0.90215 / 0.76604 = 1.17768, whose
    /// last digit is that of the angle.
    #[test]
    fn the_spread_is_wider_in_the_plane_of_incidence() {
        for (deg, index, expected) in [(0.0, 1.49, 1.0), (40.0, 1.0, 1.0), (40.0, 1.49, 1.17768)] {
            let found = tangential_gain(f64::to_radians(deg), index);
            assert!((found - expected).abs() < 1e-5, "{deg} {index}: {found}");
        }
        // 2 mrad at 500 mm are 1 mm.
        let along = |normal| 4.0 * variance_per_mrad2(500.0, normal, 1.2);
        assert!((along([0.0, 1.0]) - 1.0).abs() < 1e-15);
        assert!((along([1.0, 0.0]) - 1.44).abs() < 1e-15);
    }
}
