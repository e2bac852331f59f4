//! RESULT.json: what an estimate says, for scripts and for `fit predict`.

use serde::{Deserialize, Serialize};

use crate::estimate::Bounds;
use crate::estimate::Estimate;
use crate::estimate::Estimated;
use crate::estimate::Forward;
use crate::estimate::Kind;
use crate::estimate::Ranked;
use crate::estimate::Value;
use crate::estimate::{Aerial, Scene};
use crate::names::LobeShape;
use crate::names::Spectrum;
use crate::names::{Family, Kernel};
use crate::names::{ParameterId, ParameterKind};
use crate::result::table::TableResult;
use crate::samples::Sampling;

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
    /// The value at an incidence angle: linear between the fitted angles, constant beyond them.
    /// `None` where a value that is needed is null.
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

/// Covariance of the parameters, rows and columns in the order of `names`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Covariance {
    /// c_mm, a_per_mm or a_times_r, mu; `_at_<incidence>` where there is one per angle.
    pub names: Vec<ParameterId>,
    /// The matrix. Null where an entry is not finite: the photographs do not tell these parameters,
    /// or not apart; a warning says so.
    pub matrix: Vec<Vec<Option<f64>>>,
}

/// One model that was compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Terms of the blur.
    pub kernel: Kernel,
    /// Lobe shape; null without a lobe.
    pub lobe: Option<LobeShape>,
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
    /// Standard deviation of every parameter by the samples alone, in the order of the covariance's
    /// names; part of the standard errors.
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
    pub lobe: Option<LobeShape>,
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
    /// What was added to the captures' azimuths, degrees, where the photographs were asked
    /// (`--fit-azimuth`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<Number>,
    /// Of all the parameters above.
    pub covariance: Covariance,
    /// One-sided bounds of what the photographs cannot pin down.
    pub bounds: Bounds,
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
    /// Writes an estimate down, beside the table that it was made with and the seconds that it
    /// took.
    pub fn new(estimated: &Estimated, table: TableResult, seconds: f64) -> ResultFile {
        let Estimated { scene, best, .. } = estimated;
        let kernel = best.choice.kernel;
        let written = Written { estimated };
        let is_rough = kernel.is_baseline();
        let lens = best.camera.lens;
        ResultFile {
            model: kernel.family(),
            kernel,
            lobe: kernel.has_lobe().then_some(best.choice.shape),
            loss: estimated.kind,
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
            c_mm: written.size().filter(|_| !is_rough),
            a_per_mm: written.spread(ParameterKind::APerMm),
            a_times_r: written.spread(ParameterKind::ATimesR),
            roughness: written.spread(ParameterKind::Roughness),
            surface_roughness: written.size().filter(|_| is_rough),
            mu: best
                .mu
                .as_ref()
                .and_then(|mu| written.parameter(ParameterKind::Mu, mu, best.choice.per_angle_mu)),
            azimuth_deg: estimated.azimuth.as_ref().map(|found| Number {
                value: Some(found.deg.value),
                standard_error: Some(found.deg.standard_error),
            }),
            covariance: covariance(best),
            bounds: estimated.bounds.clone(),
            candidates: estimated.compared.iter().map(candidate).collect(),
            captures: captures(scene, best),
            camera: CameraResult {
                pixel_pitch_mm: scene.camera.pitch_mm,
                lens_blur_mm: lens.map(|l| l.blur_mm),
                lens_exponent: lens.map(|l| l.exponent),
            },
            half_mirror: scene.half_mirror,
            table,
            warnings: estimated.warnings.clone(),
        }
    }
}

/// The numbers of an estimate as they are written.
struct Written<'a> {
    estimated: &'a Estimated,
}

impl Written<'_> {
    /// A number, null where it is only bounded; its error, null where it has none.
    fn number(&self, id: ParameterId, value: Value) -> Number {
        let bounded = self.estimated.bounds.contains_key(&id);
        let error = value.standard_error;
        Number {
            value: (!bounded).then_some(value.value),
            standard_error: (!bounded && error.is_finite()).then_some(error),
        }
    }

    /// A parameter that has one value, or one for every incidence.
    fn parameter(
        &self,
        kind: ParameterKind,
        values: &[Value],
        per_angle: bool,
    ) -> Option<Parameter> {
        if !per_angle {
            let first = values.first()?;
            return Some(Parameter::Shared(self.number(kind.shared(), *first)));
        }
        let entry = |(&incidence_deg, &v): (&f64, &Value)| {
            let Number {
                value,
                standard_error,
            } = self.number(kind.at(incidence_deg), v);
            AtAngle {
                incidence_deg,
                value,
                standard_error,
            }
        };
        let groups = &self.estimated.scene.groups;
        let per_angle = groups.iter().zip(values).map(entry).collect();
        Some(Parameter::PerAngle { per_angle })
    }

    /// The spread, where it is of this kind.
    fn spread(&self, kind: ParameterKind) -> Option<Parameter> {
        let best = &self.estimated.best;
        let kernel = best.choice.kernel;
        (kernel.has_lobe() && ParameterKind::spread_of(kernel) == kind)
            .then(|| self.parameter(kind, &best.spread, best.choice.per_angle_a))
            .flatten()
    }

    /// c, or the roughness of a baseline's front.
    fn size(&self) -> Option<Number> {
        let best = &self.estimated.best;
        let id = ParameterKind::size_of(best.choice.kernel).shared();
        best.c_mm.map(|size| self.number(id, size))
    }
}

fn candidate(row: &Ranked) -> Candidate {
    let kernel = row.choice.kernel;
    Candidate {
        kernel,
        lobe: kernel.has_lobe().then_some(row.choice.shape),
        sharing: sharing(kernel, row.choice.per_angle_a),
        criterion: row.criterion,
        loss: row.chi2,
        parameters: row.parameters,
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
pub(crate) fn sharing(kernel: Kernel, per_angle: bool) -> String {
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
    let finite = |&v: &f64| v.is_finite().then_some(v);
    let rows = best.covariance.row_iter();
    Covariance {
        names: best.parameters.clone(),
        matrix: rows.map(|row| row.iter().map(finite).collect()).collect(),
    }
}

fn captures(scene: &Scene, best: &Estimate) -> Vec<CaptureResult> {
    let shots = scene.shots.iter().zip(&best.modelled).zip(&best.losses);
    shots
        .map(|((shot, modelled), &loss)| capture(shot, modelled, loss))
        .collect()
}

fn capture(shot: &Aerial, modelled: &[f64], loss: f64) -> CaptureResult {
    let view = &shot.view;
    CaptureResult {
        image: shot.image.clone(),
        incidence_deg: shot.incidence_deg,
        floating_distance_mm: shot.r_mm,
        edge_angle_deg: view.line.normal_rad.to_degrees(),
        mtf50_per_mm: view.mtf50_per_mm(),
        loss,
        warnings: shot.warnings.clone(),
        curves: Curves {
            frequency_per_mm: view.estimator.frequencies_per_mm.clone(),
            measured: view.mtf.modulus.clone(),
            standard_error: view.mtf_standard_error.clone(),
            modelled: modelled.to_vec(),
        },
    }
}
