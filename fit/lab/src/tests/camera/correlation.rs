//! Noise that neighbouring pixels share, planted by filters whose effect is known.

use rayon::prelude::*;

use crate::planted::{SHARED, Stream, camera, fitted, params, table, truth};
use crate::simulate;
use crate::simulate::Params;
use crate::simulate::photograph::{light, photograph};
use crate::study::trial::{campaign, source};
use crate::tests::studies::statistics::{check, is_corrected, pulls_of_fit};
use edges::names::{Kernel, LobeShape};
use estimator::estimate::{Kind, Scene};

/// Weights of a filter of the noise along each axis.
type Filter = &'static [f64];

const WHITE: Filter = &[1.0];
const PAIRS: Filter = &[0.5, 0.5];
const SMOOTH: Filter = &[0.25, 0.5, 0.25];
const BLOCKS: Filter = &[0.25; 4];

/// Returns a photograph whose noise is filtered along both axes. Light and edge stay as they are.
fn filtered(
    filter: Filter,
) -> impl Fn(&Params, Option<usize>) -> Result<Vec<f32>, simulate::error::Error> + Sync {
    move |params, index| {
        let light = light(params, index)?;
        let noisy = photograph(params, index)?;
        let (width, height) = (params.camera.width, params.camera.height);
        let noise: Vec<f64> = noisy
            .iter()
            .zip(&light)
            .map(|(n, l)| f64::from(*n) - l)
            .collect();
        // Beyond the border the noise of the other side goes on.
        let along = |noise: &[f64], step: [usize; 2]| -> Vec<f64> {
            let at = |x: usize, y: usize| noise[y % height * width + x % width];
            let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let mean = |(x, y): (usize, usize)| {
                let terms = filter.iter().enumerate();
                terms
                    .map(|(k, w)| w * at(x + k * step[0], y + k * step[1]))
                    .sum()
            };
            places.map(mean).collect()
        };
        let noise = along(&along(&noise, [1, 0]), [0, 1]);
        Ok(light
            .iter()
            .zip(noise)
            .map(|(l, n)| (l + n) as f32)
            .collect())
    }
}

/// Draws a scene of two photographs and a reference with filtered noise.
fn drawn(seed: u64, filter: Filter) -> (Scene, [f64; 3]) {
    let mut stream = Stream(0xc0de << 20 | seed);
    let (a, c) = (stream.between(2.0, 6.0), stream.between(0.2, 0.5));
    let mu = stream.between(0.3, 0.8);
    let planted = truth(Kernel::Eq1, LobeShape::Radial, a, c, mu);
    let incidence = [5.0, 30.0];
    let table = table(&planted, &incidence, 20.0);
    let params = params(seed, planted, &incidence, &[200.0], camera(1e4));
    let scene = Scene::of(
        &campaign(&params, &[]),
        &table,
        &source(&params, filtered(filter)),
    );
    (scene.expect("the edges are visible"), [c, a, mu])
}

/// Checks the factor by which correlated noise counts. Means of n pixels scatter as those of n
/// independent ones do, because each filter's weights sum to 1, while a pixel's variance falls by
/// the sum of their squares. So the factor is 1 over that sum, for both axes.
///
/// The factor of one photograph of N pixels scatters by sqrt(2 x 289 / N) of itself, for the 289
/// lags; the mean of n photographs by 1/sqrt(n) of that. The limit is 4 of these. It also is 4 %
/// too low at most: the light's profile takes one number of each bin of 60 pixels and more.
#[test]
fn correlated_noise_counts_by_its_autocorrelation() {
    for filter in [WHITE, PAIRS, SMOOTH, BLOCKS] {
        let squares: f64 = filter.iter().map(|w| w * w).sum();
        let expected = 1.0 / (squares * squares);
        let found: Vec<f64> = (0..4_u64)
            .into_par_iter()
            .flat_map_iter(|seed| {
                let (scene, _) = drawn(seed, filter);
                let all: Vec<f64> = scene.shots.iter().map(|shot| shot.pixels.excess).collect();
                all
            })
            .collect();
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        println!(
            "{filter:?}: {mean:.3} for {expected:.3} in {} photographs",
            found.len()
        );
        if filter.len() == 1 {
            assert!(found.iter().all(|&factor| factor == 1.0), "{found:?}");
        } else {
            let scatter = (2.0 * 289.0 / (192.0 * 128.0) / found.len() as f64).sqrt();
            let off = mean / expected - 1.0;
            assert!(
                off < 4.0 * scatter && off > -4.0 * scatter - 0.04,
                "{mean} {expected}"
            );
        }
    }
}

/// Checks that standard errors hold where neighbours share their noise. Without the factor the
/// errors would be 2.7 times too small.
#[test]
#[ignore = "minutes: `make test-full` runs it"]
fn statistics_of_correlated_noise() {
    const DRAWS: u64 = 160;
    let losses = [Kind::Mtf, Kind::Edge];
    let draws: Vec<(bool, [[f64; 3]; 2])> = (0..DRAWS)
        .into_par_iter()
        .map(|seed| {
            let (scene, truth) = drawn(100 + seed, SMOOTH);
            let pulls = losses.map(|kind| pulls_of_fit(&fitted(&scene, SHARED, kind), truth));
            (is_corrected(&scene), pulls)
        })
        .collect();
    for (k, loss) in losses.iter().enumerate() {
        for (i, parameter) in ["c", "a", "mu"].into_iter().enumerate() {
            // The mu of the MTFs is wrong where even light was taken for uneven.
            let counted = draws
                .iter()
                .filter(|(corrected, _)| !corrected || (k, i) != (0, 2));
            let pulls: Vec<f64> = counted.map(|(_, draw)| draw[k][i]).collect();
            check(&format!("{loss:?} {parameter}"), &pulls, 0.1);
        }
    }
    let corrected = draws.iter().filter(|(corrected, _)| *corrected).count();
    println!("light corrected in {corrected} of {DRAWS} campaigns");
    assert!(corrected < 5, "{corrected}");
}
