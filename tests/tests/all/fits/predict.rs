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
    let options = "--kernel eq1 --lobe separable --shared a,mu";
    let files = format!("estimate {manifest} --table {fitted} -o r.json");
    fit(here, &format!("{files} {options}")).done();

    let predict = |table: &str, incidence: &str| {
        let places = format!("--distance 300 --incidence {incidence} --azimuth 30 --json");
        fit(here, &format!("predict r.json --table {table} {places}"))
    };
    let mtf50 = |text: &str| -> f64 {
        let report: Value = serde_json::from_str(text).unwrap();
        report["predictions"][0]["mtf50_per_mm"].as_f64().unwrap()
    };
    let own = predict(&fitted, "15").done();
    let between = predict(&fitted, "20");
    assert!(between.err.contains("interpolated"), "{}", between.err);

    // Within the photographs (150 and 300 mm, 0 to 45 degrees) nothing is said of them. Beyond them
    // a warning says so, and the JSON names the key.
    assert!(!between.err.contains("outside"), "{}", between.err);
    let beyond = format!(
        "predict r.json --table {fitted} --distance 200,400 --incidence 15 --azimuth 30 \
            --frequency 0,2"
    );
    let csv = fit(here, &beyond);
    let said = "warning: distance 400 mm lies outside of the photographs (150 to 300 mm)";
    assert!(csv.err.contains(said), "{}", csv.err);
    let rows: Vec<Vec<&str>> = csv
        .out
        .lines()
        .map(|row| row.split(',').collect())
        .collect();
    let head = "luminance_low,luminance_high,mtf_low,mtf_high,outside";
    assert_eq!(rows[0][8..].join(","), head);
    // Two distances, two axes, two frequencies.
    assert_eq!(rows.len(), 1 + 8);
    for row in &rows[1..] {
        let number = |k: usize| -> f64 { row[k].parse().unwrap() };
        assert_eq!(row.len(), 13);
        assert!(number(8) < number(5) && number(5) < number(9), "{row:?}");
        assert!(
            number(10) <= number(7) && number(7) <= number(11),
            "{row:?}"
        );
        let outside = if row[0] == "400" {
            "floating_distance_mm"
        } else {
            ""
        };
        assert_eq!(row[12], outside);
    }
    // MTF50 does not depend on the frequencies that are listed.
    let few = fit(here, &format!("{beyond} --json")).out;
    let report: Value = serde_json::from_str(&few).unwrap();
    let all = predict(&fitted, "15").done();
    assert_eq!(
        mtf50(&few),
        mtf50(&all),
        "eq1 has one blur at all distances"
    );
    assert_eq!(
        report["predictions"][2]["outside"][0],
        "floating_distance_mm"
    );
    assert!(report["warnings"].to_string().contains("distance 400 mm"));

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
        let places = "--distance 300 --incidence 15 --azimuth 30";
        let files = format!("predict r.json --table {fitted} --model {model}");
        fit(here, &format!("{files} {places}"))
    };
    named("proposed").done();
    let refused = named("saito");
    assert_eq!(refused.code, Some(1));
    let remedy = "r.json: is the fit of another model; fit this one: fit estimate captures.toml \
    --table table.h5 --model saito";
    assert!(refused.err.contains(remedy), "{}", refused.err);
}
