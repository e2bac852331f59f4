//! The power of unpolarised light at surfaces: Fresnel's amplitudes, carried along a path in three
//! dimensions.
//!
//! Unpolarised light is an even mixture of any two orthogonal polarisations. So its power after a
//! path is the mean power of two orthogonal fields that were launched with unit power. Both are
//! followed as complex vectors (polarisation ray tracing: Yun, Crabtree and Chipman, Applied Optics
//! 50, 2855, 2011). Taking the mean of s and p at every single surface would be wrong: a facet
//! polarises the light that the next facet receives.
//!
//! Fields are scaled so that |E|^2 is the power through an area that travels along. A transmitted
//! amplitude therefore contains sqrt(n2 cos2 / n1 cos1).
//!
//! Time is exp(-i omega t), and an index is n + ik with k >= 0. For the direction d and the facet's
//! normal N, s = d x N and, for each direction, p = d x s. So r_p = -r_s at normal incidence. Only
//! square roots are taken, so that all processors give the same bits.

use crate::optics::mirror::reflect;
use glam::DVec3;
use num_complex::Complex64;
use tables::{Fate, Jones};

/// The medium or the coating behind a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Backing {
    /// A mirror that reflects a fixed share of the power at every angle. It keeps the polarisation
    /// of an ideal mirror.
    Mirror {
        /// Share of the power that is reflected, above 0 and at most 1.
        reflectance: f64,
    },
    /// A thick metal of this complex refractive index.
    Metal(Complex64),
    /// Vacuum. Light is reflected by total internal reflection, or in part by Fresnel's equations.
    Bare,
}

impl Backing {
    /// Returns the fate of the light that the facet does not reflect.
    pub(crate) fn takes(&self) -> Fate {
        match self {
            Backing::Mirror { .. } | Backing::Metal(_) => Fate::Absorbed,
            Backing::Bare => Fate::Transmitted,
        }
    }

    /// Returns the amplitudes [r_s, r_p] of the reflection inside a medium of refractive index
    /// `index`.
    ///
    /// `cosine` is that of the angle from the normal. The power is never more than 1 but for
    /// rounding.
    pub(crate) fn reflection(&self, index: f64, cosine: f64) -> [Complex64; 2] {
        match *self {
            Backing::Mirror { reflectance } => {
                let amplitude = Complex64::from(reflectance.sqrt());
                [-amplitude, amplitude]
            }
            Backing::Metal(metal) => reflection(index, cosine, metal),
            Backing::Bare => reflection(index, cosine, Complex64::ONE),
        }
    }
}

/// Returns Fresnel's [r_s, r_p] between a medium of real index `from` and one of complex index
/// `to`.
fn reflection(from: f64, cosine: f64, to: Complex64) -> [Complex64; 2] {
    let squared = to * to;
    // This is n2 cos2. Behind a totally reflecting facet the field decays, which is the root with
    // the positive imaginary part.
    let onward = root(squared - from * from * (1.0 - cosine * cosine));
    let s = (from * cosine - onward) / (from * cosine + onward);
    let p = (squared * cosine - onward * from) / (squared * cosine + onward * from);
    [s, p]
}

/// Returns the amplitudes [t_s, t_p] between two transparent media, scaled to power. A side is
/// given as (index, cosine of the angle).
fn transmission(from: (f64, f64), to: (f64, f64)) -> [f64; 2] {
    let ((n1, cos1), (n2, cos2)) = (from, to);
    let both = 2.0 * (n1 * cos1 * n2 * cos2).sqrt();
    [
        both / (n1 * cos1 + n2 * cos2),
        both / (n2 * cos1 + n1 * cos2),
    ]
}

/// Returns the square root whose imaginary part is not negative, of a number whose imaginary part
/// is not negative.
fn root(z: Complex64) -> Complex64 {
    let size = (z.re * z.re + z.im * z.im).sqrt();
    if size == 0.0 {
        return Complex64::ZERO;
    }
    // The part that does not cancel is computed first.
    let large = (f64::midpoint(size, z.re.abs())).sqrt();
    let small = z.im / (2.0 * large);
    if z.re >= 0.0 {
        Complex64::new(large, small)
    } else {
        Complex64::new(small, large)
    }
}

/// Returns the axes s and p of light along `direction` at a surface with unit normal `normal`.
fn axes(direction: DVec3, normal: DVec3) -> (DVec3, DVec3) {
    // Along the normal any s is right: there r_p = -r_s, to the square of the angle.
    let across = direction.cross(normal);
    let s = if across.length_squared() > 1e-24 {
        across.normalize()
    } else {
        direction.any_orthonormal_vector()
    };
    (s, direction.cross(s))
}

/// An electric field as real and imaginary part, scaled so that |E|^2 is the power.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Field {
    re: DVec3,
    im: DVec3,
}

impl Field {
    fn along(axis: DVec3, amplitude: f64) -> Self {
        Field {
            re: axis * amplitude,
            im: DVec3::ZERO,
        }
    }

    fn dot(&self, axis: DVec3) -> Complex64 {
        Complex64::new(self.re.dot(axis), self.im.dot(axis))
    }

    fn power(&self) -> f64 {
        self.re.length_squared() + self.im.length_squared()
    }
}

/// Light on its way, as two fields that were orthogonal and of unit power at the launch outside the
/// sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PolarisedLight([Field; 2]);

impl PolarisedLight {
    /// Returns light that has passed the flat front face of a sheet.
    ///
    /// The face has the normal +z and the sheet the refractive index `index`. The light now travels
    /// along `travel`, unit length, inside the sheet.
    pub(crate) fn entered(travel: DVec3, index: f64) -> Self {
        let (inside, outside) = cosines(travel, index);
        let (s, p) = axes(travel, DVec3::Z);
        let [ts, tp] = transmission((1.0, outside), (index, inside));
        PolarisedLight([Field::along(s, ts), Field::along(p, tp)])
    }

    /// Returns light before a front face that takes nothing, as if it kept all polarisations.
    pub(crate) fn whole(travel: DVec3) -> Self {
        let (s, p) = axes(travel, DVec3::Z);
        PolarisedLight([Field::along(s, 1.0), Field::along(p, 1.0)])
    }

    /// Returns the Jones matrix of light that was launched along `launched` and leaves along `left`,
    /// both inside the sheet and of unit length; see [`tables::Jones`].
    ///
    /// `launched` lies in the plane of x and z. `front` gives the amplitudes [t_s, t_p] at which the
    /// front face is passed.
    pub(crate) fn jones(&self, launched: DVec3, left: DVec3, front: [f64; 2]) -> Jones {
        let along_v = DVec3::Y;
        // The fields were launched along the axes of the front face. Seen along the light, the angle
        // between these axes and the table's is the same on both sides of the face.
        let (own, _) = axes(launched, DVec3::Z);
        let turn = [own.dot(along_v), own.dot(along_v.cross(launched))];
        let (s, p) = axes(left, DVec3::Z);
        let leaving = [s.dot(along_v), s.dot(along_v.cross(left))];
        let out = self.0.map(|field| {
            let [t_s, t_p] = front;
            let (along_s, along_p) = (field.dot(s) * t_s, field.dot(p) * t_p);
            // p of the table is s x the direction, that of a surface the direction x s.
            let [cosine, sine] = leaving;
            [
                along_s * cosine + along_p * sine,
                along_s * sine - along_p * cosine,
            ]
        });
        let [cosine, sine] = turn;
        let launched = |part: usize| {
            let (by_s, by_p) = (out[0][part], out[1][part]);
            [by_s * cosine + by_p * sine, by_s * sine - by_p * cosine]
        };
        [0, 1].map(|part| launched(part).map(|amplitude| [amplitude.re, amplitude.im]))
    }

    /// Returns the power as a share of the launched power.
    pub(crate) fn power(&self) -> f64 {
        f64::midpoint(self.0[0].power(), self.0[1].power()).min(1.0)
    }

    /// Returns the light after the reflection at a facet.
    ///
    /// `travel` is the direction before it, unit length, and `index` the refractive index of the
    /// medium.
    pub(crate) fn reflected(
        &self,
        travel: DVec3,
        normal: DVec3,
        surface: &Backing,
        index: f64,
    ) -> Self {
        let [rs, rp] = surface.reflection(index, travel.dot(normal).abs());
        let (s, p) = axes(travel, normal);
        let onward = reflect(travel, normal).cross(s);
        PolarisedLight(self.0.map(|field| {
            let (along_s, along_p) = (rs * field.dot(s), rp * field.dot(p));
            Field {
                re: s * along_s.re + onward * along_p.re,
                im: s * along_s.im + onward * along_p.im,
            }
        }))
    }

    /// Returns the light that the front face reflects back inside.
    pub(crate) fn kept_inside(&self, travel: DVec3, index: f64) -> Self {
        self.reflected(travel, DVec3::Z, &Backing::Bare, index)
    }

    /// Returns the power that leaves through the front face, as a share of the launched power.
    ///
    /// `travel` is the direction inside, unit length. Beyond the critical angle the power is 0.
    pub(crate) fn power_outside(&self, travel: DVec3, index: f64) -> f64 {
        let (s, p) = axes(travel, DVec3::Z);
        let [ts, tp] = passes_outside(travel, index);
        let power =
            |field: &Field| ts * ts * field.dot(s).norm_sqr() + tp * tp * field.dot(p).norm_sqr();
        f64::midpoint(power(&self.0[0]), power(&self.0[1])).min(1.0)
    }
}

/// Returns the amplitudes [t_s, t_p], scaled to power, of light that leaves through the front face
/// along `travel`, a unit direction inside.
pub(crate) fn passes_outside(travel: DVec3, index: f64) -> [f64; 2] {
    let (inside, outside) = cosines(travel, index);
    transmission((index, inside), (1.0, outside))
}

/// Returns the cosines of the angles from z inside and outside. The outer cosine is 0 if light is
/// totally reflected.
fn cosines(travel: DVec3, index: f64) -> (f64, f64) {
    let sine = index * travel.truncate().length();
    (travel.z.abs(), (1.0 - sine * sine).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding error of a dozen operations.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;

    /// Checks Fresnel's closed forms: ((m - 1)/(m + 1))^2 at normal incidence, ((n - m)^2 +
    /// k^2)/((n + m)^2 + k^2) of a metal, no p at Brewster's angle, the energy of both sides of a
    /// dielectric, and 1 beyond the critical angle.
    #[test]
    fn closed_forms() {
        let mut cases = 0;
        for index in [1.0, 1.33, 1.49, 1.586] {
            let expected = ((index - 1.0) / (index + 1.0_f64)).powi(2);
            for r in Backing::Bare.reflection(index, 1.0) {
                assert!((r.norm_sqr() - expected).abs() < ROUNDING);
            }
            let entered = PolarisedLight::entered(DVec3::NEG_Z, index);
            assert!((entered.power() - (1.0 - expected)).abs() < ROUNDING);
            let metal = Complex64::new(0.96, 6.69);
            let expected = ((metal.re - index).powi(2) + metal.im.powi(2))
                / ((metal.re + index).powi(2) + metal.im.powi(2));
            for r in Backing::Metal(metal).reflection(index, 1.0) {
                assert!((r.norm_sqr() - expected).abs() < ROUNDING);
            }
            let brewster = (1.0 / index).atan().cos();
            assert!(Backing::Bare.reflection(index, brewster)[1].norm() < ROUNDING);
            for degrees in 0..90 {
                let cosine = f64::from(degrees).to_radians().cos();
                let sine = index * (1.0 - cosine * cosine).sqrt();
                let r = Backing::Bare.reflection(index, cosine);
                if sine < 1.0 {
                    let t = transmission((index, cosine), (1.0, (1.0 - sine * sine).sqrt()));
                    for (r, t) in r.iter().zip(t) {
                        // Near the critical angle the outer cosine loses half its digits, and so
                        // does t^2.
                        let slack = ROUNDING / (1.0 - sine * sine).sqrt();
                        assert!((r.norm_sqr() + t * t - 1.0).abs() < slack, "{degrees}");
                    }
                } else {
                    for r in r {
                        assert!((r.norm_sqr() - 1.0).abs() < ROUNDING);
                    }
                }
                cases += 1;
            }
        }
        assert_eq!(cases, 360);
    }

    /// Checks the phases of total reflection: tan(d_s/2) = sqrt(sin^2 - 1/m^2)/cos and tan(d_p/2) =
    /// m^2 times that (Born and Wolf, 1.5.4), here in a frame in which r_p has the other sign.
    #[test]
    fn total_reflection_turns_the_phase() {
        let index = 1.49;
        let mut cases = 0;
        for degrees in 43..89 {
            let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
            let half = (sine * sine - 1.0 / (index * index)).sqrt() / cosine;
            let [s, p] = Backing::Bare.reflection(index, cosine);
            // (1 - i h)/(1 + i h)
            let phase = |h: f64| Complex64::new(1.0, -h) / Complex64::new(1.0, h);
            assert!((s - phase(half)).norm() < 1e2 * ROUNDING, "{degrees}");
            assert!((p - phase(index * index * half)).norm() < 1e2 * ROUNDING);
            cases += 1;
        }
        assert_eq!(cases, 46);
    }

    #[test]
    fn roots_square_to_their_numbers() {
        let mut cases = 0;
        for i in 0..200 {
            let angle = f64::from(i) / 199.0 * std::f64::consts::PI;
            let z = Complex64::new(angle.cos(), angle.sin().max(0.0)) * 10_f64.powi(i % 7 - 3);
            let w = root(z);
            assert!(w.im >= 0.0 && (w * w - z).norm() <= ROUNDING * z.norm());
            cases += 1;
        }
        assert_eq!(root(Complex64::ZERO), Complex64::ZERO);
        assert_eq!(cases, 200);
    }

    /// Checks that the choice of s does not matter along a facet's normal, where s is arbitrary.
    #[test]
    fn a_field_along_the_normal_depends_on_no_axis() {
        let surface = Backing::Metal(Complex64::new(0.96, 6.69));
        let light = PolarisedLight::entered(DVec3::new(0.3, 0.1, -0.9).normalize(), 1.0);
        let straight = light.reflected(DVec3::NEG_Z, DVec3::Z, &surface, 1.0);
        let mut cases = 0;
        for i in 0..12 {
            let (y, x) = f64::from(i).sin_cos();
            let tilt = DVec3::new(1e-9 * x, 1e-9 * y, 1.0).normalize();
            let tilted = light.reflected(DVec3::NEG_Z, tilt, &surface, 1.0);
            for (a, b) in straight.0.iter().zip(&tilted.0) {
                // The direction after the reflection turns by twice the tilt.
                assert!((a.re - b.re).length() + (a.im - b.im).length() < 1e-8);
            }
            cases += 1;
        }
        assert_eq!(cases, 12);
    }
}
