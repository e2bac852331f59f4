//! Tests of the study of drawn campaigns, in a short version. BENCHMARKS.md records the long one.

use std::path::Path;

use crate::planted::{camera, params, scene, table, truth};
use crate::study::Ranges;
use crate::study::Trial;
use crate::study::photographs;
use crate::study::refused;
use crate::study::trial;
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::names::ParameterKind;
use estimator::Error;
use estimator::estimate::Candidates;
use estimator::estimate::Kind;
use rayon::prelude::*;

/// Draws campaigns and runs them over the closed form of the pair at three angles.
pub(crate) fn run(ranges: &Ranges, seed: u64, campaigns: u64) -> Vec<Result<Trial, Error>> {
    let incidence = [0.0, 15.0, 30.0];
    let table = table(
        &truth(Kernel::Eq1, LobeShape::Radial, 3.0, 0.3, 0.5),
        &incidence,
        20.0,
    );
    let directions = ranges.directions(&table);
    assert_eq!(directions.len(), 3);
    (0..campaigns)
        .into_par_iter()
        .map(|index| {
            let params = ranges.campaign(seed, index, &directions);
            trial::run(&params, index, &table)
        })
        .collect()
}

pub(crate) fn trials(seed: u64, campaigns: u64) -> Vec<Trial> {
    // Small campaigns make the study short.
    let ranges = Ranges {
        photographs: [2.0, 6.0],
        ..Ranges::default()
    };
    let all = run(&ranges, seed, campaigns).into_iter();
    all.map(|trial| trial.expect("the edges are visible"))
        .collect()
}

/// Refusals are counted by their reason. A camera whose black level is 0 and that sees almost no
/// light is cut off at 0. A blur of several windows is no edge.
#[test]
fn refusals_are_counted_by_their_reason() {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.0, 0.3, 0.5);
    let table = table(&planted, &[0.0, 15.0, 30.0], 20.0);
    let run = |ranges: &Ranges| {
        let directions = ranges.directions(&table);
        refused::part((0..3).map(|index| {
            let params = ranges.campaign(1, index, &directions);
            trial::run(&params, index, &table)
        }))
    };
    let small = Ranges {
        photographs: [2.0, 2.0],
        ..Ranges::default()
    };
    let (trials, refused) = run(&small);
    assert_eq!(
        (trials.len(), refused::line(&refused).as_str()),
        (3, "0 refused")
    );
    let wide = Ranges {
        a_per_mm: [0.1, 0.1],
        ..small
    };
    let (trials, refused) = run(&wide);
    println!("{}", refused::line(&refused));
    assert_eq!((trials.len(), refused::total(&refused)), (0, 3));
    assert!(
        refused
            .iter()
            .all(|of| of.reason == "blur wider than the window"),
        "{refused:?}"
    );
}

/// Uneven light below the limit of correction is a nuisance parameter of the pixels. They keep mu,
/// the MTFs do not. Over 12 campaigns the mean square of a normal pull scatters by sqrt(2/12) =
/// 0.41 about 1; the limits are 4 of these.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn uneven_light_is_drawn_and_the_pixels_mu_holds() {
    let ranges = Ranges {
        photographs: [4.0, 4.0],
        electrons: [2e4, 2e4],
        light: Some([0.01, 0.02]),
        ..Ranges::default()
    };
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.0, 0.3, 0.5);
    let table = table(&planted, &[0.0, 15.0, 30.0], 20.0);
    let directions = ranges.directions(&table);
    let pulls: Vec<[f64; 2]> = (0..12)
        .into_par_iter()
        .map(|index| {
            let params = ranges.campaign(11, index, &directions);
            assert!(
                params
                    .captures
                    .iter()
                    .all(|shot| shot.edge.light_to_right != 0.0)
            );
            let trial = trial::run(&params, index, &table).expect("the edges are visible");
            trial
                .found
                .map(|found| (found[2][0] - trial.truth[2]) / trial.bound[2])
        })
        .collect();
    let square = |loss: usize| pulls.iter().map(|p| p[loss].powi(2)).sum::<f64>() / 12.0;
    let (mtf, edge) = (square(0), square(1));
    println!("mean squared error of mu over the bound squared: mtf {mtf:.2}, edge {edge:.2}");
    assert!(edge < 1.0 + 4.0 * 0.41, "edge {edge}");
    assert!(mtf > edge, "mtf {mtf}");
}

/// A campaign is a function of (seed, index). The threads and the other draws have no effect on it.
#[test]
fn draws_are_reproducible() {
    let some = trials(3, 3);
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread")
        .install(|| trials(3, 2));
    for (a, b) in some.iter().zip(&one) {
        assert_eq!(
            serde_json::to_string(a).expect("numbers"),
            serde_json::to_string(b).expect("numbers")
        );
    }
    assert_eq!((some.len(), one.len()), (3, 2));
    assert_ne!(some[0].truth, some[1].truth);
}

/// The standard error of the edge loss is the bound if nothing was cut off. The MTFs leave out
/// phases and tails, so their errors of c and a are not smaller.
#[test]
fn a_study_of_photographs_names_every_parameter_and_fit() {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.0, 0.35, 0.5);
    let incidence = [5.0, 30.0];
    let table = table(&planted, &incidence, 20.0);
    let scene = scene(
        &params(3, planted, &incidence, &[150.0, 300.0], camera(2e4)),
        &table,
    );
    let open = Candidates {
        kernels: vec![Kernel::Eq1, Kernel::Lobe],
        shapes: vec![LobeShape::Radial],
        spare_shapes: Vec::new(),
        per_angle_a: Some(true),
        per_angle_mu: Some(false),
    };
    let study = photographs(&scene, 0.0, &open).expect("candidates are open");
    let names: Vec<String> = study
        .parameters
        .iter()
        .map(|p| p.name.to_string())
        .collect();
    assert_eq!(names, ["c_mm", "a_per_mm_at_5", "a_per_mm_at_30", "mu"]);
    for p in &study.parameters {
        // Chi-square per degree of freedom may lie above 1 by chance, by sqrt(2 / 10^4) = 1.4 %;
        // standard errors are then larger.
        let ratio = p.edge / p.bound;
        assert!((0.999..1.035).contains(&ratio), "{}: {ratio}", p.name);
        assert!(
            p.name == ParameterKind::Mu.shared() || p.mtf > p.bound,
            "{p:?}"
        );
    }
    let fits: Vec<(Kernel, Kind)> = study.fits.iter().map(|f| (f.kernel, f.loss)).collect();
    let all = [
        (Kernel::Eq1, Kind::Mtf),
        (Kernel::Eq1, Kind::Edge),
        (Kernel::Lobe, Kind::Mtf),
        (Kernel::Lobe, Kind::Edge),
    ];
    assert_eq!(fits, all);
    assert!(study.fits[3].reduced_chi2 > study.fits[1].reduced_chi2);
}

/// The documented file states what is drawn without a file. A range that runs backwards is refused
/// with its line.
#[test]
fn ranges_are_read() {
    let documented = Path::new(env!("CARGO_MANIFEST_DIR")).join("../doc/ranges.toml");
    assert_eq!(
        Ranges::load(&documented).expect("it is valid"),
        Ranges::default()
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (text, said) in [
        (
            "ior = 1.5\nc_mm = { from = 0.5, to = 0.05 }\n",
            ":2: `c_mm` goes from 0.5 to 0.05",
        ),
        ("mu = { from = 0.2 }\n", ":1: `to` is missing"),
        (
            "mu = [0.2, 0.4]\n",
            ":1: `mu` must be a table, not an array",
        ),
        ("camera = [192, 128]\n", ":1: `camera` must be a table"),
        (
            "pair = true\nior = 1.5\nrefractive_index = 1.5\n",
            ":3: `refractive_index` is given twice",
        ),
        ("electron = { from = 1, to = 2 }\n", "electrons"),
        ("photographs = { from = 0, to = 3 }\n", "between 1 and 1000"),
        ("kernels = [\"eq2\"]\n", "use one of eq1"),
        ("kernels = []\n", "an array of one or more strings"),
        ("kernels = [\"wave\"]\n", "wavelength_nm"),
    ] {
        let file = folder.path().join("ranges.toml");
        std::fs::write(&file, text).expect("the folder takes files");
        let error = Ranges::load(&file).expect_err(text).to_string();
        assert!(error.contains(said), "{error}");
    }
}
