//! Comparison of two tables, direction by direction.
//!
//! It says how much the tables differ, and whether their errors explain the difference. Of two
//! exact tables the polygons are compared, because `fit` computes with them and not with the
//! histogram: path by path, and where the paths are cut differently, by their regions. Exit
//! directions are compared where at least one of the tables counted them.

use crate::cell::MEAN_ERROR;
use crate::run::cuts::uncut;
use crate::run::exits::{ABSOLUTE, ExitGap, exits};
use crate::run::paths::{SAME, apart};
use ndarray::{Array2, Axis, s};
use tables::{Fate, Table};

/// Number of standard errors by which shares of random counts may differ. A normal variable is
/// beyond them once in 1.7 million times.
const SIGMAS: f64 = 5.0;

/// Number of standard errors of random counts by which shares of low-discrepancy counts may differ.
///
/// The variance of a scrambled net in base 2 is at most e times that of random points (Owen 1997),
/// and 5 sqrt(e) is 8.2. It holds by the standard error that their randomisations give too: of 16,
/// Student's t with 15 degrees of freedom is beyond 8 once in a million times.
const SIGMAS_OF_NETS: f64 = 8.2;

/// Least number of randomisations whose standard error is taken.
const KNOWN: usize = 16;

/// Number of standard deviations beyond the mean that counting explains of an L1 distance; the
/// bound is that of [`crate::run::exits`]: once in 65 million times.
const SIGMAS_OF_L1: f64 = 6.0;

/// Largest difference that rounding explains.
const ROUNDING: f64 = 1e-9;

/// Comparison of two tables with equal axes, direction by direction.
pub struct Comparison {
    /// Differences of the tables by direction, incidence slow, azimuth fast.
    pub rows: Vec<Difference>,
}

/// Difference of two tables in one direction.
pub struct Difference {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; NaN for the mean over all azimuths.
    pub azimuth_deg: f64,
    /// Sum over the bins of the absolute differences of probability (L1 distance).
    pub l1: f64,
    /// Largest absolute difference of probability of a bin.
    pub largest: f64,
    /// Difference of the retroreflected fractions: the second less the first.
    pub eta: f64,
    /// Difference of the retroreflected fractions in standard errors; `None` if both tables are
    /// exact, so that they have none.
    pub sigmas: Option<f64>,
    /// L1 distance that the counting errors of both tables explain.
    pub noise: f64,
    /// Largest difference of what was counted, in units of what counting and rounding explain.
    ///
    /// Compared are eta, the share of every fate, and the histograms, as they are and with 2 x 2, 4
    /// x 4 and more of their bins taken together. So few rays cannot hide a wrong distribution.
    pub counted: f64,
    /// Difference of the light of two exact tables; `None` unless both have polygons of this
    /// direction, and where one of them was unfolded.
    ///
    /// It is the largest difference of their polygons, maps, weights and deviations, path by path,
    /// or, if that is less, the mean distance of the outlines of equal light, edge lengths. The
    /// latter does not depend on the polygons into which a region is cut.
    pub paths: Option<f64>,
    /// Difference of the exit directions; `None` unless one table counted them and the other
    /// counted them on the same grid or has polygons.
    pub exits: Option<ExitGap>,
}

impl Comparison {
    /// Compares two tables.
    ///
    /// Where the azimuths of one stand for those of the other by symmetry, it is unfolded: rounding
    /// of a mesh may have hidden a symmetry of its cell. Then polygons are not compared, because a
    /// rotation may carry the cubes of a cell to other places.
    ///
    /// # Errors
    /// Returns a sentence that names the axis if the two tables differ in their incidences, their
    /// azimuths or their histogram bins.
    pub fn new(a: &Table, b: &Table) -> Result<Self, &'static str> {
        // Bits are compared, so that NaN (the mean over azimuths) equals itself.
        let same = |a: &[f64], b: &[f64]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
        };
        if !same(&a.axes.incidence_deg, &b.axes.incidence_deg) {
            return Err("the incidence angles differ");
        }
        if (a.axes.bins, a.axes.range.to_bits()) != (b.axes.bins, b.axes.range.to_bits()) {
            return Err("the histogram bins differ");
        }
        if same(&a.axes.azimuth_deg, &b.axes.azimuth_deg) {
            return Ok(Comparison::of(a, b));
        }
        // Each must know all azimuths of the other, so that no direction is left out.
        let both = [
            a.unfolded(&b.axes.azimuth_deg),
            b.unfolded(&a.axes.azimuth_deg),
        ];
        let more_of_b = b.axes.azimuth_deg.len() > a.axes.azimuth_deg.len();
        match both {
            [Some(unfolded), Some(_)] if more_of_b => Ok(Comparison::of(&unfolded, b).unplaced()),
            [Some(_), Some(unfolded)] => Ok(Comparison::of(a, &unfolded).unplaced()),
            _ => Err(
                "the azimuths differ (with --azimuth full they may, where rounding of a mesh hides \
                a symmetry: list the azimuths)",
            ),
        }
    }

    /// Compares two tables whose axes are known to be equal.
    pub(crate) fn of(a: &Table, b: &Table) -> Self {
        let row = |((i, j), &eta): ((usize, usize), &f64)| {
            let at = (i, j);
            let pairs = [in_range(a, at), in_range(b, at)];
            let difference = (&pairs[0] - &pairs[1]).mapv(f64::abs);
            let other = b.retroreflected[[i, j]];
            let gap = (eta - other).abs();
            // Of random counts, a bin of probability p differs by [`ABSOLUTE`] sqrt(p/na + p/nb)
            // on average. Counts of a low-discrepancy sequence differ less.
            let share = |rays: u64| if rays == 0 { 0.0 } else { 1.0 / rays as f64 };
            let per_ray = share(a.rays[[i, j]]) + share(b.rays[[i, j]]);
            // Where all rays came back, or none, the standard error is 0. But the fraction is known
            // no better than to one ray.
            let error = a.standard_error[[i, j]]
                .hypot(b.standard_error[[i, j]])
                .max(per_ray);
            Difference {
                incidence_deg: a.axes.incidence_deg[i],
                azimuth_deg: a.axes.azimuth_deg[j],
                l1: difference.sum(),
                largest: difference.iter().copied().fold(0.0, f64::max),
                eta: other - eta,
                sigmas: (error > 0.0).then(|| if gap <= 1e-12 { 0.0 } else { gap / error }),
                noise: noise(&pairs, per_ray),
                counted: Counting::new([a, b], at, per_ray).largest(&pairs),
                paths: paths(a, b, (i, j)),
                exits: exits(a, b, (i, j)),
            }
        };
        Comparison {
            rows: a.retroreflected.indexed_iter().map(row).collect(),
        }
    }

    /// Leaves polygons out, whose places differ.
    fn unplaced(mut self) -> Self {
        self.rows.iter_mut().for_each(|row| row.paths = None);
        self
    }

    /// Returns whether the two tables agree in every direction.
    ///
    /// [`Difference::agrees`] says what that means.
    pub fn agrees(&self) -> bool {
        self.rows.iter().all(Difference::agrees)
    }
}

impl Difference {
    /// Returns whether the two tables agree in this direction.
    ///
    /// They agree if [`Difference::counted`] is at most 1, the exit directions are within
    /// [`ExitGap::limit`], and polygons agree to 1e-9.
    pub fn agrees(&self) -> bool {
        self.counted <= 1.0
            && self.paths.is_none_or(|apart| apart <= SAME)
            && self.exits.is_none_or(|gap| gap.l1 <= gap.limit)
    }
}

/// Differences of shares and histograms of two tables in one direction that counting explains.
struct Counting<'a> {
    tables: [&'a Table; 2],
    at: (usize, usize),
    /// Sum of 1 / rays of both tables.
    per_ray: f64,
    /// Difference that is explained without counting.
    exact: f64,
    /// Number of standard errors of random counts.
    sigmas: f64,
}

impl<'a> Counting<'a> {
    fn new(tables: [&'a Table; 2], at: (usize, usize), per_ray: f64) -> Self {
        let random = |table: &Table| table.counts.is_none() || table.provenance.is_random();
        let averaged = |table: &&Table| table.counts.is_none() && table.axes.is_mean();
        Counting {
            tables,
            at,
            per_ray,
            exact: ROUNDING
                + MEAN_ERROR * tables.iter().filter(|table| averaged(table)).count() as f64,
            sigmas: match tables.into_iter().all(random) {
                true => SIGMAS,
                false => SIGMAS_OF_NETS,
            },
        }
    }

    /// Returns the largest difference in units of what is explained; `bins` are the probabilities
    /// of both tables.
    fn largest(&self, bins: &[Array2<f64>; 2]) -> f64 {
        let [a, b] = self.tables;
        let (i, j) = self.at;
        let etas = [a, b].map(|table| table.retroreflected[[i, j]]);
        let mut largest = (etas[0] - etas[1]).abs() / self.of_eta(etas);
        let common = a.fates().len().min(b.fates().len());
        let [of_a, of_b] = [a, b].map(|table| fates(table, self.at, common));
        for (p, q) in of_a.into_iter().zip(of_b) {
            largest = largest.max((p - q).abs() / self.of(self.sigmas * self.error([p, q])));
        }
        let mut bins = bins.clone();
        loop {
            let l1 = (&bins[0] - &bins[1]).mapv(f64::abs).sum();
            let mass = f64::midpoint(bins[0].sum(), bins[1].sum());
            let beyond = SIGMAS_OF_L1 * (mass * self.per_ray).sqrt();
            // Where a bin holds less than some rays, the mean distance is up to 1.14 times that of
            // a normal variable.
            largest = largest.max(l1 / self.of(1.5 * noise(&bins, self.per_ray) + beyond));
            if !bins[0].nrows().is_multiple_of(2) {
                return largest;
            }
            bins = bins.map(|bins| {
                let quarter = |v, u| bins.slice(s![v..;2, u..;2]).to_owned();
                quarter(0, 0) + quarter(0, 1) + quarter(1, 0) + quarter(1, 1)
            });
        }
    }

    /// Returns what is explained, if counting explains so much of it.
    fn of(&self, counting: f64) -> f64 {
        counting + self.per_ray + self.exact
    }

    /// Returns the standard error of the difference of two shares by random counts.
    fn error(&self, shares: [f64; 2]) -> f64 {
        let share = f64::midpoint(shares[0], shares[1]);
        (share * (1.0 - share) * self.per_ray).max(0.0).sqrt()
    }

    /// Returns the difference of two eta that is explained.
    fn of_eta(&self, etas: [f64; 2]) -> f64 {
        let (i, j) = self.at;
        let stated =
            self.tables[0].standard_error[[i, j]].hypot(self.tables[1].standard_error[[i, j]]);
        let known = |table: &Table| match &table.fate_counts {
            None => true,
            Some(_) if table.provenance.is_random() => true,
            Some(fates) => {
                let each = fates.slice(s![i, j, .., ..]);
                each.axis_iter(Axis(0))
                    .filter(|fates| fates.sum() > 0)
                    .count()
                    >= KNOWN
            }
        };
        let random = self.error(etas);
        let error = match self.tables.iter().all(|table| known(table)) {
            true => stated.min(random),
            false => random,
        };
        self.of(self.sigmas * error)
    }
}

/// Returns the first `common` fates of a direction. Older tables count the light of the others as
/// absorbed.
fn fates(table: &Table, (i, j): (usize, usize), common: usize) -> Vec<f64> {
    let mut shares = table.fate.slice(s![i, j, ..]).to_vec();
    let more: f64 = shares.drain(common..).sum();
    shares[Fate::Absorbed as usize] += more;
    shares
}

/// Returns the L1 distance of the probabilities of bins that counting explains on average.
fn noise(bins: &[Array2<f64>; 2], per_ray: f64) -> f64 {
    let pairs = bins[0].iter().zip(&bins[1]);
    ABSOLUTE
        * pairs
            .map(|(&p, &q)| (f64::midpoint(p, q) * per_ray).sqrt())
            .sum::<f64>()
}

/// Returns the probability per launched ray of each bin, `[v, u]`.
///
/// [`Table::probability`] spreads light that is out of range over the bins. Its counts have no
/// noise there, so a comparison leaves it out.
fn in_range(table: &Table, (i, j): (usize, usize)) -> Array2<f64> {
    let share = table.fate[[i, j, Fate::Retroreflected as usize]];
    table.histogram.slice(s![i, j, .., ..]).mapv(|p| p * share)
}

/// Returns how far the light of two exact tables is apart in one direction.
fn paths(a: &Table, b: &Table, (i, j): (usize, usize)) -> Option<f64> {
    let at = i * a.axes.shape().1 + j;
    let of = |table: &Table| Some(table.exact.as_ref()?.paths.get(at)?.clone());
    (!a.axes.is_mean()).then_some(())?;
    let (a, b) = (of(a)?, of(b)?);
    let in_pairs = apart(&a, &b);
    Some(if in_pairs <= SAME {
        in_pairs
    } else {
        in_pairs.min(uncut(&a, &b))
    })
}
