//! Paths of an exact table as functions of the direction, from which the page computes polygons.
//!
//! The blur of kernel `shift` ends at a sharp rim, which moves with the direction. No mixture of
//! its transforms at a few directions follows the rim. Its polygons do: the lines of their edges
//! are affine in tau = tan(incidence inside) (cos azimuth, sin azimuth), up to the second order in
//! the spacing of the table. So the page gets these affine functions for each gap between
//! neighbouring directions of the table, and intersects the half-planes itself.

use serde::Serialize;
use tables::{Family, Table, polygon};

use crate::explore::stencil::{Ends, Nodes};

/// Gaps between the directions of a table, each with its paths.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Gaps {
    /// Incidences of the table, degrees.
    incidence: Vec<f64>,
    /// Azimuths of the table and their images, degrees, over the sector that the page folds to.
    azimuth: Vec<f64>,
    /// Refractive index of the sheet.
    index: f64,
    /// Area of the entrance, square edge lengths.
    entrance: f64,
    /// Greatest move of a corner for each unit of tau, edge lengths.
    fastest: f64,
    /// Paths of each gap, `[incidence, azimuth]`.
    paths: Vec<Vec<Course>>,
}

/// Number within a gap: one value if it is constant; three if it is affine in tau, which are the
/// value in the middle and the slopes; otherwise the values at [`ALONG`] evenly spaced incidences
/// and azimuths, `[incidence, azimuth]`.
type Varying = Vec<f64>;

/// Incidences, and azimuths, of a gap at which its paths are evaluated.
const ALONG: usize = 5;

/// Directions of a gap at which its paths are evaluated.
const PLACES: usize = ALONG * ALONG;

/// One path within a gap.
#[derive(Debug, Clone, Serialize)]
struct Course {
    /// Least and greatest coordinates of the corners at the table's directions.
    bounds: [[f64; 2]; 2],
    /// Corners of the gap that have the path, as (greater incidence, greater azimuth).
    there: Vec<[f64; 2]>,
    /// Corners of the gap that lack the path by a jump.
    jumps: Vec<[f64; 2]>,
    /// Lines: normal and offset. The polygon is where normal . p is at most the offset; p is
    /// relative to the fixed point of the map.
    lines: Vec<[Varying; 3]>,
    /// Map of a point to its shift, row-major; then how light is astray, and the weight.
    map: [Varying; 7],
}

/// Light of one path at one direction.
pub(crate) struct Patch {
    /// Corners of the shifts, (u, v), edge lengths.
    pub corners: Vec<[f64; 2]>,
    /// Share of the launched light.
    pub light: f64,
}

/// Text of the paths, at most, bytes.
const MOST_TEXT: usize = 3_000_000;

/// Area below which a polygon is nothing but rounding, square edge lengths.
const NO_AREA: f64 = 1e-12;

impl Gaps {
    /// Collects the paths of a table; `around` are the azimuths of the page.
    ///
    /// Returns `None` if the table has no polygons that can be interpolated everywhere, or if their
    /// paths are too many for a page.
    pub(crate) fn new(table: &Table, around: &Nodes) -> Option<Gaps> {
        let mut gaps = Gaps {
            incidence: table.axes.incidence_deg.clone(),
            azimuth: azimuths(table, around),
            index: table.provenance.refractive_index,
            entrance: table.exact.as_ref()?.entrance_area,
            fastest: Family::FASTEST,
            paths: Vec::new(),
        };
        for i in 0..count(&gaps.incidence) {
            for k in 0..count(&gaps.azimuth) {
                let [incidence, azimuth] = [ends(&gaps.incidence, i), ends(&gaps.azimuth, k)];
                let [middle, side] = [incidence, azimuth].map(|[a, b]| 0.5 * (a + b));
                let families = table.families(middle, side.rem_euclid(360.0))?;
                let places = places([incidence, azimuth]).map(|at| gaps.tau(at));
                let course = |family: &Family| Course::new(family, &places);
                gaps.paths.push(families.iter().map(course).collect());
            }
        }
        let text = serde_json::to_string(&gaps).map_or(usize::MAX, |text| text.len());
        (text <= MOST_TEXT).then_some(gaps)
    }

    /// Returns the light at a direction, in its incidence frame, by patches.
    ///
    /// `azimuth_deg` is within the sector. Light that is astray by a tangent is shifted by
    /// `per_tangent` times the tangent.
    pub(crate) fn patches(
        &self,
        [incidence_deg, azimuth_deg]: [f64; 2],
        per_tangent: [f64; 2],
    ) -> Vec<Patch> {
        let [(i, s), (k, t)] = [
            (&self.incidence, incidence_deg),
            (&self.azimuth, azimuth_deg),
        ]
        .map(bracket);
        let tau = self.tau([incidence_deg, azimuth_deg]);
        let gap = [ends(&self.incidence, i), ends(&self.azimuth, k)];
        let corners = corners(gap).map(|at| self.tau(at));
        let share = |[a, b]: [f64; 2]| part(a, s) * part(b, t);
        let at = Place {
            tau,
            shares: [s, t],
            beyond: beyond(&corners, tau),
            corners,
            azimuth_rad: azimuth_deg.to_radians(),
            index: self.index,
            per_tangent,
        };
        let own = &self.paths[i * count(&self.azimuth) + k];
        let patch = |course: &Course| {
            let absent: f64 = course.jumps.iter().map(|&corner| share(corner)).sum();
            let (corners, light) = course.patch(&at, 1.0 - absent)?;
            let light = light / self.entrance;
            Some(Patch { corners, light })
        };
        own.iter().filter_map(patch).collect()
    }

    /// Returns tau of a direction.
    fn tau(&self, [incidence_deg, azimuth_deg]: [f64; 2]) -> [f64; 2] {
        let sine = incidence_deg.to_radians().sin() / self.index;
        let tangent = sine / (1.0 - sine * sine).sqrt();
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        [tangent * cos, tangent * sin]
    }
}

/// Direction at which the paths of a gap are evaluated.
struct Place {
    tau: [f64; 2],
    /// Place between the ends of incidence and azimuth, from 0 to 1.
    shares: [f64; 2],
    /// tau beyond the middle of the gap.
    beyond: [f64; 2],
    /// tau of the corners of the gap.
    corners: [[f64; 2]; 4],
    azimuth_rad: f64,
    index: f64,
    per_tangent: [f64; 2],
}

/// Greatest error of a number that is taken as constant or affine: edge lengths, parts of a map or
/// of a weight. It moves a rim by less than a hundredth of a pixel that is as wide as 0.01 edges.
const CLOSE: f64 = 1e-4;

/// Greatest error of light that is astray and taken as constant or affine, rad. It is multiplied by
/// the distance in edge lengths.
const CLOSE_ASTRAY: f64 = 1e-9;

impl Course {
    fn new(family: &Family, places: &[[f64; 2]; PLACES]) -> Course {
        let last = (ALONG - 1) as f64;
        let corners = CORNERS.map(|[a, b]| places[(last * (a * ALONG as f64 + b)) as usize]);
        let shares = fit(&places.map(|tau| beyond(&corners, tau)));
        let values = places.map(|tau| family.at(tau));
        let varying = |close: f64, value: &dyn Fn(usize) -> f64| {
            let all = std::array::from_fn(value);
            varying(
                all,
                close,
                &shares,
                &places.map(|tau| beyond(&corners, tau)),
            )
        };
        let has = |tau: [f64; 2]| family.members.iter().any(|(own, _)| near(*own, tau));
        let there = CORNERS.into_iter().zip(corners);
        Course {
            bounds: family.bounds,
            there: there
                .filter(|(_, tau)| has(*tau))
                .map(|own| own.0)
                .collect(),
            jumps: family.jumps.clone(),
            lines: (0..family.lines.len())
                .map(|line| [0, 1, 2].map(|part| varying(CLOSE, &|k| values[k].0[line][part])))
                .collect(),
            map: [0, 1, 2, 3, 4, 5, 6].map(|part| {
                let close = if part == 4 || part == 5 {
                    CLOSE_ASTRAY
                } else {
                    CLOSE
                };
                varying(close, &|k| values[k].1[part])
            }),
        }
    }

    /// Returns the corners of the shifts, and weight times area, or `None` if nothing is left.
    fn patch(&self, at: &Place, present: f64) -> Option<(Vec<[f64; 2]>, f64)> {
        let value = |own: &Varying| evaluated(own, at);
        // Lines that hardly turn from each other can meet far away, after the path has ended.
        let moved = self.there.iter().map(|&[a, b]| {
            let corner = at.corners[(2.0 * a + b) as usize];
            Family::FASTEST * (corner[0] - at.tau[0]).hypot(corner[1] - at.tau[1])
        });
        let margin = moved.fold(f64::INFINITY, f64::min) + 1e-6;
        let [[left, low], [right, high]] = self.bounds;
        let ([left, low], [right, high]) = (
            [left - margin, low - margin],
            [right + margin, high + margin],
        );
        let mut corners = vec![[left, low], [right, low], [right, high], [left, high]];
        for line in &self.lines {
            let [x, y, offset] = line.each_ref().map(value);
            let on =
                |p: [f64; 2], q: [f64; 2], part: f64| [0, 1].map(|k| p[k] + part * (q[k] - p[k]));
            corners = polygon::clip(&corners, |p| x * p[0] + y * p[1] - offset, on);
        }
        let [uu, uv, vu, vv, x, y, weight] = self.map.each_ref().map(value);
        let area = polygon::area(&corners);
        let light = weight.clamp(0.0, 1.0) * present.max(0.0) * area;
        if area <= NO_AREA || light <= 0.0 {
            return None;
        }
        let (sin, cos) = at.azimuth_rad.sin_cos();
        let turned = |[x, y]: [f64; 2]| [cos * x + sin * y, cos * y - sin * x];
        let astray = Family::deviation(turned([x, y]), at.tau, at.index);
        let shift = |&[x, y]: &[f64; 2]| {
            let own = turned([uu * x + uv * y, vu * x + vv * y]);
            [0, 1].map(|k| own[k] + at.per_tangent[k] * astray[k])
        };
        Some((corners.iter().map(shift).collect(), light))
    }
}

/// Corners of a gap as (greater incidence, greater azimuth).
const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];

/// Returns the directions of the corners of a gap, in the order of [`CORNERS`].
fn corners([incidence, azimuth]: [[f64; 2]; 2]) -> [[f64; 2]; 4] {
    CORNERS.map(|[a, b]| [incidence[a as usize], azimuth[b as usize]])
}

/// Returns the middle of the corners of a gap.
fn middle(corners: &[[f64; 2]; 4]) -> [f64; 2] {
    [0, 1].map(|k| 0.25 * corners.iter().map(|corner| corner[k]).sum::<f64>())
}

/// Returns tau relative to the middle of a gap.
fn beyond(corners: &[[f64; 2]; 4], tau: [f64; 2]) -> [f64; 2] {
    let middle = middle(corners);
    [tau[0] - middle[0], tau[1] - middle[1]]
}

/// Returns the directions at which the paths of a gap are evaluated.
fn places(ends: [[f64; 2]; 2]) -> [[f64; 2]; PLACES] {
    std::array::from_fn(|place| {
        let steps = [place / ALONG, place % ALONG].map(|step| step as f64 / (ALONG - 1) as f64);
        [0, 1].map(|k| ends[k][0] + steps[k] * (ends[k][1] - ends[k][0]))
    })
}

/// Returns a number with these values in the shortest form that is close to all of them.
fn varying(
    all: [f64; PLACES],
    close: f64,
    shares: &[[f64; PLACES]; 3],
    beyond: &[[f64; 2]; PLACES],
) -> Varying {
    // The page keeps digits that are far finer than what counts as close.
    let per_unit = (1e3 / close).round();
    let rounded = |value: f64| (value * per_unit).round() / per_unit;
    let part = |share: &[f64; PLACES]| -> f64 {
        share.iter().zip(all).map(|(share, own)| share * own).sum()
    };
    let [middle, x, y] = shares.each_ref().map(part);
    let pairs = || all.iter().zip(beyond);
    if pairs().all(|(own, _)| (own - all[PLACES / 2]).abs() <= close * 0.01) {
        return vec![rounded(all[PLACES / 2])];
    }
    if pairs().all(|(own, at)| (own - middle - x * at[0] - y * at[1]).abs() <= close) {
        return [middle, x, y].map(rounded).to_vec();
    }
    all.map(rounded).to_vec()
}

/// Returns a number at a direction.
fn evaluated(own: &Varying, at: &Place) -> f64 {
    match own[..] {
        [one] => one,
        [middle, x, y] => middle + x * at.beyond[0] + y * at.beyond[1],
        _ => {
            let [along, around] = at.shares.map(through);
            let rows = own.chunks_exact(ALONG).map(|row| dot(row, &around));
            dot(&rows.collect::<Vec<_>>(), &along)
        }
    }
}

/// Returns the shares of [`ALONG`] evenly spaced values in the polynomial through them; `t` runs
/// from 0 to 1.
fn through(t: f64) -> [f64; ALONG] {
    let x = t * (ALONG - 1) as f64;
    std::array::from_fn(|own| {
        let others = (0..ALONG).filter(|&other| other != own);
        let factor = |other: usize| (x - other as f64) / (own as f64 - other as f64);
        others.map(factor).product()
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns the shares of values in the affine function that fits them best: in its value at the
/// origin, and in its slopes. Slopes that nothing determines are 0.
fn fit(places: &[[f64; 2]; PLACES]) -> [[f64; PLACES]; 3] {
    let sum = |value: &dyn Fn([f64; 2]) -> f64| places.iter().map(|&at| value(at)).sum::<f64>();
    let mean = [0, 1].map(|k| sum(&|at| at[k]) / PLACES as f64);
    let [xx, xy, yy] =
        [[0, 0], [0, 1], [1, 1]].map(|[i, k]| sum(&|at| (at[i] - mean[i]) * (at[k] - mean[k])));
    // A gap along a line determines the slope along it only; a single direction determines none.
    let ridge = 1e-9 * (xx + yy) + f64::MIN_POSITIVE;
    let determinant = (xx + ridge) * (yy + ridge) - xy * xy;
    let slopes = places.map(|at| {
        let [x, y] = [at[0] - mean[0], at[1] - mean[1]];
        let along = [(yy + ridge) * x - xy * y, (xx + ridge) * y - xy * x];
        along.map(|own| {
            if determinant > 0.0 {
                own / determinant
            } else {
                0.0
            }
        })
    });
    [
        slopes.map(|[x, y]| 1.0 / PLACES as f64 - mean[0] * x - mean[1] * y),
        slopes.map(|slope| slope[0]),
        slopes.map(|slope| slope[1]),
    ]
}

/// Returns whether two directions are the same but for rounding.
fn near(a: [f64; 2], b: [f64; 2]) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9
}

/// Returns the azimuths of a table around the sector of the page: from the last one at or before
/// its first azimuth to the first one at or after its last.
pub(crate) fn azimuths(table: &Table, around: &Nodes) -> Vec<f64> {
    if around.ends == Ends::Open {
        return table.axes.azimuth_deg.clone();
    }
    let [first, last] = [around.first, around.first + around.width()];
    let known = table.azimuths();
    let all: Vec<f64> = (-2..=2)
        .flat_map(|turn| known.iter().map(move |own| own.0 + 360.0 * f64::from(turn)))
        .collect();
    let before = all.iter().filter(|&&own| own <= first + 1e-9);
    let after = all.iter().filter(|&&own| own >= last - 1e-9);
    let start = before.copied().fold(f64::NEG_INFINITY, f64::max);
    let end = after.copied().fold(f64::INFINITY, f64::min);
    all.into_iter()
        .filter(|own| (start..=end).contains(own))
        .collect()
}

/// Returns the number of gaps of an axis; a single angle is a gap without width.
fn count(axis: &[f64]) -> usize {
    (axis.len() - 1).max(1)
}

/// Returns the ends of a gap.
fn ends(axis: &[f64], gap: usize) -> [f64; 2] {
    [axis[gap], axis[(gap + 1).min(axis.len() - 1)]]
}

/// Returns the gap that holds an angle, and its place there, from 0 to 1.
fn bracket((axis, angle): (&Vec<f64>, f64)) -> (usize, f64) {
    let after = axis.partition_point(|&own| own <= angle);
    let gap = after.saturating_sub(1).min(count(axis) - 1);
    let [low, high] = ends(axis, gap);
    let place = if high > low {
        (angle - low) / (high - low)
    } else {
        0.0
    };
    (gap, place.clamp(0.0, 1.0))
}

/// Returns the share of one end of a gap.
fn part(far: f64, place: f64) -> f64 {
    if far > 0.0 { place } else { 1.0 - place }
}
