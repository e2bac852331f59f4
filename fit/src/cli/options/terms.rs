//! The options that name terms of the model or leave them open, and the kernels in words.

use crate::cli::failure::Failure;
use edges::names::LobeShape;
use edges::names::{Family, Kernel};
use estimator::estimate::Candidates;

/// Terms of the model that the user names or leaves open.
#[derive(Debug, clap::Args)]
pub(crate) struct Terms {
    /// Model of the sheet: the proposed one or a published baseline.
    #[arg(long, value_enum, default_value_t = Family::Proposed, help_heading = "Model")]
    pub model: Family,
    /// Kernel: the blur terms of the proposed model
    ///
    /// Possible values:
    /// - auto:    the simplest kernel that the photographs allow
    /// - eq1:     ray shift and the lobe of Eq. (1), the same at all distances
    /// - angular: ray shift and a lobe of a fixed angle, a = A/R
    /// - shift:   ray shift alone, no lobe
    /// - lobe:    the lobe of Eq. (1) alone, no ray shift
    /// - wave:    wave optics, from c and the wavelength alone
    ///
    /// wave needs a wavelength and an exact table. auto compares it too if both
    /// are given.
    #[arg(
        long,
        default_value = "auto",
        value_parser = kernels,
        help_heading = "Model",
        verbatim_doc_comment
    )]
    pub kernel: Kernels,
    #[arg(
        long,
        value_parser = lobes,
        help_heading = "Model",
        help = shape_of_the_lobe(),
        long_help = format!(
            "{}.\n\nauto compares {}. The lobe of a baseline is beckmann, ggx or \
            auto, and auto if you leave this option out.",
            shape_of_the_lobe(),
            LobeShape::COMPARED.map(LobeShape::name).join(" and "),
        )
    )]
    pub lobe: Option<Lobes>,
    /// Parameters with one value per incidence.
    ///
    /// What you name neither here nor in --shared is decided by a criterion (BIC).
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        help_heading = "Model"
    )]
    pub per_angle: Vec<PerAngle>,
    /// Parameters that all incidences share.
    ///
    /// c is always shared.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        help_heading = "Model"
    )]
    pub shared: Vec<SharedName>,
}

/// Kernels that are open.
#[derive(Debug, Clone)]
pub(crate) struct Kernels(Vec<Kernel>);

/// Lobe shapes that are open.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Lobes {
    /// All shapes that the model has.
    Auto,
    /// One shape.
    One(LobeShape),
}

/// Parameters that may be fitted per angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum PerAngle {
    /// Diffraction spread; of a baseline its roughness.
    A,
    /// Reflectance.
    Mu,
    /// Decided by the criterion.
    Auto,
}

/// Parameters that may be shared by all angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum SharedName {
    /// Diffraction spread; of a baseline its roughness.
    A,
    /// Corner size.
    C,
    /// Reflectance.
    Mu,
    /// Decided by the criterion.
    Auto,
}

fn kernels(text: &str) -> Result<Kernels, String> {
    if text == "auto" {
        return Ok(Kernels(Kernel::ALL.to_vec()));
    }
    let kernel = Kernel::from_name(text).ok_or("use auto, eq1, angular, shift, lobe or wave")?;
    Ok(Kernels(vec![kernel]))
}

fn lobes(text: &str) -> Result<Lobes, String> {
    if text == "auto" {
        return Ok(Lobes::Auto);
    }
    let mut all = LobeShape::ALL.into_iter().chain(LobeShape::MICROFACETS);
    let shape = all.find(|shape| shape.name() == text);
    let shape = shape.ok_or_else(|| {
        format!(
            "use {} or auto; with a baseline beckmann, ggx or auto",
            LobeShape::NAMES.join(", ")
        )
    })?;
    Ok(Lobes::One(shape))
}

/// Returns the first line of help on the lobe, which names all shapes.
fn shape_of_the_lobe() -> String {
    let names = LobeShape::NAMES.join(", ");
    format!(
        "Shape of the lobe: {names} or auto; radial if left out, and separable where \
        radial does not describe the photographs"
    )
}

impl Terms {
    /// Returns the candidates that these options leave.
    ///
    /// # Errors
    /// Returns [`Failure::Usage`] if a parameter is both shared and per angle, or if terms of one
    /// model are named for another.
    pub(crate) fn candidates(&self, verb: &'static str) -> Result<Candidates, Failure> {
        let conflict = |message: &'static str| Failure::conflict(verb, message);
        let sharing = |per_angle: PerAngle, shared: SharedName| {
            let named = (
                self.per_angle.contains(&per_angle),
                self.shared.contains(&shared),
            );
            match named {
                (true, false) => Ok(Some(true)),
                (false, true) => Ok(Some(false)),
                (false, false) => Ok(None),
                (true, true) => Err(conflict(
                    "a parameter is named both in --per-angle and in --shared; name it in one of \
                    them",
                )),
            }
        };
        let baseline = self.model != Family::Proposed;
        if baseline && self.kernel.0.len() == 1 {
            let message =
                "--kernel names terms of the proposed model; leave it out with another --model";
            return Err(conflict(message));
        }
        let shapes = match self.lobe {
            None if baseline => self.model.compared().to_vec(),
            None => vec![LobeShape::Radial],
            Some(Lobes::Auto) => self.model.compared().to_vec(),
            Some(Lobes::One(shape)) if self.model.shapes().contains(&shape) => vec![shape],
            Some(Lobes::One(_)) if baseline => {
                return Err(conflict("the lobe of a baseline is beckmann or ggx"));
            }
            Some(Lobes::One(_)) => {
                let [others @ .., last] = LobeShape::NAMES;
                let names = others.join(", ");
                let message = format!("the lobe of the proposed model is {names} or {last}");
                return Err(Failure::conflict(verb, message));
            }
        };
        let spare_shapes = match self.lobe {
            None if !baseline => vec![LobeShape::Separable],
            _ => Vec::new(),
        };
        Ok(Candidates {
            kernels: if baseline {
                self.model.kernels().to_vec()
            } else {
                self.kernel.0.clone()
            },
            shapes,
            spare_shapes,
            // The roughness of a material is one number, unless the user asks for one per angle.
            per_angle_a: sharing(PerAngle::A, SharedName::A)?.or(baseline.then_some(false)),
            per_angle_mu: sharing(PerAngle::Mu, SharedName::Mu)?,
        })
    }
}
