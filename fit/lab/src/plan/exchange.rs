//! The best choice of photographs, by exchange (Fedorov, Theory of Optimal Experiments, 1972).

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::plan::information::{Foreseen, Information};
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
    /// Indices of the parameters whose variances count.
    blur: Vec<usize>,
    counts_mu: bool,
}

impl Search<'_> {
    /// Prepares the search.
    pub(crate) fn new<'a>(
        foreseen: &'a Foreseen<'a>,
        known: Option<&Information>,
        minimise: &[ParameterKind],
    ) -> Search<'a> {
        let mut before = foreseen.before(known);
        for normal in [&mut before.blur, &mut before.whole] {
            for i in 0..normal.nrows() {
                normal[(i, i)] += VAGUE;
            }
        }
        let blur = foreseen.parameters.iter().enumerate();
        let blur = blur.filter(|&(_, kind)| *kind != ParameterKind::Mu && minimise.contains(kind));
        Search {
            foreseen,
            before,
            blur: blur.map(|(i, _)| i).collect(),
            counts_mu: minimise.contains(&ParameterKind::Mu),
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
                let (other, after) = self.best_beside(&sums);
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
        self.best_beside(&self.sums(chosen)).0
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

    /// Returns the candidate that is best added to `sums`, the first among equals, and the measure
    /// with it.
    fn best_beside(&self, sums: &[Information]) -> (usize, f64) {
        let all = (0..self.foreseen.candidates.len()).into_par_iter();
        let measured = all.map(|i| (i, self.measure(sums, Some(i))));
        let best = measured.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        best.unwrap_or((0, f64::INFINITY))
    }

    /// Returns the mean over the beliefs of the logarithm of the summed variances, with the
    /// information `sums` and that of one more candidate.
    fn measure(&self, sums: &[Information], more: Option<usize>) -> f64 {
        let points = sums.iter().enumerate().map(|(point, sum)| {
            let tells = more.map(|i| self.foreseen.tells(i, point));
            let with = |own: &DMatrix<f64>, more: Option<&DMatrix<f64>>| match more {
                Some(more) => own + more,
                None => own.clone(),
            };
            let mut variance = 0.0;
            if !self.blur.is_empty() {
                let normal = with(&sum.blur, tells.map(|own| &own.blur));
                let inverse = inverted(normal);
                variance += self.blur.iter().map(|&i| inverse[(i, i)]).sum::<f64>();
            }
            if self.counts_mu {
                let inverse = inverted(with(&sum.whole, tells.map(|own| &own.whole)));
                let mu = inverse.nrows() - 2;
                variance += inverse[(mu, mu)];
            }
            variance.ln()
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
