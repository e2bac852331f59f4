//! The best choice of photographs, by exchange (Fedorov, Theory of Optimal Experiments, 1972).

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::plan::information::{Foreseen, Information};
use crate::plan::request::Plan;
use crate::plan::rival::left;
use edges::names::ParameterKind;

/// Information on every unknown before a photograph is taken, so that the first ones can be
/// compared: a number is believed to within a factor of e. It has no part in stated errors.
const VAGUE: f64 = 1.0;

/// Passes over all photographs. Most plans need three.
const PASSES: usize = 20;

/// Share by which an exchange has to lower the measure, above rounding.
const LEAST_GAIN: f64 = 1e-9;

/// Search for the photographs that lower the variances most.
pub(crate) struct Search<'a> {
    foreseen: &'a Foreseen<'a>,
    before: Information,
    /// How often a candidate may be taken.
    repeat: usize,
    /// Places of the parameters whose variances count, with their weights: in the information on the
    /// blur, and of mu in that on all.
    blur: Vec<(usize, f64)>,
    mu: Vec<(usize, f64)>,
}

impl Search<'_> {
    /// Prepares the search.
    pub(crate) fn new<'a>(
        foreseen: &'a Foreseen<'a>,
        known: Option<&Information>,
        plan: &Plan,
    ) -> Search<'a> {
        let mut before = foreseen.before(known);
        let (blur, whole) = (before.blur.nrows(), before.whole.nrows());
        let rival = before.rival.nrows().saturating_sub(1);
        let known = [
            (&mut before.blur, blur),
            (&mut before.whole, whole),
            (&mut before.rival, rival),
        ];
        for (normal, unknowns) in known {
            for i in 0..unknowns {
                normal[(i, i)] += VAGUE;
            }
        }
        let weighed = |kind: &ParameterKind| {
            let places = foreseen.places(*kind);
            let weight = 1.0 / places.len() as f64;
            places.into_iter().map(move |place| (place, weight))
        };
        let is_mu = |kind: &&ParameterKind| **kind == ParameterKind::Mu;
        let kinds = || plan.minimise.iter();
        Search {
            foreseen,
            before,
            repeat: plan.choices.repeat,
            blur: kinds()
                .filter(|kind| !is_mu(kind))
                .flat_map(weighed)
                .collect(),
            mu: kinds().filter(is_mu).flat_map(weighed).collect(),
        }
    }

    /// Returns the best `count` candidates. The first are taken one by one, then exchanged until
    /// none is.
    pub(crate) fn best(&self, count: usize) -> Vec<usize> {
        let mut chosen = Vec::new();
        for _ in 0..count {
            chosen.push(self.next(&chosen));
        }
        for _ in 0..PASSES {
            let mut moved = false;
            for i in 0..count {
                let mut sums = self.sums(&chosen);
                let before = self.measure(&sums, None);
                for (point, sum) in sums.iter_mut().enumerate() {
                    sum.take(self.foreseen.tells(chosen[i], point));
                }
                let others = [&chosen[..i], &chosen[i + 1..]].concat();
                let (other, after) = self.best_beside(&sums, &others);
                if after < before - LEAST_GAIN {
                    chosen[i] = other;
                    moved = true;
                }
            }
            if !moved {
                break;
            }
        }
        chosen
    }

    /// Returns the candidate that is best taken beside these.
    pub(crate) fn next(&self, chosen: &[usize]) -> usize {
        self.best_beside(&self.sums(chosen), chosen).0
    }

    /// Returns the measure of a choice.
    #[cfg(test)]
    pub(crate) fn of(&self, chosen: &[usize]) -> f64 {
        self.measure(&self.sums(chosen), None)
    }

    /// Returns the information of some candidates, at each point of the beliefs.
    fn sums(&self, chosen: &[usize]) -> Vec<Information> {
        let at = |point: usize| {
            let mut sum = self.before.clone();
            for &i in chosen {
                sum.add(self.foreseen.tells(i, point));
            }
            sum
        };
        (0..self.foreseen.points()).map(at).collect()
    }

    /// Returns the candidate that is best added to `chosen`, whose information is `sums`, the first
    /// among equals, and the measure with it.
    fn best_beside(&self, sums: &[Information], chosen: &[usize]) -> (usize, f64) {
        let taken = |i: &usize| chosen.iter().filter(|&own| own == i).count();
        let all = (0..self.foreseen.candidates.len()).into_par_iter();
        let all = all.filter(|i| taken(i) < self.repeat);
        let measured = all.map(|i| (i, self.measure(sums, Some(i))));
        let best = measured.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        best.unwrap_or((0, f64::INFINITY))
    }

    /// Returns the mean over the beliefs of the logarithm of the summed variances, less that of the
    /// chi-square which tells kernels apart, with the information `sums` and that of one more
    /// candidate.
    ///
    /// So half the variance counts as much as twice the chi-square. A chi-square below 1, as noise
    /// alone gives, hardly counts.
    fn measure(&self, sums: &[Information], more: Option<usize>) -> f64 {
        let points = sums.iter().enumerate().map(|(point, sum)| {
            let tells = more.map(|i| self.foreseen.tells(i, point));
            let with = |own: &DMatrix<f64>, more: Option<&DMatrix<f64>>| match more {
                Some(more) => own + more,
                None => own.clone(),
            };
            let mut variance = 0.0;
            let mut count = |normal: DMatrix<f64>, places: &[(usize, f64)]| {
                let inverse = inverted(normal);
                let own = places.iter().map(|&(i, weight)| weight * inverse[(i, i)]);
                variance += own.sum::<f64>();
            };
            if !self.blur.is_empty() {
                count(with(&sum.blur, tells.map(|own| &own.blur)), &self.blur);
            }
            if !self.mu.is_empty() {
                count(with(&sum.whole, tells.map(|own| &own.whole)), &self.mu);
            }
            let mut goal = if self.blur.is_empty() && self.mu.is_empty() {
                0.0
            } else {
                variance.ln()
            };
            if !sum.rival.is_empty() {
                goal -= left(&with(&sum.rival, tells.map(|own| &own.rival)), 0).ln_1p();
            }
            goal
        });
        points.sum::<f64>() / sums.len() as f64
    }
}

/// Inverts a normal matrix, which the vague beliefs keep regular.
fn inverted(normal: DMatrix<f64>) -> DMatrix<f64> {
    let n = normal.nrows();
    match normal.cholesky() {
        Some(own) => own.inverse(),
        None => DMatrix::from_element(n, n, f64::INFINITY),
    }
}
