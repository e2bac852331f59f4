//! Tests of predictions: crossings against closed forms, intervals against differences and over
//! drawn campaigns, and the remarks on places outside of the photographs.

use rayon::prelude::*;
use serde_json::json;
use tables::{Symmetry, Table};

use crate::planted::{Stream, camera, params, table, truth};
use crate::simulate::photograph::photograph;
use crate::study::trial::{campaign, source};
use crate::tests::estimates::azimuth::all_azimuths;
use crate::tests::studies::statistics::check;
use edges::names::{Kernel, LobeShape, ParameterId, ParameterKind};
use estimator::estimate::campaign::campaign as estimated;
use estimator::estimate::{Candidates, Options, Progress};
use estimator::predict::{Places, Prediction, Viewpoint, predict, remarks};
use estimator::result::{Number, Parameter, ResultFile, TableResult};

/// A result with correlated errors: c, the spread at 0 and at 40 degrees, and mu.
pub(super) fn result(kernel: Kernel, lobe: LobeShape, table: &Table) -> ResultFile {
    let spread = match kernel {
        Kernel::Angular => 600.0,
        Kernel::Saito | Kernel::SaitoSurface | Kernel::Guo | Kernel::Mrm => 2e-3,
        _ => 4.0,
    };
    let size = if kernel == Kernel::SaitoSurface {
        1e-3
    } else {
        0.24
    };
    let at = |incidence_deg: f64, value: f64| {
        let error = 0.01 * value;
        json!({"incidence_deg": incidence_deg, "value": value, "standard_error": error})
    };
    let key = spread_key(kernel);
    let of = |name: &str| {
        (kernel.has_lobe() && name == key)
            .then(|| json!({"per_angle": [at(0.0, spread), at(40.0, 0.8 * spread)]}))
    };
    let number = json!({"value": size, "standard_error": 0.01 * size});
    let errors = [0.01 * size, 0.01 * spread, 0.02 * spread, 0.005];
    let matrix: Vec<Vec<f64>> = (0..4)
        .map(|i| {
            let correlation = |j: usize| if i == j { 1.0 } else { 0.3 };
            (0..4)
                .map(|j| correlation(j) * errors[i] * errors[j])
                .collect()
        })
        .collect();
    let size_key = if kernel == Kernel::SaitoSurface {
        "surface_roughness"
    } else {
        "c_mm"
    };
    serde_json::from_value(json!({
        "kernel": kernel, "lobe": kernel.has_lobe().then_some(lobe), "loss": "edge",
        "iterations": 1,
        "stop": "small step", "seconds": 0.1,
        "wavelength_nm": (kernel == Kernel::Wave).then_some("550"),
        "c_mm": kernel.has_c().then(|| number.clone()).filter(|_| size_key == "c_mm"),
        "surface_roughness": (size_key != "c_mm").then_some(number),
        "a_per_mm": of("a_per_mm"), "a_times_r": of("a_times_r"), "roughness": of("roughness"),
        "mu": {"value": 0.25, "standard_error": 0.005},
        "covariance": {
            "names": [size_key, format!("{key}_at_0"), format!("{key}_at_40"), "mu"],
            "matrix": matrix,
        },
        "bounds": {}, "candidates": [], "captures": [],
        "camera": {"pixel_pitch_mm": 0.08, "lens_blur_mm": null, "lens_exponent": null},
        "half_mirror": 0.25, "table": serde_json::to_value(TableResult::of(table)).unwrap(),
        "seen_in_mirror": false,
        "domain": {"floating_distance_mm": [150.0, 200.0], "incidence_deg": [0.0, 20.0],
            "azimuth_deg": [30.0, 30.0]},
        "warnings": ["the reference is unsharp"]
    }))
    .unwrap()
}

fn spread_key(kernel: Kernel) -> &'static str {
    ParameterKind::spread_of(kernel).name()
}

fn places(floating_distance_mm: f64, incidence_deg: f64, frequency_per_mm: Vec<f64>) -> Places {
    Places {
        floating_distance_mm: vec![floating_distance_mm],
        incidence_deg: vec![incidence_deg],
        azimuth_deg: Some(20.0),
        frequency_per_mm,
    }
}

/// MTF50 and MTF10 come from the model: two listed frequencies give what many give, and the
/// separable lobe has them in closed form, at a / 2 pi and 0.9 a / pi along both axes. The search
/// ends at 1e-12 of the frequency, and the lobe, a straight line, rounds by less than that.
#[test]
fn crossings_do_not_depend_on_the_listed_frequencies() {
    let planted = truth(Kernel::Lobe, LobeShape::Separable, 4.0, 0.24, 0.25);
    let table = table(&planted, &[0.0, 20.0, 40.0], 20.0);
    let mut cases = 0;
    for incidence_deg in [0.0, 20.0, 40.0] {
        let result = result(Kernel::Lobe, LobeShape::Separable, &table);
        let a = 4.0 * (1.0 - 0.2 * incidence_deg / 40.0);
        let many: Vec<f64> = (0..100).map(|k| 0.05 * f64::from(k)).collect();
        for listed in [vec![], vec![0.0, 2.0], many] {
            let places = places(170.0, incidence_deg, listed);
            for found in predict(&result, &table, &places).unwrap() {
                let crossings = [found.mtf50_per_mm, found.mtf10_per_mm].map(Option::unwrap);
                let expected = [0.5, 0.9].map(|part| part * a / std::f64::consts::PI);
                for (found, expected) in crossings.into_iter().zip(expected) {
                    assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected}");
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 3 * 3 * 2 * 2);
}

/// Intervals are those of differences: each parameter of the result is moved by a small part of its
/// error to either side, and the changes of all numbers are summed with the covariance. A
/// difference over 1e-3 of an error of 2 % has an error of 1e-10 of the third derivative, and the
/// rounding of 1e-15 over a step of 2e-5 leaves 1e-10. The derivatives of lobes and lines are those
/// of their interpolation, to 1e-4. Two results have an angular spread and dihedral errors, which are
/// moved in the table that is predicted from.
#[test]
fn intervals_are_those_of_differences() {
    let planted = truth(Kernel::Wave, LobeShape::Radial, 4.0, 0.24, 0.25);
    let table = table(&planted, &[0.0, 10.0, 40.0], 20.0);
    let mut cases = 0;
    let mut worst = 0.0_f64;
    for (kernel, is_bent) in [
        (Kernel::Eq1, false),
        (Kernel::Angular, false),
        (Kernel::Shift, false),
        (Kernel::Lobe, false),
        (Kernel::Wave, false),
        (Kernel::Saito, false),
        (Kernel::SaitoSurface, false),
        (Kernel::Mrm, false),
        (Kernel::Eq1, true),
        (Kernel::Shift, true),
    ] {
        let shape = if kernel.is_baseline() {
            LobeShape::Ggx
        } else {
            LobeShape::Radial
        };
        let mut result = result(kernel, shape, &table);
        if is_bent {
            result = with_bent_cubes(&result);
        }
        for incidence_deg in [0.0, 10.0, 40.0] {
            let places = places(170.0, incidence_deg, vec![0.3, 0.9]);
            let predicted = |result: &ResultFile| {
                predict(result, &result.seen(&table).unwrap(), &places).unwrap()
            };
            let numbers = |result: &ResultFile| -> Vec<f64> {
                let all = predicted(result);
                all.iter().flat_map(parts).collect()
            };
            let covariance = &result.covariance;
            let n = covariance.names.len();
            let entry = |i: usize, j: usize| covariance.matrix[i][j].unwrap();
            let slopes: Vec<Vec<f64>> = (0..n)
                .map(|i| {
                    let step = 1e-3 * entry(i, i).sqrt();
                    let moved = |by| numbers(&with(&result, covariance.names[i], by));
                    let sides = [moved(step), moved(-step)];
                    let pairs = sides[0].iter().zip(&sides[1]);
                    pairs.map(|(a, b)| (a - b) / (2.0 * step)).collect()
                })
                .collect();
            let all = predicted(&result);
            let intervals: Vec<[f64; 2]> = all.iter().flat_map(ends).collect();
            for (k, (value, [low, high])) in numbers(&result).into_iter().zip(intervals).enumerate()
            {
                let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
                let variance: f64 = pairs
                    .map(|(i, j)| slopes[i][k] * entry(i, j) * slopes[j][k])
                    .sum();
                let expected = 1.959_964 * variance.sqrt();
                let off = (high - value - expected)
                    .abs()
                    .max((value - low - expected).abs());
                worst = worst.max(off / expected);
                assert!(
                    off < 1e-4 * expected,
                    "{kernel:?} {k}: {low} {value} {high} {expected}"
                );
                cases += 1;
            }
        }
    }
    println!("{cases} intervals, off by up to {worst:.1e} of themselves");
    assert_eq!(cases, 10 * 3 * 2 * 5);
}

/// Intervals hold the error of eta by rays, and that of a fitted azimuth: half the difference
/// between predictions one standard error to either side. Both come on top of the covariance, as
/// independent errors. All numbers are sums of few terms, so rounding alone differs.
#[test]
fn intervals_hold_the_errors_of_rays_and_of_the_azimuth() {
    for (incidence_deg, expected) in [(20.0, 0.0), (40.0, 0.1)] {
        let of_light = intervals_hold_both_errors(incidence_deg);
        println!("{incidence_deg} deg: the azimuth adds {of_light:.3} of mu's error to the light");
        assert!(of_light >= expected, "{of_light}");
    }
}

/// Checks the errors of all numbers at an incidence. Returns the part of the luminance's error that
/// the azimuth causes, over the rest.
fn intervals_hold_both_errors(incidence_deg: f64) -> f64 {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.24, 0.25);
    let mut table = all_azimuths(&planted, &[0.0, 20.0, 40.0]);
    let result = result(Kernel::Eq1, LobeShape::Radial, &table);
    let places = || places(170.0, incidence_deg, vec![0.3, 0.9]);
    let halves = |result: &ResultFile, table: &Table| -> Vec<f64> {
        let all = predict(result, table, &places()).unwrap();
        let ends = all.iter().flat_map(ends);
        ends.map(|[low, high]| 0.5 * (high - low) / 1.959_964)
            .collect()
    };
    let plain = halves(&result, &table);
    assert_eq!(plain.len(), 2 * 5);
    // The azimuth.
    let mut turned = result.clone();
    turned.azimuth_deg = Some(Number {
        value: Some(7.0),
        standard_error: Some(3.0),
    });
    let numbers = |azimuth: f64| -> Vec<f64> {
        let places = Places {
            azimuth_deg: Some(azimuth),
            ..places()
        };
        let all = predict(&result, &table, &places).unwrap();
        all.iter().flat_map(parts).collect()
    };
    let sides = numbers(23.0).into_iter().zip(numbers(17.0));
    let by_azimuth: Vec<f64> = sides.map(|(a, b)| 0.5 * (a - b).abs()).collect();
    let of_light = by_azimuth[0] / plain[0];
    let found = halves(&turned, &table);
    let mut most = 0.0_f64;
    for ((found, plain), by_azimuth) in found.iter().zip(&plain).zip(&by_azimuth) {
        let expected = plain.hypot(*by_azimuth);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        most = most.max(by_azimuth / plain);
    }
    println!("the azimuth adds up to {most:.2} of the other errors");
    assert!(most > 0.01);
    // The rays: 3 % of eta, in the luminance alone.
    let eta = table.retroreflected.clone();
    let luminance = numbers(20.0)[0];
    table.standard_error = eta * 0.03;
    for (k, (found, plain)) in halves(&result, &table).into_iter().zip(plain).enumerate() {
        let azimuths = table.direction(incidence_deg, Some(20.0)).unwrap();
        let share = azimuths.standard_error / azimuths.retroreflected;
        let by_rays = if k % 5 == 0 { luminance * share } else { 0.0 };
        let expected = plain.hypot(by_rays);
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{k}: {found} {expected}"
        );
    }
    of_light
}

/// The numbers of a prediction that have intervals.
fn parts(found: &Prediction) -> Vec<f64> {
    let single = [found.luminance, found.mtf50_per_mm, found.mtf10_per_mm];
    let single = single.map(|value| value.expect("light returns"));
    single
        .into_iter()
        .chain(found.mtf.iter().copied())
        .collect()
}

/// The intervals of a prediction, in the order of [`parts`].
fn ends(found: &Prediction) -> Vec<[f64; 2]> {
    let single = [
        found.luminance_interval,
        found.mtf50_per_mm_interval,
        found.mtf10_per_mm_interval,
    ];
    let single = single.map(|interval| interval.expect("there is a covariance"));
    single
        .into_iter()
        .chain(found.mtf_interval.iter().copied())
        .collect()
}

/// Key of the dihedral errors.
const ERRORS: &str = "dihedral_errors_mrad";

/// A result that also has an angular spread and dihedral errors, each with an error that depends on
/// those of the other parameters.
fn with_bent_cubes(result: &ResultFile) -> ResultFile {
    let mut bent = serde_json::to_value(result).unwrap();
    let number = |value: f64| json!({"value": value, "standard_error": 0.1 * value.abs()});
    let added = [0.3, 0.2, -0.1, 0.15];
    bent["angular_spread_mrad"] = number(added[0]);
    bent[ERRORS] = json!([number(added[1]), number(added[2]), number(added[3])]);
    let kinds = [ParameterKind::AngularSpread].into_iter();
    let kinds = kinds.chain(ParameterKind::DIHEDRAL_ERRORS);
    let own = &result.covariance;
    let known = own.names.len();
    let names = own.names.iter().map(|id| json!(id));
    let names = names.chain(kinds.map(|kind| json!(kind.shared())));
    bent["covariance"]["names"] = names.collect();
    let error = |i: usize| match i.checked_sub(known) {
        None => own.matrix[i][i].unwrap().sqrt(),
        Some(k) => 0.1 * added[k].abs(),
    };
    let entry = |i: usize, j: usize| {
        let correlation = if i == j { 1.0 } else { 0.3 };
        correlation * error(i) * error(j)
    };
    let all = 0..known + added.len();
    let row = |i: usize| -> Vec<f64> { all.clone().map(|j| entry(i, j)).collect() };
    bent["covariance"]["matrix"] = all.clone().map(row).collect();
    serde_json::from_value(bent).unwrap()
}

/// A result in which one parameter is moved.
pub(super) fn with(result: &ResultFile, id: ParameterId, by: f64) -> ResultFile {
    let mut moved = serde_json::to_value(result).unwrap();
    let within = match id.at {
        None => "value",
        Some(0.0) => "per_angle/0/value",
        Some(_) => "per_angle/1/value",
    };
    let kinds = ParameterKind::DIHEDRAL_ERRORS;
    let edge = kinds.iter().position(|&kind| kind == id.kind);
    let key = edge.map_or(id.kind.name().to_owned(), |k| format!("{ERRORS}/{k}"));
    // A kernel without the parameter has null in its place.
    if let Some(value) = moved.pointer_mut(&format!("/{key}/{within}")) {
        *value = json!(value.as_f64().unwrap() + by);
    }
    serde_json::from_value(moved).unwrap()
}

/// Remarks name each quantity that leaves the photographs, and only those; they repeat the
/// warnings of the result, and say what an older result lacks.
#[test]
fn remarks_name_what_leaves_the_photographs() {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.24, 0.25);
    let mut table = table(&planted, &[0.0, 20.0, 45.0], 20.0);
    table.provenance.symmetry = Symmetry {
        rotations: 6,
        mirror_deg: Some(0.0),
    };
    let result = result(Kernel::Eq1, LobeShape::Radial, &table);
    let at = |r_mm: f64, incidence_deg: f64, azimuth_deg: f64| Viewpoint {
        incidence_deg,
        azimuth_deg: Some(azimuth_deg),
        r_mm,
    };
    let mut cases = 0;
    for (place, said) in [
        (at(150.0, 0.0, 30.0), &[][..]),
        (at(200.0, 20.0, 30.0), &[]),
        // Symmetry makes these azimuths one.
        (at(170.0, 10.0, 90.0), &[]),
        (at(170.0, 10.0, -30.0), &[]),
        (at(170.0, 10.0, 390.0), &[]),
        (
            at(170.0, 45.0, 30.0),
            &["incidence 45 deg lies outside of the photographs (0 to 20 deg)"],
        ),
        (
            at(100.0, 10.0, 30.0),
            &[
                "distance 100 mm lies outside of the photographs (150 to 200",
                "the kernel eq1 takes the blur by diffraction as the same",
            ],
        ),
        (
            at(170.0, 10.0, 20.0),
            &["azimuth 20 deg lies outside of the photographs (30 deg)"],
        ),
        (
            at(201.0, 20.01, 20.0),
            &[
                "distance 201",
                "incidence 20.01",
                "azimuth 20 ",
                "the kernel eq1 takes",
            ],
        ),
    ] {
        let found = remarks(&result, &table, &[place]).unwrap();
        assert!(found[0].starts_with("the result has a warning"));
        assert_eq!(found.len(), 1 + said.len(), "{found:?}");
        for (remark, said) in found[1..].iter().zip(said) {
            assert!(remark.starts_with(said), "{remark}");
        }
        cases += 1;
    }
    assert_eq!(cases, 9);
    let found = remarks(
        &result,
        &table,
        &[at(170.0, 30.0, 30.0), at(170.0, 45.0, 30.0)],
    )
    .unwrap();
    assert!(found[1].starts_with("incidence 30 to 45 deg"), "{found:?}");

    let mut old = result.clone();
    (old.domain, old.seen_in_mirror) = (None, None);
    let found = remarks(&old, &table, &[at(170.0, 45.0, 20.0)]).unwrap();
    assert!(found[1].contains("no key domain"), "{found:?}");
    // The table is of azimuth 20, so both answers differ.
    assert!(found[2].contains("no key seen_in_mirror"), "{found:?}");
    assert_eq!(found[2].matches(" /mm if it is ").count(), 2);
    assert_eq!(found.len(), 3);
}

/// Intervals of predictions hold the truth: MTF at the frequencies where it is truly 0.5
/// (tangential) and 0.25 (sagittal), MTF50, and luminance, between the distances and incidences of
/// the photographs. Kernels are eq1 and angular, in half of the campaigns with one a and one mu for
/// each incidence. Limits are those of [`check`].
#[test]
#[ignore = "45 processor-seconds: `make test-full` runs it"]
fn statistics_of_predictions() {
    const DRAWS: u64 = 600;
    const FIGURES: [&str; 4] = ["MTF at 0.5", "MTF at 0.25", "MTF50", "luminance"];
    let draw = |seed: u64| -> [f64; 4] {
        let mut stream = Stream(0x93ed << 20 | seed);
        let (c, mu) = (stream.between(0.2, 0.5), stream.between(0.3, 0.8));
        let kernel = [Kernel::Eq1, Kernel::Angular][(seed % 2) as usize];
        let a = stream.between(2.0, 6.0)
            * if kernel == Kernel::Angular {
                200.0
            } else {
                1.0
            };
        let planted = truth(kernel, LobeShape::Radial, a, c, mu);
        let table = table(&planted, &[5.0, 15.0, 30.0], 20.0);
        let electrons = stream.between(5e3, 4e4);
        let (angles, distances) = ([5.0, 30.0], [150.0, 250.0]);
        let mut params = params(seed, planted, &angles, &distances, camera(electrons));
        // Each incidence at one distance: 5 degrees at 150 mm, 30 degrees at 250 mm.
        params.captures = vec![params.captures.remove(0), params.captures.remove(2)];
        let per_angle = Some(seed % 4 >= 2);
        let options = Options::new(Candidates {
            kernels: vec![kernel],
            per_angle_a: per_angle,
            per_angle_mu: per_angle,
            ..Candidates::proposed()
        });
        let photographs = source(&params, photograph);
        let campaign = campaign(&params, &[]);
        let found = estimated(&campaign, &photographs, &table, &options, &Progress::SILENT);
        let found = ResultFile::new(&found.unwrap(), TableResult::of(&table), 0.0);
        let shared = |value: f64| {
            Parameter::Shared(Number {
                value: Some(value),
                standard_error: None,
            })
        };
        let mut true_result = found.clone();
        true_result.c_mm = Some(Number {
            value: Some(c),
            standard_error: None,
        });
        true_result.mu = Some(shared(mu));
        true_result.a_per_mm = found.a_per_mm.as_ref().map(|_| shared(a));
        true_result.a_times_r = found.a_times_r.as_ref().map(|_| shared(a));
        let at = |result: &ResultFile, frequencies: Vec<f64>| {
            predict(result, &table, &places(200.0, 15.0, frequencies)).unwrap()
        };
        let exact = at(
            &true_result,
            (1..400).map(|k| 0.01 * f64::from(k)).collect(),
        );
        let half = exact[0].mtf50_per_mm.unwrap();
        let quarter = 0.01 * (1 + exact[1].mtf.iter().position(|&m| m < 0.25).unwrap()) as f64;
        let exact = at(&true_result, vec![half, quarter]);
        let found = at(&found, vec![half, quarter]);
        assert!(
            found.iter().all(|found| found.outside.is_empty()),
            "{found:?}"
        );
        let figures = |all: &[Prediction]| {
            let [tangential, sagittal] = [&all[0], &all[1]].map(parts);
            [tangential[3], sagittal[4], tangential[1], tangential[0]]
        };
        let highs = {
            let [tangential, sagittal] = [&found[0], &found[1]].map(ends);
            [tangential[3], sagittal[4], tangential[1], tangential[0]].map(|[_, high]| high)
        };
        let (value, exact) = (figures(&found), figures(&exact));
        std::array::from_fn(|i| (value[i] - exact[i]) * 1.959_964 / (highs[i] - value[i]))
    };
    let draws: Vec<[f64; 4]> = (0..DRAWS).into_par_iter().map(draw).collect();
    for (i, figure) in FIGURES.into_iter().enumerate() {
        let pulls: Vec<f64> = draws.iter().map(|draw| draw[i]).collect();
        check(figure, &pulls, 0.1);
    }
}
