//! `bake optimise`: reads a goal, searches the best cell, and writes its mesh.

use crate::cli::calls::Caller;
use crate::cli::design;
use crate::cli::display::ProgressDisplay;
use crate::error::Error;
use crate::optimise::{Answer, Best as Wanted, Goal, optimise, report};
use crate::plan::heading;
use crate::run::Progress;
use clap::Args;
use meshes::Mesh;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;
use tables::Outputs;
use tables::cli::{in_a_line, print, reserve_plot, warn};

/// Options of `bake optimise`.
#[derive(Debug, Args)]
pub(crate) struct OptimiseArgs {
    /// What is wanted and what may vary, as TOML
    #[arg(value_name = "GOAL.toml")]
    goal: PathBuf,
    /// Mesh of the best cell: .obj (exact digits) or .glb, in mm
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Picture of the front, .svg; needs best = "both"
    #[arg(long, value_name = "FILE.svg", help_heading = heading::OUTPUT)]
    plot: Option<PathBuf>,
    /// Prints everything as one JSON object
    #[arg(long, help_heading = heading::OUTPUT)]
    json: bool,
}

/// Best cell of a goal for another program.
pub struct Best {
    /// Mesh of the cell, mm.
    pub mesh: Mesh,
    /// Everything, as JSON.
    pub json: String,
    /// Picture of the front as SVG; `None` unless the goal is of both sharpness and light.
    pub front: Option<String>,
    /// Warnings, one sentence each.
    pub warnings: Vec<String>,
}

/// Searches the best cell for another program. Nothing is printed or written.
///
/// # Errors
/// Fails as [`run`] does, and if the caller stopped it.
pub(super) fn called(args: &OptimiseArgs, caller: &Caller) -> Result<Best, Error> {
    let goal = Goal::load(&args.goal)?;
    let done = AtomicU64::new(0);
    let told = |cells| {
        let done = cells + done.fetch_add(cells, Ordering::Relaxed);
        (caller.told)(done, Some(goal.cells));
    };
    let start = Instant::now();
    let answer = optimise(&goal, Progress::new(&told).stopped_by(caller.stop))?;
    let seconds = start.elapsed().as_secs_f64();
    let both = goal.best == Wanted::Both;
    Ok(Best {
        mesh: design::as_read(&answer.mesh)?,
        json: report::json(&answer, "mesh", seconds).to_string(),
        front: both.then(|| report::picture(&goal, &answer)),
        warnings: warnings(&goal, &answer),
    })
}

/// Returns warnings about an answer.
fn warnings(goal: &Goal, answer: &Answer) -> Vec<String> {
    let differ = answer.checks.iter().filter(|own| !own.agrees).count();
    let differ = (differ > 0).then(|| {
        format!(
            "rays and polygons differ in {differ} directions: one of them is wrong; please report it"
        )
    });
    differ.into_iter().chain(answer.at_ends(goal)).collect()
}

/// Runs `bake optimise`.
pub(crate) fn run(args: &OptimiseArgs) -> Result<(), Error> {
    let goal = Goal::load(&args.goal)?;
    if args.plot.is_some() && goal.best != Wanted::Both {
        return Err(Error::Usage(
            "--plot draws the front of sharpness and light, which needs best = \"both\" in the goal; \
            write it there, or leave out --plot"
                .into(),
        ));
    }
    let format = design::Format::of(&args.output)?;
    let mut outputs = Outputs::beside([args.goal.as_path()]);
    let output = outputs.reserve(&args.output)?;
    let plot = reserve_plot(args.plot.as_deref(), &mut outputs)?;
    let display = ProgressDisplay::of_steps();
    display.begin("cells", goal.cells);
    let start = Instant::now();
    let told = |cells: u64| display.advance(cells);
    let answer = optimise(&goal, Progress::new(&told))?;
    let seconds = start.elapsed().as_secs_f64();
    display.finish();
    output.commit(&format.bytes(&answer.mesh)?)?;
    if let Some(plot) = plot {
        plot.commit(report::picture(&goal, &answer).as_bytes())?;
    }
    warn(warnings(&goal, &answer));
    let name = args.output.display().to_string();
    let name = in_a_line(&name);
    Ok(print(&match args.json {
        true => format!("{}\n", report::json(&answer, &name, seconds)),
        false => report::text(&goal, &answer, &name, seconds),
    })?)
}
