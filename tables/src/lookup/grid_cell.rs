//! The directions of a table around another one, and what lies between them.
//!
//! The paths of an exact table are interpolated as polygons (`between`), and eta follows from them.
//! Bins are a mixture: eta x histogram, bilinear in the two angles, each neighbouring distribution
//! in its own incidence frame. (Across a cutoff the conditional histogram jumps; eta x histogram
//! does not.) The error of either depends on the spacing of the table, and the standard error does
//! not include it.

use ndarray::Array2;

use crate::lookup::between;
use crate::lookup::direction::{AzimuthImage, Direction, SAME_DEG};
use crate::lookup::shape::NearDirection;
use crate::table::deviation::Exits;
use crate::table::exact::{Exact, Path};
use crate::table::polygon::area;
use crate::table::table::Table;

/// Two places of an axis and the share of the second; one place twice if the axis holds the value.
pub(super) type Bracket = (usize, usize, f64);

/// Returns the share of a place in a bracket; 0 beyond the bracket.
fn share((first, second, share): Bracket, place: usize) -> f64 {
    let (a, b) = (place == first, place == second);
    f64::from(u8::from(a)) * (1.0 - share) + f64::from(u8::from(b)) * share
}

/// Directions of a table around the direction that is asked for.
pub(super) struct GridCell<'a> {
    pub table: &'a Table,
    pub images: &'a [AzimuthImage],
    pub along: Bracket,
    /// Bracket of the azimuth, as indices of `images`.
    pub across: Bracket,
}

impl GridCell<'_> {
    /// Mixes the bins of the corners and interpolates the paths.
    pub(super) fn direction(&self, incidence_deg: f64, azimuth_deg: f64) -> Direction {
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
        let mut direction = Direction {
            incidence_deg,
            azimuth_deg,
            retroreflected: eta,
            probability,
            range: table.axes.range,
            standard_error: variance.sqrt(),
            interpolated,
            paths,
            exits: self.exits(),
        };
        if table.errors_rad != [0.0; 3] {
            let index = table.provenance.refractive_index;
            direction = direction.bent(table.errors_rad, index).unwrap_or(direction);
        }
        match &table.passage {
            Some(passage) => passage.seen(direction),
            None => direction,
        }
    }

    /// Mixes the light by shift and deviation of the corners.
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
        // The entries of each corner ascend. The sort is stable, so equal places are added in the
        // order of the corners.
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

    /// Returns the corners with a share above 0: index of the incidence, index of the image, share.
    fn corners(&self) -> impl Iterator<Item = (usize, usize, f64)> + use<> {
        let ends = |(first, second, t): Bracket| [(first, 1.0 - t), (second, t)];
        let across = ends(self.across);
        let along = ends(self.along).into_iter();
        let all = along.flat_map(move |(i, p)| across.map(|(k, q)| (i, k, p * q)));
        all.filter(|&(_, _, share)| share > 0.0)
    }

    /// Returns the greatest number of corners of the directions from which paths are interpolated;
    /// 0 if none are.
    pub(super) fn corners_between(&self) -> usize {
        let axes = &self.table.axes;
        let own = self.along.2 == 0.0 && self.across.2 == 0.0;
        let Some(exact) = self
            .table
            .exact
            .as_ref()
            .filter(|_| !own && !axes.is_mean())
        else {
            return 0;
        };
        let azimuths = self.azimuths_around();
        let stored = self.incidences_around().flat_map(|i| {
            let place = |&k: &usize| i * axes.azimuth_deg.len() + self.images[k].place;
            azimuths.iter().map(place).collect::<Vec<_>>()
        });
        let corners = |stored: usize| -> usize {
            let paths = exact.paths[stored].iter();
            paths.map(|path| path.polygon.len()).sum()
        };
        stored.map(corners).max().unwrap_or_default()
    }

    /// Returns the paths of a direction of the table, in the frame of image `k`.
    fn paths(&self, exact: &Exact, i: usize, k: usize) -> Option<Vec<Path>> {
        let image = &self.images[k];
        let stored = i * self.table.axes.azimuth_deg.len() + image.place;
        exact.paths.get(stored).map(|paths| image.seen_paths(paths))
    }

    /// Interpolates the paths from the corners of the cell and the directions next to them.
    fn paths_between(
        &self,
        exact: &Exact,
        incidence_deg: f64,
        azimuth_deg: f64,
    ) -> Option<Vec<Path>> {
        let index = self.table.provenance.refractive_index;
        let azimuth_rad = azimuth_deg.to_radians();
        let tau = self.tau(incidence_deg, azimuth_rad);
        between::paths(&self.nodes(exact)?, tau, azimuth_rad, index)
    }

    /// Returns tan(incidence inside the sheet) (cos azimuth, sin azimuth).
    pub(super) fn tau(&self, incidence_deg: f64, azimuth_rad: f64) -> [f64; 2] {
        let sine = incidence_deg.to_radians().sin() / self.table.provenance.refractive_index;
        let tangent = sine / (1.0 - sine * sine).sqrt();
        [azimuth_rad.cos(), azimuth_rad.sin()].map(|x| tangent * x)
    }

    /// Returns the corners of the cell and the directions next to them.
    pub(super) fn nodes(&self, exact: &Exact) -> Option<Vec<NearDirection>> {
        let incidences = &self.table.axes.incidence_deg;
        let around = self.incidences_around();
        let azimuths = self.azimuths_around();
        let mut nodes = Vec::new();
        for (i, &incidence_deg) in around.clone().zip(&incidences[around]) {
            for &k in &azimuths {
                let azimuth_rad = self.images[k].azimuth_deg.to_radians();
                nodes.push(NearDirection {
                    tau: self.tau(incidence_deg, azimuth_rad),
                    azimuth_rad,
                    paths: self.paths(exact, i, k)?,
                    share: share(self.along, i) * share(self.across, k),
                    corner: [i == self.along.1, k == self.across.1].map(|far| f64::from(far as u8)),
                });
            }
        }
        Some(nodes)
    }

    /// Returns the incidences at the cell's corners, and those next to them.
    fn incidences_around(&self) -> std::ops::RangeInclusive<usize> {
        let last = self.table.axes.incidence_deg.len() - 1;
        self.along.0.saturating_sub(1)..=(self.along.1 + 1).min(last)
    }

    /// Returns the images at the cell's corners, and the images next to them unless a wide gap lies
    /// between.
    fn azimuths_around(&self) -> Vec<usize> {
        let count = self.images.len();
        let widest = self.table.axes.widest_gap_deg() + SAME_DEG;
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
