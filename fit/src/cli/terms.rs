//! The options by which a verb leaves terms of the model open, or closes them.

use crate::estimate::Candidates;
use crate::names::LobeShape;
use crate::names::{Family, Kernel};

/// Which terms are open.
#[derive(Debug, clap::Args)]
pub(crate) struct Terms {
    /// Whose model of the sheet: the proposed one, or a baseline for comparison
    #[arg(long, value_enum, default_value_t = Family::Proposed)]
    pub model: Family,
    /// Blur terms of the proposed model: auto, eq1 (a independent of distance), angular (a = A/R),
    /// shift (no lobe), lobe (no shift), wave (wave optics: c alone, the wavelength given; in auto
    /// where one is named)
    #[arg(long, default_value = "auto", value_parser = kernels)]
    pub kernel: Kernels,
    /// Shape of the lobe: radial (the default), separable or auto; of a baseline beckmann, ggx or
    /// auto (the default)
    #[arg(long, value_parser = lobes)]
    pub lobe: Option<Lobes>,
    /// Parameters fitted for every incidence angle: a (a baseline's roughness), mu, or auto (what
    /// is named in neither list is decided)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub per_angle: Vec<PerAngle>,
    /// Parameters that all angles share: a, c, mu (c always is)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub shared: Vec<SharedName>,
}

/// The kernels that are open.
#[derive(Debug, Clone)]
pub(crate) struct Kernels(Vec<Kernel>);

/// The lobe shapes that are open.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Lobes {
    /// All that the model has.
    Auto,
    /// One.
    One(LobeShape),
}

/// What may be fitted per angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum PerAngle {
    /// The diffraction spread.
    A,
    /// The reflectance.
    Mu,
    /// Decide.
    Auto,
}

/// What may be shared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum SharedName {
    /// The diffraction spread.
    A,
    /// The corner size.
    C,
    /// The reflectance.
    Mu,
    /// Decide.
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
    Ok(Lobes::One(shape.ok_or(
        "use radial, separable or auto; with a baseline beckmann, ggx or auto",
    )?))
}

/// Ends the program with a usage error.
fn conflict(verb: &'static str, message: &str) -> ! {
    clap::Command::new(verb)
        .error(clap::error::ErrorKind::ArgumentConflict, message)
        .exit()
}

impl Terms {
    /// The candidates that are left. Ends the program with a usage error where a parameter is both
    /// shared and per angle, or terms of one model are named for another.
    pub(crate) fn candidates(&self, verb: &'static str) -> Candidates {
        let sharing = |per_angle: PerAngle, shared: SharedName| {
            let named = (
                self.per_angle.contains(&per_angle),
                self.shared.contains(&shared),
            );
            match named {
                (true, false) => Some(true),
                (false, true) => Some(false),
                (false, false) => None,
                (true, true) => conflict(
                    verb,
                    "a parameter is named both in --per-angle and in --shared; name it in one of \
                    them",
                ),
            }
        };
        let baseline = self.model != Family::Proposed;
        if baseline && self.kernel.0.len() == 1 {
            conflict(
                verb,
                "--kernel names terms of the proposed model; leave it out with another --model",
            );
        }
        let shapes = match self.lobe {
            None if baseline => self.model.shapes().to_vec(),
            None => vec![LobeShape::Radial],
            Some(Lobes::Auto) => self.model.shapes().to_vec(),
            Some(Lobes::One(shape)) if self.model.shapes().contains(&shape) => vec![shape],
            Some(Lobes::One(_)) if baseline => {
                conflict(verb, "the lobe of a baseline is beckmann or ggx")
            }
            Some(Lobes::One(_)) => conflict(
                verb,
                "the lobe of the proposed model is radial or separable",
            ),
        };
        Candidates {
            kernels: if baseline {
                self.model.kernels().to_vec()
            } else {
                self.kernel.0.clone()
            },
            shapes,
            // The roughness of a material is one number, unless it is asked for by angle.
            per_angle_a: sharing(PerAngle::A, SharedName::A).or(baseline.then_some(false)),
            per_angle_mu: sharing(PerAngle::Mu, SharedName::Mu),
        }
    }
}
