//! Ray shifts of the ideal corner cube in closed form, without a table: the polygon of each cube,
//! its share of the light, and its marginal along an edge normal.
//!
//! The frame is that of the aperture plane: u in the plane of incidence, v = n x u, edge lengths,
//! origin at the centroid of the aperture. q is the apex, projected along the ray on this plane. A
//! ray that enters at p leaves at 2 q - p. So the shift is uniform over 2 (q - K), where K is the
//! aperture intersected with its point reflection through q.

/// Height of the aperture above the apex, edge lengths: 1/sqrt(3).
const HEIGHT: f64 = 0.577_350_269_189_625_8;
/// Distance of the aperture's corners from its centroid, edge lengths: sqrt(2/3).
const CIRCUMRADIUS: f64 = 0.816_496_580_927_726;
/// Area of the aperture, square edge lengths: sqrt(3)/2.
const APERTURE_AREA: f64 = 0.866_025_403_784_438_6;

/// Ray shifts of one cube for one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct CubeShift {
    /// Corners of the polygon over which the shift (u, v) is uniform, counter-clockwise, edge
    /// lengths. Empty if no light returns.
    pub polygon: Vec<[f64; 2]>,
    /// Share of the light on this cube's aperture that is retroreflected.
    pub retroreflected: f64,
}

/// Returns the ray shifts of the cubes of a cell: of one cube, or of the pair (the second cube is
/// turned by 180 degrees about the normal).
///
/// `incidence_rad` is measured in the air, in front of a flat face; `refractive_index` is that
/// behind the face (1 for hollow cubes). `azimuth_rad` is that of a table. The eta of the whole
/// cell is the mean of the cubes' `eta`.
pub(crate) fn shifts(
    incidence_rad: f64,
    azimuth_rad: f64,
    refractive_index: f64,
    pair: bool,
) -> Vec<CubeShift> {
    let inside_rad = (incidence_rad.sin() / refractive_index)
        .clamp(-1.0, 1.0)
        .asin();
    let turns = if pair {
        &[0.0, std::f64::consts::PI][..]
    } else {
        &[0.0][..]
    };
    turns
        .iter()
        .map(|turn| cube_shift(inside_rad, azimuth_rad + turn))
        .collect()
}

fn cube_shift(inside_rad: f64, azimuth_rad: f64) -> CubeShift {
    let corner = |k: usize| {
        let angle = k as f64 * std::f64::consts::TAU / 3.0 - azimuth_rad;
        [CIRCUMRADIUS * angle.cos(), CIRCUMRADIUS * angle.sin()]
    };
    let apex_u = -HEIGHT * inside_rad.tan();
    let triangle = [corner(0), corner(1), corner(2)];
    let reflected = triangle.map(|[u, v]| [2.0 * apex_u - u, -v]);
    let mut overlap = triangle.to_vec();
    for k in 0..3 {
        overlap = clip(&overlap, reflected[k], reflected[(k + 1) % 3]);
    }
    let eta = area(&overlap) / APERTURE_AREA;
    // Triangles that only touch leave a sliver of rounding errors, which is no light.
    if eta < 1e-12 {
        return CubeShift {
            polygon: Vec::new(),
            retroreflected: 0.0,
        };
    }
    CubeShift {
        polygon: overlap
            .iter()
            .map(|&[u, v]| [2.0 * (apex_u - u), -2.0 * v])
            .collect(),
        retroreflected: eta,
    }
}

/// Returns the part of a convex polygon to the left of the line from `from` to `to` (Sutherland and
/// Hodgman).
fn clip(polygon: &[[f64; 2]], from: [f64; 2], to: [f64; 2]) -> Vec<[f64; 2]> {
    let side =
        |p: [f64; 2]| (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]);
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &here) in polygon.iter().enumerate() {
        let next = polygon[(k + 1) % polygon.len()];
        let (a, b) = (side(here), side(next));
        if a >= 0.0 {
            kept.push(here);
        }
        if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
            let part = a / (a - b);
            kept.push([
                here[0] + part * (next[0] - here[0]),
                here[1] + part * (next[1] - here[1]),
            ]);
        }
    }
    kept
}

/// Returns the area of a counter-clockwise polygon.
pub(crate) fn area(polygon: &[[f64; 2]]) -> f64 {
    let twice: f64 = (0..polygon.len())
        .map(|k| {
            let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            p[0] * q[1] - p[1] * q[0]
        })
        .sum();
    0.5 * twice
}

/// A piece of a piecewise linear probability density: from (`low`, `at_low`) to (`high`,
/// `at_high`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ramp {
    /// Lower end of the piece.
    pub low: f64,
    /// Upper end of the piece.
    pub high: f64,
    /// Density at `low`.
    pub at_low: f64,
    /// Density at `high`.
    pub at_high: f64,
}

impl Ramp {
    /// Returns the mass of the piece.
    pub(crate) fn mass(&self) -> f64 {
        0.5 * (self.at_low + self.at_high) * (self.high - self.low)
    }

    /// Returns the integral of max(t - w, 0) times the density over w, for this piece.
    pub(crate) fn twice_integrated(&self, t: f64) -> f64 {
        if t <= self.low {
            return 0.0;
        }
        let width = self.high - self.low;
        let slope = (self.at_high - self.at_low) / width;
        let reach = (t - self.low).min(width);
        // Up to `reach`: integral of (t - low - x) (at_low + slope x) dx.
        let lever = t - self.low;
        lever * (self.at_low * reach + 0.5 * slope * reach * reach)
            - (0.5 * self.at_low * reach * reach + slope * reach * reach * reach / 3.0)
    }
}

/// Returns the density of `along . r` for r uniform over a convex polygon: exact, piecewise linear,
/// of mass 1. Returns an empty list if the projection is narrower than 1e-12; the density is then a
/// single point at the projection.
pub(crate) fn marginal(polygon: &[[f64; 2]], along: [f64; 2]) -> Vec<Ramp> {
    // Coordinates (along, across): a chord is a difference of the second at an equal first.
    let turned: Vec<[f64; 2]> = polygon
        .iter()
        .map(|p| {
            [
                along[0] * p[0] + along[1] * p[1],
                along[0] * p[1] - along[1] * p[0],
            ]
        })
        .collect();
    let mut knots: Vec<f64> = turned.iter().map(|p| p[0]).collect();
    knots.sort_by(f64::total_cmp);
    let chord = |w: f64| {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (k, &p) in turned.iter().enumerate() {
            let q = turned[(k + 1) % turned.len()];
            if (p[0] < w) != (q[0] < w) {
                let across = p[1] + (w - p[0]) / (q[0] - p[0]) * (q[1] - p[1]);
                least = least.min(across);
                most = most.max(across);
            }
        }
        (most - least).max(0.0)
    };
    let mut ramps: Vec<Ramp> = knots
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > 1e-12)
        .map(|pair| {
            // Two inner chords give the line, because the chord may jump at the knots themselves.
            let (low, high) = (pair[0], pair[1]);
            let (first, second) = (
                chord(low + (high - low) / 3.0),
                chord(low + (high - low) * 2.0 / 3.0),
            );
            Ramp {
                low,
                high,
                at_low: 2.0 * first - second,
                at_high: 2.0 * second - first,
            }
        })
        .collect();
    let total: f64 = ramps.iter().map(Ramp::mass).sum();
    for ramp in &mut ramps {
        ramp.at_low /= total;
        ramp.at_high /= total;
    }
    ramps
}

#[cfg(test)]
mod tests {
    use super::*;

    include!("../../../../tests/eta.rs");

    /// Returns the mean eta of the cubes of a cell.
    fn eta(theta_deg: f64, phi_deg: f64, pair: bool) -> f64 {
        let cubes = shifts(theta_deg.to_radians(), phi_deg.to_radians(), 1.0, pair);
        cubes.iter().map(|cube| cube.retroreflected).sum::<f64>() / cubes.len() as f64
    }

    #[test]
    fn retroreflected_fraction_of_the_hollow_cube() {
        let (mut lit, mut dark) = (0, 0);
        let known = known_eta("cube").into_iter();
        for (theta, phi, expected) in known.filter(|row| !row.1.is_nan()) {
            let found = eta(theta, phi, false);
            // The tolerance is half a unit of the last digit.
            let off = (found - expected).abs();
            assert!(
                off < 5.1e-6,
                "({theta}, {phi}): {found} instead of {expected}"
            );
            if expected == 0.0 {
                assert_eq!(found, 0.0, "({theta}, {phi})");
                dark += 1;
            } else {
                lit += 1;
            }
        }
        assert_eq!((lit, dark), (9, 5));
    }

    #[test]
    fn the_pair_is_the_mean_of_its_cubes() {
        for theta in [0.0, 12.0, 31.0, 44.0] {
            for phi in [0.0, 17.0, 30.0] {
                let mean = 0.5 * (eta(theta, phi, false) + eta(theta, phi + 180.0, false));
                assert!((eta(theta, phi, true) - mean).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn marginals_have_the_moments_of_the_polygon() {
        for (theta, phi) in [(0.0_f64, 0.0_f64), (20.0, 13.0), (33.0, 60.0)] {
            let cube = &shifts(theta.to_radians(), phi.to_radians(), 1.0, false)[0];
            for angle in [0.0_f64, 5.0, 30.0, 90.0, 97.0] {
                let along = [angle.to_radians().cos(), angle.to_radians().sin()];
                let ramps = marginal(&cube.polygon, along);
                let mass: f64 = ramps.iter().map(Ramp::mass).sum();
                assert!((mass - 1.0).abs() < 1e-12, "mass {mass}");
                // Variance of a uniform polygon along a direction, by triangles about the origin.
                // The polygon is symmetric, so its mean is 0, and each triangle (0, p, q) gives
                // area (p^2 + p q + q^2) / 6.
                let turned: Vec<f64> = cube
                    .polygon
                    .iter()
                    .map(|p| along[0] * p[0] + along[1] * p[1])
                    .collect();
                let mut variance = 0.0;
                for k in 0..turned.len() {
                    let next = (k + 1) % turned.len();
                    let triangle = area(&[[0.0, 0.0], cube.polygon[k], cube.polygon[next]]);
                    let (p, q) = (turned[k], turned[next]);
                    variance += triangle * (p * p + p * q + q * q) / 6.0;
                }
                variance /= area(&cube.polygon);
                // Far to the right the second integral P2 is t. The variance is the integral of 2
                // (P2(t) - max(t, 0)) over t, here by fine trapezoids.
                let (steps, reach) = (40_000, 2.0);
                let step = 2.0 * reach / f64::from(steps);
                let found: f64 = (0..=steps)
                    .map(|k| {
                        let t = -reach + step * f64::from(k);
                        2.0 * (ramps
                            .iter()
                            .map(|ramp| ramp.twice_integrated(t))
                            .sum::<f64>()
                            - t.max(0.0))
                            * step
                    })
                    .sum();
                // The trapezoid at the kink of max(t, 0) is exact if the kink is a node; otherwise
                // its error is below step^2.
                assert!(
                    (found - variance).abs() < step * step,
                    "({theta}, {phi}) at {angle}: {found} {variance}"
                );
            }
        }
    }
}
