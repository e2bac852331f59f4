#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]
use crate::plan::directions::angles;
use crate::plan::effort::*;
use crate::plan::plan::*;
use crate::plan::request::*;
use num_complex::Complex64;
use tables::options::{Back, Losses, Sampler};

#[test]
fn lists_and_ranges() {
    assert_eq!(angles("--incidence", "0:45:5").unwrap().len(), 10);
    assert_eq!(angles("--incidence", "0:0.3:0.1").unwrap().len(), 4);
    assert_eq!(
        angles("--incidence", "30, 0,15,0").unwrap(),
        [0.0, 15.0, 30.0]
    );
    assert_eq!(
        angles("--azimuth", "-0").unwrap()[0].to_bits(),
        0_f64.to_bits()
    );
}

#[test]
fn defaults_make_a_plan() {
    let plan = Plan::new(&Request::default()).unwrap();
    assert_eq!(plan.axes.shape(), (10, 1));
    assert_eq!(plan.effort, Effort::Rays(4_194_304));
    assert_eq!(plan.randomisations, 16);
}

/// Checks the sentence that each bad option gets.
#[test]
fn bad_options_name_option_value_and_remedy() {
    let base = Request::default;
    let text = |incidence: &str| Request {
        incidence: incidence.into(),
        ..base()
    };
    let cases = [
        (
            text("0:45"),
            "--incidence 0:45, degrees: a range has three parts",
        ),
        (
            text("0:45:-5"),
            "--incidence 0:45:-5, degrees: a range needs",
        ),
        (
            text("0,x"),
            "--incidence 0,x, degrees: \"x\" is not a number; write",
        ),
        (
            text("nan"),
            "--incidence nan, degrees: \"nan\" is not a number",
        ),
        (text(""), "\"\" is not a number"),
        (
            text("90"),
            "--incidence 90: the angle must be from 0 to below 90",
        ),
        (text("-1"), "--incidence -1: the angle must be"),
        (
            Request {
                azimuth: "all".into(),
                ..base()
            },
            ", full or mean",
        ),
        (
            Request {
                direction_tolerance: Some(0.0),
                ..base()
            },
            "--direction-tolerance 0: give a number above 0",
        ),
        (
            Request {
                direction_tolerance: Some(0.01),
                azimuth: "mean".into(),
                ..base()
            },
            "--direction-tolerance and --azimuth mean exclude",
        ),
        (
            Request {
                azimuth: "full:0".into(),
                ..base()
            },
            "--azimuth full 0: give a number from 0.01 to 90, the widest step",
        ),
        (
            Request {
                azimuth: "400".into(),
                ..base()
            },
            "--azimuth 400: the angle must be from -360 to 360",
        ),
        (
            Request { bins: 0, ..base() },
            "--bins 0: give a whole number from 1 to 4096",
        ),
        (
            Request {
                range: 0.0,
                ..base()
            },
            "--range 0: give a number above 0",
        ),
        (
            Request {
                range: f64::NAN,
                ..base()
            },
            "--range NaN: give a number above 0",
        ),
        (
            Request {
                rays: Some(0),
                ..base()
            },
            "--rays 0: give a whole number",
        ),
        (
            Request {
                rays: Some(1),
                tolerance: Some(0.1),
                ..base()
            },
            "--rays and --tolerance exclude",
        ),
        (
            Request {
                tolerance: Some(-1.0),
                ..base()
            },
            "--tolerance -1: give a number from 1e-7 to 2, the greatest L1 distance",
        ),
        (
            Request {
                tolerance: Some(0.1),
                sampler: Sampler::Random,
                ..base()
            },
            "--tolerance needs --sampler",
        ),
        (
            Request {
                refractive_index: Some(0.5),
                ..base()
            },
            "--refractive-index 0.5: give a number from 1",
        ),
        (
            Request {
                angular_tolerance_deg: 0.0,
                ..base()
            },
            "--angular-tolerance 0: give a number above 0",
        ),
        (
            Request {
                shard: Some("3/2".into()),
                ..base()
            },
            "--shard 3/2: give K/N",
        ),
        (
            Request {
                shard: Some("2".into()),
                ..base()
            },
            "--shard 2: give K/N",
        ),
        (
            Request {
                shard: Some("1/2".into()),
                tolerance: Some(0.1),
                ..base()
            },
            "--tolerance and --shard exclude",
        ),
        (
            Request {
                threads: Some(0),
                ..base()
            },
            "--threads 0: give a whole number from 1",
        ),
    ];
    let lossy = |back, reflectance, metal| Request {
        losses: Losses::Fresnel,
        back,
        reflectance,
        metal,
        ..base()
    };
    let metal = Some(Complex64::new(1.0, 7.0));
    let losses = [
        (
            Request {
                reflectance: Some(0.9),
                ..base()
            },
            "--reflectance needs --losses fresnel",
        ),
        (
            Request { metal, ..base() },
            "--metal needs --losses fresnel",
        ),
        (
            lossy(Back::Mirror, Some(0.9), metal),
            "--reflectance and --metal exclude each other",
        ),
        (
            lossy(Back::Tir, None, metal),
            "--metal and --back tir exclude each other",
        ),
        (
            lossy(Back::Mirror, Some(1.1), None),
            "--reflectance 1.1: give a number above 0 and at most 1",
        ),
        (
            Request {
                wavelength_nm: Some(-550.0),
                ..base()
            },
            "--wavelength-nm -550: give a number above 0",
        ),
    ];
    let mut refused = 0;
    for (request, sentence) in cases.iter().chain(&losses) {
        let error = Plan::new(request).expect_err(sentence).to_string();
        assert!(
            error.contains(sentence),
            "\"{error}\" should say \"{sentence}\""
        );
        refused += 1;
    }
    assert_eq!(refused, 31);
}
