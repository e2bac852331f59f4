//! Transforms of the ray shift on a grid of directions, from which the page mixes every place.
//!
//! The sheet of the grid has cells of 1 mm and no lobe. Its OTF S depends on the direction, on the
//! frequency and, where light does not leave straight back or is taken as waves, on one number
//! more: the [`Scaling`]. A frequency g of this sheet stands for g / c of a sheet with cells of
//! size c. So c, the lobe and the size of the picture need no nodes: the page computes with them as
//! they are. Tangential frequencies of shifts are those along the sheet, see
//! [`tilt`](crate::explore::unit::tilt).

use std::io::Write;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;
use tables::Table;

use crate::error::Error;
use crate::explore::gaps::{self, Gaps};
use crate::explore::lattice::{Ending, Lattice, MARGIN, Shape, kinked};
use crate::explore::scaling::{Scaling, bend, scaling, states};
use crate::explore::span::{Fineness, Span, known};
use crate::explore::stencil::{Ends, Nodes};
use crate::explore::unit::{UnitSheet, shifts, tilt};
use crate::images::progress::Pieces;
use crate::images::sheet::spot_of;
use crate::images::{RenderProgress, Viewpoint};
use estimator::Error as PredictError;
use estimator::predict::Fitted;

/// Corners of the polygons of a direction, at most. Cells of one or two cubes have 10 to 60. The
/// time of a page grows in proportion, to minutes.
pub(crate) const MOST_CORNERS: usize = 512;

/// Numbers of the page, at most, bytes. They take about a sixth of it when packed.
const MOST_BYTES: usize = 32_000_000;

/// Text of the packed numbers, at most, bytes, so that the page stays below 4 MB.
const MOST_TEXT: usize = 3_700_000;

/// Factor from a number of a transform to an integer of the page.
///
/// Transforms divided by that of a kink can be larger than 1.
pub(crate) const UNIT: f64 = 8_000.0;

/// Transforms of the ray shift on a grid of directions.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    /// Incidences, degrees.
    pub incidence: Nodes,
    /// Azimuths, degrees; NaN for a mean over azimuths.
    pub azimuth: Nodes,
    /// Coordinates of the [`Scaling`].
    pub state: Nodes,
    /// Number at which the coordinate of the scaling bends.
    pub bend: f64,
    /// Ends of the lattices.
    pub ends: Ending,
    /// Slope of the kink of waves, see [`kink`].
    pub kink: f64,
    /// Number that `state` stands for.
    pub scaling: Scaling,
    /// Lattice of frequencies of each state.
    pub lattices: Vec<Lattice>,
    /// True if all transforms are real.
    pub real: bool,
    /// Light that returns, before mu and half mirror, `[incidence, azimuth]`.
    pub energy: Vec<f64>,
    /// Distance that contains all shifts, edge lengths, `[incidence, azimuth, state]`.
    pub reach: Vec<f64>,
    /// Paths of an exact table, which stand for the transforms where light ends at a sharp rim.
    pub gaps: Option<Gaps>,
    /// Transforms in units of 1 / [`UNIT`], `[incidence, azimuth, state, row, column]`, real and
    /// imaginary parts in turns.
    pub values: Vec<i16>,
    /// `values` as text: their differences, the lower bytes of all, then the upper bytes, packed by
    /// zlib, in base64.
    pub text: String,
}

/// Transforms of one direction, for each state: the reach and the numbers.
type Transforms = Vec<(f64, Vec<[f64; 2]>)>;

impl Grid {
    /// Computes the grid of a sheet.
    ///
    /// # Errors
    /// Returns [`Error::Sheet`] if the blur cannot be computed, and [`Error::Large`] if the numbers
    /// do not fit into a page.
    pub(crate) fn new(
        sheet: &Fitted<'_>,
        span: &Span,
        fineness: &Fineness,
        progress: RenderProgress<'_>,
    ) -> Result<Grid, Error> {
        let (result, table) = (sheet.result, sheet.table);
        let scaling = scaling(result.kernel, table);
        let incidences = &table.axes.incidence_deg;
        let (low, high) = (incidences[0], incidences[incidences.len() - 1]);
        let steps = ((high - low) / fineness.incidence_deg - 1e-9)
            .ceil()
            .max(3.0);
        let incidence = Nodes::between([low, high], steps as usize, Ends::Open);
        let azimuth = azimuths(table, fineness.azimuth_deg);
        let bend = bend(sheet, scaling);
        if fineness.paths
            && let Some(gaps) = Gaps::new(table, &azimuth)
        {
            return Ok(Grid::of_paths(table, [incidence, azimuth], gaps));
        }
        let [incidence, azimuth] = (fineness.own)
            .unwrap_or([incidence, azimuth].map(|nodes| nodes.mixing(fineness.points)));
        let state = states(sheet, span, scaling, fineness.state)?;
        let shape = Shape::new(sheet, span, fineness, &state, scaling, &incidence)?;
        let real = scaling == Scaling::Waves || !shifts(result.kernel);
        let parts = if real { 1 } else { 2 };
        let places = incidence.count * azimuth.count;
        let numbers: usize = shape.lattices.iter().map(Lattice::count).sum();
        let bytes = places * numbers * parts * size_of::<i16>();
        let large = |bytes: usize| Error::Large {
            megabytes: bytes as f64 / 1e6,
            reach: shape.reach,
            distance_mm: span.distance_mm,
        };
        if bytes > MOST_BYTES {
            return Err(large(bytes / 4));
        }
        let unit = UnitSheet::of(result);
        let rays = unit.rays();
        let pieces = Pieces::new(progress, "directions", places);
        let nodes: Vec<(f64, Transforms)> = (0..places)
            .into_par_iter()
            .map(|place| {
                let at = Viewpoint {
                    incidence_deg: incidence.place(place / azimuth.count),
                    azimuth_deg: known(azimuth.place(place % azimuth.count)),
                    r_mm: 1.0,
                };
                let own = node(sheet, [&unit, &rays], &at, &shape);
                pieces.one();
                own
            })
            .collect::<Result<_, PredictError>>()?;
        let mut grid = Grid {
            incidence,
            azimuth,
            state,
            bend,
            ends: shape.ends,
            kink: shape.kink,
            scaling,
            lattices: shape.lattices,
            real,
            gaps: None,
            energy: Vec::with_capacity(places),
            reach: Vec::new(),
            values: Vec::with_capacity(bytes / size_of::<i16>()),
            text: String::new(),
        };
        for (energy, lattices) in nodes {
            grid.energy.push(energy);
            for (reach, values) in lattices {
                grid.reach.push(reach);
                let rounded = |part: f64| (part * UNIT).round() as i16;
                let all = values.iter().flat_map(|value| &value[..parts]);
                grid.values.extend(all.map(|&part| rounded(part)));
            }
        }
        grid.text = packed(&grid.values, &grid.lattices, parts);
        if grid.text.len() > MOST_TEXT {
            return Err(large(grid.text.len()));
        }
        Ok(grid)
    }

    /// Makes a grid that holds the paths of a table, and no transforms.
    fn of_paths(table: &Table, [incidence, azimuth]: [Nodes; 2], gaps: Gaps) -> Grid {
        Grid {
            incidence,
            azimuth,
            state: Nodes::one(0.0),
            bend: 1.0,
            ends: Ending {
                highest: 1.0,
                angle: f64::MAX,
            },
            kink: 0.0,
            scaling: Scaling::Fixed,
            lattices: vec![Lattice::NONE],
            real: true,
            gaps: Some(gaps),
            energy: table.retroreflected.iter().copied().collect(),
            reach: Vec::new(),
            values: Vec::new(),
            text: packed(&[], &[], 1),
        }
    }
}

/// Packs the transforms of all directions as the page unpacks them.
///
/// A number is told from its neighbours: what is packed are second differences along the rows of
/// first differences along the columns, with the sign in the lowest bit. They are small where the
/// transform is smooth, and take a third less room. All sums are taken modulo 2^16, so nothing is
/// lost.
fn packed(values: &[i16], lattices: &[Lattice], parts: usize) -> String {
    let mut coded = Vec::with_capacity(values.len());
    let mut rest = values;
    while !rest.is_empty() {
        for lattice in lattices {
            let [columns, _] = lattice.size();
            let (own, next) = rest.split_at(lattice.count() * parts);
            coded.extend(differences(own, columns * parts, parts));
            rest = next;
        }
    }
    let byte = |which: usize| {
        coded
            .iter()
            .map(move |value: &u16| value.to_le_bytes()[which])
    };
    let bytes: Vec<u8> = byte(0).chain(byte(1)).collect();
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    let written = packer.write_all(&bytes).and_then(|()| packer.finish());
    STANDARD.encode(written.expect("memory takes every byte"))
}

/// Returns the differences of a lattice whose rows have `width` numbers, `parts` of each point.
fn differences(values: &[i16], width: usize, parts: usize) -> impl Iterator<Item = u16> + use<'_> {
    let at = move |row: usize, column: usize, back: usize| match column.checked_sub(back * parts) {
        Some(column) => {
            let above = row
                .checked_sub(1)
                .map_or(0, |row| values[row * width + column]);
            values[row * width + column].wrapping_sub(above)
        }
        None => 0,
    };
    (0..values.len()).map(move |place| {
        let [now, before, earlier] = [0, 1, 2].map(|back| at(place / width, place % width, back));
        let second = now
            .wrapping_sub(before)
            .wrapping_sub(before)
            .wrapping_add(earlier);
        ((second << 1) ^ (second >> 15)) as u16
    })
}

/// Returns the azimuths of the grid: one sector if the table goes all around, else what it spans.
fn azimuths(table: &Table, step_deg: f64) -> Nodes {
    let own = &table.axes.azimuth_deg;
    if table.axes.is_mean() {
        return Nodes::one(f64::NAN);
    }
    let steps = |width: f64| ((width / step_deg - 1e-9).ceil() as usize).max(3);
    let symmetry = table.provenance.symmetry;
    let (first, width) = symmetry.sector_deg();
    let incidence_deg = table.axes.incidence_deg[0];
    // A table that knows the middle between all its neighbours goes all around.
    let whole = (0..360).all(|deg| {
        let azimuth_deg = Some(f64::from(deg) + 0.5);
        table.direction(incidence_deg, azimuth_deg).is_ok()
    });
    let ends = match (whole, symmetry.mirror_deg) {
        (true, Some(_)) => Ends::Mirrors,
        (true, None) => Ends::Turn,
        (false, _) => {
            return Nodes::between(
                [own[0], own[own.len() - 1]],
                steps(own[own.len() - 1] - own[0]),
                Ends::Open,
            );
        }
    };
    Nodes::between([first, first + width], steps(width), ends)
}

/// Returns the axes of a table of rays as nodes of which a place mixes two, if they are evenly
/// spaced. That mixture is exact: such a table mixes its bins in the same way.
pub(crate) fn own_axes(table: &Table) -> Option<[Nodes; 2]> {
    let around = azimuths(table, 360.0);
    if table.exact.is_some() || table.axes.is_mean() {
        return None;
    }
    let even = |own: &[f64], ends: Ends| {
        let nodes = Nodes::between([own[0], own[own.len() - 1]], own.len() - 1, ends);
        let mut all = own.iter().enumerate();
        let meets = all.all(|(k, own)| (nodes.place(k) - own).abs() < 1e-9);
        meets.then_some(nodes.mixing(2))
    };
    let azimuth = even(&gaps::azimuths(table, &around), around.ends)?;
    let same = (azimuth.first - around.first).abs() < 1e-9
        && (azimuth.width() - around.width()).abs() < 1e-9;
    let incidence = even(&table.axes.incidence_deg, Ends::Open)?;
    same.then_some([incidence, azimuth])
}

/// Computes energy, reach and lattices of one direction, by the sheet with cells of 1 mm and by its
/// rays alone.
fn node(
    sheet: &Fitted<'_>,
    [unit, rays]: [&UnitSheet; 2],
    at: &Viewpoint,
    shape: &Shape,
) -> Result<(f64, Transforms), PredictError> {
    let direction = sheet.table.direction(at.incidence_deg, at.azimuth_deg)?;
    let energy = sheet.returned(at.incidence_deg, direction.retroreflected);
    let [unit, rays] = [unit.on(sheet), rays.on(sheet)];
    let lines = Arc::default();
    let mut all = Transforms::new();
    for (&r_mm, lattice) in shape.distances.iter().zip(&shape.lattices) {
        if !shifts(sheet.result.kernel) {
            all.push((0.0, vec![[1.0, 0.0]]));
            continue;
        }
        let at = Viewpoint { r_mm, ..*at };
        let step = lattice.step();
        let tilt = tilt(sheet.result.kernel, at.incidence_deg);
        let finest = (lattice.end + step * (MARGIN + 1) as f64) / tilt;
        let spot = spot_of(&unit, direction.clone(), &at, finest, Some(&lines))?;
        let (columns, zero) = (lattice.size()[0], lattice.zero());
        let value = |place: usize| {
            let at = [place % columns, place / columns];
            let frequency = [0, 1].map(|k| step * (at[k] as f64 - zero[k] as f64));
            let [along, across] = frequency;
            let smooth = spot.otf([along / tilt, across]) / kinked(shape.kink * r_mm, frequency);
            [smooth.re, smooth.im]
        };
        let reach = spot_of(&rays, direction.clone(), &at, 1.0, None)?.reach_mm() / tilt;
        all.push((reach, (0..lattice.count()).map(value).collect()));
    }
    Ok((energy, all))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds differences up again, as the page does.
    fn added_up(coded: &[u16], width: usize, parts: usize) -> Vec<i16> {
        let unsigned = |coded: u16| ((coded >> 1) as i16) ^ -((coded & 1) as i16);
        let mut values: Vec<i16> = coded.iter().map(|&coded| unsigned(coded)).collect();
        for row in values.chunks_exact_mut(width) {
            for _ in 0..2 {
                for k in parts..width {
                    row[k] = row[k].wrapping_add(row[k - parts]);
                }
            }
        }
        for k in width..values.len() {
            values[k] = values[k].wrapping_add(values[k - width]);
        }
        values
    }

    /// Nothing is lost, whatever the values, also where differences leave 16 bits.
    #[test]
    fn differences_add_up_to_the_values() {
        for parts in [1, 2] {
            for (columns, rows) in [(1, 1), (2, 3), (7, 4), (40, 21)] {
                let width = columns * parts;
                let jumps = (0..width * rows).map(|k| (k as i16).wrapping_mul(20_011));
                let waves = (0..width * rows).map(|k| (8000.0 * (0.3 * k as f64).cos()) as i16);
                for values in [jumps.collect::<Vec<_>>(), waves.collect()] {
                    let coded: Vec<u16> = differences(&values, width, parts).collect();
                    assert_eq!(added_up(&coded, width, parts), values);
                }
            }
        }
    }

    /// Differences of values on a plane are 0.
    #[test]
    fn differences_of_a_plane_are_small() {
        let values: Vec<i16> = (0..60).map(|k| 100 * (k / 10) - 7 * (k % 10) + 3).collect();
        let coded: Vec<u16> = differences(&values, 10, 1).collect();
        // Beyond the first two columns a plane has no second differences.
        let beyond = coded.iter().enumerate().filter(|(k, _)| k % 10 > 1);
        assert!(beyond.clone().count() == 48 && beyond.clone().all(|(_, &d)| d == 0));
    }
}
