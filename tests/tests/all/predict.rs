//! Predictions with another table than that of the fit: one of the same cell with other directions,
//! and one of another cell, which is refused.

use serde_json::Value;
use tests::files::{argument, bake_table};
use tests::program::fit;

#[test]
fn any_table_of_the_fitted_cell_predicts() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let manifest = argument("tests/captures/public_shared/captures.toml");
    let fitted = bake_table(here, "triangular-pair", "0:45:15", "30");
    let options = ["--kernel", "eq1", "--lobe", "separable", "--shared", "a,mu"];
    let files = ["estimate", &manifest, "--table", &fitted, "-o", "r.json"];
    fit(here, &[&files[..], &options].concat()).done();

    let predict = |table: &str, incidence: &str| {
        let places = [
            "--distance",
            "300",
            "--incidence",
            incidence,
            "--azimuth",
            "30",
            "--json",
        ];
        fit(
            here,
            &[&["predict", "r.json", "--table", table], &places[..]].concat(),
        )
    };
    let mtf50 = |text: &str| -> f64 {
        let report: Value = serde_json::from_str(text).unwrap();
        report["predictions"][0]["mtf50_per_mm"].as_f64().unwrap()
    };
    let own = predict(&fitted, "15").done();
    let between = predict(&fitted, "20");
    assert!(between.err.contains("interpolated"), "{}", between.err);

    let elsewhere = here.join("elsewhere");
    std::fs::create_dir(&elsewhere).unwrap();
    let table = |design: &str| {
        let table = bake_table(&elsewhere, design, "0:45:5", "30");
        elsewhere.join(table).display().to_string()
    };
    let dense = table("triangular-pair");
    assert_eq!(mtf50(&predict(&dense, "15").done()), mtf50(&own));
    // This run gives no warning, because no direction is interpolated.
    let held = predict(&dense, "20").done();
    assert_ne!(mtf50(&held), mtf50(&between.out));

    let refused = predict(&table("triangular"), "15");
    assert_eq!(refused.code, Some(1));
    assert!(
        refused.err.contains("a table of another cell"),
        "{}",
        refused.err
    );

    // `--model` is allowed if it names the model of the result.
    let named = |model: &str| {
        let places = ["--distance", "300", "--incidence", "15", "--azimuth", "30"];
        let files = ["predict", "r.json", "--table", &fitted, "--model", model];
        fit(here, &[&files[..], &places].concat())
    };
    named("proposed").done();
    let refused = named("saito");
    assert_eq!(refused.code, Some(1));
    let remedy = "r.json: is the fit of another model; fit this one: fit estimate captures.toml \
    --table table.h5 --model saito";
    assert!(refused.err.contains(remedy), "{}", refused.err);
}
