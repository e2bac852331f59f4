//! Tests of `estimator::estimate::search::select` on planted campaigns.

use crate::planted::{SHARED, camera, fitted, params, scene, table, truth};
use edges::names::{Kernel, LobeShape};
use estimator::estimate::search::layout::Choice;
use estimator::estimate::search::loss::Kind;
use estimator::estimate::search::select::*;

/// Each incidence has its own mu if theirs differ by more than the criterion asks for, times
/// the misfit of the photographs. The table returns a tenth too much light at one of two
/// incidences, which gives a sum of squares; a misfit of as many times the limit is then just
/// enough, or not.
#[test]
fn a_misfit_raises_what_a_mu_of_each_incidence_has_to_bring() {
    let incidence = [5.0, 30.0];
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let of_ideal = table(&planted, &incidence, 20.0);
    let mut scene = scene(
        &params(51, planted, &incidence, &[150.0, 300.0], camera(4e4)),
        &of_ideal,
    );
    for shot in &mut scene.shots {
        shot.direction.returned.retroreflected *= [1.1, 1.0][shot.place.group];
    }
    let choice = Choice {
        per_angle_mu: true,
        ..SHARED
    };
    let mut fit = fitted(&scene, choice, Kind::Mtf);
    let mu: Vec<f64> = fit.mu.iter().flatten().map(|mu| mu.value).collect();
    let entry = |i: usize, j: usize| fit.covariance[(2 + i, 2 + j)] / (mu[i] * mu[j]);
    let variance = entry(0, 0) + entry(1, 1) - 2.0 * entry(0, 1);
    let squares = (mu[1] / mu[0]).ln().powi(2) / variance;
    // One more number for four photographs, and 4 for a clear fall.
    let most = squares / (4.0_f64.ln() + 4.0);
    println!("mu {mu:?}: {squares:.1}, up to a misfit of {most:.1}");
    assert!(most > 1.5, "{most}");
    for (misfit, needed) in [(0.5, true), (0.999 * most, true), (1.001 * most, false)] {
        fit.chi2 = misfit * fit.degrees_of_freedom() as f64;
        assert_eq!(needs_own_mu(&scene, &fit), needed, "{misfit}");
    }
}
