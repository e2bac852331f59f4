//! Reflection and refraction at a plane, as pure functions of directions.

use glam::{DMat3, DVec2, DVec3};

/// Returns the direction after a mirror reflection at a plane with unit normal `normal` (either
/// sign). The length is kept.
#[inline(always)]
pub(crate) fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// Returns the linear map of a mirror reflection at a plane with unit normal n (either sign): I - 2
/// n n^T.
pub(crate) fn reflection(normal: DVec3) -> DMat3 {
    let [x, y, z] = normal.to_array();
    DMat3::IDENTITY - DMat3::from_cols(normal * (2.0 * x), normal * (2.0 * y), normal * (2.0 * z))
}

/// Returns the linear map `map`, followed by a mirror reflection at a plane with unit normal
/// `normal` (either sign).
///
/// This is the product of [`reflection`] and `map`, in two thirds of the operations.
#[inline(always)]
pub(crate) fn mirrored(map: DMat3, normal: DVec3) -> DMat3 {
    DMat3::from_cols(
        reflect(map.x_axis, normal),
        reflect(map.y_axis, normal),
        reflect(map.z_axis, normal),
    )
}

/// Returns the sine of the angle inside a medium of refractive index `index`, from the sine outside
/// (vacuum), by Snell's law.
pub(crate) fn refracted_sine(outside_sine: f64, index: f64) -> f64 {
    outside_sine / index
}

/// Returns the direction after refraction at a plane with unit normal `normal` (either sign), from
/// a medium of refractive index `from` into one of index `to`.
///
/// Returns `None` if reflection is total.
pub(crate) fn refract(direction: DVec3, normal: DVec3, from: f64, to: f64) -> Option<DVec3> {
    let (cosine, ratio) = (direction.dot(normal), from / to);
    let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    (squared > 0.0).then(|| {
        let onward = squared.sqrt().copysign(cosine);
        direction * ratio + normal * (onward - ratio * cosine)
    })
}

/// Returns the direction outside of light along `inside` in a sheet of refractive index `index`
/// with the normal +z.
///
/// Light that cannot leave, because its reflection is total, has a length above 1.
#[inline(always)]
pub(crate) fn outside(inside: DVec3, index: f64) -> DVec3 {
    let along = inside.truncate() * index;
    let upright = (1.0 - along.length_squared()).max(0.0).sqrt();
    along.extend(upright.copysign(inside.z))
}

/// Returns the deviation outside of light that was launched along `launched` and leaves along
/// `left`.
///
/// Both directions are inside a sheet of refractive index `index` with the normal +z, and
/// `launched` lies in the plane of x and z. The deviation is the two tangents of the angles from
/// the exact way back: first across that way within the plane of incidence, towards +x, then along
/// y.
pub(crate) fn deviation(launched: DVec3, left: DVec3, index: f64) -> DVec2 {
    let (back, out) = (-outside(launched, index), outside(left, index));
    let across = DVec3::new(back.z, 0.0, -back.x);
    DVec2::new(out.dot(across), out.y) / out.dot(back)
}

/// Returns whether a ray inside a medium of refractive index `index` is totally reflected at a
/// facet against vacuum.
///
/// `cosine` is that of the angle from the facet's normal, either sign. At the critical angle itself
/// reflection is total.
pub(crate) fn totally_reflected(cosine: f64, index: f64) -> bool {
    (1.0 - cosine * cosine) * index * index >= 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflection_matrix_and_reflect_agree() {
        let mut cases = 0;
        for i in 0..50 {
            let t = i as f64;
            let n = DVec3::new(t.sin(), (1.7 * t).cos(), 0.3 + (2.3 * t).sin()).normalize();
            let d = DVec3::new((0.4 * t).cos(), (3.1 * t).sin(), -0.7).normalize();
            let r = reflect(d, n);
            assert!((reflection(n) * d - r).length() < 1e-15);
            // A unit vector keeps its length, and its component along the normal changes sign.
            // There are a dozen roundings, with those of the normal's own length counted four
            // times. Each adds at most half an epsilon.
            assert!((r.length() - 1.0).abs() < 8.0 * f64::EPSILON);
            assert!((r.dot(n) + d.dot(n)).abs() < 8.0 * f64::EPSILON);
            cases += 1;
        }
        assert_eq!(cases, 50);
    }

    /// Checks Snell's law, the plane of incidence, the way to the other side, and total reflection
    /// from the critical angle on, to a dozen roundings.
    #[test]
    fn refraction_obeys_snell() {
        let (mut through, mut total) = (0, 0);
        for i in 0..200 {
            let t = f64::from(i);
            let n = DVec3::new(t.sin(), (1.7 * t).cos(), 0.3 + (2.3 * t).sin()).normalize();
            let d = DVec3::new((0.4 * t).cos(), (3.1 * t).sin(), -0.7).normalize();
            let (from, to) = if i % 2 == 0 { (1.0, 1.93) } else { (1.93, 1.0) };
            let sine = d.cross(n) * (from / to);
            match refract(d, n, from, to) {
                None => {
                    assert!(sine.length() >= 1.0 && i % 2 == 1);
                    total += 1;
                }
                Some(r) => {
                    assert!((r.cross(n) - sine).length() < 16.0 * f64::EPSILON);
                    assert!((r.length() - 1.0).abs() < 16.0 * f64::EPSILON);
                    assert!(r.dot(n) * d.dot(n) > 0.0, "goes on to the other side");
                    through += 1;
                }
            }
        }
        println!("{through} refracted, {total} totally reflected");
        assert!(through > 100 && total > 30);
    }

    #[test]
    fn critical_angle_of_acrylic() {
        // asin(1/1.49) = 42.1554 deg
        let cos_deg = |a: f64| a.to_radians().cos();
        assert!(totally_reflected(cos_deg(42.16), 1.49));
        assert!(!totally_reflected(cos_deg(42.15), 1.49));
        assert!(!totally_reflected(1.0, 1.49));
        assert!(totally_reflected(0.0, 1.49));
    }
}
