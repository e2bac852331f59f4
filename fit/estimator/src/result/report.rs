//! RESULT.json: the estimate for scripts and for `fit predict`.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use tables::Table;

use crate::error::{Error, all_within};
use crate::estimate::Bounds;
use crate::estimate::Estimate;
use crate::estimate::Estimated;
use crate::estimate::Forward;
use crate::estimate::Kind;
use crate::estimate::Unverified;
use crate::estimate::Value;
use crate::model::{self, polarised};
use crate::result::capture::{CameraResult, CaptureResult, FROM_EXIF, captures, lenses};
use crate::result::diffraction::{WidthResult, widths};
use crate::result::domain::Domain;
use crate::result::parameter::{AtAngle, AtDistance, Covariance, Number, OwnBlur, Parameter};
use crate::result::quality::{Candidate, FitResult, candidate};
use crate::result::table::TableResult;
use crate::samples::Sampling;
use edges::document;
use edges::names::{Family, Kernel};
use edges::names::{LobeShape, Polarisation, Spectrum, Stray};
use edges::names::{ParameterId, ParameterKind};

/// Dihedral error, mrad, far beyond what is of first order.
const DIHEDRAL: document::Bounds = document::Bounds::new("from -100 to 100", |x| x.abs() <= 100.0);

/// Samples of a rendered model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SamplingResult {
    /// Count of samples per pixel, their sequence, and their seed.
    #[serde(flatten)]
    pub sampling: Sampling,
    /// Standard deviation of every parameter that the samples alone cause.
    ///
    /// The order is that of [`Covariance::names`]. The standard errors include it.
    pub standard_error: Vec<f64>,
}

/// Content of RESULT.json.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResultFile {
    /// Model of the sheet: the proposed one or a baseline; absent from older results.
    #[serde(default)]
    pub model: Family,
    /// Kernel: the terms of the blur.
    pub kernel: Kernel,
    /// Shape of the lobe; null without a lobe.
    pub lobe: Option<LobeShape>,
    /// Loss that was minimised.
    pub loss: Kind,
    /// Method by which the model was evaluated.
    #[serde(default)]
    pub forward: Forward,
    /// Samples of the model; null if it was evaluated in closed form.
    #[serde(default)]
    pub sampling: Option<SamplingResult>,
    /// Count of evaluations by the solver.
    pub iterations: usize,
    /// Reason why the solver stopped.
    pub stop: String,
    /// Wall time from the first file that was read to the estimate, seconds.
    pub seconds: f64,
    /// Wavelengths of the source, nm; null if none is named.
    #[serde(default)]
    pub wavelength_nm: Option<Spectrum>,
    /// What red, green and blue of the camera see of the source; absent if it is not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colours: Option<[Spectrum; 3]>,
    /// Corner size c, mm; null under `lobe` and baselines.
    pub c_mm: Option<Number>,
    /// Diffraction spread a, 1/mm; null under `angular`, `shift`, `wave` and baselines.
    pub a_per_mm: Option<Parameter>,
    /// Diffraction spread A = a R, without unit; null except under `angular`.
    pub a_times_r: Option<Parameter>,
    /// Roughness of a baseline's facets, without unit; null under the proposed model.
    #[serde(default)]
    pub roughness: Option<Parameter>,
    /// Roughness of a baseline's front face, without unit; null if it is no separate parameter.
    #[serde(default)]
    pub surface_roughness: Option<Number>,
    /// Blur of the mid-air photographs that the reference does not have, pixels: the standard
    /// deviation of a Gaussian, negative if the reference is less sharp.
    ///
    /// It is absent if the photographs do not ask for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_blur_px: Option<OwnBlur>,
    /// Standard deviation of the direction of the returned light across the plane of incidence,
    /// outside of the sheet, mrad.
    ///
    /// It is absent if the photographs do not ask for it; `bounds` then has a bound.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_spread_mrad: Option<Number>,
    /// Errors of the dihedral angles at the edges 1, 2 and 3 of all cubes, mrad.
    ///
    /// They are absent if the photographs do not ask for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dihedral_errors_mrad: Option<[Number; 3]>,
    /// Reflectance mu; null without a reference photograph.
    pub mu: Option<Parameter>,
    /// Angle that `--fit-azimuth` added to the captures' azimuths, degrees; absent without this
    /// option.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<Number>,
    /// Covariance of all parameters above.
    pub covariance: Covariance,
    /// Bounds of the parameters that the photographs cannot determine, at 95 %.
    pub bounds: Bounds,
    /// Models that were compared, with the best criterion first.
    pub candidates: Vec<Candidate>,
    /// Relation of the reference's values to light that was taken, such as `linear` or `sRGB`;
    /// absent without a reference photograph and from older results.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_transfer: Option<String>,
    /// Origin of this relation; absent together with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_transfer_from: Option<String>,
    /// Photographs in the order of the manifest.
    pub captures: Vec<CaptureResult>,
    /// Camera that was used.
    pub camera: CameraResult,
    /// Transmittance times reflectance of the half mirror.
    pub half_mirror: f64,
    /// Width of the lobe compared with the diffraction of the cubes, by incidence; empty without a
    /// lobe, c or wavelengths.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub diffraction: Vec<WidthResult>,
    /// Polarisers, film and half mirror of the setup; absent for unpolarised light that is collected
    /// whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polarisation: Option<Polarisation>,
    /// Ghost, haze and front of the sheet; absent without them.
    #[serde(default, skip_serializing_if = "Stray::is_none")]
    pub stray: Stray,
    /// True if the camera saw the sheet in the half mirror, as the fit took it; absent from older
    /// results, which were fitted as if it were true.
    #[serde(default)]
    pub seen_in_mirror: Option<bool>,
    /// Quality of the fit; absent from older results.
    #[serde(default)]
    pub fit: Option<FitResult>,
    /// Distances and directions of the photographs; absent from older results.
    #[serde(default)]
    pub domain: Option<Domain>,
    /// Inputs that no photograph can check, with the effects of small errors of them; empty in
    /// older results.
    #[serde(default)]
    pub trusted: Vec<Unverified>,
    /// Table that was used.
    pub table: TableResult,
    /// Warnings about the campaign as a whole.
    pub warnings: Vec<String>,
}

impl ResultFile {
    /// Converts an estimate, its table and the seconds that it took to the content of a result
    /// file.
    pub fn new(estimated: &Estimated, table: TableResult, seconds: f64) -> ResultFile {
        let Estimated { scene, best, .. } = estimated;
        let kernel = best.choice.kernel;
        let written = Written { estimated };
        let is_rough = kernel.is_baseline();
        let lens = best.camera.lenses.first();
        let reference = scene.reference.as_ref().map(|own| &own.transfer);
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
            colours: estimated.campaign.setup.colours(),
            c_mm: written.size().filter(|_| !is_rough),
            a_per_mm: written.spread(ParameterKind::APerMm),
            a_times_r: written.spread(ParameterKind::ATimesR),
            roughness: written.spread(ParameterKind::Roughness),
            surface_roughness: written.size().filter(|_| is_rough),
            own_blur_px: written.own_blur(),
            angular_spread_mrad: best
                .angular_spread_mrad
                .map(|own| written.number(ParameterKind::AngularSpread.shared(), own)),
            dihedral_errors_mrad: best.dihedral_errors_mrad.map(|errors| {
                let kinds = ParameterKind::DIHEDRAL_ERRORS;
                [0, 1, 2].map(|k| written.number(kinds[k].shared(), errors[k]))
            }),
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
            reference_transfer: reference.map(|taken| taken.name.clone()),
            reference_transfer_from: reference.map(|taken| taken.from.clone()),
            captures: captures(scene, best),
            camera: CameraResult {
                pixel_pitch_mm: scene.optics.camera.pitch_mm,
                lens_blur_mm: lens.map(|l| l.blur_mm),
                lens_exponent: lens.map(|l| l.exponent),
                lens_assumed: scene.optics.assumed,
                lens: lenses(&best.camera),
                farthest_from_reference_deg: scene.farthest_from_reference_deg(),
            },
            half_mirror: scene.half_mirror,
            diffraction: widths(scene, best),
            polarisation: estimated.campaign.setup.polarisation,
            stray: estimated.campaign.setup.stray,
            seen_in_mirror: Some(estimated.campaign.setup.is_in_mirror()),
            fit: Some(FitResult::new(
                &estimated.goodness,
                &estimated.suspects,
                estimated.diagnosis,
            )),
            domain: Some(Domain::of(scene, estimated.azimuth_period_deg)),
            trusted: estimated.trusted.clone(),
            table,
            warnings: estimated.warnings.clone(),
        }
    }
}

impl ResultFile {
    /// Checks that the numbers of which predictions are made are those of a sheet and a camera.
    ///
    /// # Errors
    /// Returns [`Error::Number`] of the first number that is out of range.
    pub fn check(&self) -> Result<(), Error> {
        let all = |parameter: &Option<Parameter>| -> Vec<f64> {
            match parameter {
                None => Vec::new(),
                Some(Parameter::Shared(number)) => number.value.into_iter().collect(),
                Some(Parameter::PerAngle { per_angle }) => {
                    per_angle.iter().filter_map(|number| number.value).collect()
                }
            }
        };
        let one = |number: Option<Number>| -> Vec<f64> {
            number.and_then(|number| number.value).into_iter().collect()
        };
        let checked = [
            ("a_per_mm", all(&self.a_per_mm), document::Bounds::POSITIVE),
            (
                "a_times_r",
                all(&self.a_times_r),
                document::Bounds::POSITIVE,
            ),
            (
                "roughness",
                all(&self.roughness),
                document::Bounds::NOT_NEGATIVE,
            ),
            ("mu", all(&self.mu), document::Bounds::NOT_NEGATIVE),
            ("c_mm", one(self.c_mm), document::Bounds::NOT_NEGATIVE),
            (
                "angular_spread_mrad",
                one(self.angular_spread_mrad),
                document::Bounds::NOT_NEGATIVE,
            ),
            (
                "dihedral_errors_mrad",
                self.dihedral_errors_mrad
                    .into_iter()
                    .flatten()
                    .flat_map(|own| one(Some(own)))
                    .collect(),
                DIHEDRAL,
            ),
            (
                "surface_roughness",
                one(self.surface_roughness),
                document::Bounds::NOT_NEGATIVE,
            ),
            (
                "half_mirror",
                vec![self.half_mirror],
                document::Bounds::SHARE,
            ),
        ];
        all_within(checked)?;
        self.camera.check()
    }

    /// Returns a table of the sheet as the light of the setup sees it. Predictions take this one.
    ///
    /// # Errors
    /// Returns [`tables::Error::Polarised`] if the light is polarised, and the table does not say
    /// how its cubes turn it, [`tables::Error::Cubeless`] if the cubes have errors, and the table does
    /// not say which cubes its paths belong to, and an error that names the keys of the setup if no
    /// light passes it.
    pub fn seen<'a>(&self, table: &'a Table) -> Result<Cow<'a, Table>, Error> {
        let in_mirror = self.seen_in_mirror.unwrap_or(true);
        let seen = polarised::seen(table, self.polarisation.as_ref(), in_mirror)?;
        let Some(errors) = self.dihedral_errors_mrad else {
            return Ok(seen);
        };
        let errors_rad = errors.map(|error| 1e-3 * error.value.unwrap_or(0.0));
        Ok(Cow::Owned(seen.into_owned().bent(errors_rad)?))
    }
}

/// Numbers of an estimate as the file has them.
struct Written<'a> {
    estimated: &'a Estimated,
}

impl Written<'_> {
    /// Returns a number as the file has it.
    ///
    /// The value is null if it is only bounded. The error is null if it is not finite.
    fn number(&self, id: ParameterId, value: Value) -> Number {
        let bounded = self.estimated.bounds.contains_key(&id);
        let error = value.standard_error;
        Number {
            value: (!bounded).then_some(value.value),
            standard_error: (!bounded && error.is_finite()).then_some(error),
        }
    }

    /// Returns a parameter that has one value, or one for every incidence.
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

    /// Returns the blur that the reference does not have.
    fn own_blur(&self) -> Option<OwnBlur> {
        let Estimate {
            choice,
            own_blur_px,
            ..
        } = &self.estimated.best;
        let kind = ParameterKind::OwnBlur;
        if choice.further.own_blur != model::OwnBlur::PerDistance {
            let first = own_blur_px.first()?;
            return Some(OwnBlur::Shared(self.number(kind.shared(), *first)));
        }
        let entry = |(&floating_distance_mm, &own): (&f64, &Value)| {
            let Number {
                value,
                standard_error,
            } = self.number(kind.at(floating_distance_mm), own);
            AtDistance {
                floating_distance_mm,
                value,
                standard_error,
            }
        };
        let distances = &self.estimated.scene.distances_mm;
        let per_distance = distances.iter().zip(own_blur_px).map(entry).collect();
        Some(OwnBlur::PerDistance { per_distance })
    }

    /// Returns the spread if it is of this kind.
    fn spread(&self, kind: ParameterKind) -> Option<Parameter> {
        let best = &self.estimated.best;
        let kernel = best.choice.kernel;
        (kernel.has_lobe() && ParameterKind::spread_of(kernel) == kind)
            .then(|| self.parameter(kind, &best.spread, best.choice.per_angle_a))
            .flatten()
    }

    /// Returns c, or the roughness of the front face of a baseline.
    fn size(&self) -> Option<Number> {
        let best = &self.estimated.best;
        let id = ParameterKind::size_of(best.choice.kernel).shared();
        best.c_mm.map(|size| self.number(id, size))
    }
}

impl ResultFile {
    /// Returns the dihedral error at each edge.
    pub fn dihedral_errors(&self) -> [Option<Parameter>; 3] {
        let errors = self.dihedral_errors_mrad;
        [0, 1, 2].map(|k| errors.map(|errors| Parameter::Shared(errors[k])))
    }

    /// Returns the number of photographs whose exposure comes from Exif data.
    pub fn exposures_from_exif(&self) -> usize {
        let captures = self.captures.iter();
        captures
            .filter(|own| own.exposure_from == FROM_EXIF)
            .count()
    }

    /// Returns the spread: a, a R or the roughness, whichever the kernel has.
    pub fn spread(&self) -> Option<&Parameter> {
        let a = self.a_per_mm.as_ref().or(self.a_times_r.as_ref());
        a.or(self.roughness.as_ref())
    }
}

/// Converts the covariance; entries that are not finite become null.
fn covariance(best: &Estimate) -> Covariance {
    let finite = |&v: &f64| v.is_finite().then_some(v);
    let rows = best.covariance.row_iter();
    Covariance {
        names: best.parameters.clone(),
        matrix: rows.map(|row| row.iter().map(finite).collect()).collect(),
    }
}
