//! Mid-air images of whole pictures.
//!
//! A picture, a result and a table enter. A rendered picture leaves.

mod exposure;
mod plane;
mod progress;
pub mod render;
mod sheet;
mod spot;

pub use exposure::automatic;
pub use progress::{RenderProgress, RenderStep, SILENT};
pub use render::Scale;
#[cfg(test)]
pub(crate) use render::viewed;
#[cfg(test)]
pub(crate) use spot::{Sampler, Spot};
pub use spot::{Sheet, TAIL, Viewpoint};
