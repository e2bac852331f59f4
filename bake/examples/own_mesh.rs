//! Bakes a mesh file by rays, and compares the table with other rays.
//!
//! The program shows its progress and stops after ten seconds.
//!
//! `cargo run --release -p bake --example own_mesh -- cell.obj`

use bake::{Error, Plan, Prepared, Progress, Request, retrace, trace};
use meshes::CellOptions;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tables::options::Method;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Some(file) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err("give a mesh: .obj, .gltf, .glb, .stl or .ply".into());
    };
    // Light comes from +z of the file. A lattice or a scale would be given in these options.
    let prepared = Prepared::new(meshes::load_cell(&file, &CellOptions::default())?);
    for warning in &prepared.cell().warnings {
        eprintln!("warning: {warning}");
    }
    let plan = Plan::new(&Request {
        incidence: "0,15,30,45".into(),
        method: Method::Rays,
        rays: Some(1 << 20),
        ..Request::default()
    })?;
    let (done, stop, start) = (AtomicU64::new(0), AtomicBool::new(false), Instant::now());
    let told = |rays| {
        let done = done.fetch_add(rays, Ordering::Relaxed) + rays;
        eprint!("\r{done} rays");
        stop.store(start.elapsed() > Duration::from_secs(10), Ordering::Relaxed);
    };
    let table = match trace(&prepared, &plan, Progress::new(&told).stopped_by(&stop)) {
        Err(Error::Stopped) => return Err("ten seconds were not enough".into()),
        table => table?,
    };
    eprintln!();
    for (incidence, eta) in table.axes.incidence_deg.iter().zip(&table.retroreflected) {
        println!("{incidence:4} deg  eta {eta:.4}");
    }
    let comparison = retrace(&table, &prepared, 1 << 18, 2, Progress::none())?;
    println!(
        "other rays {}",
        if comparison.agrees() {
            "agree"
        } else {
            "differ"
        }
    );
    Ok(())
}
