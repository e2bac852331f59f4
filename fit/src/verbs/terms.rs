//! The options by which a verb leaves terms of the model open, or closes them.

use std::path::Path;

use crate::cli::Failure;
use crate::kernel::Kernel;
use crate::lobe::Shape;
use crate::scene::Scene;
use crate::select::Candidates;
use crate::wave;

/// Which terms are open.
#[derive(Debug, clap::Args)]
pub struct Terms {
    /// Blur terms: auto, eq1 (a independent of distance), angular (a = A/R), shift (no lobe), lobe (no shift), wave (wave
    /// optics: c alone, the wavelength given; in auto where one is named)
    #[arg(long, default_value = "auto", value_parser = kernels)]
    pub kernel: Kernels,
    /// Shape of the lobe: radial, separable or auto
    #[arg(long, default_value = "radial", value_parser = shapes)]
    pub lobe: Shapes,
    /// Parameters fitted for every incidence angle: a, mu, or auto (what is named in neither list is decided)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub per_angle: Vec<PerAngle>,
    /// Parameters that all angles share: a, c, mu (c always is)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub shared: Vec<SharedName>,
}

/// The kernels that are open.
#[derive(Debug, Clone)]
pub struct Kernels(Vec<Kernel>);

/// The lobe shapes that are open.
#[derive(Debug, Clone)]
pub struct Shapes(Vec<Shape>);

/// What may be fitted per angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PerAngle {
    /// The diffraction spread.
    A,
    /// The reflectance.
    Mu,
    /// Decide.
    Auto,
}

/// What may be shared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum SharedName {
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

fn shapes(text: &str) -> Result<Shapes, String> {
    if text == "auto" {
        return Ok(Shapes(Shape::ALL.to_vec()));
    }
    let shape = Shape::from_name(text).ok_or("use radial, separable or auto")?;
    Ok(Shapes(vec![shape]))
}

impl Terms {
    /// The candidates that are left. Ends the program with a usage error where a parameter is both shared and per angle.
    pub fn candidates(&self, verb: &'static str) -> Candidates {
        let sharing = |per_angle: PerAngle, shared: SharedName| {
            match (self.per_angle.contains(&per_angle), self.shared.contains(&shared)) {
                (true, false) => Some(true),
                (false, true) => Some(false),
                (false, false) => None,
                (true, true) => clap::Command::new(verb)
                    .error(
                        clap::error::ErrorKind::ArgumentConflict,
                        "a parameter is named both in --per-angle and in --shared; name it in one of them",
                    )
                    .exit(),
            }
        };
        Candidates {
            kernels: self.kernel.0.clone(),
            shapes: self.lobe.0.clone(),
            per_angle_a: sharing(PerAngle::A, SharedName::A),
            per_angle_mu: sharing(PerAngle::Mu, SharedName::Mu),
        }
    }
}

/// The candidates that the photographs and the table allow: `wave` needs wavelengths and polygons. What is left out is said
/// in the scene's warnings, unless nobody asked for it.
///
/// # Errors
/// [`Failure::Wave`] where `wave` alone was asked for.
pub fn possible(
    candidates: &Candidates,
    scene: &mut Scene,
    manifest: &Path,
) -> Result<Candidates, Failure> {
    let mut candidates = candidates.clone();
    if candidates.kernels.contains(&Kernel::Wave)
        && let Err(fault) = scene.waves()
    {
        if candidates.kernels == [Kernel::Wave] {
            return Err(Failure::Wave {
                manifest: manifest.to_owned(),
                fault,
            });
        }
        candidates.kernels.retain(|&kernel| kernel != Kernel::Wave);
        if fault != wave::Fault::NoWavelength {
            scene.warnings.push(format!(
                "the wave kernel is not among the candidates: {fault}"
            ));
        }
    }
    Ok(candidates)
}
