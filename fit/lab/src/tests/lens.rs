//! Lenses that no OTF exp(-(f blur)^p) describes, planted in space: a perfect round pupil, a halo,
//! sharpening of the pixels, an astigmatic lens.

use rayon::prelude::*;

use crate::planted::{camera, params, table, truth};
use crate::simulate::photograph::photograph;
use crate::simulate::{Params, PlantedCamera, PlantedEdge, PlantedSheet};
use crate::study::{campaign as manifest_of, source as source_of};
use edges::names::{Kernel, LobeShape};
use edges::photographs::captures::Shot;
use estimator::estimate::campaign::campaign;
use estimator::estimate::{Candidates, Estimated, Kind, Options, Progress, Value, Verdict};

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

/// Estimates a campaign. Further references are the source edge across these normals, degrees.
fn estimated(params: &Params, further_deg: &[f64], loss: Kind) -> Estimated {
    let table = table(&params.truth, &INCIDENCE, 20.0);
    let mut manifest = manifest_of(params, &[]);
    let name = |k: usize| format!("source-{k}");
    let further = (0..further_deg.len()).map(|k| Shot::named(name(k), 1.0));
    manifest.references.extend(further);
    let own = source_of(params, photograph);
    let photo = |shot: &Shot| {
        let asked = shot.image.to_str().unwrap();
        let Some(k) = (0..further_deg.len()).find(|&k| asked == name(k)) else {
            return own(shot);
        };
        let other = Params {
            seed: params.seed + 7919 * (k as u64 + 1),
            reference: Some(PlantedEdge {
                normal_deg: further_deg[k],
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

/// Prints errors and verdicts of several draws.
#[test]
#[ignore = "prints: for measurements"]
fn lenses_by_draws() {
    let draws: u64 = std::env::var("DRAWS").map_or(4, |n| n.parse().unwrap());
    let mut cases = departing();
    cases.push(("ideal", camera(4e4)));
    for (name, camera) in cases {
        for loss in [Kind::Edge, Kind::Mtf] {
            let all: Vec<String> = (0..draws)
                .into_par_iter()
                .map(|seed| {
                    let found = estimated(&planted(900 + seed, camera.clone(), false), &[], loss);
                    let [percent, z] = off(&found);
                    format!(
                        "  {:+.2?} % {z:+.1?} se {:?} {:.2} terms {:?} ref {:.2}",
                        percent.map(|v| 100.0 * v),
                        found.goodness.verdict,
                        found.goodness.scale,
                        terms(&found),
                        found.scene.reference.as_ref().unwrap().reduced_chi2,
                    )
                })
                .collect();
            println!("{name} {loss:?}\n{}", all.join("\n"));
        }
    }
    let camera = PlantedCamera {
        sigma_px: 0.5,
        sigma_down_px: Some(0.7),
        ..camera(4e4)
    };
    for further in [&[][..], &[94.0]] {
        for seed in 0..draws {
            let found = estimated(
                &planted(900 + seed, camera.clone(), true),
                further,
                Kind::Edge,
            );
            let [percent, z] = off(&found);
            println!(
                "astigmatic {further:?} {:+.2?} % {z:+.1?} se {:?} {:.2} terms {:?}",
                percent.map(|v| 100.0 * v),
                found.goodness.verdict,
                found.goodness.scale,
                terms(&found),
            );
        }
    }
    let _ = Verdict::Good;
}
