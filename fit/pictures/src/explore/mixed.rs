//! Spots mixed from the nodes of a grid, computed as the page computes them, and the error of that.

use std::f64::consts::PI;
use std::sync::Arc;

use estimator::model::Lobe;
use num_complex::Complex64;
use rayon::prelude::*;
use tables::polygon;
use transforms::Real;

use crate::error::Error;
use crate::explore::gaps::Patch;
use crate::explore::grid::{Grid, UNIT};
use crate::explore::lattice::{Lattice, kinked};
use crate::explore::scaling::Scaling;
use crate::explore::stencil::Share;
use crate::explore::unit::tilt;
use crate::images::progress::Pieces;
use crate::images::sheet::spot_of;
use crate::images::{RenderProgress, TAIL, Viewpoint};
use edges::names::{Kernel, LobeShape};
use edges::numerics::lagrange;
use edges::numerics::sinc;
use estimator::Error as PredictError;
use estimator::model::{Baseline, Blur};
use estimator::predict::Fitted;

/// Sheet whose shift or waves are mixed from the nodes of a grid.
#[derive(Clone, Copy)]
pub(crate) struct Mixed<'a> {
    /// Parameters, and the table that the grid was computed from.
    pub sheet: Fitted<'a>,
    /// Transforms of the shift.
    pub grid: &'a Grid,
    /// Number of times that its waves are longer than those of the grid, see
    /// [`stretches`](crate::explore::scaling::stretches).
    pub stretch: f64,
}

/// Image of a point at one place, by [`Mixed`].
struct MixedSpot {
    kernel: Kernel,
    shape: LobeShape,
    blur: Blur,
    r_mm: f64,
    incidence_rad: f64,
    refractive_index: f64,
    /// Light that returns, before mu and half mirror; 0 where a mixture is too faint to be told
    /// from nothing.
    light: f64,
    shift: Shift,
    /// Light by patches, in edge lengths, in place of `shift`.
    patches: Option<Vec<Patch>>,
    /// Tangential and sagittal size of an edge length, mm.
    edge_mm: [f64; 2],
    reach_mm: f64,
}

/// Mixture of the transforms around one place.
struct Shift {
    /// Highest frequency, 1/mm.
    end: f64,
    /// Factor of tangential frequencies, see [`tilt`].
    tilt: f64,
    /// Slope of the kink of waves, mm.
    kink: f64,
    /// Mixture over the directions, for each state.
    states: Vec<(Lattice, Vec<Complex64>)>,
}

/// Light below which nothing returns, as a share. A mixture of nodes without light and with a
/// little can be negative.
pub(crate) const FAINT: f64 = 1e-4;

impl Mixed<'_> {
    /// Mixes the spot at a place.
    fn spot(&self, place: &Viewpoint) -> Result<MixedSpot, PredictError> {
        let Fitted { result, table } = self.sheet;
        let blur = self.sheet.blur(place.incidence_deg)?;
        let edge_mm = [
            blur.c_mm * place.incidence_deg.to_radians().cos(),
            blur.c_mm,
        ];
        let patches = self.patches(place, edge_mm);
        let (shift, light, reach) = match &patches {
            Some(patches) => gathered(patches),
            None => self.mixture(place, blur.c_mm),
        };
        let mut spot = MixedSpot {
            kernel: result.kernel,
            shape: result.lobe.unwrap_or(LobeShape::Radial),
            blur,
            r_mm: place.r_mm,
            incidence_rad: place.incidence_deg.to_radians(),
            refractive_index: table.provenance.refractive_index,
            light: if light > FAINT { light } else { 0.0 },
            shift,
            patches,
            edge_mm,
            reach_mm: 0.0,
        };
        let waves = spot.shift.kink / (PI * PI * TAIL);
        spot.reach_mm = reach * blur.c_mm + spot.lobe_reach_mm() + waves;
        Ok(spot)
    }

    /// Returns the light at a place by patches, if the grid holds paths.
    fn patches(&self, place: &Viewpoint, edge_mm: [f64; 2]) -> Option<Vec<Patch>> {
        let gaps = self.grid.gaps.as_ref()?;
        let azimuth_deg = place.azimuth_deg.unwrap_or(self.grid.azimuth.first);
        let (azimuth_deg, mirrored) = self.grid.azimuth.fold(azimuth_deg);
        let per_tangent = edge_mm.map(|edge| place.r_mm / edge);
        let mut patches = gaps.patches([place.incidence_deg, azimuth_deg], per_tangent);
        if mirrored {
            let corners = patches.iter_mut().flat_map(|patch| &mut patch.corners);
            corners.for_each(|corner| corner[1] = -corner[1]);
        }
        Some(patches)
    }

    /// Returns the shift at a place, the light that returns and the reach in edge lengths.
    fn mixture(&self, place: &Viewpoint, c_mm: f64) -> (Shift, f64, f64) {
        let grid = self.grid;
        let along = grid.incidence.mixture(place.incidence_deg);
        let around = match place.azimuth_deg {
            Some(azimuth_deg) if grid.azimuth.count > 1 => grid.azimuth.mixture(azimuth_deg),
            _ => vec![Share::ALL],
        };
        let scaling = self.stretch * grid.scaling.of(place.r_mm, c_mm);
        let states = match grid.scaling {
            Scaling::Fixed => vec![Share::ALL],
            _ => grid
                .state
                .mixture(grid.scaling.coordinate(scaling, grid.bend)),
        };
        let parts = if grid.real { 1 } else { 2 };
        let ends: Vec<usize> = (grid.lattices.iter())
            .scan(0, |end, lattice| {
                *end += lattice.count() * parts;
                Some(*end)
            })
            .collect();
        let per_direction = ends[ends.len() - 1];
        let (mut light, mut reach) = (0.0, 0.0_f64);
        let mut mixed: Vec<(Lattice, Vec<Complex64>)> = (states.iter())
            .map(|state| grid.lattices[state.node])
            .map(|lattice| (lattice, vec![Complex64::ZERO; lattice.count()]))
            .collect();
        for a in &along {
            for b in &around {
                let direction = a.node * grid.azimuth.count + b.node;
                let share = a.weight * b.weight * grid.energy[direction];
                light += share;
                if share == 0.0 {
                    continue;
                }
                for (c, (lattice, values)) in states.iter().zip(&mut mixed) {
                    reach = reach.max(grid.reach[direction * grid.state.count + c.node]);
                    let columns = lattice.size()[0];
                    let size = lattice.count() * parts;
                    let start = direction * per_direction + ends[c.node] - size;
                    let own = &grid.values[start..][..size];
                    let share = share * c.weight / UNIT;
                    for (k, value) in values.iter_mut().enumerate() {
                        // In a mirror the sagittal frequency changes its sign: the transform at
                        // (x, -y) is the conjugate of that at (-x, y).
                        let (at, sign) = match b.mirrored {
                            true => (k - k % columns + columns - 1 - k % columns, -1.0),
                            false => (k, 1.0),
                        };
                        let part = |i: usize| f64::from(own[at * parts + i]);
                        let imaginary = if grid.real { 0.0 } else { sign * part(1) };
                        *value += Complex64::new(part(0), imaginary) * share;
                    }
                }
            }
        }
        let all = mixed.iter_mut().flat_map(|(_, values)| values);
        all.for_each(|value| *value /= light.max(FAINT));
        let shift = Shift {
            end: grid.ends.at(scaling) / c_mm,
            tilt: tilt(self.sheet.result.kernel, place.incidence_deg),
            kink: grid.kink * scaling * c_mm,
            states: mixed,
        };
        (shift, light, reach)
    }
}

/// Returns no shift, the light of all patches, and how far they reach, edge lengths.
fn gathered(patches: &[Patch]) -> (Shift, f64, f64) {
    let corners = patches.iter().flat_map(|patch| &patch.corners);
    let reach = corners
        .map(|corner| corner[0].hypot(corner[1]))
        .fold(0.0, f64::max);
    let none = Shift {
        end: f64::INFINITY,
        tilt: 1.0,
        kink: 0.0,
        states: vec![(Lattice::NONE, Vec::new())],
    };
    (none, patches.iter().map(|patch| patch.light).sum(), reach)
}

/// Returns the transform E[exp(-2 pi i f.x)] of light that is spread evenly over a polygon.
///
/// By Gauss's theorem it is a sum over the edges.
fn transform(corners: &[[f64; 2]], f: [f64; 2]) -> Complex64 {
    let squared = f[0] * f[0] + f[1] * f[1];
    let area = polygon::area(corners);
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    // Rounding is 1e-16 / (f size)^2; the first two terms of the series err by less than that.
    let size = corners
        .iter()
        .map(|own| own[0].hypot(own[1]))
        .fold(0.0, f64::max);
    if squared.sqrt() * size < 1e-4 {
        let count = corners.len() as f64;
        let middle = [0, 1].map(|k| corners.iter().map(|own| own[k]).sum::<f64>() / count);
        return Complex64::cis(-2.0 * PI * (f[0] * middle[0] + f[1] * middle[1]));
    }
    let sum: Complex64 = ends
        .map(|(a, b)| {
            let edge = [b[0] - a[0], b[1] - a[1]];
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let along = PI * (f[0] * edge[0] + f[1] * edge[1]);
            let turn = Complex64::cis(-2.0 * PI * (f[0] * middle[0] + f[1] * middle[1]));
            turn * ((f[0] * edge[1] - f[1] * edge[0]) * sinc(along))
        })
        .sum();
    sum * Complex64::I / (2.0 * PI * squared * area)
}

impl MixedSpot {
    /// Returns the rough facets along one direction of the image; `None` for the other kernels.
    fn facets(&self, normal: [f64; 2]) -> Option<Baseline> {
        Baseline::new(
            self.kernel,
            self.incidence_rad,
            self.refractive_index,
            normal,
        )
    }

    /// Returns a of the lobe, 1/mm.
    fn a(&self) -> f64 {
        self.blur.spread / self.kernel.distance_scale(self.r_mm)
    }

    /// Returns how far the lobe reaches, mm.
    fn lobe_reach_mm(&self) -> f64 {
        let axes = [[1.0, 0.0], [0.0, 1.0]].map(|normal| self.facets(normal));
        if let [Some(tangential), Some(sagittal)] = axes {
            let reach = |own: Baseline| own.reach_mm(self.shape, self.blur, self.r_mm, TAIL);
            return reach(tangential).max(reach(sagittal));
        }
        match self.kernel.has_lobe() {
            true => self.shape.reach_mm(self.a(), TAIL),
            false => 0.0,
        }
    }

    /// Evaluates the transfer of the lobe.
    fn lobe(&self, frequency: [f64; 2]) -> f64 {
        let modulus = frequency[0].hypot(frequency[1]);
        let normal = match modulus > 0.0 {
            true => frequency.map(|f| f / modulus),
            false => [1.0, 0.0],
        };
        match self.facets(normal) {
            Some(facets) => facets.otf(self.shape, self.blur, self.r_mm, modulus)[0].re,
            None if self.kernel.has_lobe() => self.shape.otf(self.a(), modulus, normal).0,
            None => 1.0,
        }
    }

    /// Evaluates the OTF at a frequency (tangential, sagittal), 1/mm.
    fn otf(&self, frequency: [f64; 2]) -> Complex64 {
        let Some(patches) = &self.patches else {
            return self.shift.at(frequency) * self.lobe(frequency);
        };
        let per_edge = [0, 1].map(|k| frequency[k] * self.edge_mm[k]);
        let all = patches.iter();
        let sum: Complex64 = all
            .map(|own| own.light * transform(&own.corners, per_edge))
            .sum();
        sum / self.light.max(FAINT) * self.lobe(frequency)
    }
}

impl Shift {
    /// Interpolates the transform at a frequency, 1/mm; 0 beyond the end.
    fn at(&self, frequency: [f64; 2]) -> Complex64 {
        if self.states[0].0.points == 0 {
            return Complex64::ONE;
        }
        if frequency[1] < 0.0 {
            return self.at(frequency.map(|f| -f)).conj();
        }
        // States are mixed at the same share of their ends.
        let share = [frequency[0] * self.tilt, frequency[1]].map(|f| f / self.end);
        if share[0].abs() > 1.0 || share[1] > 1.0 {
            return Complex64::ZERO;
        }
        let states = self.states.iter();
        let smooth: Complex64 = states
            .map(|(lattice, values)| interpolated(lattice, values, share))
            .sum();
        smooth * kinked(self.kink, frequency)
    }
}

/// Interpolates on one lattice at a frequency that is given as a share of its end.
fn interpolated(lattice: &Lattice, values: &[Complex64], share: [f64; 2]) -> Complex64 {
    let [x, y] = share.map(|share| share * lattice.points as f64);
    let (left, top) = (x.floor(), y.floor());
    let (across, down) = (lagrange(x - left), lagrange(y - top));
    let (columns, zero) = (lattice.size()[0], lattice.zero());
    let first = (left as i64 + zero[0] as i64 - 2) as usize;
    let mut sum = Complex64::ZERO;
    for (i, weight) in down.iter().enumerate() {
        let row = (top as usize + zero[1] - 2 + i) * columns + first;
        let values = values[row..].iter().zip(&across);
        let part: Complex64 = values.map(|(value, weight)| value * weight).sum();
        sum += part * weight;
    }
    sum
}

/// Error of mixing at one place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Misfit {
    /// Largest error of a pixel in any picture, in units of the brightest pixel of an image at the
    /// brightest direction.
    ///
    /// Light is not negative, so it is the sum of the positive or of the negative differences of
    /// all weights: that of a picture which is bright just where they are.
    pub pixel: f64,
    /// Largest difference of a weight, in units of the largest weight at the brightest direction.
    pub peak: f64,
}

impl Misfit {
    /// Returns the larger of the two numbers.
    pub(crate) fn larger(self) -> f64 {
        self.pixel.max(self.peak)
    }

    /// Returns the larger of both in each number.
    pub(crate) fn or(self, other: Misfit) -> Misfit {
        Misfit {
            pixel: self.pixel.max(other.pixel),
            peak: self.peak.max(other.peak),
        }
    }
}

/// Points of the transforms along each axis in which errors are measured.
const POINTS: usize = 48;

/// Returns the largest misfit of a mixture from the sheet itself over some places.
///
/// # Errors
/// Returns [`Error::Sheet`] if the blur cannot be computed at a place.
pub(crate) fn misfit(
    mixed: &Mixed<'_>,
    places: &[Viewpoint],
    progress: RenderProgress<'_>,
) -> Result<Misfit, Error> {
    let brightest = mixed.grid.energy.iter().copied().fold(0.0, f64::max);
    if brightest <= 0.0 {
        return Ok(Misfit::default());
    }
    let pieces = Pieces::new(progress, "places", places.len());
    let all = places.par_iter().map(|place| {
        let own = misfit_at(mixed, place, brightest);
        pieces.one();
        own
    });
    all.try_reduce(Misfit::default, |a, b| Ok(a.or(b)))
}

/// Returns the misfit at one place.
///
/// The differences of both point spreads are computed on a period that holds all but their tails.
/// Tails that come round only add to them.
fn misfit_at(mixed: &Mixed<'_>, place: &Viewpoint, brightest: f64) -> Result<Misfit, Error> {
    let blur = mixed.sheet.blur(place.incidence_deg)?;
    let found = mixed.spot(place)?;
    // The tails of waves and of the separable lobe are far wider than the blur itself.
    let widest = 3.0 * blur.c_mm + 5.0 / core(mixed, &blur, place);
    let period = 2.0 * found.reach_mm.min(widest).max(1e-9);
    let step = 1.0 / period;
    let table = mixed.sheet.table;
    let direction = table
        .direction(place.incidence_deg, place.azimuth_deg)
        .map_err(PredictError::from)?;
    let own = mixed
        .sheet
        .returned(place.incidence_deg, direction.retroreflected);
    let (finest, lines) = (step * POINTS as f64, Arc::default());
    let truth = spot_of(&mixed.sheet, direction, place, finest, Some(&lines))?;
    // Squares of light: what lies beyond the frequencies is damped by them.
    let half = POINTS as i64 / 2;
    let damped = |k: i64| sinc(PI * k as f64 / POINTS as f64).powi(2);
    let mut off = vec![Complex64::ZERO; POINTS * POINTS];
    let mut whole = off.clone();
    let place = |x: i64, y: i64| {
        let [x, y] = [x, y].map(|k| k.rem_euclid(POINTS as i64) as usize);
        y * POINTS + x
    };
    // Light is real: the other half of the frequencies are the conjugates of these.
    for y in 0..half {
        let first = if y > 0 { 1 - half } else { 0 };
        for x in first..half {
            let frequency = [x, y].map(|k| step * k as f64);
            let weight = damped(x) * damped(y);
            let exact = truth.otf(frequency) * own;
            let difference = (found.otf(frequency) * found.light - exact) * weight;
            (off[place(-x, -y)], off[place(x, y)]) = (difference.conj(), difference);
            let exact = exact * weight;
            (whole[place(-x, -y)], whole[place(x, y)]) = (exact.conj(), exact);
        }
    }
    let differences = spread_of(off);
    let peak = spread_of(whole).into_iter().fold(0.0, f64::max);
    let scale = if own > 0.0 { brightest / own } else { 1.0 };
    let above: f64 = differences.iter().map(|v| v.max(0.0)).sum();
    let below: f64 = differences.iter().map(|v| (-v).max(0.0)).sum();
    let largest = differences.iter().map(|v| v.abs()).fold(0.0, f64::max);
    Ok(Misfit {
        pixel: above.max(below) / brightest,
        peak: if peak > 0.0 {
            largest / (peak * scale)
        } else {
            0.0
        },
    })
}

/// Transforms a spectrum of [`POINTS`] by [`POINTS`] frequencies into weights.
fn spread_of(mut spectrum: Vec<Complex64>) -> Vec<f64> {
    let inverse = f64::complex_inverse(POINTS);
    for _ in 0..2 {
        spectrum
            .chunks_exact_mut(POINTS)
            .for_each(|row| inverse.process(row));
        spectrum = (0..POINTS * POINTS)
            .map(|k| spectrum[k % POINTS * POINTS + k / POINTS])
            .collect();
    }
    let scale = 1.0 / (POINTS * POINTS) as f64;
    spectrum.into_iter().map(|value| value.re * scale).collect()
}

/// Returns the frequency scale of the lobe or of the waves, 1/mm; infinite without either.
fn core(mixed: &Mixed<'_>, blur: &Blur, place: &Viewpoint) -> f64 {
    let result = mixed.sheet.result;
    match &result.wavelength_nm {
        Some(spectrum) if result.kernel.has_waves() => {
            let lines = spectrum.lines().iter().map(|line| line.wavelength_nm);
            blur.c_mm / (lines.fold(0.0, f64::max) * 1e-6 * place.r_mm)
        }
        _ if result.kernel.is_baseline() => 1.0 / (2.0 * blur.spread * place.r_mm),
        _ if result.kernel.has_lobe() => blur.spread / result.kernel.distance_scale(place.r_mm),
        _ => f64::INFINITY,
    }
}

/// Returns the misfit of a grid at some places, for tests.
#[cfg(test)]
pub(crate) fn misfit_of(
    sheet: &Fitted<'_>,
    grid: &Grid,
    places: &[Viewpoint],
) -> Result<Misfit, Error> {
    let mixed = Mixed {
        sheet: *sheet,
        grid,
        stretch: 1.0,
    };
    misfit(&mixed, places, crate::images::SILENT)
}
