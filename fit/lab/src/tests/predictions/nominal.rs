//! Nominal sheets: their tables, and what they predict.

use edges::names::Spectrum;
use estimator::predict::{Places, predict};
use estimator::result::{ByHand, Nominal, Spread, TableResult};

/// Every sheet brings a table of its own cell, and its luminance at normal incidence is the product
/// of its published or assumed numbers.
#[test]
fn every_nominal_sheet_predicts_from_its_own_table() {
    // mu, and the share of light that ideal cubes return: two thirds of triangular ones, all of
    // full ones. The reflectances are from an independent trial: eta mu = 0.401 at index 1.4926,
    // to three digits, where the front of index 1.49 reflects 0.0004 less.
    let expected = [
        ("prism-0.1", 0.602, 2.0 / 3.0),
        ("prism-0.2", 0.602, 2.0 / 3.0),
        // Two passes of a front of index 1.49 at normal incidence: (1 - 0.0387)^2.
        ("prism-0.1-tir", 0.924, 2.0 / 3.0),
        ("prism-0.2-tir", 0.924, 2.0 / 3.0),
        ("hollow-0.2", 0.740, 1.0),
        ("published", 0.252, 2.0 / 3.0),
    ];
    assert_eq!(Nominal::all().len(), expected.len());
    let mut compared = 0;
    for (name, mu, share) in expected {
        let sheet = Nominal::named(name).expect("a sheet");
        let table = sheet.table().expect("a table");
        let own = || TableResult::of(&table);
        let places = |incidence_deg| Places {
            floating_distance_mm: vec![300.0, 3000.0],
            incidence_deg,
            azimuth_deg: Some(0.0),
            frequency_per_mm: vec![0.0, 0.1],
        };
        let result = sheet.result(own(), None, 0.25, 0.5);
        assert!(result.is_by_hand() && result.warnings.iter().any(|text| text.contains(name)));
        let found = predict(&result, &table, &places(vec![0.0])).expect("predictions");
        for one in &found {
            let luminance = one.luminance.expect("mu is known");
            assert!(
                (luminance / (0.25 * mu * share) - 1.0).abs() < 0.002,
                "{name}: {luminance}"
            );
            compared += 1;
        }
        // A farther image is blurred more by all of them.
        assert!(found[0].mtf[1] > found[found.len() - 1].mtf[1], "{name}");
        let own_mu = result
            .mu
            .as_ref()
            .and_then(|mu| mu.at(0.0))
            .expect("mu is known");
        let halved = sheet.result(own(), Some(0.5 * own_mu), 0.25, 0.5);
        let halved = predict(&halved, &table, &places(vec![0.0])).expect("predictions");
        let ratio = halved[0].luminance.expect("mu is given") / found[0].luminance.expect("known");
        assert!((ratio - 0.5).abs() < 1e-12, "{name}: {ratio}");
        let steep = predict(&result, &table, &places(vec![12.5, 40.0])).expect("all around");
        assert_eq!(steep.len(), 8);
    }
    assert_eq!(compared, 24);
    assert!(Nominal::named("prism").is_none());
}

/// The published numbers are those of each incidence.
#[test]
fn the_published_sheet_has_its_numbers_at_each_incidence() {
    let sheet = Nominal::named("published").expect("a sheet");
    let table = sheet.table().expect("a table");
    let result = sheet.result(TableResult::of(&table), None, 0.25, 0.5);
    let a = result.a_times_r.expect("the kernel is angular");
    let mu = result.mu.expect("mu is known");
    let cases = [
        (0.0, 735.0, 0.252),
        (20.0, 509.0, 0.231),
        (45.0, 191.0, 0.202),
    ];
    for (incidence_deg, expected_a, expected_mu) in cases {
        assert_eq!(a.at(incidence_deg), Some(expected_a));
        assert_eq!(mu.at(incidence_deg), Some(expected_mu));
    }
    println!("{} incidences", cases.len());
}

/// No sheet is sharper than the ideal waves of its own cubes. `published` is less sharp by little
/// at normal incidence, because its edge length was taken so.
#[test]
fn no_sheet_is_sharper_than_ideal_waves() {
    let mut cases = 0;
    for sheet in Nominal::all() {
        let table = sheet.table().expect("a table");
        let own = sheet.result(TableResult::of(&table), None, 0.25, 0.5);
        let ideal = ByHand {
            c_mm: own.c_mm.and_then(|c| c.value).expect("c is known"),
            spread: Spread::Wave(Spectrum::monochromatic(550.0).expect("a wavelength")),
            angular_spread_mrad: None,
            mu: None,
            half_mirror: 0.25,
            pixel_pitch_mm: 0.5,
        };
        let ideal = ideal.result(TableResult::of(&table));
        let places = Places {
            floating_distance_mm: vec![50.0, 150.0, 500.0, 3000.0],
            incidence_deg: vec![0.0, 15.0, 30.0, 40.0],
            azimuth_deg: Some(30.0),
            frequency_per_mm: vec![],
        };
        let [own, ideal] =
            [&own, &ideal].map(|result| predict(result, &table, &places).expect("predictions"));
        for (own, ideal) in own.iter().zip(&ideal) {
            let pair = own.mtf50_per_mm.zip(ideal.mtf50_per_mm);
            let Some((sharp, sharpest)) = pair else {
                continue;
            };
            let ratio = sharp / sharpest;
            assert!(ratio < 1.0 + 1e-9, "{}: {own:?} {ratio}", sheet.name);
            if sheet.name == "published" && own.incidence_deg == 0.0 {
                // By transforms of the aperture in numpy: 0.85 at 50 mm to 0.984 at 3000 mm.
                assert!((0.84..0.99).contains(&ratio), "{own:?} {ratio}");
            }
            cases += 1;
        }
    }
    println!("{cases} cases");
    assert!(cases > 100);
}
