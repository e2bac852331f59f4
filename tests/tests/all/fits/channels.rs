//! Estimates for each colour channel of coloured photographs (`--channel each`), with the real
//! program: one result for each channel, from the light of that channel alone.

use std::path::Path;

use serde_json::Value;
use tests::files::bake_table;
use tests::program::{Run, fit};

/// a (1/mm) and mu of three sheets. Their photographs become the red, green and blue channels.
const SHEETS: [(f64, f64); 3] = [(4.0, 0.5), (3.0, 0.6), (5.0, 0.4)];

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

fn parameters((a, mu): (f64, f64)) -> String {
    let capture = |distance: f64, normal: f64| {
        format!(
            "[[capture]]\nfloating_distance_mm = {distance:?}\nincidence_deg = 10.0\nazimuth_deg \
            = 20.0\n\
             edge_normal_deg = {normal:?}\nexposure = 4.0\n"
        )
    };
    format!(
        "seed = 3\n[camera]\nwidth = 192\nheight = 128\npixel_pitch_mm = 0.08\nfull_well_e = \
        20000.0\n\
         [truth]\nkernel = \"eq1\"\nlobe = \"radial\"\nior = 1.49\npair = true\na = {a:?}\nc = \
         0.2\nmu = {mu:?}\n{}{}",
        capture(200.0, 5.0),
        capture(300.0, 7.0)
    )
}

/// Reads a photograph of one plane; returns its pixels, columns and rows.
fn plane(file: &Path) -> (Vec<f32>, usize, usize) {
    let image = exr::prelude::read_first_flat_layer_from_file(file).unwrap();
    let size = image.layer_data.size;
    let channel = &image.layer_data.channel_data.list[0];
    let values = channel.sample_data.values_as_f32().collect();
    (values, size.width(), size.height())
}

/// Writes the three campaigns, and in the folder `mixed` one campaign of coloured photographs.
///
/// Each coloured photograph holds those of the three sheets as its channels.
fn mix(here: &Path) {
    for (sheet, channel) in SHEETS.into_iter().zip(CHANNELS) {
        std::fs::write(here.join(format!("{channel}.toml")), parameters(sheet)).unwrap();
        fit(here, &format!("simulate {channel}.toml -o {channel}")).done();
    }
    let mixed = here.join("mixed");
    std::fs::create_dir(&mixed).unwrap();
    for entry in std::fs::read_dir(here.join("red")).unwrap() {
        let file = entry.unwrap().file_name();
        if Path::new(&file)
            .extension()
            .is_none_or(|ending| ending != "exr")
        {
            std::fs::copy(here.join("red").join(&file), mixed.join(&file)).unwrap();
            continue;
        }
        let planes = CHANNELS.map(|channel| plane(&here.join(channel).join(&file)));
        let (_, width, height) = planes[0];
        exr::prelude::write_rgb_file(mixed.join(&file), width, height, |x, y| {
            let [red, green, blue] = planes.each_ref().map(|(plane, ..)| plane[y * width + x]);
            (red, green, blue)
        })
        .unwrap();
    }
}

#[test]
fn every_channel_has_a_result_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    mix(here);
    let table = bake_table(here, "triangular-pair", "10", "20");
    let run = |more: &str| -> Run {
        let files = format!("estimate mixed/captures.toml --table {table}");
        let fixed = "--kernel eq1 --json --channel";
        fit(here, &format!("{files} {fixed} {more}"))
    };
    let each = run("each -o colours.json");
    assert_eq!(each.code, Some(0), "{}", each.err);
    assert_eq!(
        each.out,
        std::fs::read_to_string(here.join("colours.json")).unwrap()
    );
    let results: Value = serde_json::from_str(&each.out).unwrap();
    let mut cases = 0;
    for (channel, (known, _)) in CHANNELS.into_iter().zip(SHEETS) {
        let a = &results[channel]["a_per_mm"];
        let (value, error) = (
            a["value"].as_f64().unwrap(),
            a["standard_error"].as_f64().unwrap(),
        );
        assert!(
            (value - known).abs() < 5.0 * error,
            "{channel}: {value} +- {error}, planted {known}"
        );
        cases += 1;
    }
    assert_eq!(cases, 3);
    // A channel fitted alone gives exactly the result that it has in `each`.
    let one = run("g");
    assert_eq!(one.code, Some(0), "{}", one.err);
    let mut one: Value = serde_json::from_str(&one.out).unwrap();
    let mut green = results["green"].clone();
    one["seconds"] = 0.into();
    green["seconds"] = 0.into();
    assert_eq!(one, green);
    let both = run("each --plot mtf.svg");
    assert_eq!(both.code, Some(2), "{}", both.err);
    assert!(both.err.contains("name one --channel"), "{}", both.err);

    // A prediction is for one channel, which must be named.
    let predict = |more: &str| -> Run {
        let files = format!("predict colours.json --table {table}");
        let place = "--distance 200 --incidence 10";
        fit(here, &format!("{files} {place} {more}"))
    };
    let [red, blue] = ["red", "blue"].map(|channel| {
        let run = predict(&format!("--channel {channel}"));
        assert_eq!(run.code, Some(0), "{}", run.err);
        run.out
    });
    assert_ne!(red, blue);
    for more in ["", "--channel luminance"] {
        let run = predict(more);
        assert_eq!(run.code, Some(1), "{}", run.err);
        assert!(run.err.contains("blue, green, red"), "{}", run.err);
    }
}
