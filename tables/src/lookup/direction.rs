//! One direction of a table: exactly, or interpolated between those around it.
//!
//! The paths of an exact table are interpolated as polygons (`between`), and eta is theirs. Bins
//! are a mixture: eta x histogram, bilinear in the two angles (model: across a cutoff the
//! conditional histogram jumps, eta x histogram does not), each of the neighbouring distributions
//! in its own incidence frame. The error of either is that of the table's spacing, which the
//! standard error does not include.

use ndarray::Array2;

use crate::error::error::Error;
use crate::error::no_direction::NoDirection;
use crate::lookup::between;
use crate::lookup::between::Node;
use crate::table::deviation::Exits;
use crate::table::exact::{Exact, Path};
use crate::table::polygon::area;
use crate::table::symmetry;
use crate::table::table::Table;

/// Angles closer than this are the same direction, degrees.
pub(crate) const SAME_DEG: f64 = 1e-9;

/// What the sheet does with rays of one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Angle of incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; NaN for the mean over all azimuths.
    pub azimuth_deg: f64,
    /// Retroreflected fraction, `out_of_range` included; 0 is a legal answer.
    pub eta: f64,
    /// Probability per launched ray of each bin, eta x histogram, `[v, u]`; of an interpolated
    /// direction the mixture of its neighbours, even where `paths` say more.
    pub probability: Array2<f64>,
    /// The histogram covers u, v in [-range, range], edge lengths.
    pub range: f64,
    /// Standard error of `eta` from the numbers of rays; the error of the interpolation is not in
    /// it.
    pub standard_error: f64,
    /// Whether the table holds the direction only by interpolation.
    pub interpolated: bool,
    /// The paths behind the distribution, where the table is exact: its own, or interpolated.
    pub paths: Option<Vec<Path>>,
    /// Where the light goes, where a table of rays says so: its own, or mixed as `probability`.
    pub exits: Option<Exits>,
}

/// An azimuth that the table knows: one of its own, or what the symmetry makes of it.
#[derive(Debug, Clone, Copy)]
struct Image {
    /// In [0, 360).
    azimuth_deg: f64,
    /// Index in the axis.
    place: usize,
    /// Whether v is turned over.
    mirrored: bool,
}

impl Image {
    /// The only azimuth of a mean.
    const MEAN: Image = Image {
        azimuth_deg: f64::NAN,
        place: 0,
        mirrored: false,
    };

    fn seen(&self, probability: Array2<f64>) -> Array2<f64> {
        if self.mirrored {
            symmetry::mirrored(probability)
        } else {
            probability
        }
    }

    fn seen_paths(&self, paths: &[Path]) -> Vec<Path> {
        if self.mirrored {
            symmetry::mirrored_paths(paths)
        } else {
            paths.to_vec()
        }
    }
}

impl Table {
    /// The direction of that incidence and azimuth, degrees: the table's own within 1e-9 deg, else
    /// interpolated between its neighbours.
    ///
    /// Azimuths are periodic in 360 deg, and those of a symmetric table ([`crate::Symmetry`]) stand
    /// for their images too. Between the last and the first azimuth, and between images, there is
    /// interpolation only where that gap is no wider than the widest one of the table's own
    /// azimuths, that is, where the table goes all around. A table of the mean over azimuths
    /// answers every azimuth, or none, with the mean.
    ///
    /// # Errors
    /// [`Error::NoDirection`] outside of what the table brackets, naming the nearest direction that
    /// it holds; where the azimuth is left out and the table is not a mean; where an angle is not
    /// finite.
    ///
    /// ```
    /// # use ndarray::{Array4, Array5};
    /// # use tables::options::{Back, Losses, Method, Sampler, StatedOptions};
    /// # use tables::{Axes, Fate, Provenance, Table};
    /// # let axes = Axes { incidence_deg: vec![0.0, 10.0], azimuth_deg: vec![0.0], bins: 2, range: 2.0 };
    /// # let counts = Array5::from_shape_fn((2, 1, 1, 2, 2), |(i, ..)| if i == 0 { 2 } else { 1 });
    /// # let mut fates = Array4::zeros((2, 1, 1, Fate::ALL.len()));
    /// # for i in 0..2 {
    /// #     fates[[i, 0, 0, Fate::Retroreflected as usize]] = [8, 4][i];
    /// #     fates[[i, 0, 0, Fate::Missed as usize]] = [2, 6][i];
    /// # }
    /// # let provenance = Provenance {
    /// #     generator: String::new(), design: String::new(), mesh_hash: String::new(), edge_length: 1.0,
    /// #     edge_length_unit: "mm".into(), azimuth_zero: [1.0, 0.0, 0.0], refractive_index: 1.0,
    /// #     back: Back::Mirror.into(), losses: Losses::None.into(), reflectance: 1.0,
    /// #     method: Method::Rays.into(), sampler: Some(Sampler::Random.into()), seed: 1,
    /// #     angular_tolerance_deg: 0.5, tolerance: 0.0, lattice: None, wavelength_nm: None,
    /// #     metal_index: None, shards: None, symmetry: tables::Symmetry::NONE,
    /// #     direction_tolerance: None, options: StatedOptions::none(),
    /// # };
    /// # let table = Table::from_counts(axes, counts, fates, provenance);
    /// // eta is 0.8 at 0 deg and 0.4 at 10 deg
    /// let direction = table.direction(5.0, Some(0.0))?;
    /// assert!(direction.interpolated && (direction.eta - 0.6).abs() < 1e-15);
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
            azimuth_deg.ok_or_else(|| NoDirection::AzimuthNeeded {
                first_deg: azimuths[0],
                last_deg: azimuths[azimuths.len() - 1],
            })?
        };
        if !incidence_deg.is_finite() || !(asked.is_finite() || self.axes.is_mean()) {
            return Err(NoDirection::NotFinite {
                incidence_deg,
                azimuth_deg: asked,
            }
            .into());
        }
        let images = self.images();
        let across = if self.axes.is_mean() {
            Some((0, 0, 0.0))
        } else {
            around(&images, self.widest_gap_deg(), asked)
        };
        match (between(&self.axes.incidence_deg, incidence_deg), across) {
            (Some(along), Some(across)) => Ok(Cell {
                table: self,
                images,
                along,
                across,
            }
            .direction(incidence_deg, asked)),
            _ => Err(self.outside(incidence_deg, asked).into()),
        }
    }

    /// The azimuths in [0, 360) that the table knows, ascending: its own ones and their images.
    fn images(&self) -> Vec<Image> {
        if self.axes.is_mean() {
            return vec![Image::MEAN];
        }
        let symmetry = self.provenance.symmetry;
        let places = self.axes.azimuth_deg.iter().enumerate();
        let mut images: Vec<Image> = places
            .flat_map(|(place, &azimuth)| {
                let image = move |(azimuth_deg, mirrored)| Image {
                    azimuth_deg,
                    place,
                    mirrored,
                };
                symmetry.images(azimuth).map(image)
            })
            .collect();
        // Of equal azimuths the first one stays, which is seen in no mirror if one of them is.
        images.sort_by(|a, b| {
            let order = a.azimuth_deg.total_cmp(&b.azimuth_deg);
            order
                .then(a.mirrored.cmp(&b.mirrored))
                .then(a.place.cmp(&b.place))
        });
        images.dedup_by(|b, a| b.azimuth_deg - a.azimuth_deg <= SAME_DEG);
        images
    }

    /// The widest gap between neighbours of the azimuth axis, degrees: wider ones are not
    /// interpolated across.
    fn widest_gap_deg(&self) -> f64 {
        let gaps = self.axes.azimuth_deg.windows(2);
        gaps.map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
    }

    fn outside(&self, incidence_deg: f64, azimuth_deg: f64) -> NoDirection {
        let nearest = |values: &[f64], distance: &dyn Fn(f64) -> f64| {
            values
                .iter()
                .copied()
                .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
                .unwrap_or(f64::NAN)
        };
        let images = self.images();
        let images = images.iter().map(|image| image.azimuth_deg);
        let azimuths: Vec<f64> = self
            .axes
            .azimuth_deg
            .iter()
            .copied()
            .chain(images)
            .collect();
        NoDirection::Outside {
            incidence_deg,
            azimuth_deg,
            nearest_incidence_deg: nearest(&self.axes.incidence_deg, &|x| {
                (x - incidence_deg).abs()
            }),
            nearest_azimuth_deg: nearest(&azimuths, &|x| turn(x - azimuth_deg).abs()),
        }
    }
}

/// Two places of an axis and the share of the second; twice the same place where the axis holds the
/// value.
type Bracket = (usize, usize, f64);

/// The share of a place, 0 beyond the bracket.
fn share((first, second, share): Bracket, place: usize) -> f64 {
    let (a, b) = (place == first, place == second);
    f64::from(u8::from(a)) * (1.0 - share) + f64::from(u8::from(b)) * share
}

/// The directions of a table around one that is asked for.
struct Cell<'a> {
    table: &'a Table,
    images: Vec<Image>,
    along: Bracket,
    /// Among `images`.
    across: Bracket,
}

impl Cell<'_> {
    fn direction(&self, incidence_deg: f64, azimuth_deg: f64) -> Direction {
        let table = self.table;
        let mut eta = 0.0;
        let mut variance = 0.0;
        let mut probability = Array2::zeros((table.axes.bins, table.axes.bins));
        for (i, k, share) in self.corners() {
            let (image, j) = (&self.images[k], self.images[k].place);
            eta += share * table.retroreflected[[i, j]];
            variance += (share * table.standard_error[[i, j]]).powi(2);
            probability.scaled_add(share, &image.seen(table.probability(i, j)));
        }
        let interpolated = self.along.2 > 0.0 || self.across.2 > 0.0;
        let exact = table.exact.as_ref().filter(|_| !table.axes.is_mean());
        let paths = exact.and_then(|exact| {
            if interpolated {
                let paths = self.paths_between(exact, incidence_deg, azimuth_deg)?;
                let returned = paths.iter().map(|path| path.weight * area(&path.polygon));
                eta = (returned.sum::<f64>() / exact.entrance_area).min(1.0);
                Some(paths)
            } else {
                self.paths(exact, self.along.0, self.across.0)
            }
        });
        Direction {
            incidence_deg,
            azimuth_deg,
            eta,
            probability,
            range: table.axes.range,
            standard_error: variance.sqrt(),
            interpolated,
            paths,
            exits: self.exits(),
        }
    }

    /// The exit directions, mixed.
    fn exits(&self) -> Option<Exits> {
        let found = self.table.deviations.as_ref()?;
        let mut mixed: Vec<(u64, f64)> = Vec::new();
        for (i, k, share) in self.corners() {
            let image = &self.images[k];
            let azimuths = self.table.axes.azimuth_deg.len();
            let launched = self.table.rays[[i, image.place]].max(1) as f64;
            for entry in &found.entries[i * azimuths + image.place] {
                let place = match image.mirrored {
                    true => found.grid.mirrored(entry.place),
                    false => entry.place,
                };
                mixed.push((place, share * entry.rays as f64 / launched));
            }
        }
        // The corners' entries ascend: sorted runs, which are merged in their order, so that sums
        // are too.
        mixed.sort_by_key(|(place, _)| *place);
        mixed.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            kept.1 += if same { next.1 } else { 0.0 };
            same
        });
        Some(Exits {
            grid: found.grid,
            probability: mixed,
        })
    }

    /// The table's directions around, as indices of the incidence and the image, with their shares.
    fn corners(&self) -> impl Iterator<Item = (usize, usize, f64)> + use<> {
        let ends = |(first, second, t): Bracket| [(first, 1.0 - t), (second, t)];
        let across = ends(self.across);
        let along = ends(self.along).into_iter();
        let all = along.flat_map(move |(i, p)| across.map(|(k, q)| (i, k, p * q)));
        all.filter(|&(_, _, share)| share > 0.0)
    }

    fn paths(&self, exact: &Exact, i: usize, k: usize) -> Option<Vec<Path>> {
        let image = &self.images[k];
        let held = i * self.table.axes.azimuth_deg.len() + image.place;
        exact.paths.get(held).map(|paths| image.seen_paths(paths))
    }

    /// By the corners of the cell and the directions next to them.
    fn paths_between(
        &self,
        exact: &Exact,
        incidence_deg: f64,
        azimuth_deg: f64,
    ) -> Option<Vec<Path>> {
        let index = self.table.provenance.refractive_index;
        let tau = |incidence_deg: f64, azimuth_rad: f64| {
            let sine = incidence_deg.to_radians().sin() / index;
            let tangent = sine / (1.0 - sine * sine).sqrt();
            [azimuth_rad.cos(), azimuth_rad.sin()].map(|x| tangent * x)
        };
        let incidences = &self.table.axes.incidence_deg;
        let last = (self.along.1 + 1).min(incidences.len() - 1);
        let around = self.along.0.saturating_sub(1)..=last;
        let azimuths = self.azimuths_around();
        let mut nodes = Vec::new();
        for (i, &incidence_deg) in around.clone().zip(&incidences[around]) {
            for &k in &azimuths {
                let azimuth_rad = self.images[k].azimuth_deg.to_radians();
                nodes.push(Node {
                    tau: tau(incidence_deg, azimuth_rad),
                    azimuth_rad,
                    paths: self.paths(exact, i, k)?,
                    share: share(self.along, i) * share(self.across, k),
                });
            }
        }
        let azimuth_rad = azimuth_deg.to_radians();
        between::paths(&nodes, tau(incidence_deg, azimuth_rad), azimuth_rad, index)
    }

    /// The images at the cell's corners, and their next ones where no wide gap lies between.
    fn azimuths_around(&self) -> Vec<usize> {
        let count = self.images.len();
        let widest = self.table.widest_gap_deg() + SAME_DEG;
        let gap = |from: usize, to: usize| {
            (self.images[to].azimuth_deg - self.images[from].azimuth_deg).rem_euclid(360.0)
        };
        let (first, second) = (self.across.0, self.across.1);
        let (before, after) = ((first + count - 1) % count, (second + 1) % count);
        let mut around = vec![first, second];
        around.extend((gap(before, first) <= widest).then_some(before));
        around.extend((gap(second, after) <= widest).then_some(after));
        around.sort_unstable();
        around.dedup();
        around
    }
}

/// The places of an ascending axis around `x` and the share of the second, if `x` is in it or
/// between two of its values.
fn between(axis: &[f64], x: f64) -> Option<Bracket> {
    if let Some(held) = axis.iter().position(|&held| (held - x).abs() <= SAME_DEG) {
        return Some((held, held, 0.0));
    }
    let above = axis.iter().position(|&value| value > x)?;
    let below = above.checked_sub(1)?;
    Some((
        below,
        above,
        (x - axis[below]) / (axis[above] - axis[below]),
    ))
}

/// The places of the images around an azimuth and the share of the second, where they are no
/// further apart than `widest_deg`.
fn around(images: &[Image], widest_deg: f64, x: f64) -> Option<Bracket> {
    let held = |image: &Image| turn(image.azimuth_deg - x).abs() <= SAME_DEG;
    if let Some(held) = images.iter().position(held) {
        return Some((held, held, 0.0));
    }
    let x = x.rem_euclid(360.0);
    let above = images.partition_point(|image| image.azimuth_deg <= x);
    let next = above % images.len();
    let before = (above + images.len() - 1) % images.len();
    let from = |azimuth: f64| (azimuth - images[before].azimuth_deg).rem_euclid(360.0);
    let gap = from(images[next].azimuth_deg);
    (gap > 0.0 && gap <= widest_deg + SAME_DEG).then(|| (before, next, from(x) / gap))
}

/// The angle in (-180, 180] that differs by whole turns, degrees.
fn turn(angle: f64) -> f64 {
    let angle = angle.rem_euclid(360.0);
    if angle > 180.0 { angle - 360.0 } else { angle }
}
