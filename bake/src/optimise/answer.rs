//! The search for the best cell, its check by rays, and what small errors cost.

use crate::datasheet::Surface;
use crate::error::Error;
use crate::optimise::candidate::{Candidate, Quality, Values};
use crate::optimise::evolve::{Member, Merit, evolve, undominated};
use crate::optimise::goal::{Best, Goal, Parameter};
use crate::plan::{Plan, Request};
use crate::run::{Comparison, Progress, trace};
use meshes::design::Shape;
use meshes::{CellOptions, Mesh};
use std::sync::atomic::{AtomicU64, Ordering};
use tables::options::{Back, Losses, Method};

/// Rays in each direction of the check.
const RAYS: u64 = 1 << 18;

/// Part of a parameter by which it is wrong in the answer.
const PART: f64 = 0.01;

/// Dihedral error in the answer, mrad.
const ERROR_MRAD: f64 = 1.0;

/// Cell of the answer.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Winner {
    /// Cell.
    pub cell: Candidate,
    /// How good it is.
    pub quality: Quality,
}

/// Eta of the best cell by polygons and by rays, in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Check {
    /// Incidence and azimuth, degrees.
    pub direction_deg: [f64; 2],
    /// Eta by polygons.
    pub eta: f64,
    /// Eta by rays.
    pub by_rays: f64,
    /// Standard error of eta by rays.
    pub standard_error: f64,
    /// Whether eta, all fates and the ray shifts agree within the errors of counting.
    pub agrees: bool,
}

/// What one small error costs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Loss {
    /// Name of what is wrong.
    pub what: &'static str,
    /// Size of the error, in the unit of the name.
    pub step: f64,
    /// Change of the MTF, the worse of both signs.
    pub mtf: f64,
    /// Change of eta, the worse of both signs.
    pub luminance: f64,
}

/// What became of a design of the goal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fate {
    /// Design.
    pub shape: Shape,
    /// Number of its cells on the front.
    pub on_front: usize,
    /// The largest of each quantity that is wanted, over its cells that meet the conditions; `None`
    /// if none does.
    pub best: Option<Vec<f64>>,
}

/// The best cell, or the front.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Answer {
    /// Cells that no other one is better than in everything, the brightest first. It is one cell if
    /// one quantity is wanted.
    pub front: Vec<Winner>,
    /// Place of the best cell on the front.
    pub best: usize,
    /// What became of each design, in the order of the goal.
    pub fates: Vec<Fate>,
    /// Mesh of the best cell, mm.
    pub mesh: Mesh,
    /// Number of cells that were tried.
    pub tried: u64,
    /// Check by rays.
    pub checks: Vec<Check>,
    /// What small errors of the best cell cost.
    pub losses: Vec<Loss>,
}

impl Answer {
    /// Says which parameters of the written cell, and of both ends of the front, lie at an end of
    /// their range, beyond which a better cell may lie.
    pub(crate) fn at_ends(&self, goal: &Goal) -> Vec<String> {
        // Share of a range that the search does not resolve.
        const NEAR: f64 = 1e-3;
        let last = self.front.len() - 1;
        let cells = [
            (self.best, ""),
            (0, "brightest cell: "),
            (last, "sharpest cell: "),
        ];
        let mut said: Vec<(&str, String)> = Vec::new();
        for (place, whose) in cells {
            let cell = &self.front[place].cell;
            for (place, [from, to]) in Candidate::varied(cell.shape, &goal.ranges) {
                let value = cell.values[place];
                let name = Parameter::ALL[place].name();
                let is_near = (value - from).min(to - value) < NEAR * (to - from);
                if is_near && said.iter().all(|(own, _)| *own != name) {
                    let sentence = format!(
                        "{whose}{name} = {value:.4} lies at an end of its range {from} to {to}: a \
                        wider range may hold a better cell"
                    );
                    said.push((name, sentence));
                }
            }
        }
        said.into_iter().map(|(_, sentence)| sentence).collect()
    }

    /// Says which cell to take if one of both quantities hardly varies along the front.
    pub(crate) fn advice(&self) -> Option<String> {
        // Variation that nobody sees, as a share.
        const HARDLY: f64 = 0.01;
        let variation = |of: fn(&Quality) -> f64| {
            let values = || self.front.iter().map(|own| of(&own.quality));
            let most = values().fold(f64::NEG_INFINITY, f64::max);
            1.0 - values().fold(f64::INFINITY, f64::min) / most
        };
        let (mtf, luminance) = (variation(|own| own.mtf), variation(|own| own.luminance));
        let (least, name, take) = match mtf <= luminance {
            true => (mtf, "MTF", "brightest (best = \"luminance\")"),
            false => (luminance, "luminance", "sharpest (best = \"mtf\")"),
        };
        (self.front.len() > 1 && least < HARDLY).then(|| {
            let percent = 100.0 * least;
            format!("{name} varies by {percent:.1} % along the front: take the {take}")
        })
    }
}

/// Searches the best cell of a goal. `progress` is told the cells that were tried.
///
/// # Errors
/// Returns an [`Error`] if no cell keeps the frequencies visible or returns light, if a cell of the
/// answer cannot be made, or if the caller stopped the work.
pub(crate) fn optimise(goal: &Goal, progress: Progress<'_>) -> Result<Answer, Error> {
    let tried = AtomicU64::new(0);
    let done = |cells: u64| {
        tried.fetch_add(cells, Ordering::Relaxed);
        progress.tell(cells);
    };
    let budget = goal.cells / goal.shapes.len() as u64;
    let mut found: Vec<(Candidate, Merit)> = Vec::new();
    let mut fates = Vec::new();
    for &shape in &goal.shapes {
        let dimensions = Candidate::varied(shape, &goal.ranges).len();
        let merit = |shares: &[f64]| {
            let cell = Candidate::at(shape, &goal.ranges, shares);
            let quality = (!progress.is_stopped()).then(|| cell.quality(goal).ok());
            quality.flatten().unwrap_or(Quality::NONE).merit(goal)
        };
        let front = evolve(dimensions, budget, goal.seed, &merit, &done);
        fates.push(Fate {
            shape,
            on_front: 0,
            best: largest(&front),
        });
        let cells = front.into_iter();
        found.extend(cells.map(|(shares, merit)| {
            let cell = Candidate::at(shape, &goal.ranges, &shares);
            (cell, merit)
        }));
        if progress.is_stopped() {
            return Err(Error::Stopped);
        }
    }
    let front = undominated(found, |(_, merit)| merit).into_iter();
    let winner = |(cell, _): (Candidate, Merit)| {
        let quality = cell.quality(goal)?;
        Ok(Winner { cell, quality })
    };
    let mut front = front.map(winner).collect::<Result<Vec<Winner>, Error>>()?;
    front.sort_by(|a, b| b.quality.luminance.total_cmp(&a.quality.luminance));
    for fate in &mut fates {
        let own = front.iter().filter(|own| own.cell.shape == fate.shape);
        fate.on_front = own.count();
    }
    let best = compromise(goal, &front);
    let Winner { cell, quality } = front[best];
    if quality.least < goal.least_mtf {
        return Err(Error::Failed(format!(
            "no cell keeps every frequency visible: the nearest one, {}, has an MTF of {:.4} where \
            `least_mtf` is {}; lower `least_mtf`, the frequencies or the incidences, or widen \
            the ranges of [sheet]",
            cell.words(),
            quality.least,
            goal.least_mtf
        )));
    }
    // The cell as it is read from the file. Prisms need their index again: no mesh states it.
    let mut mesh = cell.mesh()?;
    mesh.hollow = cell.value(Parameter::Index) == 1.0;
    let text = meshes::write::obj(&mesh);
    let mesh =
        meshes::obj::parse(text.as_bytes()).map_err(|fault| Error::Failed(fault.to_string()))?;
    Ok(Answer {
        checks: checks(goal, &cell, &mesh)?,
        losses: losses(goal, &cell, quality),
        mesh,
        front,
        best,
        fates,
        tried: tried.into_inner(),
    })
}

/// Returns the largest of each quantity over the cells that lack nothing; `None` without any.
fn largest(front: &[Member]) -> Option<Vec<f64>> {
    let whole = front.iter().filter(|(_, merit)| merit.lack == 0.0);
    let values = whole.map(|(_, merit)| merit.values.clone());
    values.reduce(|a, b| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect())
}

/// Returns the place of the cell of a front that is nearest to the best of both, where the front
/// from end to end counts as 1 along each axis.
fn compromise(goal: &Goal, front: &[Winner]) -> usize {
    let axis = |of: fn(&Quality) -> f64| {
        let values = || front.iter().map(|own| of(&own.quality));
        let least = values().fold(f64::INFINITY, f64::min);
        let width = values().fold(f64::NEG_INFINITY, f64::max) - least;
        move |quality: &Quality| match width > 0.0 {
            true => 1.0 - (of(quality) - least) / width,
            false => 0.0,
        }
    };
    let (mtf, luminance) = (axis(|own| own.mtf), axis(|own| own.luminance));
    let distance = |own: &Winner| match goal.best {
        Best::Mtf => mtf(&own.quality),
        Best::Luminance => luminance(&own.quality),
        Best::Both => mtf(&own.quality).hypot(luminance(&own.quality)),
    };
    let places = 0..front.len();
    let nearest = places.min_by(|&a, &b| distance(&front[a]).total_cmp(&distance(&front[b])));
    nearest.unwrap_or(0)
}

/// Traces the best cell again by rays, and compares every direction with the polygons.
fn checks(goal: &Goal, cell: &Candidate, mesh: &Mesh) -> Result<Vec<Check>, Error> {
    let cell_of_file = meshes::normalise(mesh, "best.obj".as_ref(), &CellOptions::default())?;
    let prepared = crate::cell::Prepared::new(cell_of_file);
    let list = |degrees: &[f64]| {
        let words: Vec<String> = degrees.iter().map(f64::to_string).collect();
        words.join(",")
    };
    let mut checks: Vec<Check> = Vec::new();
    for [incidence, azimuth] in &goal.directions {
        let request = Request {
            incidence: list(incidence),
            azimuth: list(azimuth),
            refractive_index: Some(cell.value(Parameter::Index)),
            back: match goal.surface {
                Surface::TotalReflection => Back::Tir,
                _ => Back::Mirror,
            },
            losses: match goal.surface {
                Surface::Mirrors => Losses::None,
                _ => Losses::Fresnel,
            },
            metal: (goal.surface == Surface::Metal).then_some(goal.metal),
            wavelength_nm: Some(goal.wavelength_nm),
            rays: Some(RAYS),
            seed: goal.seed,
            ..Request::default()
        };
        let bake = |method: Method| {
            let request = Request {
                method,
                ..request.clone()
            };
            trace(&prepared, &Plan::new(&request)?, Progress::none())
        };
        let [exact, rays] = [bake(Method::Exact)?, bake(Method::Rays)?];
        let compared = Comparison::new(&exact, &rays);
        let compared = compared.map_err(|reason| Error::Failed(reason.to_owned()))?;
        let places = exact.retroreflected.indexed_iter();
        for (row, (place, &eta)) in compared.rows.iter().zip(places) {
            let direction_deg = [row.incidence_deg, row.azimuth_deg];
            if checks.iter().all(|own| own.direction_deg != direction_deg) {
                checks.push(Check {
                    direction_deg,
                    eta,
                    by_rays: rays.retroreflected[place],
                    standard_error: rays.standard_error[place],
                    agrees: row.agrees(),
                });
            }
        }
    }
    Ok(checks)
}

/// Returns what 1 % of each parameter costs, and a dihedral error of 1 mrad.
fn losses(goal: &Goal, cell: &Candidate, quality: Quality) -> Vec<Loss> {
    let changed = |places: &[usize], step: f64| {
        let mut values: Values = cell.values;
        places.iter().for_each(|&place| values[place] += step);
        let other = Candidate { values, ..*cell };
        // An error that no cell of this kind can have costs nothing.
        other.quality(goal).unwrap_or(quality)
    };
    let loss = |what: &'static str, places: &[usize], step: f64| {
        let both = [-step, step].map(|step| changed(places, step));
        Loss {
            what,
            step,
            mtf: both[0].mtf.min(both[1].mtf) - quality.mtf,
            luminance: both[0].luminance.min(both[1].luminance) - quality.luminance,
        }
    };
    let mut all = Vec::new();
    let mut errors = Vec::new();
    for (place, parameter) in Parameter::ALL.into_iter().enumerate() {
        if let Parameter::Error(_) = parameter {
            errors.push(place);
            all.push(loss(parameter.name(), &[place], ERROR_MRAD));
            continue;
        }
        let step = PART * cell.values[place].abs();
        if parameter.is_of(cell.shape) && step > 0.0 {
            all.push(loss(parameter.name(), &[place], step));
        }
    }
    all.push(loss("all_dihedral_errors_mrad", &errors, ERROR_MRAD));
    all
}
