//! The exact bake: beam tracing instead of samples.
//!
//! The method follows Heckbert and Hanrahan, "Beam Tracing Polygonal Objects", SIGGRAPH 1984. On
//! planar facets a collimated beam is piecewise affine: every sequence of facets maps one polygon
//! of the entrance plane by one affine map. So the whole distribution of ray shifts is a finite set
//! of polygons, and the probability of a bin is an area. This bake differs from the article in
//! three points:
//!
//! - All light of a direction is parallel and stays parallel. So facets are unfolded into the
//!   entrance plane, and the whole problem is two-dimensional.
//! - Cells may be periodic.
//! - Of many equal cubes one is followed.
//!
//! Losses are a weight. All light of a facet sequence meets each facet at one angle. So one
//! polarised path (`light`) gives the share of its power that is retroreflected; the rest goes to
//! the fates that took it.
//!
//! Accuracy: areas and shifts are known to a few ulp of the longest path in the cell, 1e-15 /
//! cos(incidence) edge lengths. Facets mirror on the side from which their corners run
//! counter-clockwise. Light ends at their backs, which only a lattice with gaps shows.

use crate::beams::view::View;
use crate::beams::{beam, bins, mean, paths};
use crate::cell::{ExactCell, MEAN_ERROR, Prepared};
use crate::geometry::{HalfPlane, Polygon, polygon};
use crate::optics::{Incidence, Rules};
use glam::{DMat2, DVec2};
use ndarray::{Array2, Array3, Array4};
use rayon::prelude::*;
use tables::{Axes, Exact, Fate, Path, Provenance, Table};

impl ExactCell {
    /// Traces one direction, given by its angles in degrees outside the front face, cell frame.
    ///
    /// The histogram has `bins` x `bins` bins over [-range, range] edge lengths.
    pub(crate) fn direction(
        &self,
        incidence_deg: f64,
        azimuth_deg: f64,
        bins: usize,
        range: f64,
        rules: &Rules,
    ) -> Share {
        let (incidence_rad, azimuth_rad) = (incidence_deg.to_radians(), azimuth_deg.to_radians());
        let light = Incidence::new(incidence_rad, azimuth_rad, rules.refractive_index);
        let mut filled = bins::Histogram::new(bins, range);
        let mut paths = Vec::new();
        let mut fate = [0.0; Fate::ALL.len()];
        let (mut eta, mut dropped) = (0.0, 0.0);
        for body in &self.bodies {
            let sheet = body.sheet.as_deref();
            let body = sheet.filter(|_| rules.follows_the_front()).unwrap_or(body);
            let view = View::new(body, &light);
            let outcome = beam::trace(&view, rules);
            let share = body.weight / self.entrance_area;
            for path in paths::merge(outcome.pieces, &view) {
                let polygon: Vec<DVec2> =
                    path.polygon.iter().map(|&p| DVec2::from_array(p)).collect();
                let [[uu, uv], [vu, vv]] = path.matrix;
                let matrix = DMat2::from_cols(DVec2::new(uu, vu), DVec2::new(uv, vv));
                let density = share * path.weight;
                eta += density * polygon::area(&polygon);
                filled.add(&polygon, matrix, DVec2::from_array(path.offset), density);
                paths.push(Path {
                    weight: body.weight * path.weight,
                    ..path
                });
            }
            for (sum, area) in fate.iter_mut().zip(outcome.area) {
                *sum += share * area;
            }
            dropped += share * outcome.dropped;
        }
        fate[Fate::OutOfRange as usize] = filled.out_of_range;
        fate[Fate::Retroreflected as usize] = (eta - filled.out_of_range).max(0.0);
        Share {
            paths,
            fate,
            retroreflected: eta,
            histogram: filled.mass,
            dropped,
        }
    }
}

/// Returns the probability per launched ray that `paths` give each bin, `[v][u]` row-major, and the
/// probability outside the histogram.
pub(crate) fn spread(
    paths: &[Path],
    entrance_area: f64,
    bins: usize,
    range: f64,
) -> (Vec<f64>, f64) {
    let mut filled = bins::Histogram::new(bins, range);
    for path in paths {
        let polygon: Vec<DVec2> = path.polygon.iter().map(|&p| p.into()).collect();
        let [[uu, uv], [vu, vv]] = path.matrix;
        let matrix = DMat2::from_cols(DVec2::new(uu, vu), DVec2::new(uv, vv));
        let density = path.weight / entrance_area;
        filled.add(&polygon, matrix, path.offset.into(), density);
    }
    (filled.mass, filled.out_of_range)
}

/// The arrays of an exact table, named as in [`tables::Table`].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Baked {
    /// Conditional probability `[incidence, azimuth, v, u]`.
    pub histogram: Array4<f64>,
    /// Retroreflected share eta `[incidence, azimuth]`.
    pub retroreflected: Array2<f64>,
    /// Shares of the launched light by fate `[incidence, azimuth, fate]`.
    pub fate: Array3<f64>,
    /// Polygons and maps of every direction.
    pub exact: Exact,
}

impl Baked {
    /// Makes the table of these arrays over `axes`.
    pub(crate) fn table(self, axes: Axes, provenance: Provenance) -> Table {
        let shape = axes.shape();
        Table {
            axes,
            histogram: self.histogram,
            counts: None,
            standard_error: Array2::zeros(shape),
            retroreflected: self.retroreflected,
            fate: self.fate,
            fate_counts: None,
            rays: Array2::zeros(shape),
            exact: Some(self.exact),
            deviations: None,
            provenance,
            passage: None,
            errors_rad: [0.0; 3],
        }
    }
}

/// Returns the prepared cell if its table in the directions of `axes` has no error but rounding.
///
/// # Errors
/// Says why not: an azimuth is NaN, the mean over all azimuths, or the exact method does not take
/// the cell.
pub(crate) fn prepare<'a>(prepared: &'a Prepared, axes: &Axes) -> Result<&'a ExactCell, String> {
    if axes.azimuth_deg.iter().any(|azimuth| azimuth.is_nan()) {
        return Err(format!(
            "a mean over all azimuths is a numerical integral with an error of up to {MEAN_ERROR}, \
            so it has no exact table"
        ));
    }
    prepared.exact().map_err(String::from)
}

/// Bakes every direction of `axes`, in parallel. The result does not depend on the number of
/// threads.
///
/// `done` is called once per finished direction, from any thread, and returns whether to go on. If
/// it once returns `false`, the result is `None`. An azimuth of NaN stands for the mean over all
/// azimuths, which is within [`crate::cell::MEAN_ERROR`] and has no paths.
pub(crate) fn bake(
    exact: &ExactCell,
    axes: &Axes,
    rules: &Rules,
    done: impl Fn() -> bool + Sync,
) -> Option<Baked> {
    let (incidences, azimuths) = axes.shape();
    let directions: Option<Vec<Share>> = (0..incidences * azimuths)
        .into_par_iter()
        .map(|i| {
            let (incidence, azimuth) = (
                axes.incidence_deg[i / azimuths],
                axes.azimuth_deg[i % azimuths],
            );
            let at = |azimuth| exact.direction(incidence, azimuth, axes.bins, axes.range, rules);
            let direction = if azimuth.is_nan() {
                mean::mean(&at)
            } else {
                at(azimuth)
            };
            done().then_some(direction)
        })
        .collect();
    let directions = directions?;
    let of = |incidence: usize, azimuth: usize| &directions[incidence * azimuths + azimuth];
    let in_range: Vec<f64> = directions
        .iter()
        .map(|direction| direction.histogram.iter().sum())
        .collect();
    let histogram = Array4::from_shape_fn(
        (incidences, azimuths, axes.bins, axes.bins),
        |(i, a, v, u)| {
            let whole = in_range[i * azimuths + a];
            if whole > 0.0 {
                of(i, a).histogram[v * axes.bins + u] / whole
            } else {
                0.0
            }
        },
    );
    let retroreflected =
        Array2::from_shape_fn((incidences, azimuths), |(i, a)| of(i, a).retroreflected);
    let fates = rules.fates().len();
    let fate = Array3::from_shape_fn((incidences, azimuths, fates), |(i, a, k)| of(i, a).fate[k]);
    let exact = Exact {
        entrance_area: exact.entrance_area,
        paths: directions
            .into_iter()
            .map(|direction| direction.paths)
            .collect(),
    };
    Some(Baked {
        histogram,
        retroreflected,
        fate,
        exact,
    })
}

/// The fates and ray shifts of the light of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Share {
    /// Polygons of retroreflected light with their maps, incidence frame, edge lengths.
    pub paths: Vec<Path>,
    /// Share of the launched light by fate, in the order of [`Fate::ALL`].
    pub fate: [f64; Fate::ALL.len()],
    /// Retroreflected share eta: the sum of the fates `retroreflected` and `out_of_range`.
    pub retroreflected: f64,
    /// Probability per launched ray of each bin, `[v][u]`, row-major. Its sum is the share of the
    /// fate `retroreflected`.
    pub histogram: Vec<f64>,
    /// Net share of the slivers that were given up as rounding. The shares of all fates sum to 1
    /// less this.
    pub dropped: f64,
}

/// Length of an edge, edge lengths, below which its direction is rounding. Such an edge would cut a
/// polygon anywhere. Without it a thin polygon is longer by no more than this area.
const SHORT: f64 = 1e-15;

/// Distance, edge lengths, by which a polygon may cross the line of its own edge. The rounding of a
/// long edge is less.
const STRAIGHT: f64 = 1e-13;

/// Returns the sum of the areas of `parts`.
pub(crate) fn total_area(parts: &[Polygon]) -> f64 {
    parts.iter().map(|part| polygon::area(part)).sum()
}

/// Returns `polygon` less the convex parts `taken`, as convex parts of more than `least` area each.
pub(crate) fn without(polygon: &Polygon, taken: &[(usize, Polygon)], least: f64) -> Vec<Polygon> {
    let mut left = vec![polygon.clone()];
    for (_, taken) in taken {
        let edges = polygon::edges_longer_than(SHORT, taken);
        let planes: Vec<HalfPlane> = edges.map(|edge| beside(edge, taken)).collect();
        left = left
            .into_iter()
            .flat_map(|part| polygon::subtract(&part, &planes, least).unwrap_or(vec![part]))
            .collect();
    }
    left.retain(|part| polygon::area(part) > least);
    left
}

/// Returns the half-plane moved outward until `polygon` lies in it.
///
/// The direction of a short edge is off by rounding over its length. Its line would cut off a part
/// of its own polygon.
fn beside(edge: HalfPlane, polygon: &Polygon) -> HalfPlane {
    let beyond = polygon.iter().map(|&p| edge.value(p)).fold(0.0, f64::max);
    if beyond <= STRAIGHT * edge.gradient.length() {
        return edge;
    }
    HalfPlane {
        constant: edge.constant - beyond,
        ..edge
    }
}

/// Returns the lowest and the highest coordinates of all `parts` together.
pub(crate) fn bounds_of_all(parts: &[Polygon]) -> (DVec2, DVec2) {
    let start = polygon::bounds(&[]);
    parts
        .iter()
        .map(|part| polygon::bounds(part))
        .fold(start, |a, b| (a.0.min(b.0), a.1.max(b.1)))
}
