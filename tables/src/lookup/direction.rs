//! One direction of a table: its own, or interpolated between the directions around.

use ndarray::Array2;

use crate::error::Error;
use crate::lookup::family::{self, Family};
use crate::lookup::grid_cell::{Bracket, GridCell};
use crate::table::axes::Axes;
use crate::table::deviation::Exits;
use crate::table::exact::Path;
use crate::table::symmetry;
use crate::table::table::Table;

/// Greatest difference of two angles that count as equal, degrees.
pub(crate) const SAME_DEG: f64 = 1e-9;

/// Greatest number of corners of a direction whose polygons are interpolated.
///
/// The directions of a cube with worn edges, errors and a front that traps light have a hundred.
/// The work grows with the square. Thousands come from a curved face that planes stand for, and
/// hardly any of its paths has a counterpart in another direction.
const MOST_CORNERS: usize = 2048;

/// Behaviour of the sheet for rays of one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; NaN for the mean over all azimuths.
    pub azimuth_deg: f64,
    /// Retroreflected share, `out_of_range` included; 0 is a legal answer.
    pub retroreflected: f64,
    /// Probability per launched ray of each bin, eta x histogram, `[v, u]`.
    ///
    /// For an interpolated direction it is the mixture of its neighbours, even where `paths` are
    /// more accurate.
    pub probability: Array2<f64>,
    /// Half width of the histogram, edge lengths: it covers u and v in [-range, range].
    pub range: f64,
    /// Standard error of `eta` from the numbers of rays, without the error of the interpolation.
    pub standard_error: f64,
    /// True if the direction was interpolated, false if it is one of the table's own.
    pub interpolated: bool,
    /// Paths behind the distribution of an exact table, its own or interpolated; `None` without
    /// polygons.
    pub paths: Option<Vec<Path>>,
    /// Light by shift and deviation, where a table of rays has it: its own, or mixed as
    /// `probability` is.
    pub exits: Option<Exits>,
}

impl Direction {
    /// Returns the direction without its bins and exit directions, for what only its paths tell.
    pub fn without_bins(&self) -> Direction {
        Direction {
            probability: Array2::zeros((0, 0)),
            exits: None,
            paths: self.paths.clone(),
            ..*self
        }
    }
}

/// Azimuth that the table knows: one of its own, or an image of one by symmetry.
#[derive(Debug, Clone, Copy)]
pub(super) struct AzimuthImage {
    /// Azimuth, degrees, in [0, 360).
    pub azimuth_deg: f64,
    /// Index of the azimuth in the axis of the table.
    pub place: usize,
    /// True if v changes its sign.
    pub mirrored: bool,
}

impl AzimuthImage {
    /// Only azimuth of a table of the mean over azimuths.
    const MEAN: AzimuthImage = AzimuthImage {
        azimuth_deg: f64::NAN,
        place: 0,
        mirrored: false,
    };

    /// Returns a histogram as this image shows it.
    pub(super) fn seen(&self, probability: Array2<f64>) -> Array2<f64> {
        if self.mirrored {
            symmetry::mirrored(probability)
        } else {
            probability
        }
    }

    /// Returns paths as this image shows them.
    pub(super) fn seen_paths(&self, paths: &[Path]) -> Vec<Path> {
        if self.mirrored {
            symmetry::mirrored_paths(paths)
        } else {
            paths.to_vec()
        }
    }
}

impl Table {
    /// Returns the direction with this incidence and azimuth, degrees.
    ///
    /// It is the table's own direction within 1e-9 deg, otherwise interpolated between its
    /// neighbours.
    ///
    /// Azimuths are periodic in 360 deg, and those of a symmetric table ([`crate::Symmetry`]) stand
    /// for their images too. A gap between the last and the first azimuth, or between images, is
    /// interpolated only if it is no wider than the widest gap between the table's own azimuths,
    /// that is, if the table goes all around. A table of the mean over azimuths answers with the
    /// mean, whatever the azimuth, and without one.
    ///
    /// # Errors
    /// Returns [`Error::Direction`] if the direction lies outside of the angles of the table (the
    /// error names the nearest direction that it holds), if `azimuth_deg` is `None` and the table
    /// is not a mean, if an angle is not finite, or if there are too many polygons to interpolate.
    ///
    /// ```
    /// # use ndarray::{Array4, Array5};
    /// # use tables::options::{Back, Front, Losses, Method, Sampler, StatedOptions};
    /// # use tables::{Axes, Fate, Provenance, Table};
    /// # let axes = Axes {
    /// #     incidence_deg: vec![0.0, 10.0], azimuth_deg: vec![0.0], bins: 2, range: 2.0,
    /// # };
    /// # let counts = Array5::from_shape_fn((2, 1, 1, 2, 2), |(i, ..)| if i == 0 { 2 } else { 1 });
    /// # let mut fates = Array4::zeros((2, 1, 1, Fate::of(Front::Once, false).len()));
    /// # for i in 0..2 {
    /// #     fates[[i, 0, 0, Fate::Retroreflected as usize]] = [8, 4][i];
    /// #     fates[[i, 0, 0, Fate::Missed as usize]] = [2, 6][i];
    /// # }
    /// # let provenance = Provenance {
    /// #     generator: String::new(), design: String::new(), mesh_hash: String::new(),
    /// #     edge_length: 1.0, edge_length_unit: "mm".into(), azimuth_zero: [1.0, 0.0, 0.0],
    /// #     refractive_index: 1.0, back: Back::Mirror.into(), losses: Losses::None.into(),
    /// #     reflectance: 1.0, method: Method::Rays.into(), sampler: Some(Sampler::Random.into()),
    /// #     seed: 1, angular_tolerance_deg: 0.5, tolerance: 0.0, lattice: None,
    /// #     wavelength_nm: None, metal_index: None, shards: None,
    /// #     symmetry: tables::Symmetry::NONE, direction_tolerance: None,
    /// #     options: StatedOptions::none(),
    /// # };
    /// # let table = Table::from_counts(axes, counts, fates, provenance);
    /// // eta is 0.8 at 0 deg and 0.4 at 10 deg.
    /// let direction = table.direction(5.0, Some(0.0))?;
    /// assert!(direction.interpolated && (direction.retroreflected - 0.6).abs() < 1e-15);
    /// let error = table.direction(11.0, Some(0.0)).unwrap_err().to_string();
    /// assert!(error.contains("it is incidence 10 deg"), "{error}");
    /// # Ok::<(), tables::Error>(())
    /// ```
    pub fn direction(
        &self,
        incidence_deg: f64,
        azimuth_deg: Option<f64>,
    ) -> Result<Direction, Error> {
        let azimuths = &self.axes.azimuth_deg;
        let asked = if self.axes.is_mean() {
            f64::NAN
        } else {
            azimuth_deg.ok_or_else(|| {
                let (first, last) = (azimuths[0], azimuths[azimuths.len() - 1]);
                Error::Direction(format!(
                    "the table holds single azimuths ({first} to {last} deg); give azimuth_deg, or \
                    bake with --azimuth mean"
                ))
            })?
        };
        if !incidence_deg.is_finite() || !(asked.is_finite() || self.axes.is_mean()) {
            return Err(Error::Direction(format!(
                "incidence {incidence_deg} deg, azimuth {asked} deg is no direction; give finite \
                angles"
            )));
        }
        match self.cell(&self.images(), incidence_deg, asked) {
            Some(cell) => {
                let corners = cell.corners_between();
                if corners > MOST_CORNERS {
                    return Err(Error::Direction(format!(
                        "incidence {incidence_deg} deg lies between directions of the table that \
                        have {corners} corners of polygons, above the limit of {MOST_CORNERS} for \
                        interpolation; name a direction of the table, or bake curved faces by rays \
                        (--method rays)"
                    )));
                }
                Ok(cell.direction(incidence_deg, asked))
            }
            None => Err(self.outside(incidence_deg, asked)),
        }
    }

    /// Returns what the interpolation of polygons knows of the gap in which a direction lies, or
    /// `None` if the direction is outside of the table, or polygons cannot be interpolated there.
    ///
    /// All directions within the gap give the same. A direction with an incidence or an azimuth of
    /// the table lies in a gap of its own, along the line of that angle. A mean over azimuths has
    /// no gaps.
    pub fn families(&self, incidence_deg: f64, azimuth_deg: f64) -> Option<Vec<Family>> {
        let exact = self.exact.as_ref().filter(|_| !self.axes.is_mean())?;
        let images = self.images();
        let cell = self.cell(&images, incidence_deg, azimuth_deg)?;
        family::known(&cell.nodes(exact)?, self.provenance.refractive_index)
    }

    /// Returns the table's directions around a direction, or `None` outside of the table.
    pub(super) fn cell<'a>(
        &'a self,
        images: &'a [AzimuthImage],
        incidence_deg: f64,
        azimuth_deg: f64,
    ) -> Option<GridCell<'a>> {
        let across = if self.axes.is_mean() {
            Some((0, 0, 0.0))
        } else {
            around(images, self.axes.widest_gap_deg(), azimuth_deg)
        };
        Some(GridCell {
            table: self,
            along: between(&self.axes.incidence_deg, incidence_deg)?,
            across: across?,
            images,
        })
    }

    /// Returns the azimuths in [0, 360) that the table knows, ascending.
    ///
    /// They are its own azimuths and their images by symmetry. Each is an azimuth in degrees, the
    /// index of the azimuth whose distribution it has, and true if v is turned over. For a mean
    /// over azimuths it is one entry, with the azimuth NaN.
    pub fn azimuths(&self) -> Vec<(f64, usize, bool)> {
        let images = self.images().into_iter();
        images
            .map(|image| (image.azimuth_deg, image.place, image.mirrored))
            .collect()
    }

    /// Returns the azimuths in [0, 360) that the table knows, ascending: its own and their images.
    pub(super) fn images(&self) -> Vec<AzimuthImage> {
        if self.axes.is_mean() {
            return vec![AzimuthImage::MEAN];
        }
        let symmetry = self.provenance.symmetry;
        let places = self.axes.azimuth_deg.iter().enumerate();
        let mut images: Vec<AzimuthImage> = places
            .flat_map(|(place, &azimuth)| {
                let image = move |(azimuth_deg, mirrored)| AzimuthImage {
                    azimuth_deg,
                    place,
                    mirrored,
                };
                symmetry.images(azimuth).map(image)
            })
            .collect();
        // Of equal azimuths the first stays. It is not mirrored if one of them is not.
        images.sort_by(|a, b| {
            let order = a.azimuth_deg.total_cmp(&b.azimuth_deg);
            order
                .then(a.mirrored.cmp(&b.mirrored))
                .then(a.place.cmp(&b.place))
        });
        images.dedup_by(|b, a| b.azimuth_deg - a.azimuth_deg <= SAME_DEG);
        images
    }

    /// Makes the error for a direction outside of the table, with the nearest direction.
    fn outside(&self, incidence_deg: f64, azimuth_deg: f64) -> Error {
        let nearest = |values: &[f64], distance: &dyn Fn(f64) -> f64| {
            values
                .iter()
                .copied()
                .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
                .unwrap_or(f64::NAN)
        };
        let images = self.images().into_iter().map(|image| image.azimuth_deg);
        let azimuths: Vec<f64> = self
            .axes
            .azimuth_deg
            .iter()
            .copied()
            .chain(images)
            .collect();
        let incidence = nearest(&self.axes.incidence_deg, &|x| (x - incidence_deg).abs());
        let azimuth = nearest(&azimuths, &|x| turn(x - azimuth_deg).abs());
        Error::Direction(format!(
            "the table does not cover incidence {incidence_deg} deg, azimuth {azimuth_deg} deg; the \
            nearest direction in it is incidence {incidence} deg, azimuth {azimuth} deg; correct \
            the angle, or bake the direction"
        ))
    }
}

/// Returns the places of an ascending axis around `x`, or `None` if `x` lies outside of the axis.
fn between(axis: &[f64], x: f64) -> Option<Bracket> {
    if let Some(stored) = axis
        .iter()
        .position(|&stored| (stored - x).abs() <= SAME_DEG)
    {
        return Some((stored, stored, 0.0));
    }
    let above = axis.iter().position(|&value| value > x)?;
    let below = above.checked_sub(1)?;
    Some((
        below,
        above,
        (x - axis[below]) / (axis[above] - axis[below]),
    ))
}

impl Axes {
    /// Returns whether a table with these axes and without symmetry interpolates from its last
    /// azimuth on to its first: if that gap is no wider than its widest one.
    pub fn goes_around(&self) -> bool {
        let [first, .., last] = self.azimuth_deg[..] else {
            return false;
        };
        first + 360.0 - last <= self.widest_gap_deg() + SAME_DEG
    }

    /// Returns the widest gap between neighbouring azimuths, degrees. Wider gaps are not
    /// interpolated.
    pub(super) fn widest_gap_deg(&self) -> f64 {
        let gaps = self.azimuth_deg.windows(2);
        gaps.map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
    }
}

/// Returns the places of the images around an azimuth, or `None` if their gap is wider than
/// `widest_deg`.
fn around(images: &[AzimuthImage], widest_deg: f64, x: f64) -> Option<Bracket> {
    let stored = |image: &AzimuthImage| turn(image.azimuth_deg - x).abs() <= SAME_DEG;
    if let Some(stored) = images.iter().position(stored) {
        return Some((stored, stored, 0.0));
    }
    let x = x.rem_euclid(360.0);
    let above = images.partition_point(|image| image.azimuth_deg <= x);
    let next = above % images.len();
    let before = (above + images.len() - 1) % images.len();
    let from = |azimuth: f64| (azimuth - images[before].azimuth_deg).rem_euclid(360.0);
    let gap = from(images[next].azimuth_deg);
    (gap > 0.0 && gap <= widest_deg + SAME_DEG).then(|| (before, next, from(x) / gap))
}

/// Returns the angle in (-180, 180] that differs from `angle` by whole turns, degrees.
pub(super) fn turn(angle: f64) -> f64 {
    let angle = angle.rem_euclid(360.0);
    if angle > 180.0 { angle - 360.0 } else { angle }
}
