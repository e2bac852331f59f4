//! What each photograph that could be taken would tell, at each point of the beliefs.

use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;
use tables::Table;

use crate::plan::request::{Choices, Edge, Own, Plan};
use crate::plan::rival::Apart;
use crate::plan::seen::{BRIGHT, Seen, Setup, pattern, planted_camera};
use crate::plan::{Error, Expected, Photograph};
use edges::names::{ParameterId, ParameterKind};
use estimator::estimate::{Choice, Layout};
use estimator::model::Further;
use estimator::result::{Parameter, ResultFile};

/// Least share of the light that returns where a photograph is worth while.
const LEAST_ETA: f64 = 0.02;

/// A photograph that could be taken.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    /// Place and direction.
    pub setup: Setup,
    /// Edge.
    pub edge: Edge,
    /// Retroreflected share.
    pub retroreflected: f64,
    /// Information at each point of the beliefs.
    pub tells: Vec<Information>,
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
    /// Products of the other kernel's derivatives by its blur and the lens, and of its difference to
    /// the believed one; empty if there is no other.
    pub rival: DMatrix<f64>,
}

/// Places of the unknowns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unknowns {
    /// Number of those of blur and lens.
    pub blur: usize,
    /// Number of mu.
    pub mu: usize,
    /// Size of the products of the other kernel, 0 without one.
    pub rival: usize,
}

impl Information {
    /// Creates the information of nothing.
    pub(crate) fn none(Unknowns { blur, mu, rival }: Unknowns) -> Information {
        Information {
            rival: DMatrix::zeros(rival, rival),
            blur: DMatrix::zeros(blur, blur),
            whole: DMatrix::zeros(blur + mu + 1, blur + mu + 1),
        }
    }

    /// Adds that of another source.
    pub(crate) fn add(&mut self, other: &Information) {
        self.blur += &other.blur;
        self.whole += &other.whole;
        self.rival += &other.rival;
    }

    /// Takes that of another source away.
    pub(crate) fn take(&mut self, other: &Information) {
        self.blur -= &other.blur;
        self.whole -= &other.whole;
        self.rival -= &other.rival;
    }

    /// Makes it from rows (ln step, derivatives by blur and lens), whose derivatives belong to
    /// `columns`. The step depends on that mu, if on any. The other kernel is left out, except for
    /// the lens of the source edge, which has no mu.
    pub(crate) fn of(
        rows: &DMatrix<f64>,
        columns: &[usize],
        Unknowns {
            blur,
            mu: several,
            rival,
        }: Unknowns,
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
        let own = free.tr_mul(&free);
        let mut other = DMatrix::zeros(rival, rival);
        if mu.is_none() && rival > 0 {
            other.view_mut((0, 0), (blur, blur)).copy_from(&own);
        }
        Information {
            blur: own,
            whole: tied.tr_mul(&tied),
            rival: other,
        }
    }
}

/// Everything that could be photographed, with what it would tell.
pub(crate) struct Foreseen<'a> {
    seen: Seen<'a>,
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
    pub(crate) fn new(plan: &'a Plan, table: &'a Table) -> Result<Foreseen<'a>, Error> {
        let (setups, dark) = setups(&plan.choices, table)?;
        let Some(&(first, _)) = setups.first() else {
            return Err(Error::Dark);
        };
        let pattern = pattern(plan, table, [first.incidence_deg, first.azimuth_deg])?;
        let mut angles: Vec<f64> = setups.iter().map(|(own, _)| own.incidence_deg).collect();
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
        let layout = Layout::new(choice, angles.len(), 1);
        let unknowns = Unknowns {
            blur: layout.parameters() + pattern.optics.free.len(),
            mu: if own(Own::Mu) { angles.len() } else { 1 },
            rival: 0,
        };
        let unknowns = Unknowns {
            rival: plan.rival.map_or(0, |_| unknowns.blur + 1),
            ..unknowns
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
        let mut seen = Seen {
            plan,
            table,
            pattern,
            camera,
            layout,
            unknowns,
            angles,
            points: plan.beliefs.points(),
            rival: None,
        };
        seen.rival = plan
            .rival
            .map(|rival| seen.resembling(rival, &setups))
            .transpose()?;
        let found = setups
            .par_iter()
            .map(|&(setup, eta)| seen.candidates(setup, eta));
        let found: Vec<Vec<Candidate>> = found.collect::<Result<_, Error>>()?;
        Ok(Foreseen {
            parameters,
            unknowns,
            candidates: found.into_iter().flatten().collect(),
            dark,
            source: seen.source(),
            seen,
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
        let plan = self.seen.plan;
        let camera = &plan.camera;
        let [low, high] = plan.beliefs.mu;
        let half_mirror = camera.half_mirror_transmittance * camera.half_mirror_reflectance;
        let light = camera.source_level * (low * high).sqrt() * half_mirror * own.retroreflected;
        Photograph {
            floating_distance_mm: own.setup.floating_distance_mm,
            incidence_deg: own.setup.incidence_deg,
            azimuth_deg: own.setup.azimuth_deg,
            edge: own.edge,
            exposure: BRIGHT / light,
        }
    }

    /// Returns how well a choice of candidates tells the kernels of the plan apart.
    ///
    /// # Errors
    /// Returns the errors of [`Seen::shots`].
    pub(crate) fn apart(&self, chosen: &[usize]) -> Result<Vec<Apart>, Error> {
        let chosen: Vec<&Candidate> = chosen.iter().map(|&i| &self.candidates[i]).collect();
        self.seen.judged(&chosen)
    }

    /// Returns the chi-square by which a choice shows the other kernel to be worse, in the middle of
    /// the beliefs; `None` if the plan names no other.
    ///
    /// # Errors
    /// Returns the errors of [`Seen::shots`].
    pub(crate) fn chi2(&self, chosen: &[usize]) -> Result<Option<f64>, Error> {
        let chosen: Vec<&Candidate> = chosen.iter().map(|&i| &self.candidates[i]).collect();
        self.seen.chi2(&chosen)
    }

    /// Returns `count` candidates that are spread evenly over the choices, with the edges in turn.
    pub(crate) fn even(&self, count: usize) -> Vec<usize> {
        let edges = self.seen.plan.choices.edge.len();
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
        let Unknowns { blur, mu, .. } = self.unknowns;
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
        let Unknowns { blur, mu, .. } = self.unknowns;
        let first = self.parameters.len() - mu;
        if parameter < first {
            parameter
        } else {
            blur + parameter - first
        }
    }

    /// Returns the information of an earlier result on the parameters of the plan.
    pub(crate) fn known(&self, result: &ResultFile) -> Result<Information, Error> {
        let kernel = self.seen.plan.beliefs.kernel;
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

/// Returns the setups that return light, each with its retroreflected share, and the number of
/// photographs that would show none.
fn setups(choices: &Choices, table: &Table) -> Result<(Vec<(Setup, f64)>, usize), Error> {
    let (mut lit, mut all) = (Vec::new(), 0);
    for &floating_distance_mm in &choices.floating_distance_mm {
        for &incidence_deg in &choices.incidence_deg {
            for &azimuth_deg in &choices.azimuth_deg {
                let eta = table.direction(incidence_deg, Some(azimuth_deg));
                let eta = eta.map_err(estimator::Error::from)?.retroreflected;
                let setup = Setup {
                    floating_distance_mm,
                    incidence_deg,
                    azimuth_deg,
                };
                lit.extend((eta >= LEAST_ETA).then_some((setup, eta)));
                all += 1;
            }
        }
    }
    let dark = (all - lit.len()) * choices.edge.len();
    Ok((lit, dark))
}

/// Returns the value of a parameter of a result.
fn value(result: &ResultFile, id: &ParameterId) -> Option<f64> {
    let of = |own: &Option<Parameter>| match (own.as_ref()?, id.at) {
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
