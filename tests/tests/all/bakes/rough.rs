//! MTF of rough facets: their blur is a spread of angles, so it grows with the distance.

use serde_json::Value;
use std::f64::consts::PI;
use tests::files::{argument, bake_table};
use tests::program::{bake, fit};

/// The MTF of rough facets is that of smooth facets times exp(-2 (pi s f)^2).
///
/// Three perpendicular facets of roughness alpha spread light by s = 2 m alpha R across the plane
/// of incidence. Within this plane, s is larger by the factor cos(inside) / cos(outside).
#[test]
fn the_blur_of_rough_facets_grows_with_the_distance() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (alpha, index) = (5e-4, 1.49_f64);
    let manifest = argument("tests/captures/public_shared/captures.toml");
    let smooth = bake_table(here, "triangular-pair", "0:45:15", "30");
    let options = "--kernel eq1 --lobe separable --shared a,mu";
    let files = format!("estimate {manifest} --table {smooth} -o r.json");
    fit(here, &format!("{files} {options}")).done();
    let files = "trace triangular-pair.obj -o rough.h5 --method rays";
    let light = "--refractive-index 1.49 --incidence 0,30 --azimuth 30";
    let rough = "--rays 1048576 --roughness 0.0005";
    bake(here, &format!("{files} {light} {rough}")).done();
    // A result belongs to the options of its table. The options are changed here, so that this
    // result can be used with the table of rough facets.
    let result = std::fs::read_to_string(here.join("r.json")).unwrap();
    let mut result: Value = serde_json::from_str(&result).unwrap();
    result["table"]["cell"]["options"] = "--roughness 0.0005".into();
    std::fs::write(here.join("rough.json"), result.to_string()).unwrap();
    let predicted = |[result, table]: [&str; 2]| -> Value {
        let places = "--distance 75,150,300 --incidence 0,30 --azimuth 30 --json";
        let files = format!("predict {result} --table {table}");
        // 75 mm lies outside of the photographs, which a warning says.
        let run = fit(here, &format!("{files} {places}"));
        assert_eq!(run.code, Some(0), "{}", run.err);
        serde_json::from_str(&run.out).unwrap()
    };
    let tables = [["r.json", &smooth], ["rough.json", "rough.h5"]];
    let [smooth, rough] = tables.map(predicted);
    let numbers = |list: &Value| -> Vec<f64> {
        let list = list.as_array().unwrap().iter();
        list.map(|number| number.as_f64().unwrap()).collect()
    };
    let frequencies = numbers(&smooth["frequency_per_mm"]);
    let pairs = smooth["predictions"].as_array().unwrap().iter();
    let pairs = pairs.zip(rough["predictions"].as_array().unwrap());
    let (mut cases, mut worst) = (0, 0.0_f64);
    for (smooth, rough) in pairs {
        assert_eq!(smooth["distance_mm"], rough["distance_mm"]);
        let outside = smooth["incidence_deg"].as_f64().unwrap().to_radians();
        let inside = (outside.sin() / index).asin();
        let grown = match smooth["axis"].as_str() {
            Some("tangential") => inside.cos() / outside.cos(),
            _ => 1.0,
        };
        let spread = 2.0 * index * alpha * smooth["distance_mm"].as_f64().unwrap() * grown;
        let curves = numbers(&smooth["mtf"])
            .into_iter()
            .zip(numbers(&rough["mtf"]));
        for (frequency, (smooth, rough)) in frequencies.iter().zip(curves) {
            let expected = smooth * (-2.0 * (PI * spread * frequency).powi(2)).exp();
            worst = worst.max((rough - expected).abs());
            cases += 1;
        }
    }
    println!("{cases} values of 12 curves, within {worst:.4} of the closed form");
    // A relative error of x changes exp(-x) by x exp(-x) <= 0.37 times that error. x is the
    // variance, up to a factor. 700,000 rays give it to 4.5 sqrt(2 / N) = 0.8 %. Bins are an eighth
    // of the spread wide, and their width^2 / 12 is 0.13 % of the variance. Light near edges adds
    // an error of the order of alpha. So the limit is 1.2 % x 0.37 and what alpha adds.
    assert!(worst < 0.005, "{worst}");
    assert!(cases >= 12 * 50, "{cases}");
}
