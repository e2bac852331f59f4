//! Words that files, options and crates share: kernels, shapes of lobes, parameters, spectra and
//! polarisations of light.
//!
//! Text enters. Checked names leave, and the facts that follow from a name alone (such as which
//! parameters a kernel has). The module holds no optics. The model and the simulator share this
//! module on purpose, and nothing else about light, so that each checks the other.

mod kernel;
mod lobe;
mod parameter;
mod polarisation;
mod spectrum;
mod stray;

pub use kernel::Family;
pub use kernel::Kernel;
pub use lobe::LobeShape;
pub use parameter::{ParameterId, ParameterKind};
pub use polarisation::{ByAxis, Polarisation, Retarder, State};
pub use spectrum::SpectralLine;
pub use spectrum::Spectrum;
pub use stray::{Ghost, Haze, Stray};
