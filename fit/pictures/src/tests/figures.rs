//! Pictures of curves and studies from awkward inputs: no text is cut, and none covers another.

use charts::check::faults;
use serde_json::json;

use crate::report::plot::{Shown, against, around, fitted, measured, predicted};
use crate::report::{Variable, picture};
use edges::names::{Kernel, LobeShape};
use estimator::estimate::Kind;
use estimator::predict::{Around, Axis, Prediction};
use estimator::result::{ResultFile, TableResult};
use estimator::samples::Sequence;
use lab::planted;
use lab::study::forward::{Errors, Row as Render};
use lab::study::given::Fit;
use lab::study::summary::Row;
use lab::study::{Figure, LOSSES, PARAMETERS, Speed, Study, Summary};

const FREQUENCY: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

/// Name of a photograph or sheet that is longer than a figure is wide.
fn long(k: usize) -> String {
    format!(
        "{k}_{}.tiff",
        "retroreflective_sheet_from_the_left_drawer_".repeat(3)
    )
}

fn whole(svg: &str) {
    assert_eq!(faults(svg), [""; 0]);
}

/// Predictions at all distances, incidences and azimuths; some have no curve, a gap or no interval.
fn predictions(distances: &[f64], incidences: &[f64], azimuths: &[f64]) -> Vec<Prediction> {
    let mut all = Vec::new();
    for &floating_distance_mm in distances {
        for &incidence_deg in incidences {
            for &azimuth_deg in azimuths {
                for axis in [Axis::Tangential, Axis::Sagittal] {
                    let index = all.len();
                    let width = 0.2 + 0.01 * index as f64;
                    let mut mtf: Vec<f64> = FREQUENCY.map(|f| (-width * f).exp()).to_vec();
                    if index % 7 == 6 {
                        mtf.clear();
                    } else if index % 5 == 4 {
                        mtf[2] = f64::NAN;
                    }
                    all.push(Prediction {
                        floating_distance_mm,
                        incidence_deg,
                        azimuth_deg: Some(azimuth_deg),
                        axis,
                        retroreflected: 0.5,
                        interpolated: false,
                        luminance: None,
                        luminance_interval: None,
                        mtf50_per_mm: None,
                        mtf50_per_mm_interval: None,
                        mtf10_per_mm: None,
                        mtf10_per_mm_interval: None,
                        mtf_interval: match index % 2 {
                            0 => mtf.iter().map(|m| [m - 0.05, m + 0.05]).collect(),
                            _ => Vec::new(),
                        },
                        mtf,
                        outside: if index % 3 == 0 {
                            vec!["incidence_deg"]
                        } else {
                            Vec::new()
                        },
                    });
                }
            }
        }
    }
    all
}

#[test]
fn predicted_curves() {
    let azimuths: Vec<f64> = (0..72).map(|k| 5.0 * f64::from(k)).collect();
    let incidences: Vec<f64> = (0..19).map(|k| 2.5 * f64::from(k)).collect();
    let distances = [12.345_678, 150.0, 300.0, 1e4];
    let cases = [
        predictions(&[150.0], &[0.0], &[0.0]),
        predictions(&[150.0], &[0.0], &azimuths),
        predictions(&distances, &incidences, &[30.0]),
        predictions(&distances[..2], &[0.0, 45.0], &azimuths),
        Vec::new(),
    ];
    for all in &cases {
        for frequency in [&FREQUENCY[..], &FREQUENCY[..1], &[]] {
            let mut all = all.clone();
            for p in &mut all {
                p.mtf.truncate(frequency.len());
                p.mtf_interval.truncate(frequency.len());
            }
            whole(&predicted(&all, frequency));
            for variable in [Variable::Incidence, Variable::Azimuth, Variable::Distance] {
                whole(&against(&all, frequency, variable));
            }
        }
    }
}

#[test]
fn curves_all_around() {
    let place = |k: usize| Around {
        floating_distance_mm: 150.0 * k as f64,
        incidence_deg: 12.5,
        azimuth_deg: k.is_multiple_of(2).then_some(355.0),
        direction_deg: vec![0.0, 90.0, 180.0, 270.0, 360.0],
        mtf: match k {
            3 => Vec::new(),
            _ => FREQUENCY.map(|f| vec![1.0 / (1.0 + f); 5]).to_vec(),
        },
    };
    for count in [1, 4, 30] {
        let all: Vec<Around> = (0..count).map(place).collect();
        whole(&around(&all, &FREQUENCY));
    }
}

#[test]
fn measured_curves() {
    let mtf = [1.0, 0.9, f64::NAN, 0.4, 0.01];
    let names: Vec<String> = (0..72).map(long).collect();
    let shown = |k: usize| Shown {
        name: names[k].clone(),
        frequency: &FREQUENCY,
        mtf: &mtf,
        standard_error: &[0.01; 5],
        half: k.is_multiple_of(2).then_some(1.7),
    };
    let one = Shown {
        frequency: &FREQUENCY[..1],
        mtf: &mtf[..1],
        standard_error: &[0.1],
        ..shown(0)
    };
    whole(&measured(&[one], "cycles/pixel"));
    for count in [1, 5, 72] {
        let all: Vec<Shown> = (0..count).map(shown).collect();
        whole(&measured(&all, "1/mm"));
    }
}

/// Draws the result of photographs at `incidences` angles, `distances` distances, two edges each.
#[test]
fn fitted_curves() {
    let truth = planted::truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.2, 0.5);
    let table = planted::table(&truth, &[0.0, 30.0], 20.0);
    for (incidences, distances, edges) in [(1, 1, 1), (2, 2, 2), (19, 8, 1), (3, 30, 2)] {
        let mut captures = Vec::new();
        for k in 0..incidences * distances * edges {
            captures.push(json!({
                "image": long(k), "incidence_deg": 2.5 * (k % incidences) as f64,
                "floating_distance_mm": 150.125 * (1 + k / incidences % distances) as f64,
                "edge_angle_deg": 5.0 + 90.0 * (k / incidences / distances) as f64,
                "mtf50_per_mm": null, "loss": 0.1, "warnings": [],
                "curves": { "frequency_per_mm": FREQUENCY, "measured": [1.0, 0.8, 0.5, 0.1, 0.0],
                    "standard_error": [0.1, 0.1, 0.1, 0.1, 0.1], "modelled": [1.0, 0.7, 0.5, 0.2, 0.0] },
            }));
        }
        let result: ResultFile = serde_json::from_value(json!({
            "kernel": "eq1", "loss": "edge", "iterations": 1, "stop": "converged", "seconds": 0.0,
            "c_mm": null, "a_per_mm": null, "a_times_r": null, "mu": null,
            "covariance": { "names": [], "matrix": [] }, "bounds": {}, "candidates": [],
            "captures": captures, "half_mirror": 0.25, "warnings": [],
            "camera": { "pixel_pitch_mm": 0.1, "lens_blur_mm": null, "lens_exponent": null },
            "table": TableResult::of(&table),
        }))
        .expect("a result");
        whole(&fitted(&result));
    }
}

#[test]
fn studies() {
    let figure = |value: f64| Figure { value, error: 0.1 };
    let row = |(parameter, loss)| Row {
        parameter,
        loss,
        rmse_over_bound: figure(1.1),
        bias_over_standard_error: figure(0.0),
        coverage: figure(0.95),
    };
    let pairs = PARAMETERS
        .into_iter()
        .flat_map(|p| LOSSES.map(|loss| (p, loss)));
    for rows in [Vec::new(), pairs.map(row).collect()] {
        whole(&picture::drawn(&Summary {
            campaigns: 100_000,
            refused: Vec::new(),
            counted: 99_999,
            cut_off: 0,
            rows,
            verdicts: Vec::new(),
        }));
    }
    for seconds in [0.0, 1e-6, 2.5, 1e7] {
        let fit = |loss: Kind| Fit {
            kernel: Kernel::Eq1,
            loss,
            seconds,
            reduced_chi2: 1.0,
            error_over_bound: (loss == Kind::Mtf).then_some(1e4 * seconds),
        };
        whole(&picture::photographs(&Study {
            kernel: Kernel::Eq1,
            photographs: 72,
            seconds_to_measure: seconds,
            parameters: Vec::new(),
            fits: [Kind::Mtf, Kind::Mse, Kind::Edge].map(fit).to_vec(),
        }));
        let render = |k: i32| Render {
            samples: 2_usize.pow(k as u32),
            sequence: if k % 2 == 0 {
                Sequence::Sobol
            } else {
                Sequence::Independent
            },
            samples_in_all: 1,
            seconds_to_draw: seconds,
            seconds_to_evaluate: seconds,
            seconds: 1e-6 * 10_f64.powi(k),
            iterations: 1,
            errors: Errors {
                a: Some(10_f64.powi(-k)),
                c: (k != 3).then_some(0.1),
                mu: None,
            },
            gradient_noise: [None; 2],
        };
        for count in [0, 1, 12] {
            whole(&picture::speed(&Speed {
                photographs: 20,
                spectral_seconds: seconds,
                spectral_seconds_to_evaluate: seconds,
                spectral_iterations: 1,
                pixel_noise: Errors {
                    a: None,
                    c: Some(1e-3),
                    mu: None,
                },
                randomisations: 1,
                rows: (0..count).map(render).collect(),
            }));
        }
    }
}
