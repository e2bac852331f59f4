//! The published loop by samples (`--forward render`), with the real program on photographs whose
//! truth is known.
//!
//! It must agree with the closed form within its sampling error. Differences of the MTF are
//! weighted by their noise (`--loss mtf`) or all alike, as published (`--loss mse`).

use serde_json::Value;
use tests::estimate::{json, numbers};
use tests::files::{argument, bake_table};
use tests::program::fit;

/// Returns the values of all parameters, in the order of the covariance.
fn values(result: &Value) -> Vec<f64> {
    let of = |parameter: &Value| -> Vec<f64> {
        match parameter["per_angle"].as_array() {
            Some(list) => list.iter().filter_map(|p| p["value"].as_f64()).collect(),
            None => vec![parameter["value"].as_f64().expect("a number")],
        }
    };
    ["c_mm", "a_per_mm", "mu"]
        .iter()
        .flat_map(|key| of(&result[key]))
        .collect()
}

/// Estimates by samples agree with the closed form to five standard deviations of the samples: by
/// angle with differences all alike, and shared by all angles with differences in units of noise.
///
/// 8 randomisations give the standard deviation to 27 %. By Student's t with 7 degrees of freedom,
/// each of the 10 numbers exceeds five of them with a probability of 0.0016. The samples are fixed.
/// A further 5e-5 is allowed for all other differences of the two models.
#[test]
fn the_render_lands_on_the_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let parameters = argument("tests/tests/all/planted/eq1.toml");
    fit(here, &format!("simulate {parameters} -o by-angle")).done();
    let table = bake_table(here, "triangular-pair", "0:45:5", "30");
    let shared = argument("tests/captures/public_shared");
    for (photographs, terms, loss, samples, count) in [
        ("by-angle", "--lobe radial --per-angle a,mu", "mse", 32, 7),
        (&*shared, "--lobe separable --shared a,mu", "mtf", 16, 3),
    ] {
        let estimate = |options: &str| {
            let files = format!("{photographs}/captures.toml --table {table} -o result.json");
            let terms = format!("--kernel eq1 {terms} --loss {loss}");
            let run = fit(here, &format!("estimate {files} {terms} {options}"));
            assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
            json(&here.join("result.json"))
        };
        let closed = estimate("");
        assert_eq!(closed["forward"], "spectral");
        assert!(closed["sampling"].is_null());
        let truth = json(&here.join(photographs).join("truth.json"));
        for number in numbers(&closed, &truth) {
            // The photographs are one fixed set, as in the test of the campaigns. The first limit
            // rejects standard errors that are reported too small. The second rejects those that
            // are far too large (`mse` has up to 4 times the errors of `mtf`).
            assert!(number.score().abs() < 4.5, "{loss}: {number:?}");
            assert!(number.standard_error < 0.02 * number.truth, "{number:?}");
        }
        let render = estimate(&format!("--forward render --samples {samples}"));
        assert_eq!(render["forward"], "render");
        assert_eq!(render["loss"], loss);
        assert!(render["iterations"].as_u64().is_some_and(|n| n < 200));
        let errors = render["sampling"]["standard_error"].as_array().unwrap();
        let (closed, found) = (values(&closed), values(&render));
        assert_eq!([closed.len(), errors.len()], [count; 2]);
        for ((exact, found), error) in closed.iter().zip(&found).zip(errors) {
            let error = error.as_f64().unwrap();
            assert!(
                (found - exact).abs() < 5.0 * error + 5e-5 * exact,
                "{photographs}: {found} against {exact}, sampling error {error}"
            );
            // A far too large sampling error would pass the check above.
            assert!(error < 0.01 * exact, "{photographs}: {error} of {exact}");
        }
    }
}

/// A kernel without samples, and a loss that does not compare MTFs, are refused as wrong usage.
#[test]
fn what_the_render_cannot_do_is_refused() {
    let manifest = argument("tests/captures/public_shared/captures.toml");
    for (options, said) in [
        ("--kernel wave", "has no samples"),
        ("--loss edge", "compares MTFs"),
    ] {
        let files = format!("estimate {manifest} --table none.h5 --forward render");
        let run = fit(std::path::Path::new("."), &format!("{files} {options}"));
        assert_eq!(run.code, Some(2), "{}\n{}", run.line, run.err);
        assert!(run.err.contains(said), "{}", run.err);
    }
}
