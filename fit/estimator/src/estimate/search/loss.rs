//! The losses: functions that a fit minimises.

use nalgebra::DVector;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::compare::{Nuisances, Remainder, Weights};
use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::search::compared::{Compared, assemble, compare};
use crate::estimate::search::joint::Joint;
use crate::estimate::search::layout::Choice;
use crate::estimate::search::layout::Layout;
use edges::numerics::Evaluation;

/// Kinds of loss by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Differences of the MTFs, whitened with their noise covariance
    Mtf,
    /// Plain mean squared differences of the MTFs, as published
    Mse,
    /// Maximum likelihood on the pixels around the edge
    Edge,
}

impl Kind {
    /// Returns the name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Mtf => "mtf",
            Kind::Mse => "mse",
            Kind::Edge => "edge",
        }
    }
}

/// Loss that is ready for evaluation.
pub enum Loss<'a> {
    /// Whitened differences of the MTFs.
    Mtf(&'a Scene),
    /// Plain differences of the MTFs. The sum of squares is the sum over the photographs of their
    /// mean squared difference. It is no chi-square, so it can decide neither terms nor bounds.
    Mse(&'a Scene),
    /// Likelihood of the pixels.
    Edge(Box<Joint<'a>>),
}

impl<'a> Loss<'a> {
    /// Makes the loss of a kind. `near` is a candidate with parameters near the truth.
    pub fn new(kind: Kind, scene: &'a Scene, near: (Choice, &DVector<f64>)) -> Loss<'a> {
        match kind {
            Kind::Mtf => Loss::Mtf(scene),
            Kind::Mse => Loss::Mse(scene),
            Kind::Edge => Loss::Edge(Box::new(Joint::new(scene, near.0, near.1))),
        }
    }

    /// Returns the loss of the same photographs in another scene, with the noise and the light that
    /// they have in this one.
    pub(crate) fn in_scene<'b>(&self, scene: &'b Scene) -> Loss<'b>
    where
        'a: 'b,
    {
        match self {
            Loss::Mtf(_) => Loss::Mtf(scene),
            Loss::Mse(_) => Loss::Mse(scene),
            Loss::Edge(joint) => Loss::Edge(Box::new(joint.in_scene(scene))),
        }
    }

    /// Makes the loss of MTFs with these weights.
    pub fn of_mtfs(scene: &'a Scene, weights: Weights) -> Loss<'a> {
        match weights {
            Weights::Noise => Loss::Mtf(scene),
            Weights::Even => Loss::Mse(scene),
        }
    }

    /// Returns the kind of the loss.
    pub fn kind(&self) -> Kind {
        match self {
            Loss::Mtf(_) => Kind::Mtf,
            Loss::Mse(_) => Kind::Mse,
            Loss::Edge(_) => Kind::Edge,
        }
    }

    /// Returns the parameters of this loss from those of the blur. For `edge` the parameters of the
    /// lens follow them, if the reference gives them.
    pub fn start(&self, blur: &DVector<f64>) -> DVector<f64> {
        match self {
            Loss::Mtf(_) | Loss::Mse(_) => blur.clone(),
            Loss::Edge(joint) => joint.start(blur),
        }
    }

    /// Evaluates residuals in units of their noise (plain for `Mse`) and their derivatives at a
    /// point. Only sums of products over all rows have a meaning.
    pub fn evaluate(&self, layout: &Layout, at: &DVector<f64>) -> Evaluation {
        self.evaluate_from(layout, at, &mut Vec::new())
    }

    /// Does the same in a search, which keeps the nuisances of its last point in `near`: see
    /// [`Joint::evaluate`]. It begins with none.
    pub(crate) fn evaluate_from(
        &self,
        layout: &Layout,
        at: &DVector<f64>,
        near: &mut Vec<Nuisances>,
    ) -> Evaluation {
        let evaluation = match self {
            Loss::Mtf(scene) => differences(scene, layout, at, Weights::Noise),
            Loss::Mse(scene) => differences(scene, layout, at, Weights::Even),
            Loss::Edge(joint) => joint.evaluate(layout, at, near),
        };
        layout.with_expected(at, evaluation)
    }

    /// Returns what the model leaves of each photograph at a point, in units of the noise. The loss
    /// `edge` has the reference last.
    pub fn remainders(&self, layout: &Layout, at: &DVector<f64>) -> Vec<Remainder> {
        match self {
            Loss::Mtf(scene) | Loss::Mse(scene) => scene
                .shots
                .par_iter()
                .map(|shot| {
                    let blur = layout.blur(at, shot.place);
                    let part = compare(shot, None, layout.choice, blur);
                    let left = shot.view.weigh(Weights::Noise, &part.difference);
                    Remainder::of_mtf(left.as_slice())
                })
                .collect(),
            Loss::Edge(joint) => joint.remainders(layout, at),
        }
    }

    /// Evaluates the residuals of each photograph and their derivatives by all parameters. Together
    /// they are those of [`Loss::evaluate`], except for an assumption on the lens. The loss `edge`
    /// has the reference last.
    pub(crate) fn parts(&self, layout: &Layout, at: &DVector<f64>) -> Vec<Evaluation> {
        let of = |scene: &Scene, weights| {
            let all = scene.shots.par_iter().map(|shot| {
                let blur = layout.blur(at, shot.place);
                let part = [compare(shot, None, layout.choice, blur)];
                assemble(std::slice::from_ref(shot), layout, &part, weights)
            });
            all.collect()
        };
        match self {
            Loss::Mtf(scene) => of(scene, Weights::Noise),
            Loss::Mse(scene) => of(scene, Weights::Even),
            Loss::Edge(joint) => joint.parts(layout, at),
        }
    }

    /// Evaluates the same for both halves of a photograph along its edge. The MTFs have no halves.
    pub(crate) fn halves(
        &self,
        layout: &Layout,
        at: &DVector<f64>,
        photograph: usize,
    ) -> Option<[Evaluation; 2]> {
        match self {
            Loss::Mtf(_) | Loss::Mse(_) => None,
            Loss::Edge(joint) => Some(joint.halves(layout, at, photograph)),
        }
    }

    /// Returns the number of independent numbers that are compared, the n of Bayes' criterion:
    /// whitened MTF differences, or means and slopes along the edge of all bins of pixels, less the
    /// nuisances.
    pub fn observations(&self) -> usize {
        match self {
            Loss::Mtf(scene) | Loss::Mse(scene) => {
                let of = |shot: &Aerial| shot.view.mtf.modulus.len() - 1;
                scene.shots.iter().map(of).sum()
            }
            Loss::Edge(joint) => joint.observations(),
        }
    }
}

/// Evaluates the weighted differences of the MTFs of all photographs, and their derivatives.
fn differences(scene: &Scene, layout: &Layout, at: &DVector<f64>, weights: Weights) -> Evaluation {
    let parts: Vec<Compared> = scene
        .shots
        .par_iter()
        .map(|shot| compare(shot, None, layout.choice, layout.blur(at, shot.place)))
        .collect();
    assemble(&scene.shots, layout, &parts, weights)
}
