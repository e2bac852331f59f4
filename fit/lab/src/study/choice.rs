//! Study of the choice of terms: campaigns with drawn terms, fitted with all terms open.
//!
//! The study computes, independently of the fit, if the photographs of a campaign can tell the
//! planted terms from simpler ones (rivals). Each rival is fitted to the same photographs without
//! noise, with residuals in units of the planted noise. Its sum of squares is then D above that of
//! the planted terms. With noise, the sum of squares of a rival that spares q parameters is D + q
//! above that of the planted terms on average, and the difference scatters by sqrt(4 D + 2 q). So
//! the planted terms win by (D + q - penalty) / sqrt(4 D + 2 q) standard deviations, where the
//! penalty is that of the criterion. If they win by more than [`SURE`] against every rival, the
//! photographs can tell them. If this number is below -[`SURE`] for one rival, the photographs
//! cannot tell them.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use tables::Table;

use crate::simulate::PixelNoise;
use crate::simulate::error::Error as Unplanted;
use crate::simulate::photograph as simulate;
use crate::simulate::{ByIncidence, Params};
use crate::study::refused;
use crate::study::refused::Refused;
use crate::study::trial;
use edges::names::Kernel;
use edges::names::ParameterKind;
use edges::numerics::{Solution, Stop};
use edges::photographs::edge::fault::Accepted;
use estimator::Error;
use estimator::estimate::Choice;
use estimator::estimate::Layout;
use estimator::estimate::Loss;
use estimator::estimate::Progress;
use estimator::estimate::Scene;
use estimator::estimate::campaign as estimate;
use estimator::estimate::{CLEAR, Candidates, Ranked, own_mu_limit, scatter_of_mu};
use estimator::estimate::{Estimated, Options};
use estimator::estimate::{Joint, Used};
use estimator::estimate::{Optimum, refined};
use estimator::model::Further;

/// Number of standard deviations at which a difference counts as sure. Of campaigns that lie at
/// this limit, one in 44 goes the other way.
pub const SURE: f64 = 2.0;

/// Terms of a campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Terms {
    /// Kernel.
    pub kernel: Kernel,
    /// True if each incidence has an a of its own.
    pub per_angle_a: bool,
    /// True if each incidence has a mu of its own.
    pub per_angle_mu: bool,
}

/// Planted terms compared with the chosen ones.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Verdict {
    /// Standard deviations by which the planted terms should win against the best simpler ones;
    /// `None` if there are no simpler ones.
    pub margin: Option<f64>,
    /// True if the planted terms were chosen.
    pub right: bool,
    /// True if simpler terms were chosen.
    pub simpler: bool,
}

/// One-sided bound with the planted value: c from above, a from below.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OneSided {
    /// Bound on c in mm or on a in 1/mm; `None` if the photographs gave none.
    pub bound: Option<f64>,
    /// Planted c in mm, 0 if the kernel has no c; or planted a in 1/mm, `None` if the kernel has no
    /// a of Eq. (1).
    pub planted: Option<f64>,
    /// True if the planted value lies on the right side of the bound, or if there is no bound.
    pub holds: bool,
}

/// Result of one campaign.
#[derive(Debug, Clone, Serialize)]
pub struct Trial {
    /// Number of the campaign.
    pub index: u64,
    /// Number of photographs without the reference.
    pub photographs: usize,
    /// Terms that were planted.
    pub planted: Terms,
    /// Terms that were chosen.
    pub chosen: Terms,
    /// Verdict on the kernel and the sharing of a.
    pub blur: Verdict,
    /// Verdict on the sharing of mu; `None` if all photographs have one incidence.
    pub mu: Option<Verdict>,
    /// Bound on c; `None` if c came back as a number.
    pub c_at_most: Option<OneSided>,
    /// Bound on an a that all angles share; `None` if a came back as a number.
    pub a_at_least: Option<OneSided>,
}

/// Photographs and fits a campaign of any terms, with all terms open.
///
/// # Errors
/// Fails if a photograph is so noisy that its edge is not found, or if the fit fails.
pub fn run(params: &Params, index: u64, table: &Table) -> Result<Trial, Error> {
    let truth = &params.truth;
    let own = |values: &ByIncidence| matches!(values, ByIncidence::Table(_));
    let planted = Choice {
        kernel: truth.kernel,
        shape: truth.lobe,
        per_angle_a: own(&truth.a),
        per_angle_mu: own(&truth.mu),
        further: Further::NONE,
    };
    let options = Options::new(Candidates {
        shapes: vec![truth.lobe],
        ..Candidates::proposed()
    });
    let photographs = trial::source(params, simulate::photograph);
    let campaign = trial::campaign(params, &[]);
    let found = estimate::campaign(&campaign, &photographs, table, &options, &Progress::SILENT)?;
    let (scene, chosen) = (&found.scene, found.best.choice);
    let (margin, mu_margin) = margins(params, &silent(params, table)?, planted, &found.compared);
    let row = found.compared.iter().find(|row| {
        let (a, b) = (row.choice, chosen);
        (a.kernel, a.per_angle_a) == (b.kernel, b.per_angle_a)
    });
    let parameters = Layout::of(planted, scene).parameters();
    let mu = (scene.groups.len() > 1).then_some(Verdict {
        margin: mu_margin,
        right: chosen.per_angle_mu == planted.per_angle_mu,
        simpler: planted.per_angle_mu && !chosen.per_angle_mu,
    });
    let [c_at_most, a_at_least] = one_sided(params, planted, &found);
    Ok(Trial {
        index,
        photographs: scene.shots.len(),
        planted: terms(planted),
        chosen: terms(chosen),
        blur: Verdict {
            margin,
            right: (chosen.kernel, chosen.per_angle_a) == (planted.kernel, planted.per_angle_a),
            simpler: row.is_some_and(|row| row.precedes(planted, parameters)),
        },
        mu,
        c_at_most,
        a_at_least,
    })
}

/// Takes the photographs of a campaign without noise.
///
/// # Errors
/// Fails if an edge is not found or a photograph cannot be used.
fn silent(params: &Params, table: &Table) -> Result<Scene, Error> {
    // A ripple of the blur that no noise hides may look like a second edge, so doubled edges are
    // accepted.
    let campaign = trial::campaign(params, &[Accepted::Doubled]);
    let photographs = trial::source(params, without_noise);
    Scene::of(&campaign, table, &photographs)
}

/// Takes a photograph of a campaign without noise, or its reference if the index is `None`. A
/// plateau without noise looks clipped, so noise of a millionth is added.
///
/// # Errors
/// Fails if the truth lacks a value at the photograph's incidence.
pub(crate) fn without_noise(params: &Params, index: Option<usize>) -> Result<Vec<f32>, Unplanted> {
    let light = simulate::light(params, index)?.into_iter().enumerate();
    let photograph = index.map_or(0, |index| index as u64 + 1);
    let part = |pixel| 1e-6 * PixelNoise::new(0, photograph, pixel as u64).normal();
    Ok(light.map(|(i, v)| (v + part(i)) as f32).collect())
}

/// Returns the bounds on c (from above) and a (from below) with the planted values. The bound of a
/// parameter that came back as a number is `None`.
fn one_sided(params: &Params, planted: Choice, found: &Estimated) -> [Option<OneSided>; 2] {
    let truth = &params.truth;
    let of = |kind: ParameterKind| found.bounds.get(&kind.shared());
    let c = if truth.kernel.has_c() {
        truth.c_mm
    } else {
        0.0
    };
    let c_at_most = of(ParameterKind::CornerSize).map(|found| OneSided {
        bound: found.at_most,
        planted: Some(c),
        holds: found.at_most.is_none_or(|bound| c <= bound),
    });
    // A bound on a is one on the a of Eq. (1). Planted terms with another lobe have no such a.
    let a = (truth.kernel == Kernel::Eq1 || truth.kernel == Kernel::Lobe)
        .then(|| truth.a.at(found.scene.groups[0]))
        .flatten();
    let literal = truth.kernel != Kernel::Angular && !truth.kernel.has_waves();
    let a_at_least = of(ParameterKind::APerMm)
        .filter(|_| literal && !planted.per_angle_a)
        .map(|found| OneSided {
            bound: found.at_least,
            planted: a,
            holds: found.at_least.zip(a).is_none_or(|(bound, a)| a >= bound),
        });
    [c_at_most, a_at_least]
}

fn terms(choice: Choice) -> Terms {
    Terms {
        kernel: choice.kernel,
        per_angle_a: choice.per_angle_a,
        per_angle_mu: choice.per_angle_mu,
    }
}

/// Computes by how many standard deviations the planted terms should win: those of the blur, then
/// the sharing of mu. `scene` is without noise.
fn margins(
    params: &Params,
    scene: &Scene,
    choice: Choice,
    rivals: &[Ranked],
) -> (Option<f64>, Option<f64>) {
    let layout = Layout::of(choice, scene);
    let truth = &params.truth;
    let c = choice.kernel.has_c().then_some(truth.c_mm);
    let spread = |g: usize| truth.a.at(scene.groups[g]).unwrap_or(1.0);
    let blur = c.into_iter().chain((0..layout.spreads).map(spread));
    let blur = DVector::from_iterator(layout.parameters(), blur.map(f64::ln));
    let mut joint = Joint::new(scene, choice, &blur);
    let at = trial::planted(&joint, &params.camera, &blur);
    joint.with_noise(choice, &at, trial::noise(&params.camera));

    let own_mu = Choice {
        per_angle_mu: true,
        ..choice
    };
    let own_mu = Layout::of(own_mu, scene);
    let mu_margin = choice
        .per_angle_mu
        .then(|| {
            let known = joint.information(&own_mu, &at, Used::ByAnyEstimate);
            let first = layout.parameters();
            let groups = scene.groups.len();
            let covariance: DMatrix<f64> = known.mu?.covariance;
            let covariance = covariance
                .view((first, first), (groups, groups))
                .into_owned();
            let planted: Option<Vec<f64>> = scene.groups.iter().map(|&g| truth.mu.at(g)).collect();
            let squares = scatter_of_mu(&planted?, &covariance)?;
            let spared = (groups - 1) as f64;
            let limit = own_mu_limit(groups, scene.shots.len());
            Some((squares + spared - limit) / (4.0 * squares + 2.0 * spared).sqrt())
        })
        .flatten();

    let loss = Loss::Edge(Box::new(joint));
    let (residuals, _) = loss.evaluate(&layout, &at);
    let own = residuals.norm_squared();
    let n = (loss.observations() as f64).ln();
    let margin = rivals
        .iter()
        .filter(|rival| rival.precedes(choice, layout.parameters()))
        .map(|rival| {
            let start = Optimum {
                choice: rival.choice,
                solution: Solution {
                    parameters: rival.at.clone(),
                    residuals: DVector::zeros(0),
                    jacobian: DMatrix::zeros(0, 0),
                    iterations: 0,
                    stop: Stop::Converged,
                },
                observations: loss.observations(),
            };
            let fitted = refined(scene, &loss, start).solution.sum_of_squares();
            let above = (fitted - own).max(0.0);
            let spared = (layout.parameters() - rival.parameters) as f64;
            let wins = above + spared - spared * n - CLEAR;
            // The difference to an equal rival of equal size does not scatter: the preferred one
            // stays.
            wins / (4.0 * above + 2.0 * spared).sqrt().max(1e-3)
        })
        .reduce(f64::min);
    (margin, mu_margin)
}

/// Counts of campaigns with the same planted terms: how many can tell these terms, and how many
/// chose them.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Row {
    /// Planted terms, in words.
    pub planted: String,
    /// Number of campaigns with these terms.
    pub campaigns: usize,
    /// Campaigns that can tell the terms from all simpler ones, and those of them that chose the
    /// planted terms.
    pub told: [usize; 2],
    /// Campaigns that cannot tell the terms, and those of them that chose simpler ones.
    pub hidden: [usize; 2],
    /// Campaigns between the two, and those of them that chose the planted terms or simpler ones.
    pub between: [usize; 2],
}

impl Row {
    fn new(planted: String) -> Row {
        Row {
            planted,
            ..Row::default()
        }
    }

    fn add(&mut self, verdict: &Verdict) {
        let margin = verdict.margin.unwrap_or(f64::INFINITY);
        let (place, good) = if margin >= SURE {
            (&mut self.told, verdict.right)
        } else if margin <= -SURE {
            (&mut self.hidden, verdict.simpler)
        } else {
            (&mut self.between, verdict.right || verdict.simpler)
        };
        place[0] += 1;
        place[1] += usize::from(good);
        self.campaigns += 1;
    }
}

/// Counts of one kind of one-sided bound.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Sided {
    /// Kind of the bound (c at most, or a at least) and planted kernel.
    pub name: String,
    /// Number of campaigns in which the parameter did not come back as a number.
    pub campaigns: usize,
    /// Number of these campaigns that gave a bound.
    pub bounded: usize,
    /// Number of these bounds that hold for the planted value.
    pub holds: usize,
}

/// Summary of all trials.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Number of campaigns drawn.
    pub campaigns: usize,
    /// Campaigns that gave no trial, by reason.
    pub refused: Vec<Refused>,
    /// Counts by planted kernel and sharing of a, for all kernels, then by sharing of mu.
    pub rows: Vec<Row>,
    /// Counts of one-sided bounds.
    pub bounds: Vec<Sided>,
}

impl Summary {
    /// Sums up the trials and the campaigns that gave none.
    pub fn new(trials: &[Trial], refused: Vec<Refused>) -> Summary {
        let mut rows = Vec::new();
        let (mut all, mut mus) = (Row::new("all kernels".into()), Vec::new());
        for kernel in Kernel::ALL {
            for own in [false, true] {
                let sharing = if own { ", a by angle" } else { "" };
                let mut row = Row::new(format!("{}{sharing}", kernel.name()));
                let planted =
                    |t: &&Trial| (t.planted.kernel, t.planted.per_angle_a) == (kernel, own);
                for trial in trials.iter().filter(planted) {
                    row.add(&trial.blur);
                    all.add(&trial.blur);
                }
                rows.push(row);
            }
        }
        for own in [false, true] {
            let sharing = if own { "mu by angle" } else { "mu shared" };
            let mut row = Row::new(sharing.into());
            for trial in trials.iter().filter(|t| t.planted.per_angle_mu == own) {
                trial.mu.iter().for_each(|verdict| row.add(verdict));
            }
            mus.push(row);
        }
        rows.push(all);
        rows.extend(mus);
        rows.retain(|row| row.campaigns > 0);
        let mut bounds = Vec::new();
        for (name, side) in [
            (
                "c at most",
                (|t| t.c_at_most) as fn(&Trial) -> Option<OneSided>,
            ),
            ("a at least", |t| t.a_at_least),
        ] {
            for kernel in Kernel::ALL {
                let mut row = Sided {
                    name: format!("{name}, of {}", kernel.name()),
                    ..Sided::default()
                };
                let planted = trials.iter().filter(|t| t.planted.kernel == kernel);
                for found in planted.filter_map(side) {
                    row.campaigns += 1;
                    row.bounded += usize::from(found.bound.is_some());
                    row.holds += usize::from(found.bound.is_some() && found.holds);
                }
                bounds.push(row);
            }
        }
        bounds.retain(|row| row.campaigns > 0);
        Summary {
            campaigns: trials.len() + refused::total(&refused),
            refused,
            rows,
            bounds,
        }
    }
}
