//! Tests of the estimate against planted answers.

use crate::planted::{camera, fitted, params, scene, table, truth};
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::names::Spectrum;
use edges::names::{ParameterId, ParameterKind};
use edges::photographs::manifest::captures;
use estimator::compare::Contrast;
use estimator::compare::Weights;
use estimator::estimate::Candidates;
use estimator::estimate::Choice;
use estimator::estimate::Progress;
use estimator::estimate::Scene;
use estimator::estimate::absent;
use estimator::estimate::search::optimum::{optimum, sum_of_squares_with};
use estimator::estimate::search::select::{Selection, select};
use estimator::estimate::{Estimate, estimate};
use estimator::estimate::{Kind, Loss};
use estimator::estimate::{refined, residuals_at};
use estimator::model::Blur;
use estimator::model::Further;
use estimator::model::Model;
use nalgebra::DVector;

const SHARED: Choice = Choice {
    kernel: Kernel::Eq1,
    shape: LobeShape::Radial,
    per_angle_a: false,
    per_angle_mu: false,
    further: Further::NONE,
};

/// The simulator works in space, the model in frequency. On the same bins they must agree.
///
/// Tolerance: 14-bit rounding gives an error of 1/(2^14 sqrt 12) = 1.8e-5 per pixel, and electrons
/// at 1e12 full well 1e-6. A bin of n >= 20 pixels averages these errors, so 4.5 sigma over 5000
/// bins is 2e-5 of full scale; steps are above 0.05 of it. The model's interpolation adds 2e-5 (see
/// `view`), the simulator's grid 2e-7.
#[test]
fn model_equals_noise_free_photographs() {
    let mut cases = 0;
    let mut worst: f64 = 0.0;
    for kernel in Kernel::ALL {
        for shape in LobeShape::ALL {
            let a = if kernel == Kernel::Angular {
                700.0
            } else {
                3.4
            };
            let truth = truth(kernel, shape, a, 0.31, 0.6);
            let incidence = [0.0, 20.0, 40.0];
            let table = table(&truth, &incidence, 20.0);
            let scene = scene(
                &params(5, truth, &incidence, &[200.0], camera(1e12)),
                &table,
            );
            for shot in &scene.shots {
                let model = Model {
                    kernel,
                    shape,
                    shift: shot.direction.shift.as_ref(),
                    bent: None,
                    wave: shot.direction.wave.as_ref().ok(),
                    baseline: None,
                    r_mm: shot.r_mm,
                    normal: shot.normal(),
                    further: Further::NONE,
                    ghost: None,
                    haze: None,
                    tangential_gain: 1.0,
                };
                let curve = shot.view.curve(&model, Blur::new(a, 0.31));
                let profile = &shot.view.profile;
                let contrast = Contrast::fit(profile, &curve.bins);
                let bins = &curve.bins;
                // The fit passes through the means, weighted by the number of pixels in each bin.
                let mean = |curve: &[f64]| {
                    let sum: f64 = profile.count.iter().zip(curve).map(|(n, v)| n * v).sum();
                    sum / profile.count.iter().sum::<f64>()
                };
                let dark = mean(&profile.mean) - contrast.step * mean(bins);
                let error =
                    |j: usize| (profile.mean[j] - dark - contrast.step * bins[j]) / contrast.step;
                // The place of the edge is the half level of the profile, not the centre of the
                // model. Its error is a few thousandths of a pixel; it is the share of the slope in
                // the differences.
                let slope = |j: usize| 0.5 * (bins[j + 1] - bins[j - 1]);
                let inner = 1..bins.len() - 1;
                let place = inner.clone().map(|j| error(j) * slope(j)).sum::<f64>()
                    / inner.clone().map(|j| slope(j).powi(2)).sum::<f64>();
                assert!(place.abs() < 0.2, "the edge lies {place} bins off");
                worst = inner
                    .map(|j| (error(j) - place * slope(j)).abs())
                    .fold(worst, f64::max);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 5 * LobeShape::ALL.len() * 3);
    assert!(
        worst < 2e-5 / 0.05 + 2e-5,
        "largest difference of profile and model: {worst:.2e} of the step"
    );
}

/// Derivatives match central differences. Differences with step h have an error of h^2/6 times the
/// third derivative, and the rounding of the residuals over h. Residuals are in units of noise, up
/// to 1e4, so rounding gives 1e-12 x 1e4 / 1e-4 = 1e-4 absolute; derivatives reach 1e4.
#[test]
fn derivatives_match_differences() {
    let mut truth = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    truth.spectrum = Spectrum::parse("450:0.4,550:0.6").ok();
    let incidence = [0.0, 30.0];
    let table = table(&truth, &incidence, 20.0);
    let scene = scene(
        &params(6, truth, &incidence, &[150.0, 300.0], camera(40_000.0)),
        &table,
    );
    let mut cases = 0;
    for kernel in Kernel::ALL {
        for shape in LobeShape::ALL {
            let choice = Choice {
                kernel,
                shape,
                per_angle_a: true,
                per_angle_mu: false,
                further: Further::NONE,
            };
            let a = if kernel == Kernel::Angular {
                600.0_f64
            } else {
                3.1
            };
            let mut at: Vec<f64> = Vec::new();
            if kernel.has_c() {
                at.push(0.29_f64.ln());
            }
            if kernel.has_lobe() {
                at.extend([a.ln(), (0.8 * a).ln()]);
            }
            let at = DVector::from_vec(at);
            let (_, jacobian) = residuals_at(&scene, choice, &at);
            for i in 0..at.len() {
                let h = 1e-4;
                let (mut low, mut high) = (at.clone(), at.clone());
                low[i] -= h;
                high[i] += h;
                let difference = (residuals_at(&scene, choice, &high).0
                    - residuals_at(&scene, choice, &low).0)
                    / (2.0 * h);
                let largest = jacobian.column(i).amax();
                let error = (jacobian.column(i) - &difference).amax();
                assert!(
                    error < 2e-5 * largest + 1e-3,
                    "{kernel:?} {shape:?} {i}: {error:.1e} of {largest:.1e}"
                );
                cases += 1;
            }
        }
    }
    assert_eq!(cases, LobeShape::ALL.len() * (1 + 1 + 2 + 3 + 3));
}

/// Checks a bound of a term that was left out against its definition: a normal number about the
/// bound, known to lie below the threshold of the criterion, lies below the estimate with a
/// probability of 5 %. All of them in standard deviations, which are roots of falls and rises of
/// chi-square. A bound is the outer end of an interval of 1 % of the parameter, so 5 % lie between
/// the shares of its two ends.
fn bound_is_conditional(scene: &Scene, selection: &Selection, id: ParameterId, at: f64, way: f64) {
    let loss = &selection.loss;
    let both = Choice {
        kernel: Kernel::Eq1,
        ..selection.best.choice
    };
    let fit = estimate(scene, loss, optimum(scene, both));
    let i = fit.parameters.iter().position(|&own| own == id);
    let i = i.expect("eq1 has both terms");
    let found = (selection.best.chi2 - fit.chi2).max(0.0).sqrt();
    // Bayes' criterion and the margin of 4 that a term has to clear.
    let threshold = ((loss.observations() as f64).ln() + 4.0).sqrt();
    let below = |x: f64| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
    let share = |x: f64| {
        let from = &fit.solution.parameters;
        let (squares, _) = sum_of_squares_with(1e-10, scene, loss, both, from, (i, x));
        let rise = (squares - fit.chi2).max(0.0).sqrt();
        below(-rise) / below((threshold - found).max(0.1) - rise)
    };
    let (inside, outside) = (share(at - 0.01 * way), share(at));
    println!("found at {found:.2} of {threshold:.2}: {inside:.4} to {outside:.4}");
    assert!(outside <= 0.05 && 0.05 <= inside, "{inside} {outside}");
}

/// A campaign with a gaussian lobe gives its a, c and mu back, each within 4.5 standard errors, which
/// chance exceeds in 7 of 10^6. With a radial lobe the same photographs do not agree.
#[test]
fn a_gaussian_lobe_comes_back() {
    let (a, c_mm, mu) = (2.4, 0.31, 0.6);
    let planted = truth(Kernel::Eq1, LobeShape::Gaussian, a, c_mm, mu);
    let incidence = [0.0, 25.0];
    let table = table(&planted, &incidence, 20.0);
    let params = params(3, planted, &incidence, &[150.0, 300.0], camera(4e4));
    let scene = scene(&params, &table);
    let choice = Choice {
        shape: LobeShape::Gaussian,
        ..SHARED
    };
    let found = fitted(&scene, choice, Kind::Edge);
    let found_mu = &found.mu.as_ref().expect("the source is known")[0];
    let numbers = [
        (found.spread[0], a),
        (found.c_mm.expect("eq1 has a c"), c_mm),
        (*found_mu, mu),
    ];
    for (number, planted) in numbers {
        println!("{number:?} of {planted}");
        let off = (number.value - planted) / number.standard_error;
        assert!(off.abs() < 4.5, "{number:?} of {planted}");
        assert!(number.standard_error < 0.05 * planted, "nothing is known");
    }
    let radial = fitted(&scene, SHARED, Kind::Edge);
    println!("chi2 {} with a radial lobe {}", found.chi2, radial.chi2);
    assert!(radial.chi2 > 2.0 * found.chi2);
}

/// The right terms are found if the photographs can show them: distances of 150 and 300 mm
/// distinguish eq1 from angular.
#[test]
fn selection_finds_the_planted_terms() {
    let everything = Candidates {
        kernels: vec![Kernel::Eq1, Kernel::Angular, Kernel::Shift, Kernel::Lobe],
        shapes: vec![LobeShape::Radial, LobeShape::Separable],
        spare_shapes: Vec::new(),
        per_angle_a: None,
        per_angle_mu: None,
    };
    let mut cases = 0;
    for (kernel, a) in [
        (Kernel::Eq1, 3.4),
        (Kernel::Angular, 700.0),
        (Kernel::Shift, 1.0),
        (Kernel::Lobe, 2.5),
    ] {
        for shape in LobeShape::COMPARED {
            let truth = truth(kernel, shape, a, 0.35, 0.6);
            let incidence = [0.0, 25.0];
            let table = table(&truth, &incidence, 20.0);
            let scene = scene(
                &params(11, truth, &incidence, &[150.0, 300.0], camera(4e4)),
                &table,
            );
            let selection = select(&scene, Kind::Mtf, &everything, &Progress::SILENT).unwrap();
            // A parameter that was left out has a bound in the direction in which its blur
            // vanishes.
            let bound = absent(&scene, &selection, 1.0);
            println!("{kernel:?} {shape:?} {bound:?}");
            let expected = match kernel {
                Kernel::Lobe => Some((ParameterKind::CornerSize, 1.0)),
                Kernel::Shift => Some((ParameterKind::APerMm, -1.0)),
                _ => None,
            };
            assert_eq!(
                bound.map(|(id, _)| id),
                expected.map(|(kind, _)| kind.shared())
            );
            if let (Some((id, bound)), Some((_, way))) = (bound, expected) {
                assert_eq!(bound.at_most.is_some(), way > 0.0);
                let at = bound.at_most.or(bound.at_least).expect("one side");
                bound_is_conditional(&scene, &selection, id, at.ln(), way);
            }
            let chosen = selection.best.choice;
            assert_eq!(chosen.kernel, kernel, "planted {kernel:?} {shape:?}");
            if kernel.has_lobe() {
                assert_eq!(chosen.shape, shape, "planted {kernel:?} {shape:?}");
                assert!(
                    !chosen.per_angle_a && !chosen.per_angle_mu,
                    "planted {kernel:?} {shape:?}: {chosen:?}"
                );
            }
            cases += 1;
        }
    }
    assert_eq!(cases, 8);
}

/// Valid but degenerate campaigns have an answer: no retroreflected light at one angle, one
/// photograph, no reference.
#[test]
fn degenerate_campaigns() {
    // A single hollow cube at azimuth 20 returns no light at 50 degrees.
    let mut hollow = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.35, 0.6);
    (hollow.refractive_index, hollow.pair) = (1.0, false);
    let incidence = [10.0, 50.0];
    let of_hollow = table(&hollow, &incidence, 20.0);
    assert_eq!(of_hollow.retroreflected[[1, 0]], 0.0);
    let both = scene(
        &params(21, hollow.clone(), &incidence, &[200.0], camera(4e4)),
        &of_hollow,
    );
    assert_eq!(both.shots.len(), 1);
    assert!(
        both.warnings
            .iter()
            .any(|w| w.contains("left out") && w.contains("50 deg")),
        "{:?}",
        both.warnings
    );
    let fit = estimate(&both, &Loss::Mtf(&both), optimum(&both, SHARED));
    assert!(
        fit.c_mm
            .is_some_and(|c| ((c.value - 0.35) / c.standard_error).abs() < 4.5)
    );

    // Without a reference c and a are estimated all the same; a warning says that a sharper camera
    // is assumed. mu is null.
    let mut alone = params(22, hollow.clone(), &incidence[..1], &[200.0], camera(4e4));
    alone.reference = None;
    let alone = scene(&alone, &of_hollow);
    assert!(
        alone.reference.is_none() && alone.warnings.iter().any(|w| w.contains("no [reference]"))
    );
    let fit = estimate(&alone, &Loss::Mtf(&alone), optimum(&alone, SHARED));
    assert!(fit.mu.is_none() && fit.c_mm.is_some_and(|c| c.value.is_finite()));

    // If no light returns at any angle, the error says so.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let nothing = params(23, hollow, &incidence[1..], &[200.0], camera(4e4));
    crate::simulate::run(&nothing, folder.path(), true).expect("the campaign can be written");
    let campaign =
        captures::load(&folder.path().join("captures.toml")).expect("the manifest is valid");
    let error = Scene::load(&campaign, &of_hollow)
        .err()
        .expect("there is nothing to fit")
        .to_string();
    assert!(error.contains("no capture is left"), "{error}");
}

/// A large c is found beside a wide lobe. No path leads there from a start with a small c, because
/// the model does not depend on a small c.
#[test]
fn starting_values_reach_every_c() {
    for (a, c) in [
        (2.28, 0.45),
        (2.24, 0.276),
        (2.23, 0.292),
        (7.4, 0.12),
        (1.6, 0.48),
        (5.0, 0.1),
    ] {
        let planted = truth(Kernel::Eq1, LobeShape::Radial, a, c, 0.6);
        let incidence = [0.0, 7.0, 14.0];
        let of_ideal = table(&planted, &incidence, 20.0);
        let photographed = scene(
            &params(31, planted, &incidence, &[150.0, 300.0], camera(18e3)),
            &of_ideal,
        );
        let fit = estimate(
            &photographed,
            &Loss::Mtf(&photographed),
            optimum(&photographed, SHARED),
        );
        let found = fit.c_mm.expect("eq1 has c");
        let freedom = (fit.residuals - fit.blur_parameters()) as f64;
        // The standard deviation of chi-square per degree of freedom is sqrt(2/n) < 0.2 here.
        assert!(
            fit.chi2 / freedom < 2.0,
            "a {a} c {c}: chi-square {:.1} over {freedom}",
            fit.chi2
        );
        assert!(
            ((found.value - c) / found.standard_error).abs() < 4.5,
            "a {a} c {c}: {found:?}"
        );
    }
}

/// The loss `mse` is the mean square of the MTF differences that a result states. Its sum is
/// smaller at its own optimum than at that of `mtf`, and the sum of `mtf` is smaller at that of
/// `mtf`.
#[test]
fn the_plain_loss_is_the_mean_of_squares() {
    let incidence = [0.0, 30.0];
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let of_ideal = table(&planted, &incidence, 20.0);
    let photographed = scene(
        &params(41, planted, &incidence, &[150.0], camera(4e3)),
        &of_ideal,
    );
    let near = optimum(&photographed, SHARED);
    let losses = [Weights::Noise, Weights::Even].map(|weights| {
        let loss = Loss::of_mtfs(&photographed, weights);
        let best = refined(&photographed, &loss, near.clone());
        estimate(&photographed, &loss, best)
    });
    let [weighed, plain] = &losses;
    for fit in &losses {
        for ((shot, modelled), stated) in photographed
            .shots
            .iter()
            .zip(&fit.modelled)
            .zip(&fit.losses)
        {
            let measured = &shot.view.mtf.modulus;
            let squares = modelled
                .iter()
                .zip(measured)
                .skip(1)
                .map(|(m, d)| (m - d).powi(2));
            let mean = squares.sum::<f64>() / (modelled.len() - 1) as f64;
            assert!((mean / stated - 1.0).abs() < 1e-12, "{mean} {stated}");
        }
    }
    let sum = |fit: &Estimate| fit.losses.iter().sum::<f64>();
    let least = plain.solution.sum_of_squares();
    assert!((sum(plain) / least - 1.0).abs() < 1e-12, "{least}");
    assert!(
        sum(plain) < sum(weighed) && weighed.chi2 < plain.chi2,
        "{losses:?}"
    );
}

/// A parameter that is not there has a wide standard error, never one of 0.
///
/// The planted sheet has a lobe alone, so c is 0. The model depends on c^2, whose estimate is z
/// standard errors off 0, with a normal z. If z > 0, the standard error of c is c / (2 z). A z
/// above 4 has a chance of 3e-5, so c stays below 8 of its errors. If z < 0, c runs to its limit,
/// where the error is far wider than c.
#[test]
fn a_corner_size_that_is_not_there_has_a_wide_error() {
    let planted = truth(Kernel::Lobe, LobeShape::Radial, 3.0, 0.3, 0.6);
    let table = table(&planted, &[5.0, 25.0], 20.0);
    let (mut cases, mut at_limit) = (0, 0);
    for seed in 1..=4 {
        let params = params(
            seed,
            planted.clone(),
            &[5.0, 25.0],
            &[150.0],
            camera(4_000.0),
        );
        let scene = scene(&params, &table);
        for kind in [Kind::Mtf, Kind::Edge] {
            let found = fitted(&scene, SHARED, kind);
            let c = found.c_mm.expect("eq1 has a c");
            println!("seed {seed}, {}: {c:?}", kind.name());
            assert!(c.value < 8.0 * c.standard_error, "{c:?}");
            at_limit += usize::from(c.value < 1e-6);
            cases += 1;
        }
    }
    println!("{cases} estimates, {at_limit} of them at the limit");
    assert_eq!(cases, 8);
    assert!(at_limit > 0, "no estimate ran to the limit");
}

/// A start at which c has no effect, and so no slope, leads to the optimum too: the MTFs lose c in
/// very uneven light. Found without c, the spread makes up for a part of it. Both fits end where
/// chi-square changes by less than 1e-10 of itself, which is 1e-6 here, or a thousandth of a
/// standard error.
#[test]
fn a_lost_c_is_found_again_by_the_pixels() {
    let mut cases = 0;
    for (c_mm, electrons) in [(0.31, 2e4), (0.1, 2e4), (0.1, 600.0)] {
        let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, c_mm, 0.6);
        let table = table(&planted, &[0.0, 30.0], 20.0);
        let scene = scene(
            &params(12, planted, &[0.0, 30.0], &[150.0], camera(electrons)),
            &table,
        );
        let near = optimum(&scene, SHARED);
        let at = &near.solution.parameters;
        let loss = Loss::new(Kind::Edge, &scene, (SHARED, at));
        let mut lost = near.clone();
        lost.solution.parameters =
            sum_of_squares_with(1e-10, &scene, &Loss::Mtf(&scene), SHARED, at, (0, -14.0)).1;
        let [right, found] =
            [near, lost].map(|start| estimate(&scene, &loss, refined(&scene, &loss, start)));
        for (right, found) in right.values().zip(found.values()) {
            let off = (found.value - right.value) / right.standard_error;
            println!("{c_mm} {electrons}: {off:.1e}");
            assert!(off.abs() < 1e-3, "{c_mm} {electrons}: {off}");
            cases += 1;
        }
    }
    assert_eq!(cases, 9);
}
