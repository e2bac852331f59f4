//! The azimuth of the sheet if the captures do not know it: one angle, added to the azimuths of all
//! captures.
//!
//! The profile of the azimuth is the least whitened sum of squares of the MTFs over all other
//! parameters. It has several minima. So it is evaluated all around the table's period, and the
//! lowest minima are refined. The curvature of the profile gives the standard error. The part of
//! the other parameters' covariance that stems from the azimuth is added afterwards, from fits at
//! one standard error to either side.

use nalgebra::DMatrix;
use tables::Table;

use crate::error::Error;
use crate::estimate::progress::{Progress, Step};
use crate::estimate::scene::Scene;
use crate::estimate::search::fitted::estimate;
use crate::estimate::search::layout::{Choice, Value};
use crate::estimate::search::loss::{Kind, Loss};
use crate::estimate::search::optimum::{Optimum, optimum, refined};
use crate::model::Further;
use edges::names::Kernel;
use edges::names::LobeShape;

/// Step of the first search, degrees. Minima of the profile of a cube are at least 30 degrees
/// apart.
const STEP_DEG: f64 = 5.0;

/// Width to which a minimum is found, degrees. It is far below the error of any photographs.
const FOUND_DEG: f64 = 1e-3;

/// Largest number of minima that are refined.
const MINIMA: usize = 4;

/// Rise of the sum of squares, in units of the misfit, below which another minimum fits as well as
/// the lowest: two standard deviations.
const AS_WELL: f64 = 4.0;

/// Azimuth of the sheet as estimated from the photographs.
#[derive(Debug, Clone, PartialEq)]
pub struct Azimuth {
    /// Angle to add to the captures' azimuths, degrees, from 0 to below [`Azimuth::period_deg`].
    pub deg: Value,
    /// Period of the azimuth, degrees: azimuths that differ by it cannot be told apart. It is 360,
    /// or less by the symmetry that the table records.
    pub period_deg: f64,
    /// Other azimuths that fit as well, degrees.
    pub others_deg: Vec<f64>,
}

/// Profile of the azimuth, evaluated from place to place.
struct Profile<'a> {
    scene: &'a Scene,
    table: &'a Table,
    /// Azimuths of the captures, degrees.
    azimuths_deg: Vec<f64>,
    choice: Choice,
    /// Last fit, from which the next one starts.
    last: Option<Optimum>,
}

impl Profile<'_> {
    /// Returns the scene with all azimuths increased by `deg`.
    ///
    /// # Errors
    /// Fails if the table neither holds nor brackets one of the directions.
    fn turned(&self, deg: f64) -> Result<Scene, tables::Error> {
        let turned: Vec<f64> = self.azimuths_deg.iter().map(|own| own + deg).collect();
        self.scene.turned(self.table, &turned)
    }

    /// Returns the least sum of squares at an azimuth. It is infinite if a photograph has no light
    /// there.
    ///
    /// # Errors
    /// Fails if the table neither holds nor brackets one of the directions.
    fn squares(&mut self, deg: f64) -> Result<f64, tables::Error> {
        let scene = self.turned(deg)?;
        if !scene.is_lit() {
            return Ok(f64::INFINITY);
        }
        let fit = match self.last.take() {
            Some(last) => refined(&scene, &Loss::Mtf(&scene), last),
            None => optimum(&scene, self.choice),
        };
        let squares = fit.solution.sum_of_squares();
        self.last = Some(fit);
        Ok(if squares.is_finite() {
            squares
        } else {
            f64::INFINITY
        })
    }

    /// Finds the minimum between two azimuths by golden-section search. Returns azimuth and sum of
    /// squares.
    ///
    /// # Errors
    /// Fails if the table neither holds nor brackets one of the directions.
    fn minimum(&mut self, mut low: f64, mut high: f64) -> Result<(f64, f64), tables::Error> {
        let part = 0.5 * (5_f64.sqrt() - 1.0);
        let (mut a, mut b) = (high - part * (high - low), low + part * (high - low));
        let (mut at_a, mut at_b) = (self.squares(a)?, self.squares(b)?);
        while high - low > FOUND_DEG {
            if at_a < at_b {
                (high, b, at_b) = (b, a, at_a);
                a = high - part * (high - low);
                at_a = self.squares(a)?;
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = low + part * (high - low);
                at_b = self.squares(b)?;
            }
        }
        Ok(if at_a < at_b { (a, at_a) } else { (b, at_b) })
    }
}

/// Returns the candidate for the search. In it a and mu differ by incidence, so that the azimuth
/// does not compensate for such differences.
pub(crate) fn flexible(scene: &Scene) -> Choice {
    let several = scene.groups.len() > 1;
    Choice {
        kernel: Kernel::Eq1,
        shape: LobeShape::Radial,
        per_angle_a: several,
        per_angle_mu: several,
        further: Further::NONE,
    }
}

/// Checks that a table tells azimuths apart.
///
/// # Errors
/// Returns [`Error::OneAzimuth`] if the table is a mean over azimuths or holds only one.
fn check(table: &Table) -> Result<(), Error> {
    let held = if table.axes.is_mean() {
        "it is a mean over all azimuths"
    } else if table.axes.azimuth_deg.len() < 2 {
        "it holds only one"
    } else {
        return Ok(());
    };
    Err(Error::OneAzimuth(held))
}

/// Finds the azimuth under `choice`. Returns it with the scene at this azimuth.
///
/// # Errors
/// Returns [`Error::OneAzimuth`] if the table is a mean over azimuths or holds only one,
/// [`Error::Table`] if its azimuths do not go all around, and [`Error::Cancelled`] if the flag of
/// `progress` is set.
pub fn find(
    scene: &Scene,
    table: &Table,
    choice: Choice,
    progress: &Progress,
) -> Result<(Azimuth, Scene), Error> {
    check(table)?;
    let period = 360.0 / f64::from(table.provenance.symmetry.rotations);
    let observations = Loss::Mtf(scene).observations();
    let mut profile = Profile {
        scene,
        table,
        azimuths_deg: scene.azimuths_deg(),
        choice,
        last: None,
    };
    let steps = (period / STEP_DEG).ceil() as usize;
    let step = period / steps as f64;
    let of = steps + MINIMA;
    let mut around = Vec::with_capacity(steps);
    for k in 0..steps {
        around.push(profile.squares(k as f64 * step)?);
        progress.done(Step::Azimuths { done: k + 1, of })?;
    }
    let mut lows: Vec<usize> = (0..steps)
        .filter(|&k| {
            let beside = [around[(k + steps - 1) % steps], around[(k + 1) % steps]];
            beside.iter().all(|&other| around[k] <= other)
        })
        .collect();
    lows.sort_by(|&a, &b| around[a].total_cmp(&around[b]));
    let mut minima = Vec::new();
    for low in lows.into_iter().take(MINIMA) {
        let middle = low as f64 * step;
        minima.push(profile.minimum(middle - step, middle + step)?);
        let done = steps + minima.len();
        progress.done(Step::Azimuths { done, of })?;
    }
    minima.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (best, least) = minima.first().copied().unwrap_or((0.0, f64::INFINITY));
    let misfit = (least / observations.max(1) as f64).max(1.0);
    // At one standard error the profile has risen by the misfit. The curvature is measured near
    // there.
    let mut error = 0.5;
    for _ in 0..3 {
        let sides = [
            profile.squares(best - error)?,
            profile.squares(best + error)?,
        ];
        let rise = 0.5 * (sides[0] + sides[1]) - least;
        let next = error * (misfit / rise.max(1e-6 * misfit)).sqrt();
        error = next.clamp(1e-3, 0.25 * period);
    }
    let others = minima[1.min(minima.len())..]
        .iter()
        .filter(|(deg, squares)| {
            let apart = (deg - best).rem_euclid(period);
            squares - least < AS_WELL * misfit && apart.min(period - apart) > error
        });
    let found = Azimuth {
        deg: Value {
            value: best.rem_euclid(period),
            standard_error: error,
        },
        period_deg: period,
        others_deg: others.map(|(deg, _)| deg.rem_euclid(period)).collect(),
    };
    Ok((found, profile.turned(best)?))
}

/// Returns the covariance that the error of the azimuth adds to the logarithms of all parameters.
/// The scene must be at the azimuth `found`.
///
/// # Errors
/// Fails if the table neither holds nor brackets one of the directions.
pub fn scatter(
    scene: &Scene,
    table: &Table,
    found: &Azimuth,
    kind: Kind,
    choice: Choice,
) -> Result<DMatrix<f64>, tables::Error> {
    let own = scene.azimuths_deg();
    let mut sides = Vec::new();
    for side in [-1.0, 1.0] {
        let by = side * found.deg.standard_error;
        let turned: Vec<f64> = own.iter().map(|own| own + by).collect();
        let scene = &scene.turned(table, &turned)?;
        let near = optimum(scene, choice);
        let loss = Loss::new(kind, scene, (choice, &near.solution.parameters));
        let fit = estimate(scene, &loss, refined(scene, &loss, near));
        sides.push(fit.coordinates());
    }
    let half: Vec<f64> = sides[0]
        .iter()
        .zip(&sides[1])
        .map(|(a, b)| 0.5 * (b - a))
        .collect();
    Ok(DMatrix::from_fn(half.len(), half.len(), |i, j| {
        half[i] * half[j]
    }))
}
