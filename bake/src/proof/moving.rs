//! Lines that move with the direction of the light, and the areas that they can leave.
//!
//! Let tau = tan(incidence inside) (cos azimuth, sin azimuth). A patch is a parallelogram of tau:
//! tau = centre + s first + t second, with s and t in [-1, 1].

use glam::DVec2;

use crate::geometry::{HalfPlane, Polygon, polygon};

/// Directions of light that are looked at together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch {
    pub centre: DVec2,
    pub first: DVec2,
    pub second: DVec2,
    /// Unit vector along the azimuth in the middle.
    pub axis: DVec2,
    /// Greatest turn of the azimuth from there, rad.
    pub turn: f64,
}

/// Number of slices of a strip between two lines.
const SLICES: u32 = 8;

/// Multiple of the area of points that a strip must be below to be worth slices.
const WORTH: f64 = 4.0;

/// Corners of (s, t).
pub(crate) const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

impl Patch {
    /// Returns the patch around all directions between two incidences and two azimuths, degrees.
    ///
    /// Along the azimuth in the middle, the arcs lie between the chord of the inner one and the
    /// crown of the outer one. Across it they reach as far as the end of the outer one. Gaps of
    /// azimuth are less than half a turn.
    pub(crate) fn around(incidence_deg: [f64; 2], azimuth_deg: [f64; 2], index: f64) -> Patch {
        let radius = incidence_deg.map(|incidence| {
            let sine = incidence.to_radians().sin() / index;
            sine / (1.0 - sine * sine).sqrt()
        });
        let [from, to] = azimuth_deg.map(f64::to_radians);
        let half = 0.5 * (to - from);
        let axis = DVec2::from_angle(0.5 * (from + to));
        let (near, far) = (radius[0] * half.cos(), radius[1]);
        Patch {
            centre: 0.5 * (near + far) * axis,
            first: 0.5 * (far - near) * axis,
            second: radius[1] * half.sin() * axis.perp(),
            axis,
            turn: half,
        }
    }

    /// Returns the greatest and the least distance of `tau` from the directions of the patch; the
    /// least one may be too small.
    pub(crate) fn distances(&self, tau: DVec2) -> (f64, f64) {
        let far =
            CORNERS.map(|[s, t]| tau.distance(self.centre + s * self.first + t * self.second));
        // The axes are at right angles, so each tells how far `tau` is beyond the patch.
        let beyond = [self.first, self.second].map(|axis| {
            let half = axis.length();
            let along = (tau - self.centre).dot(axis) / half.max(f64::MIN_POSITIVE);
            (along.abs() - half).max(0.0)
        });
        let flat = [self.first, self.second]
            .iter()
            .any(|axis| axis.length() == 0.0);
        let near = if flat {
            // The distance to a segment or a point.
            let whole = if self.first.length() > 0.0 {
                self.first
            } else {
                self.second
            };
            let part = (tau - self.centre).dot(whole) / whole.length_squared().max(1e-300);
            tau.distance(self.centre + part.clamp(-1.0, 1.0) * whole)
        } else {
            beyond[0].hypot(beyond[1])
        };
        (far.into_iter().fold(0.0, f64::max), near)
    }
}

/// Number that is affine in (s, t): its value in the middle, and its changes with s and t.
pub(crate) type Affine = [f64; 3];

/// Returns the greatest magnitude of an affine number.
pub(crate) fn most(value: Affine) -> f64 {
    value[0].abs() + value[1].abs() + value[2].abs()
}

/// Half-plane that moves: offset + normal . x <= error, with both affine in (s, t).
///
/// The true half-plane lies somewhere within the error: its function is off by at most that.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moving {
    pub offset: Affine,
    pub normal: [DVec2; 3],
    pub error: f64,
}

impl Moving {
    /// Returns the half-plane on the other side.
    pub(crate) fn beyond(&self) -> Moving {
        Moving {
            offset: self.offset.map(|x| -x),
            normal: self.normal.map(|x| -x),
            error: self.error,
        }
    }

    /// Returns the half-plane moved by `step`.
    pub(crate) fn moved(&self, step: DVec2) -> Moving {
        Moving {
            offset: [0, 1, 2].map(|k| self.offset[k] - self.normal[k].dot(step)),
            ..*self
        }
    }

    /// Returns how the function changes at `x` with s and with t.
    fn change(&self, x: DVec2) -> [f64; 2] {
        [1, 2].map(|k| self.offset[k] + self.normal[k].dot(x))
    }

    /// Returns a half-plane that holds all points of `polygon` that are in this one for some
    /// direction of the patch.
    ///
    /// The changes are affine in x, so their magnitudes are greatest in corners.
    fn ever(&self, polygon: &[DVec2]) -> HalfPlane {
        let most = polygon.iter().fold([0.0_f64; 2], |[a, b], &x| {
            let [s, t] = self.change(x);
            [a.max(s.abs()), b.max(t.abs())]
        });
        HalfPlane {
            gradient: self.normal[0],
            anchor: DVec2::ZERO,
            constant: self.offset[0] - self.error - most[0] - most[1],
        }
    }

    /// Returns a half-plane all of whose points in `polygon` are in this one for every direction of
    /// the patch.
    fn always(&self, polygon: &[DVec2]) -> HalfPlane {
        let ever = self.ever(polygon);
        HalfPlane {
            constant: 2.0 * self.offset[0] - ever.constant,
            ..ever
        }
    }

    /// Returns the half-plane in the middle of the patch, without error.
    fn middle(&self) -> HalfPlane {
        HalfPlane {
            gradient: self.normal[0],
            anchor: DVec2::ZERO,
            constant: self.offset[0],
        }
    }
}

/// Returns a polygon that holds all points of `start` that are in all `lines` for one direction of
/// the patch.
pub(crate) fn ever<'a>(start: &[DVec2], lines: impl IntoIterator<Item = &'a Moving>) -> Polygon {
    cut(start, lines, Moving::ever)
}

/// Returns points of `start` that are in all `lines` for every direction of the patch.
pub(crate) fn always(start: &[DVec2], lines: &[Moving]) -> Polygon {
    cut(start, lines, Moving::always)
}

/// Returns the points of `start` that are in all `lines` in the middle of the patch, without error.
pub(crate) fn middle<'a>(start: &[DVec2], lines: impl IntoIterator<Item = &'a Moving>) -> Polygon {
    cut(start, lines, |line, _| line.middle())
}

/// Cuts `start` by the half-plane that each line has for what is left.
fn cut<'a>(
    start: &[DVec2],
    lines: impl IntoIterator<Item = &'a Moving>,
    plane: impl Fn(&Moving, &[DVec2]) -> HalfPlane,
) -> Polygon {
    let mut kept = start.to_vec();
    for line in lines {
        if kept.is_empty() {
            break;
        }
        let plane = plane(line, &kept);
        // Most lines cut nothing off.
        if kept.iter().any(|&x| plane.value(x) > 0.0) {
            kept = polygon::clip(&kept, [plane]);
        }
    }
    kept
}

/// Returns a bound of the area in `first` and `second` together, in every direction of the patch;
/// `within` holds all of it.
///
/// The area of all points that are ever in both is a bound. Where a line of the one and a line of
/// the other run against each other, there is a better one: both move with the light, but not
/// against each other. Let f and g be their functions, scaled so that the normals cancel in the
/// middle. In both half-planes f <= e and g <= e', so f >= min(f + g) - e', the least over the
/// points and directions. (The sum is affine in each of x, s and t, so it is least in corners.) The
/// points lie in a strip across f, whose width is that range of f over the least gradient, and
/// whose length is the extent of the points along it.
pub(crate) fn overlap(within: &[DVec2], first: &[Moving], second: &[Moving]) -> f64 {
    overlap_facing(within, first, second, &[])
}

/// Two lines that run against each other and whose sum is known better than both.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facing {
    /// One of the lines.
    pub line: Moving,
    /// Greatest error of its normal.
    pub loose: f64,
    /// Sum of the functions of both lines.
    pub sum: Moving,
}

/// Returns a bound as [`overlap`] does, where lines of the two are known to be `facing`.
pub(crate) fn overlap_facing(
    within: &[DVec2],
    first: &[Moving],
    second: &[Moving],
    facing: &[Facing],
) -> f64 {
    // Few lines usually cut off more than many, which then have less to do.
    let points = if first.len() <= second.len() {
        ever(within, first.iter().chain(second))
    } else {
        ever(within, second.iter().chain(first))
    };
    let area = polygon::area(&points);
    if area <= 0.0 {
        return 0.0;
    }
    let pairs = first
        .iter()
        .flat_map(|f| second.iter().map(move |g| (f, g)));
    let pairs = pairs.filter_map(|(f, g)| Facing::of(f, g));
    let strips = facing.iter().copied().chain(pairs);
    let strips = strips.filter_map(|facing| Some((strip(&points, &facing)?, facing)));
    let best = strips.min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((strip, facing)) = best.filter(|(strip, _)| *strip < WORTH * area) else {
        return area;
    };
    sliced(&points, &facing).min(strip).min(area)
}

impl Facing {
    /// Returns two lines that run against each other, scaled so that their normals cancel in the
    /// middle, or `None` if they do not.
    fn of(f: &Moving, g: &Moving) -> Option<Facing> {
        let (a, b) = (f.normal[0].length(), g.normal[0].length());
        if f.normal[0].dot(g.normal[0]) > -0.8 * a * b || a == 0.0 || b == 0.0 {
            return None;
        }
        let sum = |p: f64, q: f64| p + a / b * q;
        Some(Facing {
            line: *f,
            loose: 0.0,
            sum: Moving {
                offset: [0, 1, 2].map(|k| sum(f.offset[k], g.offset[k])),
                normal: [0, 1, 2].map(|k| f.normal[k] + a / b * g.normal[k]),
                error: sum(f.error, g.error),
            },
        })
    }

    /// Returns the other sides of both lines.
    pub(crate) fn beyond(&self) -> Facing {
        Facing {
            line: self.line.beyond(),
            loose: self.loose,
            sum: self.sum.beyond(),
        }
    }
}

/// Returns a bound of the area of `points` between two lines that face each other; it is infinite
/// if the lines turn too much.
///
/// The bound of [`strip`] holds for the points of each slice across the lines, with the least of
/// the sum in that slice. The strip is wide in few of them, so their sum is less.
fn sliced(points: &[DVec2], facing: &Facing) -> f64 {
    let along = facing.line.normal[0].normalize_or_zero().perp();
    let places = || points.iter().map(|x| x.dot(along));
    let from = places().fold(f64::INFINITY, f64::min);
    let to = places().fold(f64::NEG_INFINITY, f64::max);
    let end = |k: u32| from + f64::from(k) / f64::from(SLICES) * (to - from);
    let beyond = |place: f64, sign: f64| HalfPlane {
        gradient: sign * along,
        anchor: DVec2::ZERO,
        constant: -sign * place,
    };
    let slice = |k: u32| {
        let part = polygon::clip(points, [beyond(end(k), -1.0), beyond(end(k + 1), 1.0)]);
        if part.is_empty() {
            return 0.0;
        }
        let area = polygon::area(&part);
        strip(&part, facing).map_or(f64::INFINITY, |strip| strip.min(area))
    };
    (0..SLICES).map(slice).sum()
}

/// Returns a bound of the area of `points` between two lines that face each other, or `None` if
/// they turn too much.
fn strip(points: &[DVec2], facing: &Facing) -> Option<f64> {
    let (f, sum) = (&facing.line, &facing.sum);
    let steep = f.normal[0].length();
    // Turn of f, as a part of its gradient.
    let turn = (f.normal[1].length() + f.normal[2].length() + facing.loose) / steep;
    if turn.is_nan() || turn > 0.5 {
        return None;
    }
    let mut least = f64::INFINITY;
    for &x in points {
        let at = sum.offset[0] + sum.normal[0].dot(x);
        let [s, t] = sum.change(x);
        least = least.min(at - s.abs() - t.abs());
    }
    // What is not a number bounds nothing.
    if !(sum.error - least).is_finite() {
        return None;
    }
    let width = (sum.error - least).max(0.0) / (steep * (1.0 - turn));
    let across = f.normal[0] / steep;
    let extent = |axis: DVec2| {
        let along = || points.iter().map(|x| x.dot(axis));
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    Some(width * (extent(across.perp()) + extent(across) * turn / (1.0 - turn)))
}
