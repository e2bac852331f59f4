//! Words that files, options and crates share: kernels, shapes of lobes, parameters, and spectra of
//! light.
//!
//! Text enters. Checked names leave, and the facts that follow from a name alone (such as which
//! parameters a kernel has). The module holds no optics. The model and the simulator share this
//! module on purpose, and nothing else about light, so that each checks the other.

mod kernel;
mod lobe;
mod parameter;
mod spectrum;

pub use kernel::Family;
pub use kernel::Kernel;
pub use lobe::LobeShape;
pub use parameter::{ParameterId, ParameterKind};
pub use spectrum::SpectralLine;
pub use spectrum::Spectrum;
