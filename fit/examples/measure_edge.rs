//! Prints the MTF of the edge in a photograph.
//!
//! Run it with `cargo run --example measure_edge [PHOTOGRAPH]`.

use std::error::Error;
use std::path::PathBuf;

use fit::{Decode, Estimator, crossing, load_photo, measure_edge};

const CAMERA: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../tests/edges/camera_5deg.exr"
);

/// Number of frequencies, from 0 to the sampling frequency.
const COUNT: usize = 21;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os()
        .nth(1)
        .map_or(PathBuf::from(CAMERA), PathBuf::from);
    let photo = load_photo(&path, &Decode::default())?;
    let edge = measure_edge(&photo, None, &[])?;
    for warning in &edge.warnings {
        eprintln!("warning: {warning}");
    }
    let normal_deg = edge.line.normal_rad.to_degrees();
    println!("edge normal at {normal_deg:.3} deg from +x");
    // The transform reaches 4 cycles per pixel. Its first quarter ends at the sampling frequency.
    let estimator = Estimator::new(&edge.profile, 1.0, 4 * (COUNT - 1), COUNT);
    let mtf = estimator.measure(&edge.profile).modulus;
    println!("cycles/pixel    MTF");
    for (frequency, value) in estimator.frequencies_per_mm.iter().zip(&mtf) {
        println!("{frequency:12.3}{value:9.4}");
    }
    match crossing(&estimator.frequencies_per_mm, &mtf, 0.5) {
        Some(half) => println!("one half at {half:.3} cycles/pixel"),
        None => println!("nowhere one half"),
    }
    Ok(())
}
