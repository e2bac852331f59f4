//! What a page spans, and how fine its grid is.

use crate::explore::stencil::{Nodes, POINTS};
use edges::names::Kernel;
use estimator::predict::Fitted;

/// Ranges that the sliders of the page span.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Span {
    /// Distances, mm.
    pub distance_mm: [f64; 2],
    /// Widths of the picture, mm.
    pub width_mm: [f64; 2],
    /// Factors on c, a and mu.
    pub factor: [f64; 2],
}

/// Fineness of a grid, which is raised until the error of mixing is small enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fineness {
    /// Widest step between incidences, degrees.
    pub incidence_deg: f64,
    /// Widest step between azimuths, degrees.
    pub azimuth_deg: f64,
    /// Widest step between coordinates of the [`Scaling`].
    pub state: f64,
    /// Largest transfer of the lobe beyond the frequencies of the grid.
    pub lost: f64,
    /// Most nodes that a place mixes along one axis.
    pub points: usize,
    /// True if the page holds the paths of an exact table in place of a grid, where they fit.
    pub paths: bool,
    /// Nodes that are the directions of the table, in place of those at the widest steps.
    pub own: Option<[Nodes; 2]>,
    /// Points of a lattice for the bends of the transform of waves.
    pub bends: f64,
}

impl Fineness {
    /// Returns the fineness with which the search begins.
    pub(crate) fn first(sheet: &Fitted<'_>) -> Fineness {
        let waves = sheet.result.kernel.has_waves();
        Fineness {
            // Waves of prisms need this grid. Two coarser ones, tried in vain, took three fifths of
            // the time of a page.
            incidence_deg: if waves { 3.0 } else { 5.0 },
            azimuth_deg: if waves { 3.6 } else { 10.0 },
            state: 0.3,
            lost: if waves { 0.01 } else { 0.02 },
            paths: sheet.result.kernel == Kernel::Shift,
            own: None,
            // The rim of a shift without a lobe is sharp, and its transform moves far from node to
            // node. Six nodes follow it better. Smoother kernels gain nothing from them.
            points: if sheet.result.kernel == Kernel::Shift {
                6
            } else {
                POINTS
            },
            bends: 5.0,
        }
    }
}

/// Returns the azimuth, or `None` for a mean over azimuths.
pub(crate) fn known(azimuth_deg: f64) -> Option<f64> {
    (!azimuth_deg.is_nan()).then_some(azimuth_deg)
}
