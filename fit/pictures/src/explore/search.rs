//! Search for the coarsest grid that is fine enough.

use crate::error::Error;
use crate::explore::grid::{Grid, MOST_CORNERS, own_axes};
use crate::explore::lattice::{HIGHEST, sharpness};
use crate::explore::mixed::{Misfit, Mixed, misfit};
use crate::explore::scaling::{Scaling, stretches};
use crate::explore::span::{Fineness, Span, known};
use crate::explore::stencil::Nodes;
use crate::images::{RenderProgress, Viewpoint};
use edges::names::Kernel;
use estimator::predict::Fitted;
use estimator::result::{AtAngle, Number, Parameter, ResultFile};
use tables::Path;

/// Largest error of mixing that the search aims at.
pub const WANTED: f64 = 0.01;

/// Places at which the error that the page states is measured.
const PLACES: usize = 200;

/// Places at which the error along one axis is measured.
const ALONG: usize = 24;

/// Factor by which the axis with the largest error is made finer.
const FINER: f64 = 0.6;

/// Factor that is tried where the numbers of a grid that is finer by [`FINER`] do not fit.
const LITTLE_FINER: f64 = 0.8;

/// Times that the first grid is made coarser if its numbers do not fit.
const COARSER: usize = 3;

/// Spread of a lobe that is nearly none, in units of the highest frequency of a lattice.
const SHARP: f64 = 4.0;

/// Grids that are tried at most.
const MOST_GRIDS: usize = 10;

/// Axes along which a grid can be made finer.
const AXES: [Axis; 4] = [Axis::Incidence, Axis::Azimuth, Axis::State, Axis::None];

/// Grid of a page, with its error.
pub(crate) struct Found {
    /// The grid.
    pub grid: Grid,
    /// Largest error over the places.
    pub misfit: Misfit,
    /// Count of places between the nodes at which the error was measured.
    pub places: usize,
}

/// Computes the coarsest grid whose error of mixing is at most 1 %, or else the finest that fits
/// into a page.
///
/// # Errors
/// Returns [`Error::ManyCorners`] if the table has too many polygons, the errors of [`Grid::new`]
/// for the first grid, and those of [`misfit`].
pub(crate) fn grid(
    sheet: &Fitted<'_>,
    span: &Span,
    progress: RenderProgress<'_>,
) -> Result<Found, Error> {
    let of = |paths: &Vec<Path>| paths.iter().map(|path| path.polygon.len()).sum();
    let exact = sheet.table.exact.iter();
    let corners: usize = exact
        .flat_map(|exact| exact.paths.iter().map(of))
        .max()
        .unwrap_or(0);
    if corners > MOST_CORNERS {
        return Err(Error::ManyCorners { corners });
    }
    let sharpest = scaled(sheet.result, span.factor[1]);
    let sharpest = Fitted {
        result: &sharpest,
        table: sheet.table,
    };
    // A lobe that is nearly none leaves the rim of the shift sharp, as kernel `shift` does. Then
    // the search for a grid of transforms would try all of them in vain.
    let first = sheet
        .table
        .axes
        .incidence_deg
        .first()
        .copied()
        .unwrap_or_default();
    let is_sharp = shifts_rays(sheet)
        && sheet.result.kernel.has_lobe()
        && sharpness(sheet, span, first)? > SHARP * HIGHEST;
    let mut paths = match is_sharp {
        true => of_paths([sheet, &sharpest], span, progress)?,
        false => None,
    };
    if let Some(found) = paths.take_if(|found| found.misfit.larger() <= WANTED) {
        return Ok(found);
    }
    let found = finest([sheet, &sharpest], span, progress)?;
    if found.misfit.larger() <= WANTED || found.grid.gaps.is_some() || !shifts_rays(sheet) {
        return Ok(found);
    }
    let paths = match paths {
        None if !is_sharp => of_paths([sheet, &sharpest], span, progress)?,
        paths => paths,
    };
    let better = paths.filter(|paths| paths.misfit.larger() < found.misfit.larger());
    Ok(better.unwrap_or(found))
}

/// Returns the largest error of the colours that a grid shows by their mean wavelengths, and the
/// count of places at which it was measured: 0 if colours do not have waves of their own.
///
/// No grid is without this error, so the search does not count it.
///
/// # Errors
/// Returns those of [`misfit`].
pub(crate) fn misfit_of_colours(
    sheet: &Fitted<'_>,
    span: &Span,
    grid: &Grid,
    progress: RenderProgress<'_>,
) -> Result<(Misfit, usize), Error> {
    let places = spread(sheet, grid, span);
    let (mut worst, mut count) = (Misfit::default(), 0);
    let own = stretches(sheet.result).zip(sheet.result.colours.as_ref());
    for (colour, stretch) in own.into_iter().flat_map(|(by, own)| own.iter().zip(by)) {
        let result = ResultFile {
            wavelength_nm: Some(colour.clone()),
            ..sheet.result.clone()
        };
        let mixed = Mixed {
            sheet: Fitted {
                result: &result,
                table: sheet.table,
            },
            grid,
            stretch,
        };
        worst = worst.or(misfit(&mixed, &places, progress)?);
        count += places.len();
    }
    Ok((worst, count))
}

/// Computes the grid of the table's paths, for a sheet and for the sharpest one that the page
/// spans; `None` if there is none.
fn of_paths(
    [sheet, sharpest]: [&Fitted<'_>; 2],
    span: &Span,
    progress: RenderProgress<'_>,
) -> Result<Option<Found>, Error> {
    let paths = Fineness {
        paths: true,
        ..Fineness::first(sheet)
    };
    let grid = Grid::new(sheet, span, &paths, progress)?;
    if grid.gaps.is_none() {
        return Ok(None);
    }
    let places = spread(sheet, &grid, span);
    let error = |sheet: &Fitted<'_>| {
        let mixed = Mixed {
            sheet: *sheet,
            grid: &grid,
            stretch: 1.0,
        };
        misfit(&mixed, &places, progress)
    };
    let misfit = error(sheet)?.or(error(sharpest)?);
    Ok(Some(Found {
        grid,
        misfit,
        places: 2 * places.len(),
    }))
}

/// Computes the coarsest grid of transforms whose error is small enough, or else the finest that
/// fits into a page, for a sheet and for the sharpest one that the page spans.
fn finest(
    [sheet, sharpest]: [&Fitted<'_>; 2],
    span: &Span,
    progress: RenderProgress<'_>,
) -> Result<Found, Error> {
    let mut fineness = Fineness::first(sheet);
    if sheet.result.kernel == Kernel::Shift {
        fineness.own = own_axes(sheet.table);
    }
    let mut best: Option<Found> = None;
    let mut coarser: Option<Fineness> = None;
    let mut tried = 0;
    loop {
        tried += 1;
        let grid = match Grid::new(sheet, span, &fineness, progress) {
            Ok(grid) => grid,
            Err(error @ Error::Large { .. }) => {
                fineness = match coarser.take() {
                    _ if fineness.own.is_some() && best.is_none() => Fineness {
                        own: None,
                        ..fineness
                    },
                    Some(coarser) => coarser,
                    None if best.is_none() && tried <= COARSER => AXES
                        .iter()
                        .fold(fineness, |all, &axis| finer(all, axis, 1.0 / FINER)),
                    None => return best.ok_or(error),
                };
                continue;
            }
            Err(error) => return Err(error),
        };
        let error = |sheet: &Fitted<'_>, places: &[Viewpoint]| {
            let mixed = Mixed {
                sheet: *sheet,
                grid: &grid,
                stretch: 1.0,
            };
            misfit(&mixed, places, progress)
        };
        let spread = spread(sheet, &grid, span);
        let found = error(sheet, &spread)?.or(error(sharpest, &spread)?);
        // Paths have no grid that could be finer.
        let last = tried >= MOST_GRIDS || grid.gaps.is_some();
        let enough = goal(sheet, found) <= WANTED || last;
        let worst = match enough {
            true => None,
            false => {
                let one = |sheet, axis| error(sheet, &along(sheet, &grid, span, axis));
                let along = |axis| Ok(one(sheet, axis)?.or(one(sharpest, axis)?).larger());
                let errors = AXES
                    .map(along)
                    .into_iter()
                    .collect::<Result<Vec<_>, Error>>()?;
                (0..4).max_by(|&a, &b| errors[a].total_cmp(&errors[b]))
            }
        };
        let now = Found {
            grid,
            misfit: found,
            places: 2 * spread.len(),
        };
        let better = best.filter(|best| goal(sheet, best.misfit) <= goal(sheet, found));
        let kept = better.unwrap_or(now);
        let Some(worst) = worst else {
            return Ok(kept);
        };
        best = Some(kept);
        coarser = Some(finer(fineness, AXES[worst], LITTLE_FINER));
        fineness = finer(fineness, AXES[worst], FINER);
    }
}

/// Returns whether the blur is the shift of rays, with or without a lobe.
fn shifts_rays(sheet: &Fitted<'_>) -> bool {
    sheet.result.kernel.shifts_rays()
}

/// Returns the error that the search makes small: that of a pixel and that of a weight.
///
/// The light of kernel `shift` ends at a sharp rim. Where the page has neither the paths of the
/// table nor its own directions, no grid that fits into a page follows the weights there, and that
/// of a pixel counts alone.
fn goal(sheet: &Fitted<'_>, misfit: Misfit) -> f64 {
    if sheet.result.kernel == Kernel::Shift {
        misfit.pixel
    } else {
        misfit.larger()
    }
}

/// Returns the fineness of a grid whose steps along one axis are multiplied by `factor`.
fn finer(mut fineness: Fineness, axis: Axis, factor: f64) -> Fineness {
    match axis {
        // The directions of the table are no finer than they are.
        Axis::Incidence | Axis::Azimuth if fineness.own.is_some() => {
            return finer(fineness, Axis::None, factor);
        }
        Axis::Incidence => fineness.incidence_deg *= factor,
        Axis::Azimuth => fineness.azimuth_deg *= factor,
        Axis::State => fineness.state *= factor,
        Axis::None => {
            fineness.lost *= factor;
            fineness.bends /= factor;
        }
    }
    fineness
}

/// Returns a result with c and the spread multiplied by a factor.
fn scaled(result: &ResultFile, factor: f64) -> ResultFile {
    let number = |own: &Number| Number {
        value: own.value.map(|value| value * factor),
        ..*own
    };
    let all = |own: &Option<Parameter>| {
        own.as_ref().map(|own| match own {
            Parameter::Shared(own) => Parameter::Shared(number(own)),
            Parameter::PerAngle { per_angle } => Parameter::PerAngle {
                per_angle: per_angle
                    .iter()
                    .map(|own| AtAngle {
                        value: own.value.map(|value| value * factor),
                        ..*own
                    })
                    .collect(),
            },
        })
    };
    ResultFile {
        c_mm: result.c_mm.as_ref().map(number),
        a_per_mm: all(&result.a_per_mm),
        a_times_r: all(&result.a_times_r),
        ..result.clone()
    }
}

/// Axis of a grid.
#[derive(Clone, Copy, PartialEq)]
enum Axis {
    Incidence,
    Azimuth,
    State,
    /// None of the axes: places on nodes.
    None,
}

/// Returns places in the middle between nodes of one axis, and on nodes of the others.
fn along(sheet: &Fitted<'_>, grid: &Grid, span: &Span, axis: Axis) -> Vec<Viewpoint> {
    let nodes = |nodes: &Nodes| -> Vec<f64> { (0..nodes.count).map(|k| nodes.place(k)).collect() };
    let pick = |own: &Nodes, between: bool| match between {
        true if own.count > 1 => own.middles().collect(),
        true => Vec::new(),
        false => nodes(own),
    };
    let incidences = pick(&grid.incidence, axis == Axis::Incidence);
    let azimuths = pick(&grid.azimuth, axis == Axis::Azimuth);
    let states = pick(&grid.state, axis == Axis::State);
    let count = incidences.len() * azimuths.len() * states.len();
    let chosen = (0..ALONG.min(count)).map(|k| k * count / ALONG.min(count));
    chosen
        .map(|k| {
            let state = states[k % states.len()];
            let azimuth = azimuths[k / states.len() % azimuths.len()];
            let incidence_deg = incidences[k / states.len() / azimuths.len()];
            let c_mm = sheet.blur(incidence_deg).map_or(1.0, |blur| blur.c_mm);
            let [near, far] = span.distance_mm;
            let r_mm = match grid.scaling {
                Scaling::Fixed => (near * far).sqrt(),
                Scaling::Deviating => grid.scaling.at(state, grid.bend) * c_mm,
                Scaling::Waves => grid.scaling.at(state, grid.bend) * c_mm * c_mm,
            };
            Viewpoint {
                incidence_deg,
                azimuth_deg: known(azimuth),
                r_mm: r_mm.clamp(near, far),
            }
        })
        .collect()
}

/// Returns places that fill the ranges evenly: multiples of three irrational numbers.
fn spread(sheet: &Fitted<'_>, grid: &Grid, span: &Span) -> Vec<Viewpoint> {
    // The powers of the root of x^4 = x + 1 spread points evenly in three dimensions.
    const STEP: [f64; 3] = [0.819_172_513, 0.671_043_607, 0.549_700_478];
    let incidences = &sheet.table.axes.incidence_deg;
    let (low, high) = (incidences[0], incidences[incidences.len() - 1]);
    let around = &grid.azimuth;
    let end = around.place(around.count - 1);
    let [near, far] = span.distance_mm.map(f64::ln);
    (0..PLACES)
        .map(|k| {
            let [a, b, c] = STEP.map(|step| (0.5 + step * k as f64).fract());
            Viewpoint {
                incidence_deg: low + a * (high - low),
                azimuth_deg: known(around.first + b * (end - around.first)),
                r_mm: (near + c * (far - near)).exp(),
            }
        })
        .collect()
}
