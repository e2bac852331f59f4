//! The exact bake: beam tracing instead of samples.
//!
//! After Heckbert and Hanrahan, "Beam Tracing Polygonal Objects", SIGGRAPH 1984. On planar facets a collimated beam is
//! piecewise affine: every sequence of facets maps one polygon of the entrance plane by one affine map, so the whole
//! distribution of ray shifts is a finite set of polygons, and the probability of a bin is an area. Where this differs
//! from the article: all light of a direction is parallel and stays so, so that facets are unfolded into the entrance
//! plane and the whole problem is two-dimensional; cells may be periodic; of many equal cubes one is followed.
//!
//! Losses are a weight: all light of a facet sequence meets each facet at one angle, so one polarised path (`light`) says what
//! part of its power comes back, and the rest goes to the fates that took it.
//!
//! Accuracy: areas and shifts to a few ulp of the longest path in the cell, 1e-15 / cos(incidence) edge lengths.
//! Facets mirror on the side that is wound counter-clockwise; light ends at their backs, which only a lattice with gaps shows.

use crate::beams::beam;
use crate::beams::bins;
use crate::beams::mean;
use crate::beams::paths;
use glam::{DMat2, DVec2};
use meshes::cell::Cell;
use ndarray::{Array2, Array3, Array4};
use rayon::prelude::*;
use tables::{Axes, Exact, Fate, Path};

use crate::beams::body::Body;
pub use crate::beams::mean::MEAN_ERROR;
use crate::beams::view::View;
use crate::cell::bodies;
use crate::geometry::polygon;
use crate::optics::ray::Direction;
use crate::rays::path::Rules;

/// Why a cell cannot be baked exactly.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExactError {
    /// An average over azimuths is an integral that no finite set of polygons gives.
    #[error("the exact mean over azimuths is a quadrature, within {MEAN_ERROR}")]
    MeanAzimuth,
    /// A mean has no paths to say where their light goes.
    #[error(
        "the cell sends light off straight back, and an exact mean over azimuths would not say where; rays do (or leave it out: \
         --deviations off)"
    )]
    MeanDeviates,
    /// Facets that are no mirrors of one normal each.
    #[error("{option} leaves no plane mirrors, which the exact method needs")]
    NoPlanes {
        /// The option that asks for others.
        option: String,
    },
    /// Joining triangles to planes would take minutes.
    #[error(
        "the cell has {triangles} triangles in one piece and the exact method takes at most {limit}; give --method rays"
    )]
    TooFine {
        /// Triangles.
        triangles: usize,
        /// The limit.
        limit: usize,
    },
    /// The work grows faster than the number of facets.
    #[error(
        "the cell has {facets} planar facets and the exact method takes at most {limit}; give --method rays"
    )]
    TooManyFacets {
        /// Facets after joining coplanar triangles.
        facets: usize,
        /// The limit.
        limit: usize,
    },
}

/// Most facets, after joining coplanar triangles, that the exact method takes of a cell, or of one body of each kind where
/// the cell is taken apart: the work grows with their square.
pub const MOST_FACETS: usize = 2048;

/// Most triangles of a cell that is not taken apart: those of a plane are joined in a time that grows with their square.
pub(crate) const MOST_TRIANGLES: usize = 1 << 14;

/// What became of the light of one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Share {
    /// Retroreflecting polygons and maps, incidence frame, edge lengths.
    pub paths: Vec<Path>,
    /// Share of the launched light by fate, in the order of [`Fate::ALL`].
    pub fate: [f64; Fate::ALL.len()],
    /// Retroreflected fraction: `retroreflected` and `out_of_range` together.
    pub eta: f64,
    /// Probability per launched ray of each bin, `[v][u]` row-major: sums to the share of `retroreflected`.
    pub histogram: Vec<f64>,
    /// Net share of the slivers given up as rounding: the shares of all fates sum to 1 less this.
    pub dropped: f64,
}

/// A cell prepared for exact baking: planar facets joined, and of a sheet of many cells one of each kind.
#[derive(Debug, Clone)]
pub struct ExactCell {
    bodies: Vec<Body>,
    /// Of all bodies, each by its weight, square edge lengths.
    entrance_area: f64,
}

impl ExactCell {
    /// Takes the cell apart where it can be ([`bodies::kinds`]), joins coplanar triangles and checks the number of
    /// facets.
    ///
    /// # Errors
    /// [`ExactError::TooFine`], [`ExactError::TooManyFacets`], [`ExactError::NoPlanes`].
    pub fn new(cell: &Cell) -> Result<Self, ExactError> {
        if cell.normals.is_some() {
            return Err(ExactError::NoPlanes {
                option: "--normals file".into(),
            });
        }
        let bodies: Vec<Body> = match bodies::kinds(cell) {
            Ok(kinds) => {
                let most = kinds.iter().map(|kind| kind.places.len()).max();
                let weight = |places: usize| places as f64 / most.unwrap_or(1) as f64;
                kinds
                    .iter()
                    .map(|kind| Body::new(&kind.facets, &kind.entrance, weight(kind.places.len())))
                    .collect()
            }
            Err(_) if cell.facets.len() > MOST_TRIANGLES => {
                return Err(ExactError::TooFine {
                    triangles: cell.facets.len(),
                    limit: MOST_TRIANGLES,
                });
            }
            Err(_) => vec![Body::new(&cell.facets, &cell.entrance, 1.0)],
        };
        let prepared = ExactCell {
            entrance_area: bodies
                .iter()
                .map(|body| body.weight * body.entrance_area)
                .sum(),
            bodies,
        };
        let facets = prepared.facet_count();
        if facets > MOST_FACETS {
            return Err(ExactError::TooManyFacets {
                facets,
                limit: MOST_FACETS,
            });
        }
        Ok(prepared)
    }

    /// Area of the entrance, square edge lengths; of a sheet of many cells as [`Exact::entrance_area`] says.
    pub fn entrance_area(&self) -> f64 {
        self.entrance_area
    }

    /// Number of planar facets after joining coplanar triangles, in one body of each kind.
    pub fn facet_count(&self) -> usize {
        self.bodies.iter().map(|body| body.facets.len()).sum()
    }

    /// Traces one direction: angles in degrees, outside the front face, cell frame; `bins` x `bins` over
    /// [-range, range] edge lengths.
    pub fn direction(
        &self,
        incidence_deg: f64,
        azimuth_deg: f64,
        bins: usize,
        range: f64,
        rules: &Rules,
    ) -> Share {
        let (incidence_rad, azimuth_rad) = (incidence_deg.to_radians(), azimuth_deg.to_radians());
        let light = Direction::new(incidence_rad, azimuth_rad, rules.refractive_index);
        let mut filled = bins::Bins::new(bins, range);
        let mut paths = Vec::new();
        let mut fate = [0.0; Fate::ALL.len()];
        let (mut eta, mut dropped) = (0.0, 0.0);
        for body in &self.bodies {
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
            eta,
            histogram: filled.mass,
            dropped,
        }
    }
}

/// Probability per launched ray that `paths` give each bin, `[v][u]` row-major, and that beyond the histogram.
pub fn spread(paths: &[Path], entrance_area: f64, bins: usize, range: f64) -> (Vec<f64>, f64) {
    let mut filled = bins::Bins::new(bins, range);
    for path in paths {
        let polygon: Vec<DVec2> = path.polygon.iter().map(|&p| p.into()).collect();
        let [[uu, uv], [vu, vv]] = path.matrix;
        let matrix = DMat2::from_cols(DVec2::new(uu, vu), DVec2::new(uv, vv));
        let density = path.weight / entrance_area;
        filled.add(&polygon, matrix, path.offset.into(), density);
    }
    (filled.mass, filled.out_of_range)
}

/// The arrays of an exact table, as [`tables::Table`] names them.
#[derive(Debug, Clone, PartialEq)]
pub struct Baked {
    /// Conditional probability `[incidence, azimuth, v, u]`.
    pub histogram: Array4<f64>,
    /// Eta `[incidence, azimuth]`.
    pub retroreflected: Array2<f64>,
    /// Shares `[incidence, azimuth, fate]`.
    pub fate: Array3<f64>,
    /// Polygons and maps.
    pub exact: Exact,
}

/// Whether the table of `cell` in the directions of `axes` has no error at all: gives the prepared cell.
///
/// # Errors
/// [`ExactError`]: why not.
pub fn prepare(cell: &Cell, axes: &Axes) -> Result<ExactCell, ExactError> {
    if axes.azimuth_deg.iter().any(|azimuth| azimuth.is_nan()) {
        return Err(ExactError::MeanAzimuth);
    }
    ExactCell::new(cell)
}

/// Bakes every direction of `axes`, in parallel; the result does not depend on the number of threads. `done` is called
/// once per finished direction, from any thread. An azimuth of NaN is the mean over all, within [`MEAN_ERROR`], and has no
/// paths.
pub fn bake(prepared: &ExactCell, axes: &Axes, rules: &Rules, done: impl Fn() + Sync) -> Baked {
    let (incidences, azimuths) = axes.shape();
    let directions: Vec<Share> = (0..incidences * azimuths)
        .into_par_iter()
        .map(|i| {
            let (incidence, azimuth) = (
                axes.incidence_deg[i / azimuths],
                axes.azimuth_deg[i % azimuths],
            );
            let at = |azimuth| prepared.direction(incidence, azimuth, axes.bins, axes.range, rules);
            let direction = if azimuth.is_nan() {
                mean::mean(&at)
            } else {
                at(azimuth)
            };
            done();
            direction
        })
        .collect();
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
    let retroreflected = Array2::from_shape_fn((incidences, azimuths), |(i, a)| of(i, a).eta);
    let fate = Array3::from_shape_fn((incidences, azimuths, Fate::ALL.len()), |(i, a, k)| {
        of(i, a).fate[k]
    });
    let exact = Exact {
        entrance_area: prepared.entrance_area,
        paths: directions
            .into_iter()
            .map(|direction| direction.paths)
            .collect(),
    };
    Baked {
        histogram,
        retroreflected,
        fate,
        exact,
    }
}
