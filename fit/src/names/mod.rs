//! Words that files, options and rooms share: kernels, shapes of lobes, parameters, and spectra of
//! light.
//!
//! The room takes text and gives checked names, and the facts that follow from a name alone (such
//! as which parameters a kernel has). It holds no optics. The model and the simulator share this
//! room and nothing else, so that each can check the other. The room may use no other room.

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
