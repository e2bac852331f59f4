//! Page of `fit explore`: its pixels in a browser against `fit render`, and its refusals.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use tests::browser::Browser;
use tests::files::{argument, bake_table};
use tests::program::{bake, fit};

/// Code of the colour of the bars, which blur makes half as bright.
const BARS: [u8; 3] = [255, 0, 0];
/// Code of the colour of the disc, whose middle stays as bright as it is. It is darker than the
/// bars, and brighter than what blur leaves of them.
const DISC: [u8; 3] = [0, 140, 140];

/// Writes a small picture in colour, whose codes are sRGB: bars, a frame and a disc.
fn picture(here: &Path) {
    let image = image::RgbImage::from_fn(96, 64, |x, y| {
        let disc = (x as i32 - 70).pow(2) + (y as i32 - 32).pow(2) < 300;
        match (x, y) {
            (4..40, _) if x % 6 < 3 && (8..56).contains(&y) => image::Rgb(BARS),
            _ if disc => image::Rgb(DISC),
            (0 | 95, _) | (_, 0 | 63) => image::Rgb([30, 90, 250]),
            _ => image::Rgb([0, 0, 0]),
        }
    });
    image.save(here.join("content.png")).unwrap();
}

/// Puts scripts into a page: one that keeps errors before all others, the probe behind them, and
/// one that the page's policy must not let run. The policy gets the hashes of the first two.
///
/// Frames come from timers. Virtual time waits for these, but not for the frames of a busy machine.
fn probed(page: &str, settings: &Value) -> String {
    let first = "const ERRORS = []; addEventListener('error', (e) => \
        ERRORS.push(e.message)); addEventListener('unhandledrejection', (e) => \
        ERRORS.push(String(e.reason))); console.error = (...all) => \
        ERRORS.push(all.join(' ')); requestAnimationFrame = (draw) => \
        setTimeout(draw, 16); const BLOCKED = []; \
        addEventListener('securitypolicyviolation', (e) => BLOCKED.push(e.effectiveDirective));";
    let probe = format!(
        "const SETTINGS = {settings};\n{}",
        include_str!("explore_probe.js")
    );
    let policy = format!("script-src {} {} ", allowed(first), allowed(&probe));
    let foreign = "<script>ERRORS.push('a foreign script ran')</script>\
        <b onclick=\"ERRORS.push('a foreign handler ran')\" id=\"foreign\"></b>";
    page.replacen("script-src ", &policy, 1)
        .replacen("<title>", &format!("<script>{first}</script><title>"), 1)
        .replacen(
            "</body>",
            &format!("{foreign}<script>{probe}</script>\n</body>"),
            1,
        )
}

/// Returns the words by which a policy allows a script or a style sheet.
fn allowed(text: &str) -> String {
    format!("'sha256-{}'", STANDARD.encode(Sha256::digest(text)))
}

fn floats(text: &Value) -> Vec<f32> {
    let bytes = STANDARD.decode(text.as_str().unwrap()).unwrap();
    let floats = bytes.chunks_exact(4);
    floats
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

/// Runs `fit` and returns the facts that it prints as JSON. Warnings are allowed.
fn facts(here: &Path, command: &str) -> Value {
    let run = fit(here, command);
    assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
    serde_json::from_str(&run.out).unwrap()
}

/// Returns the first number of a text.
fn number(text: &Value) -> f64 {
    let text = text.as_str().unwrap();
    let from = text.find(|c: char| c.is_ascii_digit()).expect(text);
    let digits = text[from..].split([' ', ';', ',']).next().unwrap();
    digits.parse().unwrap_or_else(|_| panic!("{text}"))
}

/// Returns the light of a code, by the definition of sRGB (IEC 61966-2-1).
fn light(code: u8) -> f64 {
    let v = f64::from(code) / 255.0;
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// Returns the luminance of linear light by ITU-R BT.709.
fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The facts that a page shows at a setting against what they are, computed from `fit predict` and
/// from the image of `fit render`: luminance, MTF50, letter, exposure and size. Returns how many
/// were compared.
///
/// The page writes three digits, so a number is off by half a unit of the third, 0.5 %. `stated` is
/// the error of a pixel or a weight of the page, as a part of the brightest, and frequencies are
/// off by as much where an MTF falls.
fn facts_are_right(
    image: &Value,
    setting: &Value,
    predicted: &Value,
    aerial: &fit::Picture,
    stated: f64,
) -> usize {
    let of = |key: &str| setting[key].as_f64().unwrap();
    let fact = |key: &str| number(&image["facts"][key]);
    let near = |found: f64, expected: f64, what: &str| {
        let off = (found / expected - 1.0).abs();
        println!(
            "{what}: {found} for {expected}, off by {:.2} %",
            100.0 * off
        );
        assert!(
            off <= 0.005 + stated,
            "{what}: {found} for {expected}: {image}"
        );
    };
    let rows = predicted["predictions"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    let energy = rows[0]["luminance"].as_f64().unwrap();
    near(fact("luminance"), energy * of("luminance"), "luminance");
    // The frequency at which the first of both curves falls to a level, between two frequencies on
    // a straight line.
    let frequencies = predicted["frequency_per_mm"].as_array().unwrap();
    let lesser: Vec<[f64; 2]> = (0..frequencies.len())
        .map(|k| {
            let mtf = |row: &Value| row["mtf"][k].as_f64().unwrap();
            [
                frequencies[k].as_f64().unwrap(),
                mtf(&rows[0]).min(mtf(&rows[1])),
            ]
        })
        .collect();
    let falls_to = |level: f64| {
        let pair = lesser
            .windows(2)
            .find(|pair| pair[1][1] < level)
            .expect("it falls");
        let share = (pair[0][1] - level) / (pair[0][1] - pair[1][1]);
        pair[0][0] + share * (pair[1][0] - pair[0][0])
    };
    near(fact("mtf50"), falls_to(0.5), "mtf50");
    // Ambient light lies on white and on black: the contrast is (white - black) / (white + black).
    let (white, black) = (energy * of("luminance") + of("ambient"), of("ambient"));
    let contrast = (white - black) / (white + black);
    // A letter is five strokes high, and a period of the finest pattern is two strokes.
    let blur = 5.0 * 0.5 / falls_to(of("threshold") / contrast);
    let eye = 1000.0 * of("viewer") * (5.0_f64 / 60.0).to_radians().tan();
    near(fact("letter"), blur.max(eye), "letter");
    let limited = image["facts"]["letter"].as_str().unwrap();
    let by = if eye > blur {
        "limited by the eye"
    } else {
        "limited by the blur"
    };
    assert!(limited.contains(by), "{limited}");
    // Exposure makes the brightest luminance that of the source, unless a colour would be brighter
    // than any of the source.
    let ambient = of("ambient") / of("luminance");
    let source = [BARS, DISC, [30, 90, 250]].map(|codes| codes.map(light));
    let most = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0, f64::max);
    let [red, green, blue] = [0, 1, 2].map(|k| &aerial.planes[k]);
    let luminances = red.iter().zip(green).zip(blue);
    let seen = most(&mut luminances.map(|((r, g), b)| luminance([*r, *g, *b].map(f64::from))));
    let alike = most(&mut source.iter().map(|own| luminance(*own))) / (seen + ambient);
    let seen = most(&mut aerial.planes.iter().flatten().map(|&own| f64::from(own)));
    let unclipped = most(&mut source.iter().flatten().copied()) / (seen + ambient);
    assert!(
        alike < unclipped,
        "the luminance decides: {alike} {unclipped}"
    );
    near(fact("exposure"), alike, "exposure");
    let pitch = image["pitch"].as_f64().unwrap();
    near(fact("size"), 96.0 * pitch, "width");
    6
}

/// A sheet: its options for `fit explore` and `fit render`, and what it tells.
struct Sheet<'a> {
    name: &'static str,
    table: &'a str,
    options: String,
    /// Light that may lie beyond the blur of the page, as a share. The page lays it within the
    /// blur, `fit render` within a wider one.
    tails: f64,
}

/// Writes the result of a sheet whose kernel is `shift`, which no options give: a fit, with c and
/// mu of the other sheets in place of its own.
fn shift_result(here: &Path, table: &str) -> String {
    let (manifest, result) = ("campaign/captures.toml", format!("shift-{table}.json"));
    let estimate = format!("estimate {manifest} --table {table} --kernel shift");
    fit(here, &format!("{estimate} -o {result}"));
    let text = fs::read_to_string(here.join(&result)).unwrap();
    let mut fitted: Value = serde_json::from_str(&text).unwrap();
    fitted["c_mm"]["value"] = json!(0.2);
    fitted["mu"] = json!({"value": 0.5, "standard_error": null});
    fs::write(here.join(&result), fitted.to_string()).unwrap();
    format!("--params {result}")
}

/// Writes a setup whose camera sees a white lamp in three colours. Returns the options of a sheet in
/// its light.
fn coloured_light(here: &Path) -> String {
    let row = |nm: i32| {
        let seen = [600.0, 535.0, 460.0].map(|peak| {
            let off = (f64::from(nm) - peak) / 32.0;
            format!("{:.6}", (-0.5 * off * off).exp())
        });
        format!("{nm},{}\n", seen.join(","))
    };
    let camera: String = (380..=780).step_by(5).map(row).collect();
    fs::write(here.join("camera.csv"), camera).unwrap();
    let setup = "[setup]\nspectrum = \"LED-B3\"\ncamera_response = \"camera.csv\"\n";
    fs::write(here.join("lamp.toml"), setup).unwrap();
    "--c 0.25 --mu 0.5 --setup lamp.toml".to_owned()
}

#[test]
#[ignore = "a minute: `make test-pages` runs it"]
fn a_browser_shows_what_fit_render_computes() {
    compare_pages(&["shift of errors", "eq1", "errors"]);
}

#[test]
#[ignore = "takes minutes: every kind of sheet; `make test-pages` runs it"]
fn a_browser_shows_every_kind_of_sheet() {
    compare_pages(&[
        "shift",
        "shift of rays",
        "sharp eq1",
        "angular",
        "wave",
        "coloured wave",
    ]);
}

/// The pixels of the page at settings off its nodes, against `fit render` at the same ones: they
/// differ by no more than the page states, plus the light in tails that both cut off elsewhere.
///
/// Each picture is also rounded: `fit render` to 32-bit floats, and the page keeps the spectra of
/// picture and blur in 32-bit floats. Three roundings of 6e-8, each of every frequency, add to 1e-7
/// of a pixel as white as the source, and to five times that at the worst of 6144 pixels. White of
/// the source is less than four times the brightest pixel of these images over their energy.
fn compare_pages(names: &[&str]) {
    let Some(browser) = Browser::find() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    picture(here);
    let whole = bake_table(here, "triangular-pair", "0:40:10", "full:10");
    let one = bake_table(here, "triangular-pair", "0:40:5", "23");
    for line in [
        "design triangular-pair --dihedral-error-mrad 0.5,0,-0.3 -o errors.obj",
        "trace errors.obj -o errors.h5 --refractive-index 1.49 --incidence 0:40:5 --azimuth 23",
        "trace triangular-pair.obj -o rays.h5 --refractive-index 1.49 --incidence 0:40:10 \
            --azimuth full:15 --method rays --rays 65536 --bins 64",
    ] {
        bake(here, line).done();
    }
    let parameters = argument("tests/tests/all/planted/shift.toml");
    let campaign = format!("simulate {parameters} -o campaign --force");
    fit(here, &campaign).done();
    let sheet = |name, table, options: &str, tails| Sheet {
        name,
        table,
        options: options.to_owned(),
        tails,
    };
    let scattered = "--c 0.2 --a-times-r 700 --mu 0.5";
    let waves = "--c 0.25 --wavelength-nm 500:0.5,600 --mu 0.5";
    let sheets = [
        sheet("shift", &whole, &shift_result(here, &whole), 0.0),
        sheet(
            "shift of errors",
            "errors.h5",
            &shift_result(here, "errors.h5"),
            0.0,
        ),
        sheet(
            "shift of rays",
            "rays.h5",
            &shift_result(here, "rays.h5"),
            0.0,
        ),
        sheet("eq1", &whole, "--c 0.2 --a 4.5 --mu 0.5", 0.0),
        sheet("sharp eq1", &whole, "--c 0.2 --a 300 --mu 0.5", 0.0),
        sheet("angular", &whole, scattered, 0.0),
        sheet("errors", "errors.h5", scattered, 0.0),
        // Rust cuts the light beyond 0.2 % of each axis, the page that beyond 202 pixels.
        sheet("wave", &one, waves, 0.012),
        // Each colour sees other wavelengths of the lamp.
        sheet("coloured wave", &one, &coloured_light(here), 0.012),
    ];
    // The letter is limited by the blur, by the blur in much ambient light, and by the eye.
    let settings = json!([
        {"distance": 163.0, "incidence": 17.3, "azimuth": 23.0, "width": 38.0,
         "luminance": 500.0, "ambient": 0.0, "viewer": 0.1, "threshold": 0.1},
        {"distance": 240.0, "incidence": 33.1, "azimuth": 71.7, "width": 30.0,
         "luminance": 700.0, "ambient": 20.0, "viewer": 0.1, "threshold": 0.2},
        {"distance": 420.0, "incidence": 6.2, "azimuth": 348.0, "width": 60.0,
         "luminance": 300.0, "ambient": 3.0, "viewer": 4.0, "threshold": 0.1},
    ]);
    let (mut compared, mut facts_compared) = (0, 0);
    for sheet in sheets.iter().filter(|sheet| names.contains(&sheet.name)) {
        let (name, table, options) = (sheet.name, sheet.table, &sheet.options);
        let page = format!("{}.html", name.replace(' ', "-"));
        // A result is an option of `fit render`, and an argument here.
        let named = options.trim_start_matches("--params ");
        let range = "--nearest 100 --farthest 600";
        let command = format!(
            "explore {named} --table {table} --source content.png {range} --json -o {page}"
        );
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
        assert_eq!(
            found["blocked"],
            json!(["script-src-elem", "script-src-attr"])
        );
        for (image, setting) in found["images"]
            .as_array()
            .unwrap()
            .iter()
            .zip(settings.as_array().unwrap())
        {
            let own = &image["own"];
            let number = |key: &str| own[key].as_f64().unwrap().to_string();
            let place = ["distance", "incidence", "azimuth"]
                .map(|key| format!("--{key} {}", number(key)))
                .join(" ");
            let pitch = image["pitch"].as_f64().unwrap();
            let picture = format!("--source content.png --pixel-pitch {pitch} -o aerial.exr");
            let command = format!("render --table {table} {options} {place} {picture} --json");
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
            let frequencies = "--frequency 0:20:0.02 --json";
            let command = format!("predict {named} --table {table} {place} {frequencies}");
            let predicted = facts(here, &command);
            facts_compared += facts_are_right(image, setting, &predicted, &aerial, 0.01);
        }
    }
    let count = 3 * names.len();
    assert_eq!((compared, facts_compared), (3 * count, 6 * count));
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
    fit(here, &format!("simulate {parameters} -o campaign --force")).done();
    let table = bake_table(here, "triangular-pair", "0:40:20", "30");
    let manifest = "campaign/captures.toml";
    let options = "--kernel eq1 --lobe radial -o r.json";
    let estimate = format!("estimate {manifest} --table {table}");
    fit(here, &format!("{estimate} {options}"));
    fit(here, &format!("explore r.json --table {table} -o e.html")).done();
    let page = fs::read_to_string(here.join("e.html")).unwrap();
    let data = page.split_once("id=\"data\">").unwrap().1;
    let data: Value = serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap();
    let span = &data["span"];
    let settings = json!([{"distance": 200.0, "viewer": 1.0}]);
    fs::write(here.join("probe.html"), probed(&page, &settings)).unwrap();
    for (width, dark) in [(360, false), (360, true), (800, false), (1300, true)] {
        let found = browser.probe(&here.join("probe.html"), width, dark);
        assert_eq!(found["errors"], json!([]));
        assert_eq!(found["wide"], json!([]), "{width}");
        assert_eq!(found["unnamed"], json!([]));
        assert_eq!((&found["curves"], &found["bands"]), (&json!(2), &json!(2)));
        // A slider at 990 of 1000 on a scale of logarithms.
        let [near, far] = [0, 1].map(|k| span["distance_mm"][k].as_f64().unwrap());
        let (moved, expected) = (number(&found["spoken"]), near * (far / near).powf(0.99));
        assert!((moved / expected - 1.0).abs() < 0.005, "{moved} {expected}");
        let remarks = found["remarks"].as_str().unwrap();
        assert!(remarks.contains("Outside of the photographs of the fit: distance"));
        assert!(remarks.contains("The kernels angular and wave let it grow"));
        assert!(found["spoken"].as_str().unwrap().ends_with(" mm"));
        let typed = |k: usize| found["typed"][k].as_f64().unwrap();
        assert_eq!((typed(0), typed(1)), (12.5, typed(2)));
        assert!(typed(1) > 12.5 && typed(1) < 90.0, "{}", typed(1));
        assert_eq!(found["saved"], json!([true, true]));
        assert_eq!(found["dropped"], true);
        // From 62 rem on, the pictures stand beside the sliders, and grow to the whole width.
        let grown = found["grown"].as_f64().unwrap();
        assert!((grown > 1.5) == (width > 992), "{width}: {grown}");
    }
}

#[test]
fn wrong_requests_are_refused_and_leave_no_page() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bake_table(here, "triangular-pair", "0:20:10", "30");
    let sheet = format!("--c 0.2 --a 4.5 --table {table} -o e.html");
    let cases: [(&str, &str); 6] = [
        ("--width 9.9", "10 to 3000 mm wide"),
        ("--width 3001", "--width 3001"),
        ("--nearest 500 --farthest 100", "--farthest"),
        ("--source none.png", "none.png"),
        ("--transfer srgb", "--source"),
        ("result.json", "cannot be used with"),
    ];
    for (options, part) in cases {
        let run = fit(here, &format!("explore {options} {sheet}"));
        assert_ne!(run.code, Some(0), "{options:?}");
        assert!(run.err.contains(part), "{options:?}: {}", run.err);
        assert!(!here.join("e.html").exists());
    }
    let run = fit(
        here,
        &format!("explore {}", sheet.replace("e.html", "e.png")),
    );
    assert_eq!(run.code, Some(2));
    assert!(run.err.contains("is written as .html"), "{}", run.err);
    assert!(!here.join("e.png").exists());
    let wide = "--width 1500 --distance 500";
    let run = fit(here, &format!("explore {wide} {sheet}"));
    assert!(run.err.contains("exchange --width"), "{}", run.err);
    std::fs::remove_file(here.join("e.html")).unwrap();
    // Errors of 1 mrad put light far off at 1 km: that fits into no page.
    let design = "design triangular-pair --dihedral-error-mrad 1,0,-0.6";
    let made = bake(here, &format!("{design} -o off.obj"));
    made.done();
    let trace = "trace off.obj --refractive-index 1 --incidence 0:20:10 --azimuth 30";
    bake(here, &format!("{trace} -o off.h5")).done();
    let options = "--c 0.01 --a 4.5 --table off.h5 -o e.html";
    let far = "explore --farthest 1000000";
    let run = fit(here, &format!("{far} {options}"));
    assert_eq!(run.code, Some(1));
    assert!(run.err.contains("shorter --farthest"), "{}", run.err);
}
