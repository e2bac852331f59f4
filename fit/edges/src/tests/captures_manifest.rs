//! Tests of a manifest with every key, and of the campaign that is read from it.

use std::path::Path;

use crate::photographs::Roi;
use crate::photographs::edge::fault::Accepted;
use crate::photographs::manifest::captures;
use crate::photographs::photo::channel::Channel;
use crate::photographs::photo::transfer::Transfer;

/// A folder with a manifest and an image for it, and the campaign that is read from them.
fn campaign(manifest: &str) -> (tempfile::TempDir, captures::Campaign) {
    let folder = tempfile::tempdir().unwrap();
    let image = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/bad/good.exr");
    for name in ["source.exr", "one.exr", "two.exr"] {
        std::fs::copy(&image, folder.path().join(name)).unwrap();
    }
    let file = folder.path().join("captures.toml");
    std::fs::write(&file, manifest).unwrap();
    let campaign = captures::load(&file).unwrap();
    (folder, campaign)
}

#[test]
fn every_key_arrives_and_captures_override_the_setup() {
    let (folder, campaign) = campaign(
        r#"
        [setup]
        pixel_pitch_mm = 0.05
        half_mirror_transmittance = 0.4
        half_mirror_reflectance = 0.6
        wavelength_nm = "450:0.2,550:0.5"
        path_mm = 180
        roi = [1, 2, 10, 8]
        tangential_axis_deg = 90
        transfer = "linear"
        channel = "luminance"
        accept = ["doubled"]

        [reference]
        image = "source.exr"
        roi = [0, 0, 16, 12]

        [[capture]]
        image = "one.exr"
        floating_distance_mm = 150
        incidence_deg = 30.0
        azimuth_deg = -60
        exposure = 6

        [[capture]]
        image = "two.exr"
        floating_distance_mm = 300.0
        incidence_deg = 0
        exposure = 0x10
        path_mm = 333.5
        roi = [0, 1, 3, 4]
        tangential_axis_deg = -3.5
        transfer = "srgb"
        channel = "view.L"
        "#,
    );
    let setup = &campaign.setup;
    assert_eq!(setup.pixel_pitch_mm, 0.05);
    assert_eq!(
        (
            setup.half_mirror_transmittance,
            setup.half_mirror_reflectance
        ),
        (0.4, 0.6)
    );
    let lines: Vec<_> = setup
        .spectrum
        .as_ref()
        .unwrap()
        .lines()
        .iter()
        .map(|line| (line.wavelength_nm, line.weight))
        .collect();
    assert_eq!(lines, [(450.0, 0.2), (550.0, 0.5)]);
    let reference = &campaign.references[0];
    assert_eq!(
        (reference.exposure, reference.roi),
        (
            1.0,
            Some(Roi {
                x: 0,
                y: 0,
                width: 16,
                height: 12
            })
        )
    );
    let [one, two] = &campaign.captures[..] else {
        panic!("{} captures", campaign.captures.len())
    };
    assert_eq!(one.shot.image, folder.path().join("one.exr"));
    assert_eq!(
        (one.floating_distance_mm, one.range_mm(), one.shot.exposure),
        (150.0, 180.0, 6.0)
    );
    assert_eq!(
        (one.incidence_rad(), one.azimuth_rad()),
        (30_f64.to_radians(), Some(-60_f64.to_radians()))
    );
    assert_eq!(one.tangential_axis_rad(), 90_f64.to_radians());
    assert_eq!(
        one.shot.roi,
        Some(Roi {
            x: 1,
            y: 2,
            width: 10,
            height: 8
        })
    );
    assert_eq!(one.shot.decode.transfer, Some(Transfer::Linear));
    assert_eq!(
        (two.range_mm(), two.azimuth_deg, two.tangential_axis_deg),
        (333.5, None, -3.5)
    );
    assert_eq!(two.shot.exposure, 16.0);
    assert_eq!(
        two.shot.roi,
        Some(Roi {
            x: 0,
            y: 1,
            width: 3,
            height: 4
        })
    );
    assert_eq!(two.shot.decode.transfer, Some(Transfer::Srgb));
    assert_eq!(two.shot.decode.channel, Channel::Named("view.L".to_owned()));
    assert_eq!(two.shot.place.line, 26);
    // Keys in [setup] hold for every photograph.
    let source = &campaign.references[0];
    for shot in [source, &one.shot, &two.shot] {
        assert_eq!(shot.accepted, [Accepted::Doubled]);
    }
    assert_eq!(campaign.warnings, Vec::<String>::new());
    assert_eq!(one.shot.load().unwrap().width, 16);
}

#[test]
fn what_is_left_out_has_a_default_and_a_warning() {
    let (_folder, campaign) = campaign(
        "[setup]\npixel_pitch_mm = 1\nwavelength_nm = 550\n\
         [[capture]]\nimage = \"one.exr\"\nfloating_distance_mm = 1\nincidence_deg = 89.9\n\
         [[capture]]\nimage = \"one.exr\"\nfloating_distance_mm = 1\nincidence_deg = 0\n",
    );
    let capture = &campaign.captures[0];
    assert_eq!(
        (
            capture.shot.exposure,
            capture.tangential_axis_deg,
            capture.range_mm()
        ),
        (1.0, 0.0, 1.0)
    );
    assert_eq!(
        (capture.shot.roi, &capture.shot.decode.channel),
        (None, &Channel::Luminance)
    );
    assert_eq!(
        (
            campaign.setup.half_mirror_transmittance,
            campaign.setup.half_mirror_reflectance
        ),
        (1.0, 1.0)
    );
    assert_eq!(
        campaign.setup.spectrum.as_ref().unwrap().lines()[0].wavelength_nm,
        550.0
    );
    let parts = [
        "mu includes it",
        "has no [reference]",
        "used by an earlier capture, so it counts twice",
    ];
    assert_eq!(
        campaign.warnings.len(),
        parts.len(),
        "{:?}",
        campaign.warnings
    );
    for part in parts {
        assert!(
            campaign
                .warnings
                .iter()
                .any(|warning| warning.contains(part)),
            "{part}: {:?}",
            campaign.warnings
        );
    }
}

#[test]
fn the_expected_table_is_a_hash_of_either_case() {
    let hash = "0123456789abcdefABCDEF0123456789abcdefABCDEF0123456789abcdefABCD";
    let folder = tempfile::tempdir().unwrap();
    let image = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/bad/good.exr");
    std::fs::copy(&image, folder.path().join("one.exr")).unwrap();
    let file = folder.path().join("captures.toml");
    let read = |key: &str| {
        let text = format!(
            "[setup]\npixel_pitch_mm = 0.05\n{key}\n[[capture]]\nimage = \"one.exr\"\n\
            floating_distance_mm = 150\nincidence_deg = 20\n"
        );
        std::fs::write(&file, text).unwrap();
        captures::read(&file).map(|manifest| manifest.expected_table)
    };
    let found = read(&format!("expect_table = \"{hash}\""))
        .unwrap()
        .unwrap();
    assert_eq!((found.hash, found.place.line), (hash.to_lowercase(), 3));
    assert_eq!(read("").unwrap(), None);
    let long = format!("{hash}0");
    let none = hash.replace('0', "g");
    for bad in [&hash[1..], &long, &none, ""] {
        let error = read(&format!("expect_table = \"{bad}\"")).unwrap_err();
        assert!(error.to_string().contains("no content hash"), "{error}");
    }
}

/// A reference that is named twice counts twice, as a capture does.
#[test]
fn a_reference_that_is_there_twice_gets_a_warning() {
    let (_folder, campaign) = campaign(
        "[setup]\npixel_pitch_mm = 1\nhalf_mirror_transmittance = 0.5\n\
         half_mirror_reflectance = 0.5\n\
         [[reference]]\nimage = \"source.exr\"\nexposure = 1\n\
         [[reference]]\nimage = \"./source.exr\"\nexposure = 1\n\
         [[capture]]\nimage = \"one.exr\"\nfloating_distance_mm = 1\nincidence_deg = 0\n\
         exposure = 1\n",
    );
    let [warning] = &campaign.warnings[..] else {
        panic!("{:?}", campaign.warnings)
    };
    assert!(warning.contains("captures.toml:9: image "), "{warning}");
    assert!(
        warning.contains("used by an earlier reference"),
        "{warning}"
    );
}

/// Faults of [setup] name their key in one line, and what a setup alone lacks is a warning as it is
/// in a campaign.
#[test]
fn a_setup_alone_is_checked_and_warns() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.toml");
    let read = |keys: &str| {
        std::fs::write(&file, format!("[setup]\n{keys}\n")).unwrap();
        captures::setup_of(&file)
    };
    let cases = [
        (
            "retarder = { waves = nan, axis_deg = 0 }",
            "s.toml:2: `waves` is NaN but must be a finite number",
        ),
        (
            "retarder = { waves = inf, axis_deg = 0 }",
            "s.toml:2: `waves` is inf but must be a finite number",
        ),
        (
            "retarder = { waves = 1e300, axis_deg = 0 }",
            "but must be a finite number, at most 1e9 in size; correct the value",
        ),
        (
            "retarder = { waves = 1, axis_deg = 361.0 }",
            "s.toml:2: `axis_deg` is 361 but must be from -360 to 360 degrees",
        ),
        (
            "half_mirror_transmittance = { s = 0.5 }",
            "s.toml:2: `p` is missing from [setup.half_mirror_transmittance]; add it",
        ),
    ];
    for (keys, expected) in cases {
        let said = read(keys).unwrap_err().to_string();
        assert!(said.contains(expected) && !said.contains('\n'), "{said:?}");
    }
    assert_eq!(cases.len(), 5);
    let both = |t: f64| format!("half_mirror_transmittance = {t}\nhalf_mirror_reflectance = 0.5");
    for (keys, expected) in [
        (String::new(), Some("what is missing counts as 1")),
        (both(0.6), Some("add up to more than 1")),
        (both(0.5), None),
    ] {
        let (_, warnings) = read(&keys).unwrap();
        assert_eq!(warnings.len(), expected.iter().count(), "{warnings:?}");
        assert!(
            expected.is_none_or(|part| warnings[0].contains(part)),
            "{warnings:?}"
        );
    }
}

/// One table and an array of tables are both read, in their order. A further reference without
/// `exposure` needs the camera's settings, which EXR does not have.
#[test]
fn one_reference_or_several_are_read() {
    let rest = "[[capture]]\nimage = \"one.exr\"\nfloating_distance_mm = 1\nincidence_deg = 0\n\
        exposure = 2\n";
    let setup = "[setup]\npixel_pitch_mm = 1\n";
    let several = "[[reference]]\nimage = \"two.exr\"\n[[reference]]\nimage = \"source.exr\"\n\
        exposure = 3\n";
    let mut cases = 0;
    for (references, expected) in [
        ("", vec![]),
        (
            "[reference]\nimage = \"source.exr\"\n",
            vec![("source.exr", 1.0)],
        ),
        (
            "[[reference]]\nimage = \"one.exr\"\n",
            vec![("one.exr", 1.0)],
        ),
        (several, vec![("two.exr", 1.0), ("source.exr", 3.0)]),
    ] {
        let (folder, campaign) = campaign(&format!("{setup}{references}{rest}"));
        let found = campaign.references.iter();
        let found: Vec<_> = found.map(|own| (own.image.clone(), own.exposure)).collect();
        let all = expected.into_iter();
        let all: Vec<_> = all
            .map(|(name, by)| (folder.path().join(name), by))
            .collect();
        assert_eq!(found, all);
        cases += 1;
    }
    assert_eq!(cases, 4);
    let (folder, _) = campaign(&format!("{setup}{rest}"));
    let file = folder.path().join("captures.toml");
    for (text, line) in [
        (several.replace("exposure = 3", ""), 6),
        (several.replace("exposure", "expose"), 7),
        (several.replace("source.exr", "none.exr"), 6),
        ("reference = 3\n".to_owned(), 1),
    ] {
        let order = if text.starts_with('r') {
            format!("{text}{setup}{rest}")
        } else {
            format!("{setup}{text}{rest}")
        };
        std::fs::write(&file, order).unwrap();
        let fault = captures::load(&file).unwrap_err().to_string();
        assert!(
            fault.contains(&format!("captures.toml:{line}: ")),
            "{fault}"
        );
    }
}
