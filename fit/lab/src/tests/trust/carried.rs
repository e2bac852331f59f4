//! Tests of what follows from an estimate: bounds by the profile of chi-square, and the covariance
//! by the errors that all photographs share.

use std::sync::Arc;

use crate::planted::{SHARED, camera, fitted, params, scene, table, truth};
use edges::names::Kernel;
use edges::names::LobeShape;
use estimator::compare::{Contrast, View};
use estimator::estimate::scene::Scene;
use estimator::estimate::search::optimum::optimum;
use estimator::estimate::{Choice, Estimate, Kind, Loss};
use estimator::estimate::{bounds, estimate, measure_parametric, sum_of_squares_with};
use estimator::model::Camera;
use estimator::model::Lens;
use nalgebra::{DMatrix, DVector};

/// Returns the logarithms of c, a and mu.
fn logarithms(fit: &Estimate) -> DVector<f64> {
    let values = fit.c_mm.iter().chain(&fit.spread);
    let all = values.chain(fit.mu.iter().flatten());
    DVector::from_vec(all.map(|v| v.value.ln()).collect())
}

/// Returns the covariance of the logarithms of c, a and mu.
fn of_logarithms(fit: &Estimate) -> DMatrix<f64> {
    let scale = logarithms(fit).map(f64::exp);
    DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
        fit.covariance[(i, j)] / (scale[i] * scale[j])
    })
}

/// Checks chi-square at the bounds of c (no ray shift was planted) and of a (no lobe was planted),
/// with the other parameter fitted again. 1.644854^2 = 2.70554 is the square of the normal number
/// that 5 % exceed, and the code rounds it to 2.706. A bound is the outer end of an interval of 1 %
/// of the parameter in which chi-square rises beyond this value. The solver ends at changes of
/// 1e-10 of chi-square, which is below 1000.
///
/// If the model fits badly, the rise is in units of chi-square per degree of freedom. This is tried
/// with a sixth of the numbers that the photographs hold.
#[test]
fn chi_square_rises_by_2_7055_at_a_bound() {
    let incidence = [0.0, 25.0];
    for (kernel, seed, i, way) in [(Kernel::Lobe, 12, 0, 1.0), (Kernel::Shift, 13, 1, -1.0)] {
        let planted = truth(kernel, LobeShape::Radial, 2.5, 0.35, 0.6);
        let of_ideal = table(&planted, &incidence, 20.0);
        let scene = scene(
            &params(seed, planted, &incidence, &[150.0, 300.0], camera(4e4)),
            &of_ideal,
        );
        let loss = Loss::Mtf(&scene);
        let fit = estimate(&scene, &loss, optimum(&scene, SHARED));
        let whole = fit.residuals;
        for residuals in [whole, whole / 6] {
            let fit = Estimate {
                residuals,
                ..fit.clone()
            };
            let bound =
                bounds(&scene, &loss, &fit, fit.reduced_chi2().max(1.0))[&fit.parameters[i]];
            let at = if way > 0.0 {
                bound.at_most
            } else {
                bound.at_least
            };
            let at = at.expect("the photographs bound it").ln();
            let unit = fit.reduced_chi2().max(1.0);
            assert!(residuals == whole || unit > 3.0, "{unit}");
            let rise = |x: f64| {
                let from = &fit.solution.parameters;
                let (squares, _) = sum_of_squares_with(1e-10, &scene, &loss, SHARED, from, (i, x));
                (squares - fit.chi2) / unit
            };
            let (inside, outside) = (rise(at - 0.01 * way), rise(at));
            println!("{kernel:?}: {inside:.4} {outside:.4}");
            assert!(fit.chi2 < 1000.0);
            assert!(inside < 2.706 + 1e-7, "{kernel:?}: {inside}");
            assert!(outside > 2.705_54 - 1e-7, "{kernel:?}: {outside}");
        }
    }
}

/// Checks how a misfit enters the errors: as a factor on the standard errors of the blur and one on
/// those of mu, and by their products on the covariance. Powers of two multiply exactly.
#[test]
fn a_misfit_raises_standard_errors_by_its_factors() {
    let incidence = [5.0, 30.0];
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let of_ideal = table(&planted, &incidence, 20.0);
    let scene = scene(
        &params(54, planted, &incidence, &[150.0], camera(4e4)),
        &of_ideal,
    );
    let mut cases = 0;
    for kind in [Kind::Mtf, Kind::Edge] {
        let fit = fitted(&scene, SHARED, kind);
        let mut raised = fit.clone();
        raised.raise([4.0, 8.0]);
        let by = [4.0, 4.0, 8.0];
        let expected = DMatrix::from_fn(3, 3, |i, j| fit.covariance[(i, j)] * by[i] * by[j]);
        assert_eq!(raised.covariance, expected);
        for ((more, own), by) in raised.values().zip(fit.values()).zip(by) {
            assert_eq!(more.standard_error, by * own.standard_error);
            assert_eq!(more.value, own.value);
            cases += 1;
        }
        // Independent errors of the logarithms, as of samples or of an azimuth, add as squares.
        let mut more = fit.clone();
        let added = [0.01, -0.02, 0.03];
        let alone = more.add_scatter(&DMatrix::from_fn(3, 3, |i, j| added[i] * added[j]));
        for (i, (with, own)) in more.values().zip(fit.values()).enumerate() {
            let by = added[i] * own.value;
            let expected = (own.standard_error.powi(2) + by * by).sqrt();
            assert!((alone[i] / by.abs() - 1.0).abs() < 1e-12);
            assert!((with.standard_error / expected - 1.0).abs() < 1e-12);
            for (j, other) in fit.values().enumerate() {
                let expected = fit.covariance[(i, j)] + by * added[j] * other.value;
                let scale = more.covariance[(i, i)].sqrt() * more.covariance[(j, j)].sqrt();
                assert!((more.covariance[(i, j)] - expected).abs() < 1e-12 * scale);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 2 * (3 + 9));
}

/// Differences of light are in units of the noise and of the error of eta. The table returns a
/// fifth more light at one incidence than the sheet does, and states an error of 0.05. So the
/// differences of both incidences lie ln(1.2) / 0.05 apart, whatever the weights of their mean is.
/// The noise of the pixels is about a hundredth of that error, and moves means of three by less.
#[test]
fn differences_of_light_hold_the_error_of_eta() {
    let incidence = [5.0, 30.0];
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let of_ideal = table(&planted, &incidence, 20.0);
    let mut scene = scene(
        &params(51, planted, &incidence, &[150.0, 220.0, 300.0], camera(4e5)),
        &of_ideal,
    );
    for shot in &mut scene.shots {
        let returned = &mut shot.direction.returned;
        returned.retroreflected *= [1.2, 1.0][shot.place.group];
        returned.standard_error = 0.05 * returned.retroreflected;
    }
    let expected = 1.2_f64.ln() / 0.05;
    for kind in [Kind::Mtf, Kind::Edge] {
        let fit = fitted(&scene, SHARED, kind);
        let scatter = fit.scatter.expect("there is a reference");
        assert_eq!((scatter.freedom, scatter.each.len()), (5, 6));
        let apart = (3..6)
            .map(|i| scatter.each[i] - scatter.each[i - 3])
            .sum::<f64>()
            / 3.0;
        println!("{kind:?}: {apart:.3} {expected:.3}, {:?}", scatter.each);
        assert!((apart / expected - 1.0).abs() < 0.03, "{apart} {expected}");
        let squares: f64 = scatter.each.iter().map(|v| v * v).sum();
        assert!((scatter.squares() / squares - 1.0).abs() < 1e-12);
    }
}

/// Checks the part of mu's covariance that the table's rays cause. All photographs of one
/// incidence share the error of eta, so it does not average out. By hand, ln mu of one incidence
/// moves by -1 per ln eta. For one mu the whole estimate is repeated with a changed eta of each
/// incidence.
///
/// The rest of the covariance is that without this error, or somewhat more, because the error makes
/// the weights of the photographs more even: for variances that differ by a factor of up to 5.8 at
/// most twice as much (Kantorovich). So the difference is right to the value without the error,
/// which is a few thousandths here.
#[test]
fn photographs_of_one_incidence_share_the_error_of_eta() {
    let incidence = [5.0, 30.0];
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let of_ideal = table(&planted, &incidence, 20.0);
    let scene = scene(
        &params(51, planted, &incidence, &[150.0, 220.0, 300.0], camera(4e4)),
        &of_ideal,
    );
    let errors = [0.05, 0.04];
    let with = |scale: [f64; 2], errors: [f64; 2]| {
        let mut other = scene.clone();
        for shot in &mut other.shots {
            let returned = &mut shot.direction.returned;
            returned.retroreflected *= scale[shot.place.group];
            returned.standard_error = errors[shot.place.group] * returned.retroreflected;
        }
        other
    };
    let mut cases = 0;
    for kind in [Kind::Mtf, Kind::Edge] {
        for per_angle_mu in [false, true] {
            let choice = Choice {
                per_angle_mu,
                ..SHARED
            };
            let fit = |scale, errors| fitted(&with(scale, errors), choice, kind);
            let exact = of_logarithms(&fit([1.0; 2], [0.0; 2]));
            let whole = of_logarithms(&fit([1.0; 2], errors));
            let step = 1e-3_f64;
            let mut expected = DMatrix::zeros(whole.nrows(), whole.ncols());
            for group in 0..2 {
                let moved = |by: f64| {
                    let mut scale = [1.0; 2];
                    scale[group] = by.exp();
                    logarithms(&fit(scale, errors))
                };
                let slope = (moved(step) - moved(-step)) / (2.0 * step);
                expected += &slope * slope.transpose() * errors[group].powi(2);
                if per_angle_mu {
                    assert!((slope[2 + group] + 1.0).abs() < 1e-6, "{slope}");
                }
            }
            for i in 2..whole.nrows() {
                let (found, by_hand) = (whole[(i, i)] - exact[(i, i)], expected[(i, i)]);
                println!(
                    "{kind:?} {i}: {found:.4e} {by_hand:.4e}, rest {:.1e}",
                    exact[(i, i)]
                );
                assert!(
                    (found - by_hand).abs() < exact[(i, i)] && exact[(i, i)] < 0.05 * by_hand,
                    "{kind:?} {per_angle_mu} {i}: {found:e} {by_hand:e}"
                );
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 2 * (1 + 2));
}

/// Returns a scene whose photographs are modelled through another lens.
fn through(scene: &Scene, lens: Lens) -> Scene {
    let camera = Camera {
        lenses: vec![lens],
        ..scene.optics.camera
    };
    let mut other = scene.clone();
    other.optics.camera = camera.clone();
    for shot in &mut other.shots {
        let view = &shot.view;
        // The tangential axis of planted photographs is +x.
        let (line, profile) = (view.line, view.profile.clone());
        shot.view = Arc::new(View::new(line, profile, camera.pitch_mm, 0.0, &camera));
    }
    other
}

/// Compares the part of the covariance that the lens causes with the whole estimate repeated
/// through changed lenses: the responses to ln(blur) and to the exponent, times the covariance of
/// the lens. The step of the reference divides mu, and
/// `a_planted_lens_and_its_step_are_found` checks how it responds.
///
/// The responses of the code are one-sided differences over 1e-4. They err by half of it times the
/// ratio of the second derivative to the first, which is below 10 for powers and exponentials of
/// order 1. That is 5e-4, and twice as much in a product.
#[test]
fn the_error_of_the_lens_is_carried_to_every_parameter() {
    let incidence = [5.0, 30.0];
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let of_ideal = table(&planted, &incidence, 20.0);
    let scene = scene(
        &params(52, planted, &incidence, &[150.0, 300.0], camera(1e9)),
        &of_ideal,
    );
    let covariance = DMatrix::from_row_slice(2, 2, &[1e-4, 3e-5, 3e-5, 4e-4]);
    let with = |lens_covariance: &DMatrix<f64>| {
        let mut other = scene.clone();
        other.optics.covariance = lens_covariance.clone();
        of_logarithms(&fitted(&other, SHARED, Kind::Mtf))
    };
    let found = with(&covariance) - with(&DMatrix::zeros(2, 2));
    let lens = &scene.optics.camera.lenses[0];
    let step = 2e-3;
    let reference = scene.reference.as_ref().expect("there is one");
    let of_step = &reference.step_by_lens;
    let slope = |k: usize, change: &dyn Fn(f64) -> Lens| {
        let at = |by: f64| logarithms(&fitted(&through(&scene, change(by)), SHARED, Kind::Mtf));
        let mut slope = (at(step) - at(-step)) / (2.0 * step);
        slope[2] -= of_step[k];
        slope
    };
    let slopes = [
        slope(0, &|by| Lens {
            blur_mm: lens.blur_mm * by.exp(),
            ..lens.clone()
        }),
        slope(1, &|by| Lens {
            exponent: lens.exponent + by,
            ..lens.clone()
        }),
    ];
    let mut expected = DMatrix::zeros(3, 3);
    for (i, a) in slopes.iter().enumerate() {
        for (j, b) in slopes.iter().enumerate() {
            expected += a * b.transpose() * covariance[(i, j)];
        }
    }
    println!("{found:.4e}{expected:.4e}");
    for i in 0..3 {
        for j in 0..3 {
            let scale = f64::sqrt(expected[(i, i)] * expected[(j, j)]);
            assert!(
                (found[(i, j)] - expected[(i, j)]).abs() < 1e-3 * scale,
                "{i} {j}: {found}{expected}"
            );
        }
    }
}

/// Checks the lens that is measured from a noise-free edge of a planted lens with an exponent other
/// than 2, and how the step of this edge responds to the lens. The solver ends at changes of 1e-10
/// of the parameters or of the sum of squares. Derivatives are one-sided differences over 1e-4, of
/// a step whose second derivative by ln(blur) or exponent is at most a few times the first.
#[test]
fn a_planted_lens_and_its_step_are_found() {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let of_ideal = table(&planted, &[0.0], 20.0);
    let scene = scene(
        &params(53, planted, &[0.0], &[150.0], camera(4e4)),
        &of_ideal,
    );
    let pitch_mm = scene.optics.camera.pitch_mm;
    let pixel = Camera {
        pitch_mm,
        lenses: Vec::new(),
    };
    let shot = &scene.shots[0];
    let mut cases = 0;
    for exponent in [1.0, 1.4, 2.6] {
        let of = |ln_blur: f64, exponent: f64| Camera {
            pitch_mm,
            lenses: vec![Lens::new(ln_blur.exp(), exponent)],
        };
        let ln_blur = (2.5 * pitch_mm).ln();
        let mut profile = shot.view.profile.clone();
        let edge = shot.view.edge_of(&of(ln_blur, exponent));
        // The model's MTF is raised by the noise of the bins, and these have none.
        profile.variance.iter_mut().for_each(|v| *v *= 1e-12);
        profile.mean = edge.iter().map(|unit| 0.02 + 0.8 * unit).collect();
        let view = View::new(shot.view.line, profile, pitch_mm, 0.0, &pixel);
        let (found, optics) = measure_parametric(vec![(view.clone(), (*shot.pixels).clone(), 2.0)]);
        let lens = &optics.camera.lenses[0];
        println!("{lens:?} {:?} {}", found.step_by_lens, found.step);
        assert!((lens.exponent - exponent).abs() < 1e-6, "{lens:?}");
        assert!((lens.blur_mm.ln() - ln_blur).abs() < 1e-6, "{lens:?}");
        assert!((found.step - 0.4).abs() < 1e-6, "{}", found.step);
        let h = 1e-3;
        let step = |ln_blur, exponent| {
            let edge = view.edge_of(&of(ln_blur, exponent));
            Contrast::fit(&view.profile, &edge).step.ln()
        };
        let expected = [
            step(ln_blur + h, exponent) - step(ln_blur - h, exponent),
            step(ln_blur, exponent + h) - step(ln_blur, exponent - h),
        ];
        for (&slope, change) in found.step_by_lens.iter().zip(expected) {
            let difference = change / (2.0 * h);
            assert!(
                (slope - difference).abs() < 1e-3 * difference.abs() + 1e-6,
                "p {exponent}: {slope} {difference}"
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 6);
}

/// Checks the covariance of a measured lens: the inverse of the normal matrix by differences, times
/// chi-square per degree of freedom if that is above 1. The edge is a lens's with a ripple of the
/// given height, in units of the noise of a bin. Central differences over 1e-3 err by 1e-6 of third
/// derivatives, which are at most some ten times the first.
#[test]
fn a_misfit_of_the_reference_widens_the_lens() {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let of_ideal = table(&planted, &[0.0], 20.0);
    let scene = scene(
        &params(53, planted, &[0.0], &[150.0], camera(4e4)),
        &of_ideal,
    );
    let pitch_mm = scene.optics.camera.pitch_mm;
    let of = |lens: Option<Lens>| Camera {
        pitch_mm,
        lenses: lens.into_iter().collect(),
    };
    let view = &scene.shots[0].view;
    let mut found = Vec::new();
    for height in [0.0, 20.0] {
        let lens = Lens::new(2.5 * pitch_mm, 1.4);
        let mut profile = view.profile.clone();
        let edge = view.edge_of(&of(Some(lens))).into_iter();
        profile.mean = edge
            .zip(&profile.variance)
            .enumerate()
            .map(|(j, (unit, variance))| {
                0.02 + 0.8 * unit + height * variance.sqrt() * (0.21 * j as f64).sin()
            })
            .collect();
        let view = View::new(view.line, profile, pitch_mm, 0.0, &of(None));
        let pixels = (*scene.shots[0].pixels).clone();
        let (reference, optics) = measure_parametric(vec![(view.clone(), pixels, 1.0)]);
        let lens = &optics.camera.lenses[0];
        let residuals = |ln_blur: f64, exponent: f64| {
            let lens = Lens::new(lens.blur_mm * ln_blur.exp(), lens.exponent + exponent);
            let (modelled, _) = view.predict(&view.edge_of(&of(Some(lens))), &[]);
            let pairs = modelled.iter().zip(&view.mtf.modulus);
            view.whiten(&pairs.map(|(m, d)| m - d).collect::<Vec<f64>>())
        };
        let h = 1e-3;
        let slopes = DMatrix::from_columns(&[
            (residuals(h, 0.0) - residuals(-h, 0.0)) / (2.0 * h),
            (residuals(0.0, h) - residuals(0.0, -h)) / (2.0 * h),
        ]);
        let rest = residuals(0.0, 0.0);
        let reduced = rest.norm_squared() / (rest.len() - 2) as f64;
        let inverse = (slopes.tr_mul(&slopes)).try_inverse();
        let expected = inverse.expect("both are told") * reduced.max(1.0);
        println!(
            "{reduced:.4} {}{:.6e}{expected:.6e}",
            reference.reduced_chi2, optics.covariance
        );
        assert!((reference.reduced_chi2 / reduced - 1.0).abs() < 1e-9);
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let scale = f64::sqrt(expected[(i, i)] * expected[(j, j)]);
            let off = (optics.covariance[(i, j)] - expected[(i, j)]).abs();
            assert!(off < 1e-4 * scale, "{i} {j}: {off:e} of {scale:e}");
        }
        found.push(reduced);
    }
    // Without a ripple there is nothing to raise.
    assert!(found[0] < 0.5 && found[1] > 2.0, "{found:?}");
}

/// A photograph is sharper than the reference if its MTF lies more than 0.1 above one half where
/// that of the reference is one half. And a lens has an exponent of its own if chi-square falls by
/// 10.8 with it, which noise reaches once in 1,000. The edge is noise-free, and the fall
/// is one over the variance that is stated. Between the two variances lie 1e-5.
#[test]
fn limits_of_a_reference_are_those_that_are_stated() {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let of_ideal = table(&planted, &[0.0], 20.0);
    let scene = scene(
        &params(53, planted, &[0.0], &[150.0], camera(4e4)),
        &of_ideal,
    );
    let pitch_mm = scene.optics.camera.pitch_mm;
    let of = |lens: Option<Lens>| Camera {
        pitch_mm,
        lenses: lens.into_iter().collect(),
    };
    let view = &scene.shots[0].view;
    let at = |wide: f64| {
        let lens = Lens::new(2.5 * pitch_mm, 2.1);
        let mut profile = view.profile.clone();
        profile.variance.iter_mut().for_each(|v| *v *= wide);
        let edge = view.edge_of(&of(Some(lens)));
        profile.mean = edge.iter().map(|unit| 0.02 + 0.8 * unit).collect();
        let view = View::new(view.line, profile, pitch_mm, 0.0, &of(None));
        let pixels = (*scene.shots[0].pixels).clone();
        let (reference, optics) = measure_parametric(vec![(view.clone(), pixels, 1.0)]);
        let freedom = view.mtf.modulus.len() - 1 - optics.lens.len();
        let squares = reference.reduced_chi2 * freedom as f64;
        (reference, optics.lens.len(), squares)
    };
    // The widest variance with an exponent of its own, and the least without one.
    let (mut low, mut high) = (1.0_f64, 1e6);
    for _ in 0..20 {
        let middle = (low * high).sqrt();
        let kept = at(middle).1 == 2;
        *(if kept { &mut low } else { &mut high }) = middle;
    }
    let ((_, free, less), (mut reference, one, more)) = (at(low), at(high));
    println!("{more:.3} for {less:.3} at {high:.3} times the variance");
    assert!((free, one) == (2, 1) && ((more - less) / 10.8 - 1.0).abs() < 0.01);
    for (level, sharper) in [(0.59, false), (0.61, true)] {
        let (mut low, mut high) = (0.0, view.mtf50_per_mm().expect("it falls"));
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let [mtf, error] = view.mtf_at(middle).expect("it is measured");
            assert!(error < 0.02, "{error}");
            if mtf > level {
                low = middle;
            } else {
                high = middle;
            }
        }
        reference.photographs[0].mtf50_per_mm = Some(low);
        assert_eq!(reference.is_blunter_than(view), sharper, "{level}");
    }
}
