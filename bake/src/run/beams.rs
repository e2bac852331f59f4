//! Table of a bake by the exact method.

use crate::beams::exact;
use crate::cell::{ExactCell, MEAN_ERROR};
use crate::error::Error;
use crate::plan::{Effort, Plan};
use crate::run::bake::Bake;
use crate::run::progress::Progress;
use tables::cli::pool;
use tables::options::{Method, Record, SceneOptions};
use tables::{Provenance, Table};

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
