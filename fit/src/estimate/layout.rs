//! Where a candidate's parameters stand in the solver's vector: [ln c] [ln spread ...].

use nalgebra::DVector;

use crate::estimate::choice::Choice;
use crate::model::Blur;

/// The order of one candidate's parameters.
pub struct Layout {
    /// The candidate.
    pub choice: Choice,
    /// Number of spreads: 0, 1, or one per incidence group.
    pub spreads: usize,
}

impl Layout {
    /// The layout of a candidate in a scene of so many incidence groups.
    pub fn new(choice: Choice, groups: usize) -> Layout {
        let spreads = match (choice.kernel.has_lobe(), choice.per_angle_a) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => groups,
        };
        Layout { choice, spreads }
    }

    /// Column of ln c.
    pub fn c(&self) -> Option<usize> {
        self.choice.kernel.has_c().then_some(0)
    }

    /// Column of a group's ln spread.
    pub fn spread(&self, group: usize) -> Option<usize> {
        let first = usize::from(self.choice.kernel.has_c());
        (self.spreads > 0).then(|| first + if self.choice.per_angle_a { group } else { 0 })
    }

    /// Index of a group's mu.
    pub fn mu_group(&self, group: usize) -> usize {
        if self.choice.per_angle_mu { group } else { 0 }
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        usize::from(self.choice.kernel.has_c()) + self.spreads
    }

    /// The blur of a group at a point.
    pub fn blur(&self, parameters: &DVector<f64>, group: usize) -> Blur {
        // Beyond e^+-14 of 1 mm or 1/mm nothing changes any more; the clamp keeps a runaway step
        // finite.
        let at = |i: Option<usize>| i.map_or(1.0, |i| parameters[i].clamp(-14.0, 14.0).exp());
        Blur {
            spread: at(self.spread(group)),
            c_mm: at(self.c()),
        }
    }

    /// Columns of the parameters that one shot depends on, in the order of its derivatives (spread,
    /// c).
    pub fn columns(&self, group: usize) -> Vec<usize> {
        self.spread(group).into_iter().chain(self.c()).collect()
    }
}
