//! One fit per channel of coloured photographs: each channel is the photograph of its own light.

mod planted;

use fit::estimate::scene::Scene;
use fit::names::kernel::Kernel;
use fit::names::lobe::LobeShape;
use fit::photographs::captures;
use fit::photographs::photo;
use fit::photographs::photo::channel::{Channel, Decode};
use planted::{camera, params, table, truth};

/// Red, green and blue from three sheets (a and mu differ): every channel's scene is that of its own sheet, to the last bit.
#[test]
fn every_channel_is_measured_as_its_own_photograph() {
    let incidence = [10.0];
    let sheets = [(4.0, 0.5), (3.0, 0.6), (5.0, 0.4)];
    let folders = sheets.map(|(a, mu)| {
        let folder = tempfile::tempdir().unwrap();
        let truth = truth(Kernel::Eq1, LobeShape::Radial, a, 0.2, mu);
        let params = params(3, truth, &incidence, &[200.0, 300.0], camera(20_000.0));
        fit::simulate::write::run(&params, folder.path(), true).unwrap();
        folder
    });
    let mixed = tempfile::tempdir().unwrap();
    let manifest = std::fs::read_to_string(folders[0].path().join("captures.toml")).unwrap();
    std::fs::write(mixed.path().join("captures.toml"), manifest).unwrap();
    let campaign = captures::load(&folders[0].path().join("captures.toml")).unwrap();
    let shots = campaign.captures.iter().map(|capture| &capture.shot);
    for shot in campaign.reference.iter().chain(shots) {
        let name = shot.image.file_name().unwrap();
        let planes = folders
            .each_ref()
            .map(|folder| photo::load(&folder.path().join(name), &Decode::default()).unwrap());
        let (width, height) = (planes[0].width, planes[0].height);
        exr::prelude::write_rgb_file(mixed.path().join(name), width, height, |x, y| {
            let [red, green, blue] = planes.each_ref().map(|plane| plane.at(x, y).unwrap());
            (red, green, blue)
        })
        .unwrap();
    }
    let coloured = captures::load(&mixed.path().join("captures.toml")).unwrap();
    let mut cases = 0;
    for (channel, (folder, (a, mu))) in Channel::PRIMARIES.iter().zip(folders.iter().zip(sheets)) {
        let table = table(
            &truth(Kernel::Eq1, LobeShape::Radial, a, 0.2, mu),
            &incidence,
            20.0,
        );
        let alone = captures::load(&folder.path().join("captures.toml")).unwrap();
        let alone = Scene::load(&alone, &table).unwrap();
        let mixed = Scene::load(&coloured.in_channel(channel), &table).unwrap();
        for (a, b) in alone.shots.iter().zip(&mixed.shots) {
            assert_eq!(
                a.view.mtf.modulus, b.view.mtf.modulus,
                "{channel} of {}",
                a.image
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 6);

    // The program: an object with one result per channel, each with its own sheet's a.
    let mut table = table(
        &truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.2, 0.5),
        &incidence,
        20.0,
    );
    // A file's fates and bins add up; the fit takes the polygons.
    let eta = table.retroreflected[[0, 0]];
    (table.fate[[0, 0, 0]], table.fate[[0, 0, 4]]) = (eta, 1.0 - eta);
    table.histogram[[0, 0, 1, 1]] = 1.0;
    if let Some(exact) = &mut table.exact {
        exact.entrance_area /= 4.0;
    }
    tables::write(&table, &mixed.path().join("table.h5")).unwrap();
    let run = |more: &[&str]| {
        let fixed = [
            "estimate",
            "captures.toml",
            "--table",
            "table.h5",
            "--kernel",
            "eq1",
            "--json",
            "--channel",
        ];
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_fit"))
            .current_dir(mixed.path())
            .args(fixed.iter().chain(more))
            .output()
            .unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stdout).unwrap(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let (code, out, err) = run(&["each", "-o", "colours.json"]);
    assert_eq!(code, Some(0), "{err}");
    assert_eq!(
        out,
        std::fs::read_to_string(mixed.path().join("colours.json")).unwrap()
    );
    let results: serde_json::Value = serde_json::from_str(&out).unwrap();
    for (channel, (known, _)) in Channel::PRIMARIES.iter().zip(sheets) {
        let a = &results[channel.to_string()]["a_per_mm"];
        let (value, error) = (
            a["value"].as_f64().unwrap(),
            a["standard_error"].as_f64().unwrap(),
        );
        assert!(
            (value - known).abs() < 5.0 * error,
            "{channel}: {value} +- {error}, planted {known}"
        );
    }
    // One channel gives the very result that it has among all.
    let (code, out, err) = run(&["g"]);
    assert_eq!(code, Some(0), "{err}");
    let mut one: serde_json::Value = serde_json::from_str(&out).unwrap();
    let mut green = results["green"].clone();
    one["seconds"] = 0.into();
    green["seconds"] = 0.into();
    assert_eq!(one, green);
    let (code, _, err) = run(&["each", "--plot", "mtf.svg"]);
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("name one --channel"), "{err}");

    // A prediction is of one channel, which must be named.
    let predict = |more: &[&str]| {
        let place = ["--table", "table.h5", "--distance", "200", "--incidence"];
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_fit"))
            .current_dir(mixed.path())
            .args(["predict", "colours.json"])
            .args(place)
            .arg(incidence[0].to_string())
            .args(more)
            .output()
            .unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (
            output.status.code(),
            text(output.stdout),
            text(output.stderr),
        )
    };
    let (code, red, err) = predict(&["--channel", "red"]);
    assert_eq!(code, Some(0), "{err}");
    let (code, blue, err) = predict(&["--channel", "blue"]);
    assert_eq!(code, Some(0), "{err}");
    assert_ne!(red, blue);
    for more in [&[][..], &["--channel", "luminance"]] {
        let (code, _, err) = predict(more);
        assert_eq!(code, Some(1), "{err}");
        assert!(err.contains("blue, green, red"), "{err}");
    }
}
