//! Sheet of the grid: cells of 1 mm and no lobe.

use edges::names::Kernel;
use estimator::predict::Fitted;
use estimator::result::{Number, ResultFile};

/// Sheet with cells of 1 mm and without a lobe: its result.
pub(crate) struct UnitSheet(ResultFile);

impl UnitSheet {
    /// Takes the shift or the waves of a result.
    pub(crate) fn of(result: &ResultFile) -> UnitSheet {
        let kernel = match result.kernel {
            kernel if kernel.shifts_rays() => Kernel::Shift,
            other => other,
        };
        let c_mm = Some(Number {
            value: Some(1.0),
            standard_error: None,
        });
        UnitSheet(ResultFile {
            kernel,
            c_mm: if shifts(kernel) { c_mm } else { result.c_mm },
            ..result.clone()
        })
    }

    /// Returns the sheet without waves: the shift of rays alone.
    pub(crate) fn rays(&self) -> UnitSheet {
        UnitSheet(ResultFile {
            kernel: Kernel::Shift,
            ..self.0.clone()
        })
    }

    /// Returns the sheet on the table of another.
    pub(crate) fn on<'a>(&'a self, sheet: &Fitted<'a>) -> Fitted<'a> {
        Fitted {
            result: &self.0,
            table: sheet.table,
        }
    }
}

/// Returns whether the blur of a kernel contains the shift of rays.
pub(crate) fn shifts(kernel: Kernel) -> bool {
    kernel.has_c() && !kernel.is_baseline()
}

/// Returns the factor by which a shift along the sheet is shortened across the viewing ray.
///
/// Waves are not taken apart into shifts along the sheet: for them it is 1.
pub(crate) fn tilt(kernel: Kernel, incidence_deg: f64) -> f64 {
    match kernel.shifts_rays() {
        true => incidence_deg.to_radians().cos(),
        false => 1.0,
    }
}
