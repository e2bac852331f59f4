//! How the light of one facet sequence leaves: fixed point, map and exit direction, enclosed over a
//! patch of directions.

use glam::{DMat2, DMat3, DVec2, DVec3};

use crate::optics::Rules;
use crate::proof::leaves::Leaf;
use crate::proof::means::Enclosed;
use crate::proof::moving::{Affine, Patch, most};
use crate::proof::pits::Pit;
use crate::proof::power::power;

/// Returned light of a facet sequence.
#[derive(Debug, Clone)]
pub(crate) struct Returned {
    /// Entry point whose light leaves where it entered, affine in (s, t).
    pub fixed: [DVec2; 3],
    /// Greatest error of it, edge lengths.
    pub error: f64,
    /// Row-major linear part of the shift map, and the tangents astray as in [`tables::Family`].
    pub map: Enclosed<6>,
    /// Weight of the path, as in [`tables::Path`].
    pub weight: (Affine, f64),
}

impl Returned {
    /// Returns a bound of the weight, `limit` at most.
    pub(crate) fn most_weight(&self, limit: f64) -> f64 {
        (most(self.weight.0) + self.weight.1).min(limit)
    }

    /// Encloses the light of `leaf` of `pit`, or returns `None` if the patch is too large for it,
    /// or the map has no fixed point.
    pub(crate) fn of(leaf: &Leaf, pit: &Pit, patch: &Patch, rules: &Rules) -> Option<Returned> {
        let linear = leaf.linear;
        let launched = |tau: DVec2, down: f64| linear * tau.extend(down);
        // Direction of the light that leaves, (down the launched light) of length 1 / cos.
        let left = [
            launched(patch.centre, -1.0),
            launched(patch.first, 0.0),
            launched(patch.second, 0.0),
        ];
        let (fixed, error) = fixed_point(leaf, pit.height, left)?;
        let upright = [left[0].z, left[1].z, left[2].z];
        let [u, v] = [linear.x_axis, linear.y_axis].map(|y| carried(y, left, upright));
        let (u, v) = (u?, v?);
        let astray = |axis: usize| -> (Affine, f64) {
            let tau = [patch.centre, patch.first, patch.second];
            let part = |k: usize| left[k][axis] + tau[k][axis];
            ([part(0), part(1), part(2)], 0.0)
        };
        let less = |(mut value, error): (Affine, f64), one: f64| {
            value[0] -= one;
            (value, error)
        };
        Some(Returned {
            fixed,
            error,
            map: [
                less(u[0], 1.0),
                v[0],
                u[1],
                less(v[1], 1.0),
                astray(0),
                astray(1),
            ],
            weight: weight(leaf, pit, patch, rules),
        })
    }
}

/// Encloses the weight of a sequence. Its light leaves with no more than the power that it has
/// inside; after many surfaces, that says more than fields followed through all of them.
fn weight(leaf: &Leaf, pit: &Pit, patch: &Patch, rules: &Rules) -> (Affine, f64) {
    let (value, error) = (power(&leaf.met, leaf.linear, patch, rules) * pit.weight).enclosed();
    let half = 0.5 * leaf.power * pit.weight;
    if error <= half {
        (value, error)
    } else {
        ([half, 0.0, 0.0], half)
    }
}

/// Encloses y carried along the light to the plane of the entrance, both coordinates.
///
/// That is y - (y.z / z) times the light along the plane, with z its upward part. 1 / z = (1 / z0)
/// (1 - q + R), where q is the relative change of z, at most m, and R <= m^2 / (1 - m).
fn carried(y: DVec3, left: [DVec3; 3], upright: Affine) -> Option<[(Affine, f64); 2]> {
    let change = [1, 2].map(|k| upright[k] / upright[0]);
    let most = change[0].abs() + change[1].abs();
    if most.is_nan() || most >= 0.5 {
        return None;
    }
    let factor = -y.z / upright[0];
    Some([0, 1].map(|axis| {
        let along = [0, 1, 2].map(|k| left[k][axis]);
        let value = [
            y[axis] + factor * along[0],
            factor * (along[1] - along[0] * change[0]),
            factor * (along[2] - along[0] * change[1]),
        ];
        let moved = along[1].abs() + along[2].abs();
        let rest = most * most / (1.0 - most);
        let error = moved * most + (along[0].abs() + moved) * rest;
        (value, factor.abs() * error)
    }))
}

/// Encloses the fixed point of the map, by its equation: with p and the path length t,
/// (L - 1) (p, height) + shift + t L (tau, -1) = 0.
///
/// Any affine p and t leave a remainder. For those taken here it is the product of the changes of t
/// and tau alone. The error is the remainder by the inverse of the matrix (L - 1, L - 1, L (tau,
/// -1)), whose change over the patch makes the inverse longer by 1 / (1 - |inverse| |change|).
fn fixed_point(leaf: &Leaf, height: f64, left: [DVec3; 3]) -> Option<([DVec2; 3], f64)> {
    let linear = leaf.linear;
    let columns = DMat3::from_cols(linear.x_axis - DVec3::X, linear.y_axis - DVec3::Y, left[0]);
    let inverse = columns.inverse();
    let norm = inverse
        .to_cols_array()
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt();
    let change = left[1].length() + left[2].length();
    let flat = DMat2::from_cols(columns.x_axis.truncate(), columns.y_axis.truncate());
    // `tables` takes maps of smaller determinants for singular.
    let longer = norm * change;
    if longer.is_nan() || longer >= 0.5 || flat.determinant().abs() < 1e-2 {
        return None;
    }
    let start = -(inverse * ((linear.z_axis - DVec3::Z) * height + leaf.shift));
    let moves = [1, 2].map(|k| -(inverse * (start.z * left[k])));
    let rest = (moves[0].z * left[1]).length()
        + (moves[1].z * left[2]).length()
        + (moves[0].z * left[2] + moves[1].z * left[1]).length();
    let error = norm / (1.0 - longer) * rest;
    let fixed = [start, moves[0], moves[1]].map(|x| x.truncate());
    Some((fixed, error))
}
