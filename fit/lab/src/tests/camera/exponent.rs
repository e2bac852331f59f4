//! A lens whose exponent is not 2, from photographs to standard errors.
//!
//! The simulator's lens is a Gaussian. The OTF exp(-(f blur)^1.6) is a sum of Gaussians, so the
//! light through such a lens is the same sum of the simulator's lights.

use nalgebra::{DMatrix, DVector};

use crate::planted::{SHARED, camera, fitted, params, table, truth};
use crate::simulate::photograph::light;
use crate::simulate::{Params, PixelNoise, PlantedCamera};
use crate::study::trial::{campaign, source};
use crate::tests::studies::statistics::pulls_of_fit;
use edges::names::Kernel;
use edges::names::LobeShape;
use estimator::estimate::{Joint, Kind, Layout, Scene};

/// Exponent of the lens.
const EXPONENT: f64 = 1.6;

/// Blur length of the lens, pixels.
const BLUR_PX: f64 = 2.6;

/// Number of Gaussians.
const GAUSSIANS: usize = 16;

/// Returns the standard deviations of the Gaussians in units of the blur length, their weights, and
/// the largest error of their sum between frequencies of 0 and 8 over the blur length.
fn mixture() -> (Vec<f64>, Vec<f64>, f64) {
    // The OTF is not smooth at frequency 0, so wide Gaussians are needed too.
    let step = 120_f64.powf(1.0 / (GAUSSIANS - 1) as f64);
    let sigmas: Vec<f64> = (0..GAUSSIANS).map(|k| 0.05 * step.powi(k as i32)).collect();
    let places: Vec<f64> = (0..400)
        .map(|k| 0.0005 * f64::from(k))
        .chain((20..800).map(|k| 0.01 * f64::from(k)))
        .collect();
    let gaussians = DMatrix::from_fn(places.len(), GAUSSIANS, |i, k| {
        (-2.0 * (std::f64::consts::PI * sigmas[k] * places[i]).powi(2)).exp()
    });
    let wanted = places.iter().map(|x| (-x.powf(EXPONENT)).exp());
    let wanted = DVector::from_iterator(places.len(), wanted);
    let parts = gaussians.clone().svd(true, true);
    let weights = parts.solve(&wanted, 1e-12).expect("both sides were made");
    let error = (&gaussians * &weights - wanted).amax();
    (sigmas, weights.as_slice().to_vec(), error)
}

/// Returns the pixels of a photograph through the lens, with the noise that the camera states.
fn photograph(params: &Params, index: Option<usize>, sigmas: &[f64], weights: &[f64]) -> Vec<f32> {
    let planted = &params.camera;
    let mut level = vec![0.0; planted.width * planted.height];
    let whole: f64 = weights.iter().sum();
    for (sigma, weight) in sigmas.iter().zip(weights) {
        let params = Params {
            camera: PlantedCamera {
                sigma_px: sigma * BLUR_PX,
                ..planted.clone()
            },
            ..params.clone()
        };
        let part = light(&params, index).expect("it can be simulated");
        for (level, part) in level.iter_mut().zip(part) {
            *level += weight / whole * part;
        }
    }
    let number = index.map_or(0, |index| index as u64 + 1);
    let noisy = level.iter().enumerate().map(|(pixel, level)| {
        let mut noise = PixelNoise::new(params.seed, number, pixel as u64);
        let electrons = noise.poisson(level * planted.full_well_e);
        ((electrons + planted.read_noise_e * noise.normal()) / planted.full_well_e) as f32
    });
    noisy.collect()
}

/// Returns the scene of a campaign through the lens, and what was planted: c, a, mu.
fn planted(seed: u64) -> (Scene, [f64; 3]) {
    let (sigmas, weights, error) = mixture();
    let (a, c, mu) = (3.4, 0.31, 0.6);
    let sheet = truth(Kernel::Eq1, LobeShape::Radial, a, c, mu);
    let incidence = [5.0, 30.0];
    let table = table(&sheet, &incidence, 20.0);
    let params = params(seed, sheet, &incidence, &[150.0, 300.0], camera(1e4));
    let photos = source(&params, |params, index| {
        Ok(photograph(params, index, &sigmas, &weights))
    });
    let scene = Scene::of(&campaign(&params, &[]), &table, &photos).expect("it holds edges");
    // What the sum of Gaussians leaves is small beside the noise of each MTF. The reference and the
    // captures share it, so that most of it cancels.
    for shot in &scene.shots {
        let half = shot
            .view
            .mtf50_per_mm()
            .expect("the MTF falls below one half");
        let [_, noise] = shot.view.mtf_at(half).expect("within the measured ones");
        assert!(error < 0.2 * noise, "{error:.1e} {noise:.1e}");
    }
    (scene, [c, a, mu])
}

/// Estimates by both losses hold within their stated errors if the exponent is 1.6. The mean square
/// of 8 pulls of one parameter is chi-square with 8 degrees of freedom over 8. It is between 0.043
/// and 4.33 but for 1 case in 30,000 at each end.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn stated_errors_hold_for_a_lens_with_the_exponent_1_6() {
    const DRAWS: u64 = 8;
    let mut squares = [[0.0; 3]; 2];
    for seed in 0..DRAWS {
        let (scene, truth) = planted(700 + seed);
        let lens = &scene.optics.camera.lenses[0];
        assert_eq!(scene.optics.lens.len(), 2, "{lens:?}");
        for (kind, squares) in [Kind::Mtf, Kind::Edge].into_iter().zip(&mut squares) {
            let pulls = pulls_of_fit(&fitted(&scene, SHARED, kind), truth);
            println!("{kind:?} {lens:?} {pulls:.2?}");
            for (sum, pull) in squares.iter_mut().zip(pulls) {
                *sum += pull * pull / DRAWS as f64;
            }
        }
    }
    println!("mean squares of {DRAWS} pulls: {squares:.2?}");
    for square in squares.into_iter().flatten() {
        assert!((0.043..4.33).contains(&square), "{squares:?}");
    }
}

/// The likelihood's derivatives by blur and exponent of the lens match differences. The gradient of
/// the sum of squares, with the nuisances at their optimum, is 2 J^T r. Central differences with h
/// = 1e-3 have an error of h^2/6 third derivatives: 1e-6 of the change of the gradient over a unit.
/// The gradient is large 5 % off the optimum, and 1e-3 of it is enough to find any wrong column.
#[test]
fn derivatives_by_blur_and_exponent_of_the_lens_match_differences() {
    let (scene, [c, a, _]) = planted(700);
    let at = DVector::from_vec(vec![c.ln(), a.ln()]);
    let joint = Joint::new(&scene, SHARED, &at);
    let layout = Layout::of(SHARED, &scene);
    let mut off = joint.start(&at);
    off.add_scalar_mut(0.05);
    let (residuals, jacobian) = joint.evaluate(&layout, &off, &mut Vec::new());
    let gradient = 2.0 * jacobian.tr_mul(&residuals);
    let h = 1e-3;
    let mut cases = 0;
    for i in 0..off.len() {
        let squares = |h: f64| {
            let mut moved = off.clone();
            moved[i] += h;
            joint
                .evaluate(&layout, &moved, &mut Vec::new())
                .0
                .norm_squared()
        };
        let difference = (squares(h) - squares(-h)) / (2.0 * h);
        println!("{i}: {:.5e} {difference:.5e}", gradient[i]);
        assert!(
            (gradient[i] - difference).abs() < 1e-3 * gradient.amax(),
            "{i}: {} {difference}",
            gradient[i]
        );
        // A wrong sign would be noticed.
        assert!(gradient[i].abs() > 5e-3 * gradient.amax(), "{i}");
        cases += 1;
    }
    assert_eq!(cases, 4);
}
