//! What is asked of a plan: a TOML file with beliefs and choices.

use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize};

use crate::simulate::params::lobe;
use crate::simulate::{Error, PlantedCamera};
use edges::document::{Bounds, Document, Table, table};
use edges::document::{choice, choices, incidence, positive, share, spectrum, turn};
use edges::names::{Kernel, LobeShape, ParameterKind, Spectrum};
use edges::readers;
use estimator::estimate::Verdict;
use estimator::result::{Parameter, ResultFile};

/// Largest number of photographs that is planned.
pub(super) const MOST: usize = 200;

readers! {
    count = Bounds::new("between 1 and 200", |x| (1.0..=200.0).contains(&x));
}

/// A plan that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Number of photographs of the mid-air edge; `None` for as few as [`Plan::within`] needs. The
    /// source edge is photographed once more.
    pub photographs: Option<usize>,
    /// Relative standard errors that are wanted everywhere in the beliefs.
    pub within: Vec<(ParameterKind, f64)>,
    /// Parameters whose variances are minimised together; none if kernels are to be told apart and
    /// the plan names no parameter.
    pub minimise: Vec<ParameterKind>,
    /// Kernel that the believed one is to be told from.
    pub rival: Option<Kernel>,
    /// What is believed of the sheet.
    pub beliefs: Beliefs,
    /// What can be set up.
    pub choices: Choices,
    /// Camera, half mirror and source.
    pub camera: PlantedCamera,
}

/// What is believed of a sheet: a kernel, and the ends of the range of each number.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beliefs {
    /// Kernel.
    #[serde(deserialize_with = "kernel")]
    pub kernel: Kernel,
    /// Shape of the lobe.
    #[serde(default, deserialize_with = "lobe")]
    pub lobe: LobeShape,
    /// Corner size, mm.
    #[serde(default, deserialize_with = "positive")]
    pub c_mm: Option<[f64; 2]>,
    /// Diffraction spread a, 1/mm.
    #[serde(default, deserialize_with = "positive")]
    pub a_per_mm: Option<[f64; 2]>,
    /// Spread A = a R of the kernel `angular`.
    #[serde(default, deserialize_with = "positive")]
    pub a_times_r: Option<[f64; 2]>,
    /// Reflectance.
    #[serde(deserialize_with = "share")]
    pub mu: [f64; 2],
    /// Parameters with one value per incidence: both, if this is left out.
    #[serde(default = "all_own", deserialize_with = "own")]
    pub per_angle: Vec<Own>,
    /// Wavelengths of the source, for the kernel `wave`.
    #[serde(default, rename = "wavelength_nm", deserialize_with = "spectrum")]
    pub spectrum: Option<Spectrum>,
}

/// What can be set up. Every combination can be photographed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choices {
    /// Floating distances, mm.
    #[serde(deserialize_with = "positive")]
    pub floating_distance_mm: Vec<f64>,
    /// Incidences in the air, degrees.
    #[serde(deserialize_with = "incidence")]
    pub incidence_deg: Vec<f64>,
    /// Azimuths, degrees.
    #[serde(deserialize_with = "turn")]
    pub azimuth_deg: Vec<f64>,
    /// Edges.
    #[serde(default = "both", deserialize_with = "edges")]
    pub edge: Vec<Edge>,
    /// How often one combination may be photographed.
    #[serde(default = "once", deserialize_with = "count")]
    pub repeat: usize,
}

/// Parameter that may have one value per incidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Own {
    /// Diffraction spread.
    A,
    /// Reflectance.
    Mu,
}

impl Own {
    const NAMES: [&str; 2] = ["a", "mu"];

    fn from_name(name: &str) -> Option<Own> {
        match name {
            "a" => Some(Own::A),
            "mu" => Some(Own::Mu),
            _ => None,
        }
    }
}

/// Axis across which the edge of a photograph lies: that along which its blur is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Edge {
    /// Across the tangential axis.
    Tangential,
    /// Across the sagittal axis.
    Sagittal,
}

impl Edge {
    const NAMES: [&str; 2] = ["tangential", "sagittal"];

    /// Returns the name in files.
    pub const fn name(self) -> &'static str {
        Edge::NAMES[self as usize]
    }

    fn from_name(name: &str) -> Option<Edge> {
        let all = [Edge::Tangential, Edge::Sagittal];
        all.into_iter().find(|edge| edge.name() == name)
    }
}

impl Plan {
    /// Reads and checks a plan. If it has no beliefs, they are those of `given`, an earlier result of
    /// the sheet.
    ///
    /// # Errors
    /// Returns the first fault of the file with its line: an unknown or missing key, a number out of
    /// range, an empty list, a parameter to minimise that the kernel does not have, or beliefs that
    /// neither the file nor the result has.
    pub fn load(file: &Path, given: Option<&ResultFile>) -> Result<Plan, Error> {
        let document = Document::read(file)?;
        let asked: Asked = document.parse()?;
        let beliefs = match (asked.beliefs, given) {
            (Some(beliefs), _) => {
                let (part, Table(beliefs)) = (beliefs.span(), beliefs.into_inner());
                if let Some(key) = beliefs.lacks() {
                    return Err(document.missing(part, key, "[beliefs]").into());
                }
                beliefs
            }
            (None, Some(result)) => Beliefs::of(result).map_err(|key| {
                document.error(format!(
                    "[beliefs] is missing, and the given result has no {key}; add [beliefs]"
                ))
            })?,
            (None, None) => {
                let why = "[beliefs] is missing; add it, or give an earlier result (--given)";
                return Err(document.error(why).into());
            }
        };
        let (part, Table(choices)) = (asked.choices.span(), asked.choices.into_inner());
        let lengths = [
            ("floating_distance_mm", choices.floating_distance_mm.len()),
            ("incidence_deg", choices.incidence_deg.len()),
            ("azimuth_deg", choices.azimuth_deg.len()),
            ("edge", choices.edge.len()),
        ];
        if let Some((key, _)) = lengths.into_iter().find(|&(_, length)| length == 0) {
            let why = format!("`{key}` is empty; name at least one");
            return Err(document.place(part).error(why).into());
        }
        let possible = beliefs.parameters();
        let believed = beliefs.kernel;
        let rival = asked.tell_apart.map(|kernels| match kernels[..] {
            [a, b] if a == believed && b != believed => Ok(b),
            [a, b] if b == believed && a != believed => Ok(a),
            _ => Err(document.error(format!(
                "`tell_apart` is of two kernels, [\"eq1\", \"angular\"], and [beliefs] has to name \
                one of them; it names {}",
                believed.name()
            ))),
        });
        let rival = rival.transpose()?;
        let minimise = match asked.minimise {
            None if rival.is_some() => Vec::new(),
            asked => asked.unwrap_or_else(|| possible.clone()),
        };
        if let Some(absent) = minimise.iter().find(|kind| !possible.contains(kind)) {
            let names: Vec<&str> = possible.iter().map(|kind| kind.name()).collect();
            let why = format!(
                "`minimise` names {}, which the kernel {} does not have; choose of {}",
                absent.name(),
                beliefs.kernel.name(),
                names.join(", ")
            );
            return Err(document.error(why).into());
        }
        let within = asked
            .within
            .map_or_else(Vec::new, |Table(within)| within.all());
        if let Some((absent, _)) = within.iter().find(|(kind, _)| !possible.contains(kind)) {
            let (absent, kernel) = (absent.name(), beliefs.kernel.name());
            let why = format!("`within` names {absent}, which the kernel {kernel} does not have");
            return Err(document.error(why).into());
        }
        if asked.photographs.is_none() && within.is_empty() {
            let why = "`photographs` is missing; give their number, or the errors that are wanted: \
                       within = { c_mm = 0.01 }";
            return Err(document.error(why).into());
        }
        Ok(Plan {
            photographs: asked.photographs,
            within,
            minimise,
            rival,
            beliefs,
            choices,
            camera: asked.camera,
        })
    }
}

impl Plan {
    /// Takes from an earlier result of the sheet what it has found: the lobe, which parameters have
    /// one value per incidence, and whether the sheet is seen in a mirror. Returns warnings about a
    /// result that the plan cannot build on.
    pub fn follow(&mut self, result: &ResultFile) -> Vec<String> {
        let beliefs = &mut self.beliefs;
        beliefs.lobe = result.lobe.unwrap_or(beliefs.lobe);
        let own = |parameter: Option<&Parameter>, own| {
            matches!(parameter, Some(Parameter::PerAngle { .. })).then_some(own)
        };
        let per_angle = [
            own(result.spread(), Own::A),
            own(result.mu.as_ref(), Own::Mu),
        ];
        beliefs.per_angle = per_angle.into_iter().flatten().collect();
        self.camera.seen_in_mirror = result.seen_in_mirror.unwrap_or(self.camera.seen_in_mirror);
        let mut warnings = Vec::new();
        if result
            .fit
            .as_ref()
            .is_some_and(|fit| fit.verdict == Verdict::Poor)
        {
            warnings.push(
                "the given result is poor: its model does not describe its photographs, so a plan \
                that builds on it may mislead; mend it first"
                    .into(),
            );
        }
        let c_mm = result.c_mm.and_then(|c| c.value);
        if let (Some(c), Some([least, most])) = (c_mm, self.beliefs.c_mm)
            && !(least..=most).contains(&c)
        {
            warnings.push(format!(
                "the given result has c = {c:.4} mm, which the beliefs {least} to {most} mm leave \
                out: widen them, or give another result"
            ));
        }
        warnings
    }
}

/// Standard errors on either side of a value that is believed: 95 %.
const BELIEVED: f64 = 2.0;

impl Beliefs {
    /// Takes the numbers of a result as beliefs, from two standard errors below to two above. A
    /// number with one value per incidence is believed between the ends of all.
    ///
    /// # Errors
    /// Returns the name of a number that the result lacks.
    fn of(result: &ResultFile) -> Result<Beliefs, &'static str> {
        let around = |value: Option<f64>, error: Option<f64>| {
            let value = value.filter(|value| *value > 0.0)?;
            // A factor keeps the range above 0.
            let factor = (BELIEVED * error.unwrap_or(0.0) / value).exp();
            Some([value / factor, value * factor])
        };
        let range = |own: Option<&Parameter>| match own? {
            Parameter::Shared(own) => around(own.value, own.standard_error),
            Parameter::PerAngle { per_angle } => per_angle
                .iter()
                .filter_map(|own| around(own.value, own.standard_error))
                .reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]),
        };
        let beliefs = Beliefs {
            kernel: result.kernel,
            lobe: result.lobe.unwrap_or_default(),
            c_mm: result.c_mm.and_then(|c| around(c.value, c.standard_error)),
            a_per_mm: range(result.a_per_mm.as_ref()),
            a_times_r: range(result.a_times_r.as_ref()),
            mu: range(result.mu.as_ref()).ok_or(ParameterKind::Mu.name())?,
            per_angle: Vec::new(),
            spectrum: result.wavelength_nm.clone(),
        };
        beliefs.lacks().map_or(Ok(beliefs), Err)
    }

    /// Returns the name of a number that the kernel needs and that is missing.
    fn lacks(&self) -> Option<&'static str> {
        let kernel = self.kernel;
        let needed = [
            (kernel.has_c() && self.c_mm.is_none(), "c_mm"),
            (
                self.spread().is_none(),
                ParameterKind::spread_of(kernel).name(),
            ),
            (
                kernel.has_waves() && self.spectrum.is_none(),
                "wavelength_nm",
            ),
        ];
        let missing = needed.into_iter().find(|&(is_missing, _)| is_missing);
        missing.map(|(_, key)| key)
    }

    /// Returns the kinds of parameters of the kernel, in the order of an estimate.
    pub(crate) fn parameters(&self) -> Vec<ParameterKind> {
        let c = self.kernel.has_c().then_some(ParameterKind::CornerSize);
        let spread = self.kernel.has_lobe();
        let spread = spread.then(|| ParameterKind::spread_of(self.kernel));
        let all = c.into_iter().chain(spread);
        all.chain(std::iter::once(ParameterKind::Mu)).collect()
    }

    /// Returns the range of the spread, or one of no meaning if the kernel has no lobe.
    fn spread(&self) -> Option<[f64; 2]> {
        if !self.kernel.has_lobe() {
            return Some([1.0; 2]);
        }
        match ParameterKind::spread_of(self.kernel) {
            ParameterKind::ATimesR => self.a_times_r,
            _ => self.a_per_mm,
        }
    }

    /// Returns the logarithms of c and of the spread, as far as the kernel has them: in the middle
    /// of the beliefs, then at their ends in all combinations.
    pub(crate) fn points(&self) -> Vec<Vec<f64>> {
        let c = self.c_mm.filter(|_| self.kernel.has_c());
        let spread = self.spread().filter(|_| self.kernel.has_lobe());
        let ranges: Vec<[f64; 2]> = c.into_iter().chain(spread).collect();
        let middle = |range: &[f64; 2]| 0.5 * (range[0].ln() + range[1].ln());
        let mut points = vec![ranges.iter().map(middle).collect()];
        for corner in 0..1 << ranges.len() {
            let ends = ranges.iter().enumerate();
            let point: Vec<f64> = ends
                .map(|(i, range)| range[(corner >> i) & 1].ln())
                .collect();
            if !points.contains(&point) {
                points.push(point);
            }
        }
        points
    }
}

/// A plan as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    #[serde(default, deserialize_with = "count")]
    photographs: Option<usize>,
    #[serde(default)]
    within: Option<Table<Within>>,
    #[serde(default, deserialize_with = "parameters")]
    minimise: Option<Vec<ParameterKind>>,
    #[serde(default, deserialize_with = "told_apart")]
    tell_apart: Option<Vec<Kernel>>,
    #[serde(default)]
    beliefs: Option<toml::Spanned<Table<Beliefs>>>,
    choices: toml::Spanned<Table<Choices>>,
    #[serde(default, deserialize_with = "table")]
    camera: PlantedCamera,
}

/// Relative standard errors that are wanted, as they are written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Within {
    #[serde(default, deserialize_with = "share")]
    c_mm: Option<f64>,
    #[serde(default, deserialize_with = "share")]
    a_per_mm: Option<f64>,
    #[serde(default, deserialize_with = "share")]
    a_times_r: Option<f64>,
    #[serde(default, deserialize_with = "share")]
    mu: Option<f64>,
}

impl Within {
    fn all(&self) -> Vec<(ParameterKind, f64)> {
        let errors = [self.c_mm, self.a_per_mm, self.a_times_r, self.mu];
        let all = PLANNED.into_iter().zip(errors);
        all.filter_map(|(kind, error)| Some((kind, error?)))
            .collect()
    }
}

fn once() -> usize {
    1
}

fn all_own() -> Vec<Own> {
    vec![Own::A, Own::Mu]
}

/// Reads names, of which there may be none.
fn own<'de, D: Deserializer<'de>>(value: D) -> Result<Vec<Own>, D::Error> {
    let words = Vec::<toml::Value>::deserialize(value)?;
    let read = words
        .into_iter()
        .map(|word| choice(word, &Own::NAMES, Own::from_name).map_err(serde::de::Error::custom));
    read.collect()
}

fn both() -> Vec<Edge> {
    vec![Edge::Tangential, Edge::Sagittal]
}

fn edges<'de, D: Deserializer<'de>>(value: D) -> Result<Vec<Edge>, D::Error> {
    choices(value, &Edge::NAMES, Edge::from_name)
}

fn kernel<'de, D: Deserializer<'de>>(value: D) -> Result<Kernel, D::Error> {
    choice(value, &Kernel::NAMES, Kernel::from_name)
}

/// Kernels that can be told apart before photographs are taken: those with c and one spread.
const APART: [Kernel; 2] = [Kernel::Eq1, Kernel::Angular];

fn told_apart<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Vec<Kernel>>, D::Error> {
    let one = |name: &str| APART.into_iter().find(|own| own.name() == name);
    choices(value, &APART.map(Kernel::name), one).map(Some)
}

fn parameters<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Vec<ParameterKind>>, D::Error> {
    let names = PLANNED.map(ParameterKind::name);
    choices(value, &names, planned).map(Some)
}

/// Parameters that a plan may minimise.
const PLANNED: [ParameterKind; 4] = [
    ParameterKind::CornerSize,
    ParameterKind::APerMm,
    ParameterKind::ATimesR,
    ParameterKind::Mu,
];

fn planned(name: &str) -> Option<ParameterKind> {
    PLANNED.into_iter().find(|kind| kind.name() == name)
}
