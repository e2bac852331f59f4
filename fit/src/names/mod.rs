//! Words that files, options and rooms share: kernels, shapes of lobes, parameters, and spectra of
//! light.
//!
//! Text enters; checked names leave, and the facts that follow from a name alone (which parameters
//! a kernel has). No optics stands here: the model and the simulator share this room on purpose,
//! and nothing else, so that each checks the other. The room may touch no other.

mod kernel;
mod lobe;
mod parameter;
mod spectrum;

pub(crate) use kernel::Family;
pub use kernel::Kernel;
pub use lobe::LobeShape;
pub use parameter::{ParameterId, ParameterKind};
pub use spectrum::Spectrum;
pub(crate) use spectrum::{SpectralLine, SpectrumError};
