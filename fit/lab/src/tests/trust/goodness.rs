//! Tests of `estimator::estimate::goodness` on planted campaigns.

use crate::planted::{SHARED, camera, fitted, params, scene, table, truth};
use edges::names::{Kernel, LobeShape};
use edges::numerics::chance;
use estimator::compare::Pixels;
use estimator::compare::Remainder;
use estimator::estimate::search::fitted::estimate;
use estimator::estimate::search::layout::Layout;
use estimator::estimate::search::layout::{Choice, Value};
use estimator::estimate::search::loss::Kind;
use estimator::estimate::search::loss::Loss;
use estimator::estimate::search::optimum::{optimum, refined};
use estimator::estimate::trust::goodness::*;
use rayon::prelude::*;

/// Two halves of one photograph scatter by the noise: half of their distance is a standard
/// error. The mean square of its ratio to the stated error is chi-square over its number, with
/// a standard deviation of sqrt(2/160) = 0.11; the limits are 4 of these. c and a of one
/// photograph go together, so each has its own mean.
#[test]
#[ignore = "20 processor-seconds: `make test-full` runs it"]
fn halves_of_a_photograph_scatter_by_its_noise() {
    const DRAWS: u64 = 160;
    let sheet = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.33, 0.5);
    let table = table(&sheet, &[20.0], 20.0);
    let ratios = (0..DRAWS).into_par_iter().map(|seed| {
        let shots = params(seed, sheet.clone(), &[20.0], &[200.0], camera(2e4));
        let scene = scene(&shots, &table);
        let fit = fitted(&scene, SHARED, Kind::Edge);
        let at = fit.solution.parameters.rows(0, 2).into_owned();
        let loss = Loss::new(Kind::Edge, &scene, (SHARED, &at));
        let layout = Layout::new(SHARED, 1, 1);
        let LeftOut { each, halves } = LeftOut::all(&scene, &loss, &layout, &fit);
        assert_eq!((each.len(), halves.len()), (2, 2));
        let off = |k: usize, value: &Value| {
            0.5 * (halves[0][k] - halves[1][k]) * value.value / value.standard_error
        };
        let of = fit.values().take(2).enumerate();
        of.map(|(k, value)| off(k, value)).collect::<Vec<f64>>()
    });
    let ratios: Vec<Vec<f64>> = ratios.collect();
    let allowed = 4.0 * (2.0 / DRAWS as f64).sqrt();
    for k in 0..2 {
        let mean = ratios.iter().map(|r| r[k] * r[k]).sum::<f64>() / DRAWS as f64;
        println!("mean square of parameter {k}: {mean:.3}");
        assert!((mean - 1.0).abs() < allowed, "{k}: {mean}");
    }
}

/// The probabilities are those of the photographs' own sums, by the closed forms of a sum of
/// squares and of the least of n numbers, 1 - (1 - p)^n. All are taken from the same sums, so
/// rounding alone differs.
#[test]
fn chances_are_those_of_the_photographs_sums() {
    let angles = [5.0, 30.0];
    let sheet = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.33, 0.5);
    let table = table(&sheet, &angles, 20.0);
    let shots = params(7, sheet, &angles, &[150.0, 250.0], camera(2e4));
    let scene = scene(&shots, &table);
    let mut cases = 0;
    for kind in [Kind::Mtf, Kind::Edge] {
        let near = optimum(&scene, SHARED);
        let loss = Loss::new(kind, &scene, (SHARED, &near.solution.parameters));
        let fit = estimate(&scene, &loss, refined(&scene, &loss, near));
        let found = of(&scene, &loss, &fit);
        let layout = Layout::of(SHARED, &scene);
        let own = loss.remainders(&layout, &fit.solution.parameters);
        let photographs = if kind == Kind::Edge { 5 } else { 4 };
        assert_eq!(own.len(), photographs);
        let chances = own
            .iter()
            .map(|own| chance::of_squares(own.squares, own.freedom));
        let least = chances.fold(1.0, f64::min);
        let squares = |all: &dyn Fn(&Remainder) -> Vec<f64>| {
            let all: Vec<f64> = own.iter().flat_map(all).collect();
            chance::of_squares(all.iter().map(|v| v * v).sum(), all.len())
        };
        let scatter = fit.scatter.as_ref().expect("there is a reference");
        let expected = [
            chance::of_squares(fit.chi2, fit.residuals - 2),
            squares(&|own| own.across.clone()),
            squares(&|own| own.along.clone()),
            1.0 - (1.0 - least).powi(photographs as i32),
            chance::of_squares(scatter.squares(), 3),
        ];
        let Chances {
            chi2,
            across,
            along,
            photograph,
            light,
        } = found.chances;
        println!("{:?}, least {least}", found.chances);
        for (found, expected) in [chi2, across, along, photograph, light]
            .into_iter()
            .zip(expected)
        {
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
            cases += 1;
        }
        // All squares are those of the photographs. The search for the nuisances of each ends within
        // 1e-4 of its least square, and the two sums began it elsewhere.
        let sum: f64 = own.iter().map(|own| own.squares).sum();
        let ended = 1e-4 * photographs as f64;
        assert!((sum - found.chi2).abs() < ended, "{sum} {}", found.chi2);
        // Each bin of pixels has a mean, and a slope if its pixels are spread along the edge.
        // Place, turn, plateaus and two terms of the light are each photograph's own, and the
        // blur of the lens is common.
        let reference = scene.reference.as_ref().expect("there is one");
        let pixels = scene.shots.iter().map(|shot| &*shot.pixels);
        let numbers = |pixels: &Pixels| -> usize {
            let bins = pixels.bins.iter();
            bins.map(|bin| 1 + usize::from(bin.spread > 0.0)).sum()
        };
        let all: usize = pixels
            .chain([&reference.photographs[0].pixels])
            .map(numbers)
            .sum();
        let mtfs = scene
            .shots
            .iter()
            .map(|shot| shot.view.mtf.modulus.len() - 1);
        let (numbers, lens) = match kind {
            Kind::Edge => (all - 6 * photographs, scene.optics.lens.len()),
            _ => (mtfs.sum(), 0),
        };
        assert_eq!(own.iter().map(|own| own.freedom).sum::<usize>(), numbers);
        assert_eq!(found.degrees_of_freedom, numbers - lens - 2);
    }
    assert_eq!(cases, 10);
}

/// A misfit raises the errors by the root of chi-square per degree of freedom, or by the
/// jackknife if that is larger. Photographs of pairs of cubes with a table of single ones
/// differ from one another. Photographs that are alike, fitted without their lobe, do not.
#[test]
fn a_misfit_raises_by_the_root_of_chi_square_or_by_the_jackknife() {
    let sheet = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.33, 0.5);
    let mut single = sheet.clone();
    single.pair = false;
    let shift = Choice {
        kernel: Kernel::Shift,
        ..SHARED
    };
    let mut larger = Vec::new();
    for (own, angles, distances, choice) in [
        (&single, &[5.0, 30.0][..], &[150.0, 250.0][..], SHARED),
        (&sheet, &[20.0], &[200.0; 4], shift),
    ] {
        let table = table(own, angles, 20.0);
        let shots = params(7, sheet.clone(), angles, distances, camera(1e6));
        let scene = scene(&shots, &table);
        let loss = Loss::Mtf(&scene);
        let fit = estimate(&scene, &loss, optimum(&scene, choice));
        let found = of(&scene, &loss, &fit);
        let layout = Layout::of(choice, &scene);
        let jackknife = LeftOut::all(&scene, &loss, &layout, &fit).scale(&scene, &fit);
        let freedom = fit.residuals - layout.parameters();
        let by_chi2 = (fit.chi2 / freedom as f64).sqrt();
        println!("{} of {by_chi2} and {jackknife}", found.scale);
        assert!((found.scale / by_chi2.max(jackknife) - 1.0).abs() < 1e-12);
        assert_eq!(found.verdict, Verdict::Poor);
        larger.push(by_chi2 > jackknife);
    }
    assert_eq!(larger, [false, true]);
}

/// A photograph that is left out changes the parameters as a fit to the others does. The change
/// is the first step of Gauss and Newton, which errs by the change times how much the
/// information of the others moves with it: a few percent for changes of about a standard
/// error, in photographs whose errors are some percent. A tenth is allowed.
///
/// The jackknife of these changes is the factor on the errors: for c over all photographs, for
/// the a of each incidence over its own, of which the root mean square counts.
#[test]
fn photographs_left_out_move_the_estimate_as_fits_without_them() {
    let angles = [5.0, 30.0];
    let mut cases = 0;
    for (kernel, per_angle_a) in [(Kernel::Eq1, false), (Kernel::Lobe, true)] {
        let sheet = truth(kernel, LobeShape::Radial, 3.4, 0.33, 0.5);
        let table = table(&sheet, &angles, 20.0);
        let shots = params(7, sheet, &angles, &[150.0, 200.0, 250.0], camera(2e4));
        let scene = scene(&shots, &table);
        let choice = Choice {
            kernel,
            per_angle_a,
            ..SHARED
        };
        let first = usize::from(kernel.has_c());
        let fit = fitted(&scene, choice, Kind::Mtf);
        let at = &fit.solution.parameters;
        let loss = Loss::Mtf(&scene);
        let layout = Layout::of(choice, &scene);
        let left_out = LeftOut::all(&scene, &loss, &layout, &fit);
        let errors: Vec<f64> = fit
            .values()
            .take(at.len())
            .map(|value| value.standard_error / value.value)
            .collect();
        // Changes by fits, in standard errors.
        let mut all = vec![Vec::new(); at.len()];
        for (i, change) in left_out.each.iter().enumerate() {
            let other = fitted(&scene.without(i), choice, Kind::Mtf);
            let mut most = 0.0_f64;
            for k in 0..at.len() {
                let expected = (other.solution.parameters[k] - at[k]) / errors[k];
                let found = change[k] / errors[k];
                println!("{i} {k}: {found:+.3} {expected:+.3}");
                assert!(
                    (found - expected).abs() < 0.1 * expected.abs() + 0.02,
                    "{i} {k}"
                );
                most = most.max(expected.abs());
                if k < first || !per_angle_a || scene.shots[i].place.group == k - first {
                    all[k].push(expected);
                }
                cases += 1;
            }
            let moved = left_out.moved(i, &fit).expect("it is one of them");
            assert!((moved - most).abs() < 0.1 * most + 0.02, "{moved} {most}");
        }
        let squares: Vec<f64> = all
            .iter()
            .map(|own| {
                let n = own.len() as f64;
                let mean = own.iter().sum::<f64>() / n;
                own.iter().map(|v| (v - mean).powi(2)).sum::<f64>() * (n - 1.0) / n
            })
            .collect();
        let (of_c, of_a) = squares.split_at(first);
        let of_a = of_a.iter().sum::<f64>() / of_a.len() as f64;
        let expected = of_c.iter().fold(of_a, |most, &own| most.max(own)).sqrt();
        let scale = left_out.scale(&scene, &fit);
        println!("jackknife {scale:.3} {expected:.3}");
        assert!((scale / expected - 1.0).abs() < 0.1, "{scale} {expected}");
    }
    assert_eq!(cases, 6 * (2 + 2));
}

/// The jackknife of a mean is its standard error: that of 1, 2, 6 is sqrt(7/3). Without one
/// each the means are 4, 3.5 and 1.5.
#[test]
fn jackknife_of_a_mean_is_its_variance() {
    assert!((variance(&[4.0, 3.5, 1.5]) - 7.0 / 3.0).abs() < 1e-14);
}
