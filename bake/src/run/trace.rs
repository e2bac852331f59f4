//! The bake itself: a prepared cell and a plan become a table. Prints nothing.

use crate::cell::Prepared;
use crate::plan::{Effort, Plan};
use crate::rays::Tracer;
use crate::run::bake::Bake;
use crate::run::directions;
use crate::run::error::RunError;
use crate::run::ranks::{Alone, Ranks};
use crate::run::rounds::Rounds;
use crate::run::saves::Saves;
use crate::run::watch::Watch;
use crate::run::work::Work;
use tables::Table;
use tables::options::Method;

/// Bakes a cell as planned, by the method that the plan names; `auto` is the exact method where it
/// takes the cell, else rays. The table is the same, byte for byte, whatever the number of threads.
///
/// # Errors
/// [`RunError`]: the method does not take the cell, no threads, a tolerance out of reach, or `watch` stopped it.
pub fn trace(prepared: &Prepared, plan: &Plan, watch: Watch<'_>) -> Result<Table, RunError> {
    Bake::new(prepared, plan)?.table(watch)
}

impl<'a> Bake<'a> {
    /// Decides on method and directions; to choose these for a tolerance may take minutes.
    ///
    /// # Errors
    /// [`RunError::Exact`] where the plan insists on the exact method and it does not take the
    /// cell; [`RunError::ShardOfExact`], [`RunError::DirectionsOfRays`],
    /// [`RunError::DirectionTolerance`].
    pub(crate) fn new(prepared: &'a Prepared, plan: &'a Plan) -> Result<Self, RunError> {
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
        };
        if let Some(tolerance) = plan.direction_tolerance {
            let exact = exact.clone().map_err(RunError::DirectionsOfRays)?;
            bake.axes = directions::choose(&bake, exact, tolerance)?;
        }
        bake.exact = match (plan.method, exact) {
            (Method::Rays, _) | (Method::Auto, Err(_)) => None,
            (_, Ok(_)) if plan.shard.is_some() => return Err(RunError::ShardOfExact),
            (_, Ok(exact)) => Some(exact),
            (Method::Exact, Err(refusal)) => return Err(refusal.into()),
        };
        Ok(bake)
    }

    /// The table.
    ///
    /// # Errors
    /// [`RunError`]: no threads, a tolerance out of reach, or `watch` stopped it.
    pub(crate) fn table(&self, watch: Watch<'_>) -> Result<Table, RunError> {
        match self.exact {
            Some(exact) => self.beams(exact, watch),
            None => Ok(self.rays(watch, None, &Alone)?.table()),
        }
    }

    /// The table, its work shared by `ranks`, from where an interrupted bake was saved, and saved
    /// in its turn. Rank 0 gets the table, the same as that of one process; the exact method is too
    /// short to be shared, and its alone.
    ///
    /// # Errors
    /// As [`Bake::table`], and [`RunError::Saved`] where what was saved is of another bake: all in
    /// rank 0, but [`RunError::Threads`] where it happens. The other ranks then wait for it, so
    /// that who fails must end them.
    pub(crate) fn table_from(
        &self,
        watch: Watch<'_>,
        saves: Option<Saves<'_>>,
        ranks: &dyn Ranks,
    ) -> Result<Option<Table>, RunError> {
        match self.exact {
            None => {
                let work = self.rays(watch, saves, ranks)?;
                Ok(ranks.leads().then(|| work.table()))
            }
            Some(_) if !ranks.leads() => Ok(None),
            Some(exact) => self.beams(exact, watch).map(Some),
        }
    }

    fn rays<'b>(
        &'b self,
        watch: Watch<'b>,
        saves: Option<Saves<'_>>,
        ranks: &'b dyn Ranks,
    ) -> Result<Work<'b>, RunError> {
        let work = Work::new(self, watch)?;
        let mut rounds = Rounds { work, ranks, saves };
        rounds.go_on()?;
        match self.plan.effort {
            Effort::Rays(rays) => rounds.all(rays)?,
            Effort::Tolerance(tolerance) => rounds.until(tolerance)?,
        }
        Ok(rounds.work)
    }
}
