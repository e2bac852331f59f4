//! Lenses that no OTF exp(-(f blur)^p) describes, planted in space: a perfect round pupil, a halo,
//! sharpening of the pixels, an astigmatic lens.

use rayon::prelude::*;

use crate::planted::{camera, params, table, truth};
use crate::simulate::photograph::photograph;
use crate::simulate::{Params, PlantedCamera, PlantedEdge, PlantedSheet};
use crate::study::{campaign as manifest_of, source as source_of};
use edges::names::{Kernel, LobeShape};
use edges::photographs::manifest::captures::Shot;
use estimator::estimate::campaign::campaign;
use estimator::estimate::{Candidates, Estimated, Kind, Options, Progress, Value, Verdict};
use estimator::model::Further;

const INCIDENCE: [f64; 2] = [0.0, 30.0];
const TRUTH: [f64; 3] = [0.33, 3.4, 0.5];

fn sheet() -> PlantedSheet {
    let [c_mm, a, mu] = TRUTH;
    truth(Kernel::Eq1, LobeShape::Radial, a, c_mm, mu)
}

/// Returns a campaign of one camera. `down` adds photographs of edges across the other axis.
fn planted(seed: u64, camera: PlantedCamera, down: bool) -> Params {
    let mut params = params(seed, sheet(), &INCIDENCE, &[150.0, 250.0], camera);
    if down {
        let mut others = params.captures.clone();
        others
            .iter_mut()
            .for_each(|shot| shot.edge.normal_deg += 90.0);
        params.captures.extend(others);
    }
    params
}

/// Estimates a campaign. Further references are the source edge across these normals, degrees, with
/// the exposure that the manifest states.
fn estimated(params: &Params, further: &[(f64, f64)], loss: Kind) -> Estimated {
    let table = table(&params.truth, &INCIDENCE, 20.0);
    let mut manifest = manifest_of(params, &[]);
    let name = |k: usize| format!("source-{k}");
    let stated = further.iter().enumerate();
    let shots = stated.map(|(k, (_, exposure))| Shot::named(name(k), *exposure));
    manifest.references.extend(shots);
    let own = source_of(params, photograph);
    let photo = |shot: &Shot| {
        let asked = shot.image.to_str().unwrap();
        let Some(k) = (0..further.len()).find(|&k| asked == name(k)) else {
            return own(shot);
        };
        let other = Params {
            seed: params.seed + 7919 * (k as u64 + 1),
            reference: Some(PlantedEdge {
                normal_deg: further[k].0,
                ..PlantedEdge::SOURCE
            }),
            ..params.clone()
        };
        source_of(&other, photograph)(shot)
    };
    let options = Options {
        loss: Some(loss),
        ..Options::new(Candidates {
            kernels: vec![Kernel::Eq1],
            per_angle_a: Some(false),
            per_angle_mu: Some(false),
            ..Candidates::proposed()
        })
    };
    campaign(&manifest, &photo, &table, &options, &Progress::SILENT).unwrap()
}

/// Returns the relative errors of c, a and mu, and these errors in standard errors.
fn off(found: &Estimated) -> [[f64; 3]; 2] {
    let best = &found.best;
    let values: [Value; 3] = [
        best.c_mm.unwrap(),
        best.spread[0],
        best.mu.as_ref().unwrap()[0],
    ];
    let by = |of: &dyn Fn(Value, f64) -> f64| [0, 1, 2].map(|k| of(values[k], TRUTH[k]));
    [
        by(&|own, truth| own.value / truth - 1.0),
        by(&|own, truth| (own.value - truth) / own.standard_error),
    ]
}

/// Returns the number of terms of each lens of an estimate.
fn terms(found: &Estimated) -> Vec<usize> {
    let lenses = found.scene.optics.camera.lenses.iter();
    lenses
        .map(|lens| lens.departure.as_ref().map_or(0, |own| own.terms.len()))
        .collect()
}

/// Cameras whose lenses depart from exp(-(f blur)^p), by name.
fn departing() -> Vec<(&'static str, PlantedCamera)> {
    let pupil = |cutoff| PlantedCamera {
        pupil_cutoff_per_px: Some(cutoff),
        ..camera(4e4)
    };
    vec![
        ("pupil 0.6", pupil(0.6)),
        ("pupil 1.0", pupil(1.0)),
        ("pupil 1.5", pupil(1.5)),
        (
            "halo 1 %, 20 px",
            PlantedCamera {
                halo_share: 0.01,
                ..camera(4e4)
            },
        ),
        (
            "sharpening 0.3",
            PlantedCamera {
                sharpening: 0.3,
                source_level: 0.8,
                ..camera(4e4)
            },
        ),
    ]
}

/// Returns a camera whose lens blurs by 0.5 pixels along x and 0.7 along y.
fn astigmatic() -> PlantedCamera {
    PlantedCamera {
        sigma_px: 0.5,
        sigma_down_px: Some(0.7),
        ..camera(4e4)
    }
}

/// Estimates campaigns of one camera with several seeds and adds up the squares of their errors of
/// c, a and mu, in standard errors. Each estimate goes to `check`.
fn squares(
    draws: u64,
    camera: &PlantedCamera,
    further_deg: Option<f64>,
    loss: Kind,
    check: impl Fn(&Estimated) + Sync,
) -> [f64; 3] {
    let draws = (0..draws).into_par_iter().map(|seed| {
        let params = planted(900 + seed, camera.clone(), further_deg.is_some());
        let further = further_deg.map(|deg| (deg, 1.0));
        let found = estimated(&params, further.as_slice(), loss);
        let [share, pulls] = off(&found);
        println!(
            "{seed} {loss:?} {share:+.4?} {pulls:+.1?} {:?}",
            terms(&found)
        );
        check(&found);
        pulls
    });
    let draws: Vec<[f64; 3]> = draws.collect();
    [0, 1, 2].map(|k| draws.iter().map(|pulls| pulls[k].powi(2)).sum())
}

/// A lens that no exponent describes gets terms, and c, a and mu hold their stated errors. The sum
/// of squares of 2 errors exceeds 18.4 once in 10,000.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn a_departing_lens_leaves_no_bias() {
    let mut cases = 0;
    for (name, camera) in departing() {
        println!("{name}");
        let all = squares(2, &camera, None, Kind::Edge, |found| {
            assert!(terms(found)[0] > 0, "{name}");
            assert_ne!(found.goodness.verdict, Verdict::Poor, "{name}");
        });
        for sum in all {
            assert!(sum < 18.4, "{name}: {all:?}");
            cases += 1;
        }
    }
    assert_eq!(cases, 15);
}

/// The same over 12 draws and for both losses: the sum of squares of 12 errors is between 1.3 and
/// 39.1 but for 1 case in 10,000 at each end.
#[test]
#[ignore = "a minute: `make test-full` runs it"]
fn stated_errors_hold_for_departing_lenses() {
    const DRAWS: u64 = 12;
    let mut cases = 0;
    for (name, camera) in departing() {
        for loss in [Kind::Edge, Kind::Mtf] {
            println!("{name}");
            let all = squares(DRAWS, &camera, None, loss, |found| {
                assert!(terms(found)[0] > 0, "{name}");
            });
            println!("{name} {loss:?}: {all:.1?}");
            for sum in all {
                assert!((1.3..39.1).contains(&sum), "{name} {loss:?}: {all:?}");
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 30);
}

/// A Gaussian lens gets no terms. By the criterion noise gives it 2 terms if it lowers chi-square
/// by 2 ln n + 4, about 18: once in 8,000; and more terms less often. The sum of squares of 6 errors
/// exceeds 27.9 once in 10,000.
#[test]
fn a_gaussian_lens_has_no_terms() {
    let all = squares(6, &camera(4e4), None, Kind::Edge, |found| {
        assert_eq!(terms(found), [0]);
        assert_eq!(found.goodness.verdict, Verdict::Good);
    });
    assert!(all.iter().all(|&sum| sum < 27.9), "{all:?}");
}

/// A lens that is not round needs a reference for each direction: with it c holds its stated error.
/// The sum of squares of 3 errors exceeds 21.1 once in 10,000. With one reference the difference between
/// the directions is put down to the sheet: c holds within four errors, which are more than twice as
/// large.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn an_astigmatic_lens_needs_two_references() {
    let all = squares(3, &astigmatic(), Some(94.0), Kind::Edge, |found| {
        assert_eq!(found.scene.optics.camera.lenses.len(), 2);
        assert_eq!(found.goodness.verdict, Verdict::Good);
        assert_eq!(found.best.choice.further, Further::NONE);
        assert!(found.scene.farthest_from_reference_deg().unwrap() < 10.0);
    });
    assert!(all.iter().all(|&sum| sum < 21.1), "{all:?}");
    let params = planted(900, astigmatic(), true);
    let [one, two] =
        [&[][..], &[(94.0, 1.0)]].map(|further| estimated(&params, further, Kind::Edge));
    let error_of_c = |found: &Estimated| found.best.c_mm.unwrap().standard_error;
    assert!(error_of_c(&one) > 2.0 * error_of_c(&two));
    assert!(off(&one)[1][0].abs() < 4.0, "{:?}", off(&one));
    assert_ne!(one.best.choice.further, Further::NONE);
    assert!(one.scene.farthest_from_reference_deg().unwrap() > 80.0);
}

/// One more reference of the same direction lowers the error of the source's light by the root of
/// 2. If its stated exposure is 3 % wrong, it is named, and mu moves by half of that. The noise of
/// the steps is 0.02 %, and the share of each depends on it by some percent.
#[test]
fn references_share_their_light() {
    let params = planted(905, camera(4e4), false);
    let [one, two, wrong] = [&[][..], &[(4.5, 1.0)], &[(4.5, 1.03)]]
        .map(|further| estimated(&params, further, Kind::Mtf));
    assert_eq!(two.scene.optics.camera.lenses.len(), 1);
    let of = |found: &Estimated| {
        let reference = found.scene.reference.as_ref().unwrap();
        (reference.photographs.len(), reference.step_relative_error)
    };
    let ((first, before), (both, after)) = (of(&one), of(&two));
    assert_eq!((first, both), (1, 2));
    // The two have the same noise but for the places of their pixels.
    assert!((before / after / 2.0_f64.sqrt() - 1.0).abs() < 0.05);
    let [_, pulls] = off(&two);
    assert!(pulls.iter().all(|pull| pull.abs() < 4.0), "{pulls:?}");
    let said = |found: &Estimated| {
        let all = found.warnings.iter();
        all.filter(|said| said.contains("all references")).count()
    };
    // Both lie off their mean.
    assert_eq!((said(&one), said(&two), said(&wrong)), (0, 0, 2));
    for loss in [Kind::Mtf, Kind::Edge] {
        let mu = |exposure| {
            let found = estimated(&params, &[(4.5, exposure)], loss);
            found.best.mu.as_ref().unwrap()[0].value
        };
        let moved = (mu(1.03) / mu(1.0)).ln() / 1.03_f64.ln();
        assert!((moved - 0.5).abs() < 0.05, "{loss:?}: {moved}");
    }
}

/// Sharpening takes at most a third of its strength of the step off the dark side: so much of the
/// step is in the mean of 3 x 3 pixels beside a sharp edge. Here that is 0.16, less than a veil of
/// 0.2 and far more than one of 0.002, below which the file cuts it off. Noise that is cut off all
/// over a dark plateau is no sharpening.
#[test]
fn sharpening_that_is_cut_off_makes_a_fit_poor() {
    let camera = |sharpening, veil, full_well_e| PlantedCamera {
        sharpening,
        veil,
        full_well_e,
        dark_ratio: 0.001,
        source_level: 0.6,
        ..camera(4e4)
    };
    let cases = [
        (camera(0.8, 0.002, 4e4), 1),
        (camera(0.8, 0.2, 4e4), 0),
        (camera(0.0, 0.0, 1e3), 0),
    ];
    let mut tried = 0;
    for (camera, changed) in cases {
        let found = estimated(&planted(31, camera, false), &[], Kind::Edge);
        let cut = found
            .scene
            .reference
            .iter()
            .flat_map(|own| &own.photographs);
        let zeros = cut.filter(|own| own.pixels.cut.zero).count();
        println!("{:?}", found.goodness);
        assert_eq!(found.goodness.reduced, changed);
        assert_eq!(found.goodness.verdict == Verdict::Poor, changed > 0);
        assert!(zeros == 1 || tried == 1, "case {tried} has to be cut off");
        tried += 1;
    }
    assert_eq!(tried, 3);
}
