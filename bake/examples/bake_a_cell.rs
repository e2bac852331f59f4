//! Designs a cell, bakes it and prints the share of the light that it retroreflects at each angle.
//!
//! `cargo run --release -p bake --example bake_a_cell`

use bake::{Plan, Prepared, Progress, Request, trace};
use meshes::CellOptions;
use meshes::design::{Design, Shape};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    // A pair of cubes, each with one dihedral angle 0.1 mrad too wide.
    let design = Design {
        dihedral_error_rad: [1e-4, 0.0, 0.0],
        ..Design::new(Shape::TriangularPair)
    };
    let cell = meshes::normalise(
        &design.mesh()?,
        "pair.obj".as_ref(),
        &CellOptions::default(),
    )?;
    let prepared = Prepared::new(cell);
    let plan = Plan::new(&Request {
        incidence: "0:60:10".into(),
        azimuth: "0".into(),
        refractive_index: Some(1.49),
        ..Request::default()
    })?;
    for warning in plan.warnings(&prepared) {
        eprintln!("warning: {warning}");
    }
    let table = trace(&prepared, &plan, Progress::none())?;
    println!("incidence  retroreflected");
    for (incidence, eta) in table.axes.incidence_deg.iter().zip(&table.retroreflected) {
        println!("{incidence:6} deg  {eta:.4}");
    }
    let exact = table
        .exact
        .as_ref()
        .ok_or("a cell of planes is baked exactly")?;
    println!(
        "light leaves up to {:.3} mrad from straight back",
        1e3 * exact.largest_deviation_rad()
    );
    tables::write(&table, &std::env::temp_dir().join("pair.h5"))?;
    Ok(())
}
