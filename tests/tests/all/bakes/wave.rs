//! The kernel `wave` on the command line: estimate, prediction, and refusals if the table or the
//! wavelength does not allow it.

use std::path::Path;

use serde_json::Value;
use tests::estimate::{json, numbers};
use tests::files::{argument, bake_table, bake_table_with};
use tests::program::{Run, bake, fit};

#[test]
#[ignore = "a minute: `make test-slowest` runs it"]
fn waves_from_photographs_to_prediction() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let params = argument("tests/tests/all/planted/wave.toml");
    fit(here, &format!("simulate {params} -o waves")).done();
    let table = bake_table(here, "triangular-pair", "0,30", "30");
    let manifest = "waves/captures.toml";
    // mu is shared by an option. Otherwise BIC gives the two incidences different values of mu by
    // chance in 2 of 100 campaigns.
    let shared = "--shared mu";
    let files = format!("estimate {manifest} --table {table} -o r.json");
    // The manifest names the wavelengths, so `--kernel auto` tries `wave`.
    fit(here, &format!("{files} {shared}")).done();
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

    let places = "--distance 150 --incidence 0 --azimuth 30 --frequency 0,1";
    let predict = |table: &str| {
        let line = format!("predict r.json --table {table} --json {places}");
        fit(here, &line)
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
    let options = "--method rays --rays 65536";
    let rays = bake_table_with(&sampled, "triangular-pair", "0,30", "30", options);
    let rays = sampled.join(rays).display().to_string();
    let estimate = |table: &str, manifest: &str, kernel: &str| {
        let line = format!("estimate {manifest} --table {table} --kernel {kernel}");
        fit(here, &line)
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
    let files = format!("estimate waves/dark.toml --table {table} --kernel wave");
    let named = "--wavelength-nm 450:0.2,550:0.5,620:0.3 --json";
    let again: Value =
        serde_json::from_str(&fit(here, &format!("{files} {named}")).done()).unwrap();
    assert_eq!(again["c_mm"], result["c_mm"]);

    // The output says which form of material is a draft.
    for (form, drafts) in [("openpbr", 1), ("materialx", 0), ("gltf", 1)] {
        let files = format!("export r.json --table {table} --to {form}");
        let place = "--distance 150 --azimuth 30";
        let made = fit(here, &format!("{files} {place}"));
        assert_eq!(made.code, Some(0), "{}", made.err);
        let said = made.err.lines().filter(|line| line.contains("draft"));
        assert_eq!(said.count(), drafts, "{form}: {}", made.err);
    }

    // Scalar waves of cubes that reflect totally are wrong. Where a table does not hold how they turn
    // the polarisation, waves are not chosen, and the first line of whatever uses them says so.
    let bare = here.join("bare");
    std::fs::create_dir(&bare).unwrap();
    let total = bake_table_with(&bare, "triangular-pair", "0,30", "30", "--back tir");
    let total = bare.join(total).display().to_string();
    let mut older = tables::read(Path::new(&total)).unwrap();
    let paths = older.exact.iter_mut().flat_map(|exact| &mut exact.paths);
    for path in paths.flatten() {
        assert!(path.jones.take().is_some());
    }
    tables::write(&older, Path::new(&total)).unwrap();
    let tried = estimate(&total, manifest, "auto");
    assert_eq!(tried.code, Some(0), "{}", tried.err);
    assert!(
        tried.err.contains("not among the candidates"),
        "{}",
        tried.err
    );
    let files = format!("estimate {manifest} --table {total} --kernel wave");
    let named = fit(here, &format!("{files} --json -o bare.json"));
    let sign = argument("doc/sign.png");
    let numbers = "--c 0.2 --wavelength-nm 550";
    let sheet = format!("--table {total} {numbers}");
    let picture = format!("render --source {sign} --width 100 -o air.png");
    let page = "explore -o page.html --json";
    let place = "--distance 150 --incidence 0 --json";
    let held = format!("predict bare.json --table {total}");
    let runs = [
        named,
        fit(here, &format!("{held} {place}")),
        fit(here, &format!("predict {sheet} {place}")),
        fit(here, &format!("{picture} {sheet} {place}")),
        fit(here, &format!("{page} {sheet}")),
    ];
    for made in &runs {
        assert_eq!(made.code, Some(0), "{}: {}", made.line, made.err);
        first_warning(made, "polarisation");
    }
    let told = json(&here.join("bare.json"));
    assert!(
        told["warnings"][0]
            .as_str()
            .unwrap()
            .contains("polarisation")
    );

    // Cubes smaller than the light are no subject of these waves either.
    for (c, said) in [("0.00001", true), ("0.2", false)] {
        let numbers = format!("--c {c} --wavelength-nm 550 --table {table}");
        let made = fit(here, &format!("predict {numbers} {place}"));
        assert_eq!(made.code, Some(0), "{}", made.err);
        assert_eq!(
            made.err.contains("longest wavelength"),
            said,
            "{}",
            made.err
        );
    }
}

/// Checks that a run says something in its first line and in the first warning of its JSON.
fn first_warning(made: &Run, text: &str) {
    let line = made.err.lines().next().unwrap_or_default();
    assert!(line.contains(text), "{}: {}", made.line, made.err);
    let json: Value = serde_json::from_str(&made.out).unwrap();
    let first = json["warnings"][0].as_str().unwrap_or_default();
    assert!(first.contains(text), "{}: {first}", made.line);
}

/// Cubes with dihedral errors that do not matter have the waves of exact ones, and so have meshes
/// that are rounded: nothing jumps between errors of 0 and 0.05 mrad.
///
/// The expected MTF is that of the aperture by two-dimensional transforms in numpy, on rasters of
/// 1024 and 2048 points, which agree to 1e-4; with errors it has the phases of the six facet
/// orders on one aperture. The raster allows 1e-4, its four digits 5e-5, and the second order in the
/// deviation d of 0.24 mrad, 2 pi c/wavelength d^2, 1.3e-4. `fit` has each order where its rays leave,
/// which moves six sides of half an edge by up to 0.6 d: 7e-4 of the aperture.
#[test]
fn waves_are_continuous_in_the_errors_of_cubes() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let exact = [[0.8983, 0.7978, 0.6098], [0.9100, 0.8173, 0.6337]];
    let with_errors = [[0.8966, 0.7922, 0.5967], [0.9082, 0.8117, 0.6205]];
    let errors = |mrad: &str| format!("--dihedral-error-mrad={mrad},{mrad},{mrad}");
    let edge = "--edge-length 0.2";
    let cases: [(&str, &str, f64, bool); 8] = [
        ("0.obj", "", 2e-4, false),
        ("single.glb", "", 2e-4, false),
        ("six.obj", "", 0.01, false),
        ("a.obj", &errors("5e-7"), 2e-4, false),
        ("b.obj", &errors("1e-4"), 2e-4, false),
        ("c.obj", &errors("0.001"), 5e-4, false),
        ("d.obj", &errors("0.01"), 4e-3, false),
        ("e.obj", &errors("0.05"), 0.015, true),
    ];
    let mut compared = 0;
    for (mesh, options, allowed, is_bent) in &cases {
        let words = format!("design triangular-pair -o {mesh}");
        bake(here, &format!("{words} {edge} {options}"));
        if *mesh == "six.obj" {
            rounded(&here.join(mesh), 6);
        }
        let words = format!("trace {mesh} -o t.h5 --refractive-index 1.49");
        let made = bake(here, &format!("{words} --incidence 0 --azimuth 0"));
        assert_eq!(made.code, Some(0), "{mesh}: {}", made.err);
        let words = "predict --table t.h5 --c 0.2 --wavelength-nm 550";
        let place = "--distance 150 --incidence 0 --frequency 0.15,0.3,0.6";
        let made = fit(here, &format!("{words} {place} --json"));
        assert_eq!(made.code, Some(0), "{mesh}: {}", made.err);
        let found: Value = serde_json::from_str(&made.out).unwrap();
        let references = [
            Some((exact, *allowed)),
            is_bent.then_some((with_errors, 1e-3)),
        ];
        for (expected, allowed) in references.into_iter().flatten() {
            for (place, expected) in found["predictions"]
                .as_array()
                .unwrap()
                .iter()
                .zip(expected)
            {
                for (mtf, expected) in place["mtf"].as_array().unwrap().iter().zip(expected) {
                    let off = mtf.as_f64().unwrap() - expected;
                    assert!(off.abs() < allowed, "{mesh}: {place} {expected}");
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 9 * 6);
}

/// Rounds the vertices of an OBJ to a number of decimals.
fn rounded(mesh: &std::path::Path, decimals: usize) {
    let round = |word: &str| match word.parse::<f64>() {
        Ok(number) => format!("{number:.decimals$}"),
        Err(_) => word.to_owned(),
    };
    let line = |line: &str| match line.starts_with("v ") {
        true => line.split(' ').map(round).collect::<Vec<_>>().join(" "),
        false => line.to_owned(),
    };
    let text = std::fs::read_to_string(mesh).unwrap();
    let text: Vec<String> = text.lines().map(line).collect();
    std::fs::write(mesh, text.join("\n") + "\n").unwrap();
}

/// Light behind a half mirror that divides s and p, by hand: TR is 0.4 x 0.6 and 0.7 x 0.3 for the
/// two. Ideal mirrors keep both, so the mean is 0.225; a sheet that mixes them fully would pass
/// 0.55 x 0.45 = 0.2475, and totally reflecting cubes lie between. A half mirror that reflects s and
/// passes p, with a quarter-wave film before ideal mirrors, passes half of unpolarised light.
///
/// A ghost and haze lower the MTF by factors that have closed forms.
#[test]
fn a_setup_says_what_its_light_passes() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let ideal = bake_table(here, "triangular-pair", "0", "0");
    let bare = here.join("bare");
    std::fs::create_dir(&bare).unwrap();
    let total = bake_table_with(&bare, "triangular-pair", "0", "0", "--back tir");
    let total = bare.join(total).display().to_string();
    let divided = "half_mirror_transmittance = { s = 0.4, p = 0.7 }\n\
        half_mirror_reflectance = { s = 0.6, p = 0.3 }\n";
    let film = "half_mirror_transmittance = { s = 0, p = 1 }\n\
        half_mirror_reflectance = { s = 1, p = 0 }\nretarder = { waves = 0.25, axis_deg = 45 }\n";
    let even = "half_mirror_transmittance = 0.5\nhalf_mirror_reflectance = 0.5\n";
    let ghost = "ghost = { share = 0.25, tangential_mm = 2 }\n";
    let haze = "haze = { share = 0.1, spread_deg = 5 }\n";
    let predict = |table: &str, keys: &str| -> [f64; 2] {
        std::fs::write(here.join("s.toml"), format!("[setup]\n{keys}")).unwrap();
        let sheet = format!("--c 0.15 --a-times-r 700 --mu 1 --table {table} --setup s.toml");
        let places = "--distance 300 --incidence 0 --frequency 0.25 --json";
        let report = fit(here, &format!("predict {sheet} {places}")).done();
        let report: Value = serde_json::from_str(&report).unwrap();
        let along = &report["predictions"][0];
        [&along["luminance"], &along["mtf"][0]].map(|own| own.as_f64().unwrap())
    };
    let third = 2.0 / 3.0;
    let [plain, clear] = predict(&ideal, even);
    assert!((plain - 0.25 * third).abs() < 1e-12, "{plain}");
    let kept = predict(&ideal, divided)[0];
    assert!((kept - 0.225 * third).abs() < 1e-12, "{kept}");
    let between = predict(&total, divided)[0] / third;
    assert!(between > 0.2251 && between < 0.2474, "{between}");
    let doubled = predict(&ideal, film)[0];
    assert!((doubled - 0.5 * third).abs() < 1e-12, "{doubled}");
    // At 0.25 /mm a ghost 2 mm aside is out of phase: (1 - 0.25)/(1 + 0.25). Haze of 26 mm is gone.
    let two = predict(&ideal, &format!("{even}{ghost}"))[1];
    assert!((two - 0.6 * clear).abs() < 1e-12, "{two} {clear}");
    let veiled = predict(&ideal, &format!("{even}{haze}"))[1];
    assert!((veiled - 0.9 * clear).abs() < 1e-12, "{veiled} {clear}");
    println!("6 predictions");
}

/// Three tables are those of red, green and blue light: each colour of a white sign is that of a
/// grey one with its own table, and the facts are those of green.
#[test]
fn a_dispersive_sheet_has_a_table_for_each_colour() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bake(here, "design triangular-pair -o pair.obj").done();
    for (name, index) in [("red", "1.58"), ("green", "1.588"), ("blue", "1.604")] {
        let line = format!("trace pair.obj -o {name}.h5 --refractive-index {index}");
        bake(here, &format!("{line} --incidence 40 --azimuth 20")).done();
    }
    let sign = image::GrayImage::from_fn(48, 32, |x, _| image::Luma([255 * u8::from(x % 16 < 8)]));
    sign.save(here.join("grey.png")).unwrap();
    let white = image::DynamicImage::ImageLuma8(sign).to_rgb8();
    white.save(here.join("white.png")).unwrap();
    let render = |source: &str, tables: &str, more: &str| {
        let sheet = format!("--c 0.2 --a 4 --mu 0.5 --table {tables} --pixel-pitch 0.1 {more}");
        let place = "--distance 200 --incidence 40 --json -o image.exr";
        fit(here, &format!("render --source {source} {sheet} {place}"))
    };
    let image = |source: &str, tables: &str| {
        let run = render(source, tables, "");
        assert_eq!(run.code, Some(0), "{}", run.err);
        let told: Value = serde_json::from_str(&run.out).unwrap();
        let image = fit::load_colour(&here.join("image.exr"), None).unwrap();
        (image.planes, told["energy"].clone())
    };
    let (planes, energy) = image("white.png", "red.h5 green.h5 blue.h5");
    let alone = ["red.h5", "green.h5", "blue.h5"].map(|table| image("grey.png", table));
    for (plane, (own, _)) in planes.iter().zip(&alone) {
        assert_eq!(plane, &own[0]);
    }
    assert_eq!(energy, alone[1].1);
    assert!(planes[0] != planes[1] && planes[1] != planes[2]);
    let refusals = [
        ("red.h5 blue.h5", "", "give one table, or three"),
        (
            "red.h5 green.h5 blue.h5",
            "--forward render",
            "three tables work only with",
        ),
    ];
    for (tables, more, said) in refusals {
        let run = render("white.png", tables, more);
        assert_eq!(run.code, Some(2), "{}", run.err);
        assert!(run.err.contains(said), "{}", run.err);
    }
    // A cell of another mesh is no colour of this one.
    bake(here, "design triangular -o one.obj").done();
    let line = "trace one.obj -o one.h5 --refractive-index 1.5 --incidence 40 --azimuth 20";
    bake(here, line).done();
    let run = render("white.png", "red.h5 green.h5 one.h5", "");
    assert_eq!(run.code, Some(1), "{}", run.err);
    assert!(run.err.contains("with another mesh"), "{}", run.err);
    println!("3 colours, {} refusals", refusals.len() + 1);
}

/// Every fault of a setup is refused with its file and what would be right.
#[test]
fn a_setup_that_cannot_be_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let ideal = bake_table(here, "triangular-pair", "0", "0");
    std::fs::write(here.join("infrared.csv"), "850,1\n950,1\n").unwrap();
    let refused = |keys: &str, said: &str| {
        std::fs::write(here.join("s.toml"), format!("[setup]\n{keys}")).unwrap();
        let sheet = format!("--c 0.15 --a-times-r 700 --table {ideal} --setup s.toml");
        let run = fit(
            here,
            &format!("predict {sheet} --distance 300 --incidence 0"),
        );
        assert_eq!(run.code, Some(1), "{keys}: {}", run.err);
        assert!(
            run.err.contains("s.toml") && run.err.contains(said),
            "{keys}: {}",
            run.err
        );
    };
    let cases = [
        ("polarisation = \"linear\"", "linear:DEG"),
        ("analyser = \"circular:up\"", "circular:left"),
        ("retarder = { waves = 0.25 }", "axis_deg"),
        ("half_mirror_reflectance = { s = 2, p = 0 }", "from 0 to 1"),
        ("spectrum = \"LED-B9\"", "LED-B5"),
        ("camera_response = \"camera.csv\"", "spectrum"),
        ("spectrum = \"infrared.csv\"", "camera_response"),
        ("spectrum = \"D65\"\nwavelength_nm = 550", "leave one out"),
        ("haze = { share = 2, spread_deg = 5 }", "at most 1"),
        ("front_index = 0.5", "refractive index"),
    ];
    for (keys, said) in cases {
        refused(keys, said);
    }
    println!("{} refusals", cases.len());
}
