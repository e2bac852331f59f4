//! Tests of what is taken on trust: effects against whole estimates with other inputs.

use std::sync::Arc;

use crate::planted::{camera, fitted, params, table, truth};
use crate::simulate::photograph::photograph;
use crate::simulate::{Params, PlantedSheet};
use crate::study::trial;
use crate::tests::estimates::azimuth::all_azimuths;
use edges::names::{Kernel, LobeShape, ParameterKind, Spectrum};
use edges::photographs::Campaign;
use estimator::estimate::campaign::campaign as estimated;
use estimator::estimate::{
    Candidates, Doubted, Effect, Estimate, Estimated, Options, UnverifiedInput,
};
use estimator::estimate::{OtherTable, Progress, Unverified, unverified_in_words};
use tables::Table;

/// Incidences of the photographs, between directions of the table.
const INCIDENCE: [f64; 3] = [8.0, 20.0, 31.0];
const HELD: [f64; 8] = [7.0, 8.0, 9.0, 19.0, 20.0, 21.0, 30.0, 31.0];

fn sheet(kernel: Kernel) -> PlantedSheet {
    let a = if kernel == Kernel::Angular {
        700.0
    } else {
        3.4
    };
    PlantedSheet {
        spectrum: Spectrum::parse("550").ok(),
        ..truth(kernel, LobeShape::Radial, a, 0.31, 0.6)
    }
}

/// Six photographs of a sheet, with edges in several directions.
fn planted(kernel: Kernel) -> Params {
    let distances = [180.0, 260.0];
    let mut planted = params(5, sheet(kernel), &INCIDENCE, &distances, camera(4e5));
    let normals = [5.0, 38.0, -61.0, 84.0, 7.0, -35.0];
    for (shot, normal_deg) in planted.captures.iter_mut().zip(normals) {
        shot.edge.normal_deg = normal_deg;
    }
    planted
}

/// Estimates a sheet by one kernel, from photographs and a manifest that may say otherwise.
fn found(planted: &Params, manifest: &Campaign, table: &Table) -> Estimated {
    let options = Options::new(Candidates {
        kernels: vec![planted.truth.kernel],
        per_angle_a: Some(false),
        per_angle_mu: Some(false),
        ..Candidates::proposed()
    });
    let photographs = trial::source(planted, photograph);
    estimated(manifest, &photographs, table, &options, &Progress::SILENT).unwrap()
}

/// Returns c, the spread and mu, each as value and relative standard error; `None` where the kernel
/// has none.
fn numbers(best: &Estimate) -> [Option<[f64; 2]>; 3] {
    let mu = best.mu.as_ref().and_then(|mu| mu.first());
    [best.c_mm.as_ref(), best.spread.first(), mu]
        .map(|value| value.map(|v| [v.value, v.standard_error / v.value]))
}

fn parts(effect: &Effect) -> [Option<f64>; 3] {
    [effect.c_mm, effect.a_per_mm, effect.mu]
}

/// Returns whether no manifest states an input.
fn is_unstated(given: UnverifiedInput) -> bool {
    use UnverifiedInput::{Cell, DihedralAngles, Lens, Linearity};
    matches!(given, Lens | DihedralAngles | Linearity | Cell)
}

/// Changes a manifest, or the sheet of a table, by the step of an entry.
fn changed(given: UnverifiedInput, by: f64, manifest: &mut Campaign, sheet: &mut PlantedSheet) {
    let captures = &mut manifest.captures;
    match given {
        UnverifiedInput::PixelPitchMm => manifest.setup.pixel_pitch_mm *= 1.01,
        UnverifiedInput::FloatingDistanceMm => {
            captures
                .iter_mut()
                .for_each(|shot| shot.floating_distance_mm *= 1.01);
        }
        UnverifiedInput::HalfMirror => manifest.setup.half_mirror_reflectance *= 1.01,
        UnverifiedInput::ReferenceExposure => manifest.references[0].exposure *= 1.01,
        UnverifiedInput::Exposure => captures
            .iter_mut()
            .for_each(|shot| shot.shot.exposure *= 1.01),
        UnverifiedInput::WavelengthNm => manifest.setup.spectrum = Spectrum::parse("555.5").ok(),
        UnverifiedInput::RefractiveIndex => sheet.refractive_index *= 1.01,
        UnverifiedInput::IncidenceDeg => captures
            .iter_mut()
            .for_each(|shot| shot.incidence_deg += by),
        UnverifiedInput::AzimuthDeg => {
            captures
                .iter_mut()
                .for_each(|shot| *shot.azimuth_deg.as_mut().unwrap() += by);
        }
        UnverifiedInput::TangentialAxisDeg => {
            captures
                .iter_mut()
                .for_each(|shot| shot.tangential_axis_deg += by);
        }
        UnverifiedInput::Lens | UnverifiedInput::DihedralAngles | UnverifiedInput::Linearity => {
            unreachable!("no manifest states it")
        }
        UnverifiedInput::Cell => sheet.pair = !sheet.pair,
    }
}

/// Each effect is the difference of two whole estimates, from the photographs on. Both find the
/// noise of the pixels anew, each at its own rough fit, which changes the weights of the pixels by
/// some percent of a percent: a tenth of a standard error is allowed. An effect is one step of
/// Gauss and Newton. It is at most 3 %, and the parameters are logarithms, so the step errs by
/// about 3 % of the effect: 5 % are allowed. A plateau changes with the blur by a tenth of it, so
/// mu may err by a tenth of what c does. The scales change c, a and mu by powers of 1.01.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn effects_are_those_of_estimates_with_other_inputs() {
    let (mut cases, mut others, mut worst) = (0, 0, 0.0_f64);
    for kernel in [Kernel::Eq1, Kernel::Angular, Kernel::Shift, Kernel::Wave] {
        let planted = planted(kernel);
        let stated = trial::campaign(&planted, &[]);
        let own_table = all_azimuths(&sheet(kernel), &HELD);
        let own = found(&planted, &stated, &own_table);
        let hidden: Vec<_> = own.bounds.keys().map(|id| id.kind).collect();
        assert_eq!(hidden, [ParameterKind::AngularSpread], "{kernel:?}");
        let mut seen: Vec<UnverifiedInput> = Vec::new();
        for entry in own.trusted.iter().filter(|entry| !is_unstated(entry.what)) {
            // The table ends at 31 degrees.
            let (by, step) = match entry.what {
                UnverifiedInput::IncidenceDeg => (-1.0, "-1 deg"),
                UnverifiedInput::AzimuthDeg | UnverifiedInput::TangentialAxisDeg => (1.0, "1 deg"),
                _ => (1.0, "1 %"),
            };
            assert_eq!(entry.step, step, "{:?}", entry.what);
            let (mut manifest, mut sheet) = (stated.clone(), sheet(kernel));
            changed(entry.what, by, &mut manifest, &mut sheet);
            let other = found(&planted, &manifest, &all_azimuths(&sheet, &HELD));
            let pairs = numbers(&own.best).into_iter().zip(numbers(&other.best));
            let effects = parts(&entry.effect);
            let largest = effects
                .iter()
                .flatten()
                .fold(0.0_f64, |most, e| most.max(e.abs()));
            seen.push(entry.what);
            // Effects are those of the chosen candidate. Another incidence may be taken for a blur.
            let further = other.best.choice.further;
            if further != own.best.choice.further {
                println!("{kernel:?} {}: {further:?}", entry.what.name());
                others += effects.iter().flatten().count();
                continue;
            }
            for ((own, other), effect) in pairs.zip(effects) {
                let Some([value, error]) = own else {
                    assert_eq!(effect, None);
                    continue;
                };
                let (effect, expected) = (effect.unwrap(), other.unwrap()[0] / value - 1.0);
                let off = (effect - expected).abs();
                let allowed = 0.1 * error + 0.05 * expected.abs() + 0.005 * largest;
                worst = worst.max(off / allowed);
                println!(
                    "{kernel:?} {}: {effect:+.5} {expected:+.5}, standard error {error:.5}",
                    entry.what.name()
                );
                cases += 1;
            }
        }
        let index = seen
            .iter()
            .position(|&given| given == UnverifiedInput::RefractiveIndex);
        assert_eq!(index, Some(seen.len() - 4), "{seen:?}");
        let pitch = parts(&own.trusted[0].effect);
        let expected = match kernel {
            Kernel::Eq1 | Kernel::Angular => [Some(0.01), Some(1.0 / 1.01 - 1.0), Some(0.0)],
            Kernel::Shift => [Some(0.01), None, Some(0.0)],
            // The lag of the waves falls, so that they need another c.
            _ => pitch,
        };
        for (found, expected) in pitch.into_iter().zip(expected) {
            let off = found.zip(expected).map_or(0.0, |(a, b)| (a - b).abs());
            assert!(
                found.is_some() == expected.is_some() && off < 1e-14,
                "{pitch:?}"
            );
        }
    }
    println!("{cases} effects, the worst at {worst:.2} of what is allowed");
    // Shift has two parameters, wave has two and one number more, the others have three.
    assert_eq!(cases + others, 9 * (3 + 3 + 2) + 10 * 2);
    // Other inputs that look like a blur are a few.
    assert!(
        4 * others < cases,
        "{others} effects were not compared, {cases} were"
    );
    assert!(worst < 1.0, "{worst}");
}

/// The effect of a cell is known if its table is given, and is then that of an estimate with it.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn another_table_shows_what_the_cell_does() {
    let planted = planted(Kernel::Shift);
    let stated = trial::campaign(&planted, &[]);
    let own_table = all_azimuths(&sheet(Kernel::Shift), &HELD);
    let own = found(&planted, &stated, &own_table);
    let unknown = own.trusted.last().unwrap();
    assert_eq!(
        (unknown.what, unknown.effect),
        (UnverifiedInput::Cell, Effect::default())
    );
    let single = PlantedSheet {
        pair: false,
        ..sheet(Kernel::Shift)
    };
    // Single triangles have a third of the symmetry, so all azimuths that are needed are held.
    let other = OtherTable {
        name: "single.h5".into(),
        table: Arc::new(table(&single, &HELD, 20.0)),
    };
    let doubted = Doubted {
        scene: &own.scene,
        campaign: &own.campaign,
        table: &own_table,
        others: std::slice::from_ref(&other),
        loss: &own.loss(),
        best: &own.best,
        bounds: &own.bounds,
        azimuth_found: false,
        is_far: false,
    };
    let trusted = doubted.unverified();
    let entry = trusted.last().unwrap();
    assert_eq!(
        (entry.what, &*entry.step),
        (UnverifiedInput::Cell, "table single.h5")
    );
    // The same candidate: a search would explain the other cell by dihedral errors.
    let expected = found(&planted, &stated, &other.table);
    let expected = fitted(
        &expected.scene,
        own.best.choice,
        estimator::estimate::Kind::Edge,
    );
    let pairs = numbers(&own.best).into_iter().zip(numbers(&expected));
    let largest = entry.effect.c_mm.unwrap().abs();
    let mut cases = 0;
    for ((own, other), effect) in pairs.zip(parts(&entry.effect)) {
        let Some(([value, error], [expected, _])) = own.zip(other) else {
            continue;
        };
        let (effect, expected) = (effect.unwrap(), expected / value - 1.0);
        println!("{effect:+.5} {expected:+.5}");
        // Where nothing fits, the light that is found beside it depends on where the fit starts.
        assert!((effect - expected).abs() < error + 0.25 * expected.abs() + 0.1 * largest);
        cases += 1;
    }
    assert_eq!(cases, 2);
}

/// A camera whose values v fall short of the light e, v = e (1 - 0.01 e / E), gives a mu that is too
/// small by the effect of its linearity. E is the brightest plateau, that of the reference, 0.9 here.
/// The effect is that of the plain mean of the photographs. The estimate weighs them by their noise,
/// and their plateaus are 0.27 to 0.36, so their own effects lie within 0.0006 of it. Second orders of
/// the curve are 0.02 of the effect, and the blur, which it changes by 0.1 %, moves a plateau by a tenth
/// of that.
#[test]
fn a_curved_response_moves_mu_by_what_is_stated() {
    let planted = planted(Kernel::Eq1);
    let table = all_azimuths(&sheet(Kernel::Eq1), &INCIDENCE);
    let stated = trial::campaign(&planted, &[]);
    let own = found(&planted, &stated, &table);
    let curved = |params: &Params, index| {
        let light = photograph(params, index)?;
        Ok(light
            .into_iter()
            .map(|e| e * (1.0 - 0.01 * e / 0.9))
            .collect())
    };
    let photographs = trial::source(&planted, curved);
    let options = Options::new(Candidates {
        kernels: vec![Kernel::Eq1],
        per_angle_a: Some(false),
        per_angle_mu: Some(false),
        ..Candidates::proposed()
    });
    let other = estimated(&stated, &photographs, &table, &options, &Progress::SILENT).unwrap();
    let mu = |found: &Estimated| numbers(&found.best)[2].unwrap();
    let ([value, error], [bent, _]) = (mu(&own), mu(&other));
    let mut trusted = own.trusted.iter();
    let entry = trusted.find(|entry| entry.what == UnverifiedInput::Linearity);
    let effect = entry.unwrap().effect;
    assert_eq!([effect.c_mm, effect.a_per_mm], [None, None]);
    let (effect, expected) = (effect.mu.unwrap(), value / bent - 1.0);
    println!("{effect:+.5} {expected:+.5}, standard error {error:.5}");
    assert!(expected.abs() > 10.0 * error);
    assert!((effect - expected).abs() < error + 0.0006 + 0.03 * expected.abs());
}

/// Effects that a table cannot tell are null: it lacks neighbouring directions, or no reference
/// gives mu. Values that differ are null too. The lack of a reference is warned of.
#[test]
fn unknown_effects_are_null() {
    let mut planted = planted(Kernel::Shift);
    planted.reference = None;
    planted.captures[1].azimuth_deg = 20.0;
    let stated = trial::campaign(&planted, &[]);
    let table = table(&sheet(Kernel::Shift), &INCIDENCE, 20.0);
    let found = found(&planted, &stated, &table);
    let lines: Vec<String> = found
        .trusted
        .iter()
        .map(|entry| {
            let known = parts(&entry.effect).map(|part| if part.is_some() { '+' } else { '0' });
            let known: String = known.iter().collect();
            // The step of the angles depends on what the photographs tell.
            let of_angles = entry.step.strip_suffix(" mrad in all cubes");
            let step = match of_angles.and_then(|step| step.parse::<f64>().ok()) {
                Some(step) if step > 0.0 && step <= 0.02 => "told",
                _ => &entry.step,
            };
            format!("{} {:?} {step} {known}", entry.what.name(), entry.value)
        })
        .collect();
    assert_eq!(
        lines,
        [
            "pixel_pitch_mm Some(0.08) 1 % +00",
            "floating_distance_mm None 1 % +00",
            "half_mirror Some(0.25) 1 % +00",
            "refractive_index Some(1.49) 1 % 000",
            "incidence_deg None 1 deg 000",
            "azimuth_deg Some(20.0) 1 deg 000",
            "tangential_axis_deg Some(0.0) 1 deg +00",
            "dihedral_angles None told +00",
            "cell None another cell 000",
        ]
    );
    let without = found
        .warnings
        .iter()
        .any(|said| said.contains("no [reference]"));
    assert!(without, "{:?}", found.warnings);
}

/// A pitch of half its value fits as well as the true one: nothing else in the estimate can tell.
/// What is taken on trust says so, with the pitch first among the effects on c and a.
#[test]
fn a_halved_pitch_is_seen_by_nothing_but_trust() {
    let planted = planted(Kernel::Eq1);
    let table = all_azimuths(&sheet(Kernel::Eq1), &INCIDENCE);
    let stated = trial::campaign(&planted, &[]);
    let mut halved = stated.clone();
    halved.setup.pixel_pitch_mm *= 0.5;
    let [own, half] = [stated, halved].map(|manifest| found(&planted, &manifest, &table));
    // The fits end where the sum of squares changes by 1e-10.
    let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-8;
    assert!(same(own.best.chi2, half.best.chi2));
    assert_eq!(own.warnings, half.warnings);
    let [own, half] = [&own, &half].map(|found| (numbers(&found.best), &found.trusted));
    let ratio = |k: usize| half.0[k].unwrap()[0] / own.0[k].unwrap()[0];
    // The optimum is flat: its place is good to the root of that, times a standard error.
    assert!((ratio(0) - 0.5).abs() < 1e-5 && (ratio(1) - 2.0).abs() < 1e-4);
    assert!((ratio(2) - 1.0).abs() < 1e-5);
    for trusted in [own.1, half.1] {
        let pitch = &trusted[0];
        assert_eq!(pitch.what, UnverifiedInput::PixelPitchMm);
        assert!((pitch.effect.c_mm.unwrap() - 0.01).abs() < 1e-14);
        let said = unverified_in_words(trusted).unwrap();
        println!("{said}");
        assert!(
            said.starts_with("taken on trust, largest effects: c "),
            "{said}"
        );
    }
}

#[test]
fn entries_have_the_keys_of_the_contract() {
    let entry = Unverified {
        what: UnverifiedInput::PixelPitchMm,
        value: Some(0.05),
        step: "1 %".into(),
        effect: Effect {
            c_mm: Some(0.01),
            a_per_mm: None,
            mu: Some(-0.25),
        },
    };
    let text = serde_json::to_string(&entry).unwrap();
    assert_eq!(
        text,
        "{\"what\":\"pixel_pitch_mm\",\"value\":0.05,\"step\":\"1 %\",\
         \"effect\":{\"c_mm\":0.01,\"a_per_mm\":null,\"mu\":-0.25}}"
    );
    let read: Unverified = serde_json::from_str(&text).unwrap();
    assert_eq!(read, entry);
    assert_eq!(
        unverified_in_words(&[entry]).as_deref(),
        Some(
            "taken on trust, largest effects: c +1.00 % by 1 % of pixel_pitch_mm; mu -25.00 % by \
             1 % of pixel_pitch_mm"
        )
    );
    assert_eq!(unverified_in_words(&[]), None);
    // The names in files are those of the program.
    let all = [
        UnverifiedInput::FloatingDistanceMm,
        UnverifiedInput::HalfMirror,
        UnverifiedInput::ReferenceExposure,
        UnverifiedInput::WavelengthNm,
        UnverifiedInput::RefractiveIndex,
        UnverifiedInput::IncidenceDeg,
        UnverifiedInput::AzimuthDeg,
        UnverifiedInput::TangentialAxisDeg,
        UnverifiedInput::Lens,
        UnverifiedInput::DihedralAngles,
        UnverifiedInput::Linearity,
        UnverifiedInput::Cell,
    ];
    for given in all {
        let name = serde_json::to_string(&given).unwrap();
        assert_eq!(name, format!("\"{}\"", given.name()));
    }
}
