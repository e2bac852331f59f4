//! What random dihedral errors cost: the spread of eta and of MTF50 over random cells.
//!
//! Each cube of a random cell has three independent errors from a normal distribution. The MTF is
//! that of wave optics ([`tables::WaveLine`]): ray shift, diffraction and the directions of the
//! orders of facets.

use crate::beams::Returned;
use crate::cell::{ExactCell, Part};
use crate::datasheet::bend::Corner;
use crate::datasheet::request::DatasheetRequest;
use crate::datasheet::surface::Surface;
use crate::geometry::{Stream, centred};
use crate::optics::Rules;
use std::f64::consts::TAU;
use tables::WaveLine;
use tables::options::Sampler;

/// Steps of the search for MTF50 in one period of each of the three things that blur.
const STEPS: f64 = 64.0;

/// Largest number of steps of the search.
const MOST_STEPS: usize = 4096;

/// Spread of a quantity over random cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Smallest value.
    pub least: f64,
    /// Mean.
    pub mean: f64,
    /// Largest value.
    pub largest: f64,
    /// Standard deviation of one cell.
    pub standard_deviation: f64,
}

impl Spread {
    /// Returns the spread of some values, or `None` without any.
    pub(crate) fn of(values: &[f64]) -> Option<Spread> {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        (!values.is_empty()).then(|| Spread {
            least: values.iter().copied().fold(f64::INFINITY, f64::min),
            mean,
            largest: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            standard_deviation: (squares / (count - 1.0).max(1.0)).sqrt(),
        })
    }
}

/// Eta and MTF50 with and without random dihedral errors, in one direction and on one surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Tolerance {
    /// Surface of the facets.
    pub surface: Surface,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Eta of the cell as it is.
    pub eta: f64,
    /// MTF50 of the cell as it is, tangential and sagittal, 1/mm; `None` if nothing returns, or if
    /// the facets are no corner cubes.
    pub mtf50_per_mm: [Option<f64>; 2],
    /// Spread of eta over the random cells; `None` if dihedral errors have no meaning for the cell.
    pub eta_spread: Option<Spread>,
    /// Spread of MTF50 over the random cells that have one, 1/mm.
    pub mtf50_spread: [Option<Spread>; 2],
    /// MTF50 of a sheet that holds all the random cells, 1/mm.
    pub mtf50_of_sheet: [Option<f64>; 2],
}

/// Random cells: the parts of one cell with random dihedral errors.
///
/// Returns `None` if a part has not exactly one corner. `seed` chooses the errors, whose standard
/// deviation is `error_rad`.
pub(crate) fn random_cells(
    parts: &[Part],
    corners: &[Corner],
    request: &DatasheetRequest,
) -> Option<Vec<ExactCell>> {
    let stream = Stream::new(Sampler::Random, request.seed, 0.0, 0.0, 0);
    let error_rad = 1e-3 * request.error_mrad;
    let cell = |number: u64| {
        let bend = |(k, (part, corner)): (usize, (&Part, &Corner))| {
            let first = 2 * (number * parts.len() as u64 + k as u64);
            let [[a, b], [c, _]] = [first, first + 1].map(|index| normals(stream.pair(index)));
            corner.bent(part, [a, b, c].map(|x| x * error_rad))
        };
        let bent = parts.iter().zip(corners).enumerate().map(bend);
        ExactCell::new(&bent.collect::<Option<Vec<Part>>>()?).ok()
    };
    (0..u64::from(request.cells)).map(cell).collect()
}

/// Returns two independent numbers of a normal distribution (Box and Muller 1958).
fn normals(pair: [u32; 2]) -> [f64; 2] {
    let [u, v] = pair.map(|cell| 0.5 + centred(cell));
    let radius = (-2.0 * libm::log(u)).sqrt();
    let (sine, cosine) = libm::sincos(TAU * v);
    [radius * cosine, radius * sine]
}

impl Tolerance {
    /// Computes eta and MTF50 of the cell `nominal` and of `random` cells.
    pub(crate) fn new(
        nominal: &ExactCell,
        random: Option<&[ExactCell]>,
        (surface, rules): (Surface, &Rules),
        request: &DatasheetRequest,
        (incidence_deg, c_mm): (f64, f64),
    ) -> Tolerance {
        let direction = [incidence_deg, request.azimuth_deg];
        let see = |cell: &ExactCell| Returned::new(cell, rules, direction, request.wavelength_nm);
        let lengths = [c_mm, request.distance_mm];
        let own = see(nominal);
        let all: Vec<Returned> = random.unwrap_or_default().iter().map(see).collect();
        let etas: Vec<f64> = all.iter().map(|seen| seen.eta).collect();
        let of_cells = |k: usize| -> Vec<f64> {
            let each = all.iter().map(std::slice::from_ref);
            each.filter_map(|cell| mtf50(cell, k, lengths)).collect()
        };
        Tolerance {
            surface,
            incidence_deg,
            eta: own.eta,
            mtf50_per_mm: [0, 1].map(|k| mtf50(std::slice::from_ref(&own), k, lengths)),
            eta_spread: random.and_then(|_| Spread::of(&etas)),
            mtf50_spread: [0, 1].map(|k| Spread::of(&of_cells(k))),
            mtf50_of_sheet: [0, 1].map(|k| mtf50(&all, k, lengths)),
        }
    }
}

/// Returns the smallest frequency at which the MTF of all these cells together is below 1/2, 1/mm.
///
/// Cells add incoherently, each weighted by its eta. The search goes up in steps of a 64th of the
/// shortest period of shift, deviation and diffraction, and halves the step in which the MTF passes
/// 1/2. Returns `None` if no cell returns light, or one of them has no waves.
fn mtf50(cells: &[Returned], normal: usize, [c_mm, r_mm]: [f64; 2]) -> Option<f64> {
    let lit = || cells.iter().filter(|seen| seen.eta > 0.0);
    let total: f64 = lit().map(|seen| seen.eta).sum();
    let lines = lit().map(|seen| Some((seen.eta / total, seen.lines[normal].as_ref()?)));
    let lines: Vec<(f64, &WaveLine)> = lines.collect::<Option<_>>()?;
    if lines.is_empty() {
        return None;
    }
    let most = |of: &dyn Fn(&Returned) -> f64| lit().map(of).fold(0.0, f64::max);
    let deviation = most(&|seen| seen.deviation);
    let highest = most(&|seen| seen.highest_frequency(c_mm, r_mm));
    let mtf = |frequency: f64| {
        let otf = lines.iter().map(|(share, line)| {
            let (otf, _) = line.otf(c_mm, r_mm, frequency);
            otf * *share
        });
        otf.sum::<num_complex::Complex64>().norm()
    };
    // Shifts of a cube reach some three edge lengths from side to side.
    let period = 1.0 / (3.0 * c_mm + 2.0 * r_mm * deviation);
    let step = period.min(highest) / STEPS;
    let above = (1..=MOST_STEPS).find(|&k| mtf(k as f64 * step) < 0.5)?;
    let [mut low, mut high] = [above - 1, above].map(|k| k as f64 * step);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        match mtf(middle) < 0.5 {
            true => high = middle,
            false => low = middle,
        }
    }
    Some(0.5 * (low + high))
}
