//! Number on which the transforms depend besides direction and frequency, and its axis of the grid.

use tables::Table;

use crate::explore::span::Span;
use crate::explore::stencil::{Ends, Nodes};
use crate::explore::unit::shifts;
use edges::names::Kernel;
use estimator::Error as PredictError;
use estimator::predict::Fitted;
use estimator::result::ResultFile;

/// Number on which the OTF of a sheet with cells of 1 mm depends besides direction and frequency.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Scaling {
    /// None: all light leaves straight back, as rays.
    Fixed,
    /// R / c: light leaves by an angle from straight back.
    Deviating,
    /// R / c^2, 1/mm: light is taken as waves.
    Waves,
}

impl Scaling {
    /// Returns the number for a distance and a size of the cells, mm.
    pub(crate) fn of(self, r_mm: f64, c_mm: f64) -> f64 {
        match self {
            Scaling::Fixed => 1.0,
            Scaling::Deviating => r_mm / c_mm,
            Scaling::Waves => r_mm / (c_mm * c_mm),
        }
    }

    /// Returns the coordinate of the number `own` along the axis of states.
    ///
    /// It is a logarithm while the shift of rays rules, and ends at 0, where an angle rules alone
    /// and only the scale of the blur changes. `bend` lies between both.
    pub(crate) fn coordinate(self, own: f64, bend: f64) -> f64 {
        match self {
            Scaling::Fixed => 0.0,
            Scaling::Deviating | Scaling::Waves => (own / (own + bend)).ln(),
        }
    }

    /// Returns the number at a coordinate, see [`Scaling::coordinate`].
    pub(crate) fn at(self, coordinate: f64, bend: f64) -> f64 {
        match self {
            Scaling::Fixed => 1.0,
            Scaling::Deviating | Scaling::Waves => bend / (-coordinate).exp_m1(),
        }
    }
}

/// Returns the number on which the transforms depend.
pub(crate) fn scaling(kernel: Kernel, table: &Table) -> Scaling {
    let deviates = table.deviations.is_some() || table.exact.as_ref().is_some_and(|e| e.deviates());
    match kernel {
        Kernel::Wave => Scaling::Waves,
        _ if deviates && shifts(kernel) => Scaling::Deviating,
        _ => Scaling::Fixed,
    }
}

/// Returns the number at which an angle begins to rule: that of the waves, or of the deviations.
pub(crate) fn bend(sheet: &Fitted<'_>, scaling: Scaling) -> f64 {
    match scaling {
        Scaling::Fixed => 1.0,
        Scaling::Waves => 1.0 / (shortest_nm(sheet.result) * 1e-6),
        Scaling::Deviating => {
            let exact = sheet.table.exact.as_ref();
            let largest = exact.map_or(1e-3, |exact| exact.largest_deviation_rad());
            1.0 / largest.max(1e-6)
        }
    }
}

/// Returns the shortest wavelength of the source, nm.
pub(crate) fn shortest_nm(result: &ResultFile) -> f64 {
    let lines = result.wavelength_nm.iter().flat_map(|all| all.lines());
    lines
        .map(|line| line.wavelength_nm)
        .fold(f64::INFINITY, f64::min)
}

/// Returns by how many times the waves of red, green and blue are longer than those of the
/// luminance, on the mean; `None` if the colours do not have waves of their own.
///
/// The transform of waves of one length depends on the [`Scaling`] times this length. So that of a
/// colour is about that of the luminance at a scaling as many times as large. It differs by how
/// widely its wavelengths are spread.
pub(crate) fn stretches(result: &ResultFile) -> Option<[f64; 3]> {
    let colours = result
        .colours
        .as_ref()
        .filter(|_| result.kernel.has_waves())?;
    let luminance_nm = result.wavelength_nm.as_ref()?.mean_nm();
    Some(colours.each_ref().map(|own| own.mean_nm() / luminance_nm))
}

/// Returns the nodes of the coordinate of the scaling.
pub(crate) fn states(
    sheet: &Fitted<'_>,
    span: &Span,
    scaling: Scaling,
    step: f64,
) -> Result<Nodes, PredictError> {
    if scaling == Scaling::Fixed {
        return Ok(Nodes::one(0.0));
    }
    let c_mm = sheet.blur(sheet.table.axes.incidence_deg[0])?.c_mm;
    let [near, far] = span.distance_mm;
    let [small, large] = span.factor.map(|factor| factor * c_mm);
    let bend = bend(sheet, scaling);
    let stretches = stretches(sheet.result).unwrap_or([1.0; 3]);
    let shortest = stretches.into_iter().fold(1.0, f64::min);
    let longest = stretches.into_iter().fold(1.0, f64::max);
    let ends = [
        shortest * scaling.of(near, large),
        longest * scaling.of(far, small),
    ];
    let ends = ends.map(|own| scaling.coordinate(own, bend));
    let steps = ((ends[1] - ends[0]) / step - 1e-9).ceil().max(3.0);
    Ok(Nodes::between(ends, steps as usize, Ends::Open))
}
