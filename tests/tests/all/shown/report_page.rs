//! Page of `fit estimate --report`: its elements, and its look in a browser.

use std::fs;
use std::path::Path;

use base64::Engine;
use roxmltree::{Document, Node, ParsingOptions};
use serde_json::Value;
use sha2::{Digest, Sha256};
use tests::browser::Browser;
use tests::estimate::json;
use tests::files::{argument, bake_table};
use tests::program::fit;

/// A file name that would become markup if the page did not escape it.
const HOSTILE: &str = "<script>alert('1')&\"<b>.exr";

/// Writes a campaign with causes for warnings and returns its manifest.
///
/// It has six photographs, two each at 0, 20 and 40 degrees of incidence. The half mirror makes mu
/// larger than 1. One photograph at 20 degrees has a hostile name, a region and a transfer.
fn doubtful_campaign(here: &Path) -> String {
    let parameters = argument("tests/tests/all/planted/eq1.toml");
    fit(here, &format!("simulate {parameters} -o campaign --force")).done();
    let folder = here.join("campaign");
    let manifest = folder.join("captures.toml");
    let text = fs::read_to_string(&manifest).unwrap();
    let renamed = "aerial_002_150mm_20deg_tan.exr";
    fs::rename(folder.join(renamed), folder.join(HOSTILE)).unwrap();
    let named = format!("image = \"{renamed}\"");
    let hostile =
        format!("image = '''{HOSTILE}'''\nroi = [40, 30, 240, 200]\ntransfer = \"linear\"");
    let mirror = "half_mirror_transmittance = 0.5";
    assert_eq!(
        (text.matches(&named).count(), text.matches(mirror).count()),
        (1, 1)
    );
    let text = text.replace(&named, &hostile);
    let text = text.replace(mirror, "half_mirror_transmittance = 0.2");
    fs::write(&manifest, text).unwrap();
    "campaign/captures.toml".into()
}

/// Runs `fit estimate --report` on [`doubtful_campaign`]; returns the page and the result.
fn report(here: &Path, options: &str) -> (String, Value) {
    let table = bake_table(here, "triangular-pair", "0:40:20", "30");
    let manifest = doubtful_campaign(here);
    let files = format!("estimate {manifest} --table {table} -o r.json --report r.html");
    let truth = "--truth campaign/truth.json";
    let run = fit(here, &format!("{files} {truth} {options}"));
    assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
    let page = fs::read_to_string(here.join("r.html")).unwrap();
    (page, json(&here.join("r.json")))
}

fn parse(page: &str) -> Document<'_> {
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(page, options).unwrap_or_else(|error| panic!("{error}"))
}

fn all<'a>(tree: &'a Document, name: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    tree.descendants()
        .filter(move |node| node.has_tag_name(name))
}

fn text(node: Node) -> String {
    let texts = node.descendants().filter(|n| n.is_text());
    texts.filter_map(|n| n.text()).collect()
}

/// Checks that the page makes a browser fetch nothing and run nothing, and that its policy allows
/// nothing but its own style sheet and the pictures in it.
fn asks_for_nothing(page: &str, tree: &Document) {
    let policy = all(tree, "meta")
        .find(|meta| meta.attribute("http-equiv") == Some("Content-Security-Policy"))
        .and_then(|meta| meta.attribute("content"))
        .expect("a policy");
    let style = all(tree, "style").next().map(text).expect("a style sheet");
    let hash = base64::engine::general_purpose::STANDARD.encode(Sha256::digest(style));
    let expected = format!(
        "default-src 'none'; style-src 'sha256-{hash}'; img-src data:; base-uri 'none'; \
        form-action 'none'"
    );
    assert_eq!(policy, expected);
    let (before, after) = page.split_once("<meta http-equiv=").unwrap();
    let page = [before, after.split_once("/>").unwrap().1].concat();
    for word in ["http", "//", "url(", "@import", "javascript:"] {
        // Base64 may hold slashes, so the text of pictures is left out.
        let outside = page
            .split("data:image/png;base64,")
            .map(|part| part.split_once('"').map_or(part, |(_, rest)| rest));
        for part in std::iter::once(page.split("data:").next().unwrap()).chain(outside.skip(1)) {
            assert!(!part.contains(word), "the page holds {word}");
        }
    }
    for node in tree.descendants().filter(Node::is_element) {
        let tag = node.tag_name().name();
        assert!(
            !["script", "link", "iframe", "object", "img"].contains(&tag),
            "{tag}"
        );
        for attribute in node.attributes() {
            let (name, value) = (attribute.name(), attribute.value());
            assert!(!name.starts_with("on") && name != "src", "{name}={value}");
            if name == "href" {
                let inside = value.starts_with('#') || value.starts_with("data:image/png;base64,");
                assert!(inside, "{value}");
            }
        }
    }
}

/// One page, by two numbers of threads, is looked at in every way.
#[test]
fn the_page_is_whole_readable_and_seen_at_every_width() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (one, _) = report(here, "--threads 1");
    let (page, result) = report(here, "--threads 2");
    assert!(one.replace("--threads 1", "--threads 2") == page);
    let tree = parse(&page);
    asks_for_nothing(&page, &tree);
    assert_eq!(charts::check::faults(&page), [""; 0]);
    is_whole(&tree, &result);
    can_be_read_by_all(&tree);
    shows_an_image_like_the_verb(here, &tree, &result);
    is_seen_at_every_width_and_on_paper(here, &page);
}

fn is_whole(tree: &Document, result: &Value) {
    // Every photograph has a figure of its curves with its own name.
    let named: Vec<String> = all(tree, "figure")
        .filter(|figure| figure.attribute("class") == Some("capture"))
        .map(|figure| {
            let code = figure.descendants().find(|n| n.has_tag_name("code"));
            text(code.expect("a capture has a name"))
        })
        .collect();
    let captures = result["captures"].as_array().unwrap();
    let wanted: Vec<&str> = captures
        .iter()
        .map(|c| c["image"].as_str().unwrap())
        .collect();
    assert_eq!((named.len(), wanted[1]), (6, HOSTILE));
    assert_eq!(named, wanted);

    // Every number of the result is in a table: c, and a and mu at three angles. Two digits of the
    // standard error are shown, so rounding changes a number by at most 0.05 of its error.
    let rows: Vec<Vec<String>> = all(tree, "tr")
        .map(|row| row.children().filter(Node::is_element).map(text).collect())
        .collect();
    let mut found = 0;
    let mut is_shown = |symbol: &str, angle: &str, number: &Value| {
        let get = |key: &str| number[key].as_f64().unwrap();
        let row = rows
            .iter()
            .find(|row| row[0].starts_with(symbol) && row[1] == angle);
        let shown: f64 = row.expect("it has a row")[2].parse().unwrap();
        let off = (shown - get("value")).abs() / get("standard_error");
        assert!(off <= 0.0501, "{symbol} at {angle}: {shown} for {number}");
        found += 1;
    };
    is_shown("c", "all", &result["c_mm"]);
    for (symbol, parameter) in [("a", "a_per_mm"), ("\u{b5}", "mu")] {
        for entry in result[parameter]["per_angle"].as_array().unwrap() {
            let angle = format!("{}\u{b0}", entry["incidence_deg"].as_f64().unwrap());
            is_shown(symbol, &angle, entry);
        }
    }
    let chosen = all(tree, "tr").filter(|row| row.attribute("class") == Some("chosen"));
    let chosen: Vec<String> = chosen.map(text).collect();
    assert_eq!(chosen.len(), 1, "{chosen:?}");
    assert!(chosen[0].starts_with("eq1radiala per angle"), "{chosen:?}");
    let candidates = result["candidates"].as_array().unwrap().len();
    assert_eq!((found, candidates), (7, 7));

    // Every warning is there.
    let warnings: Vec<String> = all(tree, "li").map(text).collect();
    let said = captures
        .iter()
        .map(|c| &c["warnings"])
        .chain([&result["warnings"]])
        .flat_map(|list| list.as_array().unwrap());
    let mut counted = 0;
    for warning in said.map(|w| w.as_str().unwrap()) {
        assert!(
            warnings.iter().any(|w| w == warning),
            "{warning} in {warnings:?}"
        );
        counted += 1;
    }
    assert_eq!((counted, warnings.len()), (warnings.len(), counted));
    assert!(counted > 0, "nothing was warned about");

    // The page says how the values of the files became light. One of the six is told to be linear
    // by the manifest, so that two lists are named.
    let light = all(tree, "div")
        .map(text)
        .find(|entry| entry.starts_with("light"))
        .expect("an entry on light");
    for wanted in [
        "Reference: linear (EXR).",
        "5 photographs: ",
        &format!("1 photograph: {HOSTILE}: linear (given as `transfer`)."),
    ] {
        assert!(light.contains(wanted), "{wanted} in {light}");
    }

    // What is taken on trust has a row each. A pitch that is 1 % larger gives c + 1 % and a - 1 %.
    let trusted = result["trusted"].as_array().unwrap();
    let named = [
        "pixel pitch",
        "floating distances",
        "half mirror (",
        "exposure of",
        "exposures over",
        "refractive index",
        "incidence angles",
        "azimuths",
        "tangential axes",
        "lens: as",
        "dihedral angles",
        "light over",
        "cell of",
    ];
    assert_eq!(trusted.len(), named.len());
    for (entry, name) in trusted.iter().zip(named) {
        let own: Vec<&Vec<String>> = rows.iter().filter(|r| r[0].starts_with(name)).collect();
        assert_eq!((own.len(), own[0].len()), (1, 6), "{name}: {own:?}");
        let cells = [("c_mm", 3), ("a_per_mm", 4), ("mu", 5)];
        for (key, cell) in cells {
            let shown = match entry["effect"][key].as_f64() {
                Some(share) => format!("{:+.2} %", 100.0 * share).replace('-', "\u{2212}"),
                None => "\u{2013}".into(),
            };
            assert_eq!(own[0][cell], shown, "{name}: {key}");
        }
    }
    let pitch = rows
        .iter()
        .find(|row| row[0].starts_with("pixel pitch"))
        .unwrap();
    assert_eq!(pitch[2..5], ["1 %", "+1.00 %", "\u{2212}0.99 %"]);

    // The page names the table's content hash and the command line.
    for wanted in [
        result["table"]["content_hash"].as_str().unwrap(),
        "--report r.html",
    ] {
        assert!(
            all(tree, "code").any(|code| text(code).contains(wanted)),
            "{wanted}"
        );
    }
}

fn can_be_read_by_all(tree: &Document) {
    assert_eq!(tree.root_element().attribute("lang"), Some("en"));
    // The page explains each technical word exactly once.
    let words = text(tree.root_element());
    for explanation in [
        "this is the ray shift",
        "one ray becomes a spot of light, the lobe",
        "Chi-square is the sum of the squared differences",
        "c is the edge of one corner cube",
        "a says how narrow the spot is",
        "\u{b5} (mu) is the returned light",
        "(MTF) says how much contrast",
        "A kernel is the set of causes of blur",
        "fit/doc/model.md",
    ] {
        assert_eq!(words.matches(explanation).count(), 1, "{explanation}");
    }
    let mut pictures = 0;
    for svg in
        all(tree, "svg").filter(|svg| !svg.ancestors().skip(1).any(|a| a.has_tag_name("svg")))
    {
        assert_eq!(svg.attribute("role"), Some("img"));
        assert!(
            svg.attribute("aria-label")
                .is_some_and(|label| label.len() > 10)
        );
        pictures += 1;
    }
    // Six photographs, a and mu by angle, the profile of c, and the ellipses. There are crops too.
    assert!(pictures >= 6 + 2 + 2, "{pictures}");
    let headings: Vec<&str> = tree
        .descendants()
        .map(|node| node.tag_name().name())
        .filter(|name| ["h1", "h2", "h3"].contains(name))
        .collect();
    assert_eq!((headings[0], headings[1]), ("h1", "h2"));
    assert_eq!(headings.iter().filter(|h| **h == "h1").count(), 1);
    let mut ids: Vec<&str> = tree
        .descendants()
        .filter_map(|n| n.attribute("id"))
        .collect();
    let links = all(tree, "a").filter_map(|a| a.attribute("href")?.strip_prefix('#'));
    for anchor in links {
        assert!(ids.contains(&anchor), "#{anchor} leads nowhere");
    }
    let (before, _) = (ids.len(), ids.sort_unstable());
    ids.dedup();
    assert_eq!((ids.len(), before), (14, 14), "ids are unique");
}

fn shows_an_image_like_the_verb(here: &Path, tree: &Document, result: &Value) {
    let numbers: Vec<String> = all(tree, "dl")
        .filter(|list| list.attribute("class") == Some("brief cards"))
        .flat_map(|list| list.children().filter(Node::is_element).map(text))
        .collect();
    assert_eq!(numbers.len(), 3, "{numbers:?}");
    for (card, name) in numbers
        .iter()
        .zip(["c corner", "a diffraction", "\u{b5} reflect"])
    {
        assert!(
            card.starts_with(name) && card.contains("standard error"),
            "{card}"
        );
    }
    let pictures: Vec<image::RgbImage> = all(tree, "svg")
        .filter(|svg| svg.attribute("class") == Some("picture"))
        .map(|svg| {
            let image = svg.descendants().find(|n| n.has_tag_name("image")).unwrap();
            let data = image.attribute("href").unwrap();
            let data = data.strip_prefix("data:image/png;base64,").unwrap();
            let png = base64::engine::general_purpose::STANDARD.decode(data);
            image::load_from_memory(&png.unwrap()).unwrap().to_rgb8()
        })
        .collect();
    let sign = argument("doc/sign.png");
    assert_eq!(pictures.len(), 2);
    assert!(pictures[0] == image::open(&sign).unwrap().to_rgb8());
    // The image is that of the farthest photograph of the least incidence.
    let captures = result["captures"].as_array().unwrap();
    let of = |key: &'static str| captures.iter().map(move |c| c[key].as_f64().unwrap());
    let least = of("incidence_deg").fold(f64::INFINITY, f64::min);
    let there = of("floating_distance_mm").zip(of("incidence_deg"));
    let farthest = there
        .filter(|(_, angle)| *angle == least)
        .map(|pair| pair.0);
    let distance = farthest.fold(0.0, f64::max).to_string();
    let incidence = least.to_string();
    let table = bake_table(here, "triangular-pair", "0:40:20", "30");
    let files = format!("render --source {sign} --params r.json --table {table}");
    let place = format!("--distance {distance} --incidence {incidence}");
    let look = "--pixel-pitch 0.1 --auto-exposure -o sign.png";
    // The verb repeats the warnings of the result.
    let run = fit(here, &format!("{files} {place} {look}"));
    assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
    let rendered = image::open(here.join("sign.png")).unwrap().to_rgb16();
    assert_eq!(rendered.dimensions(), pictures[1].dimensions());
    // 8 bits are off by half a step at most, and 16 bits by 1/257 of that.
    let steps = rendered.as_raw().iter().zip(pictures[1].as_raw());
    let off = steps.map(|(&fine, &coarse)| (f64::from(fine) / 257.0 - f64::from(coarse)).abs());
    let (count, worst) = off.fold((0, 0.0_f64), |(n, worst), off| (n + 1, worst.max(off)));
    assert_eq!(count, 384 * 288 * 3);
    assert!(worst <= 0.5 * (1.0 + 1.0 / 257.0) + 1e-9, "{worst}");
    assert_ne!(pictures[0], pictures[1], "the image is blurred");
}

#[test]
fn a_crop_shows_the_photograph_that_is_warned_about() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bake_table(here, "triangular-pair", "0:40:40", "30");
    let manifest = doubtful_campaign(here);
    let files = format!("estimate {manifest} --table {table} --report r.html");
    let run = fit(here, &files);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let page = fs::read_to_string(here.join("r.html")).unwrap();
    let tree = parse(&page);
    let crops: Vec<Node> = all(&tree, "svg")
        .filter(|svg| svg.attribute("class") == Some("photo"))
        .collect();
    // The two photographs at 20 degrees have a crop. The table holds 0 and 40 degrees but not 20,
    // so `fit` interpolates and warns.
    assert_eq!(crops.len(), 2);
    // Blocks of 2 pixels: the region of 240 x 200 at (40, 30) with a margin of 36, and the whole
    // picture of 320 x 256.
    let label = crops[0].attribute("aria-label").unwrap();
    assert!(label.starts_with(HOSTILE), "{label}");
    let sizes = [(156, 128), (160, 128)];
    for (crop, (size, regions)) in crops.iter().zip(sizes.iter().zip([1, 0])) {
        let image = crop
            .descendants()
            .find(|n| n.has_tag_name("image"))
            .unwrap();
        let data = image.attribute("href").unwrap();
        let data = data.strip_prefix("data:image/png;base64,").unwrap();
        let png = base64::engine::general_purpose::STANDARD
            .decode(data)
            .unwrap();
        let picture = image::load_from_memory(&png).unwrap();
        assert_eq!((picture.width(), picture.height()), *size);
        let drawn = |tag: &str| crop.descendants().filter(|n| n.has_tag_name(tag)).count();
        assert_eq!(drawn("rect"), regions);
        assert_eq!(drawn("path"), 2, "the edge and its dark border");
    }
}

#[test]
fn what_is_only_bounded_has_a_page_too() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bake_table(here, "triangular-pair", "0:30:30", "30");
    let parameters = fs::read_to_string(argument("tests/tests/all/planted/angular.toml")).unwrap();
    // The truth is the kernel `lobe`, so c has no value, only an upper bound.
    let parameters = parameters
        .replace("kernel = \"angular\"", "kernel = \"lobe\"")
        .replace("a = 900.0", "a = 2.5");
    fs::write(here.join("lobe.toml"), parameters).unwrap();
    fit(here, "simulate lobe.toml -o lobe").done();
    let files = format!("estimate lobe/captures.toml --table {table} -o r.json --report r.html");
    let terms = "--kernel eq1 --lobe separable --shared a,mu";
    fit(here, &format!("{files} {terms}")).done();
    let result = json(&here.join("r.json"));
    assert!(
        result["bounds"]["c_mm"]["at_most"].is_f64(),
        "{}",
        result["bounds"]
    );
    let page = fs::read_to_string(here.join("r.html")).unwrap();
    let tree = parse(&page);
    asks_for_nothing(&page, &tree);
    let bound = |tree: &Document| {
        let cards: String = all(tree, "dl").map(text).collect();
        assert!(cards.contains("c corner size\n< 0."), "{cards}");
    };
    bound(&tree);
    let profiles = all(&tree, "svg")
        .filter_map(|svg| svg.attribute("aria-label"))
        .filter(|label| label.starts_with("Rise of chi-square. c is smaller than"));
    assert_eq!(profiles.count(), 1);

    // If the kernel is left open, `lobe` is chosen. c is not in this model, but has a bound.
    fit(here, &format!("{files} --lobe separable")).done();
    assert_eq!(json(&here.join("r.json"))["kernel"], "lobe");
    let page = fs::read_to_string(here.join("r.html")).unwrap();
    bound(&parse(&page));
}

#[test]
fn a_page_replaces_no_input_and_no_other_output() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let table = bake_table(here, "triangular-pair", "0:40:20", "30");
    let manifest = doubtful_campaign(here);
    let before = fs::read(here.join(&manifest)).unwrap();
    for (other, remedy) in [
        (manifest.as_str(), "write to another file"),
        ("same", "give each a file of its own"),
        (
            "no/such/folder/r.html",
            "there is no folder no/such/folder; make it",
        ),
    ] {
        let files = format!("estimate {manifest} --table {table} -o same --report {other}");
        let run = fit(here, &files);
        assert_eq!(run.code, Some(1), "{}", run.line);
        assert!(run.err.contains(remedy), "{}", run.err);
    }
    assert_eq!(fs::read(here.join(&manifest)).unwrap(), before);
    assert!(!here.join("same").exists());
}

/// Width of the window in CSS pixels (phone, desktop), and whether the user prefers dark colours.
const WINDOWS: [(u32, bool); 4] = [(390, false), (390, true), (1200, false), (1200, true)];

fn is_seen_at_every_width_and_on_paper(here: &Path, page: &str) {
    let Some(browser) = Browser::find() else {
        return;
    };
    let probe = include_str!("probe.js");
    let hash = base64::engine::general_purpose::STANDARD.encode(Sha256::digest(probe));
    let probed = page
        .replacen(
            "style-src",
            &format!("script-src 'sha256-{hash}'; style-src"),
            1,
        )
        .replace("</body>", &format!("<script>{probe}</script></body>"));
    fs::write(here.join("probe.html"), probed).unwrap();
    for (width, dark) in WINDOWS {
        let found = browser.probe(&here.join("probe.html"), width, dark);
        let number = |key: &str| {
            found[key]
                .as_f64()
                .unwrap_or_else(|| panic!("{key}: {found}"))
        };
        assert_eq!(number("window"), f64::from(width), "{found}");
        // Only tables may be wider than the window, because they scroll by themselves.
        assert_eq!(number("page"), f64::from(width), "{found}");
        assert_eq!(found["wide"], serde_json::json!([]), "{width}");
        // The flattest chart is 196 high if it is 360 wide. On a phone it is 390 - 2 x 16 wide.
        assert!(number("smallest_chart") > 190.0, "{found}");
        assert!(number("smallest_text") >= 9.0, "{found}");
        // WCAG 2.2, 1.4.3 (AA).
        assert!(number("least_contrast") >= 4.5, "{found}");
        assert_eq!(found["dark"], dark, "{found}");
        assert_eq!(number("captures"), 6.0);
        assert_eq!(number("folded"), 7.0);
        assert_eq!(number("broken_images"), 0.0);
    }
    let printed = |name: &str| {
        let paper = browser.print(&here.join(name), &here.join("r.pdf"));
        assert!(paper.starts_with(b"%PDF-"));
        let text = String::from_utf8_lossy(&paper).into_owned();
        text.matches("/Type /Page\n").count()
    };
    // Paper shows what is folded on the screen. A page may break elsewhere if a part was opened.
    let each = |attribute: &str| {
        let other = page.replace("<details>", &format!("<details {attribute}=\"\">"));
        assert_eq!(other.matches(&format!("<details {attribute}")).count(), 7);
        fs::write(here.join("other.html"), other).unwrap();
        printed("other.html")
    };
    let pages = printed("r.html");
    let (open, hidden) = (each("open"), each("hidden"));
    println!("{pages} pages, {open} with open parts, {hidden} without");
    assert!(pages.abs_diff(open) <= 1 && pages > hidden + 1);
    assert!((2..12).contains(&pages), "{pages} pages");
}
