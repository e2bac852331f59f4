//! What a fit minimises.

use nalgebra::DVector;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::compare::Weights;
use crate::estimate::choice::Choice;
use crate::estimate::compared::{Compared, assemble, compare};
use crate::estimate::joint::Joint;
use crate::estimate::layout::Layout;
use crate::estimate::scene::{Aerial, Scene};
use crate::numerics::Evaluation;

/// The losses by name.
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
    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Mtf => "mtf",
            Kind::Mse => "mse",
            Kind::Edge => "edge",
        }
    }
}

/// A loss, ready to be evaluated.
pub enum Loss<'a> {
    /// Whitened differences of the MTFs.
    Mtf(&'a Scene),
    /// Plain differences of the MTFs: the sum of squares is the sum over the photographs of their
    /// mean squared difference, which is no chi-square, so that neither terms nor bounds can be
    /// told by it.
    Mse(&'a Scene),
    /// The likelihood of the pixels.
    Edge(Box<Joint<'a>>),
}

impl<'a> Loss<'a> {
    /// The loss of a kind; `near` is a candidate with parameters near the truth.
    pub fn new(kind: Kind, scene: &'a Scene, near: (Choice, &DVector<f64>)) -> Loss<'a> {
        match kind {
            Kind::Mtf => Loss::Mtf(scene),
            Kind::Mse => Loss::Mse(scene),
            Kind::Edge => Loss::Edge(Box::new(Joint::new(scene, near.0, near.1))),
        }
    }

    /// The loss of MTFs weighed so.
    pub fn of_mtfs(scene: &'a Scene, weights: Weights) -> Loss<'a> {
        match weights {
            Weights::Noise => Loss::Mtf(scene),
            Weights::Even => Loss::Mse(scene),
        }
    }

    /// Its kind.
    pub fn kind(&self) -> Kind {
        match self {
            Loss::Mtf(_) => Kind::Mtf,
            Loss::Mse(_) => Kind::Mse,
            Loss::Edge(_) => Kind::Edge,
        }
    }

    /// The parameters of this loss from those of the blur: the lens beside them where the pixels
    /// tell it too.
    pub fn start(&self, blur: &DVector<f64>) -> DVector<f64> {
        match self {
            Loss::Mtf(_) | Loss::Mse(_) => blur.clone(),
            Loss::Edge(joint) => joint.start(blur),
        }
    }

    /// Residuals in units of their noise (plain under `Mse`), and derivatives, at a point. Only
    /// their products have a meaning.
    pub fn evaluate(&self, layout: &Layout, at: &DVector<f64>) -> Evaluation {
        match self {
            Loss::Mtf(scene) => differences(scene, layout, at, Weights::Noise),
            Loss::Mse(scene) => differences(scene, layout, at, Weights::Even),
            Loss::Edge(joint) => joint.evaluate(layout, at),
        }
    }

    /// How many independent numbers are compared: whitened MTF differences, or means and slopes
    /// along the edge of all bins of pixels less the nuisances. The n of Bayes' criterion.
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

/// Weighed differences of the MTFs of all photographs, and their derivatives.
fn differences(scene: &Scene, layout: &Layout, at: &DVector<f64>, weights: Weights) -> Evaluation {
    let parts: Vec<Compared> = scene
        .shots
        .par_iter()
        .map(|shot| compare(shot, None, layout.choice, layout.blur(at, shot.group)))
        .collect();
    assemble(scene, layout, &parts, weights)
}
