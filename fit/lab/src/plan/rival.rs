//! How well photographs tell the right kernel from a wrong one, before they are taken.
//!
//! Light of the right kernel is fitted with the wrong one, with blur and lens free and each
//! photograph's nuisances projected out. What is left of chi-square without noise is D. With noise,
//! chi-square of the wrong kernel lies above that of the right one by D on average, and the
//! difference scatters by the variance 4 D + 2 tr((P - Q)^2). P and Q project on what either kernel
//! can describe near its optimum. Both have the same number of parameters, so Bayes' criterion
//! compares chi-square alone, and the one that is preferred wins unless the other is clearly better
//! ([`CLEAR`]).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

use crate::plan::Error;
use crate::plan::information::Candidate;
use crate::plan::seen::{Seen, Setup};
use crate::study::trial;
use edges::names::Kernel;
use edges::numerics::chance;
use estimator::compare::{Curves, Photograph as Pixels};
use estimator::estimate::{Aerial, CLEAR, Choice, Layout, model};

/// Steps of Gauss and Newton to the best fit of the wrong kernel. Most fits take three.
const STEPS: usize = 12;

/// Share of chi-square (and of 1) below which the next step's fall ends such a fit.
const CONVERGED: f64 = 1e-3;

/// Longest step of a logarithm, so that a linear forecast does not lead astray.
const LONGEST: f64 = 0.5;

/// Largest number of setups over which the wrong kernel is fitted before the photographs are chosen.
const SOME: usize = 6;

/// What photographs say for the right kernel against the wrong one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Apart {
    /// Kernel of the sheet.
    pub right: Kernel,
    /// Kernel that the photographs are to rule out.
    pub wrong: Kernel,
    /// Chi-square by which the wrong kernel is worse on average.
    pub chi2: Told,
    /// Probability that an estimate with both kernels names the right one.
    pub chance: Told,
}

/// A number over the beliefs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Told {
    /// In the middle of the beliefs.
    pub middle: f64,
    /// The least at the middle and the ends of the beliefs.
    pub least: f64,
}

/// A kernel with its parameters.
#[derive(Clone, Copy)]
pub(crate) struct Blurred<'a> {
    pub layout: &'a Layout,
    pub at: &'a DVector<f64>,
}

impl Seen<'_> {
    /// Returns the layout of the other kernel.
    pub(crate) fn other(&self, kernel: Kernel) -> Layout {
        let choice = Choice {
            kernel,
            ..self.layout.choice
        };
        Layout::new(choice, self.angles.len(), 1)
    }

    /// Returns where the search for the other kernel's parameters begins: the same c, and lobes that
    /// are as wide at the middle of the distances.
    pub(crate) fn first_guess(&self, at: &DVector<f64>) -> DVector<f64> {
        let distances = &self.plan.choices.floating_distance_mm;
        let middle = distances.iter().map(|r| r.ln()).sum::<f64>() / distances.len() as f64;
        let by = match self.layout.choice.kernel {
            Kernel::Angular => -middle,
            _ => middle,
        };
        let mut other = at.clone();
        other.rows_mut(1, at.len() - 1).add_scalar_mut(by);
        other
    }

    /// Returns the edge profile of a photograph under a kernel.
    fn curves(&self, shot: &Aerial, own: Blurred) -> Curves {
        let pixels = Pixels::new(&shot.pixels, self.camera.pitch_mm);
        let model = model(shot, own.layout.choice);
        let blur = own.layout.blur(own.at, self.place(shot));
        pixels.curves(
            Some((&model, blur)),
            &self.camera,
            &self.pattern.optics.free,
        )
    }

    /// Returns the products of all that a photograph tells of both kernels: parameters of the right
    /// one and the lens, those of the wrong one and the lens, and the difference between the two.
    fn products(&self, shot: &Aerial, right: &Curves, wrong: Blurred) -> DMatrix<f64> {
        let pixels = Pixels::new(&shot.pixels, self.camera.pitch_mm);
        let both = right.beside(self.curves(shot, wrong));
        let rows = pixels.foreseen(&both, self.levels(), trial::noise(&self.plan.camera));
        let own = self.columns(self.place(shot));
        let width = self.unknowns.blur;
        let places = own.iter().copied().chain(own.iter().map(|i| width + i));
        let places: Vec<usize> = places.chain([2 * width]).collect();
        let mut told = DMatrix::zeros(rows.nrows() - 1, 2 * width + 1);
        for (k, place) in places.into_iter().enumerate() {
            // The first row and the first column are those of the step.
            told.set_column(place, &rows.column(k + 1).rows(1, rows.nrows() - 1));
        }
        told.tr_mul(&told)
    }

    /// Returns the products of the source edge, which tells the lens under both kernels.
    fn source_products(&self) -> DMatrix<f64> {
        let width = self.unknowns.blur;
        let own = self.source().blur;
        let mut both = DMatrix::zeros(2 * width + 1, 2 * width + 1);
        for (row, column) in [(0, 0), (0, width), (width, 0), (width, width)] {
            both.view_mut((row, column), (width, width)).copy_from(&own);
        }
        both
    }

    /// Returns what a photograph tells of the wrong kernel: the products of its parameters, the lens
    /// and the difference to the right one.
    pub(crate) fn against(&self, shot: &Aerial, right: Blurred, wrong: Blurred) -> DMatrix<f64> {
        let all = self.products(shot, &self.curves(shot, right), wrong);
        let width = self.unknowns.blur;
        let own = all.view((width, width), (width + 1, width + 1));
        own.into_owned()
    }

    /// Returns the best fit of the wrong kernel to photographs of the right one: its parameters, and
    /// the products there.
    pub(crate) fn nearest(
        &self,
        shots: &[&Aerial],
        right: Blurred,
        wrong: &Layout,
        start: DVector<f64>,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let (width, source) = (self.unknowns.blur, self.source_products());
        let seen = shots.par_iter().map(|shot| self.curves(shot, right));
        let seen: Vec<Curves> = seen.collect();
        let mut at = start;
        let mut steps = 0..STEPS;
        loop {
            let own = Blurred {
                layout: wrong,
                at: &at,
            };
            let all = shots.par_iter().zip(&seen);
            let all = all.map(|(shot, right)| self.products(shot, right, own));
            let all: Vec<DMatrix<f64>> = all.collect();
            let sum = all.into_iter().fold(source.clone(), |sum, own| sum + own);
            let wrong = sum.view((width, width), (width + 1, width + 1));
            let (step, left) = solved(&wrong.into_owned());
            let fall = sum[(2 * width, 2 * width)] - left;
            if steps.next().is_none() || fall < CONVERGED * (1.0 + left) {
                return (at, sum);
            }
            at -= step.rows(0, at.len()).map(|v| v.clamp(-LONGEST, LONGEST));
        }
    }

    /// Returns the other kernel, and at each point of the beliefs the parameters with which it
    /// resembles the believed one most, over some of all setups.
    ///
    /// # Errors
    /// Returns the errors of [`Seen::shots`].
    pub(crate) fn resembling(
        &self,
        rival: Kernel,
        setups: &[(Setup, f64)],
    ) -> Result<(Layout, Vec<DVector<f64>>), Error> {
        let some = setups.iter().step_by(setups.len().div_ceil(SOME));
        let shots = some.map(|&(setup, _)| self.shots(setup));
        let shots: Vec<Vec<Aerial>> = shots.collect::<Result<_, Error>>()?;
        let shots: Vec<&Aerial> = shots.iter().flatten().collect();
        let other = self.other(rival);
        let nearest = self.points.par_iter().map(|point| {
            let at = self.at(point);
            let right = Blurred {
                layout: &self.layout,
                at: &at,
            };
            self.nearest(&shots, right, &other, self.first_guess(&at)).0
        });
        let nearest = nearest.collect();
        Ok((other, nearest))
    }

    /// Returns the chi-square by which the other kernel is worse in the middle of the beliefs; `None`
    /// if the plan names no other.
    ///
    /// # Errors
    /// Returns the errors of [`Seen::shots`].
    pub(crate) fn chi2(&self, chosen: &[&Candidate]) -> Result<Option<f64>, Error> {
        let Some((other, resembling)) = &self.rival else {
            return Ok(None);
        };
        let shots = self.all(chosen)?;
        let shots: Vec<&Aerial> = shots.iter().collect();
        let at = self.at(&self.points[0]);
        let right = Blurred {
            layout: &self.layout,
            at: &at,
        };
        let (_, sum) = self.nearest(&shots, right, other, resembling[0].clone());
        Ok(Some(left(&sum, self.unknowns.blur)))
    }

    /// Returns the photographs of some candidates.
    fn all(&self, chosen: &[&Candidate]) -> Result<Vec<Aerial>, Error> {
        chosen.iter().map(|own| self.shot(own)).collect()
    }

    /// Judges photographs at each point of the beliefs: with the believed kernel right, then with
    /// the other one right, where it resembles the believed one most.
    pub(crate) fn judged(&self, chosen: &[&Candidate]) -> Result<Vec<Apart>, Error> {
        let Some((other, starts)) = &self.rival else {
            return Ok(Vec::new());
        };
        let shots = self.all(chosen)?;
        let shots: Vec<&Aerial> = shots.iter().collect();
        let points = self.points.par_iter().zip(starts).map(|(point, start)| {
            let believed = self.at(point);
            let own = Blurred {
                layout: &self.layout,
                at: &believed,
            };
            let (at, sum) = self.nearest(&shots, own, other, start.clone());
            let resembling = Blurred {
                layout: other,
                at: &at,
            };
            let (_, back) = self.nearest(&shots, resembling, &self.layout, believed.clone());
            [sum, back]
        });
        let points: Vec<[DMatrix<f64>; 2]> = points.collect();
        let kernels = [self.layout.choice.kernel, other.choice.kernel];
        let judged = [0, 1].map(|i| {
            let [right, wrong] = [kernels[i], kernels[1 - i]];
            let all = points.iter().map(|sums| against(&sums[i], right, wrong));
            let all: Vec<[f64; 2]> = all.collect();
            let told = |k: usize| Told {
                middle: all[0][k],
                least: all.iter().map(|own| own[k]).fold(f64::INFINITY, f64::min),
            };
            Apart {
                right,
                wrong,
                chi2: told(0),
                chance: told(1),
            }
        });
        Ok(judged.to_vec())
    }
}

/// Writes a chi-square for a reader.
pub fn chi_square(value: f64) -> String {
    if value < 1e5 {
        format!("{value:.1}")
    } else {
        format!("{value:.1e}")
    }
}

/// Returns D and the probability that the right kernel is named, from the products of both.
fn against(sum: &DMatrix<f64>, right: Kernel, wrong: Kernel) -> [f64; 2] {
    let width = sum.nrows() / 2;
    let part = |row, column| sum.view((row, column), (width, width)).into_owned();
    let left = left(sum, width);
    let [own, other] = [part(0, 0), part(width, width)].map(|own| inverted(&own));
    let shared = (&own.0 * part(0, width) * &other.0 * part(width, 0)).trace();
    let apart = (own.1 + other.1) as f64 - 2.0 * shared;
    let rank = |kernel| Kernel::ALL.iter().position(|&own| own == kernel);
    let limit = match rank(right) < rank(wrong) {
        true => -CLEAR,
        false => CLEAR,
    };
    let scatter = (4.0 * left + 2.0 * apart.max(0.0)).sqrt();
    [left, chance::of_normal((left - limit) / scatter)]
}

/// Returns the chi-square that a fit of the wrong kernel leaves, from the products of its parameters,
/// which begin at `first`, and of the difference.
pub(crate) fn left(products: &DMatrix<f64>, first: usize) -> f64 {
    let size = products.nrows() - first;
    solved(&products.view((first, first), (size, size)).into_owned()).1
}

/// Returns the parameters' change to the least squares, which is to be subtracted, and what is then
/// left.
fn solved(products: &DMatrix<f64>) -> (DVector<f64>, f64) {
    let n = products.nrows() - 1;
    let normal = products.view((0, 0), (n, n)).into_owned();
    let gradient = products.view((0, n), (n, 1)).column(0).into_owned();
    let step = inverted(&normal).0 * &gradient;
    let left = products[(n, n)] - gradient.dot(&step);
    (step, left.max(0.0))
}

/// Inverts a normal matrix, and counts the unknowns that are told. The others, as those of an
/// incidence without a photograph, have zeros.
fn inverted(normal: &DMatrix<f64>) -> (DMatrix<f64>, usize) {
    let n = normal.nrows();
    let told: Vec<usize> = (0..n).filter(|&i| normal[(i, i)] > 0.0).collect();
    let kept = normal.select_rows(&told).select_columns(&told);
    let mut all = DMatrix::zeros(n, n);
    if let Some(inverse) = kept.cholesky().map(|own| own.inverse()) {
        for (i, &a) in told.iter().enumerate() {
            for (j, &b) in told.iter().enumerate() {
                all[(a, b)] = inverse[(i, j)];
            }
        }
    }
    (all, told.len())
}
