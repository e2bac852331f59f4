//! Planted numbers, found again: `fit simulate` and then `fit estimate`.
//!
//! `fit simulate` makes the photographs in the spatial domain, from the closed form of the ideal
//! cube. `fit estimate` works in the frequency domain, with a baked table. The two share no formula
//! of blur.

use tests::estimate::{json, numbers};
use tests::files::{argument, bake_table};
use tests::program::fit;

/// Greatest distance of an estimate from its truth, in reported standard errors.
///
/// 13 numbers are compared. If they were independent and normal, one of them would exceed this
/// limit in one of 11,000 draws of the noise. The seeds are fixed. So the limit does not reject bad
/// luck; it rejects standard errors that are reported too small.
const STANDARD_ERRORS: f64 = 4.5;

#[test]
fn planted_numbers_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sheets: [(&str, &str, &str, &str, &str); 3] = [
        (
            "eq1",
            "triangular-pair",
            "0,20,40",
            "30",
            "--lobe radial --per-angle a,mu",
        ),
        (
            "angular",
            "triangular-pair",
            "0,30",
            "30",
            "--lobe separable --shared a,mu",
        ),
        (
            "single",
            "triangular",
            "15,35",
            "47",
            "--lobe radial --shared a,mu",
        ),
    ];
    let mut compared = 0;
    for (name, design, incidence, azimuth, options) in sheets {
        let table = bake_table(here, design, incidence, azimuth);
        fit(
            here,
            &format!(
                "simulate {} -o {name}",
                argument(&format!("tests/tests/all/planted/{name}.toml"))
            ),
        )
        .done();
        let truth = json(&here.join(name).join("truth.json"));
        let kernel = truth["truth"]["kernel"].as_str().unwrap();
        let manifest = format!("{name}/captures.toml");
        let files = format!("estimate {manifest} --table {table} -o result.json --kernel {kernel}");
        fit(here, &format!("{files} {options}")).done();
        let result = json(&here.join("result.json"));
        assert_eq!(result["kernel"], truth["truth"]["kernel"]);
        for number in numbers(&result, &truth) {
            println!("{name}: {number:?} score {:.2}", number.score());
            assert!(number.score().abs() < STANDARD_ERRORS, "{name}: {number:?}");
            assert!(number.relative().abs() < 0.02, "{name}: {number:?}");
            compared += 1;
        }
    }
    assert_eq!(compared, 7 + 3 + 3);
}
