//! The fitted sheet: a result and a table of its cell. What its parameters are at any incidence.

use tables::Table;

use crate::model::Blur;
use crate::model::baseline;
use crate::names::Kernel;
use crate::names::ParameterKind;
use crate::predict::error::Error;
use crate::result::ResultFile;
use crate::result::TableResult;

/// A result and a table of the fitted cell. Parameters fitted per angle are interpolated linearly
/// in the incidence and held constant beyond the fitted angles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fitted<'a> {
    /// What was fitted.
    pub result: &'a ResultFile,
    /// A table of the same cell, perhaps with other directions.
    pub table: &'a Table,
}

impl<'a> Fitted<'a> {
    /// Pairs them.
    ///
    /// # Errors
    /// [`Error::OtherCell`].
    pub(crate) fn new(result: &'a ResultFile, table: &'a Table) -> Result<Fitted<'a>, Error> {
        let given = TableResult::of(table);
        if result.table.same_cell(&given) {
            return Ok(Fitted { result, table });
        }
        let name = |table: &TableResult| format!("{} {}", table.design, table.content_hash);
        Err(Error::OtherCell {
            fitted: name(&result.table),
            given: name(&given),
        })
    }

    /// Spread and corner size, or roughnesses, at an incidence. A roughness that the photographs
    /// only bound is 0: what they do not show is left out.
    ///
    /// # Errors
    /// [`Error::Unknown`].
    pub(crate) fn blur(&self, incidence_deg: f64) -> Result<Blur, Error> {
        let result = self.result;
        let at = |parameter, values: &Option<crate::result::Parameter>| {
            let value = values.as_ref().and_then(|values| values.at(incidence_deg));
            value.ok_or(Error::Unknown { parameter })
        };
        let spread = match result.kernel {
            Kernel::Shift | Kernel::Wave => 1.0,
            Kernel::Eq1 | Kernel::Lobe => at(ParameterKind::APerMm, &result.a_per_mm)?,
            Kernel::Angular => at(ParameterKind::ATimesR, &result.a_times_r)?,
            Kernel::Saito | Kernel::SaitoSurface | Kernel::Guo | Kernel::Mrm => {
                at(ParameterKind::Roughness, &result.roughness).unwrap_or(0.0)
            }
        };
        let c_mm = if result.kernel.has_c() {
            let value = result.c_mm.and_then(|c| c.value);
            let smooth = result.surface_roughness.map(|c| c.value.unwrap_or(0.0));
            let parameter = ParameterKind::size_of(result.kernel);
            value.or(smooth).ok_or(Error::Unknown { parameter })?
        } else {
            1.0
        };
        Ok(Blur { spread, c_mm })
    }

    /// What the model makes of the fraction `eta` that the table returns; itself but for baselines.
    pub(crate) fn returned(&self, incidence_deg: f64, eta: f64) -> f64 {
        let index = self.table.provenance.refractive_index;
        baseline::returned(self.result.kernel, eta, incidence_deg.to_radians(), index)
    }

    /// Luminance over the source's where the table returns the fraction `eta`: mu eta T R, and
    /// Fresnel's or other shares of a baseline; `None` without mu.
    pub(crate) fn luminance(&self, incidence_deg: f64, eta: f64) -> Option<f64> {
        let mu = self.result.mu.as_ref().and_then(|mu| mu.at(incidence_deg));
        mu.map(|mu| mu * self.returned(incidence_deg, eta) * self.result.half_mirror)
    }
}
