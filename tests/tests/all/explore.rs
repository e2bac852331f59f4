//! Page of `fit explore`: its pixels in a browser against `fit render`, and its refusals.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tests::browser::Browser;
use tests::files::{argument, bake_table};
use tests::program::{bake, fit};

/// Writes a small picture in colour, whose codes are sRGB: bars, a frame and a disc.
fn picture(here: &Path) {
    let image = image::RgbImage::from_fn(96, 64, |x, y| {
        let disc = (x as i32 - 70).pow(2) + (y as i32 - 32).pow(2) < 300;
        match (x, y) {
            (4..40, _) if x % 6 < 3 && (8..56).contains(&y) => image::Rgb([255, 255, 255]),
            _ if disc => image::Rgb([240, 120, 20]),
            (0 | 95, _) | (_, 0 | 63) => image::Rgb([30, 90, 250]),
            _ => image::Rgb([0, 0, 0]),
        }
    });
    image.save(here.join("content.png")).unwrap();
}

/// Puts scripts into a page: one that keeps errors before all others, and the probe behind them.
///
/// Frames come from timers. Virtual time waits for these, but not for the frames of a busy machine.
fn probed(page: &str, settings: &Value) -> String {
    let first = "<script>const ERRORS = []; addEventListener('error', (e) => \
        ERRORS.push(e.message)); addEventListener('unhandledrejection', (e) => \
        ERRORS.push(String(e.reason))); console.error = (...all) => \
        ERRORS.push(all.join(' ')); requestAnimationFrame = (draw) => \
        setTimeout(draw, 16);</script><title>";
    let probe = format!(
        "<script>const SETTINGS = {settings};\n{}</script>\n</body>",
        include_str!("explore_probe.js")
    );
    page.replacen("<title>", first, 1)
        .replacen("</body>", &probe, 1)
}

fn floats(text: &Value) -> Vec<f32> {
    let bytes = STANDARD.decode(text.as_str().unwrap()).unwrap();
    let floats = bytes.chunks_exact(4);
    floats
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

/// Runs `fit` and returns the facts that it prints as JSON. Warnings are allowed.
fn facts(here: &Path, command: &[String]) -> Value {
    let run = fit(here, command);
    assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
    serde_json::from_str(&run.out).unwrap()
}

/// A sheet: its options for `fit explore` and `fit render`, and what it tells.
struct Sheet<'a> {
    name: &'static str,
    table: &'a str,
    options: Vec<String>,
    /// Light that may lie beyond the blur of the page, as a share. The page lays it within the
    /// blur, `fit render` within a wider one.
    tails: f64,
}

fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(String::from).collect()
}

/// Writes the result of a sheet whose kernel is `shift`, which no options give: a fit, with c and
/// mu of the other sheets in place of its own.
fn shift_result(here: &Path, table: &str) -> Vec<String> {
    let (manifest, result) = ("campaign/captures.toml", format!("shift-{table}.json"));
    let estimate = ["estimate", manifest, "--table", table, "--kernel", "shift"];
    fit(here, &[&estimate[..], &["-o", &result]].concat());
    let text = fs::read_to_string(here.join(&result)).unwrap();
    let mut fitted: Value = serde_json::from_str(&text).unwrap();
    fitted["c_mm"]["value"] = json!(0.2);
    fitted["mu"] = json!({"value": 0.5, "standard_error": null});
    fs::write(here.join(&result), fitted.to_string()).unwrap();
    vec!["--params".into(), result]
}

/// The pixels of the page at settings off its nodes, against `fit render` at the same ones: they
/// differ by no more than the page states, plus the light in tails that both cut off elsewhere.
///
/// Each picture is also rounded: `fit render` to 32-bit floats, and the page keeps the spectra of
/// picture and blur in 32-bit floats. Three roundings of 6e-8, each of every frequency, add to 1e-7
/// of a pixel as white as the source, and to five times that at the worst of 6144 pixels. White of
/// the source is less than four times the brightest pixel of these images over their energy.
#[test]
fn a_browser_shows_what_fit_render_computes() {
    let Some(browser) = Browser::find() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    picture(here);
    let whole = bake_table(here, "triangular-pair", "0:40:10", "full:10");
    let one = bake_table(here, "triangular-pair", "0:40:5", "23");
    let errors = ["--dihedral-error-mrad", "0.5,0,-0.3", "-o", "errors.obj"];
    bake(
        here,
        &[&["design", "triangular-pair"], &errors[..]].concat(),
    )
    .done();
    let trace = words("trace errors.obj --refractive-index 1.49 --incidence 0:40:5 --azimuth 23");
    bake(here, &[trace, words("-o errors.h5")].concat()).done();
    let rays = words("trace triangular-pair.obj --refractive-index 1.49 --incidence 0:40:10");
    let own = words("--azimuth full:15 --method rays --rays 65536 --bins 64 -o rays.h5");
    bake(here, &[rays, own].concat()).done();
    let parameters = argument("tests/tests/all/planted/shift.toml");
    let campaign = ["simulate", &parameters, "-o", "campaign", "--force"];
    fit(here, &campaign).done();
    let sheets = [
        Sheet {
            name: "shift",
            table: &whole,
            options: shift_result(here, &whole),
            tails: 0.0,
        },
        Sheet {
            name: "shift of errors",
            table: "errors.h5",
            options: shift_result(here, "errors.h5"),
            tails: 0.0,
        },
        Sheet {
            name: "shift of rays",
            table: "rays.h5",
            options: shift_result(here, "rays.h5"),
            tails: 0.0,
        },
        Sheet {
            name: "eq1",
            table: &whole,
            options: words("--c 0.2 --a 4.5 --mu 0.5"),
            tails: 0.0,
        },
        Sheet {
            name: "sharp eq1",
            table: &whole,
            options: words("--c 0.2 --a 300 --mu 0.5"),
            tails: 0.0,
        },
        Sheet {
            name: "angular",
            table: &whole,
            options: words("--c 0.2 --a-times-r 700 --mu 0.5"),
            tails: 0.0,
        },
        Sheet {
            name: "errors",
            table: "errors.h5",
            options: words("--c 0.2 --a-times-r 700 --mu 0.5"),
            tails: 0.0,
        },
        Sheet {
            name: "wave",
            table: &one,
            options: words("--c 0.25 --wavelength-nm 500:0.5,600 --mu 0.5"),
            // Rust cuts the light beyond 0.2 % of each axis, the page that beyond 202 pixels.
            tails: 0.012,
        },
    ];
    let settings = json!([
        {"distance": 163.0, "incidence": 17.3, "azimuth": 23.0, "width": 38.0},
        {"distance": 240.0, "incidence": 33.1, "azimuth": 71.7, "width": 30.0},
        {"distance": 420.0, "incidence": 6.2, "azimuth": 348.0, "width": 60.0},
    ]);
    let mut compared = 0;
    for sheet in &sheets {
        let page = format!("{}.html", sheet.name);
        let mut command = words("explore --table");
        command.push(sheet.table.into());
        // A result is an option of `fit render`, and an argument here.
        let options = sheet.options.iter().filter(|&word| word != "--params");
        command.extend(options.cloned());
        command.extend(words(
            "--source content.png --nearest 100 --farthest 600 --json -o",
        ));
        command.push(page.clone());
        let told = facts(here, &command);
        let text = fs::read_to_string(here.join(&page)).unwrap();
        assert!(text.len() < 4_000_000, "{}", text.len());
        let stated = told["mixing_error"].as_f64().unwrap();
        assert!(stated < 0.02, "{}: {told}", sheet.name);
        if sheet.name.starts_with("shift") {
            // The rim of a shift is sharp, so that a weight tells more than a pixel.
            let weight = told["mixing_error_of_peak"].as_f64().unwrap();
            assert!(stated < 0.002 && weight < 0.01, "{}: {told}", sheet.name);
        }
        fs::write(here.join("probe.html"), probed(&text, &settings)).unwrap();
        let found = browser.probe(&here.join("probe.html"), 1200, false);
        assert_eq!(found["errors"], json!([]), "{}", sheet.name);
        let fetched = found["fetched"].as_array().unwrap();
        assert!(
            (fetched.iter()).all(|own| own.as_str().is_some_and(|own| own.starts_with("data:"))),
            "{fetched:?}"
        );
        assert_eq!(found["quick"], 1);
        for image in found["images"].as_array().unwrap() {
            let own = &image["own"];
            let number = |key: &str| own[key].as_f64().unwrap().to_string();
            let mut command = words("render --source content.png --table");
            command.push(sheet.table.into());
            command.extend(sheet.options.clone());
            for key in ["distance", "incidence", "azimuth"] {
                command.extend([format!("--{key}"), number(key)]);
            }
            let pitch = image["pitch"].as_f64().unwrap().to_string();
            command.extend(["--pixel-pitch".into(), pitch]);
            command.extend(words("-o aerial.exr --json"));
            let told = facts(here, &command);
            let energy = told["energy"][0].as_f64().unwrap();
            let aerial = fit::load_colour(&here.join("aerial.exr"), None).unwrap();
            // The error is stated in units of the brightest pixel of all directions: incidence 0,
            // where the pair returns two thirds of the light (with errors a little less).
            let brightest = 0.5 * 0.25 * 2.0 / 3.0;
            let most = (stated + sheet.tails + 2e-6) * brightest;
            assert!((image["energy"].as_f64().unwrap() - energy).abs() <= stated * brightest);
            for (plane, true_one) in image["planes"]
                .as_array()
                .unwrap()
                .iter()
                .zip(&aerial.planes)
            {
                let plane = floats(plane);
                assert_eq!(plane.len(), 96 * 64);
                let off = plane
                    .iter()
                    .zip(true_one)
                    .map(|(a, b)| f64::from((a - b).abs()));
                let worst = off.fold(0.0, f64::max);
                assert!(worst <= most, "{} {own}: {worst} {most}", sheet.name);
                println!("{}: {:.1e} of {:.1e}", sheet.name, worst, most);
                assert!(true_one.iter().any(|&v| f64::from(v) > 0.2 * energy));
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 8 * 3 * 3);
}

/// A fitted sheet has intervals, marks what was photographed, and says what was not. The page fits
/// a phone and a desk, in both colours.
#[test]
fn a_browser_shows_intervals_and_what_was_not_photographed() {
    let Some(browser) = Browser::find() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let parameters = argument("tests/tests/all/planted/eq1.toml");
    fit(
        here,
        &["simulate", &parameters, "-o", "campaign", "--force"],
    )
    .done();
    let table = bake_table(here, "triangular-pair", "0:40:20", "30");
    let manifest = "campaign/captures.toml";
    let options = ["--kernel", "eq1", "--lobe", "radial", "-o", "r.json"];
    let estimate = ["estimate", manifest, "--table", &table];
    fit(here, &[&estimate[..], &options].concat());
    fit(
        here,
        &["explore", "r.json", "--table", &table, "-o", "e.html"],
    )
    .done();
    let page = fs::read_to_string(here.join("e.html")).unwrap();
    let settings = json!([{"distance": 200.0}]);
    fs::write(here.join("probe.html"), probed(&page, &settings)).unwrap();
    let mut windows = 0;
    for (width, dark) in [(360, false), (360, true), (800, false), (1300, true)] {
        let found = browser.probe(&here.join("probe.html"), width, dark);
        assert_eq!(found["errors"], json!([]));
        assert_eq!(found["wide"], json!([]), "{width}");
        assert_eq!(found["unnamed"], json!([]));
        assert_eq!((&found["curves"], &found["bands"]), (&json!(2), &json!(2)));
        assert_ne!(found["before"], found["after"]);
        let remarks = found["remarks"].as_str().unwrap();
        assert!(remarks.contains("Outside of the photographs of the fit: distance"));
        assert!(remarks.contains("The kernels angular and wave let it grow"));
        assert!(found["spoken"].as_str().unwrap().ends_with(" mm"));
        let typed = |k: usize| found["typed"][k].as_f64().unwrap();
        assert_eq!((typed(0), typed(1)), (12.5, typed(2)));
        assert!(typed(1) > 12.5 && typed(1) < 90.0, "{}", typed(1));
        windows += 1;
    }
    assert_eq!(windows, 4);
}

#[test]
fn wrong_requests_are_refused_and_leave_no_page() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bake_table(here, "triangular-pair", "0:20:10", "30");
    let sheet = [
        "--c", "0.2", "--a", "4.5", "--table", &table, "-o", "e.html",
    ];
    let cases: [(&[&str], &str); 6] = [
        (&["--width", "9.9"], "10 to 3000 mm wide"),
        (&["--width", "3001"], "--width 3001"),
        (&["--nearest", "500", "--farthest", "100"], "--farthest"),
        (&["--source", "none.png"], "none.png"),
        (&["--transfer", "srgb"], "--source"),
        (&["result.json"], "cannot be used with"),
    ];
    for (options, part) in cases {
        let run = fit(here, &[&["explore"], options, &sheet[..]].concat());
        assert_ne!(run.code, Some(0), "{options:?}");
        assert!(run.err.contains(part), "{options:?}: {}", run.err);
        assert!(!here.join("e.html").exists());
    }
    let picture = [&["explore"], &sheet[..6], &["-o", "e.png"]].concat();
    let run = fit(here, &picture);
    assert_eq!(run.code, Some(2));
    assert!(run.err.contains("is written as .html"), "{}", run.err);
    assert!(!here.join("e.png").exists());
    let wide = ["--width", "1500", "--distance", "500"];
    let run = fit(here, &[&["explore"], &wide[..], &sheet].concat());
    assert!(run.err.contains("exchange --width"), "{}", run.err);
    std::fs::remove_file(here.join("e.html")).unwrap();
    // Errors of 1 mrad put light far off at 1 km: that fits into no page.
    let design = [
        "design",
        "triangular-pair",
        "--dihedral-error-mrad",
        "1,0,-0.6",
    ];
    let made = bake(here, &[&design[..], &["-o", "off.obj"]].concat());
    made.done();
    let trace = [
        "trace",
        "off.obj",
        "--refractive-index",
        "1",
        "--incidence",
        "0:20:10",
        "--azimuth",
        "30",
    ];
    bake(here, &[&trace[..], &["-o", "off.h5"]].concat()).done();
    let options = [
        "--c", "0.01", "--a", "4.5", "--table", "off.h5", "-o", "e.html",
    ];
    let far = ["explore", "--farthest", "1000000"];
    let run = fit(here, &[&far[..], &options].concat());
    assert_eq!(run.code, Some(1));
    assert!(run.err.contains("shorter --farthest"), "{}", run.err);
}
