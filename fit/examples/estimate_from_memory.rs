//! Estimates a sheet from photographs in memory, prints its progress, and prints the result.
//!
//! Run it with `cargo run --example estimate_from_memory`. It reads the table and the demo
//! photographs from files, but no manifest. A program with a camera would put the camera's pictures
//! in the place of the demo photographs.

use std::collections::HashMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use fit::{
    Campaign, Candidates, Capture, Decode, LobeShape, Options, Photo, Progress, ResultFile, Setup,
    Shot, Step, TableResult, estimate_campaign, load_photo,
};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Names and floating distances (mm) of the photographs, all at normal incidence.
const CAPTURES: [(&str, f64); 2] = [
    ("aerial_150mm_00deg_tan.exr", 150.0),
    ("aerial_300mm_00deg_tan.exr", 300.0),
];

/// Name of the reference: the photograph of the source edge itself, without the sheet.
const SOURCE: &str = "source.exr";

fn campaign() -> Campaign {
    let capture = |(name, floating_distance_mm): (&str, f64)| Capture {
        // The exposure is six times that of the reference.
        shot: Shot::named(name, 6.0),
        floating_distance_mm,
        path_mm: None,
        incidence_deg: 0.0,
        azimuth_deg: Some(30.0),
        tangential_axis_deg: 0.0,
    };
    Campaign {
        file: "memory".into(),
        setup: Setup {
            pixel_pitch_mm: 0.05,
            seen_in_mirror: Some(true),
            half_mirror_transmittance: 0.5,
            half_mirror_reflectance: 0.5,
            spectrum: None,
            lamp: None,
            stray: Default::default(),
            polarisation: None,
        },
        references: vec![Shot::named(SOURCE, 1.0)],
        captures: CAPTURES.into_iter().map(capture).collect(),
        warnings: Vec::new(),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let folder = Path::new(ROOT).join("tests/captures/public_shared");
    let names = CAPTURES.iter().map(|(name, _)| *name).chain([SOURCE]);
    let photos: HashMap<PathBuf, Photo> = names
        .map(|name| {
            Ok((
                name.into(),
                load_photo(&folder.join(name), &Decode::default())?,
            ))
        })
        .collect::<Result<_, Box<dyn Error>>>()?;
    let table = tables::read(&Path::new(ROOT).join("tables/tests/kept/version_1_exact.h5"))?;

    // Another thread may set this flag. Then the estimate ends after its next step.
    let cancel = AtomicBool::new(false);
    let report = |step: Step| eprintln!("{step:?}");
    let progress = Progress {
        report: Some(&report),
        cancel: Some(&cancel),
    };
    // The map holds every photograph that the campaign names.
    let photo = |shot: &Shot| Ok(photos[&shot.image].clone());
    // The sheet of the demo was simulated with the separable lobe.
    let options = Options::new(Candidates {
        shapes: vec![LobeShape::Separable],
        ..Candidates::proposed()
    });
    let found = estimate_campaign(&campaign(), &photo, &table, &options, &progress)?;
    for warning in &found.warnings {
        eprintln!("warning: {warning}");
    }
    let table = TableResult::of(&table);
    let result = ResultFile::new(&found, table, start.elapsed().as_secs_f64());
    println!("{}", serde_json::to_string_pretty(&result)?);
    Ok(())
}
