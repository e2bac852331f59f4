//! Tests of the azimuth that is estimated from the photographs alone, against planted azimuths.

use crate::planted::{Stream, camera, fitted, params, scene, table, truth};
use crate::simulate::PlantedSheet;
use crate::simulate::photograph::photograph;
use crate::study::trial;
use edges::names::Kernel;
use edges::names::LobeShape;
use estimator::estimate::campaign::campaign as estimated;
use estimator::estimate::{Azimuth, find, scatter};
use estimator::estimate::{Candidates, Choice, Kind, Options, Progress, Scene, UnverifiedInput};
use estimator::model::Further;
use nalgebra::DVector;
use tables::{Exact, Symmetry, Table};

/// The closed form of the pair at azimuths 0, 15 and 30 deg. By symmetry these give all azimuths.
pub(crate) fn all_azimuths(truth: &PlantedSheet, incidence_deg: &[f64]) -> Table {
    let azimuths = [0.0, 15.0, 30.0];
    let single = azimuths.map(|azimuth| table(truth, incidence_deg, azimuth));
    let directions = (0..incidence_deg.len()).flat_map(|i| (0..3).map(move |j| (i, j)));
    let paths = directions.map(|(i, j)| single[j].exact.as_ref().unwrap().paths[i].clone());
    let mut all = single[0].clone();
    all.exact = Some(Exact {
        // The area of two cubes with edge length 1.
        entrance_area: 3_f64.sqrt(),
        paths: paths.collect(),
    });
    let (n, three) = (incidence_deg.len(), 3);
    all.axes.azimuth_deg = azimuths.to_vec();
    all.retroreflected =
        ndarray::Array2::from_shape_fn((n, three), |(i, j)| single[j].retroreflected[[i, 0]]);
    all.histogram = ndarray::Array4::zeros((n, three, 4, 4));
    all.fate = ndarray::Array3::zeros((n, three, 10));
    all.standard_error = ndarray::Array2::zeros((n, three));
    all.rays = ndarray::Array2::zeros((n, three));
    all.provenance.symmetry = Symmetry {
        rotations: 6,
        mirror_deg: Some(0.0),
    };
    all
}

/// Checks the error of an azimuth, and what it adds to the other parameters, against whole fits at
/// azimuths beside it.
///
/// One error away, the sum of squares has risen by the misfit. The search of the error halves its
/// own error at least three times, from half a degree: a tenth is allowed. The added covariance is
/// that of one number with the slopes of the fits by the azimuth. They are measured over half of
/// the error here. What repeats itself after 60 degrees has a third derivative of 36 per rad^2
/// of the first, so for an error of 2 degrees the slopes differ by 36/6 x 0.035^2 x 3/4 = 0.5 %,
/// and their products by 1 %; a part of the sign that is even does not enter. 5 % are allowed.
fn holds_the_azimuth(scene: &Scene, table: &Table, found: &Azimuth, choice: Choice) {
    let error = found.deg.standard_error;
    let own = scene.azimuths_deg();
    let fit = |by: f64| {
        let turned: Vec<f64> = own.iter().map(|own| own + by).collect();
        fitted(&scene.turned(table, &turned).unwrap(), choice, Kind::Mtf)
    };
    let [low, middle, high] = [-error, 0.0, error].map(fit);
    let rise = 0.5 * (low.chi2 + high.chi2) - middle.chi2;
    let misfit = (middle.chi2 / middle.residuals as f64).max(1.0);
    println!("chi-square rises by {rise:.3}, misfit {misfit:.3}");
    assert!((rise / misfit - 1.0).abs() < 0.1, "{rise} {misfit}");
    let sides = [0.5, -0.5].map(|part| fit(part * error).coordinates());
    let [high, low] = sides.map(DVector::from_vec);
    let slope = high - low;
    let expected = &slope * slope.transpose();
    let added = scatter(scene, table, found, Kind::Mtf, choice).unwrap();
    // The rows are c, a and three mu, all as logarithms.
    assert_eq!((added.nrows(), slope.len()), (5, 5));
    println!("{slope:.2e}{added:.3e}{expected:.3e}");
    // Half of 5 %, and what the fits leave, which end at changes of 1e-10 of the sum of squares.
    let known = |i: usize| 0.025 * slope[i].abs() + 1e-7;
    for i in 0..5 {
        for j in 0..5 {
            let off = (added[(i, j)] - expected[(i, j)]).abs();
            let allowed = known(i) * slope[j].abs() + known(j) * slope[i].abs() + 1e-14;
            assert!(off < allowed, "{i} {j}: {added}{expected}");
        }
    }
}

/// The manifest states azimuth 0, but the sheet lies at another azimuth. The estimate finds the
/// difference within its error.
#[test]
fn a_planted_azimuth_comes_back() {
    let choice = Choice {
        kernel: Kernel::Eq1,
        shape: LobeShape::Radial,
        per_angle_a: false,
        per_angle_mu: true,
        further: Further::NONE,
    };
    let incidence = [0.0, 20.0, 40.0];
    let mut stream = Stream(11);
    let mut pulls = Vec::new();
    for seed in 0..6 {
        let planted = stream.between(0.0, 60.0);
        let truth = truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.31, 0.6);
        let table = all_azimuths(&truth, &incidence);
        let mut campaign = params(seed, truth, &incidence, &[150.0, 300.0], camera(2e5));
        for (k, shot) in campaign.captures.iter_mut().enumerate() {
            shot.azimuth_deg = planted;
            // Edges in several directions distinguish a sheet from its mirror image.
            shot.edge.normal_deg += [0.0, 55.0, 90.0][k % 3];
        }
        let scene = scene(&campaign, &table);
        let unknown = vec![0.0; scene.shots.len()];
        let scene = scene.turned(&table, &unknown).unwrap();
        assert!(scene.is_lit(), "light returns everywhere");
        let (found, scene) = find(&scene, &table, choice, &Progress::SILENT).unwrap();
        assert_eq!(found.period_deg, 60.0);
        let off = (found.deg.value - planted + 30.0).rem_euclid(60.0) - 30.0;
        let pull = off / found.deg.standard_error;
        println!(
            "azimuth {planted:.3}: found {:.3} +- {:.3}, pull {pull:+.2}, as likely: {:?}",
            found.deg.value, found.deg.standard_error, found.others_deg
        );
        assert!(found.deg.standard_error < 3.0, "the photographs tell it");
        assert!(pull.abs() < 4.0);
        pulls.push(pull);
        if seed < 2 {
            holds_the_azimuth(&scene, &table, &found, choice);
        }
    }
    let squares: f64 = pulls.iter().map(|pull| pull * pull).sum();
    println!(
        "{} campaigns, rms pull {:.2}",
        pulls.len(),
        (squares / 6.0).sqrt()
    );
    // Chi-square with 6 degrees of freedom lies outside 0.4 to 22.5 in 0.1 % on either side.
    assert!((0.4..22.5).contains(&squares), "{pulls:?}");
    assert_eq!(pulls.len(), 6);
}

/// An azimuth is found for one of two views. If the manifest does not say which, and the other one
/// differs at the azimuth that is found, a warning says so.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn an_azimuth_without_the_view_is_warned_of() {
    let incidence = [20.0, 40.0];
    let truth = truth(Kernel::Shift, LobeShape::Radial, 1.0, 0.31, 0.6);
    let table = all_azimuths(&truth, &incidence);
    for (planted, said, warned) in [
        (13.0, None, true),
        (13.0, Some(true), false),
        (13.0, Some(false), false),
    ] {
        let mut campaign = params(3, truth.clone(), &incidence, &[200.0; 3], camera(2e5));
        for (k, shot) in campaign.captures.iter_mut().enumerate() {
            shot.azimuth_deg = planted;
            shot.edge.normal_deg += [0.0, 55.0, 90.0][k % 3];
        }
        let mut stated = trial::campaign(&campaign, &[]);
        stated.setup.seen_in_mirror = said;
        stated
            .captures
            .iter_mut()
            .for_each(|shot| shot.azimuth_deg = None);
        let mut options = Options::new(Candidates {
            kernels: vec![Kernel::Shift],
            ..Candidates::proposed()
        });
        options.fit_azimuth = true;
        let photographs = trial::source(&campaign, photograph);
        let found = estimated(&stated, &photographs, &table, &options, &Progress::SILENT).unwrap();
        let count = found
            .warnings
            .iter()
            .filter(|w| w.contains("seen_in_mirror"))
            .count();
        assert_eq!(count, usize::from(warned), "{said:?}: {:?}", found.warnings);
        let trusts = |given| found.trusted.iter().any(|entry| entry.what == given);
        // An azimuth that is estimated is not taken on trust.
        assert!(!trusts(UnverifiedInput::AzimuthDeg) && trusts(UnverifiedInput::IncidenceDeg));
    }
}
