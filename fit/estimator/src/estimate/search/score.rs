//! The score of further blurs: what one evaluation tells of blurs that a candidate does not have.
//!
//! At the optimum of the candidate, a step of Gauss and Newton along their columns tells by how much
//! they would lower the sum of squares.

use nalgebra::{DMatrix, DVector};

use crate::estimate::scene::Scene;
use crate::estimate::search::layout::{Choice, Layout};
use crate::estimate::search::loss::Loss;
use crate::model::{Further, OwnBlur};
use edges::names::Kernel;

/// Share of a column's square that has to be left after the other columns are projected out. Below
/// it the photographs do not tell the blur from the other parameters.
const INDEPENDENT: f64 = 1e-8;

/// Least singular value of the normal matrix of unit columns that counts: rounding is a hundredth of
/// it.
const UNNOTICED: f64 = 1e-13;

/// Returns the further blurs that a candidate may have. Without a reference the lens is free
/// already. The facets of a baseline spread the light as dihedral errors do. Dihedral errors need a
/// table that says which cubes its light belongs to.
pub(crate) fn possible(scene: &Scene, kernel: Kernel) -> Further {
    let shifts = kernel.shifts_rays() && !kernel.has_waves() && !kernel.is_baseline();
    let mut shots = scene.shots.iter();
    Further {
        own_blur: match scene.distances_mm.len() {
            _ if scene.reference.is_none() || kernel.is_baseline() => OwnBlur::None,
            1 => OwnBlur::Shared,
            _ => OwnBlur::PerDistance,
        },
        angular_spread: !kernel.is_baseline(),
        common_errors: shifts && shots.all(|shot| shot.direction.bent().is_some()),
    }
}

/// Information on further blurs that a candidate does not have, at one point. Their columns come in
/// the order of [`Layout`], with an own blur of each distance, whose sum is that of all photographs.
pub(crate) struct Score {
    /// Blurs of the columns.
    further: Further,
    /// Information, with the parameters of the candidate projected out.
    information: DMatrix<f64>,
    /// Columns times residuals, projected likewise.
    pull: DVector<f64>,
    /// Products of the columns before the projection.
    whole: DMatrix<f64>,
    /// Changes of the parameters of the candidate by the columns, at the least sum of squares.
    response: DMatrix<f64>,
    /// Number of floating distances.
    distances: usize,
}

impl Score {
    /// Evaluates the score of a candidate along those of the blurs `asked` that it may have and does
    /// not have. `at` holds its parameters, with those of the lens if the loss has them. Returns
    /// `None` if there is no such blur, or if the photographs do not determine its parameters.
    pub(crate) fn new(
        scene: &Scene,
        loss: &Loss,
        (choice, at): (Choice, &DVector<f64>),
        asked: Further,
    ) -> Option<Score> {
        let own = choice.further;
        let others = Further::ALL.without(asked).and(own);
        let further = possible(scene, choice.kernel).without(others);
        let choice = Choice {
            further: own.and(further),
            ..choice
        };
        let layout = Layout::of(choice, scene);
        let added = layout.columns_of(further);
        if added.is_empty() {
            return None;
        }
        let mut at = at.clone();
        for &column in &added {
            at = at.insert_row(column, 0.0);
        }
        let (residuals, jacobian) = loss.evaluate(&layout, &at);
        let columns = jacobian.select_columns(&added);
        let kept: Vec<usize> = (0..jacobian.ncols())
            .filter(|column| !added.contains(column))
            .collect();
        let mut known = jacobian.select_columns(&kept);
        let norms: Vec<f64> = known.column_iter().map(|column| column.norm()).collect();
        for (mut column, norm) in known.column_iter_mut().zip(&norms) {
            if *norm > 0.0 {
                column /= *norm;
            }
        }
        // Parameters that the photographs do not notice, or do not tell from others, have no part
        // in the projection.
        let inverse = known.tr_mul(&known).pseudo_inverse(UNNOTICED).ok()?;
        let cross = known.tr_mul(&columns);
        let information = columns.tr_mul(&columns) - cross.tr_mul(&(&inverse * &cross));
        let pull =
            columns.tr_mul(&residuals) - cross.tr_mul(&(&inverse * known.tr_mul(&residuals)));
        let mut response = -(&inverse * &cross);
        for (mut row, norm) in response.row_iter_mut().zip(&norms) {
            row /= norm.max(f64::MIN_POSITIVE);
        }
        let finite = |v: &f64| v.is_finite();
        let is_finite = information.iter().all(finite) && pull.iter().all(finite);
        is_finite.then(|| Score {
            further,
            whole: columns.tr_mul(&columns),
            information,
            pull,
            response,
            distances: scene.distances_mm.len(),
        })
    }

    /// Returns the parameters of some of the blurs as sums of columns, or `None` if one of them has none.
    fn sums(&self, wanted: Further) -> Option<DMatrix<f64>> {
        if !wanted.are_among(self.further) {
            return None;
        }
        let distances = self.further.own_blur.count(self.distances);
        let mut sums = DMatrix::zeros(self.pull.len(), wanted.count(self.distances));
        for distance in 0..distances {
            if let Some(column) = wanted.own_blur.of(distance) {
                sums[(distance, column)] = 1.0;
            }
        }
        let spread = usize::from(self.further.angular_spread);
        let errors = self.pull.len() - distances - spread;
        let spread = std::iter::repeat_n(wanted.angular_spread, spread);
        let others = spread.chain(std::iter::repeat_n(wanted.common_errors, errors));
        let rows = (distances..)
            .zip(others)
            .filter(|&(_, is_wanted)| is_wanted);
        for ((row, _), column) in rows.zip(wanted.own_blur.count(self.distances)..) {
            sums[(row, column)] = 1.0;
        }
        Some(sums)
    }

    /// Returns the changes of the parameters of the candidate by those of some of the blurs, at the
    /// least sum of squares, or `None` if one of the blurs has no column.
    pub(super) fn response(&self, wanted: Further) -> Option<DMatrix<f64>> {
        Some(&self.response * self.sums(wanted)?)
    }

    /// Returns the standard error of one dihedral error of all edges, mrad; `None` without errors.
    pub(crate) fn equal_errors(&self) -> Option<f64> {
        let sums = self.sums(Further::COMMON_ERRORS)?;
        let information = (sums.tr_mul(&self.information) * sums).sum();
        (information > 0.0).then(|| information.sqrt().recip())
    }

    /// Returns the fall of the sum of squares by a step along some of the blurs, and the parameters
    /// at its end, each with its standard error. Returns `None` if the photographs do not tell the
    /// blurs apart, or from the other parameters.
    pub(super) fn step(&self, wanted: Further) -> Option<(f64, Vec<[f64; 2]>)> {
        let sums = self.sums(wanted)?;
        let n = sums.ncols();
        let information = sums.tr_mul(&self.information) * &sums;
        let whole = sums.tr_mul(&self.whole) * &sums;
        let pull = sums.tr_mul(&self.pull);
        // The share of a column that neither the parameters nor the other blur explains.
        let inverse = information.try_inverse()?;
        let told = |i: usize| {
            let left = inverse[(i, i)].recip();
            left > INDEPENDENT * whole[(i, i)]
        };
        if !(0..n).all(told) {
            return None;
        }
        let step = &inverse * &pull;
        let parameters = (0..n).map(|i| [-step[i], inverse[(i, i)].sqrt()]);
        Some((pull.dot(&step), parameters.collect()))
    }
}
