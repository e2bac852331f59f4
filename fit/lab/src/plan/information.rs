//! What each photograph that could be taken would tell, at each point of the beliefs.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use tables::Table;

#[cfg(test)]
use crate::plan::request::Beliefs;
use crate::plan::request::{Choices, Edge, Own, Plan};
use crate::plan::{Error, Expected, Photograph};
use crate::simulate::{ByIncidence, Params, PlantedEdge, PlantedSheet, PlantedShot, cell};
use crate::study::{choice, trial};
use edges::names::{Kernel, ParameterId, ParameterKind};
use edges::photographs::edge::fault::Accepted;
use estimator::compare::Photograph as Pixels;
use estimator::estimate::{Aerial, Choice, Conditions, Layout, Scene, model};
use estimator::model::{Camera, Further};
use estimator::result::{Parameter, ResultFile};

/// Bright side of a mid-air photograph, full scale 1.
pub(crate) const BRIGHT: f64 = 0.8;

/// Least share of the light that returns where a photograph is worth while.
const LEAST_ETA: f64 = 0.02;

/// Direction of the edge against the axis that it lies across, degrees.
const TILT_DEG: f64 = 5.0;

/// A photograph that could be taken.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    /// Floating distance, mm.
    pub floating_distance_mm: f64,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees.
    pub azimuth_deg: f64,
    /// Edge.
    pub edge: Edge,
    /// Retroreflected share.
    retroreflected: f64,
    /// Information at each point of the beliefs.
    tells: Vec<Information>,
}

/// Information on the logarithms of c and the spreads, on the lens, and on ln mu and the step of the
/// source edge.
///
/// Each photograph has plateaus of its own, as in the estimate: so blur and lens are told without
/// what ties the steps to each other (`blur`), and mu with it (`whole`).
#[derive(Debug, Clone)]
pub(crate) struct Information {
    /// Of the blur's parameters and the lens.
    pub blur: DMatrix<f64>,
    /// Of all, in the order blur, lens, ln mu (one or more), ln step.
    pub whole: DMatrix<f64>,
}

/// Places of the unknowns.
#[derive(Debug, Clone, Copy)]
struct Unknowns {
    /// Number of those of blur and lens.
    blur: usize,
    /// Number of mu.
    mu: usize,
}

impl Information {
    /// Creates the information of nothing.
    fn none(Unknowns { blur, mu }: Unknowns) -> Information {
        Information {
            blur: DMatrix::zeros(blur, blur),
            whole: DMatrix::zeros(blur + mu + 1, blur + mu + 1),
        }
    }

    /// Adds that of another source.
    pub(crate) fn add(&mut self, other: &Information) {
        self.blur += &other.blur;
        self.whole += &other.whole;
    }

    /// Takes that of another source away.
    pub(crate) fn take(&mut self, other: &Information) {
        self.blur -= &other.blur;
        self.whole -= &other.whole;
    }

    /// Makes it from rows (ln step, derivatives by blur and lens), whose derivatives belong to
    /// `columns`. The step depends on that mu, if on any.
    fn of(
        rows: &DMatrix<f64>,
        columns: &[usize],
        Unknowns { blur, mu: several }: Unknowns,
        mu: Option<usize>,
    ) -> Information {
        let width = blur + several + 1;
        let mut tied = DMatrix::zeros(rows.nrows(), width);
        for (k, &column) in columns.iter().enumerate() {
            tied.set_column(column, &rows.column(k + 1));
        }
        // Without the row of the step, the others tell blur and lens alone.
        let free = tied.view((1, 0), (rows.nrows() - 1, blur)).into_owned();
        tied.set_column(width - 1, &rows.column(0));
        if let Some(mu) = mu {
            tied.set_column(blur + mu, &rows.column(0));
        }
        Information {
            blur: free.tr_mul(&free),
            whole: tied.tr_mul(&tied),
        }
    }
}

/// Everything that could be photographed, with what it would tell.
pub(crate) struct Foreseen<'a> {
    plan: &'a Plan,
    /// Parameters of the blur, then mu.
    pub parameters: Vec<ParameterId>,
    unknowns: Unknowns,
    /// Photographs that could be taken, in the order of the choices.
    pub candidates: Vec<Candidate>,
    /// Number of choices without light.
    pub dark: usize,
    /// Information of the source edge.
    source: Information,
}

impl<'a> Foreseen<'a> {
    /// Computes what each photograph would tell.
    pub(crate) fn new(plan: &'a Plan, table: &Table) -> Result<Foreseen<'a>, Error> {
        let Choices {
            floating_distance_mm,
            incidence_deg,
            azimuth_deg,
            ..
        } = &plan.choices;
        let mut directions = Vec::new();
        for &incidence in incidence_deg {
            for &azimuth in azimuth_deg {
                let eta = table.direction(incidence, Some(azimuth));
                let eta = eta.map_err(estimator::Error::from)?.retroreflected;
                directions.push((incidence, azimuth, eta));
            }
        }
        let all = directions.len();
        directions.retain(|&(.., eta)| eta >= LEAST_ETA);
        let per_direction = floating_distance_mm.len() * plan.choices.edge.len();
        let dark = (all - directions.len()) * per_direction;
        let Some(&(first, turned, _)) = directions.first() else {
            return Err(Error::Dark);
        };
        let pattern = pattern(plan, table, [first, turned])?;
        let mut angles: Vec<f64> = directions
            .iter()
            .map(|&(incidence, ..)| incidence)
            .collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        let own = |own: Own| plan.beliefs.per_angle.contains(&own) && angles.len() > 1;
        let choice = Choice {
            kernel: plan.beliefs.kernel,
            shape: plan.beliefs.lobe,
            per_angle_a: own(Own::A),
            per_angle_mu: own(Own::Mu),
            further: Further::NONE,
        };
        let camera = planted_camera(&pattern, plan);
        let layout = Layout::new(choice, angles.len());
        let unknowns = Unknowns {
            blur: layout.parameters() + pattern.optics.free.len(),
            mu: if own(Own::Mu) { angles.len() } else { 1 },
        };
        let ids = plan.beliefs.parameters().into_iter().flat_map(|kind| {
            let is_own = match kind {
                ParameterKind::CornerSize => false,
                ParameterKind::Mu => own(Own::Mu),
                _ => own(Own::A),
            };
            let at = |&angle: &f64| kind.at(angle);
            match is_own {
                true => angles.iter().map(at).collect(),
                false => vec![kind.shared()],
            }
        });
        let parameters = ids.collect();
        let seen = Seen {
            plan,
            pattern: &pattern,
            camera: &camera,
            layout,
            unknowns,
            angles: &angles,
            points: plan.beliefs.points(),
        };
        let places: Vec<(f64, (f64, f64, f64))> = floating_distance_mm
            .iter()
            .flat_map(|&r| directions.iter().map(move |&direction| (r, direction)))
            .collect();
        let found = places.par_iter().map(|&(r, (incidence, azimuth, eta))| {
            seen.candidates(table, r, [incidence, azimuth], eta)
        });
        let found: Vec<Vec<Candidate>> = found.collect::<Result<_, Error>>()?;
        Ok(Foreseen {
            plan,
            parameters,
            unknowns,
            candidates: found.into_iter().flatten().collect(),
            dark,
            source: seen.source(),
        })
    }

    /// Returns the number of points of the beliefs.
    pub(crate) fn points(&self) -> usize {
        self.candidates[0].tells.len()
    }

    /// Returns what a candidate tells at a point of the beliefs.
    pub(crate) fn tells(&self, candidate: usize, point: usize) -> &Information {
        &self.candidates[candidate].tells[point]
    }

    /// Returns what is known before a photograph of the mid-air edge is taken: the source edge, and
    /// an earlier result.
    pub(crate) fn before(&self, known: Option<&Information>) -> Information {
        let mut all = self.source.clone();
        known.into_iter().for_each(|known| all.add(known));
        all
    }

    /// Returns the photograph of a candidate.
    pub(crate) fn photograph(&self, candidate: usize) -> Photograph {
        let own = &self.candidates[candidate];
        let camera = &self.plan.camera;
        let [low, high] = self.plan.beliefs.mu;
        let half_mirror = camera.half_mirror_transmittance * camera.half_mirror_reflectance;
        let light = camera.source_level * (low * high).sqrt() * half_mirror * own.retroreflected;
        Photograph {
            floating_distance_mm: own.floating_distance_mm,
            incidence_deg: own.incidence_deg,
            azimuth_deg: own.azimuth_deg,
            edge: own.edge,
            exposure: BRIGHT / light,
        }
    }

    /// Returns `count` candidates that are spread evenly over the choices, with the edges in turn.
    pub(crate) fn even(&self, count: usize) -> Vec<usize> {
        let edges = self.plan.choices.edge.len();
        let places = self.candidates.len() / edges;
        // Each edge at as many places, as far from each other as they can be.
        let all = (0..count).map(|k| {
            let of_edge = count / edges + usize::from(k % edges < count % edges);
            let share = ((k / edges) as f64 + 0.5) / of_edge as f64;
            (share * places as f64) as usize * edges + k % edges
        });
        all.collect()
    }

    /// Returns the errors that a choice of candidates leaves.
    pub(crate) fn expected(&self, chosen: &[usize], known: Option<&Information>) -> Vec<Expected> {
        let before = self.before(known);
        let at = |point: usize| -> Vec<f64> {
            let mut all = before.clone();
            for &i in chosen {
                all.add(self.tells(i, point));
            }
            self.errors(&all)
        };
        let errors: Vec<Vec<f64>> = (0..self.points()).map(at).collect();
        let finite = |value: f64| value.is_finite().then_some(value);
        let parameters = self.parameters.iter().enumerate();
        parameters
            .map(|(i, &parameter)| {
                let largest = errors.iter().map(|own| own[i]).fold(0.0, f64::max);
                Expected {
                    parameter,
                    middle: finite(errors[0][i]),
                    largest: finite(largest),
                }
            })
            .collect()
    }

    /// Returns the relative errors of all parameters under some information.
    fn errors(&self, all: &Information) -> Vec<f64> {
        let Unknowns { blur, mu } = self.unknowns;
        let mut errors = deviations(&all.blur, 0..self.parameters.len() - mu);
        errors.extend(deviations(&all.whole, blur..blur + mu));
        errors
    }

    /// Returns the places of the parameters of a kind: in the information on the blur, or in that on
    /// all for mu.
    pub(crate) fn places(&self, kind: ParameterKind) -> Vec<usize> {
        let all = (0..self.parameters.len()).filter(|&i| self.parameters[i].kind == kind);
        all.map(|i| self.place(i)).collect()
    }

    /// Returns the place of a parameter.
    fn place(&self, parameter: usize) -> usize {
        let Unknowns { blur, mu } = self.unknowns;
        let first = self.parameters.len() - mu;
        if parameter < first {
            parameter
        } else {
            blur + parameter - first
        }
    }

    /// Returns the information of an earlier result on the parameters of the plan.
    pub(crate) fn known(&self, result: &ResultFile) -> Result<Information, Error> {
        let kernel = self.plan.beliefs.kernel;
        if result.kernel != kernel {
            return Err(Error::OtherKernel {
                given: result.kernel,
                believed: kernel,
            });
        }
        let values = self.parameters.iter().enumerate().filter_map(|(i, id)| {
            let row = result.covariance.names.iter().position(|own| own == id)?;
            Some((i, row, value(result, id)?))
        });
        let values: Vec<(usize, usize, f64)> = values.collect();
        let covariance = DMatrix::from_fn(values.len(), values.len(), |i, j| {
            let (_, row, a) = values[i];
            let (_, column, b) = values[j];
            let entry = result.covariance.matrix[row][column];
            entry.map_or(f64::NAN, |entry| entry / (a * b))
        });
        let inverse = covariance
            .clone()
            .try_inverse()
            .filter(|own| !values.is_empty() && own.iter().all(|entry| entry.is_finite()));
        let Some(inverse) = inverse else {
            return Err(Error::NothingGiven);
        };
        let mut known = Information::none(self.unknowns);
        let blur = self.unknowns.blur;
        let places: Vec<usize> = values.iter().map(|&(i, ..)| self.place(i)).collect();
        for (i, &a) in places.iter().enumerate() {
            for (j, &b) in places.iter().enumerate() {
                known.whole[(a, b)] = inverse[(i, j)];
            }
        }
        // What tells mu too tells of the blur what is left when mu is free.
        let kept: Vec<usize> = (0..values.len()).filter(|&i| places[i] < blur).collect();
        let own = covariance.select_rows(&kept).select_columns(&kept);
        if let Some(own) = own.try_inverse() {
            for (i, &a) in kept.iter().enumerate() {
                for (j, &b) in kept.iter().enumerate() {
                    known.blur[(places[a], places[b])] = own[(i, j)];
                }
            }
        }
        Ok(known)
    }
}

/// Returns the value of a parameter of a result.
fn value(result: &ResultFile, id: &ParameterId) -> Option<f64> {
    let of = |own: &Option<Parameter>| match (own.as_ref()?, id.incidence_deg) {
        (Parameter::Shared(number), None) => number.value,
        (Parameter::PerAngle { per_angle }, Some(_)) => {
            let own = per_angle
                .iter()
                .find(|own| id.kind.at(own.incidence_deg) == *id);
            own?.value
        }
        _ => None,
    };
    match id.kind {
        ParameterKind::CornerSize => result.c_mm.as_ref().and_then(|c| c.value),
        ParameterKind::APerMm => of(&result.a_per_mm),
        ParameterKind::ATimesR => of(&result.a_times_r),
        ParameterKind::Mu => of(&result.mu),
        _ => None,
    }
}

/// Returns the standard deviations of some unknowns of a normal matrix; infinite where nothing tells
/// them.
fn deviations(normal: &DMatrix<f64>, wanted: Range<usize>) -> Vec<f64> {
    // Unknowns of which nothing is told, as those of an incidence without a photograph, are left
    // out.
    let told: Vec<usize> = (0..normal.nrows())
        .filter(|&i| normal[(i, i)] > 0.0)
        .collect();
    let kept = normal.select_rows(&told).select_columns(&told);
    let inverse = kept.cholesky().map(|own| own.inverse());
    let deviation = |i: usize| {
        let place = told.iter().position(|&own| own == i)?;
        Some(inverse.as_ref()?[(place, place)].sqrt())
    };
    wanted
        .map(|i| deviation(i).unwrap_or(f64::INFINITY))
        .collect()
}

/// Photographs as the camera of a plan would take them.
struct Seen<'a> {
    plan: &'a Plan,
    /// Photographs of both edges, whose pixels lie as those of all candidates.
    pattern: &'a Scene,
    camera: &'a Camera,
    layout: Layout,
    unknowns: Unknowns,
    /// Different incidences, degrees, ascending.
    angles: &'a [f64],
    /// Points of the beliefs: logarithms of c and spread.
    points: Vec<Vec<f64>>,
}

impl Seen<'_> {
    /// Returns the candidates of one place and direction, one for each edge.
    fn candidates(
        &self,
        table: &Table,
        r_mm: f64,
        [incidence_deg, azimuth_deg]: [f64; 2],
        retroreflected: f64,
    ) -> Result<Vec<Candidate>, Error> {
        let conditions = self.pattern.shots.iter().map(|shot| Conditions {
            incidence_deg,
            azimuth_deg: shot.direction.azimuth_deg.map(|_| azimuth_deg),
            r_mm,
            ..shot.conditions()
        });
        let conditions: Vec<Conditions> = conditions.collect();
        let scene = self.pattern.perturbed(table, None, &conditions);
        let scene = scene.map_err(estimator::Error::from)?;
        if self.layout.choice.kernel.has_waves() {
            let file = "the plan".into();
            let fault = |fault| estimator::Error::Wave(file, fault);
            scene.waves().map_err(fault)?;
        }
        let shots = scene.shots.iter().zip(&self.plan.choices.edge);
        Ok(shots
            .map(|(shot, &edge)| Candidate {
                floating_distance_mm: r_mm,
                incidence_deg,
                azimuth_deg,
                edge,
                retroreflected,
                tells: self.points.iter().map(|at| self.tells(shot, at)).collect(),
            })
            .collect())
    }

    /// Returns what a photograph tells at a point of the beliefs.
    fn tells(&self, shot: &Aerial, at: &[f64]) -> Information {
        let layout = &self.layout;
        let angle = |&own: &f64| own == shot.incidence_deg;
        let group = self.angles.iter().position(angle).unwrap_or(0);
        // The spread is believed to be the same at every incidence.
        let c = layout.c().map(|_| at[0]).into_iter();
        let spread = (0..layout.spreads).map(|_| at[at.len() - 1]);
        let at = DVector::from_iterator(layout.parameters(), c.chain(spread));
        let blur = layout.blur(&at, group);
        let model = model(shot, layout.choice);
        let pixels = Pixels::new(&shot.pixels, self.camera.pitch_mm);
        let lens = &self.pattern.optics.free;
        let curves = pixels.curves(Some((&model, blur)), self.camera, lens);
        let rows = pixels.foreseen(&curves, self.levels(), trial::noise(&self.plan.camera));
        let first = layout.parameters();
        let columns = layout.columns(group).into_iter();
        let columns: Vec<usize> = columns.chain(first..first + lens.len()).collect();
        let mu = layout.mu_group(group);
        Information::of(&rows, &columns, self.unknowns, Some(mu))
    }

    /// Returns what the source edge tells.
    fn source(&self) -> Information {
        let first = self.layout.parameters();
        let lens = &self.pattern.optics.free;
        let mut all = Information::none(self.unknowns);
        for own in self
            .pattern
            .reference
            .iter()
            .flat_map(|own| &own.photographs)
        {
            let pixels = Pixels::new(&own.pixels, self.camera.pitch_mm);
            let curves = pixels.curves(None, self.camera, lens);
            let camera = &self.plan.camera;
            let levels = levels(camera.source_level, camera.dark_ratio, camera.veil);
            let rows = pixels.foreseen(&curves, levels, trial::noise(camera));
            let columns: Vec<usize> = (first..first + lens.len()).collect();
            all.add(&Information::of(&rows, &columns, self.unknowns, None));
        }
        all
    }

    /// Returns dark plateau and step of a mid-air photograph.
    fn levels(&self) -> [f64; 2] {
        let camera = &self.plan.camera;
        levels(BRIGHT, camera.dark_ratio, camera.veil)
    }
}

/// Returns dark plateau and step of an edge whose bright side adds `bright` to the veil.
fn levels(bright: f64, dark_ratio: f64, veil: f64) -> [f64; 2] {
    [bright * dark_ratio + veil, bright * (1.0 - dark_ratio)]
}

/// Returns the camera of the pattern with the lens as it is planted.
fn planted_camera(pattern: &Scene, plan: &Plan) -> Camera {
    let camera = &plan.camera;
    let blur_mm =
        std::f64::consts::SQRT_2 * std::f64::consts::PI * camera.sigma_px * camera.pixel_pitch_mm;
    let mut seen = pattern.optics.camera.clone();
    for lens in &mut seen.lenses {
        (lens.blur_mm, lens.exponent, lens.departure) = (blur_mm, 2.0, None);
    }
    seen
}

/// Measures photographs without noise of each edge and of the source: the places of their pixels
/// are those of every photograph that the camera takes. The sheet hardly blurs them, so no edge is
/// too wide for its window.
fn pattern(
    plan: &Plan,
    table: &Table,
    [incidence_deg, azimuth_deg]: [f64; 2],
) -> Result<Scene, Error> {
    let camera = &plan.camera;
    let eta: f64 = cell::shifts(0.0, 0.0, 1.0, true)
        .iter()
        .map(|cube| cube.retroreflected)
        .sum::<f64>()
        / 2.0;
    let half_mirror = camera.half_mirror_transmittance * camera.half_mirror_reflectance;
    let shot = |edge: &Edge| PlantedShot {
        edge: PlantedEdge {
            normal_deg: TILT_DEG + if *edge == Edge::Tangential { 0.0 } else { 90.0 },
            exposure: BRIGHT / (camera.source_level * half_mirror * eta),
            ..PlantedEdge::AERIAL
        },
        floating_distance_mm: 100.0,
        path_mm: None,
        incidence_deg: 0.0,
        azimuth_deg: 0.0,
        tangential_axis_deg: 0.0,
        shifts: None,
    };
    let sharp = Params {
        seed: 0,
        camera: camera.clone(),
        truth: PlantedSheet {
            kernel: Kernel::Eq1,
            lobe: plan.beliefs.lobe,
            spectrum: plan.beliefs.spectrum.clone(),
            refractive_index: 1.0,
            pair: true,
            a: ByIncidence::Shared(1.0 / camera.pixel_pitch_mm),
            c_mm: camera.pixel_pitch_mm,
            angular_spread_mrad: 0.0,
            mu: ByIncidence::Shared(1.0),
        },
        reference: Some(PlantedEdge::SOURCE),
        captures: plan.choices.edge.iter().map(shot).collect(),
    };
    let mut campaign = trial::campaign(&sharp, &[Accepted::Doubled]);
    for capture in &mut campaign.captures {
        capture.incidence_deg = incidence_deg;
        capture.azimuth_deg = Some(azimuth_deg);
    }
    let photographs = trial::source(&sharp, choice::without_noise);
    Ok(Scene::of(&campaign, table, &photographs)?)
}

/// Beliefs of a single sheet, for tests.
#[cfg(test)]
impl Beliefs {
    pub(crate) fn certain(kernel: Kernel, c_mm: f64, spread: f64, mu: f64) -> Beliefs {
        let spread = Some([spread; 2]);
        let is_angle = ParameterKind::spread_of(kernel) == ParameterKind::ATimesR;
        Beliefs {
            kernel,
            lobe: Default::default(),
            c_mm: Some([c_mm; 2]),
            a_per_mm: spread.filter(|_| !is_angle),
            a_times_r: spread.filter(|_| is_angle),
            mu: [mu; 2],
            per_angle: Vec::new(),
            spectrum: None,
        }
    }
}
