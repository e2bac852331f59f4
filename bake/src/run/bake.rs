//! A plan on a cell: everything that is decided before light is followed.

use crate::cell::{ExactCell, Prepared};
use crate::optics::Rules;
use crate::plan::Plan;
use crate::rays::Tracer;
use crate::run::provenance::provenance;
use tables::options::{Method, Sampler};
use tables::{Axes, Provenance, Symmetry};

/// A plan on a cell: what of it depends on the mesh is decided.
#[derive(Debug, Clone)]
pub(crate) struct Bake<'a> {
    /// The cell.
    pub prepared: &'a Prepared,
    /// What is asked for.
    pub plan: &'a Plan,
    /// Directions and bins of the table.
    pub axes: Axes,
    /// What the azimuths stand for besides themselves.
    pub symmetry: Symmetry,
    /// The cell as the exact method takes it; `None` where rays are traced.
    pub exact: Option<&'a ExactCell>,
    /// What facets do to light.
    pub rules: Rules,
    /// How rays are traced.
    pub tracer: Tracer,
}

impl Bake<'_> {
    /// The same bake, its rays traced by `tracer`.
    pub(crate) fn by(self, tracer: Tracer) -> Self {
        Bake { tracer, ..self }
    }

    /// Directions and bins of the table.
    pub(crate) fn axes(&self) -> &Axes {
        &self.axes
    }

    /// Where the table comes from, made by `method` with `sampler`.
    pub(crate) fn provenance(&self, method: Method, sampler: Option<Sampler>) -> Provenance {
        let cell = self.prepared.cell();
        provenance(cell, self.plan, self.symmetry, method, sampler)
    }
}
