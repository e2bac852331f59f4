//! Candidates fitted to the MTFs: coarsely from several starting points, then the near ones again.

use rayon::prelude::*;

use crate::estimate::scene::Scene;
use crate::estimate::search::further;
use crate::estimate::search::layout::Choice;
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::{
    COARSE, Optimum, ROUGH, from_each, nearest, refined_to, rough_from,
};
use crate::estimate::search::select::{Candidates, choices};
use crate::estimate::search::start;

/// Ratio to the best criterion of the coarse fits above which a candidate stays as it is.
const FAR_BEHIND: f64 = 100.0;

/// One candidate with its coarse fits to the MTFs, one for each starting point.
pub(super) struct Tried(Vec<Optimum>);

impl Tried {
    pub(super) fn new(scene: &Scene, choice: Choice) -> Tried {
        let starts = start::points(scene, choice);
        Tried(from_each(COARSE, scene, choice, starts))
    }

    /// Returns the best fit.
    pub(super) fn best(&self) -> &Optimum {
        nearest(self.0.iter()).expect("there is always a starting point")
    }
}

/// Fits all candidates to the MTFs to a thousandth, but for those that are far behind.
pub(super) fn approached(scene: &Scene, tried: &[Tried]) -> Vec<Optimum> {
    let scale = misfit(tried.iter().map(Tried::best));
    let criteria = tried.iter().map(|own| own.best().criterion(scale));
    let limit = FAR_BEHIND * criteria.fold(f64::INFINITY, f64::min);
    let nearer = |own: &Tried| {
        let best = own.best();
        if best.criterion(scale) > limit {
            return best.clone();
        }
        let loss = Loss::Mtf(scene);
        let all = own.0.par_iter();
        let all: Vec<Optimum> = all
            .map(|fit| refined_to(ROUGH, scene, &loss, fit.clone()))
            .collect();
        nearest(all.iter()).unwrap_or(best).clone()
    };
    tried.par_iter().map(nearer).collect()
}

/// Fits the candidates with spare shapes to the MTFs. Returns none where others describe the
/// photographs, or where these explain too little of the misfit that the others leave.
pub(super) fn spare(scene: &Scene, open: &Candidates, left: f64) -> Vec<Tried> {
    if open.spare_shapes.is_empty() || left <= further::FAR {
        return Vec::new();
    }
    let kernels = open.kernels.iter().filter(|kernel| kernel.has_lobe());
    let open = Candidates {
        kernels: kernels.copied().collect(),
        shapes: open.spare_shapes.clone(),
        ..open.clone()
    };
    let tried = choices(scene, &open).into_par_iter();
    let tried: Vec<Tried> = tried.map(|choice| Tried::new(scene, choice)).collect();
    if further::explains(left, misfit(tried.iter().map(Tried::best))) {
        tried
    } else {
        Vec::new()
    }
}

/// Tries each candidate from the c of the best one, if its own c lies elsewhere. c is a length of
/// the sheet whatever the other terms, so a far c may be a local optimum.
pub(super) fn share_c(scene: &Scene, tried: &mut [Tried]) {
    // Difference of ln c: many standard errors of c in photographs that determine c, and far less
    // than the difference between two optima.
    const ELSEWHERE: f64 = 0.1;
    let scale = misfit(tried.iter().map(Tried::best));
    let ln_c = |fit: &Optimum| {
        fit.choice
            .kernel
            .has_c()
            .then(|| fit.solution.parameters[0])
    };
    let best = tried
        .iter()
        .map(Tried::best)
        .filter(|fit| fit.choice.kernel.has_c())
        .min_by(|a, b| a.criterion(scale).total_cmp(&b.criterion(scale)));
    let Some(shared) = best.and_then(ln_c) else {
        return;
    };
    tried.par_iter_mut().for_each(|own| {
        let fit = own.best();
        if ln_c(fit).is_some_and(|own| (own - shared).abs() > ELSEWHERE) {
            let start = start::at(scene, fit.choice, shared.exp());
            own.0
                .push(rough_from(COARSE, scene, fit.choice, vec![start]));
        }
    });
}

/// Returns the factor by which all sums of squares are too large: the least chi-square per degree
/// of freedom, at least 1.
pub(super) fn misfit<'a>(fits: impl IntoIterator<Item = &'a Optimum>) -> f64 {
    let all = fits.into_iter().map(Optimum::reduced_chi2);
    all.fold(f64::INFINITY, f64::min).max(1.0)
}
