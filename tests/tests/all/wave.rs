//! The kernel `wave` on the command line: estimate, prediction, and refusals if the table or the
//! wavelength does not allow it.

use serde_json::Value;
use tests::estimate::{json, numbers};
use tests::files::{argument, bake_table, bake_table_with};
use tests::program::fit;

#[test]
fn waves_from_photographs_to_prediction() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let params = argument("tests/tests/all/planted/wave.toml");
    fit(here, &["simulate", &params, "-o", "waves"]).done();
    let table = bake_table(here, "triangular-pair", "0,30", "30");
    let manifest = "waves/captures.toml";
    // mu is shared by an option. Otherwise BIC gives the two incidences different values of mu by
    // chance in 2 of 100 campaigns.
    let shared = ["--shared", "mu"];
    let files = ["estimate", manifest, "--table", &table, "-o", "r.json"];
    // The manifest names the wavelengths, so `--kernel auto` tries `wave`.
    fit(here, &[&files[..], &shared].concat()).done();
    let result = json(&here.join("r.json"));
    assert_eq!(result["kernel"], "wave");
    assert_eq!(result["wavelength_nm"], "450:0.2,550:0.5,620:0.3");
    assert!(result["a_per_mm"].is_null() && result["a_times_r"].is_null());
    assert!(result["lobe"].is_null());
    let candidates = result["candidates"].as_array().unwrap();
    assert_eq!(
        candidates
            .iter()
            .filter(|row| row["kernel"] == "wave")
            .count(),
        1
    );
    let found = numbers(&result, &json(&here.join("waves/truth.json")));
    assert_eq!(found.len(), 2, "c and mu");
    for number in found {
        // One of the two numbers would exceed 4.5 standard errors in one of 70,000 draws of the
        // noise. The seed is fixed.
        println!("{number:?} score {:.2}", number.score());
        assert!(number.score().abs() < 4.5, "{number:?}");
    }

    let places = [
        "--distance",
        "150",
        "--incidence",
        "0",
        "--azimuth",
        "30",
        "--frequency",
        "0,1",
    ];
    let predict = |table: &str| {
        fit(
            here,
            &[
                &["predict", "r.json", "--table", table, "--json"],
                &places[..],
            ]
            .concat(),
        )
    };
    let report: Value = serde_json::from_str(&predict(&table).done()).unwrap();
    for place in report["predictions"].as_array().unwrap() {
        let mtf = [0, 1].map(|i| place["mtf"][i].as_f64().unwrap());
        assert!(
            (mtf[0] - 1.0).abs() < 1e-12 && mtf[1] > 0.0 && mtf[1] < 1.0,
            "{place}"
        );
    }

    // A table of rays holds no polygons, which the kernel `wave` needs.
    let sampled = here.join("sampled");
    std::fs::create_dir(&sampled).unwrap();
    let options = ["--method", "rays", "--rays", "65536"];
    let rays = bake_table_with(&sampled, "triangular-pair", "0,30", "30", &options);
    let rays = sampled.join(rays).display().to_string();
    let estimate = |table: &str, manifest: &str, kernel: &str| {
        fit(
            here,
            &["estimate", manifest, "--table", table, "--kernel", kernel],
        )
    };
    let refused = estimate(&rays, manifest, "wave");
    assert_eq!(refused.code, Some(1));
    assert!(
        refused.err.contains("bake trace --method exact"),
        "{}",
        refused.err
    );
    let left_out = estimate(&rays, manifest, "auto");
    assert_eq!(left_out.code, Some(0), "{}", left_out.err);
    assert!(
        left_out.err.contains("not among the candidates"),
        "{}",
        left_out.err
    );

    // Without a wavelength, the error names the option. With the option, the estimate works.
    let text = std::fs::read_to_string(here.join(manifest)).unwrap();
    let without: String = text
        .lines()
        .filter(|line| !line.starts_with("wavelength_nm"))
        .map(|line| format!("{line}\n"))
        .collect();
    std::fs::write(here.join("waves/dark.toml"), without).unwrap();
    let refused = estimate(&table, "waves/dark.toml", "wave");
    assert_eq!(refused.code, Some(1));
    assert!(refused.err.contains("--wavelength-nm"), "{}", refused.err);
    let files = [
        "estimate",
        "waves/dark.toml",
        "--table",
        &table,
        "--kernel",
        "wave",
    ];
    let named = ["--wavelength-nm", "450:0.2,550:0.5,620:0.3", "--json"];
    let again: Value =
        serde_json::from_str(&fit(here, &[&files[..], &named].concat()).done()).unwrap();
    assert_eq!(again["c_mm"], result["c_mm"]);
}
