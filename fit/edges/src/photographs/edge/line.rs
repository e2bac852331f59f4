//! An edge in a window: its direction, its place, and the smooth curve that it follows.

use std::f64::consts::{PI, TAU};

/// Largest order of the polynomial that an edge may follow. A straight line has order 1.
pub const ORDERS: usize = 9;

/// An edge in a window.
///
/// The distance of a pixel is measured from the curve. It is the distance along the line's normal,
/// divided by the length of a step along the curve over that of its shadow on the line. For a bow
/// of 3 pixels over 200 this differs from the nearest distance by less than 1e-3 of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeLine {
    /// Direction of the normal, which points from dark to bright, from +x (right) towards +y
    /// (down); radians, in (-pi, pi].
    pub normal_rad: f64,
    /// Signed distance of the edge from the window's centre along the normal, pixels.
    pub offset_px: f64,
    /// Standard error of `normal_rad` by pixel noise, radians.
    pub normal_standard_error_rad: f64,
    /// Curve that the edge follows, relative to the line; `None` if the edge is straight.
    pub bend: Option<Bend>,
}

/// A curve relative to a line: a sum of Legendre polynomials of orders 2 to 9 in the place along
/// the line. Beyond its ends it goes on parallel to the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// Middle of the curve along the line, pixels.
    pub middle_px: f64,
    /// Half of its length along the line, pixels.
    pub half_px: f64,
    /// Coefficients of the orders 2, 3, ..., pixels; positive towards the bright side.
    pub terms_px: [f64; ORDERS - 1],
    /// Highest order that is used.
    pub order: usize,
}

/// Measures places relative to an edge.
pub struct Ruler {
    sin: f64,
    cos: f64,
    offset_px: f64,
    bend: Option<Powers>,
}

/// A curve relative to a line as sums of powers of the place along the line, which are faster than
/// Legendre polynomials. Of those up to order 9 the powers have coefficients of up to 201, which
/// leaves 3 of 16 digits fewer.
struct Powers {
    middle_px: f64,
    per_px: f64,
    /// Coefficients of the powers 0, 1, ... of the height, pixels, and of its slope.
    height_px: [f64; ORDERS + 1],
    slope: [f64; ORDERS],
}

impl EdgeLine {
    /// Turns the normal by less than a turn, radians.
    pub(crate) fn turn(&mut self, rad: f64) {
        self.normal_rad += rad;
        if self.normal_rad.abs() > PI {
            self.normal_rad -= TAU * self.normal_rad.signum();
        }
    }

    /// Returns whether the edge is tilted by 1 to 44 degrees from rows and columns.
    pub fn is_slanted(&self) -> bool {
        (1.0..=44.0).contains(&self.tilt_deg())
    }

    /// Returns the angle between the edge and the nearer of rows and columns, 0 to 45 degrees.
    pub fn tilt_deg(&self) -> f64 {
        let turn = self.normal_rad.to_degrees().rem_euclid(90.0);
        turn.min(90.0 - turn)
    }

    /// Returns a ruler for places relative to the edge.
    pub fn ruler(&self) -> Ruler {
        let (sin, cos) = self.normal_rad.sin_cos();
        Ruler {
            sin,
            cos,
            offset_px: self.offset_px,
            bend: self.bend.as_ref().map(Powers::of),
        }
    }

    /// Returns the height of the curve, from its lowest to its highest place off the line, pixels;
    /// 0 for a straight edge.
    pub fn bow_px(&self) -> f64 {
        let Some(bend) = self.bend else { return 0.0 };
        let at = |k: i32| {
            bend.at(bend.middle_px + bend.half_px * f64::from(k) / 50.0)
                .0
        };
        let heights = (-50..=50).map(at);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        high - low
    }
}

impl Bend {
    /// Returns the height of the curve over the line at a place along it, pixels, and its slope.
    pub fn at(&self, along_px: f64) -> (f64, f64) {
        let place = (along_px - self.middle_px) / self.half_px;
        let x = place.clamp(-1.0, 1.0);
        let (values, slopes) = legendre(x);
        let orders = 2..=self.order;
        let (mut height, mut slope) = (0.0, 0.0);
        for (term, k) in self.terms_px.iter().zip(orders) {
            height += term * values[k];
            slope += term * slopes[k];
        }
        (
            height,
            if x == place {
                slope / self.half_px
            } else {
                0.0
            },
        )
    }

    /// Returns the tangents of the orders 2, 3, ..., at a place along the line, for a coefficient of
    /// 1 pixel each: the height at which the tangent meets the middle of the line, pixels, and its
    /// slope. Those of orders that are not used are 0.
    pub fn tangents(&self, along_px: f64) -> [[f64; 2]; ORDERS - 1] {
        let place = (along_px - self.middle_px) / self.half_px;
        let x = place.clamp(-1.0, 1.0);
        let (values, slopes) = legendre(x);
        let per_px = if x == place { 1.0 / self.half_px } else { 0.0 };
        std::array::from_fn(|i| {
            if i + 2 > self.order {
                return [0.0; 2];
            }
            let slope = slopes[i + 2] * per_px;
            [values[i + 2] - slope * along_px, slope]
        })
    }
}

impl Ruler {
    /// Returns the distance of a position from the edge and the place along it, pixels. x and y
    /// count from the window's centre.
    pub fn place(&self, x: f64, y: f64) -> (f64, f64) {
        let across = x * self.cos + y * self.sin - self.offset_px;
        let along = y * self.cos - x * self.sin;
        match &self.bend {
            None => (across, along),
            Some(bend) => {
                let (height, slope) = bend.at(along);
                ((across - height) / (1.0 + slope * slope).sqrt(), along)
            }
        }
    }
}

impl Powers {
    fn of(bend: &Bend) -> Powers {
        let mut height_px = [0.0; ORDERS + 1];
        let (mut before, mut last) = ([0.0; ORDERS + 1], [0.0; ORDERS + 1]);
        (before[0], last[1]) = (1.0, 1.0);
        for (k, term) in (2..=bend.order).zip(bend.terms_px) {
            let n = k as f64;
            let next = std::array::from_fn(|i| {
                let raised = if i > 0 { last[i - 1] } else { 0.0 };
                ((2.0 * n - 1.0) * raised - (n - 1.0) * before[i]) / n
            });
            (before, last) = (last, next);
            for (sum, power) in height_px.iter_mut().zip(last) {
                *sum += term * power;
            }
        }
        let per_px = bend.half_px.recip();
        Powers {
            middle_px: bend.middle_px,
            per_px,
            height_px,
            slope: std::array::from_fn(|i| (i + 1) as f64 * height_px[i + 1] * per_px),
        }
    }

    /// Does what [`Bend::at`] does.
    fn at(&self, along_px: f64) -> (f64, f64) {
        let place = (along_px - self.middle_px) * self.per_px;
        let x = place.clamp(-1.0, 1.0);
        let sum = |powers: &[f64]| powers.iter().rev().fold(0.0, |sum, power| sum * x + power);
        let slope = if x == place { sum(&self.slope) } else { 0.0 };
        (sum(&self.height_px), slope)
    }
}

/// Returns the Legendre polynomials of orders 0 to 9 at `x`, and their derivatives.
pub(crate) fn legendre(x: f64) -> ([f64; ORDERS + 1], [f64; ORDERS + 1]) {
    let (mut value, mut slope) = ([0.0; ORDERS + 1], [0.0; ORDERS + 1]);
    (value[0], value[1], slope[1]) = (1.0, x, 1.0);
    for k in 1..ORDERS {
        let n = k as f64;
        value[k + 1] = ((2.0 * n + 1.0) * x * value[k] - n * value[k - 1]) / (n + 1.0);
        slope[k + 1] = slope[k - 1] + (2.0 * n + 1.0) * value[k];
    }
    (value, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the distance from a curve against the nearest of many points on the same curve. The
    /// bow is 3 px over 200 px, so the curve turns by 0.12 rad and has a radius of 1,700 px. Within
    /// 20 px of it the distance errs by the turn of the normal over the shift of the foot, 20 px x
    /// 0.06, which is 20^2 x 0.06^2 / (2 x 1700) = 4e-4 px; the points are 0.01 px apart.
    #[test]
    fn distances_are_those_from_the_curve() {
        let mut terms_px = [0.0; ORDERS - 1];
        terms_px[0] = 2.0;
        let bend = Bend {
            middle_px: 3.0,
            half_px: 100.0,
            terms_px,
            order: 2,
        };
        let line = EdgeLine {
            normal_rad: 0.1,
            offset_px: 1.5,
            normal_standard_error_rad: 0.0,
            bend: Some(bend),
        };
        assert!((line.bow_px() - 3.0).abs() < 1e-12);
        let (sin, cos) = 0.1_f64.sin_cos();
        let mut cases = 0;
        for across in [-20.0, -3.0, 0.5, 8.0, 20.0] {
            for along in [-80.0, -31.0, 0.0, 44.0, 90.0] {
                let (x, y) = (across * cos - along * sin, across * sin + along * cos);
                let nearest = (-12_000..=12_000)
                    .map(|k| f64::from(k) * 0.01)
                    .map(|t| (across - 1.5 - bend.at(t).0).hypot(along - t))
                    .fold(f64::INFINITY, f64::min);
                let (found, _) = line.ruler().place(x, y);
                assert!(
                    (found.abs() - nearest).abs() < 5e-4 + 1e-5,
                    "{across} {along}: {found} {nearest}"
                );
                cases += 1;
            }
        }
        assert_eq!(cases, 25);
    }

    /// Compares powers with Legendre polynomials, along the curve and beyond its ends. The
    /// coefficients of the powers of order 9 have a sum of 476, those of its slope one of 3,077, and
    /// each term is rounded a dozen times.
    #[test]
    fn powers_are_the_polynomials() {
        let mut cases = 0;
        for order in 2..=ORDERS {
            let bend = Bend {
                middle_px: -4.0,
                half_px: 60.0,
                terms_px: std::array::from_fn(|i| (1.7 * i as f64 + 0.4).sin()),
                order,
            };
            let powers = Powers::of(&bend);
            for along in [-90.0, -64.0, -50.3, -4.0, 17.7, 55.9, 56.0, 70.0] {
                let (found, expected) = (powers.at(along), bend.at(along));
                let rounding = 8.0 * 12.0 * f64::EPSILON;
                assert!(
                    (found.0 - expected.0).abs() < 476.0 * rounding,
                    "{order} {along}"
                );
                let limit = 3077.0 / bend.half_px * rounding;
                assert!((found.1 - expected.1).abs() < limit, "{order} {along}");
                cases += 1;
            }
        }
        assert_eq!(cases, 8 * 8);
    }

    /// Checks heights and slopes of the tangents against those of a curve with one term of 1 px:
    /// both are the same sums, so they agree to rounding. Beyond its ends the curve is parallel to
    /// the line.
    #[test]
    fn tangents_touch_the_curve() {
        let mut cases = 0;
        for order in 2..=ORDERS {
            let mut terms_px = [0.0; ORDERS - 1];
            terms_px[order - 2] = 1.0;
            let bend = Bend {
                middle_px: -4.0,
                half_px: 60.0,
                terms_px,
                order,
            };
            for along in [-80.0, -50.0, 3.0, 41.0] {
                let (height, slope) = bend.at(along);
                let [origin, own] = bend.tangents(along)[order - 2];
                assert!((own - slope).abs() < 1e-14, "{order} {along}");
                assert!((origin + own * along - height).abs() < 1e-13);
                cases += 1;
            }
        }
        assert_eq!(cases, 32);
    }

    /// Checks the polynomials of orders 2, 3 and 9 against their values in tables, and the slopes
    /// against central differences (error h^2/6 of a third derivative below 2e4).
    #[test]
    fn polynomials_are_those_of_legendre() {
        let (values, _) = legendre(0.3);
        assert!((values[2] + 0.365).abs() < 1e-15 && (values[3] + 0.3825).abs() < 1e-15);
        assert!(
            (legendre(1.0).0[9] - 1.0).abs() < 1e-14 && (legendre(1.0).1[9] - 45.0).abs() < 1e-12
        );
        let h = 1e-5;
        let mut cases = 0;
        for x in [-0.9, -0.2, 0.55, 0.97] {
            let ((high, _), (low, _)) = (legendre(x + h), legendre(x - h));
            for k in 0..=ORDERS {
                let slope = (high[k] - low[k]) / (2.0 * h);
                assert!((slope - legendre(x).1[k]).abs() < 1e-6, "{k} {x}");
                cases += 1;
            }
        }
        assert_eq!(cases, 40);
    }
}
