//! The whole bake: what a plan decides about a cell, and the table by beams or by rays.

use crate::beams::exact;
use crate::cell::{ExactCell, MEAN_ERROR, Prepared};
use crate::error::Error;
use crate::optics::Rules;
use crate::plan::{Effort, MOST_BYTES, Plan};
use crate::rays::Tracer;
use crate::run::between::Between;
use crate::run::directions;
use crate::run::provenance::provenance;
use crate::run::ranks::{Alone, Ranks};
use crate::run::rounds::Rounds;
use crate::run::saves::Saves;
use crate::run::work::Work;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use tables::cli::pool;
use tables::options::{Method, Record, Sampler, SceneOptions};
use tables::{Axes, Provenance, Symmetry, Table};

/// Bake of a cell by a plan, in which everything that depends on the mesh is decided.
#[derive(Debug, Clone)]
pub(crate) struct Bake<'a> {
    /// Cell with everything that is known of its mesh.
    pub prepared: &'a Prepared,
    /// Checked plan of the bake.
    pub plan: &'a Plan,
    /// Directions and bins of the table.
    pub axes: Axes,
    /// Symmetry by which the azimuths of the table stand for others.
    pub symmetry: Symmetry,
    /// Cell in the form that the exact method needs; `None` where rays are traced.
    pub exact: Option<&'a ExactCell>,
    /// Rules by which facets change light.
    pub rules: Rules,
    /// Way in which rays are traced.
    pub tracer: Tracer,
    /// Largest error of the trials by which the directions were chosen for a tolerance.
    pub chosen: Option<Between>,
}

/// Table that was baked.
pub(crate) struct Baked {
    /// The table.
    pub table: Table,
    /// Time of the bake in seconds, without reading and writing.
    pub seconds: f64,
}

impl Bake<'_> {
    /// Returns the bake with its rays traced by `tracer`.
    pub(crate) fn by(self, tracer: Tracer) -> Self {
        Bake { tracer, ..self }
    }

    /// Returns the number of rays of the bake; `None` if it runs to a tolerance.
    pub(crate) fn all_rays(&self) -> Option<u64> {
        let (incidences, azimuths) = self.axes.shape();
        match self.plan.effort {
            Effort::Rays(rays) => Some(rays.saturating_mul((incidences * azimuths) as u64)),
            Effort::Tolerance(_) => None,
        }
    }

    /// Checks that this rank bakes what rank 0 bakes.
    ///
    /// A machine may hold another mesh under the same name, or another version of the program.
    ///
    /// # Errors
    /// Returns an [`Error`] if version, plan, axes or provenance differ from those of rank 0.
    pub(crate) fn is_that_of_all(&self, ranks: &dyn Ranks) -> Result<(), Error> {
        let plan = Plan {
            threads: None,
            ..self.plan.clone()
        };
        let (axes, provenance) = (&self.axes, self.provenance(plan.method, None));
        let mut hasher = DefaultHasher::new();
        format!(
            "{} {plan:?} {axes:?} {provenance:?}",
            env!("CARGO_PKG_VERSION")
        )
        .hash(&mut hasher);
        let mut first = [hasher.finish()];
        ranks.follow(&mut first);
        if first == [hasher.finish()] {
            return Ok(());
        }
        let rank = ranks.number();
        Err(Error::Failed(format!(
            "rank {rank} has another mesh, other options or another version of bake than rank 0; give \
            all ranks the same"
        )))
    }

    /// Returns the provenance of a table that is made by `method` with `sampler`.
    pub(crate) fn provenance(&self, method: Method, sampler: Option<Sampler>) -> Provenance {
        let cell = self.prepared.cell();
        provenance(cell, self.plan, self.symmetry, method, sampler)
    }
}

/// Bakes a cell as planned, and returns the table.
///
/// The plan names the method. With `auto` it is the exact method if that can bake the cell,
/// otherwise rays. The table is the same, byte for byte, for any number of threads.
///
/// # Errors
/// Returns [`Error`] if the method cannot bake the cell, the threads cannot be started, a
/// tolerance is out of reach, the exit directions take too much memory, or the caller stopped the
/// bake.
pub fn trace(prepared: &Prepared, plan: &Plan, progress: Progress<'_>) -> Result<Table, Error> {
    Bake::new(prepared, plan, progress)?.table(progress)
}

impl<'a> Bake<'a> {
    /// Decides on the method and the directions of a bake.
    ///
    /// The choice of directions for a tolerance may take minutes; the caller may stop it.
    ///
    /// # Errors
    /// Returns an [`Error`] if the plan asks for the exact method, a shard of its rays or a
    /// tolerance between directions and the method cannot give it, if that tolerance is out of
    /// reach, if the threads cannot be started, or if the caller stopped the choice.
    pub(crate) fn new(
        prepared: &'a Prepared,
        plan: &'a Plan,
        progress: Progress<'_>,
    ) -> Result<Self, Error> {
        let (axes, symmetry) = plan.folded(prepared);
        let exact = plan.exact_cell(prepared);
        let mut bake = Bake {
            prepared,
            plan,
            axes,
            symmetry,
            exact: None,
            rules: plan.rules(prepared.cell()),
            tracer: Tracer::Fastest,
            chosen: None,
        };
        if let Some(tolerance) = plan.direction_tolerance {
            let exact = exact.clone().map_err(|reason| {
                Error::Failed(format!(
                    "--direction-tolerance: {reason}, and only exact tables are interpolated to a \
                    tolerance; give --incidence and --azimuth as lists instead"
                ))
            })?;
            (bake.axes, bake.chosen) = directions::choose(&bake, exact, tolerance, progress)?;
        }
        bake.exact = match (plan.method, exact) {
            (Method::Rays, _) | (Method::Auto, Err(_)) => None,
            (_, Ok(_)) if plan.shard.is_some() => {
                return Err(Error::Usage(
                    "--shard: this cell is baked by the exact method, which traces no rays, so \
                    there is nothing to share; leave out --shard, or give --method rays"
                        .into(),
                ));
            }
            (_, Ok(exact)) => Some(exact),
            (Method::Exact, Err(reason)) => {
                return Err(Error::Failed(format!("--method exact: {reason}")));
            }
        };
        Ok(bake)
    }

    /// Bakes the table in this process alone.
    ///
    /// # Errors
    /// Returns the errors of [`Bake::run`].
    pub(crate) fn table(&self, progress: Progress<'_>) -> Result<Table, Error> {
        let baked = self.run(progress, None, &Alone)?;
        Ok(baked.ok_or(Error::Elsewhere)?.table)
    }

    /// Bakes the table together with `ranks`, and returns it in rank 0.
    ///
    /// With `saves`, the bake goes on from where an interrupted one was saved, and is saved in its
    /// turn. The table is the same as that of one process. The exact method takes too little time
    /// to be shared, so rank 0 does it alone.
    ///
    /// # Errors
    /// Returns [`Error`] if the threads cannot be started, a tolerance is out of reach, the exit
    /// directions take too much memory, the saved state is that of another bake, or the caller
    /// stopped the bake. A tolerance and the saved state fail in rank 0 only. If one rank fails,
    /// the other ranks wait for it, so that it must end them.
    pub(crate) fn run(
        &self,
        progress: Progress<'_>,
        saves: Option<Saves<'_>>,
        ranks: &dyn Ranks,
    ) -> Result<Option<Baked>, Error> {
        let start = Instant::now();
        let table = match self.exact {
            None => {
                let work = self.rays(progress, saves, ranks)?;
                ranks.leads().then(|| work.table())
            }
            Some(_) if !ranks.leads() => None,
            Some(exact) => Some(self.beams(exact, progress)?),
        };
        let seconds = start.elapsed().as_secs_f64();
        Ok(table.map(|table| Baked { table, seconds }))
    }

    /// Traces all rays of the bake and returns the work with its sums.
    fn rays<'b>(
        &'b self,
        progress: Progress<'b>,
        saves: Option<Saves<'_>>,
        ranks: &'b dyn Ranks,
    ) -> Result<Work<'b>, Error> {
        let (incidences, azimuths) = self.axes.shape();
        let (directions, bins) = (incidences * azimuths, self.axes.bins);
        let randomisations = self.plan.randomisations;
        let bytes = [directions, bins, bins, randomisations]
            .iter()
            .fold(8_u64, |product, &n| product.saturating_mul(n as u64));
        if bytes > MOST_BYTES {
            return Err(Error::Failed(format!(
                "the rays of {directions} directions are counted in {bins} x {bins} bins and \
                {randomisations} randomisations, which take more than 2 GiB; give fewer --bins, \
                --incidence or --azimuth"
            )));
        }
        let work = Work::new(self, progress)?;
        let mut rounds = Rounds { work, ranks, saves };
        rounds.go_on()?;
        match self.plan.effort {
            Effort::Rays(rays) => rounds.all(rays)?,
            Effort::Tolerance(tolerance) => rounds.until(tolerance)?,
        }
        Ok(rounds.work)
    }
}

impl Bake<'_> {
    /// Bakes the table by the exact method.
    ///
    /// Options for rays (number, tolerance, sampler, seed) have no effect on the table.
    ///
    /// # Errors
    /// Returns an [`Error`] if the threads cannot be started, or if the caller stopped the bake.
    pub(crate) fn beams(&self, exact: &ExactCell, progress: Progress<'_>) -> Result<Table, Error> {
        let rays_saved = match self.plan.effort {
            Effort::Rays(rays) => rays,
            Effort::Tolerance(_) => 0,
        };
        let done = || {
            progress.tell(rays_saved);
            !progress.is_stopped()
        };
        let baked =
            pool(self.plan.threads)?.install(|| exact::bake(exact, &self.axes, &self.rules, done));
        let baked = baked.ok_or(Error::Stopped)?;
        let provenance = without_rays(self.plan, self.provenance(Method::Exact, None));
        Ok(baked.table(self.axes.clone(), provenance))
    }
}

/// Returns the provenance of an exact table: options for rays have no effect on it.
pub(crate) fn without_rays(plan: &Plan, provenance: Provenance) -> Provenance {
    Provenance {
        seed: 0,
        tolerance: if plan.is_azimuth_mean() {
            MEAN_ERROR
        } else {
            0.0
        },
        shards: None,
        // An exact table holds the direction of each path, whatever the options for rays are.
        options: SceneOptions {
            deviations: Record::Auto,
            ..plan.scene
        }
        .into(),
        ..provenance
    }
}

/// Caller's side of a long bake.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    told: &'a (dyn Fn(u64) + Sync),
    stop: Option<&'a AtomicBool>,
}

impl Progress<'static> {
    /// Makes a progress that is told nothing and never stops the bake.
    pub fn none() -> Self {
        Progress::new(&|_| ())
    }
}

impl<'a> Progress<'a> {
    /// Makes a progress that calls `told` with the number of rays done since its last call.
    ///
    /// The call may come from any thread.
    pub fn new(told: &'a (dyn Fn(u64) + Sync)) -> Self {
        Progress { told, stop: None }
    }

    /// Ends the bake with [`crate::Error::Stopped`] soon after `stop` is set.
    ///
    /// Any thread may set it.
    pub fn stopped_by(self, stop: &'a AtomicBool) -> Self {
        let stop = Some(stop);
        Progress { stop, ..self }
    }

    /// Tells the caller that so many more rays are done.
    pub(crate) fn tell(&self, rays: u64) {
        (self.told)(rays);
    }

    /// Returns whether the bake is to end.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}
