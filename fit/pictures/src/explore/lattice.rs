//! Frequencies at which the transforms of the grid are known.

use crate::explore::scaling::{Scaling, bend, shortest_nm};
use crate::explore::span::{Fineness, Span, known};
use crate::explore::stencil::Nodes;
use crate::explore::unit::{UnitSheet, shifts, tilt};
use crate::images::{Sheet, Viewpoint};
use edges::names::{Kernel, LobeShape};
use estimator::Error as PredictError;
use estimator::model::Lobe;
use estimator::model::wave;
use estimator::predict::Fitted;
use estimator::result::ResultFile;

/// Points of the lattice per cycle of the fastest phase. Lagrange's polynomial of six points then
/// errs by at most (pi/4)^6 x (0.5 x 1.5 x 2.5)^2/720 = 1.1e-3, and less where the light is spread
/// evenly. The measured error of the page contains it.
pub(crate) const STEPS: f64 = 8.0;

/// Points of the lattice beyond the last frequency, and below 0.
pub(crate) const MARGIN: usize = 3;

/// Highest frequency of the lattice where nothing else ends it, cycles per edge length.
pub(crate) const HIGHEST: f64 = 4.0;

/// Highest frequencies of the lattices.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub(crate) struct Ending {
    /// Highest frequency of all, cycles per edge length.
    pub highest: f64,
    /// Frequency times [`Scaling`] at which waves or a lobe of fixed angle end.
    ///
    /// It is [`f64::MAX`] without either.
    pub angle: f64,
}

impl Ending {
    /// Returns the end of the lattice, cycles per edge length, at a number of the [`Scaling`].
    ///
    /// It is smooth, so that states are mixed at equal shares of their ends.
    pub(crate) fn at(&self, scaling: f64) -> f64 {
        (self.highest.powi(-4) + (scaling / self.angle).powi(4)).powf(-0.25)
    }
}

/// Frequencies at which the transforms of one state are known.
///
/// Rows run from -[`MARGIN`] to `points` + [`MARGIN`], columns from -(`points` + [`MARGIN`]).
/// Without shifts there is one point, of frequency 0.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub(crate) struct Lattice {
    /// Highest frequency that is used, cycles per edge length. Beyond it the transform counts as 0.
    pub end: f64,
    /// Points from 0 to the end.
    pub points: usize,
}

impl Lattice {
    /// The lattice of a sheet without shifts.
    pub(crate) const NONE: Lattice = Lattice {
        end: 1.0,
        points: 0,
    };

    /// Returns the number of the column and of the row of frequency 0.
    pub(crate) fn zero(&self) -> [usize; 2] {
        match self.points {
            0 => [0; 2],
            points => [points + MARGIN, MARGIN],
        }
    }

    /// Returns the counts of columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        match self.points {
            0 => [1; 2],
            points => [2 * (points + MARGIN) + 1, points + 2 * MARGIN + 1],
        }
    }

    /// Returns the count of numbers.
    pub(crate) fn count(&self) -> usize {
        self.size()[0] * self.size()[1]
    }

    /// Returns the distance between frequencies, cycles per edge length.
    pub(crate) fn step(&self) -> f64 {
        self.end / self.points.max(1) as f64
    }
}

/// Frequencies of the lattices.
pub(crate) struct Shape {
    /// Ends of the lattices.
    pub ends: Ending,
    /// Slope of the kink of waves, see [`kink`].
    pub kink: f64,
    /// Distance of each state for cells of 1 mm, mm.
    pub distances: Vec<f64>,
    /// Lattice of each state.
    pub lattices: Vec<Lattice>,
    /// Farthest shift of all states, edge lengths.
    pub reach: f64,
}

impl Shape {
    pub(crate) fn new(
        sheet: &Fitted<'_>,
        span: &Span,
        fineness: &Fineness,
        state: &Nodes,
        scaling: Scaling,
        incidence: &Nodes,
    ) -> Result<Shape, PredictError> {
        let kernel = sheet.result.kernel;
        if !shifts(kernel) {
            return Ok(Shape {
                ends: Ending {
                    highest: 1.0,
                    angle: f64::MAX,
                },
                kink: 0.0,
                distances: vec![1.0; state.count],
                lattices: vec![Lattice::NONE; state.count],
                reach: 0.0,
            });
        }
        let ends = Ending {
            highest: highest(sheet, span, fineness.lost, incidence)?,
            angle: match scaling {
                Scaling::Waves => cutoff(sheet.result),
                Scaling::Deviating if kernel == Kernel::Angular => {
                    lobe_of_an_angle(sheet, span, fineness.lost, incidence)?
                }
                Scaling::Fixed | Scaling::Deviating => f64::MAX,
            },
        };
        // The shifts alone: waves have no end.
        let rays = UnitSheet::of(sheet.result).rays();
        let mut shape = Shape {
            ends,
            kink: kink(sheet)?,
            distances: Vec::new(),
            lattices: Vec::new(),
            reach: 0.0,
        };
        for k in 0..state.count {
            let r_mm = scaling.at(state.place(k), bend(sheet, scaling));
            let mut reach: f64 = 1e-3;
            for (incidence_deg, azimuth_deg) in sheet.table.axes.directions() {
                let at = Viewpoint {
                    incidence_deg,
                    azimuth_deg: known(azimuth_deg),
                    r_mm,
                };
                let tilt = tilt(kernel, incidence_deg);
                reach = reach.max(rays.on(sheet).spot(&at, 1.0)?.reach_mm() / tilt);
            }
            let end = ends.at(r_mm);
            // The transform of waves has a kink at frequency 0 and an end, so that a few points
            // more are taken than the phases want.
            let kinks = if scaling == Scaling::Waves {
                fineness.bends / end
            } else {
                0.0
            };
            let step = 1.0 / (STEPS * (reach + kinks));
            shape.reach = shape.reach.max(reach);
            shape.distances.push(r_mm);
            shape.lattices.push(Lattice {
                end,
                points: (end / step).ceil() as usize,
            });
        }
        Ok(shape)
    }
}

/// Returns the frequency times the scaling beyond which the OTF of waves is 0.
///
/// No aperture is wider than a full cube's hexagon, 1.63 edge lengths. The rest is for the bend of
/// [`Ending::at`].
pub(crate) fn cutoff(result: &ResultFile) -> f64 {
    const WIDEST: f64 = 1.8;
    WIDEST / (shortest_nm(result) * 1e-6)
}

/// Returns the frequency, cycles per edge length, beyond which the lobe passes at most `lost`.
pub(crate) fn highest(
    sheet: &Fitted<'_>,
    span: &Span,
    lost: f64,
    incidence: &Nodes,
) -> Result<f64, PredictError> {
    let result = sheet.result;
    if !result.kernel.has_lobe() {
        return Ok(HIGHEST * 0.02 / lost.min(0.02));
    }
    let shape = result.lobe.unwrap_or(LobeShape::Radial);
    let mut highest: f64 = 0.0;
    for k in 0..incidence.count {
        let width = sharpness(sheet, span, incidence.place(k))?;
        highest = highest.max(end_of_lobe(shape, lost) * width);
    }
    Ok(highest.clamp(0.1, HIGHEST))
}

/// Returns the greatest spread of the lobe on the page, cycles per edge length.
pub(crate) fn sharpness(
    sheet: &Fitted<'_>,
    span: &Span,
    incidence_deg: f64,
) -> Result<f64, PredictError> {
    let blur = sheet.blur(incidence_deg)?;
    let most = span.factor[1];
    let a = most * blur.spread / sheet.result.kernel.distance_scale(span.distance_mm[0]);
    Ok(a * most * blur.c_mm)
}

/// Returns the frequency times the scaling R / c beyond which a lobe of fixed angle passes at most
/// `lost`. The rest is for the bend of [`Ending::at`].
fn lobe_of_an_angle(
    sheet: &Fitted<'_>,
    span: &Span,
    lost: f64,
    incidence: &Nodes,
) -> Result<f64, PredictError> {
    let mut widest: f64 = 0.0;
    for k in 0..incidence.count {
        widest = widest.max(sheet.blur(incidence.place(k))?.spread);
    }
    let shape = sheet.result.lobe.unwrap_or(LobeShape::Radial);
    Ok(1.1 * end_of_lobe(shape, lost) * span.factor[1] * widest)
}

/// Returns the frequency, in units of a, beyond which a lobe passes at most `lost`.
fn end_of_lobe(shape: LobeShape, lost: f64) -> f64 {
    (1..=400)
        .map(|i| 0.01 * f64::from(i))
        .filter(|&f| shape.otf(1.0, f, [1.0, 0.0]).0.abs() > lost)
        .fold(0.01, f64::max)
}

/// Returns the mean slope of the transform of waves at frequency 0, per frequency and [`Scaling`];
/// 0 without waves.
///
/// Waves have a cone there, which no polynomial follows. So the grid holds the transform divided
/// by a cone of this slope.
pub(crate) fn kink(sheet: &Fitted<'_>) -> Result<f64, PredictError> {
    if !sheet.result.kernel.has_waves() {
        return Ok(0.0);
    }
    let spectrum = sheet.result.wavelength_nm.as_ref();
    let (mut sum, mut count) = (0.0, 0);
    for (incidence_deg, azimuth_deg) in sheet.table.axes.directions() {
        let direction = sheet.table.direction(incidence_deg, known(azimuth_deg))?;
        if direction.retroreflected <= 0.0 {
            continue;
        }
        for normal in [[1.0, 0.0], [0.0, 1.0]] {
            let line = wave::line(&direction, incidence_deg.to_radians(), normal, spectrum);
            sum += line.map_err(PredictError::from)?.kink(1.0, 1.0);
            count += 1;
        }
    }
    Ok(sum / f64::from(count.max(1)))
}

/// Evaluates the cone at a frequency, for a slope.
pub(crate) fn kinked(slope: f64, frequency: [f64; 2]) -> f64 {
    (-slope * frequency[0].hypot(frequency[1])).exp()
}
