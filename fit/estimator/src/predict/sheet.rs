//! Fitted sheet: a result, a table of its cell, and the values of the parameters at any incidence.

use tables::{Direction, Table};

use crate::error::Error;
use crate::model::Blur;
use crate::model::further;
use crate::model::{baseline, wave};
use crate::result::ResultFile;
use crate::result::TableResult;
use edges::names::Kernel;
use edges::names::ParameterKind;

/// Digits of a content hash that a message shows.
const HASH_SHOWN: usize = 12;

/// Result and table of the fitted cell.
///
/// Parameters that were fitted per angle are interpolated linearly in the incidence. Beyond the
/// fitted angles they are constant.
#[derive(Debug, Clone, Copy)]
pub struct Fitted<'a> {
    /// Result of an estimate.
    pub result: &'a ResultFile,
    /// Table of the same cell. Its directions may be others than those of the fit.
    pub table: &'a Table,
}

impl<'a> Fitted<'a> {
    /// Combines a result with a table of its cell.
    ///
    /// # Errors
    /// Returns [`Error::Number`] if a number of the result is out of range, and
    /// [`Error::OtherCell`] if the table is not one of the fitted cell.
    pub fn new(result: &'a ResultFile, table: &'a Table) -> Result<Fitted<'a>, Error> {
        result.check()?;
        if result.polarisation.is_some() && table.passage.is_none() {
            return Err(Error::Unpolarised);
        }
        let given = TableResult::of(table);
        if result.table.same_cell(&given) {
            return Ok(Fitted { result, table });
        }
        Err(Error::OtherCell {
            fitted: shown(&result.table),
            given: shown(&given),
            differs: result.table.difference(&given),
        })
    }

    /// Returns the sheet with the table that its cell has in the light of another colour: its
    /// refractive index and its losses may differ, but not what is behind its facets.
    ///
    /// # Errors
    /// Returns [`Error::OtherCell`] if the other table has another mesh, size, orientation or back.
    pub fn in_colour<'b>(&'b self, table: &'b Table) -> Result<Fitted<'b>, Error> {
        let [own, other] = [self.table, table].map(|table| &table.provenance);
        let differs = [
            ("mesh", own.mesh_hash == other.mesh_hash),
            ("edge length", own.edge_length == other.edge_length),
            ("azimuth zero", own.azimuth_zero == other.azimuth_zero),
            ("back", own.back == other.back),
        ];
        let differs = differs.iter().filter(|(_, same)| !same);
        let differs: Vec<&str> = differs.map(|(name, _)| *name).collect();
        if differs.is_empty() {
            return Ok(Fitted {
                result: self.result,
                table,
            });
        }
        Err(Error::OtherCell {
            fitted: shown(&TableResult::of(self.table)),
            given: shown(&TableResult::of(table)),
            differs: differs.join(", "),
        })
    }

    /// Returns the warnings of the result. What must be known of its waves comes first, also for a
    /// result that does not say it.
    pub fn warnings(&self) -> Vec<String> {
        let [mut warnings, others] = self.warnings_apart();
        warnings.extend(others);
        warnings
    }

    /// Returns what must be known of the waves of the result, and its other warnings.
    pub(crate) fn warnings_apart(&self) -> [Vec<String>; 2] {
        let Fitted { result, table } = self;
        let c_mm = result.c_mm.as_ref().and_then(|c| c.value);
        let waves = match (result.kernel, &result.wavelength_nm, c_mm) {
            (Kernel::Wave, Some(spectrum), Some(c_mm)) => wave::remarks(table, spectrum, c_mm),
            _ => Vec::new(),
        };
        let others = result.warnings.iter().filter(|own| !waves.contains(own));
        let others = others.cloned().collect();
        [waves, others]
    }

    /// Returns spread, corner size and angular spread at an incidence, or the roughnesses of a
    /// baseline. The blur of the camera is not part of it.
    ///
    /// A roughness without a value (the photographs give only a bound) is taken as 0.
    ///
    /// # Errors
    /// Returns [`Error::Unknown`] if the result has no value for a parameter of the blur.
    pub fn blur(&self, incidence_deg: f64) -> Result<Blur, Error> {
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
        let angular_mrad = result.angular_spread_mrad.and_then(|own| own.value);
        Ok(Blur {
            angular_spread_mrad2: angular_mrad.unwrap_or(0.0).powi(2),
            ..Blur::new(spread, c_mm)
        })
    }

    /// Returns the gain of an angular spread in the plane of incidence.
    pub fn tangential_gain(&self, incidence_deg: f64) -> f64 {
        let index = self.table.provenance.refractive_index;
        further::tangential_gain(incidence_deg.to_radians(), index)
    }

    /// Returns the directions at one standard error of the fitted azimuth to either side of an
    /// azimuth, degrees; none if the azimuth was not fitted or the table lacks one of them.
    pub(crate) fn beside(&self, incidence_deg: f64, azimuth_deg: Option<f64>) -> Vec<Direction> {
        let fitted = self
            .result
            .azimuth_deg
            .and_then(|found| found.standard_error);
        let (Some(error), Some(own)) = (fitted, azimuth_deg) else {
            return Vec::new();
        };
        let side = |by: f64| self.table.direction(incidence_deg, Some(own + by)).ok();
        [-error, error]
            .into_iter()
            .map(side)
            .collect::<Option<_>>()
            .unwrap_or_default()
    }

    /// Returns the share of the light that the model returns before mu, where the table returns
    /// `eta`.
    ///
    /// It is `eta` itself, except for baselines.
    pub fn returned(&self, incidence_deg: f64, eta: f64) -> f64 {
        let index = self.table.provenance.refractive_index;
        baseline::returned(self.result.kernel, eta, incidence_deg.to_radians(), index)
    }

    /// Returns the luminance of the mid-air image divided by that of the source, or `None` without
    /// mu.
    ///
    /// It is mu eta T R, where T R is the transmittance of the half mirror times its reflectance.
    /// For a baseline, the light that its model returns takes the place of eta.
    pub fn luminance(&self, incidence_deg: f64, eta: f64) -> Option<f64> {
        let mu = self.result.mu.as_ref().and_then(|mu| mu.at(incidence_deg));
        mu.map(|mu| mu * self.returned(incidence_deg, eta) * self.result.half_mirror)
    }
}

/// Returns design and hash of a table, as messages show them.
fn shown(table: &TableResult) -> String {
    let hash: String = table.content_hash.chars().take(HASH_SHOWN).collect();
    format!("{} {hash}", table.design)
}
