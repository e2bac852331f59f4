//! The bake: a prepared cell and a plan become a table. Nothing is printed.

use crate::cell::Prepared;
use crate::error::Error;

use crate::plan::{Effort, MOST_BYTES, Plan};
use crate::rays::Tracer;
use crate::run::bake::Bake;
use crate::run::directions;
use crate::run::progress::Progress;
use crate::run::ranks::{Alone, Ranks};
use crate::run::rounds::Rounds;
use crate::run::saves::Saves;
use crate::run::work::Work;
use tables::Table;
use tables::options::Method;

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
    Bake::new(prepared, plan)?.table(progress)
}

impl<'a> Bake<'a> {
    /// Decides on the method and the directions of a bake.
    ///
    /// The choice of directions for a tolerance may take minutes.
    ///
    /// # Errors
    /// Returns an [`Error`] if the plan asks for the exact method, a shard of its rays or a
    /// tolerance between directions and the method cannot give it, if that tolerance is out of
    /// reach, or if the threads cannot be started.
    pub(crate) fn new(prepared: &'a Prepared, plan: &'a Plan) -> Result<Self, Error> {
        Bake::reporting(prepared, plan, Progress::none())
    }

    /// Decides as [`Bake::new`] does, and stops if the caller says so.
    ///
    /// # Errors
    /// Returns the errors of [`Bake::new`], and [`Error::Stopped`].
    pub(crate) fn reporting(
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
    /// Returns [`Error`] if the threads cannot be started, a tolerance is out of reach, the exit
    /// directions take too much memory, or the caller stopped the bake.
    pub(crate) fn table(&self, progress: Progress<'_>) -> Result<Table, Error> {
        match self.exact {
            Some(exact) => self.beams(exact, progress),
            None => Ok(self.rays(progress, None, &Alone)?.table()),
        }
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
    pub(crate) fn table_from(
        &self,
        progress: Progress<'_>,
        saves: Option<Saves<'_>>,
        ranks: &dyn Ranks,
    ) -> Result<Option<Table>, Error> {
        match self.exact {
            None => {
                let work = self.rays(progress, saves, ranks)?;
                Ok(ranks.leads().then(|| work.table()))
            }
            Some(_) if !ranks.leads() => Ok(None),
            Some(exact) => self.beams(exact, progress).map(Some),
        }
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
