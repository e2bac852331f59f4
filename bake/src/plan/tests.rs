use crate::cli::calls::{Caller, trace};
use crate::plan::directions::angles;
use crate::plan::effort::*;
use crate::plan::plan::*;
use crate::plan::request::*;
use std::sync::atomic::AtomicBool;

#[test]
fn lists_and_ranges() {
    let read = |text: &str| angles("--incidence", text).unwrap();
    assert_eq!(read("0:45:5").len(), 10);
    assert_eq!(read("0:0.3:0.1").len(), 4);
    assert_eq!(read("30, 0,15,0"), [0.0, 15.0, 30.0]);
    assert_eq!(read("-0")[0].to_bits(), 0_f64.to_bits());
}

#[test]
fn defaults_make_a_plan() {
    let plan = Plan::new(&Request::default()).unwrap();
    assert_eq!(plan.axes.shape(), (10, 1));
    assert_eq!(plan.effort, Effort::Rays(4_194_304));
    assert_eq!(plan.randomisations, 16);
}

/// Options that are refused, each with a part of its message.
const REFUSED: &str = "\
--incidence 0:45 | --incidence 0:45, degrees: a range has three parts
--incidence 0:45:-5 | --incidence 0:45:-5, degrees: a range needs stop >= start
--incidence 0,x | --incidence 0,x, degrees: \"x\" is not a number; write
--incidence nan | --incidence nan, degrees: \"nan\" is not a number
--incidence , | \"\" is not a number
--incidence 90 | --incidence 90: the angle must be from 0 to below 90
--incidence -1 | --incidence -1: the angle must be
--azimuth all | , full or mean
--azimuth full:0 | --azimuth full 0: give a number from 0.01 to 90, the widest step
--azimuth 400 | --azimuth 400: the angle must be from -360 to 360
--direction-tolerance 0 | --direction-tolerance 0: give a number above 0
--direction-tolerance 0.01 --azimuth mean | --direction-tolerance and --azimuth mean exclude
--bins 0 | '--bins <N>': must be a whole number from 1 to 4096
--range 0 | --range 0: give a number above 0
--range NaN | --range NaN: give a number above 0
--rays 0 | '--rays <N>': must be a whole number
--rays 1 --tolerance 0.1 | --rays and --tolerance exclude
--tolerance -1 | --tolerance -1: give a number from 1e-7 to 2, the greatest L1 distance
--tolerance 0.1 --sampler random | --tolerance needs --sampler
--refractive-index 0.5 | --refractive-index 0.5: give a number from 1
--angular-tolerance 0 | --angular-tolerance 0: give a number above 0
--shard 3/2 | --shard 3/2: give K/N
--shard 2 | --shard 2: give K/N
--shard 1/2 --tolerance 0.1 | --tolerance and --shard exclude
--threads 0 | '--threads <N>': must be a whole number from 1
--reflectance 0.9 | --reflectance needs --losses fresnel
--metal 1,7 | --metal needs --losses fresnel
--losses fresnel --reflectance 0.9 --metal 1,7 | --reflectance and --metal exclude each other
--losses fresnel --back tir --metal 1,7 | --metal and --back tir exclude each other
--losses fresnel --reflectance 1.1 | --reflectance 1.1: give a number above 0 and at most 1
--wavelength-nm -550 | --wavelength-nm -550: give a number above 0";

#[test]
fn bad_options_name_option_value_and_remedy() {
    let stop = AtomicBool::new(false);
    let caller = Caller {
        told: &|_, _| (),
        stop: &stop,
    };
    let mut refused = 0;
    for line in REFUSED.lines() {
        let (options, sentence) = line.split_once(" | ").unwrap();
        let words = format!("none.obj -o none.h5 {options}");
        let words: Vec<_> = words.split(' ').map(Into::into).collect();
        let error = trace(&words, None, caller).expect_err(sentence).to_string();
        assert!(error.contains(sentence), "{options}: {error}");
        refused += 1;
    }
    assert_eq!(refused, 31);
}

/// Numbers that the command line refuses before there is a request.
#[test]
fn requests_of_other_programs_are_checked_too() {
    let changes: [fn(&mut Request); 3] = [
        |request| request.bins = 0,
        |request| request.rays = Some(0),
        |request| request.threads = Some(0),
    ];
    for change in changes {
        let mut request = Request::default();
        change(&mut request);
        let error = Plan::new(&request).expect_err("a zero").to_string();
        assert!(error.contains(" 0: give a whole number from 1"), "{error}");
    }
}
