//! Power that the light of one facet sequence keeps, enclosed over a patch of directions.
//!
//! `optics::light` follows fields in space. Here all is folded back to the launched direction d: a
//! facet that is met after the linear map L has the normal N = transpose(L) (its normal in space).
//! With c = -d . N, the cosine of the angle from the facet, and q = N + c d, a vector across the
//! light of the length of its sine, the facet turns the field E into r_s E - (r_s + r_p) q (q . E)
//! / |q|^2. (Behind it the image of s is s, that of p is -p; folding back undoes the image.) Now
//! (r_s + r_p) / |q|^2 is smooth where the light falls straight onto the facet, for Fresnel's
//! amplitudes give
//!
//! r_s + r_p = 2 n1 (n1^2 - n2^2) |q|^2 / ((n1 c + o)(n2^2 c + o n1)), o = n2 cos2.
//!
//! In the same way t_p^2 - t_s^2 of the front face is smooth: it is |e|^2 times 4 n c0 c
//! (n^2 - 1)^2 / ((c0 + n c)^2 (c + n c0)^2), with c0 the cosine outside and e the part of the
//! face's normal across the light. The power of unpolarised light is half the trace of the matrix
//! that these factors make of the mean of all fields.

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use crate::optics::{Backing, Rules};
use crate::proof::moving::{Patch, most};
use crate::proof::series::{Complex, Series};

type Vector = [Series; 3];

/// Hermitian matrix.
type Matrix = [[Complex; 3]; 3];

/// Surface that reflects light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surface {
    /// Unit normal against the light, folded back.
    pub normal: DVec3,
    /// True for the front face, false for a facet.
    pub is_front: bool,
}

/// Encloses the share of the power that light keeps: of the direction `patch`, reflected by the
/// surfaces `met`, that leaves with the linear map `linear`.
///
/// The error is infinite or not a number if the patch is too large, as where light comes to the
/// limit of total reflection.
pub(crate) fn power(met: &[Surface], linear: DMat3, patch: &Patch, rules: &Rules) -> Series {
    let Some(backing) = rules.losses else {
        return 1.0.into();
    };
    let travel = travel(patch);
    let fields = kept(met, &travel, &backing, rules.refractive_index);
    let up = linear.transpose() * DVec3::Z;
    left(&fields, &travel, up, rules.refractive_index)
}

/// Returns a bound of the share of the power that light has inside after the surfaces `met`.
pub(crate) fn most_inside(met: &[Surface], patch: &Patch, rules: &Rules) -> f64 {
    let Some(backing) = rules.losses else {
        return 1.0;
    };
    let fields = kept(met, &travel(patch), &backing, rules.refractive_index);
    let trace = fields[0][0].re + fields[1][1].re + fields[2][2].re;
    let (share, error) = (trace * 0.5).enclosed();
    // The minimum of 1 and what is not a number is 1.
    (most(share) + error).min(1.0)
}

/// Returns a bound of the share of its power that any light keeps at `surface`.
pub(crate) fn most_reflected(surface: &Surface, patch: &Patch, rules: &Rules) -> f64 {
    let backing = match rules.losses {
        None => return 1.0,
        Some(_) if surface.is_front => Backing::Bare,
        Some(backing) => backing,
    };
    let index = rules.refractive_index;
    let cosine = -dot(&travel(patch), surface.normal);
    let (straight, crossed) = match backing {
        Backing::Mirror { reflectance } => return reflectance,
        Backing::Metal(metal) => reflection(index, metal, cosine),
        Backing::Bare => reflection(index, Complex64::ONE, cosine),
    };
    let parallel = straight + crossed * (Series::from(1.0) - cosine * cosine);
    let share = |amplitude: Complex| {
        let (share, error) = amplitude.squared().enclosed();
        // The minimum of 1 and what is not a number is 1.
        (most(share) + error).min(1.0)
    };
    share(straight).max(share(parallel))
}

/// Returns the mean of the fields inside after the surfaces `met`.
fn kept(met: &[Surface], travel: &Vector, backing: &Backing, index: f64) -> Matrix {
    let mut fields = entered(travel, index);
    for surface in met {
        let backing = if surface.is_front {
            &Backing::Bare
        } else {
            backing
        };
        fields = reflected(&fields, travel, surface.normal, backing, index);
    }
    fields
}

/// Returns the unit vector along the launched light.
fn travel(patch: &Patch) -> Vector {
    let along =
        |axis: usize| Series::affine([patch.centre[axis], patch.first[axis], patch.second[axis]]);
    let (x, y) = (along(0), along(1));
    let shorter = (x * x + y * y + 1.0.into()).root().reciprocal();
    [x * shorter, y * shorter, -shorter]
}

fn dot(a: &Vector, b: DVec3) -> Series {
    a[0] * b.x + a[1] * b.y + a[2] * b.z
}

/// Returns the part of `normal` across the light, whose cosine with it is `along`.
fn across(travel: &Vector, normal: DVec3, along: Series) -> Vector {
    [0, 1, 2].map(|k| Series::from(normal[k]) - travel[k] * along)
}

/// Returns t_s^2 of the front face, and (t_p^2 - t_s^2) / sin^2 inside, for the cosine inside.
fn transmission(cosine: Series, index: f64) -> [Series; 2] {
    let outside = (Series::from(1.0 - index * index) + cosine * cosine * (index * index)).root();
    let s = (outside + cosine * index).reciprocal();
    let p = (cosine + outside * index).reciprocal();
    let both = outside * cosine * (4.0 * index);
    let change = (index * index - 1.0).powi(2);
    [both * s * s, both * (s * s) * (p * p) * change]
}

/// Returns the mean of the fields behind the front face, each times its conjugate.
fn entered(travel: &Vector, index: f64) -> Matrix {
    let [even, odd] = transmission(-travel[2], index);
    let tilt = across(travel, DVec3::Z, travel[2]);
    let at = |i: usize, j: usize| {
        let identity = Series::from(f64::from(u8::from(i == j))) - travel[i] * travel[j];
        Complex::from(even * identity + odd * tilt[i] * tilt[j])
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| at(i, j)))
}

/// Returns the mean of the fields behind a facet.
fn reflected(
    fields: &Matrix,
    travel: &Vector,
    normal: DVec3,
    backing: &Backing,
    index: f64,
) -> Matrix {
    let cosine = -dot(travel, normal);
    let (straight, crossed) = match *backing {
        Backing::Mirror { reflectance } => {
            return fields.map(|row| row.map(|field| field * reflectance));
        }
        Backing::Metal(metal) => reflection(index, metal, cosine),
        Backing::Bare => reflection(index, Complex64::ONE, cosine),
    };
    let q = across(travel, normal, -cosine);
    let times = |row: &[Complex; 3]| {
        let parts = [0, 1, 2].map(|k| row[k] * q[k]);
        parts[0] + parts[1] + parts[2]
    };
    let seen = [0, 1, 2].map(|i| times(&fields[i]));
    let twice = times(&seen).re;
    let (size, both) = (straight.squared(), straight * crossed.conjugate());
    let second = crossed.squared() * twice;
    let at = |i: usize, j: usize| {
        let one = both * seen[i] * q[j];
        let other = both.conjugate() * seen[j].conjugate() * q[i];
        let square = Complex::from(second * q[i] * q[j]);
        fields[i][j] * size + one + other + square
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| at(i, j)))
}

/// Returns r_s, and -(r_s + r_p) / sin^2, between a medium of the index `from` and one of the index
/// `to`.
fn reflection(from: f64, to: Complex64, cosine: Series) -> (Complex, Complex) {
    let squared = to * to;
    let onward = Complex::root(squared - from * from, from * from, cosine * cosine);
    let near = Complex::from(cosine * from);
    let s = (near + onward).reciprocal();
    let p = (Complex::from(squared) * cosine + onward * from).reciprocal();
    let change = (squared - from * from) * (2.0 * from);
    ((near - onward) * s, Complex::from(change) * s * p)
}

/// Returns the power outside of light that leaves through the front face, whose folded normal is
/// `up`.
fn left(fields: &Matrix, travel: &Vector, up: DVec3, index: f64) -> Series {
    let cosine = dot(travel, up);
    let [even, odd] = transmission(cosine, index);
    let tilt = across(travel, up, cosine);
    let trace = fields[0][0].re + fields[1][1].re + fields[2][2].re;
    let mut tilted = Series::from(0.0);
    for (i, row) in fields.iter().enumerate() {
        for (j, field) in row.iter().enumerate() {
            tilted = tilted + field.re * tilt[i] * tilt[j];
        }
    }
    (even * trace + odd * tilted) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Light, mirrored, reflect};
    use glam::DVec2;

    const ALUMINIUM: Complex64 = Complex64::new(0.96, 6.69);

    /// Returns normals of facets that are nearly at right angles.
    fn facets() -> [DVec3; 3] {
        [
            DVec3::new(0.8, 0.1, 0.59),
            DVec3::new(-0.4, 0.7, 0.58),
            DVec3::new(-0.38, -0.72, 0.575),
        ]
        .map(DVec3::normalize)
    }

    /// Returns a patch of about `size` around tangents.
    fn small(size: f64, centre: [f64; 2]) -> Patch {
        Patch {
            centre: DVec2::from_array(centre),
            first: size * DVec2::new(0.8, 0.3),
            second: size * DVec2::new(-0.2, 0.5),
            axis: DVec2::X,
            turn: 0.0,
        }
    }

    /// Returns 25 directions of a patch: (s, t), and the unit vector along the light.
    fn directions(patch: &Patch) -> [(f64, f64, DVec3); 25] {
        std::array::from_fn(|k| {
            let [s, t] = [k % 5, k / 5].map(|x| 0.5 * x as f64 - 1.0);
            let tau = patch.centre + s * patch.first + t * patch.second;
            (s, t, tau.extend(-1.0).normalize())
        })
    }

    /// Fields that are followed in space, as the bakes do, lie within the enclosure. Its error
    /// falls with the size of the patch. Normal incidence on the front is among the patches.
    #[test]
    fn light_in_space_keeps_what_is_enclosed() {
        let facets = facets();
        let (mut cases, mut closest) = (0, f64::INFINITY);
        let mut errors = Vec::new();
        for (index, backing) in [
            (1.0, Backing::Metal(ALUMINIUM)),
            (1.49, Backing::Metal(ALUMINIUM)),
            (1.49, Backing::Mirror { reflectance: 0.8 }),
            (1.6, Backing::Bare),
            (1.8, Backing::Bare),
        ] {
            let rules = Rules {
                losses: Some(backing),
                ..Rules::mirrors(index)
            };
            // Total reflection bends its phases steeply near the limit.
            let most = if backing == Backing::Bare {
                0.004
            } else {
                0.02
            };
            for size in [most, 0.5 * most] {
                let mut sum = 0.0;
                for centre in [[0.0, 0.0], [0.1, -0.05], [0.02, 0.1]] {
                    let patch = small(size, centre);
                    let (mut map, mut folded) = (DMat3::IDENTITY, Vec::new());
                    for normal in facets {
                        folded.push(Surface {
                            normal: map.transpose() * normal,
                            is_front: false,
                        });
                        map = mirrored(map, normal);
                    }
                    let found = power(&folded, map, &patch, &rules);
                    let (affine, error) = found.enclosed();
                    sum += error;
                    for (s, t, mut travel) in directions(&patch) {
                        let mut light = Light::entered(travel, index);
                        for normal in facets {
                            light = light.reflected(travel, normal, &backing, index);
                            travel = reflect(travel, normal);
                        }
                        let truth = light.power_outside(travel, index);
                        let value = affine[0] + s * affine[1] + t * affine[2];
                        let off = (truth - value).abs();
                        assert!(off <= error + 1e-13, "{backing:?} {centre:?}: {off:e}");
                        closest = closest.min(error - off);
                        cases += 1;
                    }
                }
                errors.push(sum / 3.0);
            }
        }
        println!("{cases} directions; mean errors {errors:?}");
        assert!(cases == 750 && closest < 1e-3);
        for pair in errors.chunks(2) {
            assert!(pair[1] < 0.3 * pair[0] && pair[1] < 0.02, "{pair:?}");
        }
    }

    /// Light that the front sends back to the facets keeps the power that is enclosed, inside and
    /// outside, also where a patch lies across the limit of total reflection: there the enclosure
    /// is wide, but not infinite.
    #[test]
    fn light_that_the_front_sends_back_keeps_what_is_enclosed() {
        let facets = facets().map(|normal| (normal, false));
        let front = (DVec3::NEG_Z, true);
        let [a, b, c] = facets;
        let (mut cases, mut at_the_limit) = (0, 0);
        for (index, backing) in [
            (1.49, Backing::Metal(ALUMINIUM)),
            (1.49, Backing::Mirror { reflectance: 0.8 }),
            (1.6, Backing::Bare),
            // The cosines of the facets are 0.59, 0.585 and 0.577; the limit is at 0.58.
            (1.228, Backing::Bare),
        ] {
            let rules = Rules {
                losses: Some(backing),
                ..Rules::mirrors(index)
            };
            for (size, centre) in [
                (0.004, [0.0, 0.0]),
                (0.002, [0.1, -0.05]),
                (0.01, [0.02, 0.1]),
            ] {
                let patch = small(size, centre);
                let (mut map, mut met) = (DMat3::IDENTITY, Vec::new());
                let mut most = 1.0;
                for (normal, is_front) in [a, b, c, front, c, a, b] {
                    let surface = Surface {
                        normal: map.transpose() * normal,
                        is_front,
                    };
                    most *= most_reflected(&surface, &patch, &rules);
                    met.push(surface);
                    map = mirrored(map, normal);
                }
                let outside = power(&met, map, &patch, &rules).enclosed();
                let inside = most.min(most_inside(&met, &patch, &rules));
                assert!(outside.1.is_finite(), "{backing:?} {centre:?}");
                let limit = (1.0 - index.powi(-2)).sqrt();
                let (mut above, mut below) = (false, false);
                for (s, t, mut travel) in directions(&patch) {
                    let mut light = Light::entered(travel, index);
                    for (normal, is_front) in [a, b, c, front, c, a, b] {
                        let cosine = -travel.dot(normal);
                        assert!(cosine > 0.0, "the light meets the outside");
                        above |= cosine > limit;
                        below |= cosine < limit;
                        light = match is_front {
                            true => light.kept_inside(travel, index),
                            false => light.reflected(travel, normal, &backing, index),
                        };
                        travel = reflect(travel, normal);
                    }
                    let truth = light.power_outside(travel, index);
                    let value = outside.0[0] + s * outside.0[1] + t * outside.0[2];
                    let off = (truth - value).abs();
                    assert!(off <= outside.1 + 1e-13, "{backing:?} {centre:?}: {off:e}");
                    assert!(light.power() <= inside + 1e-13, "{backing:?} {centre:?}");
                    cases += 1;
                }
                at_the_limit += u32::from(index < 1.3 && above && below);
            }
        }
        println!("{cases} directions; {at_the_limit} patches at the limit");
        assert!(cases == 300 && at_the_limit > 1);
    }
}
