//! Tests of the nearest lobe for renderers and of predictions drawn against one variable. The lobe
//! is found again if it describes the sheet, else it is the nearest one; it is written in three
//! forms. What is no table of the sheet is refused.

use std::path::Path;

use crate::export::{Form, Nearest, mitsuba, nearest};
use crate::report::Variable;
use crate::report::plot;
use edges::names::Kernel;
use edges::names::LobeShape;
use estimator::predict::{Fitted, Places, around, predict};
use estimator::result::ResultFile;
use estimator::result::TableResult;
use lab::planted;
use serde_json::{Value, json};
use tables::Table;
use tables::options::Back;

fn table() -> Table {
    let truth = planted::truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.2, 0.5);
    planted::table(&truth, &[0.0, 30.0], 20.0)
}

/// A result file with these entries.
fn result(table: &Table, entries: Value) -> ResultFile {
    let number = |value: f64| json!({ "value": value, "standard_error": 1e-6 });
    let mut all = json!({
        "loss": "edge", "iterations": 1, "stop": "converged", "seconds": 0.0,
        "c_mm": null, "a_per_mm": null, "a_times_r": null, "mu": number(0.5),
        "covariance": { "names": [], "matrix": [] }, "bounds": {}, "candidates": [], "captures": [],
        "camera": { "pixel_pitch_mm": 0.1, "lens_blur_mm": null, "lens_exponent": null },
        "half_mirror": 0.25, "table": TableResult::of(table), "warnings": [],
    });
    for (key, value) in entries.as_object().expect("an object") {
        all[key] = value.as_f64().map_or(value.clone(), number);
    }
    serde_json::from_value(all).expect("a result")
}

fn at(
    result: &ResultFile,
    table: &Table,
    floating_distance_mm: f64,
    incidence_deg: f64,
) -> Nearest {
    nearest(
        result,
        table,
        floating_distance_mm,
        incidence_deg,
        Some(20.0),
    )
    .expect("light returns")
}

#[test]
fn a_lobe_is_its_own_nearest() {
    let table = table();
    let own = result(
        &table,
        json!({ "kernel": "mrm", "lobe": "ggx", "roughness": 7e-4 }),
    );
    for (distance, incidence) in [(150.0, 0.0), (300.0, 30.0), (600.0, 30.0)] {
        let lobe = at(&own, &table, distance, incidence);
        // Golden sections end at 1e-6 of the logarithm. A sum of squares is flat up to the root of
        // the rounding (1e-16).
        assert!((lobe.alpha / 7e-4 - 1.0).abs() < 1e-5, "{lobe:?}");
        assert!(lobe.rms < 1e-5 && (lobe.reflectance - 0.5).abs() < 1e-12);
    }
}

/// If a roughness is only bounded from above, the other roughness alone makes the lobe.
#[test]
fn a_roughness_that_is_only_bounded_is_none() {
    let table = table();
    let bounded = json!({ "value": null, "standard_error": null });
    let front = |facets: Value| {
        let entries = json!({
            "kernel": "saito-surface", "lobe": "ggx", "roughness": facets,
            "surface_roughness": 3e-3
        });
        at(&result(&table, entries), &table, 150.0, 30.0)
    };
    let (alone, tiny, both) = (front(bounded), front(json!(1e-9)), front(json!(5e-4)));
    assert!(
        (alone.alpha / tiny.alpha - 1.0).abs() < 1e-5,
        "{alone:?} {tiny:?}"
    );
    assert!(both.alpha > 1.1 * alone.alpha, "{both:?}");
}

#[test]
fn the_nearest_lobe_of_a_sheet_depends_on_the_distance() {
    let table = table();
    let sheet = result(
        &table,
        json!({ "kernel": "eq1", "lobe": "radial", "c_mm": 0.2, "a_per_mm": 4.0 }),
    );
    let lobes = [150.0, 300.0].map(|distance| at(&sheet, &table, distance, 0.0));
    // The blur of Eq. (1) and of the ray shift does not grow with distance, so twice the distance
    // gives half the roughness.
    assert!(
        (lobes[0].alpha / lobes[1].alpha - 2.0).abs() < 1e-4,
        "{lobes:?}"
    );
    // The misfit is that of the two sheets' predictions, over both axes up to the same frequency.
    let frequencies = 1..=(100.0 * lobes[0].end_per_mm).round() as usize;
    let places = Places {
        floating_distance_mm: vec![150.0],
        incidence_deg: vec![0.0],
        azimuth_deg: Some(20.0),
        frequency_per_mm: frequencies.map(|i| 0.01 * i as f64).collect(),
    };
    let curves = |result: &ResultFile| -> Vec<f64> {
        let axes = predict(result, &table, &places).expect("light returns");
        axes.into_iter().flat_map(|axis| axis.mtf).collect()
    };
    let entries = json!({ "kernel": "mrm", "lobe": "ggx", "roughness": lobes[0].alpha });
    let pairs = curves(&sheet)
        .into_iter()
        .zip(curves(&result(&table, entries)));
    let squares: Vec<f64> = pairs.map(|(a, b)| (a - b).powi(2)).collect();
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(
        (lobes[0].rms / rms - 1.0).abs() < 1e-9 && rms > 0.005,
        "{lobes:?} {rms}"
    );
    let eta = table
        .direction(0.0, Some(20.0))
        .expect("it is there")
        .retroreflected;
    assert!((lobes[0].reflectance - 0.5 * eta).abs() < 1e-12);
    let slanted = at(&sheet, &table, 150.0, 30.0);
    assert!(slanted.reflectance < lobes[0].reflectance);
}

/// Each form says where the sheet was measured, if the result says it.
#[test]
fn materials_say_where_the_sheet_was_measured() {
    let table = table();
    let entries = json!({ "kernel": "mrm", "lobe": "ggx", "roughness": 9e-4 });
    let mut own = result(&table, entries);
    let forms = [Form::Openpbr, Form::Materialx, Form::Gltf];
    let said = "The sheet was measured at";
    for form in forms {
        assert!(!at(&own, &table, 150.0, 0.0).text(form).contains(said));
    }
    let domain = json!({ "floating_distance_mm": [150.0, 300.0], "incidence_deg": [0.0, 40.0],
        "azimuth_deg": [20.0, 20.0] });
    own.domain = serde_json::from_value(domain).expect("a domain");
    for form in forms {
        let text = at(&own, &table, 150.0, 0.0).text(form);
        let whole =
            format!("{said} 150 to 300 mm, incidence 0 to 40 deg, azimuth 20 deg; elsewhere");
        assert!(text.contains(&whole), "{text}");
    }
}

/// A scene for Mitsuba names its files in full, and the distance only for lobes in mm.
#[test]
fn a_scene_for_mitsuba_names_files_and_distance() {
    let table = table();
    let here = std::env::current_dir().expect("a folder");
    let files = [Path::new("a \"b\" & c.json"), Path::new("t.h5")];
    let of = |kernel: &str, lobe: Option<&str>| {
        let entries = json!({ "kernel": kernel, "lobe": lobe, "c_mm": 0.2, "a_per_mm": 4.0 });
        mitsuba(&result(&table, entries), &table, files, 300.0)
    };
    let mut cases = 0;
    for (kernel, lobe, has_distance) in [
        ("eq1", Some("radial"), true),
        ("lobe", Some("separable"), true),
        ("angular", Some("radial"), false),
        ("shift", None, false),
    ] {
        let text = of(kernel, lobe).expect("a kernel of scenes");
        for file in files {
            let whole = charts::escape(&here.join(file).display().to_string());
            assert!(text.contains(&format!("value=\"{whole}\"")), "{text}");
        }
        let distance = "<float name=\"R\" value=\"300\"/>";
        assert_eq!(text.contains(distance), has_distance, "{text}");
        cases += 1;
    }
    assert_eq!(cases, 4);
    let refused = of("wave", None).expect_err("wave has no lobe of one angle");
    assert!(
        refused.to_string().contains("--kernel angular"),
        "{refused}"
    );
}

/// A table of another cell makes no scene, and one of another back is no other colour of the sheet.
#[test]
fn tables_of_other_cells_are_refused() {
    let table = table();
    let entries = json!({ "kernel": "shift", "lobe": null, "c_mm": 0.2 });
    let own = result(&table, entries);
    let mut other = table.clone();
    other.provenance.back = Back::Tir.into();
    let files = [Path::new("r.json"), Path::new("t.h5")];
    let refused = mitsuba(&own, &other, files, 300.0).expect_err("another cell");
    assert!(refused.to_string().contains("another back"), "{refused}");
    let sheet = Fitted::new(&own, &table).expect("its own table");
    let refused = sheet.in_colour(&other).expect_err("another back");
    assert!(refused.to_string().contains("another back"), "{refused}");
    other.provenance.back = table.provenance.back.clone();
    other.provenance.refractive_index = 1.51;
    assert!(sheet.in_colour(&other).is_ok());
}

/// Ideal mirrors are dark between crossed polarisers, and dim between those at 80 degrees.
#[test]
fn a_setup_that_no_light_passes_is_refused() {
    let table = table();
    let behind = |analyser: &str| {
        let both = json!({ "s": 0.5, "p": 0.5 });
        let entries = json!({
            "kernel": "shift", "lobe": null, "c_mm": 0.2,
            "polarisation": {
                "source": "linear:0", "analyser": analyser, "retarder": null,
                "half_mirror_transmittance": both, "half_mirror_reflectance": both,
            },
        });
        let own = result(&table, entries);
        own.seen(&table).map(|seen| {
            let light = |of: &Table| of.direction(0.0, Some(20.0)).unwrap().retroreflected;
            light(&seen) / light(&table)
        })
    };
    let refused = behind("linear:90").expect_err("nothing passes").to_string();
    assert!(
        refused.starts_with("[setup]: less than 1e-9") && refused.contains("`analyser`"),
        "{refused}"
    );
    // Malus' law.
    let share = behind("linear:80").expect("light passes");
    let expected = 80_f64.to_radians().cos().powi(2);
    assert!((share / expected - 1.0).abs() < 1e-12, "{share} {expected}");
}

/// What no released library declares is said, and of the other form nothing is.
#[test]
fn drafts_are_named() {
    assert!(
        Form::Openpbr
            .draft()
            .is_some_and(|said| said.contains("OpenPBR 1.2"))
    );
    assert!(
        Form::Gltf
            .draft()
            .is_some_and(|said| said.contains("draft"))
    );
    assert_eq!(Form::Materialx.draft(), None);
}

#[test]
fn every_form_says_roughness_reflectance_and_what_is_lost() {
    let table = table();
    let own = result(
        &table,
        json!({ "kernel": "mrm", "lobe": "ggx", "roughness": 9e-4 }),
    );
    let lobe = at(&own, &table, 150.0, 0.0);
    // Reads the value of an input in a MaterialX document.
    let input = |text: &str, name: &str| {
        let rest = text
            .split(&format!("name=\"{name}\""))
            .nth(1)?
            .split("value=\"")
            .nth(1)?;
        Some(rest.split('"').next()?.to_owned())
    };
    let materialx = lobe.text(Form::Materialx);
    assert_eq!(
        input(&materialx, "roughness").as_deref(),
        Some("0.00090000, 0.00090000")
    );
    assert_eq!(
        input(&materialx, "retroreflective").as_deref(),
        Some("true")
    );
    let openpbr = lobe.text(Form::Openpbr);
    assert_eq!(
        input(&openpbr, "specular_roughness").as_deref(),
        Some("0.03000000")
    );
    assert_eq!(
        input(&openpbr, "specular_retroreflectivity").as_deref(),
        Some("1")
    );
    for text in [&materialx, &openpbr] {
        assert!(text.contains("the material has no ray shift"));
        assert_eq!(text.matches("<!--").count(), text.matches("-->").count());
        assert!(
            text.split("<!--")
                .skip(1)
                .all(|c| !c.split("-->").next().unwrap_or("").contains("--"))
        );
    }
    let gltf: Value = serde_json::from_str(&lobe.text(Form::Gltf)).expect("it is JSON");
    let material = &gltf["materials"][0];
    let roughness = material["pbrMetallicRoughness"]["roughnessFactor"]
        .as_f64()
        .expect("a number");
    assert!((roughness - 0.03).abs() < 1e-6);
    assert_eq!(
        material["extensions"]["KHR_materials_retroreflection"]["retroreflectionFactor"],
        1.0
    );
    assert_eq!(gltf["extensionsUsed"][0], "KHR_materials_retroreflection");
}

#[test]
fn curves_against_a_variable_are_named_by_what_else_varies() {
    let table = table();
    let own = result(
        &table,
        json!({ "kernel": "mrm", "lobe": "ggx", "roughness": 9e-4 }),
    );
    let places = Places {
        floating_distance_mm: vec![150.0, 300.0],
        incidence_deg: vec![0.0, 10.0, 30.0],
        azimuth_deg: Some(20.0),
        frequency_per_mm: vec![0.5, 1.0],
    };
    let predictions = predict(&own, &table, &places).expect("light returns");
    let picture = |variable| plot::against(&predictions, &places.frequency_per_mm, variable);
    let by_incidence = picture(Variable::Incidence);
    let by_distance = picture(Variable::Distance);
    // One legend has the frequencies by style and all else by colour.
    for (text, name) in [
        (&by_incidence, "0.5 /mm"),
        (&by_incidence, "300 mm"),
        (&by_distance, "1 /mm"),
        (&by_distance, "incidence 30\u{b0}"),
    ] {
        assert_eq!(text.matches(&format!(">{name}<")).count(), 1, "{name}");
    }
    assert!(!by_incidence.contains("azimuth 20"), "it does not vary");
}

/// The prediction all around the axis equals the prediction along the axes where they meet.
/// Opposite directions are alike. In each panel, one for each place, the picture has a curve for
/// each frequency.
#[test]
fn all_around_is_the_axes_and_between() {
    let table = table();
    let own = result(
        &table,
        json!({ "kernel": "eq1", "lobe": "radial", "c_mm": { "value": 0.3, "standard_error": 0.0 },
            "a_per_mm": { "value": 9.0, "standard_error": 0.0 } }),
    );
    let places = Places {
        floating_distance_mm: vec![150.0, 300.0],
        incidence_deg: vec![10.0, 30.0],
        azimuth_deg: Some(20.0),
        frequency_per_mm: vec![0.5, 1.0, 2.0],
    };
    let axes = predict(&own, &table, &places).expect("light returns");
    let all = around(&own, &table, &places).expect("light returns");
    let mut cases = 0;
    for (place, axes) in all.iter().zip(axes.chunks(2)) {
        assert_eq!(
            (place.floating_distance_mm, place.incidence_deg),
            (axes[0].floating_distance_mm, axes[0].incidence_deg)
        );
        assert_eq!(place.direction_deg.len(), 73);
        for (k, curve) in place.mtf.iter().enumerate() {
            for (direction, axis) in [(0, 0), (18, 1), (36, 0), (54, 1), (72, 0)] {
                assert_eq!(
                    place.direction_deg[direction],
                    90.0 * f64::from(direction as u8 / 18)
                );
                // The cosine of 90 degrees is 6e-17, not 0; nothing else differs.
                let off = (curve[direction] - axes[axis].mtf[k]).abs();
                assert!(off < 1e-12, "{off:e}");
                cases += 1;
            }
            let (low, high) = curve
                .iter()
                .fold((1.0_f64, 0.0_f64), |(l, h), &m| (l.min(m), h.max(m)));
            assert!(
                high - low > 1e-3,
                "the shift is not alike in all directions"
            );
        }
    }
    assert_eq!(cases, 4 * 3 * 5);
    let picture = plot::around(&all, &places.frequency_per_mm);
    for name in [">0.5 /mm<", ">1 /mm<", ">2 /mm<"] {
        assert_eq!(
            picture.matches(name).count(),
            1,
            "{name}: there is one legend"
        );
    }
    assert!(picture.contains(">300 mm<") && picture.contains(">incidence 30°, azimuth 20°<"));
}
