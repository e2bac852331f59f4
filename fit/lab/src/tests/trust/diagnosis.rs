//! Tests of the search for suspects: its limit of time, that it is the same each time, and causes
//! that are blamed on nothing else.

use std::time::Duration;

use edges::names::{Kernel, LobeShape};
use edges::numerics::Stream;
use edges::photographs::manifest::captures::Shot;
use edges::photographs::photo::plane::Photo;
use edges::photographs::{Campaign, manifest::captures};
use estimator::estimate::campaign::{campaign, undiagnosed};
use estimator::estimate::{Candidates, Estimated, Options, Progress, Verdict};
use tables::Table;

use crate::planted::{camera, params, table, truth};
use crate::simulate::Params;
use crate::simulate::photograph;
use crate::study::{campaign as manifest_of, source as source_of};

const INCIDENCE: [f64; 3] = [0.0, 20.0, 40.0];
const AZIMUTH: f64 = 20.0;

fn of(kernels: &[Kernel]) -> Options {
    Options::new(Candidates {
        kernels: kernels.to_vec(),
        ..Candidates::proposed()
    })
}

/// Returns a campaign of nine photographs of this kernel, and its table.
fn planted(kernel: Kernel, spread: f64) -> (Params, Table) {
    let sheet = truth(kernel, LobeShape::Radial, spread, 0.3, 0.5);
    let shots = params(
        81,
        sheet.clone(),
        &INCIDENCE,
        &[150.0, 220.0, 300.0],
        camera(4e4),
    );
    (shots, table(&sheet, &INCIDENCE, AZIMUTH))
}

fn found(shots: &Params, manifest: &Campaign, table: &Table, options: &Options) -> Estimated {
    let photographs = source_of(shots, photograph::saved);
    campaign(manifest, &photographs, table, options, &Progress::SILENT).expect("an estimate")
}

/// A campaign whose tangential axis is off by 90 degrees is poor, and has many suspects.
fn turned(shots: &Params) -> Campaign {
    let mut manifest = manifest_of(shots, &[]);
    for capture in &mut manifest.captures {
        capture.tangential_axis_deg = 90.0;
    }
    manifest
}

/// Without time nothing is tried, and the result says so. With time to its end the search is the
/// same for any number of threads, and the estimate does not depend on it.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn a_search_says_whether_it_came_to_its_end() {
    let (shots, table) = planted(Kernel::Eq1, 3.4);
    let manifest = turned(&shots);
    let eq1 = of(&[Kernel::Eq1]);
    let searched = |diagnose: Option<Duration>, threads: usize| {
        let options = Options {
            diagnose,
            ..eq1.clone()
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        pool.install(|| found(&shots, &manifest, &table, &options))
    };
    let whole = searched(None, 2);
    let (tried, of) = (whole.diagnosis.tried, whole.diagnosis.of);
    println!("{tried} of {of} tried: {:?}", whole.suspects);
    assert!(whole.diagnosis.complete && tried == of && of > 40);
    assert_eq!(
        whole.suspects[0].what,
        "the tangential axis is off by 90 deg"
    );
    assert_eq!(whole.suspects[0].verdict_if_so, Some(Verdict::Good));
    let alone = searched(Some(Duration::MAX), 1);
    assert_eq!(alone.suspects, whole.suspects);
    assert_eq!(alone.diagnosis, whole.diagnosis);
    for (time, least) in [(Duration::ZERO, 0), (Duration::from_nanos(1), 0)] {
        let cut = searched(Some(time), 2);
        assert!(!cut.diagnosis.complete, "{time:?}");
        assert_eq!((cut.diagnosis.tried, cut.suspects.len()), (least, 0));
        assert_eq!(cut.best.covariance, whole.best.covariance);
        let says_so = |said: &String| said.contains("--diagnose");
        assert!(cut.warnings.iter().any(says_so), "{:?}", cut.warnings);
        assert!(!whole.warnings.iter().any(says_so));
    }
}

/// An estimate before its diagnosis has all numbers of the one after it, and needs a diagnosis only
/// if its fit is not good.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn an_estimate_before_its_diagnosis_is_whole() {
    let (shots, table) = planted(Kernel::Eq1, 3.4);
    let options = of(&[Kernel::Eq1]);
    let photographs = source_of(&shots, photograph::saved);
    for (manifest, needed) in [(manifest_of(&shots, &[]), false), (turned(&shots), true)] {
        let before = undiagnosed(&manifest, &photographs, &table, &options, &Progress::SILENT);
        let before = before.expect("an estimate");
        let after = found(&shots, &manifest, &table, &options);
        assert_eq!(before.needs_diagnosis(&options), needed);
        assert_eq!(before.diagnosis.complete, !needed);
        assert_eq!(before.best.covariance, after.best.covariance);
        assert_eq!(before.trusted, after.trusted);
        assert_eq!(before.suspects, []);
        assert_eq!(after.suspects.is_empty(), !needed);
    }
}

/// A sheet whose light spreads as waves fits no kernel of rays. Without a wavelength the remedy is
/// named, and no mistake of the manifest is.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn waves_without_a_wavelength_are_named() {
    let (mut shots, table) = planted(Kernel::Wave, 1.0);
    shots.truth.c_mm = 0.2;
    let mut manifest = manifest_of(&shots, &[]);
    manifest.setup.spectrum = None;
    let found = found(
        &shots,
        &manifest,
        &table,
        &Options::new(Candidates::proposed()),
    );
    println!("{:?} {:?}", found.goodness, found.suspects);
    assert_ne!(found.goodness.verdict, Verdict::Good);
    let first = &found.suspects[0];
    assert!(first.what.contains("--wavelength-nm"), "{first:?}");
    // The planted wavelength is among those that are tried.
    assert!(first.what.contains("550 nm"), "{first:?}");
    assert_eq!(first.verdict_if_so, Some(Verdict::Good));
}

/// Distances from another plane than the sheet are off by one length. It is found to a few of its
/// standard errors, which the planted photographs make about a millimetre.
#[test]
#[ignore = "a minute: `make test-full` runs it"]
fn an_offset_of_all_distances_is_named() {
    let (shots, table) = planted(Kernel::Angular, 700.0);
    for offset_mm in [-60.0, 80.0] {
        let mut manifest = manifest_of(&shots, &[]);
        for capture in &mut manifest.captures {
            capture.floating_distance_mm -= offset_mm;
        }
        let found = found(&shots, &manifest, &table, &of(&[Kernel::Angular]));
        println!("{:?} {:?}", found.goodness, found.suspects);
        assert_ne!(found.goodness.verdict, Verdict::Good);
        let first = &found.suspects[0].what;
        let (_, rest) = first.split_once("are stated ").expect("an offset");
        let (millimetres, rest) = rest.split_once(" mm too ").expect("an offset");
        let millimetres: f64 = millimetres.parse().expect("a number");
        assert_eq!(rest.starts_with("short"), offset_mm > 0.0, "{first}");
        assert!((millimetres - offset_mm.abs()).abs() < 5.0, "{first}");
    }
}

/// Blurs a picture with a disc, as a lens out of focus does. Places beyond the border have the
/// light of the nearest pixel.
fn defocused(pixels: &[f64], [width, height]: [usize; 2], radius_px: f64) -> Vec<f64> {
    const PARTS: i32 = 16;
    let reach = radius_px.ceil() as i32 + 1;
    // Shares of the disc on the pixels around, by points on a fine grid.
    let share = |dx: i32, dy: i32| {
        let inside = |k: i32| {
            let at =
                |d: i32, part: i32| f64::from(d) + (f64::from(part) + 0.5) / f64::from(PARTS) - 0.5;
            at(dx, k % PARTS).hypot(at(dy, k / PARTS)) <= radius_px
        };
        (0..PARTS * PARTS).filter(|&k| inside(k)).count() as f64
    };
    let around = || (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| (dx, dy)));
    let shares: Vec<(i32, i32, f64)> = around()
        .map(|(dx, dy)| (dx, dy, share(dx, dy)))
        .filter(|&(.., share)| share > 0.0)
        .collect();
    let all: f64 = shares.iter().map(|&(.., share)| share).sum();
    let clamped = |at: usize, by: i32, size: usize| {
        (at as i64 + i64::from(by)).clamp(0, size as i64 - 1) as usize
    };
    let blurred = |at: usize| {
        let (x, y) = (at % width, at / width);
        let light = shares.iter().map(|&(dx, dy, share)| {
            share * pixels[clamped(y, dy, height) * width + clamped(x, dx, width)]
        });
        light.sum::<f64>() / all
    };
    (0..pixels.len()).map(blurred).collect()
}

/// A blur or a tone curve that the model lacks moves the light of all photographs. It is blamed on
/// the exposure of none. The control is an exposure that is wrong beside the tone curve of none.
#[test]
#[ignore = "a minute: `make test-full` runs it"]
fn an_effect_on_all_photographs_is_blamed_on_no_exposure() {
    let (shots, table) = planted(Kernel::Eq1, 3.4);
    let size = [shots.camera.width, shots.camera.height];
    type Effect = fn(&[f64], [usize; 2]) -> Vec<f64>;
    let effects: [(&str, Effect); 4] = [
        ("defocus of 1 px", |light, size| defocused(light, size, 1.0)),
        ("defocus of 2 px", |light, size| defocused(light, size, 2.0)),
        ("tone curve", |light, _| {
            light.iter().map(|v| v.powf(1.1)).collect()
        }),
        ("tile gaps", |light, [width, _]| {
            let dark = |i: usize| if i % width % 40 == 7 { 0.7 } else { 1.0 };
            light.iter().enumerate().map(|(i, v)| v * dark(i)).collect()
        }),
    ];
    let is_blamed = |found: &Estimated| {
        let suspects = found.suspects.iter();
        suspects.filter(|own| own.what.contains("exposure")).count()
    };
    let mut poor = 0;
    for (name, effect) in effects {
        let photographs = |shot: &Shot| -> Result<Photo, captures::Error> {
            let index: Option<usize> = shot.image.to_str().and_then(|name| name.parse().ok());
            let light = photograph::light(&shots, index).expect("it is planted");
            let light = match index {
                Some(_) => effect(&light, size),
                None if name == "tone curve" => effect(&light, size),
                None => light,
            };
            let mut noise = Stream(500 + index.map_or(0, |index| index as u64 + 1));
            let full_well_e = shots.camera.full_well_e;
            let exposed = light.iter().map(|v| {
                let deviation = (v.max(0.0) / full_well_e + (3.0 / full_well_e).powi(2)).sqrt();
                (v + deviation * noise.normal()) as f32
            });
            Ok(Photo {
                width: size[0],
                height: size[1],
                luminance: exposed.collect(),
                clip_level: Some(1.0),
                clips_alone: true,
                transfer: edges::photographs::photo::taken::Taken::default(),
                warnings: Vec::new(),
            })
        };
        let manifest = manifest_of(&shots, &[]);
        let options = of(&[Kernel::Eq1, Kernel::Angular]);
        let found = campaign(&manifest, &photographs, &table, &options, &Progress::SILENT);
        let found = match found {
            Ok(found) => found,
            Err(refused) => {
                println!("{name}: refused: {refused}");
                continue;
            }
        };
        let verdict = found.goodness.verdict;
        println!(
            "{name}: {verdict:?} light {:?} scale {} {:?}",
            found.goodness.chances, found.goodness.scale, found.suspects
        );
        poor += usize::from(verdict != Verdict::Good);
        assert_eq!(is_blamed(&found), 0, "{name}");
        let said = |text: &str| found.warnings.iter().any(|own| own.contains(text));
        let mends = found.suspects.iter().any(|own| own.leaves_noise());
        assert_eq!(said("It would fit if"), mends, "{name}");
    }
    assert!(poor >= 2, "{poor} effects are seen");
    let mut manifest = manifest_of(&shots, &[]);
    manifest.captures[4].shot.exposure *= 1.2;
    let found = found(&shots, &manifest, &table, &of(&[Kernel::Eq1]));
    assert_eq!(is_blamed(&found), 1, "{:?}", found.suspects);
}
