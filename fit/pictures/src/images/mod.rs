//! Mid-air images of whole pictures.
//!
//! A picture, a result and a table enter. A rendered picture leaves.

mod exposure;
mod plane;
pub mod render;
mod sheet;
mod spot;
mod watch;

pub use exposure::automatic;
pub use render::Scale;
#[cfg(test)]
pub(crate) use render::viewed;
#[cfg(test)]
pub(crate) use spot::{Sampler, Spot};
pub use spot::{Sheet, TAIL, Viewpoint};
pub use watch::{Part, UNWATCHED, Watch};
