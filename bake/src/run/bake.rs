//! Bake of a cell by a plan, with everything decided before light is followed.

use crate::cell::{ExactCell, Prepared};
use crate::optics::Rules;
use crate::plan::Plan;
use crate::rays::Tracer;
use crate::run::between::Between;
use crate::run::provenance::provenance;
use tables::options::{Method, Sampler};
use tables::{Axes, Provenance, Symmetry};

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

impl Bake<'_> {
    /// Returns the bake with its rays traced by `tracer`.
    pub(crate) fn by(self, tracer: Tracer) -> Self {
        Bake { tracer, ..self }
    }

    /// Returns the directions and bins of the table.
    pub(crate) fn axes(&self) -> &Axes {
        &self.axes
    }

    /// Returns the provenance of a table that is made by `method` with `sampler`.
    pub(crate) fn provenance(&self, method: Method, sampler: Option<Sampler>) -> Provenance {
        let cell = self.prepared.cell();
        provenance(cell, self.plan, self.symmetry, method, sampler)
    }
}
