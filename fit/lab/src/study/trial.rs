//! One simulated campaign: photographed in memory, fitted with both losses, and compared with its
//! truth and its bound.

use std::path::PathBuf;

use nalgebra::DVector;
use serde::Serialize;
use tables::Table;

use crate::simulate;
use crate::simulate::{Params, PlantedCamera};
use edges::names::Kernel;
use edges::photographs::PixelNoise;
use edges::photographs::edge::fault::Accepted;
use edges::photographs::manifest::captures;
use edges::photographs::photo::plane::Photo;
use edges::photographs::photo::taken::Taken;
use edges::photographs::{Campaign, Capture, Setup};
use estimator::Error;
use estimator::estimate::Choice;
use estimator::estimate::Layout;
use estimator::estimate::Optimum;
use estimator::estimate::Scene;
use estimator::estimate::goodness;
use estimator::estimate::refined;
use estimator::estimate::search::optimum::optimum;
use estimator::estimate::{Chances, Verdict};
use estimator::estimate::{Estimate, estimate};
use estimator::estimate::{Joint, Used};
use estimator::estimate::{Kind, Loss};
use estimator::model::Further;

/// Parameters of a trial, in the order of its arrays.
pub const PARAMETERS: [&str; 3] = ["c", "a", "mu"];

/// Losses of a trial, in the order of its arrays.
pub const LOSSES: [Kind; 2] = [Kind::Mtf, Kind::Edge];

/// Result of one campaign, with c in mm and a in 1/mm.
#[derive(Debug, Clone, Serialize)]
pub struct Trial {
    /// Number of the campaign.
    pub index: u64,
    /// Number of photographs without the reference.
    pub photographs: usize,
    /// Number of electrons at full scale.
    pub electrons: f64,
    /// True if dark pixels were cut off at 0 in any photograph.
    pub cut_off: bool,
    /// Planted values of [`PARAMETERS`].
    pub truth: [f64; 3],
    /// Cramer-Rao bounds at the truth, as standard deviations.
    pub bound: [f64; 3],
    /// Estimates and standard errors, by loss and parameter.
    pub found: [[[f64; 2]; 3]; 2],
    /// Quality of the fit, by loss. The standard errors are raised accordingly.
    pub fit: [Quality; 2],
}

/// Quality of the fit of one campaign.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Quality {
    /// The quality in one word.
    pub verdict: Verdict,
    /// Factor on the standard errors.
    pub scale: f64,
    /// Probabilities that noise alone explains the misfit.
    pub p_values: Chances,
}

/// Photographs and fits a campaign with one `a` and one `mu` for all angles.
///
/// # Errors
/// Fails if [`Scene::of`] fails, for example because a photograph is so noisy that its edge is not
/// found.
pub fn run(params: &Params, index: u64, table: &Table) -> Result<Trial, Error> {
    let photographs = source(params, simulate::photograph::saved);
    let scene = Scene::of(&campaign(params, &[]), table, &photographs)?;
    let choice = Choice {
        kernel: Kernel::Eq1,
        shape: params.truth.lobe,
        per_angle_a: false,
        per_angle_mu: false,
        further: Further::NONE,
    };
    let shared = |values: &crate::simulate::ByIncidence| {
        values
            .at(params.captures[0].incidence_deg)
            .unwrap_or(f64::NAN)
    };
    let (a, mu) = (shared(&params.truth.a), shared(&params.truth.mu));
    let truth = [params.truth.c_mm, a, mu];
    let near = optimum(&scene, choice);
    let joint = Joint::new(&scene, choice, &near.solution.parameters);
    let with_mtf = judged(&scene, &Loss::Mtf(&scene), near.clone());
    let with_edge = judged(&scene, &Loss::Edge(Box::new(joint)), near.clone());
    let bound = bound(params, &scene, choice, &near.solution.parameters, truth);
    Ok(Trial {
        index,
        photographs: scene.shots.len(),
        electrons: params.camera.full_well_e,
        cut_off: scene.shots.iter().any(|shot| shot.pixels.cut.zero),
        truth,
        bound,
        found: [found(&with_mtf.0), found(&with_edge.0)],
        fit: [with_mtf.1, with_edge.1],
    })
}

/// Fits by a loss from `near`, judges the fit, and raises its standard errors accordingly.
fn judged(scene: &Scene, loss: &Loss, near: Optimum) -> (Estimate, Quality) {
    let mut fit = estimate(scene, loss, refined(scene, loss, near));
    let goodness = goodness(scene, loss, &fit);
    fit.raise(goodness.scales());
    let quality = Quality {
        verdict: goodness.verdict,
        scale: goodness.scale,
        p_values: goodness.chances,
    };
    (fit, quality)
}

fn found(fit: &Estimate) -> [[f64; 2]; 3] {
    let mu = fit.mu.as_ref().and_then(|mu| mu.first());
    [fit.c_mm.as_ref(), fit.spread.first(), mu]
        .map(|value| value.map_or([f64::NAN, f64::INFINITY], |v| [v.value, v.standard_error]))
}

/// Computes the Cramer-Rao bound at the truth with the planted noise. Poisson light of n electrons
/// and normal light of the same variance carry the same information (1/n) about the mean, so both
/// have this bound.
pub fn bound(
    params: &Params,
    scene: &Scene,
    choice: Choice,
    near: &DVector<f64>,
    truth: [f64; 3],
) -> [f64; 3] {
    let camera = &params.camera;
    let mut joint = Joint::new(scene, choice, near);
    let blur = DVector::from_vec(vec![truth[0].ln(), truth[1].ln()]);
    let at = planted(&joint, camera, &blur);
    joint.with_noise(choice, &at, noise(camera));
    let layout = Layout::of(choice, scene);
    let bound = joint.information(&layout, &at, Used::ByAnyEstimate);
    let covariance = bound.mu.map_or(bound.blur, |mu| mu.covariance);
    let deviation = |i: usize| covariance.get((i, i)).map_or(f64::INFINITY, |v| v.sqrt());
    [0, 1, 2].map(|i| deviation(i) * truth[i])
}

/// Returns the parameters that were planted: a blur, and the lens of the camera.
pub(crate) fn planted(joint: &Joint, camera: &PlantedCamera, blur: &DVector<f64>) -> DVector<f64> {
    let lens = [camera.lens_blur_mm().ln(), 2.0];
    let mut at = joint.start(blur);
    for (value, planted) in at.iter_mut().skip(blur.len()).zip(lens) {
        *value = planted;
    }
    at
}

/// Returns the noise of the pixels that was planted.
pub(crate) fn noise(camera: &PlantedCamera) -> PixelNoise {
    let step = 1.0 / ((1_u64 << camera.bits) - 1) as f64;
    PixelNoise {
        read: (camera.read_noise_e / camera.full_well_e).powi(2) + step * step / 12.0,
        gain: 1.0 / camera.full_well_e,
    }
}

/// Returns a campaign without a file, whose photographs are named by their numbers. The `accepted`
/// faults of edges give warnings only.
pub(crate) fn campaign(params: &Params, accepted: &[Accepted]) -> Campaign {
    let name =
        |index: Option<usize>| PathBuf::from(index.map_or("source".into(), |i| i.to_string()));
    let shot = |index: Option<usize>, exposure: f64| captures::Shot {
        accepted: accepted.to_vec(),
        ..captures::Shot::named(name(index), exposure)
    };
    let camera = &params.camera;
    Campaign {
        file: "simulated".into(),
        setup: Setup {
            pixel_pitch_mm: camera.pixel_pitch_mm,
            seen_in_mirror: Some(camera.seen_in_mirror),
            half_mirror_transmittance: camera.half_mirror_transmittance,
            half_mirror_reflectance: camera.half_mirror_reflectance,
            spectrum: params.truth.spectrum.clone(),
            lamp: None,
            stray: Default::default(),
            polarisation: None,
        },
        references: params
            .reference
            .iter()
            .map(|edge| shot(None, edge.exposure))
            .collect(),
        captures: params
            .captures
            .iter()
            .enumerate()
            .map(|(i, planted)| Capture {
                shot: shot(Some(i), planted.edge.exposure),
                floating_distance_mm: planted.floating_distance_mm,
                path_mm: planted.path_mm,
                incidence_deg: planted.incidence_deg,
                azimuth_deg: Some(planted.azimuth_deg),
                tangential_axis_deg: planted.tangential_axis_deg,
            })
            .collect(),
        warnings: Vec::new(),
    }
}

/// Returns a source of photographs for such a campaign. `photograph` gives the pixels of a capture,
/// or of the reference if the index is `None`.
pub(crate) fn source(
    params: &Params,
    photograph: impl Fn(&Params, Option<usize>) -> Result<Vec<f32>, simulate::error::Error> + Sync,
) -> impl Fn(&captures::Shot) -> Result<Photo, captures::Error> + Sync {
    move |shot| {
        let index = shot.image.to_str().and_then(|name| name.parse().ok());
        Ok(Photo {
            width: params.camera.width,
            height: params.camera.height,
            // The truth of a drawn campaign has an entry for each of its angles.
            luminance: photograph(params, index).unwrap_or_default(),
            clip_level: Some(1.0),
            clips_alone: true,
            transfer: Taken::default(),
            warnings: Vec::new(),
        })
    }
}
