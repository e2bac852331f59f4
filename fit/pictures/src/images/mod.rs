//! Mid-air images of whole pictures.
//!
//! A picture, a result and a table enter. A rendered picture leaves.

pub(crate) mod exposure;
mod file;
pub mod mid_air;
mod plane;
pub(crate) mod progress;
pub mod render;
pub(crate) mod sheet;
pub mod shown;
mod spot;

pub use file::Writing;
pub use progress::{RenderProgress, RenderStep, SILENT};
pub use render::Scale;
#[cfg(test)]
pub(crate) use render::viewed;
#[cfg(test)]
pub(crate) use spot::{Sampler, Spot};
pub use spot::{Sheet, TAIL, Viewpoint};
