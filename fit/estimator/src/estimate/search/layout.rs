//! The parameters of a candidate, and their order in the solver's vector: [ln c] [ln spread ...]
//! [own blur ...] [angular spread] [three dihedral errors]. The two blurs are variances, in mm^2 and
//! mrad^2, the errors are in mrad.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::estimate::scene::{Place, Scene};
use crate::model::Blur;
use crate::model::Further;
use edges::names::{Kernel, LobeShape};

/// Candidate: the terms of its blur, and which parameters have one value per incidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// Kernel: the terms of the blur.
    pub kernel: Kernel,
    /// Shape of the lobe.
    pub shape: LobeShape,
    /// True for one spread per incidence, false for one spread for all.
    pub per_angle_a: bool,
    /// True for one mu per incidence, false for one mu for all.
    pub per_angle_mu: bool,
    /// Blurs beside the kernel.
    pub further: Further,
}

/// Standard deviation of a dihedral error that is expected beforehand, mrad: that of poor sheets.
///
/// Photographs of edges in one direction tell one combination of the three errors, and those of two
/// directions two. So errors that are not told from one another stay finite.
const EXPECTED_MRAD: f64 = 1.0;

/// A number and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// Estimated value.
    pub value: f64,
    /// Standard deviation that pixel noise causes, carried through the estimator, the camera and
    /// the plateaus.
    pub standard_error: f64,
}

/// Returns a logarithm (of mm or 1/mm) between -14 and 14. Beyond these limits the model no longer
/// changes. They keep a step that runs away finite.
fn within(logarithm: f64) -> f64 {
    logarithm.clamp(-14.0, 14.0)
}

/// Order of one candidate's parameters.
pub struct Layout {
    /// Candidate that has these parameters.
    pub choice: Choice,
    /// Number of spreads: 0, 1, or one per incidence.
    pub spreads: usize,
    /// Number of own blurs: 0, 1, or one per distance.
    own_blurs: usize,
}

impl Layout {
    /// Makes the layout of a candidate in a scene.
    pub fn of(choice: Choice, scene: &Scene) -> Layout {
        Layout::new(choice, scene.groups.len(), scene.distances_mm.len())
    }

    /// Makes the layout of a candidate with `groups` incidences and so many floating distances.
    pub fn new(choice: Choice, groups: usize, distances: usize) -> Layout {
        let spreads = match (choice.kernel.has_lobe(), choice.per_angle_a) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => groups,
        };
        Layout {
            choice,
            spreads,
            own_blurs: choice.further.own_blur.count(distances),
        }
    }

    /// Returns the column of ln c, or `None` if the kernel has no c.
    pub fn c(&self) -> Option<usize> {
        self.choice.kernel.has_c().then_some(0)
    }

    /// Returns the column of ln spread for an incidence, or `None` if the kernel has no lobe.
    pub fn spread(&self, group: usize) -> Option<usize> {
        let first = usize::from(self.choice.kernel.has_c());
        (self.spreads > 0).then(|| first + if self.choice.per_angle_a { group } else { 0 })
    }

    /// Returns the index of mu for an incidence.
    pub fn mu_group(&self, group: usize) -> usize {
        if self.choice.per_angle_mu { group } else { 0 }
    }

    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        self.common_errors().end
    }

    /// Returns the number of parameters that are logarithms. They come before the others.
    pub fn logarithms(&self) -> usize {
        usize::from(self.choice.kernel.has_c()) + self.spreads
    }

    /// Returns the columns of the variances of own blurs; none if the candidate has none.
    pub fn own_blurs(&self) -> Range<usize> {
        let first = self.logarithms();
        first..first + self.own_blurs
    }

    /// Returns the column of the variance of the own blur at a distance, or `None` if there is none.
    fn own_blur(&self, distance: usize) -> Option<usize> {
        let own = self.choice.further.own_blur.of(distance)?;
        Some(self.logarithms() + own)
    }

    /// Returns the column of the variance of the angular spread, or `None` if the candidate has
    /// none.
    pub fn angular_spread(&self) -> Option<usize> {
        let further = self.choice.further;
        further.angular_spread.then_some(self.own_blurs().end)
    }

    /// Returns the columns of the dihedral errors at the edges 1, 2 and 3; none if the candidate has none.
    pub fn common_errors(&self) -> Range<usize> {
        let further = self.choice.further;
        let first = self.own_blurs().end + usize::from(further.angular_spread);
        first..first + 3 * usize::from(further.common_errors)
    }

    /// Returns the columns of further blurs.
    pub(crate) fn columns_of(&self, further: Further) -> Vec<usize> {
        let own = self.own_blurs().filter(|_| further.has_own_blur());
        let spread = self.angular_spread().filter(|_| further.angular_spread);
        let errors = self.common_errors().filter(|_| further.common_errors);
        own.chain(spread).chain(errors).collect()
    }

    /// Returns the blur of a photograph at these parameters.
    pub fn blur(&self, parameters: &DVector<f64>, place: Place) -> Blur {
        let at = |i: Option<usize>| i.map_or(1.0, |i| within(parameters[i]).exp());
        let variance = |i: Option<usize>| i.map_or(0.0, |i| parameters[i]);
        Blur {
            spread: at(self.spread(place.group)),
            c_mm: at(self.c()),
            own_blur_mm2: variance(self.own_blur(place.distance)),
            angular_spread_mrad2: variance(self.angular_spread()),
            errors_mrad: match self.common_errors() {
                errors if errors.is_empty() => [0.0; 3],
                errors => [0, 1, 2].map(|k| parameters[errors.start + k]),
            },
        }
    }

    /// Takes the blur's parameters back to where the model still depends on them.
    ///
    /// Their standard errors are then those at the limit, which are wide. Far beyond it c itself
    /// becomes 0, and so would its standard error.
    pub fn limit(&self, parameters: &mut DVector<f64>) {
        let blur = parameters.iter_mut().take(self.logarithms());
        blur.for_each(|value| *value = within(*value));
    }

    /// Returns the columns of the parameters on which one photograph depends, in the order of its
    /// derivatives (spread, c, further blurs).
    pub fn columns(&self, place: Place) -> Vec<usize> {
        let kernel = self.spread(place.group).into_iter().chain(self.c());
        let own = self.own_blur(place.distance);
        let others = self.own_blurs().end..self.parameters();
        kernel.chain(own).chain(others).collect()
    }

    /// Adds what is expected of the dihedral errors to residuals and derivatives.
    pub(crate) fn with_expected(
        &self,
        at: &DVector<f64>,
        (residuals, jacobian): (DVector<f64>, DMatrix<f64>),
    ) -> (DVector<f64>, DMatrix<f64>) {
        let (errors, n) = (self.common_errors(), residuals.len());
        if errors.is_empty() {
            return (residuals, jacobian);
        }
        let mut residuals = residuals.resize_vertically(n + errors.len(), 0.0);
        let mut jacobian = jacobian.resize_vertically(n + errors.len(), 0.0);
        for (row, column) in (n..).zip(errors) {
            residuals[row] = at[column] / EXPECTED_MRAD;
            jacobian[(row, column)] = EXPECTED_MRAD.recip();
        }
        (residuals, jacobian)
    }

    /// Adds the same to a normal matrix that begins with the columns of the blur.
    pub(crate) fn expect(&self, normal: &mut DMatrix<f64>) {
        for column in self.common_errors() {
            normal[(column, column)] += EXPECTED_MRAD.powi(-2);
        }
    }
}
