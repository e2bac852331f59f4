//! Tests of `estimate::campaign`, a whole estimate in one call: from memory, reported, and
//! cancelled.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::planted::{camera, params, table, truth};
use crate::simulate::Params;
use crate::simulate::photograph;
use crate::study::trial;
use edges::names::Kernel;
use edges::names::LobeShape;
use estimator::estimate::Candidates;
use estimator::estimate::Kind;
use estimator::estimate::Options;
use estimator::estimate::campaign::campaign;
use estimator::estimate::{Progress, Step};
use estimator::samples::Sampling;
use estimator::samples::Sequence;
use estimator::{Conflict, Error};
use tables::Table;

const INCIDENCE: [f64; 2] = [5.0, 30.0];

fn planted() -> (Params, Table) {
    let truth = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let table = table(&truth, &INCIDENCE, 20.0);
    (params(5, truth, &INCIDENCE, &[200.0], camera(2e4)), table)
}

fn options() -> Options {
    Options::new(Candidates {
        kernels: vec![Kernel::Eq1],
        per_angle_a: Some(false),
        per_angle_mu: Some(false),
        ..Candidates::proposed()
    })
}

/// Progress names every photograph and every candidate once. Each photograph is asked for once. The
/// planted values come back within four standard errors.
#[test]
fn photographs_from_memory_are_measured_once() {
    let (params, table) = planted();
    let (asked, steps) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let photographs = trial::source(&params, photograph::photograph);
    let source = |shot: &_| {
        asked.fetch_add(1, Ordering::Relaxed);
        photographs(shot)
    };
    let report = |step: Step| steps.lock().unwrap().push(step);
    let progress = Progress {
        report: Some(&report),
        cancel: None,
    };
    let given = trial::campaign(&params, &[]);
    let found = campaign(&given, &source, &table, &options(), &progress).unwrap();
    let captures = params.captures.len();
    assert_eq!(asked.into_inner(), captures + 1, "with the reference");
    let mut done: Vec<usize> = Vec::new();
    let mut candidates = Vec::new();
    for step in steps.into_inner().unwrap() {
        match step {
            Step::Photographs { done: n, of } => {
                assert_eq!(of, captures);
                done.push(n);
            }
            Step::Candidates { done: n, of: 2 } => candidates.push(n),
            Step::Chosen => candidates.push(3),
            other => panic!("{other:?}"),
        }
    }
    done.sort_unstable();
    assert_eq!(done, (1..=captures).collect::<Vec<_>>());
    assert_eq!(candidates, [1, 2, 3]);
    let mu = found.best.mu.as_ref().unwrap()[0];
    for (value, truth) in [
        (found.best.c_mm.unwrap(), 0.31),
        (found.best.spread[0], 3.4),
        (mu, 0.6),
    ] {
        assert!(
            (value.value - truth).abs() < 4.0 * value.standard_error,
            "{value:?}, truth {truth}"
        );
    }
}

#[test]
fn a_flag_ends_an_estimate_at_its_next_step() {
    let (params, table) = planted();
    let photographs = trial::source(&params, photograph::photograph);
    let given = trial::campaign(&params, &[]);
    for last in [Step::Candidates { done: 1, of: 2 }, Step::Chosen] {
        let cancel = AtomicBool::new(false);
        let told = Mutex::new(Vec::new());
        let report = |step: Step| {
            told.lock().unwrap().push(step);
            cancel.fetch_or(step == last, Ordering::Relaxed);
        };
        let progress = Progress {
            report: Some(&report),
            cancel: Some(&cancel),
        };
        let found = campaign(&given, &photographs, &table, &options(), &progress);
        assert!(matches!(found, Err(Error::Cancelled(_))));
        assert_eq!(told.lock().unwrap().last(), Some(&last));
    }
}

/// Options that exclude each other are refused before any photograph is asked for.
#[test]
fn options_that_exclude_each_other_are_refused() {
    let (params, table) = planted();
    let given = trial::campaign(&params, &[]);
    let none = |_: &_| panic!("no photograph is needed");
    let sampling = Sampling {
        samples: 4,
        seed: 1,
        sequence: Sequence::Sobol,
    };
    let refused =
        |options: &Options| match campaign(&given, &none, &table, options, &Progress::SILENT) {
            Err(Error::Conflict(conflict)) => conflict,
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("it is refused"),
        };
    let mut asked = options();
    asked.samples = Some(sampling);
    asked.loss = Some(Kind::Edge);
    assert_eq!(refused(&asked), Conflict::PixelsBySamples);
    asked.loss = None;
    asked.candidates.kernels = vec![Kernel::Wave];
    assert_eq!(refused(&asked), Conflict::NoSamples);
    asked.fit_azimuth = true;
    assert_eq!(refused(&asked), Conflict::AzimuthOfAnother);
}
