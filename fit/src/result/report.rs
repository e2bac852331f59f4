//! RESULT.json: what an estimate says, for scripts and for `fit predict`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::estimate::estimate::{Estimate, Value};
use crate::estimate::forward::Forward;
use crate::estimate::loss::Kind;
use crate::estimate::scene::Scene;
use crate::estimate::select::Selection;
use crate::model::kernel::{Family, Kernel};
use crate::model::lobe::Shape;
use crate::photographs::captures::Spectrum;
pub use crate::result::table::{CellResult, TableResult};
use crate::samples::sampled::Sampling;

/// A parameter: one number for all incidence angles, or one per angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Parameter {
    /// One per incidence angle.
    PerAngle {
        /// In ascending order of incidence.
        per_angle: Vec<AtAngle>,
    },
    /// One number.
    Shared(Number),
}

/// A number with its error; the value is null where the photographs only bound it (see `bounds`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// The estimate.
    pub value: Option<f64>,
    /// One standard deviation.
    pub standard_error: Option<f64>,
}

/// A number at one incidence angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AtAngle {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// The estimate.
    pub value: Option<f64>,
    /// One standard deviation.
    pub standard_error: Option<f64>,
}

impl Parameter {
    /// The value at an incidence angle: linear between the fitted angles, constant beyond them. `None` where a value
    /// that is needed is null.
    pub fn at(&self, incidence_deg: f64) -> Option<f64> {
        match self {
            Parameter::Shared(number) => number.value,
            Parameter::PerAngle { per_angle } => {
                let after = per_angle
                    .iter()
                    .position(|p| p.incidence_deg >= incidence_deg);
                match after {
                    Some(0) => per_angle[0].value,
                    None => per_angle.last()?.value,
                    Some(i) => {
                        let (a, b) = (per_angle[i - 1], per_angle[i]);
                        let part =
                            (incidence_deg - a.incidence_deg) / (b.incidence_deg - a.incidence_deg);
                        Some(a.value? + part * (b.value? - a.value?))
                    }
                }
            }
        }
    }
}

/// A one-sided bound at a confidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// The parameter is larger.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub at_least: Option<f64>,
    /// The parameter is smaller.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub at_most: Option<f64>,
    /// Confidence of the bound.
    pub confidence: f64,
}

/// Covariance of the parameters, rows and columns in the order of `names`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Covariance {
    /// c_mm, a_per_mm or a_times_r, mu; `_at_<incidence>` where there is one per angle.
    pub names: Vec<String>,
    /// The matrix.
    pub matrix: Vec<Vec<f64>>,
}

/// One model that was compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Terms of the blur.
    pub kernel: Kernel,
    /// Lobe shape; null without a lobe.
    pub lobe: Option<Shape>,
    /// Whether a (of a baseline the roughness) is shared or per angle.
    pub sharing: String,
    /// Bayes' criterion (smaller is better).
    pub criterion: f64,
    /// Sum of squares of the residuals in units of their noise, correlations taken out.
    pub loss: f64,
    /// Parameters of the blur.
    pub parameters: usize,
}

/// MTF of one photograph, measured and modelled through the same estimator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curves {
    /// Along the edge normal, 1/mm.
    pub frequency_per_mm: Vec<f64>,
    /// From the photograph.
    pub measured: Vec<f64>,
    /// Of `measured`.
    pub standard_error: Vec<f64>,
    /// From the estimate.
    pub modelled: Vec<f64>,
}

/// One photograph.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaptureResult {
    /// File name.
    pub image: String,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Floating distance (optical path), mm.
    pub floating_distance_mm: f64,
    /// Direction of the edge normal, from +x (right) towards +y (down), degrees.
    pub edge_angle_deg: f64,
    /// Frequency at which the measured MTF is one half, 1/mm.
    pub mtf50_per_mm: Option<f64>,
    /// Mean squared MTF difference.
    pub loss: f64,
    /// What was repaired, assumed or is doubtful.
    pub warnings: Vec<String>,
    /// The MTF curves.
    pub curves: Curves,
}

/// The camera that was used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CameraResult {
    /// One pixel in the aerial-image plane, mm.
    pub pixel_pitch_mm: f64,
    /// Lens OTF exp(-(f blur)^exponent): the blur, mm; null where no reference photograph told.
    pub lens_blur_mm: Option<f64>,
    /// The exponent.
    pub lens_exponent: Option<f64>,
}

/// The samples of a rendered model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SamplingResult {
    /// Samples per pixel, how they are spread, and their seed.
    #[serde(flatten)]
    pub sampling: Sampling,
    /// Standard deviation of every parameter by the samples alone, in the order of the covariance's names; part of the
    /// standard errors.
    pub standard_error: Vec<f64>,
}

/// RESULT.json.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResultFile {
    /// Whose model of the sheet it is; absent from older results.
    #[serde(default)]
    pub model: Family,
    /// Terms of the blur.
    pub kernel: Kernel,
    /// Lobe shape; null without a lobe.
    pub lobe: Option<Shape>,
    /// What was minimised.
    pub loss: Kind,
    /// How the model was evaluated.
    #[serde(default)]
    pub forward: Forward,
    /// The samples of the model; null where it was evaluated in closed form.
    #[serde(default)]
    pub sampling: Option<SamplingResult>,
    /// Evaluations of the solver.
    pub iterations: usize,
    /// Why it stopped.
    pub stop: String,
    /// Wall time from the first file read to the estimate.
    pub seconds: f64,
    /// Wavelengths of the source; null where none is named.
    #[serde(default)]
    pub wavelength_nm: Option<Spectrum>,
    /// Corner size, mm; null under `lobe` and baselines.
    pub c_mm: Option<Number>,
    /// Diffraction spread, 1/mm; null under `angular`, `shift`, `wave` and baselines.
    pub a_per_mm: Option<Parameter>,
    /// Dimensionless a R; null but under `angular`.
    pub a_times_r: Option<Parameter>,
    /// Roughness of a baseline's facets, dimensionless; null under the proposed model.
    #[serde(default)]
    pub roughness: Option<Parameter>,
    /// Roughness of a baseline's front, where it is a parameter of its own.
    #[serde(default)]
    pub surface_roughness: Option<Number>,
    /// Reflectance; null without a reference photograph.
    pub mu: Option<Parameter>,
    /// What was added to the captures' azimuths, degrees, where the photographs were asked (`--fit-azimuth`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<Number>,
    /// Of all the parameters above.
    pub covariance: Covariance,
    /// One-sided bounds of what the photographs cannot pin down.
    pub bounds: BTreeMap<String, Bound>,
    /// The models that were compared, best criterion first.
    pub candidates: Vec<Candidate>,
    /// The photographs, in the order of the manifest.
    pub captures: Vec<CaptureResult>,
    /// The camera.
    pub camera: CameraResult,
    /// Transmittance times reflectance of the half mirror.
    pub half_mirror: f64,
    /// The table.
    pub table: TableResult,
    /// Of the campaign as a whole.
    pub warnings: Vec<String>,
}

impl ResultFile {
    /// Gathers an estimate.
    pub fn new(
        scene: &Scene,
        selection: &Selection,
        bounds: BTreeMap<String, Bound>,
        table: TableResult,
        seconds: f64,
    ) -> ResultFile {
        let best = &selection.best;
        let kernel = best.choice.kernel;
        let number = |name: &str, value: Value| {
            let bounded = bounds.contains_key(name);
            Number {
                value: (!bounded).then_some(value.value),
                standard_error: (!bounded && value.standard_error.is_finite())
                    .then_some(value.standard_error),
            }
        };
        let parameter = |name: &str, values: &[Value], per_angle: bool| -> Option<Parameter> {
            if !per_angle {
                return values.first().map(|&v| Parameter::Shared(number(name, v)));
            }
            let entries = scene
                .groups
                .iter()
                .zip(scene.names(name, values.len(), true))
                .zip(values);
            let per_angle = entries
                .map(|((&incidence_deg, name), &v)| {
                    let Number {
                        value,
                        standard_error,
                    } = number(&name, v);
                    AtAngle {
                        incidence_deg,
                        value,
                        standard_error,
                    }
                })
                .collect();
            Some(Parameter::PerAngle { per_angle })
        };
        let spread = |name: &str| parameter(name, &best.spread, best.choice.per_angle_a);
        let lens = best.camera.lens;
        let size = |is_roughness: bool| {
            let own = kernel.is_baseline() == is_roughness;
            let c = best.c_mm.filter(|_| own);
            c.map(|c| number(kernel.c_name(), c))
        };
        ResultFile {
            model: kernel.family(),
            kernel,
            lobe: kernel.has_lobe().then_some(best.choice.shape),
            loss: selection.loss.kind(),
            forward: match best.sampling {
                Some(_) => Forward::Render,
                None => Forward::Spectral,
            },
            sampling: best.sampling.as_ref().map(|own| SamplingResult {
                sampling: own.sampling,
                standard_error: own.standard_error.clone(),
            }),
            iterations: best.solution.iterations,
            stop: best.solution.stop.name().into(),
            seconds,
            wavelength_nm: scene.spectrum.clone(),
            c_mm: size(false),
            a_per_mm: matches!(kernel, Kernel::Eq1 | Kernel::Lobe)
                .then(|| spread("a_per_mm"))
                .flatten(),
            a_times_r: (kernel == Kernel::Angular)
                .then(|| spread("a_times_r"))
                .flatten(),
            roughness: kernel.is_baseline().then(|| spread("roughness")).flatten(),
            surface_roughness: size(true),
            mu: best
                .mu
                .as_ref()
                .and_then(|mu| parameter("mu", mu, best.choice.per_angle_mu)),
            azimuth_deg: None,
            covariance: covariance(best),
            candidates: selection
                .compared
                .iter()
                .map(|row| Candidate {
                    kernel: row.choice.kernel,
                    lobe: row.choice.kernel.has_lobe().then_some(row.choice.shape),
                    sharing: sharing(row.choice.kernel, row.choice.per_angle_a),
                    criterion: row.criterion,
                    loss: row.chi2,
                    parameters: row.parameters,
                })
                .collect(),
            captures: captures(scene, best),
            camera: CameraResult {
                pixel_pitch_mm: scene.camera.pitch_mm,
                lens_blur_mm: lens.map(|l| l.blur_mm),
                lens_exponent: lens.map(|l| l.exponent),
            },
            half_mirror: scene.half_mirror,
            table,
            warnings: warnings(scene, selection),
            bounds,
        }
    }
}

impl ResultFile {
    /// The spread: a, a R or a roughness, whichever the kernel has.
    pub fn spread(&self) -> Option<&Parameter> {
        let a = self.a_per_mm.as_ref().or(self.a_times_r.as_ref());
        a.or(self.roughness.as_ref())
    }
}

/// How the spread is shared, in words.
pub fn sharing(kernel: Kernel, per_angle: bool) -> String {
    let name = if kernel.is_baseline() {
        "roughness"
    } else {
        "a"
    };
    match (kernel.has_lobe(), per_angle) {
        (false, _) => "none".into(),
        (true, false) => format!("{name} shared"),
        (true, true) => format!("{name} per angle"),
    }
}

fn covariance(best: &Estimate) -> Covariance {
    let finite = |v: f64| if v.is_finite() { v } else { f64::MAX };
    let matrix = best
        .covariance
        .row_iter()
        .map(|row| row.iter().copied().map(finite).collect())
        .collect();
    Covariance {
        names: best.names.clone(),
        matrix,
    }
}

fn captures(scene: &Scene, best: &Estimate) -> Vec<CaptureResult> {
    let shots = scene.shots.iter().zip(&best.modelled).zip(&best.losses);
    shots
        .map(|((shot, modelled), &loss)| CaptureResult {
            image: shot.image.clone(),
            incidence_deg: shot.incidence_deg,
            floating_distance_mm: shot.r_mm,
            edge_angle_deg: shot.view.line.normal_rad.to_degrees(),
            mtf50_per_mm: shot.view.mtf50_per_mm(),
            loss,
            warnings: shot.warnings.clone(),
            curves: Curves {
                frequency_per_mm: shot.view.estimator.frequencies_per_mm.clone(),
                measured: shot.view.mtf.modulus.clone(),
                standard_error: shot.view.mtf_standard_error.clone(),
                modelled: modelled.clone(),
            },
        })
        .collect()
}

/// Reduced chi-square above which the model is said not to describe the photographs.
pub const POOR_FIT: f64 = 2.0;

fn warnings(scene: &Scene, selection: &Selection) -> Vec<String> {
    let best = &selection.best;
    let mut warnings = scene.warnings.clone();
    // Which way a scales with distance: told apart only by photographs at several distances, or named by the user.
    let tried = |kernel| {
        selection
            .compared
            .iter()
            .any(|row| row.choice.kernel == kernel)
    };
    let open = best.choice.kernel.has_lobe() && tried(Kernel::Eq1) && tried(Kernel::Angular);
    let one_distance = scene
        .shots
        .iter()
        .all(|shot| (shot.r_mm / scene.shots[0].r_mm - 1.0).abs() < 1e-6);
    if open && one_distance {
        warnings.push(
            "all photographs are at one floating distance: whether a (eq1) or a R (angular) is constant cannot be told, \
             and predictions at other distances depend on it; photograph a second distance, or name --kernel"
                .into(),
        );
    }
    let reduced = best.reduced_chi2();
    if reduced > POOR_FIT {
        warnings.push(format!(
            "the model does not describe the photographs within their noise (chi-square {reduced:.1} per degree of \
             freedom): the standard errors are raised accordingly; try another --kernel or --lobe, or check the manifest"
        ));
    }
    warnings.extend(coarse(best));
    let above_one = |mu: &&Value| mu.value - 3.0 * mu.standard_error > 1.0;
    if let Some(mu) = best.mu.iter().flatten().find(above_one) {
        warnings.push(format!(
            "mu {:.3} is more light than falls on the sheet: check the exposures, the half mirror and the table's cell",
            mu.value
        ));
    }
    if let Some(reference) = scene
        .reference
        .as_ref()
        .filter(|r| r.reduced_chi2 > POOR_FIT)
    {
        warnings.push(format!(
            "the lens model does not describe the reference photograph within its noise (chi-square {:.1} per degree \
             of freedom)",
            reference.reduced_chi2
        ));
    }
    warnings
}

/// What to say where the samples of a render make a good part of the errors.
fn coarse(best: &Estimate) -> Option<String> {
    const GOOD_PART: f64 = 0.5;
    let own = best.sampling.as_ref()?;
    let parts = own.standard_error.iter().enumerate();
    let worst = parts
        .map(|(i, error)| error / best.covariance[(i, i)].sqrt())
        .fold(0.0, f64::max);
    (worst > GOOD_PART).then(|| {
        format!(
            "up to {:.0} % of a standard error is the render's own sampling error: give more than --samples {}",
            100.0 * worst,
            own.sampling.samples
        )
    })
}
