//! Words that files, options and rooms share: kernels, shapes of lobes, parameters, and spectra of
//! light.
//!
//! Text enters. Checked names leave, and the facts that follow from a name alone (such as which
//! parameters a kernel has). The room holds no optics. The model and the simulator share this room
//! on purpose, and no other room about light, so that each checks the other. It may touch no other
//! room.

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
